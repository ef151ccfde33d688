/* SPDX-License-Identifier: Apache-2.0 */
/* The plain kernels of grids, and the choice among all. */
#include "nn/grid_kernels.h"

#include "base/cpu.h"

static float *place(float *tile, size_t stride, uint32_t panel, uint32_t row, uint32_t feature)
{
    return tile + feature / panel * stride + (size_t)row * panel + feature % panel;
}

static void encode(const struct grid_encode *a)
{
    const uint32_t n_each = a->grid->n_levels * GRID_FEATURES;
    float encoded[GRID_MAX_LEVELS * GRID_FEATURES];
    for (uint32_t r = 0; r < a->n; r++) {
        grid_encode(a->grid, a->table, a->positions + r * a->pitch, encoded);
        for (uint32_t k = 0; k < n_each; k++)
            *place(a->tile, a->stride, a->panel, r, a->first + k) = encoded[k];
    }
}

static void back(const struct grid_back *a)
{
    for (size_t r = 0; r < a->n; r++)
        grid_encode_back(a->grid, a->level, a->positions + r * a->pitch, a->d + r * GRID_FEATURES,
                         a->gradient);
}

static void spread(const struct grid_spread *a)
{
    for (uint32_t r = 0; r < a->n; r++)
        for (uint32_t k = 0; k < a->count; k++)
            *place(a->tile, a->stride, a->panel, r,
                   a->first + k) = a->rows[(size_t)r * a->count + k];
}

const struct grid_kernels grid_kernels_ref = {
    .name = "baseline", .encode = encode, .back = back, .spread = spread};

const struct grid_kernels *grid_kernels_for(uint32_t cpu)
{
    if (!(cpu & CPU_AVX2)) return &grid_kernels_ref;
    return cpu & CPU_AVX512 ? &grid_kernels_avx512 : &grid_kernels_avx2;
}
