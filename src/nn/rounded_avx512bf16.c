/* SPDX-License-Identifier: Apache-2.0 */
#include <immintrin.h>

#include "nn/rounded.h"
#include "nn/unroll.h"

/* Blocks as in kernels_avx512.c; each step over k takes two of them. */
enum { LANES = 16, VECTORS = 4, ROWS = 6, PANEL = NN_ROUNDED_PANEL, PAIRS = PANEL / 2 };

typedef __m512 block[ROWS][VECTORS];

#define EACH_ROW    UNROLL for (int i = 0; i < ROWS; i++)
#define EACH_VECTOR UNROLL for (int j = 0; j < n_vectors; j++)

/* The first n features of a panel, row by row, as pairs. */
INLINE void round_rows(const float *x, uint32_t n, uint32_t pairs[ROWS][PAIRS])
{
    EACH_ROW
    {
        const float *row = x + i * PANEL;
        UNROLL for (int half = 0; half < 2; half++, row += 2 * LANES)
        {
            const __m512bh rounded = _mm512_cvtne2ps_pbh(_mm512_load_ps(row + LANES),
                                                         _mm512_load_ps(row));
            _mm512_store_si512(pairs[i] + half * LANES, (__m512i)rounded);
        }
        if (n % 2) pairs[i][n / 2] &= 0xFFFF; /* what follows the last may be anything */
    }
}

INLINE void forward_panel(const int n_vectors, const struct nn_forward *a, const float *w,
                          const float *b, float *y)
{
    const __m512 slope = _mm512_set1_ps(a->linear ? 1.0f : NN_SLOPE);
    for (size_t r = 0; r < a->n_rows; r += ROWS) {
        block sum;
        const float *wk = w;
        EACH_ROW EACH_VECTOR sum[i][j] = _mm512_load_ps(b + j * LANES);
        for (uint32_t k = 0; k < a->n_in; k += PANEL) {
            uint32_t pairs[ROWS][PAIRS] __attribute__((aligned(64)));
            const uint32_t n = a->n_in - k < PANEL ? a->n_in - k : PANEL;
            round_rows(a->x + k / PANEL * a->stride + r * PANEL, n, pairs);
            UNROLL_BY4 for (uint32_t p = 0; p < (n + 1) / 2; p++, wk += PANEL)
            {
                __m512bh weights[VECTORS];
                EACH_VECTOR weights[j] = (__m512bh)_mm512_load_si512(wk + j * LANES);
                EACH_ROW
                {
                    const __m512bh x = (__m512bh)_mm512_set1_epi32((int)pairs[i][p]);
                    EACH_VECTOR sum[i][j] = _mm512_dpbf16_ps(sum[i][j], x, weights[j]);
                }
            }
        }
        float *to = y + r * PANEL;
        EACH_ROW EACH_VECTOR _mm512_store_ps(
            to + i * PANEL + j * LANES, _mm512_max_ps(sum[i][j], _mm512_mul_ps(sum[i][j], slope)));
    }
}

static void forward(const struct nn_forward *a)
{
    for (uint32_t first = 0; first < a->n_out; first += PANEL) {
        const float *w = a->w + first / PANEL * nn_rounded_count(a->n_in), *b = a->b + first;
        float *y = a->y + first / PANEL * a->stride;
        if (a->n_out - first <= LANES) /* outputs; lanes past the end may be written */
            forward_panel(1, a, w, b, y);
        else
            forward_panel(VECTORS, a, w, b, y);
    }
}

static double peak(uint64_t n)
{
    enum { CHAINS = ROWS * VECTORS };
    __m512 chain[CHAINS];
    const __m512bh f = (__m512bh)_mm512_set1_epi32(0x3E803E80); /* 1/4 twice */
    UNROLL for (int j = 0; j < CHAINS; j++) chain[j] = _mm512_set1_ps((float)j);
    UNROLL_BY4 for (uint64_t i = 0; i < n; i++)
    {
        UNROLL for (int j = 0; j < CHAINS; j++) chain[j] = _mm512_dpbf16_ps(chain[j], f, f);
    }
    volatile float total = 0.0f;
    UNROLL for (int j = 0; j < CHAINS; j++) total = total + _mm512_reduce_add_ps(chain[j]);
    return 4.0 * LANES * CHAINS * (double)n;
}

const struct nn_rounded nn_rounded_avx512bf16 = {
    .name = "avx512bf16", .forward = forward, .peak = peak};
