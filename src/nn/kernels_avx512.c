/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/kernels.h"

#include <immintrin.h>

/*
 * AVX-512: 6 rows x 4 vectors of sums take 24 of the 32 registers, with 10 loads for 24
 * multiply-adds. On Sapphire Rapids blocks of 14 x 2 ran 7 % slower, although its two load ports
 * should keep up with both; splitting k so that the weights of a pass fit the first-level cache
 * gained nothing, as the second level streams them.
 */
#define LANES      16
#define VECTORS    4
#define ROWS       6
#define SHORT_ROWS 4

typedef __m512 vec;
typedef __mmask16 vec_mask;

#define vec_load(from)              _mm512_load_ps(from)
#define vec_store(to, x)            _mm512_store_ps(to, x)
#define vec_set1(x)                 _mm512_set1_ps(x)
#define vec_fma(a, b, c)            _mm512_fmadd_ps(a, b, c)
#define vec_add(a, b)               _mm512_add_ps(a, b)
#define vec_mul(a, b)               _mm512_mul_ps(a, b)
#define vec_max(a, b)               _mm512_max_ps(a, b)
#define vec_load_part(from, mask)   _mm512_maskz_loadu_ps(mask, from)
#define vec_store_part(to, mask, x) _mm512_mask_storeu_ps(to, mask, x)

/* The first n lanes. */
static inline vec_mask vec_mask_first(uint32_t n)
{
    return n >= LANES ? 0xFFFF : (vec_mask)((1u << n) - 1);
}

/* h > 0 ? x : x * factor */
static inline vec vec_mul_unless_positive(vec x, vec h, vec factor)
{
    vec_mask low = _mm512_cmp_ps_mask(h, _mm512_setzero_ps(), _CMP_LE_OQ);
    return _mm512_mask_mul_ps(x, low, x, factor);
}

#include "nn/kernels_blocked.h"

const struct nn_kernels nn_kernels_avx512 = {
    .name = "avx512",
    .panel = PANEL,
    .rows = ROWS,
    .forward = forward,
    .backward = backward,
    .outer = outer,
    .exponentials = exponentials,
    .forward_count = forward_count,
    .pack_forward = pack_forward,
    .backward_count = backward_count,
    .pack_backward = pack_backward,
    .scratch_count = scratch_count,
    .peak = peak,
};
