/* SPDX-License-Identifier: Apache-2.0 */
#include <immintrin.h>

#include "nn/rounded.h"
#include "nn/unroll.h"

/* Blocks as in kernels_avx512.c; each step over k takes two of them. */
enum { LANES = 16, VECTORS = 4, ROWS = 6, PANEL = NN_ROUNDED_PANEL };

typedef __m512 block[ROWS][VECTORS];

#define EACH_ROW    UNROLL for (int i = 0; i < ROWS; i++)
#define EACH_VECTOR UNROLL for (int j = 0; j < n_vectors; j++)

/* 2 * LANES floats as pairs. */
INLINE __m512i round_vectors(__m512 low, __m512 high)
{
    return (__m512i)_mm512_cvtne2ps_pbh(high, low);
}

/* One row of outputs, activated and as pairs if another layer follows. */
INLINE void store_row(const int n_vectors, bool linear, const __m512 sum[VECTORS], float *to)
{
    if (linear) {
        EACH_VECTOR _mm512_store_ps(to + j * LANES, sum[j]);
        return;
    }
    const __m512 slope = _mm512_set1_ps(NN_SLOPE);
    __m512 y[VECTORS + 1] = {0};
    EACH_VECTOR y[j] = _mm512_max_ps(sum[j], _mm512_mul_ps(sum[j], slope));
    UNROLL for (int j = 0; j < n_vectors; j += 2)
        _mm512_store_si512(to + j * LANES / 2, round_vectors(y[j], y[j + 1]));
}

INLINE void forward_panel(const int n_vectors, const bool linear, const struct nn_forward *a,
                          const float *w, const float *b, float *y)
{
    for (size_t r = 0; r < a->n_rows; r += ROWS) {
        block sum;
        const float *wk = w;
        EACH_ROW EACH_VECTOR sum[i][j] = _mm512_load_ps(b + j * LANES);
        for (uint32_t k = 0; k < a->n_in; k += PANEL) {
            const uint32_t n = a->n_in - k < PANEL ? a->n_in - k : PANEL;
            const float *pairs = a->x + k / PANEL * a->stride + r * PANEL;
            UNROLL_BY4 for (uint32_t p = 0; p < (n + 1) / 2; p++, wk += PANEL)
            {
                __m512bh weights[VECTORS];
                EACH_VECTOR weights[j] = (__m512bh)_mm512_load_si512(wk + j * LANES);
                EACH_ROW
                {
                    const __m512bh pair = (__m512bh)_mm512_set1_ps(pairs[i * PANEL + p]);
                    EACH_VECTOR sum[i][j] = _mm512_dpbf16_ps(sum[i][j], pair, weights[j]);
                }
            }
        }
        EACH_ROW store_row(n_vectors, linear, sum[i], y + (r + (size_t)i) * PANEL);
    }
}

INLINE void forward_layer(const bool linear, const struct nn_forward *a)
{
    for (uint32_t first = 0; first < a->n_out; first += PANEL) {
        const float *w = a->w + first / PANEL * nn_rounded_count(a->n_in), *b = a->b + first;
        float *y = a->y + first / PANEL * a->stride;
        if (a->n_out - first <= LANES) /* outputs; lanes past the end may be written */
            forward_panel(1, linear, a, w, b, y);
        else
            forward_panel(VECTORS, linear, a, w, b, y);
    }
}

static void forward(const struct nn_forward *a)
{
    if (a->linear)
        forward_layer(true, a);
    else
        forward_layer(false, a);
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
    .name = "avx512bf16",
    .forward = forward,
    .grids = &grid_rounded_avx512bf16,
    .peak = peak,
};
