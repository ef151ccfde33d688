/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_NETWORK_H
#define NN_NETWORK_H

#include "nn/generator.h"
#include "nn/kernels.h"

/*
 * The inside of struct generator: the layers' shapes, the memory of a worker, and the passes over a
 * tile of pixels. See kernels.h for the layout of a tile.
 */

enum {
    MAX_WIDTH = 1024,
    MAX_DEPTH = 32,
    MAX_LAYERS = MAX_DEPTH + 3, /* position, first, hidden ..., output */
    MAX_VARIABLES = 65536,
    MAX_PATCH_SIZE = 256,

    N_OUT = 3,
    N_Q = 13,        /* inputs but emission */
    Q_POSITION = 3,  /* where position starts within q */
    Q_ONE = N_Q,     /* a lane that holds 1: its weight gradient is the bias's */
    N_Q_LANES = 14,  /* q and the one */
    Q_GRADIENT = 16, /* floats per output in worker.dq */
};

/* y = W [x, q, v] + b; the position layer has no x and no v and only three columns of q. */
struct layer {
    uint32_t n_out, n_x, n_q;
    uint32_t n_columns;             /* of W in the block of weights: x, q, v */
    size_t w_at, b_at;              /* floats into the block of weights */
    size_t forward_at, backward_at; /* floats into generator.packed */
};

/* What one thread works in. Sizes in floats; `tile` is a panel-wise tile of all features. */
struct worker {
    float *q;       /* [n_tiles][tile_rows * panel] */
    float *h;       /* [n_tiles][n_kept] tiles: the layers' outputs */
    float *y;       /* one panel: the network's output */
    float *bias;    /* [n_layers][width_padded]: b + Wv v of the patch */
    float *scratch; /* the kernels' own */

    /* Training only. */
    float *dh;         /* 2 tiles */
    float *dy;         /* one panel, zero but for its first three lanes */
    float *dq;         /* [n_layers][width_padded][Q_GRADIENT]: of the patch alone */
    float *f, *t, *df; /* [3][P] planes: output, target, gradient of the loss */
    float *loss;       /* loss_patch()'s */
};

struct generator {
    struct generator_config config;
    struct nn_kernels kernels;
    struct pool *pool;
    uint64_t memory_size;

    uint32_t n_layers;
    struct layer layers[MAX_LAYERS];
    size_t n_weights, n_packed;
    float *weights, *packed;

    uint32_t width_padded; /* to whole panels */
    uint32_t tile_rows;    /* most pixels in a tile */
    uint32_t n_tiles;      /* of a patch; 1 without training */
    uint32_t n_kept;       /* layers whose output a tile keeps: all of them, or 2 for rendering */
    size_t stride;         /* floats from panel to panel of a tile */
    size_t tile_size;      /* floats of a tile of `width` features */

    uint32_t n_workers;
    struct worker *workers;
    float *frame_bias; /* worker.bias, of generator_render() */

    /* Training only: sums of gradients over groups of patches. The split into groups depends on
     * the batch and the width alone, so that sums do not depend on the number of threads. */
    uint32_t n_groups, n_gradients; /* n_gradients >= n_workers too, for generator_probe() */
    float *gradients;               /* [n_gradients][n_weights] */
};

/* Fills n_layers, layers, n_weights and n_packed from config and kernels. */
void network_shape(struct generator *g);

/* Packs weights for the kernels; on the pool. */
void network_pack(struct generator *g);

/* bias [n_layers][width_padded] = b + Wv v. */
void network_bias(const struct generator *g, const float *v, float *bias);

/* Fills q of a tile from n pixels of inputs; rows up to the next multiple of kernels.rows become
 * zero. Returns that multiple. */
uint32_t network_load(const struct generator *g, const float *inputs, uint32_t n, float *q);

/* One tile forward: q -> h -> worker's y. h holds n_kept tiles, used in turn. */
void network_forward(const struct generator *g, const struct worker *w, const float *bias,
                     uint32_t n_rows, const float *q, float *h, uint32_t n_kept);

/* One tile backward, from worker's dy: adds to (or with `first` overwrites) the columns of x in
 * `gradient`, and adds to (or with `first_tile` overwrites) worker's dq. */
void network_backward(const struct generator *g, const struct worker *w, uint32_t n_rows,
                      const float *q, const float *h, float *gradient, bool first, bool first_tile);

/* Adds (or with `first` writes) the columns of q and v and the biases from worker's dq. */
void network_backward_rest(const struct generator *g, const struct worker *w, const float *v,
                           float *gradient, bool first);

#endif
