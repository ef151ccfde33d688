/* SPDX-License-Identifier: Apache-2.0 */
#include "math/distribution.h"

#include <math.h>
#include <stddef.h>

#include "base/mem.h"
#include "math/vec.h"

/* The largest float below 1: keeps the handed-back random number in [0,1). */
static const float below_one = 0x1.fffffep-1f;

/* Fills cdf [n + 1] from weights; returns their sum. */
static double cumulate(const float *weights, uint32_t n, float *cdf)
{
    double total = 0.0, sum = 0.0;
    for (uint32_t i = 0; i < n; i++) total += (double)weights[i];
    bool is_flat = !(total > 0.0) || !isfinite(total);
    cdf[0] = 0.0f;
    for (uint32_t i = 0; i < n; i++) {
        sum += is_flat ? 1.0 : (double)weights[i];
        cdf[i + 1] = (float)(sum / (is_flat ? (double)n : total));
    }
    /* Rounding may leave the sum off 1; trailing items of weight 0 keep probability 0. */
    float last = cdf[n];
    for (uint32_t i = n + 1; i-- > 0 && cdf[i] == last;) cdf[i] = 1.0f;
    return is_flat ? 0.0 : total;
}

/* The i with cdf[i] <= u < cdf[i + 1]. */
static uint32_t invert(const float *cdf, uint32_t n, float *u)
{
    float x = min_float(max_float(*u, 0.0f), below_one);
    uint32_t low = 0, size = n;
    while (size > 1) {
        uint32_t half = size / 2;
        low += cdf[low + half] <= x ? half : 0; /* no branch: it would be a coin toss */
        size -= half;
    }
    *u = min_float((x - cdf[low]) / (cdf[low + 1] - cdf[low]), below_one);
    return low;
}

bool distribution_init(struct distribution *d, const float *weights, uint32_t n)
{
    *d = (struct distribution){.n = n};
    d->cdf = mem_new((size_t)n + 1, sizeof *d->cdf);
    if (!d->cdf) return false;
    d->total = cumulate(weights, n, d->cdf);
    return true;
}

void distribution_release(struct distribution *d)
{
    mem_free(d->cdf);
    *d = (struct distribution){0};
}

uint32_t distribution_sample(const struct distribution *d, float *u)
{
    return invert(d->cdf, d->n, u);
}

bool distribution2d_alloc(struct distribution2d *d, uint32_t width, uint32_t height)
{
    *d = (struct distribution2d){.width = width, .height = height};
    d->rows = mem_new((size_t)height + 1, sizeof *d->rows);
    d->cells = mem_new((size_t)height * ((size_t)width + 1), sizeof *d->cells);
    if (d->rows && d->cells) return true;
    distribution2d_release(d);
    return false;
}

void distribution2d_set(struct distribution2d *d, const float *weights)
{
    uint32_t width = d->width, height = d->height;
    float *sums = d->rows + 1; /* where cumulate() reads each before it overwrites it */
    for (uint32_t y = 0; y < height; y++)
        sums[y] = (float)cumulate(weights + (size_t)y * width, width,
                                  d->cells + (size_t)y * (width + 1));
    cumulate(sums, height, d->rows);
}

bool distribution2d_init(struct distribution2d *d, const float *weights, uint32_t width,
                         uint32_t height)
{
    if (!distribution2d_alloc(d, width, height)) return false;
    distribution2d_set(d, weights);
    return true;
}

void distribution2d_release(struct distribution2d *d)
{
    mem_free(d->rows);
    mem_free(d->cells);
    *d = (struct distribution2d){0};
}

void distribution2d_choose(const struct distribution2d *d, float *u, float *v, uint32_t *column,
                           uint32_t *row, float *pdf)
{
    *row = invert(d->rows, d->height, v);
    const float *rows = d->rows + *row, *cdf = d->cells + (size_t)*row * (d->width + 1);
    *column = invert(cdf, d->width, u);
    *pdf = (rows[1] - rows[0]) * (float)d->height * (cdf[*column + 1] - cdf[*column]) *
           (float)d->width;
}

void distribution2d_sample(const struct distribution2d *d, float u, float v, float *x, float *y,
                           float *pdf)
{
    uint32_t column, row;
    distribution2d_choose(d, &u, &v, &column, &row, pdf);
    *x = min_float(((float)column + u) / (float)d->width, below_one);
    *y = min_float(((float)row + v) / (float)d->height, below_one);
}

float distribution2d_pdf(const struct distribution2d *d, float x, float y)
{
    if (!(x >= 0.0f && x <= 1.0f && y >= 0.0f && y <= 1.0f)) return 0.0f;
    uint32_t column = (uint32_t)(x * (float)d->width), row = (uint32_t)(y * (float)d->height);
    if (column >= d->width) column = d->width - 1;
    if (row >= d->height) row = d->height - 1;
    const float *cdf = d->cells + (size_t)row * (d->width + 1);
    return (d->rows[row + 1] - d->rows[row]) * (float)d->height * (cdf[column + 1] - cdf[column]) *
           (float)d->width;
}
