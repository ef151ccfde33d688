/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/grid_kernels.h"

#include <immintrin.h>

#define LANES 16
#define PAIRS 8

typedef __m512 vec;
typedef __m512i ivec;
typedef __m256i half;
typedef __mmask16 vec_mask;

#define vec_load(from)              _mm512_loadu_ps(from)
#define vec_store(to, x)            _mm512_storeu_ps(to, x)
#define vec_load_part(from, mask)   _mm512_maskz_loadu_ps(mask, from)
#define vec_store_part(to, mask, x) _mm512_mask_storeu_ps(to, mask, x)
#define vec_gather(from, at)        _mm512_i32gather_ps(at, from, 4)
#define vec_set1(x)                 _mm512_set1_ps(x)
#define vec_fma(a, b, c)            _mm512_fmadd_ps(a, b, c)
#define vec_mul(a, b)               _mm512_mul_ps(a, b)
#define vec_sub(a, b)               _mm512_sub_ps(a, b)
#define vec_min(a, b)               _mm512_min_ps(a, b)
#define vec_max(a, b)               _mm512_max_ps(a, b)
#define vec_to_ivec(x)              _mm512_cvttps_epi32(x)
#define ivec_to_vec(x)              _mm512_cvtepi32_ps(x)
#define ivec_set1(x)                _mm512_set1_epi32(x)
#define ivec_min(a, b)              _mm512_min_epi32(a, b)
#define ivec_mul(a, b)              _mm512_mullo_epi32(a, b)

#define half_set1(x)      _mm256_set1_epi32(x)
#define half_add(a, b)    _mm256_add_epi32(a, b)
#define half_mul(a, b)    _mm256_mullo_epi32(a, b)
#define half_or(a, b)     _mm256_or_si256(a, b)
#define half_xor(a, b)    _mm256_xor_si256(a, b)
#define half_store(to, x) _mm256_storeu_si256((__m256i *)(void *)(to), x)
#define half_first(x)     ((uint32_t)_mm256_cvtsi256_si32(x))
/* (a ^ b) & mask */
#define half_xor_and(a, b, mask) _mm256_ternarylogic_epi32(a, b, mask, 0x28)
/* Bits that differ from the first point's, and whether there are none. */
#define half_differs(x) _mm256_xor_si256(x, _mm256_broadcastd_epi32(_mm256_castsi256_si128(x)))
#define half_is_same(x) _mm256_testz_si256(x, x)

/* 0, 1, 2 and so on. */
static inline ivec ivec_count(void)
{
    return _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
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

static inline half ivec_half(ivec x, int i)
{
    return i ? _mm512_extracti64x4_epi64(x, 1) : _mm512_castsi512_si256(x);
}

/* The pairs at entries. */
static inline vec pairs_gather(const float *from, half entry)
{
    return _mm512_castpd_ps(_mm512_i32gather_pd(entry, from, 8));
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

#include "nn/grid_lanes.h"

const struct grid_kernels grid_kernels_avx512 = {
    .name = "avx512", .encode = encode, .back = back, .spread = spread};
