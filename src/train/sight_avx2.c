/* SPDX-License-Identifier: Apache-2.0 */
#include "train/sight_inside.h"

#include <string.h>

#include <immintrin.h>

#define LANES 8

typedef __m256 vec;
typedef __m256 vec_mask;  /* lanes' truth, */
typedef __m256i vec_tail; /* and how many of them are in use */

#define vec_set1(x)                 _mm256_set1_ps(x)
#define vec_add(a, b)               _mm256_add_ps(a, b)
#define vec_sub(a, b)               _mm256_sub_ps(a, b)
#define vec_mul(a, b)               _mm256_mul_ps(a, b)
#define vec_div(a, b)               _mm256_div_ps(a, b)
#define vec_min(a, b)               _mm256_min_ps(a, b)
#define vec_max(a, b)               _mm256_max_ps(a, b)
#define vec_sqrt(x)                 _mm256_sqrt_ps(x)
#define vec_above(a, b)             _mm256_cmp_ps(a, b, _CMP_GT_OQ)
#define vec_equal(a, b)             _mm256_cmp_ps(a, b, _CMP_EQ_OQ)
#define vec_unequal(a, b)           _mm256_cmp_ps(a, b, _CMP_NEQ_UQ)
#define vec_mask_or(a, b)           _mm256_or_ps(a, b)
#define vec_where(mask, x)          _mm256_and_ps(mask, x)
#define vec_load_part(from, tail)   _mm256_maskload_ps(from, tail)
#define vec_store_part(to, tail, x) _mm256_maskstore_ps(to, tail, x)

/* The first n lanes. */
static inline vec_tail vec_first(uint32_t n)
{
    return _mm256_cmpgt_epi32(_mm256_set1_epi32(n < LANES ? (int)n : LANES),
                              _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
}

/* Within both halves, then across. */
static inline void transpose(vec to[LANES], const vec from[LANES])
{
    vec a[LANES], b[LANES];
    for (int i = 0; i < LANES; i += 2) {
        a[i] = _mm256_unpacklo_ps(from[i], from[i + 1]);
        a[i + 1] = _mm256_unpackhi_ps(from[i], from[i + 1]);
    }
    for (int i = 0; i < LANES; i += 4) {
        b[i] = _mm256_shuffle_ps(a[i], a[i + 2], 0x44);
        b[i + 1] = _mm256_shuffle_ps(a[i], a[i + 2], 0xEE);
        b[i + 2] = _mm256_shuffle_ps(a[i + 1], a[i + 3], 0x44);
        b[i + 3] = _mm256_shuffle_ps(a[i + 1], a[i + 3], 0xEE);
    }
    for (int i = 0; i < 4; i++) {
        to[i] = _mm256_permute2f128_ps(b[i], b[i + 4], 0x20);
        to[i + 4] = _mm256_permute2f128_ps(b[i], b[i + 4], 0x31);
    }
}

#include "train/sight_lanes.h"

void sight_look_avx2(const struct sight_job *j)
{
    look_all(j);
}
