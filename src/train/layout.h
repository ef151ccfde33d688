/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_LAYOUT_H
#define TRAIN_LAYOUT_H

#include "nn/field.h"
#include "nn/generator.h"

/*
 * Where the generator's layers lie in its block of weights (nn/generator.h has the order), and what
 * a model file calls them: "network.position.weight", "network.first.bias",
 * "network.hidden.0.weight", ..., "network.output.bias".
 */
struct layout_tensor {
    char name[40];
    uint32_t n_out, n_in; /* weight: [n_out][n_in]; bias: [n_out], n_in 0 */
    size_t at, size;      /* floats */
};

uint32_t layout_n_tensors(const struct generator_config *c);

/* The index-th tensor of the block. */
void layout_get(const struct generator_config *c, uint32_t index, struct layout_tensor *out);

/* The same of the compact network: "network.grid.0" [entries][2], ..., "network.layer.0.weight",
 * "network.layer.0.bias", ..., "network.output.bias". */
uint32_t layout_field_n_tensors(const struct field_config *c);
void layout_field_get(const struct field_config *c, uint32_t index, struct layout_tensor *out);
size_t layout_field_n_weights(const struct field_config *c);

/*
 * The paper's ablation "without preconditioning" (Sec. 7.3): position has no layer of its own but
 * enters with all other inputs. Done to freshly initialised weights by cutting the position layer
 * off: it and the columns that read it become 0, and the rest of the first layer is scaled to what
 * initialisation gives without them. This is exact: with both sides 0 the gradient of either is 0
 * too, so Adam never moves them.
 */
void layout_cut_position_layer(const struct generator_config *c, float *weights);

#endif
