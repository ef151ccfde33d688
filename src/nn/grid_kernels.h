/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_GRID_KERNELS_H
#define NN_GRID_KERNELS_H

#include <stddef.h>
#include <stdint.h>

#include "nn/grid.h"

/*
 * Grids for many points at once, one table of functions per instruction set; see kernels.h for the
 * layout of a tile. All sets find the same entries; sums and products are taken in another order,
 * so results agree to rounding only. grid.c is the plain version.
 */

/* Rows 0 .. n-1 of a tile: features first .. first + 2 n_levels - 1 become the encoding. */
struct grid_encode {
    const struct grid *grid;
    const float *table;
    const float *positions; /* row r's at positions + r * pitch */
    size_t pitch;
    uint32_t n, first; /* first: even */
    float *tile;
    size_t stride;
    uint32_t panel;
};

/* Adds what `d` [n][GRID_FEATURES] brings to the gradient of one level, point after point. */
struct grid_back {
    const struct grid *grid;
    uint32_t level;
    const float *positions;
    size_t pitch;
    uint32_t n;
    const float *d;
    float *gradient; /* [n_entries[level]][GRID_FEATURES] */
};

/* Rows 0 .. n-1 of a tile: features first .. first + count - 1 become those of `rows` [n][count].
 */
struct grid_spread {
    const float *rows;
    uint32_t n, count, first;
    float *tile;
    size_t stride;
    uint32_t panel;
};

struct grid_kernels {
    const char *name;
    void (*encode)(const struct grid_encode *a);
    void (*back)(const struct grid_back *a);
    void (*spread)(const struct grid_spread *a);
};

/* The best for `cpu`, flags of base/cpu.h. */
const struct grid_kernels *grid_kernels_for(uint32_t cpu);

/* The tables themselves, for tests: the caller checks that the machine has the set. */
extern const struct grid_kernels grid_kernels_ref, grid_kernels_avx2, grid_kernels_avx512;

#endif
