/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/rounded.h"

#include "nn/grid_vectors_avx512.h"

#include "nn/grid_places.h"

/* Levels side by side: their pairs of a point are half a vector. */
enum { LEVELS = 8 };

/* For all points but the first n. */
INLINE vec set_rest(vec x, uint32_t n, const float *from)
{
    return _mm512_mask_broadcastss_ps(x, (__mmask16)(0xFFFFu << n), _mm_load_ss(from));
}

INLINE const float *vertex_pair(const bool is_hashed, const struct level *l, const float *pairs,
                                const entries entry, uint32_t point, int k)
{
    return pairs + (is_hashed ? entry[k][point] : entry[0][point] + vertex_step(l, k));
}

/* As load_values() of grid_lanes.h: one load for each run of points in one cell. */
INLINE void load_pairs(const bool is_hashed, const struct level *l, const float *pairs,
                       const struct places *at, vec v[8])
{
    EACH(k, 8) v[k] = vec_set1(*vertex_pair(is_hashed, l, pairs, at->entry, 0, k));
    for (uint32_t runs = at->changes & ~1u; runs; runs &= runs - 1) {
        const uint32_t n = (uint32_t)__builtin_ctz(runs);
        EACH(k, 8) v[k] = set_rest(v[k], n, vertex_pair(is_hashed, l, pairs, at->entry, n, k));
    }
}

/* Between the eight vertices. */
INLINE vec mix_vertices(vec v[8], const vec f[3])
{
    EACH(a, 3)
    EACH(k, 4 >> a) v[k] = vec_fma(f[a], vec_sub(v[2 * k + 1], v[2 * k]), v[2 * k]);
    return v[0];
}

/* Two floats of each point as a pair. */
INLINE __m512i round_pairs(vec low, vec high)
{
    const __m512i order = _mm512_set_epi16(31, 15, 30, 14, 29, 13, 28, 12, 27, 11, 26, 10, 25, 9,
                                           24, 8, 23, 7, 22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1,
                                           16, 0);
    return _mm512_permutexvar_epi16(order, (__m512i)_mm512_cvtne2ps_pbh(high, low));
}

INLINE __m512i encode_level(const bool is_hashed, const struct level *l, const float *pairs,
                            const struct places *at)
{
    const __m512i high_half = _mm512_set1_epi32((int)0xFFFF0000u);
    vec v[8], low[8], high[8], f[3];
    load_pairs(is_hashed, l, pairs, at, v);
    EACH(a, 3) f[a] = vec_load(at->f[a]);
    EACH(k, 8)
    {
        const __m512i both = _mm512_castps_si512(v[k]);
        low[k] = _mm512_castsi512_ps(_mm512_slli_epi32(both, 16));
        high[k] = _mm512_castsi512_ps(_mm512_and_si512(both, high_half));
    }
    return round_pairs(mix_vertices(low, f), mix_vertices(high, f));
}

/* 8 levels of 16 points to rows of 8 levels: rows[i] has those of points i and i + 4, rows[i + 4]
 * of i + 8 and i + 12. */
INLINE void transpose(__m512i rows[LEVELS], const __m512i levels[LEVELS])
{
    const __m512i first = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
    const __m512i last = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
    __m512i quads[4][2]; /* of every fourth point, half of the levels */
    EACH(h, 2)
    {
        const __m512i *l = levels + 4 * h;
        const __m512i a = _mm512_unpacklo_epi32(l[0], l[1]), b = _mm512_unpacklo_epi32(l[2], l[3]);
        const __m512i c = _mm512_unpackhi_epi32(l[0], l[1]), d = _mm512_unpackhi_epi32(l[2], l[3]);
        quads[0][h] = _mm512_unpacklo_epi64(a, b);
        quads[1][h] = _mm512_unpackhi_epi64(a, b);
        quads[2][h] = _mm512_unpacklo_epi64(c, d);
        quads[3][h] = _mm512_unpackhi_epi64(c, d);
    }
    EACH(i, 4)
    {
        rows[i] = _mm512_permutex2var_epi64(quads[i][0], first, quads[i][1]);
        rows[i + 4] = _mm512_permutex2var_epi64(quads[i][0], last, quads[i][1]);
    }
}

/* Into rows of the tile: n_rows of them, n_levels of each from `level` on. */
INLINE void store_levels(const struct grid_encode *a, uint32_t row, uint32_t n_rows, uint32_t level,
                         uint32_t n_levels, const __m512i levels[LEVELS])
{
    const uint32_t feature = a->first + level * GRID_FEATURES, at = feature % a->panel / 2;
    float *to = a->tile + feature / a->panel * a->stride + (size_t)row * a->panel;
    __m512i rows[LEVELS];
    transpose(rows, levels);
    const uint32_t room = a->panel / 2 - at, here = n_levels < room ? n_levels : room;
    const __mmask8 mask = (__mmask8)((1u << here) - 1), rest = (__mmask8)((1u << n_levels) - 1);
    EACH(i, LANES)
    {
        const __m512i two = rows[i % 4 + i / 8 * 4];
        const __m256i one = i & 4 ? _mm512_extracti64x4_epi64(two, 1) : _mm512_castsi512_si256(two);
        if ((uint32_t)i < n_rows) {
            float *pairs = to + (size_t)i * a->panel;
            _mm256_mask_storeu_epi32(pairs + at, mask, one);
            /* What does not fit into the panel goes to the start of the next. */
            if (n_levels > room)
                _mm256_mask_storeu_epi32(pairs + a->stride - room, rest & (__mmask8)~mask, one);
        }
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
        for (uint32_t first = 0; first < g->n_levels; first += LEVELS) {
            const uint32_t rest = g->n_levels - first, n_levels = rest < LEVELS ? rest : LEVELS;
            struct places places[LEVELS];
            __m512i encoded[LEVELS];
            for (uint32_t i = 0; i < n_levels; i++) find_places(&levels[first + i], p, &places[i]);
            for (uint32_t i = 0; i < n_levels; i++) {
                const struct level *l = &levels[first + i];
                const float *pairs = a->table + l->at / GRID_FEATURES;
                encoded[i] = l->is_hashed ? encode_level(true, l, pairs, &places[i])
                                          : encode_level(false, l, pairs, &places[i]);
            }
            for (uint32_t i = n_levels; i < LEVELS; i++) encoded[i] = _mm512_setzero_si512();
            store_levels(a, r, a->n - r < LANES ? a->n - r : LANES, first, n_levels, encoded);
        }
    }
}

/* Pieces of the tile's rows, as in grid_lanes.h, of a vector of pairs each. */
static void spread(const struct grid_spread *a)
{
    enum { PIECES = 4, FLOATS = 2 * LANES };
    for (uint32_t k = 0; k < a->count;) {
        size_t from[PIECES], to[PIECES];
        uint32_t mask[PIECES], n_pieces = 0; /* of floats */
        for (; n_pieces < PIECES && k < a->count; n_pieces++) {
            const uint32_t feature = a->first + k, room = FLOATS - feature % FLOATS;
            const uint32_t n = a->count - k < room ? a->count - k : room;
            mask[n_pieces] = (uint32_t)((UINT64_C(1) << n) - 1);
            from[n_pieces] = k;
            to[n_pieces] = feature / a->panel * a->stride + feature % a->panel / 2;
            k += n;
        }
        for (uint32_t r = 0; r < a->n; r++) {
            const float *row = a->rows + (size_t)r * a->count;
            float *tile = a->tile + (size_t)r * a->panel;
            for (uint32_t i = 0; i < n_pieces; i++) {
                const vec low = vec_load_part(row + from[i], (__mmask16)mask[i]);
                const vec high = vec_load_part(row + from[i] + LANES,
                                               (__mmask16)(mask[i] >> LANES));
                const __m512i pairs = (__m512i)_mm512_cvtne2ps_pbh(high, low);
                const uint32_t n = (uint32_t)__builtin_popcount(mask[i]);
                _mm512_mask_storeu_epi32(tile + to[i], vec_mask_first((n + 1) / 2), pairs);
            }
        }
    }
}

const struct grid_kernels grid_rounded_avx512bf16 = {
    .name = "avx512bf16", .encode = encode, .spread = spread};
