/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_GENERATOR_H
#define NN_GENERATOR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "nn/adam.h"

/*
 * The paper's neural generator (Diolatzis et al. 2022, Sec. 6.1): a per-pixel network from buffers
 * x and configuration v to radiance, in the log1p domain.
 *
 *   h0 = lrelu(Wp p + bp)                        3 -> W     p: position
 *   h1 = lrelu(W1 [h0, q] + b1)            W+13+D -> W     q: normal, position, wi, albedo, alpha,
 * v h(k+1) = lrelu(Wk [hk, q] + bk)        W+13+D -> W     `depth` times y  = Wo [h, q] + bo W+13+D
 * -> 3 E = log1p(Le);  out_c = E_c > 1 ? E_c : y_c + E_c      per channel
 *
 * lrelu has slope 0.01. v is constant over a patch, so Wk's columns for v fold into one bias per
 * patch: exact, in training too.
 *
 * Products and sums are fp32. With AMX (CPU_AMX) products are of numbers split into two BF16 parts:
 * about 16 bits of each, summed in fp32; gradients at width 512 then differ by 5e-6 of their norm.
 * Leave the flag out for fp32 throughout.
 *
 * All weights live in one block, layer after layer: W row-major [n_out][n_in] with columns in the
 * order above, then b [n_out]. That is the order of the checkpoint.
 */

/* What a pixel brings: emission 3 (radiance, linear) | normal 3 | position 3 | wi 3 | albedo 3 |
 * alpha 1. */
enum { GENERATOR_INPUTS = 16 };

struct generator_config {
    uint32_t n_variables; /* D, the length of v: 0 .. 65536 */
    uint32_t width;       /* W, 1 .. 1024 */
    uint32_t depth;       /* hidden layers after h1: the paper's 8; 0 .. 32 */
    uint32_t patch_size;  /* side of training patches: 32; 0: no training, and no memory for it */
};

struct pool;
struct generator;

/* cpu: flags of base/cpu.h that kernels may use. The pool must outlive the generator. All memory
 * that training or rendering needs is taken here. */
lmn_status generator_new(const struct generator_config *config, struct pool *pool, uint32_t cpu,
                         struct generator **out, struct error *err);
void generator_free(struct generator *g);

/* U(+-1/sqrt(fan_in)) for weights and biases, PyTorch's default for Linear. */
void generator_init(struct generator *g, uint64_t seed);

size_t generator_n_weights(const struct generator *g);

/* [n_weights]. Whoever writes to them calls generator_weights_changed() before the next call that
 * uses them. */
float *generator_weights(struct generator *g);
void generator_weights_changed(struct generator *g);
uint64_t generator_memory_size(const struct generator *g); /* bytes */

/* out[n_pixels][3] = expm1(network) >= 0 clamp none: linear radiance. inputs [n_pixels][16], v [D].
 */
void generator_render(const struct generator *g, const float *inputs, const float *v,
                      size_t n_pixels, float *out);

/* Square patches, each with its own v. P = patch_size^2 pixels. */
struct generator_batch {
    uint32_t n_patches;
    const float *const *inputs;  /* [n_patches] -> [P][16] */
    const float *const *targets; /* [n_patches] -> [P][3], log1p of radiance */
    const float *const *v;       /* [n_patches] -> [D] */
};

struct generator_loss {
    bool legacy_ssim; /* the authors' axes: the window slides over (column, colour), rows are
                         channels */
};

/*
 * Mean over patches of  mean(2 |f - t|) + (1 - SSIM(f, t))  on log1p values (11x11 Gaussian of
 * sigma 1.5, C1 = 1e-4, C2 = 9e-4, zero padded), and its exact gradient.
 *
 * losses    [n_patches], each patch's own loss
 * gradient  [n_weights], of the mean over patches; may be NULL
 * The result has the same bytes for any number of threads.
 */
void generator_gradient(struct generator *g, const struct generator_batch *batch,
                        const struct generator_loss *loss, float *losses, float *gradient);

/*
 * For every patch alone: its loss, and the Euclidean norm over all weights of the step that Adam
 * *would* make with that patch's gradient (the target function of the Markov chains, Sec. 4.3), or
 * with adam == NULL the norm of the gradient itself. Before the first step (a->t == 0) norms are 1.
 */
void generator_probe(struct generator *g, const struct adam *adam,
                     const struct generator_batch *batch, const struct generator_loss *loss,
                     float *losses, float *norms);

#endif
