/* SPDX-License-Identifier: Apache-2.0 */
#include "picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/mem.h"

struct picture picture_new(const struct window *w)
{
    struct picture p = {.width = w->width, .height = w->height};
    p.n_pixels = (size_t)w->width * w->height;
    p.color = mem_new(p.n_pixels, 3 * sizeof(float));
    p.half_a = mem_new(p.n_pixels, 3 * sizeof(float));
    p.half_b = mem_new(p.n_pixels, 3 * sizeof(float));
    p.buffers = mem_new(p.n_pixels, BUFFER_CHANNELS * sizeof(float));
    if (!p.color || !p.half_a || !p.half_b || !p.buffers) abort();
    return p;
}

void picture_release(struct picture *p)
{
    mem_free(p->color);
    mem_free(p->half_a);
    mem_free(p->half_b);
    mem_free(p->buffers);
}

struct trace_output picture_output(const struct picture *p)
{
    return (struct trace_output){
        .color = p->color, .half_a = p->half_a, .half_b = p->half_b, .buffers = p->buffers};
}

struct picture picture_trace(trace_fn *fn, const struct view *v, const struct trace_settings *t,
                             const struct window *w)
{
    struct picture p = picture_new(w);
    struct trace_output out = picture_output(&p);
    fn(v, t, w, &out);
    return p;
}

struct window picture_whole(uint32_t width, uint32_t height)
{
    return (struct window){width, height, 0, 0, width, height};
}

bool picture_is_crop(const struct picture *a, const struct picture *b, uint32_t x, uint32_t y)
{
    const float *const of_a[] = {a->color, a->half_a, a->half_b, a->buffers};
    const float *const of_b[] = {b->color, b->half_a, b->half_b, b->buffers};
    const size_t n_channels[] = {3, 3, 3, BUFFER_CHANNELS};
    for (int k = 0; k < 4; k++) {
        for (uint32_t row = 0; row < a->height; row++) {
            const float *p = of_a[k] + (size_t)row * a->width * n_channels[k];
            const float *q = of_b[k] + ((size_t)(y + row) * b->width + x) * n_channels[k];
            if (memcmp(p, q, a->width * n_channels[k] * sizeof(float)) != 0) return false;
        }
    }
    return true;
}

double picture_different(const float *a, const float *b, size_t n_pixels, int n_channels,
                         double relative)
{
    size_t n = 0;
    for (size_t i = 0; i < n_pixels; i++) {
        for (int c = 0; c < n_channels; c++) {
            size_t at = i * (size_t)n_channels + (size_t)c;
            double x = a[at], y = b[at];
            if (fabs(x - y) <= relative * fmax(fabs(y), 1e-3)) continue;
            n++;
            break;
        }
    }
    return (double)n / (double)n_pixels;
}

double picture_mean(const float *a, size_t n)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++) sum += a[i];
    return sum / (double)n;
}
