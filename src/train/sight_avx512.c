/* SPDX-License-Identifier: Apache-2.0 */
#include "train/sight_inside.h"

#include <string.h>

#include <immintrin.h>

#define LANES 16

typedef __m512 vec;
typedef __mmask16 vec_mask; /* lanes' truth, */
typedef __mmask16 vec_tail; /* and how many of them are in use */

#define vec_set1(x)                 _mm512_set1_ps(x)
#define vec_add(a, b)               _mm512_add_ps(a, b)
#define vec_sub(a, b)               _mm512_sub_ps(a, b)
#define vec_mul(a, b)               _mm512_mul_ps(a, b)
#define vec_div(a, b)               _mm512_div_ps(a, b)
#define vec_min(a, b)               _mm512_min_ps(a, b)
#define vec_max(a, b)               _mm512_max_ps(a, b)
#define vec_sqrt(x)                 _mm512_sqrt_ps(x)
#define vec_above(a, b)             _mm512_cmp_ps_mask(a, b, _CMP_GT_OQ)
#define vec_equal(a, b)             _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ)
#define vec_unequal(a, b)           _mm512_cmp_ps_mask(a, b, _CMP_NEQ_UQ)
#define vec_mask_or(a, b)           ((vec_mask)((a) | (b)))
#define vec_where(mask, x)          _mm512_maskz_mov_ps(mask, x)
#define vec_load_part(from, tail)   _mm512_maskz_loadu_ps(tail, from)
#define vec_store_part(to, tail, x) _mm512_mask_storeu_ps(to, tail, x)

/* The first n lanes. */
static inline vec_tail vec_first(uint32_t n)
{
    return n >= LANES ? 0xFFFF : (vec_tail)((1u << n) - 1);
}

/* Pairs of vectors are zipped four times: each time the lanes' numbers turn by a bit. */
static inline void transpose(vec to[LANES], const vec from[LANES])
{
    const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
    const __m512i high = _mm512_add_epi32(low, _mm512_set1_epi32(8));
    vec spare[LANES];
    const vec *a = from;
    for (int pass = 0; pass < 4; pass++) {
        vec *b = pass % 2 ? to : spare;
        for (int i = 0; i < LANES / 2; i++) {
            b[2 * i] = _mm512_permutex2var_ps(a[i], low, a[i + LANES / 2]);
            b[2 * i + 1] = _mm512_permutex2var_ps(a[i], high, a[i + LANES / 2]);
        }
        a = b;
    }
}

#include "train/sight_lanes.h"

void sight_look_avx512(const struct sight_job *j)
{
    look_all(j);
}
