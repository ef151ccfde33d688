/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_FILM_H
#define RENDER_FILM_H

#include "render/filter.h"
#include "render/view.h"

/*
 * Splatting: a sample, drawn uniformly within its pixel, counts in all pixels whose filter it falls
 * under, and a pixel is the weighted mean of what it got. All neighbours' samples lower its noise:
 * for a tent 2.25 times less variance than when each sample counts for one pixel (filter.h).
 *
 * Sums are made tile by tile, in scan order within a tile, then tiles are added in order. Tiles are
 * those of the whole picture, so that neither threads nor windows change the order of additions,
 * nor a byte.
 */
enum {
    FILM_TILE = 32,
    FILM_MARGIN = 4, /* of the widest filter, in pixels; wider ones are not splatted */
    FILM_SIDE = FILM_TILE + 2 * FILM_MARGIN,
    FILM_SAMPLES = 128 /* weighed at once, at most */
};

/* Weighted radiance and weight, of even and odd samples. */
struct film_sum {
    float rgbw[2][4];
};

/* What the samples of one tile bring, also to the pixels around it. */
struct film_tile {
    int32_t x, y; /* of the first sum, in the picture: may lie outside */
    struct film_sum sums[FILM_SIDE * FILM_SIDE];
};

/* Pixels beyond its own that a filter reaches, on each side; 0: splatting is of no use. */
uint32_t film_margin(const struct filter *f);

/* Readies the tile whose first pixel in the picture is (x, y), multiples of FILM_TILE. */
void film_tile_start(struct film_tile *t, uint32_t margin, uint32_t x, uint32_t y);

/* What samples weigh in the pixels around their own, by column and by row, the pixel `margin` to
 * the left or above first: the products are the filter's values. */
struct film_weights {
    float across[2 * FILM_MARGIN + 1][FILM_SAMPLES], down[2 * FILM_MARGIN + 1][FILM_SAMPLES];
};

/* Of n samples that lie at (dx, dy) from their pixels' centres. */
void film_weigh(struct film_weights *w, const struct filter *f, uint32_t margin, uint32_t n,
                const float *dx, const float *dy);

/* Adds sample i of those, of the even or the odd half, of one of the tile's pixels: (column, row)
 * of the picture. */
void film_tile_add(struct film_tile *t, uint32_t margin, const struct film_weights *w, uint32_t i,
                   uint32_t column, uint32_t row, uint32_t half, struct vec3 radiance);

/* Adds what a tile has for the window to the window's sums [height][width]. */
void film_add(struct film_sum *sums, const struct window *w, const struct film_tile *t,
              uint32_t margin);

/* Turns sums of the `part` of the window w into means. */
void film_store(const struct film_sum *sums, const struct window *part, const struct window *w,
                struct trace_output *out);

#endif
