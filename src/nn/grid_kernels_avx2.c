/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/grid_kernels.h"

#include <immintrin.h>

#define LANES 8
#define PAIRS 4

typedef __m256 vec;
typedef __m256i ivec;
typedef __m128i half;
typedef __m256i vec_mask;

#define vec_load(from)              _mm256_loadu_ps(from)
#define vec_store(to, x)            _mm256_storeu_ps(to, x)
#define vec_load_part(from, mask)   _mm256_maskload_ps(from, mask)
#define vec_store_part(to, mask, x) _mm256_maskstore_ps(to, mask, x)
#define vec_gather(from, at)        _mm256_i32gather_ps(from, at, 4)
#define vec_set1(x)                 _mm256_set1_ps(x)
#define vec_fma(a, b, c)            _mm256_fmadd_ps(a, b, c)
#define vec_mul(a, b)               _mm256_mul_ps(a, b)
#define vec_sub(a, b)               _mm256_sub_ps(a, b)
#define vec_min(a, b)               _mm256_min_ps(a, b)
#define vec_max(a, b)               _mm256_max_ps(a, b)
#define vec_to_ivec(x)              _mm256_cvttps_epi32(x)
#define ivec_to_vec(x)              _mm256_cvtepi32_ps(x)
#define ivec_count()                _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)
#define ivec_set1(x)                _mm256_set1_epi32(x)
#define ivec_min(a, b)              _mm256_min_epi32(a, b)
#define ivec_mul(a, b)              _mm256_mullo_epi32(a, b)

#define half_set1(x)      _mm_set1_epi32(x)
#define half_add(a, b)    _mm_add_epi32(a, b)
#define half_mul(a, b)    _mm_mullo_epi32(a, b)
#define half_or(a, b)     _mm_or_si128(a, b)
#define half_xor(a, b)    _mm_xor_si128(a, b)
#define half_store(to, x) _mm_storeu_si128((__m128i *)(void *)(to), x)
#define half_first(x)     ((uint32_t)_mm_cvtsi128_si32(x))
/* (a ^ b) & mask */
#define half_xor_and(a, b, mask) _mm_and_si128(_mm_xor_si128(a, b), mask)
/* Bits that differ from the first point's, and whether there are none. */
#define half_differs(x) _mm_xor_si128(x, _mm_broadcastd_epi32(x))
#define half_is_same(x) _mm_testz_si128(x, x)

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

static inline half ivec_half(ivec x, int i)
{
    return i ? _mm256_extracti128_si256(x, 1) : _mm256_castsi256_si128(x);
}

/* The pairs at entries. */
static inline vec pairs_gather(const float *from, half entry)
{
    return _mm256_castpd_ps(_mm256_i32gather_pd((const double *)(const void *)from, entry, 8));
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
