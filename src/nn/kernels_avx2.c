/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/kernels.h"

#include <immintrin.h>

/* AVX2 and FMA: 6 rows x 2 vectors of sums take 12 of the 16 registers, weights and a broadcast
 * three more. */
#define LANES      8
#define VECTORS    2
#define ROWS       6
#define SHORT_ROWS 4

typedef __m256 vec;
typedef __m256i vec_mask;

#define vec_load(from)              _mm256_load_ps(from)
#define vec_store(to, x)            _mm256_store_ps(to, x)
#define vec_set1(x)                 _mm256_set1_ps(x)
#define vec_fma(a, b, c)            _mm256_fmadd_ps(a, b, c)
#define vec_add(a, b)               _mm256_add_ps(a, b)
#define vec_mul(a, b)               _mm256_mul_ps(a, b)
#define vec_max(a, b)               _mm256_max_ps(a, b)
#define vec_load_part(from, mask)   _mm256_maskload_ps(from, mask)
#define vec_store_part(to, mask, x) _mm256_maskstore_ps(to, mask, x)

/* The first n lanes. */
static inline vec_mask vec_mask_first(uint32_t n)
{
    __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    return _mm256_cmpgt_epi32(_mm256_set1_epi32(n < LANES ? (int)n : LANES), lane);
}

/* h > 0 ? x : x * factor */
static inline vec vec_mul_unless_positive(vec x, vec h, vec factor)
{
    vec positive = _mm256_cmp_ps(h, _mm256_setzero_ps(), _CMP_GT_OQ);
    return _mm256_blendv_ps(_mm256_mul_ps(x, factor), x, positive);
}

#include "nn/kernels_blocked.h"

const struct nn_kernels nn_kernels_avx2 = {
    .name = "avx2",
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
