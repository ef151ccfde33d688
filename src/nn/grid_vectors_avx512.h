/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_GRID_VECTORS_AVX512_H
#define NN_GRID_VECTORS_AVX512_H

/* The vectors of AVX-512 for grid_lanes.h and grid_places.h. */

#include <immintrin.h>
#include <stddef.h>
#include <stdint.h>

#define LANES 16
#define PAIRS 8

typedef __m512 vec;
typedef __m512i ivec;
typedef __mmask16 vec_mask;

#define vec_load(from)              _mm512_loadu_ps(from)
#define vec_store(to, x)            _mm512_storeu_ps(to, x)
#define vec_load_part(from, mask)   _mm512_maskz_loadu_ps(mask, from)
#define vec_store_part(to, mask, x) _mm512_mask_storeu_ps(to, mask, x)
#define vec_set1(x)                 _mm512_set1_ps(x)
#define vec_fma(a, b, c)            _mm512_fmadd_ps(a, b, c)
#define vec_mul(a, b)               _mm512_mul_ps(a, b)
#define vec_sub(a, b)               _mm512_sub_ps(a, b)
#define vec_min(a, b)               _mm512_min_ps(a, b)
#define vec_max(a, b)               _mm512_max_ps(a, b)
#define vec_to_ivec(x)              _mm512_cvttps_epi32(x)
#define ivec_to_vec(x)              _mm512_cvtepi32_ps(x)
#define ivec_set1(x)                _mm512_set1_epi32(x)
#define ivec_mul(a, b)              _mm512_mullo_epi32(a, b)

#define ivec_add(a, b)    _mm512_add_epi32(a, b)
#define ivec_xor(a, b)    _mm512_xor_si512(a, b)
#define ivec_store(to, x) _mm512_store_si512(to, x)
/* (a ^ b) & mask */
#define ivec_xor_and(a, b, mask) _mm512_ternarylogic_epi32(a, b, mask, 0x28)

/* Points k, k + 4, k + 8 and k + 12, four numbers each, of which the last is 0. */
static inline vec points_row(const float *from, size_t pitch, uint32_t k, uint32_t last)
{
    __m128 point[4];
    for (uint32_t j = 0; j < 4; j++, k += 4)
        point[j] = _mm_maskz_loadu_ps(7, from + (k < last ? k : last) * pitch);
    const __m256 low = _mm256_insertf128_ps(_mm256_castps128_ps256(point[0]), point[1], 1);
    const __m256 high = _mm256_insertf128_ps(_mm256_castps128_ps256(point[2]), point[3], 1);
    return _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
}

/* x, y and z of points 0 .. LANES - 1; of those past `last` its own. */
static inline void points_load(vec p[3], const float *from, size_t pitch, uint32_t last)
{
    vec row[4];
    for (uint32_t k = 0; k < 4; k++) row[k] = points_row(from, pitch, k, last);
    const __m512d xy[2] = {_mm512_castps_pd(_mm512_unpacklo_ps(row[0], row[1])),
                           _mm512_castps_pd(_mm512_unpacklo_ps(row[2], row[3]))};
    const __m512d z[2] = {_mm512_castps_pd(_mm512_unpackhi_ps(row[0], row[1])),
                          _mm512_castps_pd(_mm512_unpackhi_ps(row[2], row[3]))};
    p[0] = _mm512_castpd_ps(_mm512_unpacklo_pd(xy[0], xy[1]));
    p[1] = _mm512_castpd_ps(_mm512_unpackhi_pd(xy[0], xy[1]));
    p[2] = _mm512_castpd_ps(_mm512_unpacklo_pd(z[0], z[1]));
}

/* A bit for each point whose cell is not that of the point before; the first's says nothing. */
static inline uint32_t ivec_changes(const ivec low[3])
{
    ivec differs = _mm512_setzero_si512();
    for (int a = 0; a < 3; a++)
        differs = _mm512_ternarylogic_epi32(
            differs, low[a], _mm512_alignr_epi32(low[a], low[a], LANES - 1), 0xF6); /* | ^ */
    return _mm512_test_epi32_mask(differs, differs);
}

/* The first n lanes. */
static inline vec_mask vec_mask_first(uint32_t n)
{
    return n >= LANES ? 0xFFFF : (vec_mask)((1u << n) - 1);
}

/* One pair for all points. */
static inline vec pairs_set1(const float *from)
{
    return _mm512_castpd_ps(_mm512_set1_pd(*(const double *)(const void *)from));
}

/* One pair for all points but the first n. */
static inline vec pairs_set_rest(vec x, uint32_t n, const float *from)
{
    const __m128d pair = _mm_load_sd((const double *)(const void *)from);
    const __mmask8 rest = (__mmask8)(0xFFu << n);
    return _mm512_castpd_ps(_mm512_mask_broadcastsd_pd(_mm512_castps_pd(x), rest, pair));
}

/* Each number of one half of the lanes twice. */
static inline vec pairs_repeat(vec x, int i)
{
    const __m512i low = _mm512_setr_epi32(0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7);
    return _mm512_permutexvar_ps(i ? _mm512_add_epi32(low, _mm512_set1_epi32(LANES / 2)) : low, x);
}

/* 8 x 8 pairs: pairs of 1, 2 and 4 rows change sides. */
static inline void pairs_transpose(vec to[PAIRS], const vec from[PAIRS])
{
    __m512d a[PAIRS], b[PAIRS];
    for (int i = 0; i < 4; i++) {
        const __m512d x = _mm512_castps_pd(from[2 * i]), y = _mm512_castps_pd(from[2 * i + 1]);
        a[i] = _mm512_unpacklo_pd(x, y);     /* points 0 2 4 6 of two levels */
        a[i + 4] = _mm512_unpackhi_pd(x, y); /* points 1 3 5 7 */
    }
    for (int i = 0; i < 8; i += 4) {
        b[i] = _mm512_shuffle_f64x2(a[i], a[i + 1], 0x44);     /* points 0 2, levels 0-3 */
        b[i + 1] = _mm512_shuffle_f64x2(a[i], a[i + 1], 0xEE); /* points 4 6 */
        b[i + 2] = _mm512_shuffle_f64x2(a[i + 2], a[i + 3], 0x44);
        b[i + 3] = _mm512_shuffle_f64x2(a[i + 2], a[i + 3], 0xEE);
    }
    for (int i = 0; i < 8; i++) {
        const int odd = i & 1 ? 4 : 0, high = i >> 2;
        const __m512d x = b[odd + high], y = b[odd + 2 + high];
        to[i] = _mm512_castpd_ps(i & 2 ? _mm512_shuffle_f64x2(x, y, 0xDD)
                                       : _mm512_shuffle_f64x2(x, y, 0x88));
    }
}

#endif
