/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/grid.h"

#include <math.h>

void grid_init(struct grid *g, const struct grid_config *config)
{
    const uint32_t most = UINT32_C(1) << config->log2_size;
    double n_cells = config->base;
    *g = (struct grid){.n_levels = config->n_levels};
    for (uint32_t l = 0; l < g->n_levels; l++, n_cells *= (double)config->growth) {
        /* Finer than floats in [0,1] can tell is of no use. */
        g->n_cells[l] = (uint32_t)fmin(n_cells, 0x1p20);
        uint64_t edge = (uint64_t)g->n_cells[l] + 1, n = edge * edge * edge;
        g->n_entries[l] = n < most ? (uint32_t)n : most;
        g->at[l + 1] = g->at[l] + (size_t)g->n_entries[l] * GRID_FEATURES;
    }
}

void grid_find(const struct grid *g, uint32_t level, const float p[3], struct grid_cell *c)
{
    const uint32_t n = g->n_cells[level], edge = n + 1, n_entries = g->n_entries[level];
    const bool is_hashed = grid_is_hashed(g, level);
    const uint32_t stride[3] = {1, is_hashed ? GRID_HASH_Y : edge,
                                is_hashed ? GRID_HASH_Z : edge * edge};
    uint32_t low[3];
    float f[3];
    for (int a = 0; a < 3; a++) {
        float x = p[a] > 0.0f ? p[a] : 0.0f; /* also where it is no number */
        x = (x < GRID_MOST ? x : GRID_MOST) * (float)n;
        uint32_t i = (uint32_t)x;
        f[a] = x - (float)i;
        low[a] = i;
    }
    for (uint32_t k = 0; k < 8; k++) {
        uint32_t x = (low[0] + (k & 1)) * stride[0], y = (low[1] + (k >> 1 & 1)) * stride[1],
                 z = (low[2] + (k >> 2)) * stride[2];
        c->entry[k] = is_hashed ? (x ^ y ^ z) & (n_entries - 1) : x + y + z;
        c->weight[k] = (k & 1 ? f[0] : 1.0f - f[0]) * (k & 2 ? f[1] : 1.0f - f[1]) *
                       (k & 4 ? f[2] : 1.0f - f[2]);
    }
}

void grid_encode(const struct grid *g, const float *table, const float p[3], float *out)
{
    for (uint32_t l = 0; l < g->n_levels; l++, out += GRID_FEATURES) {
        const float *values = table + g->at[l];
        struct grid_cell c;
        float sum[GRID_FEATURES] = {0};
        grid_find(g, l, p, &c);
        for (uint32_t k = 0; k < 8; k++)
            for (uint32_t i = 0; i < GRID_FEATURES; i++)
                sum[i] += c.weight[k] * values[(size_t)c.entry[k] * GRID_FEATURES + i];
        for (uint32_t i = 0; i < GRID_FEATURES; i++) out[i] = sum[i];
    }
}

void grid_encode_back(const struct grid *g, uint32_t level, const float p[3], const float *d,
                      float *gradient)
{
    struct grid_cell c;
    grid_find(g, level, p, &c);
    for (uint32_t k = 0; k < 8; k++)
        for (uint32_t i = 0; i < GRID_FEATURES; i++)
            gradient[(size_t)c.entry[k] * GRID_FEATURES + i] += c.weight[k] * d[i];
}
