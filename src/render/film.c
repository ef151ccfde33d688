/* SPDX-License-Identifier: Apache-2.0 */
#include "render/film.h"

#include <string.h>

uint32_t film_margin(const struct filter *f)
{
    float beyond = f->radius - 0.5f;
    if (f->kind == FILTER_BOX || !(beyond > 0.0f) || beyond > (float)FILM_MARGIN) return 0;
    return (uint32_t)ceilf(beyond);
}

void film_tile_start(struct film_tile *t, uint32_t margin, uint32_t x, uint32_t y)
{
    const uint32_t side = FILM_TILE + 2 * margin;
    t->x = (int32_t)(x - margin);
    t->y = (int32_t)(y - margin);
    memset(t->sums, 0, side * side * sizeof *t->sums);
}

/* At `shift` minus the distance d from the centre. */
static void weigh(float *restrict w, const struct filter *f, float shift, uint32_t n,
                  const float *restrict d)
{
    if (f->kind == FILTER_TENT) {
        float slope = 1.0f / f->radius, scale = slope;
#pragma omp simd
        for (uint32_t i = 0; i < n; i++)
            w[i] = max_float(1.0f - fabsf(shift - d[i]) * slope, 0.0f) * scale;
    } else {
        for (uint32_t i = 0; i < n; i++) w[i] = filter_weight(f, shift - d[i]);
    }
}

void film_weigh(struct film_weights *w, const struct filter *f, uint32_t margin, uint32_t n,
                const float *dx, const float *dy)
{
    for (uint32_t k = 0; k <= 2 * margin; k++) {
        float shift = (float)k - (float)margin;
        weigh(w->across[k], f, shift, n, dx);
        weigh(w->down[k], f, shift, n, dy);
    }
}

void film_tile_add(struct film_tile *t, uint32_t margin, const struct film_weights *w, uint32_t k,
                   uint32_t column, uint32_t row, uint32_t half, struct vec3 radiance)
{
    const uint32_t n = 2 * margin + 1, side = FILM_TILE + 2 * margin;
    uint32_t x = (uint32_t)((int32_t)column - t->x) - margin;
    uint32_t y = (uint32_t)((int32_t)row - t->y) - margin;
    struct film_sum *sums = t->sums + y * side + x;
    const float rgbw[4] = {radiance.x, radiance.y, radiance.z, 1.0f};
    for (uint32_t j = 0; j < n; j++) {
        for (uint32_t i = 0; i < n; i++) {
            float weight = w->across[i][k] * w->down[j][k], *to = sums[j * side + i].rgbw[half];
#pragma omp simd
            for (uint32_t c = 0; c < 4; c++) to[c] += rgbw[c] * weight;
        }
    }
}

static int32_t max_i32(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

static int32_t min_i32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

void film_add(struct film_sum *sums, const struct window *w, const struct film_tile *t,
              uint32_t margin)
{
    const int32_t side = FILM_TILE + 2 * (int32_t)margin, wx = (int32_t)w->x, wy = (int32_t)w->y;
    int32_t x0 = max_i32(t->x, wx), x1 = min_i32(t->x + side, wx + (int32_t)w->width);
    int32_t y0 = max_i32(t->y, wy), y1 = min_i32(t->y + side, wy + (int32_t)w->height);
    for (int32_t y = y0; y < y1; y++) {
        for (int32_t x = x0; x < x1; x++) {
            float *to = sums[(size_t)(y - wy) * w->width + (size_t)(x - wx)].rgbw[0];
            const float *from = t->sums[(y - t->y) * side + x - t->x].rgbw[0];
            for (int c = 0; c < 8; c++) to[c] += from[c];
        }
    }
}

static void store(float *to, size_t pixel, const float *rgb, float weight)
{
    if (!to) return;
    for (int c = 0; c < 3; c++) to[3 * pixel + (size_t)c] = weight > 0.0f ? rgb[c] / weight : 0.0f;
}

void film_store(const struct film_sum *sums, const struct window *part, const struct window *w,
                struct trace_output *out)
{
    for (uint32_t y = 0; y < part->height; y++) {
        for (uint32_t x = 0; x < part->width; x++) {
            const float *a = sums[(size_t)y * part->width + x].rgbw[0], *b = a + 4;
            const float both[3] = {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
            size_t pixel = (size_t)(part->y - w->y + y) * w->width + (part->x - w->x + x);
            store(out->color, pixel, both, a[3] + b[3]);
            store(out->half_a, pixel, a, a[3]);
            store(out->half_b, pixel, b, b[3]);
        }
    }
}
