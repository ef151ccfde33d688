/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_RENDER_PICTURE_H
#define TESTS_RENDER_PICTURE_H

#include "render/view.h"

/* All that tracing a window gives, for comparing. */
struct picture {
    float *color, *half_a, *half_b; /* [height][width][3] */
    float *buffers;                 /* [height][width][BUFFER_CHANNELS] */
    uint32_t width, height;
    size_t n_pixels;
};

typedef void trace_fn(const struct view *v, const struct trace_settings *t, const struct window *w,
                      struct trace_output *out);

struct picture picture_new(const struct window *w);
void picture_release(struct picture *p);
struct trace_output picture_output(const struct picture *p);

/* Both at once, with view_trace() or view_trace_plain(). */
struct picture picture_trace(trace_fn *fn, const struct view *v, const struct trace_settings *t,
                             const struct window *w);
struct window picture_whole(uint32_t width, uint32_t height);

/* The same bytes, of a and of its equal in b from pixel (x, y) on? */
bool picture_is_crop(const struct picture *a, const struct picture *b, uint32_t x, uint32_t y);

/* The part of pixels that differ in some channel by more than `relative` (of 1e-3 at least). */
double picture_different(const float *a, const float *b, size_t n_pixels, int n_channels,
                         double relative);

double picture_mean(const float *a, size_t n);

#endif
