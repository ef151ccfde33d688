/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/kernels.h"

/*
 * The plain version: what the other kernels must compute, and what runs where there is no AVX2.
 * Loops over the lanes of a panel are left to the compiler to vectorise.
 */

enum { PANEL = 16, ROWS = 4 };

static void forward(const struct nn_forward *a)
{
    for (uint32_t first = 0; first < a->n_out; first += PANEL) {
        const float *w = a->w + (size_t)first * (a->n_in + a->n_q);
        for (uint32_t r = 0; r < a->n_rows; r++) {
            float acc[PANEL];
            for (uint32_t j = 0; j < PANEL; j++) acc[j] = a->b[first + j];
            for (uint32_t k = 0; k < a->n_in; k++) {
                float x = a->x[k / PANEL * a->stride + r * PANEL + k % PANEL];
                for (uint32_t j = 0; j < PANEL; j++) acc[j] += x * w[k * PANEL + j];
            }
            for (uint32_t k = 0; k < a->n_q; k++) {
                float q = a->q[r * PANEL + k];
                for (uint32_t j = 0; j < PANEL; j++) acc[j] += q * w[(a->n_in + k) * PANEL + j];
            }
            float *y = a->y + first / PANEL * a->stride + r * PANEL;
            for (uint32_t j = 0; j < PANEL; j++)
                y[j] = acc[j] > 0.0f || a->linear ? acc[j] : NN_SLOPE * acc[j];
        }
    }
}

static void backward(const struct nn_backward *a)
{
    for (uint32_t first = 0; first < a->n_in; first += PANEL) {
        const float *w = a->w + (size_t)first * a->n_out;
        for (uint32_t r = 0; r < a->n_rows; r++) {
            float acc[PANEL] = {0};
            for (uint32_t k = 0; k < a->n_out; k++) {
                float dy = a->dy[k / PANEL * a->stride + r * PANEL + k % PANEL];
                for (uint32_t j = 0; j < PANEL; j++) acc[j] += dy * w[k * PANEL + j];
            }
            size_t at = first / PANEL * a->stride + r * PANEL;
            for (uint32_t j = 0; j < PANEL; j++)
                a->dh[at + j] = a->h[at + j] > 0.0f ? acc[j] : NN_SLOPE * acc[j];
        }
    }
}

static void outer(const struct nn_outer *a)
{
    for (uint32_t first = 0; first < a->n_in; first += PANEL) {
        const float *x = a->x + first / PANEL * a->stride;
        uint32_t n = a->n_in - first < PANEL ? a->n_in - first : PANEL;
        for (uint32_t o = 0; o < a->n_out; o++) {
            const float *dy = a->dy + o / PANEL * a->stride + o % PANEL;
            float acc[PANEL] = {0};
            for (uint32_t r = 0; r < a->n_rows; r++)
                for (uint32_t j = 0; j < PANEL; j++) acc[j] += dy[r * PANEL] * x[r * PANEL + j];
            float *dw = a->dw + o * a->ld + first;
            for (uint32_t j = 0; j < n; j++) dw[j] = a->accumulate ? dw[j] + acc[j] : acc[j];
        }
    }
}

/* Multiplies and adds apart, as baseline x86-64 has no fused operation. */
static double peak(uint64_t n)
{
    enum { CHAINS = 40 };
    float acc[CHAINS];
    for (int j = 0; j < CHAINS; j++) acc[j] = (float)j;
    volatile float factor = 0.5f;
    float f = factor;
    for (uint64_t i = 0; i < n; i++)
        for (int j = 0; j < CHAINS; j++) acc[j] = acc[j] * f + f;
    volatile float sink = 0.0f;
    for (int j = 0; j < CHAINS; j++) sink = sink + acc[j];
    return 2.0 * CHAINS * (double)n;
}

const struct nn_kernels nn_kernels_ref = {
    .name = "baseline",
    .panel = PANEL,
    .rows = ROWS,
    .forward = forward,
    .backward = backward,
    .outer = outer,
    .peak = peak,
};
