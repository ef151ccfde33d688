/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernels of grids over lanes of points, included once by each instruction set's file, which
 * defines before:
 *
 *   LANES, PAIRS   floats per vector; pairs of floats per vector, half of them
 *   vec, ivec      vectors of floats and of integers of 32 bits
 *   and the operations used below
 *
 * A lane is a point while entries are looked for. The two numbers of an entry come as one load of
 * 64 bits, so that a vector then holds the pairs of PAIRS points; PAIRS levels of them, transposed,
 * are rows of the tile. Entries of PAIRS levels are all found before the first value is loaded:
 * otherwise mixtures that wait for their values keep the processor from going ahead.
 */

#include "nn/grid_places.h"

enum { HALVES = LANES / PAIRS };

/* The value of vertex k of one point's cell. */
INLINE const float *vertex_value(const bool is_hashed, const struct level *l, const float *values,
                                 entries entry, uint32_t point, int k)
{
    const size_t at = is_hashed ? entry[k][point] : entry[0][point] + vertex_step(l, k);
    return values + at * GRID_FEATURES;
}

/* The values of the eight vertices of the cells of PAIRS points from `first` on. `runs` has a bit
 * for the first point of each run in one cell: one load serves a run, as pixels side by side often
 * share cells, and loads one by one are no slower than gathering where they do not. */
INLINE void load_values(const bool is_hashed, const struct level *l, const float *values,
                        entries entry, uint32_t first, uint32_t runs, vec v[8])
{
    EACH(k, 8) v[k] = pairs_set1(vertex_value(is_hashed, l, values, entry, first, k));
    while (runs &= runs - 1) {
        const uint32_t n = (uint32_t)__builtin_ctz(runs);
        EACH(k, 8)
        v[k] = pairs_set_rest(v[k], n, vertex_value(is_hashed, l, values, entry, first + n, k));
    }
}

/* Between a and b. */
INLINE vec mix(vec a, vec b, vec f)
{
    return vec_fma(f, vec_sub(b, a), a);
}

/* out [HALVES]: the pairs of all points. */
INLINE void encode_level(const bool is_hashed, const struct level *l, const float *values,
                         struct places *at, vec *out)
{
    EACH(i, HALVES)
    {
        const uint32_t runs = (at->changes >> i * PAIRS & ((1u << PAIRS) - 1)) | 1;
        vec v[8];
        load_values(is_hashed, l, values, at->entry, i * PAIRS, runs, v);
        EACH(a, 3)
        {
            const vec fa = pairs_repeat(vec_load(at->f[a]), i);
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
    struct level levels[GRID_MAX_LEVELS];
    for (uint32_t i = 0; i < g->n_levels; i++) levels[i] = level_of(g, i);
    for (uint32_t r = 0; r < a->n; r += LANES) {
        vec p[3];
        load_points(p, a->positions, a->pitch, r, a->n);
        for (uint32_t first = 0; first < g->n_levels; first += PAIRS) {
            const uint32_t rest = g->n_levels - first, n_levels = rest < PAIRS ? rest : PAIRS;
            struct places places[PAIRS];
            vec pairs[HALVES][PAIRS];
            for (uint32_t i = 0; i < n_levels; i++) find_places(&levels[first + i], p, &places[i]);
            for (uint32_t i = 0; i < n_levels; i++) {
                const struct level *l = &levels[first + i];
                vec out[HALVES];
                if (l->is_hashed)
                    encode_level(true, l, a->table + l->at, &places[i], out);
                else
                    encode_level(false, l, a->table + l->at, &places[i], out);
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
        entries entry;
        float weight[8][LANES] __attribute__((aligned(64)));
        vec p[3], f[3], rest[3];
        ivec low[3];
        load_points(p, a->positions, a->pitch, r, a->n);
        find_low(&l, p, low, f);
        find_entries(l.is_hashed, &l, low, entry);
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
                const size_t at = l.is_hashed ? entry[k][i] : entry[0][i] + vertex_step(&l, k);
                double *to = (double *)(void *)(a->gradient + at * GRID_FEATURES);
                const __m128 sum = _mm_castpd_ps(_mm_load_sd(to));
                _mm_store_sd(to, _mm_castps_pd(_mm_fmadd_ps(_mm_set1_ps(weight[k][i]), d, sum)));
            }
        }
    }
}

/* ---- Features ---- */

/* Pieces of the tile's rows, a few at a time: a vector of the tile never crosses panels. */
static void spread(const struct grid_spread *a)
{
    enum { PIECES = 8 };
    for (uint32_t k = 0; k < a->count;) {
        size_t from[PIECES], to[PIECES];
        vec_mask mask[PIECES];
        uint32_t n_pieces = 0;
        for (; n_pieces < PIECES && k < a->count; n_pieces++) {
            const uint32_t feature = a->first + k, room = LANES - feature % LANES;
            const uint32_t n = a->count - k < room ? a->count - k : room;
            mask[n_pieces] = vec_mask_first(n);
            from[n_pieces] = k;
            to[n_pieces] = feature / a->panel * a->stride + feature % a->panel;
            k += n;
        }
        for (uint32_t r = 0; r < a->n; r++) {
            const float *row = a->rows + (size_t)r * a->count;
            float *tile = a->tile + (size_t)r * a->panel;
            for (uint32_t i = 0; i < n_pieces; i++)
                vec_store_part(tile + to[i], mask[i], vec_load_part(row + from[i], mask[i]));
        }
    }
}
