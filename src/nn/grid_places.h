/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_GRID_PLACES_H
#define NN_GRID_PLACES_H

/*
 * Where points are in a grid: their cells, and the entries of these cells' vertices. For kernels
 * over lanes of points, after the vectors of grid_lanes.h.
 */

#include <stdbool.h>

#include "nn/grid_kernels.h"
#include "nn/unroll.h"

#define EACH(i, n) UNROLL for (int i = 0; i < (n); i++)

/* The positions of points first .. first + LANES - 1, within the cube; past the end the last. */
INLINE void load_points(vec p[3], const float *positions, size_t pitch, uint32_t first, uint32_t n)
{
    points_load(p, positions + first * pitch, pitch, n - 1 - first);
    EACH(a, 3) p[a] = vec_min(vec_max(p[a], vec_set1(0.0f)), vec_set1(GRID_MOST));
}

/* One level of a grid. */
struct level {
    float n; /* cells along an edge */
    uint32_t edge, mask;
    bool is_hashed;
    size_t at; /* its values, floats into the table */
};

static struct level level_of(const struct grid *g, uint32_t index)
{
    return (struct level){.n = (float)g->n_cells[index],
                          .edge = g->n_cells[index] + 1,
                          .mask = g->n_entries[index] - 1,
                          .is_hashed = grid_is_hashed(g, index),
                          .at = g->at[index]};
}

/* The lower vertex of each point's cell, and how far in it the point is. */
INLINE void find_low(const struct level *l, const vec p[3], ivec low[3], vec f[3])
{
    EACH(a, 3)
    {
        vec x = vec_mul(p[a], vec_set1(l->n));
        low[a] = vec_to_ivec(x);
        f[a] = vec_sub(x, ivec_to_vec(low[a]));
    }
}

/* Entries of the vertices of LANES points' cells. */
typedef uint32_t entries[8][LANES] __attribute__((aligned(64)));

/* In a hashed level each vertex has its own entry; in a dense one they lie vertex_step(l, k) after
 * the first, and only that is found. */
INLINE void find_entries(const bool is_hashed, const struct level *l, const ivec low[3],
                         entries entry)
{
    if (!is_hashed) {
        const ivec edge = ivec_set1((int)l->edge);
        ivec_store(entry[0],
                   ivec_add(low[0], ivec_mul(edge, ivec_add(low[1], ivec_mul(edge, low[2])))));
        return;
    }
    const ivec ky = ivec_set1((int)GRID_HASH_Y), kz = ivec_set1((int)GRID_HASH_Z);
    const ivec mask = ivec_set1((int)l->mask);
    ivec x[2] = {low[0], ivec_add(low[0], ivec_set1(1))};
    ivec y[2] = {ivec_mul(low[1], ky)}, z[2] = {ivec_mul(low[2], kz)};
    y[1] = ivec_add(y[0], ky);
    z[1] = ivec_add(z[0], kz);
    EACH(k, 8)
    ivec_store(entry[k], ivec_xor_and(x[k & 1], ivec_xor(y[k >> 1 & 1], z[k >> 2]), mask));
}

INLINE size_t vertex_step(const struct level *l, int k)
{
    return (size_t)(k & 1) + (size_t)l->edge * ((size_t)(k >> 1 & 1) + (size_t)l->edge * (k >> 2));
}

/* Where LANES points are in one level. */
struct places {
    entries entry;
    float f[3][LANES] __attribute__((aligned(64)));
    uint32_t changes; /* ivec_changes() */
};

INLINE void find_places(const struct level *l, const vec p[3], struct places *to)
{
    ivec low[3];
    vec f[3];
    find_low(l, p, low, f);
    if (l->is_hashed)
        find_entries(true, l, low, to->entry);
    else
        find_entries(false, l, low, to->entry);
    EACH(a, 3) vec_store(to->f[a], f[a]);
    to->changes = ivec_changes(low);
}

#endif
