/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_FIELD_INSIDE_H
#define NN_FIELD_INSIDE_H

#include "nn/field.h"
#include "nn/grid_kernels.h"
#include "nn/rounded.h"
#include "nn/kernels.h"

/* The inside of struct field, for field.c and field_train.c. */

enum {
    N_COLORS = 3,
    MAX_DEPTH = 16,
    MAX_GROUPS = 16,     /* of runs, whose gradients are summed apart */
    MAX_TILE_ROWS = 160, /* at least FIELD_PART rounded up to any kernel's rows */
    DQ_STRIDE = 16       /* floats per output in worker.dq */
};

/* y = W x + b. The first layer has further columns for v. */
struct layer {
    uint32_t n_out, n_in, n_columns;
    size_t w_at, b_at;              /* floats into the block of weights */
    size_t forward_at, backward_at; /* floats into field.packed */
    size_t rounded_at;              /* floats into field.packed_rounded */
};

/* What one thread works in; see kernels.h for the layout of a tile. */
struct worker {
    float *e;                           /* tile of the inputs */
    float *h;                           /* [depth] tiles */
    float *y;                           /* tile of the outputs */
    float *bias;                        /* [width_padded]: b1 + columns of v */
    float *scratch;                     /* the kernels' own */
    uint64_t encode_ticks, layer_ticks; /* of field_render_part() */

    /* Training only. */
    float *q;  /* one panel whose first lane is 1: the gradient of its weights is the biases' */
    float *dq; /* [depth + 1][width_padded][DQ_STRIDE]: of the run alone */
    float *dy; /* tile of the outputs */
    float *dh; /* 2 tiles */
    float *de; /* tile of what the grids gave */
};

struct field {
    struct field_config config;
    struct grid grid;
    struct nn_kernels kernels;
    const struct nn_rounded *rounded; /* of pictures; NULL: `kernels` */
    const struct grid_kernels *grids;
    struct pool *pool;
    uint64_t memory_size;

    uint32_t n_out;           /* of the last layer */
    uint32_t n_encoded, n_in; /* numbers that grids give; inputs of the first layer but v */
    uint32_t n_layers;
    struct layer layers[MAX_DEPTH + 1];
    size_t n_table, n_weights, n_packed, n_rounded; /* n_table: of all grids */
    float *weights, *packed, *packed_rounded;
    float *pairs;      /* [n_table / 2]: of all grids, where there is `rounded` */
    bool rounds;       /* since field_begin() */
    bool is_rounded;   /* packed_rounded and pairs are of these weights */
    float *biases;     /* [n_layers][width_padded] */
    float *frame_bias; /* [width_padded]: of field_begin() */

    uint32_t width_padded, tile_rows;
    size_t stride;    /* floats from panel to panel of a tile */
    size_t tile_size; /* floats of a tile of `width` features */
    uint32_t n_workers;
    struct worker *workers;

    /* Training only. */
    float *ones;         /* a tile of them: the inputs have no activation */
    float *d_encoded;    /* [n_grids * n_levels][encoded_rows][GRID_FEATURES] */
    size_t encoded_rows; /* max_pixels and some, as a power of 2 would collide in the cache */
    float *gradients;    /* [MAX_GROUPS][weights of layers] */
};

static inline uint32_t round_up(uint32_t n, uint32_t to)
{
    return (n + to - 1) / to * to;
}

/* Where a tile has it. */
static inline size_t place(const struct field *f, uint32_t row, uint32_t feature)
{
    const uint32_t panel = f->kernels.panel;
    return feature / panel * f->stride + (size_t)row * panel + feature % panel;
}

/* Outputs of a tile's first n rows, `count` of them from `first` on: o [n][count], and values
 * [n][count] = exp(o) within bounds. */
enum { MAX_OUTPUTS = FIELD_MAX_LIGHTS * N_COLORS + 1 };
void field_outputs(const struct field *f, const struct worker *w, uint32_t first, uint32_t count,
                   uint32_t n, float *o, float *values);

/* The first layer's biases for a configuration: bias [width_padded]. */
void field_fold(const struct field *f, const float *v, float *bias);

/* Inputs of n pixels of a run from `first` on, into a tile, as pairs if `rounded`; rows up to the
 * next multiple of kernels.rows become zero. Returns that multiple. */
uint32_t field_load(const struct field *f, const struct field_run *run, uint32_t first, uint32_t n,
                    const struct nn_rounded *rounded, float *e);

/* One tile forward: w->e and the first layer's biases -> w->h, w->y; rounded or, NULL, not. */
void field_forward(const struct field *f, const struct worker *w, const float *bias,
                   uint32_t n_rows, const struct nn_rounded *rounded);

#endif
