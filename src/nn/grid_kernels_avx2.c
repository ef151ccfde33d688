/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/grid_kernels.h"

#include <immintrin.h>

#define LANES 8
#define PAIRS 4

typedef __m256 vec;
typedef __m256i ivec;
typedef __m256i vec_mask;

#define vec_load(from)              _mm256_loadu_ps(from)
#define vec_store(to, x)            _mm256_storeu_ps(to, x)
#define vec_load_part(from, mask)   _mm256_maskload_ps(from, mask)
#define vec_store_part(to, mask, x) _mm256_maskstore_ps(to, mask, x)
#define vec_set1(x)                 _mm256_set1_ps(x)
#define vec_fma(a, b, c)            _mm256_fmadd_ps(a, b, c)
#define vec_mul(a, b)               _mm256_mul_ps(a, b)
#define vec_sub(a, b)               _mm256_sub_ps(a, b)
#define vec_min(a, b)               _mm256_min_ps(a, b)
#define vec_max(a, b)               _mm256_max_ps(a, b)
#define vec_to_ivec(x)              _mm256_cvttps_epi32(x)
#define ivec_to_vec(x)              _mm256_cvtepi32_ps(x)
#define ivec_set1(x)                _mm256_set1_epi32(x)
#define ivec_mul(a, b)              _mm256_mullo_epi32(a, b)

#define ivec_add(a, b)    _mm256_add_epi32(a, b)
#define ivec_xor(a, b)    _mm256_xor_si256(a, b)
#define ivec_store(to, x) _mm256_store_si256((__m256i *)(void *)(to), x)
/* (a ^ b) & mask */
#define ivec_xor_and(a, b, mask) _mm256_and_si256(_mm256_xor_si256(a, b), mask)

/* Points k and k + 4, four numbers each, of which the last is 0. */
static inline vec points_row(const float *from, size_t pitch, uint32_t k, uint32_t last)
{
    const __m128i three = _mm_setr_epi32(-1, -1, -1, 0);
    __m128 point[2];
    for (uint32_t j = 0; j < 2; j++, k += 4)
        point[j] = _mm_maskload_ps(from + (k < last ? k : last) * pitch, three);
    return _mm256_insertf128_ps(_mm256_castps128_ps256(point[0]), point[1], 1);
}

/* x, y and z of points 0 .. LANES - 1; of those past `last` its own. */
static inline void points_load(vec p[3], const float *from, size_t pitch, uint32_t last)
{
    vec row[4];
    for (uint32_t k = 0; k < 4; k++) row[k] = points_row(from, pitch, k, last);
    const __m256d xy[2] = {_mm256_castps_pd(_mm256_unpacklo_ps(row[0], row[1])),
                           _mm256_castps_pd(_mm256_unpacklo_ps(row[2], row[3]))};
    const __m256d z[2] = {_mm256_castps_pd(_mm256_unpackhi_ps(row[0], row[1])),
                          _mm256_castps_pd(_mm256_unpackhi_ps(row[2], row[3]))};
    p[0] = _mm256_castpd_ps(_mm256_unpacklo_pd(xy[0], xy[1]));
    p[1] = _mm256_castpd_ps(_mm256_unpackhi_pd(xy[0], xy[1]));
    p[2] = _mm256_castpd_ps(_mm256_unpacklo_pd(z[0], z[1]));
}

/* A bit for each point whose cell is not that of the point before; the first's says nothing. */
static inline uint32_t ivec_changes(const ivec low[3])
{
    const ivec before = _mm256_setr_epi32(7, 0, 1, 2, 3, 4, 5, 6);
    ivec same = _mm256_set1_epi32(-1);
    for (int a = 0; a < 3; a++)
        same = _mm256_and_si256(
            same, _mm256_cmpeq_epi32(low[a], _mm256_permutevar8x32_epi32(low[a], before)));
    return 0xFFu & ~(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(same));
}

/* The first n lanes. */
static inline vec_mask vec_mask_first(uint32_t n)
{
    __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    return _mm256_cmpgt_epi32(_mm256_set1_epi32(n < LANES ? (int)n : LANES), lane);
}

/* One pair for all points. */
static inline vec pairs_set1(const float *from)
{
    return _mm256_castpd_ps(_mm256_broadcast_sd((const double *)(const void *)from));
}

/* One pair for all points but the first n. */
static inline vec pairs_set_rest(vec x, uint32_t n, const float *from)
{
    const __m256i lane = _mm256_setr_epi64x(0, 1, 2, 3);
    const __m256i rest = _mm256_cmpgt_epi64(lane, _mm256_set1_epi64x((long long)n - 1));
    return _mm256_blendv_ps(x, pairs_set1(from), _mm256_castsi256_ps(rest));
}

/* Each number of one half of the lanes twice. */
static inline vec pairs_repeat(vec x, int i)
{
    return _mm256_permutevar8x32_ps(x, i ? _mm256_setr_epi32(4, 4, 5, 5, 6, 6, 7, 7)
                                         : _mm256_setr_epi32(0, 0, 1, 1, 2, 2, 3, 3));
}

/* 4 x 4 pairs. */
static inline void pairs_transpose(vec to[PAIRS], const vec from[PAIRS])
{
    __m256d a[PAIRS];
    for (int i = 0; i < 2; i++) {
        const __m256d x = _mm256_castps_pd(from[2 * i]), y = _mm256_castps_pd(from[2 * i + 1]);
        a[i] = _mm256_unpacklo_pd(x, y);     /* points 0 2 of two levels */
        a[i + 2] = _mm256_unpackhi_pd(x, y); /* points 1 3 */
    }
    to[0] = _mm256_castpd_ps(_mm256_permute2f128_pd(a[0], a[1], 0x20));
    to[1] = _mm256_castpd_ps(_mm256_permute2f128_pd(a[2], a[3], 0x20));
    to[2] = _mm256_castpd_ps(_mm256_permute2f128_pd(a[0], a[1], 0x31));
    to[3] = _mm256_castpd_ps(_mm256_permute2f128_pd(a[2], a[3], 0x31));
}

#include "nn/grid_lanes.h"

const struct grid_kernels grid_kernels_avx2 = {
    .name = "avx2", .encode = encode, .back = back, .spread = spread};
