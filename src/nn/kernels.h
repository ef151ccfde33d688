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
 * Concatenated inputs [x, q] are two products into one sum, never a copy. Lanes beyond the last
 * feature hold zeros or nothing that matters; kernels may write them.
 */

#define NN_SLOPE          0.01f  /* LeakyReLU's, below zero */
#define NN_LEAST_EXPONENT -10.0f /* of colours: from 5e-5 */
#define NN_MOST_EXPONENT  12.0f  /* to 2e5 */

/* y = act(x W^T + q Wq^T + b), act = lrelu or nothing. */
struct nn_forward {
    uint32_t n_rows; /* pixels: a multiple of nn_kernels.rows */
    uint32_t n_out, n_in, n_q;
    const float *x; /* n_in features */
    const float *q; /* n_q features, all in the first panel; not read when n_q is 0 */
    const float *w; /* panels of n_out, packed by nn_kernels.pack_forward() */
    const float *b; /* [n_out rounded up to panels] */
    float *y;       /* n_out features */
    size_t stride;  /* floats from panel to panel, of x and y */
    bool linear;    /* no activation */
    float *scratch; /* nn_kernels.scratch_count() floats */
};

/* dh = (dy W) o lrelu'(h): what reaches the layer's input h, before h's activation. */
struct nn_backward {
    uint32_t n_rows;
    uint32_t n_out, n_in; /* features of dy; of h and dh */
    const float *dy;
    const float *w; /* panels of n_in, packed by nn_kernels.pack_backward() */
    const float *h; /* after its activation: its sign is that of the value before */
    float *dh;
    size_t stride;
    float *scratch;
};

/* dw (+)= dy^T x and dq (+)= dy^T q, row-major. */
struct nn_outer {
    uint32_t n_rows;
    uint32_t n_out, n_in, n_q;
    const float *dy;
    const float *x, *q;
    float *dw, *dq; /* [n_out][ld_w], [n_out][ld_q] */
    size_t ld_w, ld_q, stride;
    bool add_w, add_q; /* add instead of overwriting */
    float *scratch;
};

struct nn_kernels {
    const char *name;
    uint32_t panel; /* features per panel: 16, 32 or 64, so that q fits in one */
    uint32_t rows;  /* tiles hold a multiple of this many rows */
    float error;    /* relative error of one product of two numbers; 0: that of float */
    void (*forward)(const struct nn_forward *a);
    void (*backward)(const struct nn_backward *a);
    void (*outer)(const struct nn_outer *a);

    /* y = exp(x) of n numbers, x clipped to the bounds above: colours from the last layer's
     * outputs. */
    void (*exponentials)(const float *x, uint32_t n, float *y);

    /*
     * Weights lie row-major, w [n_out][ld]. pack_forward() packs `index`-th panel of outputs, of
     * columns 0 .. n_in-1 (for x) and n_in .. n_in+n_q-1 (for q); pack_backward() the index-th
     * panel of inputs. The counts say how many floats a packed panel takes.
     */
    size_t (*forward_count)(uint32_t n_in, uint32_t n_q);
    void (*pack_forward)(float *packed, const float *w, size_t ld, uint32_t n_out, uint32_t n_in,
                         uint32_t n_q, uint32_t index);
    size_t (*backward_count)(uint32_t n_out);
    void (*pack_backward)(float *packed, const float *w, size_t ld, uint32_t n_out, uint32_t n_in,
                          uint32_t index);

    /* Floats of scratch for tiles of n_rows and layers of up to n features on both sides. */
    size_t (*scratch_count)(uint32_t n_rows, uint32_t n);

    /* Runs n independent chains of fp32 multiply-adds in registers; returns the floating-point
     * operations done. Measures the peak that the others are held against. */
    double (*peak)(uint64_t n);
};

/* Fills the table with the best kernels among `cpu` (flags of base/cpu.h). */
void nn_kernels_init(struct nn_kernels *t, uint32_t cpu);

/* The tables themselves, for tests and benches: the caller checks that the machine has the set. */
extern const struct nn_kernels nn_kernels_ref, nn_kernels_avx2, nn_kernels_avx512, nn_kernels_amx;

static inline uint32_t nn_n_panels(const struct nn_kernels *t, uint32_t n)
{
    return (n + t->panel - 1) / t->panel;
}

/* The packing of all sets that multiply floats: panels of [n_in + n_q][panel] and [n_out][panel],
 * zero in lanes past the end. */
void nn_pack_forward(uint32_t panel, float *packed, const float *w, size_t ld, uint32_t n_out,
                     uint32_t n_columns, uint32_t index);
void nn_pack_backward(uint32_t panel, float *packed, const float *w, size_t ld, uint32_t n_out,
                      uint32_t n_in, uint32_t index);

#endif
