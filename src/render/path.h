/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_PATH_H
#define RENDER_PATH_H

#include "render/bsdf.h"
#include "render/sampler.h"
#include "render/surface.h"
#include "render/view.h"

/*
 * A light path in steps: unidirectional, with a light sampled at every surface and multiple
 * importance sampling between that and the bsdf (Veach & Guibas 1995). Depth, Russian roulette and
 * hidden emitters are counted as Mitsuba's `path` does. Steps cast no rays, so that one loop can
 * take many paths through them (stream.c), or one after another (path_radiance()):
 *
 *   path_start(p, ray), then from depth 0 on: cast p->ray; path_arrive(p, depth) or end;
 *   path_connect(p): when true, cast p->shadow and add p->light when nothing is in its way;
 *   path_scatter(p, depth) or end
 */
struct path {
    struct ray ray;
    struct hit hit; /* of `ray` */
    struct vec3 throughput, radiance;
    struct vec3 last_p; /* where the path last scattered, the density, and whether no light */
    float last_pdf;     /* sample could have found the direction */
    bool last_is_delta;
    float eta; /* product of relative indices: undoes the scaling of radiance in roulette */
    struct sampler sampler;
    struct surface surface;
    struct bsdf_point bsdf;
    struct ray shadow;
    struct vec3 light; /* what arrives along it if it is free, throughput included */
};

/* The sampler is p->sampler, set before. */
void path_start(struct path *p, const struct ray *primary);

/* Adds what shines at the end of the ray; false when the path ends there. */
bool path_arrive(struct path *p, const struct view *v, const struct trace_settings *t,
                 int32_t depth);

/* Chooses a light and sets p->shadow and p->light; false when there is nothing to gain. */
bool path_connect(struct path *p, const struct view *v, const struct trace_settings *t,
                  int32_t depth);

/* Chooses how the path goes on and sets p->ray; false when it ends. */
bool path_scatter(struct path *p, const struct trace_settings *t, int32_t depth);

/* Radiance along the primary ray that path_start() was given, whose hit is in p->hit. The plain
 * loop over the steps, one ray at a time: the reference for stream.c. */
struct vec3 path_radiance(struct path *p, const struct view *v, const struct trace_settings *t);

/* Adds the first hit's BUFFER_* channels to buffers [BUFFER_CHANNELS], ids excepted. `offset`: how
 * far from the pinhole the ray starts. */
void path_add_buffers(const struct view *v, const struct trace_settings *t,
                      const struct ray *primary, float offset, const struct hit *first,
                      float *buffers);

#endif
