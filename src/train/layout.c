/* SPDX-License-Identifier: Apache-2.0 */
#include "train/layout.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { N_Q = GENERATOR_INPUTS - 3 }; /* all inputs but emission */

uint32_t layout_n_tensors(const struct generator_config *c)
{
    return 2 * (c->depth + 3);
}

void layout_get(const struct generator_config *c, uint32_t index, struct layout_tensor *out)
{
    uint32_t layer = index / 2, last = c->depth + 2;
    uint32_t n_columns = c->width + N_Q + c->n_variables;
    bool is_bias = index & 1;
    *out = (struct layout_tensor){.n_out = layer == last ? 3 : c->width,
                                  .n_in = layer == 0 ? 3 : n_columns};

    const char *kind = is_bias ? "bias" : "weight";
    if (layer == 0)
        snprintf(out->name, sizeof out->name, "network.position.%s", kind);
    else if (layer == 1)
        snprintf(out->name, sizeof out->name, "network.first.%s", kind);
    else if (layer == last)
        snprintf(out->name, sizeof out->name, "network.output.%s", kind);
    else
        snprintf(out->name, sizeof out->name, "network.hidden.%u.%s", layer - 2, kind);

    if (layer > 0) { /* the position layer, then equal ones */
        out->at = 4 * (size_t)c->width;
        out->at += (layer - 1) * ((size_t)c->width * n_columns + c->width);
    }
    if (is_bias) {
        out->at += (size_t)out->n_out * out->n_in;
        out->n_in = 0;
    }
    out->size = (size_t)out->n_out * (is_bias ? 1 : out->n_in);
}

uint32_t layout_field_n_tensors(const struct field_config *c)
{
    return c->n_grids + 2 * (c->depth + 1);
}

void layout_field_get(const struct field_config *c, uint32_t index, struct layout_tensor *out)
{
    struct grid grid;
    grid_init(&grid, &c->grid);
    const size_t table = grid.at[grid.n_levels];
    *out = (struct layout_tensor){.n_in = GRID_FEATURES};
    if (index < c->n_grids) {
        snprintf(out->name, sizeof out->name, "network.grid.%u", index);
        out->n_out = (uint32_t)(table / GRID_FEATURES);
        out->at = index * table;
        out->size = table;
        return;
    }
    const uint32_t layer = (index - c->n_grids) / 2,
                   n_first = c->n_grids * grid.n_levels * GRID_FEATURES + c->n_features +
                             c->n_variables;
    const bool is_bias = (index - c->n_grids) & 1;
    const char *kind = is_bias ? "bias" : "weight";
    out->n_out = layer == c->depth ? 3 * c->n_lights + 1 : c->width;
    out->n_in = layer == 0 ? n_first : c->width;
    if (layer == c->depth)
        snprintf(out->name, sizeof out->name, "network.output.%s", kind);
    else
        snprintf(out->name, sizeof out->name, "network.layer.%u.%s", layer, kind);
    out->at = c->n_grids * table;
    if (layer > 0) out->at += (size_t)c->width * (n_first + 1);
    if (layer > 1) out->at += (layer - 1) * (size_t)c->width * (c->width + 1);
    if (is_bias) {
        out->at += (size_t)out->n_out * out->n_in;
        out->n_in = 0;
    }
    out->size = (size_t)out->n_out * (is_bias ? 1 : out->n_in);
}

size_t layout_field_n_weights(const struct field_config *c)
{
    struct layout_tensor last;
    layout_field_get(c, layout_field_n_tensors(c) - 1, &last);
    return last.at + last.size;
}

void layout_cut_position_layer(const struct generator_config *c, float *weights)
{
    struct layout_tensor w, b;
    layout_get(c, 2, &w);
    layout_get(c, 3, &b);
    memset(weights, 0, w.at * sizeof *weights);
    float scale = sqrtf((float)w.n_in / (float)(w.n_in - c->width)); /* U(+-1/sqrt(fan in)) */
    for (uint32_t row = 0; row < w.n_out; row++) {
        float *columns = weights + w.at + (size_t)row * w.n_in;
        memset(columns, 0, c->width * sizeof *columns);
        for (uint32_t i = c->width; i < w.n_in; i++) columns[i] *= scale;
        weights[b.at + row] *= scale;
    }
}
