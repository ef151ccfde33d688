/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_PATH_H
#define RENDER_PATH_H

#include "render/sampler.h"
#include "render/surface.h"
#include "render/view.h"

/*
 * One light path after another, the plain way: unidirectional, with a light sampled at every
 * surface and multiple importance sampling between that and the bsdf (Veach & Guibas 1995). Depth,
 * Russian roulette and hidden emitters are counted as Mitsuba's `path` does.
 */

/* Radiance along a primary ray; `first` is what it hit (hit.shape SCENE_NONE: nothing). */
struct vec3 path_radiance(const struct view *v, const struct trace_settings *t,
                          const struct ray *primary, const struct hit *first,
                          struct sampler *sampler);

/* Adds the first hit's BUFFER_* channels to buffers [BUFFER_CHANNELS], ids excepted. `offset`: how
 * far from the pinhole the ray starts. */
void path_add_buffers(const struct view *v, const struct trace_settings *t,
                      const struct ray *primary, float offset, const struct hit *first,
                      float *buffers);

#endif
