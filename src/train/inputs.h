/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_INPUTS_H
#define TRAIN_INPUTS_H

#include <stddef.h>

#include "nn/generator.h"
#include "render/view.h"

/*
 * From what the renderer gives to what the network takes (method of the paper, Sec. 6.1; encoding
 * as its authors': position by the scene's box to [0,1], normal n/2 + 1/2, the rest as it is).
 */

/* buffers [n_pixels][BUFFER_CHANNELS] -> inputs [n_pixels][GENERATOR_INPUTS]. What is not finite
 * becomes 0, emission below 0 too. */
void inputs_from_buffers(const struct scene *s, const float *buffers, size_t n_pixels,
                         float *inputs);

/* color [n_pixels][3], radiance -> targets [n_pixels][3] = log1p(radiance); NaN and negative
 * radiance become 0. */
void inputs_targets(const float *color, size_t n_pixels, float *targets);

/* The network's v [n_variables] of a configuration u [n_variables]: u itself, but a discrete
 * variable's choice k of n as k / (n - 1). */
void inputs_variables(const struct scene *s, const float *u, float *v);

/* The same of one variable. */
float inputs_variable(const struct scene *s, uint32_t variable, float u);

/* The virtual picture whose longer side is `resolution` pixels, with the proportions that the scene
 * declares; no side below `least`. */
void inputs_picture_size(const struct scene *s, uint32_t resolution, uint32_t least,
                         uint32_t *width, uint32_t *height);

#endif
