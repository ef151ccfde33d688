/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_KERNELS_H
#define NN_KERNELS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 * The inner loops of the network, one table per instruction set. Every set computes the same
 * products; sums are taken in another order, so results agree to rounding only.
 *
 * A tile holds a few hundred pixels with all their features, cut into panels: `panel` features of
 * one pixel lie together, pixel after pixel, panel after panel.
 *
 *   feature f of row r:  x[(f / panel) * stride + r * panel + f % panel]
 *
 *         panel 0             panel 1              each row of a panel starts a cache line;
 *     r0 [f0 .. f31]      [f32 .. f63]             stride >= capacity * panel, so that kernels step
 *     r1 [f0 .. f31]      [f32 .. f63]             with constants through rows and panels never
 *     ...                 ...                      collide in the cache
 *
 * Forward and backward read a row's features one by one and the weights by vectors, the weight
 * gradient reads both sides as they lie: nothing is ever transposed but the weights, once per step.
 * Lanes beyond the last feature hold zeros or nothing that matters; tables may write them.
 */

#define NN_SLOPE 0.01f /* LeakyReLU's, below zero */

/* y = act(x W^T + q Wq^T + b), act = lrelu or nothing. */
struct nn_forward {
    uint32_t n_rows; /* pixels: a multiple of nn_kernels.rows */
    uint32_t n_out, n_in, n_q;
    const float *x; /* n_in features */
    const float *q; /* n_q features, all in the first panel; not read when n_q is 0 */
    const float *w; /* [panels of n_out][n_in + n_q][panel], see nn_pack_forward() */
    const float *b; /* [n_out rounded up to panels] */
    float *y;       /* n_out features */
    size_t stride;  /* floats from panel to panel, of x and y */
    bool linear;    /* no activation */
};

/* dh = (dy W) o lrelu'(h): what reaches the layer's input h, before h's activation. */
struct nn_backward {
    uint32_t n_rows;
    uint32_t n_out, n_in; /* features of dy; of h and dh */
    const float *dy;
    const float *w; /* [panels of n_in][n_out][panel], see nn_pack_backward() */
    const float *h; /* after its activation: its sign is that of the value before */
    float *dh;
    size_t stride;
};

/* dw (+)= dy^T x, row-major. */
struct nn_outer {
    uint32_t n_rows;
    uint32_t n_out, n_in;
    const float *dy;
    const float *x;
    float *dw; /* [n_out][ld] */
    size_t ld, stride;
    bool accumulate; /* add to dw instead of overwriting it */
};

struct nn_kernels {
    const char *name;
    uint32_t panel; /* features per panel: 16 or 64, so that q fits in one */
    uint32_t rows;  /* tiles hold a multiple of this many rows */
    void (*forward)(const struct nn_forward *a);
    void (*backward)(const struct nn_backward *a);
    void (*outer)(const struct nn_outer *a);
    /* Runs n independent chains of multiply-adds in registers; returns the floating-point
     * operations done. Measures the peak that the others are held against. */
    double (*peak)(uint64_t n);
};

/* Fills the table with the best kernels among `cpu` (flags of base/cpu.h). */
void nn_kernels_init(struct nn_kernels *t, uint32_t cpu);

/* The tables themselves, for tests and benches: the caller checks that the machine has the set. */
extern const struct nn_kernels nn_kernels_ref, nn_kernels_avx2, nn_kernels_avx512;

static inline uint32_t nn_n_panels(const struct nn_kernels *t, uint32_t n)
{
    return (n + t->panel - 1) / t->panel;
}

/* Packs panel `index` of row-major w [n_out][ld] for forward: columns 0 .. n_columns-1 become
 * packed[n_columns][panel], zero in the lanes past n_out. */
void nn_pack_forward(const struct nn_kernels *t, float *packed, const float *w, size_t ld,
                     uint32_t n_out, uint32_t n_columns, uint32_t index);

/* Packs panel `index` of columns for backward: packed[n_out][panel], zero past n_in. */
void nn_pack_backward(const struct nn_kernels *t, float *packed, const float *w, size_t ld,
                      uint32_t n_out, uint32_t n_in, uint32_t index);

#endif
