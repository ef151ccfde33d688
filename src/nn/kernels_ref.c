/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/exponential.h"
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

/* dw (+)= dy^T x */
static void sum_products(const struct nn_outer *a, const float *x, uint32_t n_in, float *dw,
                         size_t ld, bool add)
{
    for (uint32_t first = 0; first < n_in; first += PANEL, x += a->stride) {
        uint32_t n = n_in - first < PANEL ? n_in - first : PANEL;
        for (uint32_t o = 0; o < a->n_out; o++) {
            const float *dy = a->dy + o / PANEL * a->stride + o % PANEL;
            float acc[PANEL] = {0};
            for (uint32_t r = 0; r < a->n_rows; r++)
                for (uint32_t j = 0; j < PANEL; j++) acc[j] += dy[r * PANEL] * x[r * PANEL + j];
            float *to = dw + o * ld + first;
            for (uint32_t j = 0; j < n; j++) to[j] = add ? to[j] + acc[j] : acc[j];
        }
    }
}

static void outer(const struct nn_outer *a)
{
    sum_products(a, a->x, a->n_in, a->dw, a->ld_w, a->add_w);
    sum_products(a, a->q, a->n_q, a->dq, a->ld_q, a->add_q);
}

static void exponentials(const float *x, uint32_t n, float *y)
{
    exponentials_loop(x, n, y);
}

static size_t forward_count(uint32_t n_in, uint32_t n_q)
{
    return (size_t)(n_in + n_q) * PANEL;
}

static void pack_forward(float *packed, const float *w, size_t ld, uint32_t n_out, uint32_t n_in,
                         uint32_t n_q, uint32_t index)
{
    nn_pack_forward(PANEL, packed, w, ld, n_out, n_in + n_q, index);
}

static size_t backward_count(uint32_t n_out)
{
    return (size_t)n_out * PANEL;
}

static void pack_backward(float *packed, const float *w, size_t ld, uint32_t n_out, uint32_t n_in,
                          uint32_t index)
{
    nn_pack_backward(PANEL, packed, w, ld, n_out, n_in, index);
}

static size_t scratch_count(uint32_t n_rows, uint32_t n)
{
    (void)n_rows;
    (void)n;
    return 0;
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
    .exponentials = exponentials,
    .forward_count = forward_count,
    .pack_forward = pack_forward,
    .backward_count = backward_count,
    .pack_backward = pack_backward,
    .scratch_count = scratch_count,
    .peak = peak,
};
