/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernels of grids over lanes of points, included once by each instruction set's file, which
 * defines before:
 *
 *   LANES, PAIRS   floats per vector; pairs of floats per vector, half of them
 *   vec, ivec      vectors of floats and of integers of 32 bits
   half           half an ivec, the integers of PAIRS points
   and the operations used below
 *
 * A lane is a point while entries are looked for. The two numbers of an entry come as one load of
 * 64 bits, so that a vector then holds the pairs of PAIRS points; PAIRS levels of them, transposed,
 * are rows of the tile.
 */

#include <stdbool.h>

#include "nn/unroll.h"

enum { HALVES = LANES / PAIRS };

#define EACH(i, n) UNROLL for (int i = 0; i < (n); i++)

/* The positions of points first .. first + LANES - 1, within the cube; past the end the last. */
INLINE void load_points(vec p[3], const float *positions, size_t pitch, uint32_t first, uint32_t n)
{
    const ivec point = ivec_min(ivec_count(), ivec_set1((int)(n - 1 - first)));
    const ivec at = ivec_mul(point, ivec_set1((int)pitch));
    const float *from = positions + first * pitch;
    EACH(a, 3)
    {
        vec x = vec_gather(from + a, at);
        p[a] = vec_min(vec_max(x, vec_set1(0.0f)), vec_set1(GRID_MOST));
    }
}

/* One level of a grid. */
struct level {
    float n; /* cells along an edge */
    uint32_t edge, mask;
    bool is_hashed;
};

static struct level level_of(const struct grid *g, uint32_t index)
{
    return (struct level){.n = (float)g->n_cells[index],
                          .edge = g->n_cells[index] + 1,
                          .mask = g->n_entries[index] - 1,
                          .is_hashed = grid_is_hashed(g, index)};
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

/* The hashed entries of the eight vertices, of a half's points. */
INLINE void hash(const struct level *l, const half low[3], half entry[8])
{
    const half ky = half_set1((int)GRID_HASH_Y), kz = half_set1((int)GRID_HASH_Z);
    const half mask = half_set1((int)l->mask);
    half x[2] = {low[0], half_add(low[0], half_set1(1))};
    half y[2] = {half_mul(low[1], ky)}, z[2] = {half_mul(low[2], kz)};
    y[1] = half_add(y[0], ky);
    z[1] = half_add(z[0], kz);
    EACH(k, 8) entry[k] = half_xor_and(x[k & 1], half_xor(y[k >> 1 & 1], z[k >> 2]), mask);
}

/* The first entry of a dense array; vertex k lies dense_step(l, k) entries on. */
INLINE half dense(const struct level *l, const half low[3])
{
    const half edge = half_set1((int)l->edge);
    return half_add(low[0], half_mul(edge, half_add(low[1], half_mul(edge, low[2]))));
}

INLINE size_t dense_step(const struct level *l, int k)
{
    return (size_t)(k & 1) + (size_t)l->edge * ((size_t)(k >> 1 & 1) + (size_t)l->edge * (k >> 2));
}

/* Whether all points of a half are in one cell: pixels side by side often are, on coarse levels. */
INLINE bool is_shared(const half low[3])
{
    return half_is_same(
        half_or(half_differs(low[0]), half_or(half_differs(low[1]), half_differs(low[2]))));
}

/* The values of the eight vertices of the cell that all points of a half share. */
INLINE void load_shared(const bool is_hashed, const struct level *l, const float *values,
                        const half low[3], vec v[8])
{
    const uint32_t x = half_first(low[0]), y = half_first(low[1]), z = half_first(low[2]);
    const uint32_t ky = is_hashed ? GRID_HASH_Y : l->edge;
    const uint32_t kz = is_hashed ? GRID_HASH_Z : l->edge * l->edge;
    EACH(k, 8)
    {
        const uint32_t xk = x + (k & 1), yk = (y + (k >> 1 & 1)) * ky, zk = (z + (k >> 2)) * kz;
        const uint32_t entry = is_hashed ? (xk ^ yk ^ zk) & l->mask : xk + yk + zk;
        v[k] = pairs_set1(values + (size_t)entry * GRID_FEATURES);
    }
}

/* The same where they do not. */
INLINE void load_each(const bool is_hashed, const struct level *l, const float *values,
                      const half low[3], vec v[8])
{
    if (is_hashed) {
        half entry[8];
        hash(l, low, entry);
        EACH(k, 8) v[k] = pairs_gather(values, entry[k]);
    } else {
        const half entry = dense(l, low);
        EACH(k, 8) v[k] = pairs_gather(values + GRID_FEATURES * dense_step(l, k), entry);
    }
}

/* Between a and b. */
INLINE vec mix(vec a, vec b, vec f)
{
    return vec_fma(f, vec_sub(b, a), a);
}

/* out [HALVES]: the pairs of all points. */
INLINE void encode_level(const bool is_hashed, const struct level *l, const float *values,
                         const vec p[3], vec *out)
{
    ivec lows[3];
    vec f[3];
    find_low(l, p, lows, f);
    EACH(i, HALVES)
    {
        vec v[8];
        half low[3];
        EACH(a, 3) low[a] = ivec_half(lows[a], i);
        if (is_shared(low))
            load_shared(is_hashed, l, values, low, v);
        else
            load_each(is_hashed, l, values, low, v);
        EACH(a, 3)
        {
            const vec fa = pairs_repeat(f[a], i);
            EACH(k, 4 >> a) v[k] = mix(v[2 * k], v[2 * k + 1], fa);
        }
        out[i] = v[0];
    }
}

/* Pairs of PAIRS levels and points, level by level, into rows of the tile: n_rows of them, n_levels
 * of each. */
INLINE void store_pairs(const struct grid_encode *a, uint32_t row, uint32_t n_rows, uint32_t level,
                        uint32_t n_levels, const vec *pairs)
{
    const uint32_t feature = a->first + level * GRID_FEATURES, at = feature % a->panel;
    const uint32_t n = n_levels * GRID_FEATURES, room = a->panel - at;
    float *to = a->tile + feature / a->panel * a->stride + (size_t)row * a->panel + at;
    vec rows[PAIRS];
    pairs_transpose(rows, pairs);
    if (n == LANES && room >= LANES && n_rows == PAIRS) {
        EACH(r, PAIRS) vec_store(to + (size_t)r * a->panel, rows[r]);
        return;
    }
    /* What does not fit into the panel goes to the start of the next. */
    const vec_mask here = vec_mask_first(n < room ? n : room);
    for (uint32_t r = 0; r < n_rows; r++, to += a->panel) {
        float spare[2 * LANES];
        vec_store(spare, rows[r]);
        vec_store_part(to, here, rows[r]);
        if (n > room)
            vec_store_part(to - at + a->stride, vec_mask_first(n - room), vec_load(spare + room));
    }
}

static void encode(const struct grid_encode *a)
{
    const struct grid *g = a->grid;
    for (uint32_t r = 0; r < a->n; r += LANES) {
        vec p[3];
        load_points(p, a->positions, a->pitch, r, a->n);
        for (uint32_t first = 0; first < g->n_levels; first += PAIRS) {
            const uint32_t rest = g->n_levels - first, n_levels = rest < PAIRS ? rest : PAIRS;
            vec pairs[HALVES][PAIRS];
            for (uint32_t i = 0; i < n_levels; i++) {
                const struct level l = level_of(g, first + i);
                vec out[HALVES];
                const float *values = a->table + g->at[first + i];
                if (l.is_hashed)
                    encode_level(true, &l, values, p, out);
                else
                    encode_level(false, &l, values, p, out);
                EACH(k, HALVES) pairs[k][i] = out[k];
            }
            for (uint32_t i = n_levels; i < PAIRS; i++)
                EACH(k, HALVES) pairs[k][i] = vec_set1(0.0f);
            EACH(k, HALVES)
            {
                const uint32_t row = r + (uint32_t)k * PAIRS;
                if (row >= a->n) continue;
                const uint32_t n_rows = a->n - row < PAIRS ? a->n - row : PAIRS;
                store_pairs(a, row, n_rows, first, n_levels, pairs[k]);
            }
        }
    }
}

/* ---- Backward ---- */

static void back(const struct grid_back *a)
{
    const struct level l = level_of(a->grid, a->level);
    for (uint32_t r = 0; r < a->n; r += LANES) {
        const uint32_t n = a->n - r < LANES ? a->n - r : LANES;
        uint32_t entry[8][LANES] __attribute__((aligned(64)));
        float weight[8][LANES] __attribute__((aligned(64)));
        vec p[3], f[3], rest[3];
        ivec lows[3];
        load_points(p, a->positions, a->pitch, r, a->n);
        find_low(&l, p, lows, f);
        EACH(i, HALVES)
        {
            half low[3], entries[8];
            EACH(c, 3) low[c] = ivec_half(lows[c], i);
            if (l.is_hashed) {
                hash(&l, low, entries);
            } else {
                const half first = dense(&l, low);
                EACH(k, 8) entries[k] = half_add(first, half_set1((int)dense_step(&l, k)));
            }
            EACH(k, 8) half_store(entry[k] + i * PAIRS, entries[k]);
        }
        EACH(c, 3) rest[c] = vec_sub(vec_set1(1.0f), f[c]);
        EACH(k, 8)
        {
            const vec xy = vec_mul(k & 1 ? f[0] : rest[0], k & 2 ? f[1] : rest[1]);
            vec_store(weight[k], vec_mul(xy, k & 4 ? f[2] : rest[2]));
        }
        /* One point after the other, as two may share a vertex. */
        for (uint32_t i = 0; i < n; i++) {
            const __m128 d = _mm_castpd_ps(_mm_load_sd(
                (const double *)(const void *)(a->d + (size_t)(r + i) * GRID_FEATURES)));
            EACH(k, 8)
            {
                double *to = (double *)(void *)(a->gradient + (size_t)entry[k][i] * GRID_FEATURES);
                const __m128 sum = _mm_castpd_ps(_mm_load_sd(to));
                _mm_store_sd(to, _mm_castps_pd(_mm_fmadd_ps(_mm_set1_ps(weight[k][i]), d, sum)));
            }
        }
    }
}

/* ---- Features ---- */

/* Pieces of the tile's lines: a vector of the tile never crosses panels. */
static void spread(const struct grid_spread *a)
{
    for (uint32_t k = 0; k < a->count;) {
        const uint32_t feature = a->first + k, in_vector = feature % LANES;
        const uint32_t room = LANES - in_vector, left = a->count - k;
        const uint32_t n = left < room ? left : room;
        const vec_mask mask = vec_mask_first(n);
        const float *from = a->rows + k;
        float *to = a->tile + feature / a->panel * a->stride + feature % a->panel;
        for (uint32_t r = 0; r < a->n; r++, from += a->count, to += a->panel)
            vec_store_part(to, mask, vec_load_part(from, mask));
        k += n;
    }
}
