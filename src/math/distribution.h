/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MATH_DISTRIBUTION_H
#define MATH_DISTRIBUTION_H

#include <stdbool.h>
#include <stdint.h>

/*
 * A discrete distribution over n items by non-negative weights: inverts the cumulative sums, so
 * that strata of the random number stay together, and hands back the unused part of it.
 * Owns its memory; {0} is empty.
 */
struct distribution {
    float *cdf; /* [n + 1]: 0 ... 1 */
    uint32_t n;
    double total; /* of the weights */
};

/* False when memory is short. With a total of 0 (or not finite) all items are equally likely. */
bool distribution_init(struct distribution *d, const float *weights, uint32_t n);
void distribution_release(struct distribution *d);

/* The item whose interval of the cdf holds *u; *u becomes the position in it, in [0,1). Never
 * returns an item of probability 0. */
uint32_t distribution_sample(const struct distribution *d, float *u);

static inline float distribution_probability(const struct distribution *d, uint32_t i)
{
    return d->cdf[i + 1] - d->cdf[i];
}

/*
 * A piecewise constant density on the unit square over width x height cells: choose a row, then a
 * cell of it, then a place in it.
 */
struct distribution2d {
    float *rows;  /* cdf [height + 1] */
    float *cells; /* cdfs [height][width + 1] */
    uint32_t width, height;
};

/* In two steps, of which the second allocates nothing and may be repeated. */
bool distribution2d_alloc(struct distribution2d *d, uint32_t width, uint32_t height);
void distribution2d_set(struct distribution2d *d, const float *weights);

/* weights [height][width], per cell (not per area of anything else). */
bool distribution2d_init(struct distribution2d *d, const float *weights, uint32_t width,
                         uint32_t height);
void distribution2d_release(struct distribution2d *d);

/* A cell, the place (*u, *v) in it in [0,1)^2, and its density with respect to area of the unit
 * square. */
void distribution2d_choose(const struct distribution2d *d, float *u, float *v, uint32_t *column,
                           uint32_t *row, float *pdf);

/* A place (x, y) in [0,1)^2 and its density with respect to area of the unit square. */
void distribution2d_sample(const struct distribution2d *d, float u, float v, float *x, float *y,
                           float *pdf);
float distribution2d_pdf(const struct distribution2d *d, float x, float y);

#endif
