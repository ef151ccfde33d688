/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/network.h"

#include <string.h>

#include "base/pool.h"

void network_shape(struct generator *g)
{
    const struct generator_config *c = &g->config;
    const struct nn_kernels *t = &g->kernels;
    g->n_layers = c->depth + 3;
    g->width_padded = nn_n_panels(t, c->width) * t->panel;
    size_t at = 0, packed = 0;
    for (uint32_t l = 0; l < g->n_layers; l++) {
        struct layer *layer = &g->layers[l];
        bool is_position = l == 0;
        layer->n_out = l + 1 < g->n_layers ? c->width : N_OUT;
        layer->n_x = is_position ? 0 : c->width;
        layer->n_q = is_position ? 3 : N_Q;
        layer->n_columns = layer->n_x + layer->n_q + (is_position ? 0 : c->n_variables);
        layer->w_at = at;
        at += (size_t)layer->n_out * layer->n_columns;
        layer->b_at = at;
        at += layer->n_out;
        layer->forward_at = packed;
        packed += nn_n_panels(t, layer->n_out) * t->forward_count(layer->n_x, layer->n_q);
        layer->backward_at = packed;
        packed += nn_n_panels(t, layer->n_x) * t->backward_count(layer->n_out);
    }
    g->n_weights = at;
    g->n_packed = packed;
}

/* Item: one panel of one layer, forward panels first. */
static void pack_panel(void *ctx, uint32_t item, uint32_t worker)
{
    struct generator *g = ctx;
    const struct nn_kernels *t = &g->kernels;
    uint32_t per_layer = 2 * nn_n_panels(t, g->width_padded);
    const struct layer *layer = &g->layers[item / per_layer];
    uint32_t index = item % per_layer, n_forward = nn_n_panels(t, layer->n_out);
    const float *w = g->weights + layer->w_at;
    (void)worker;
    if (index < n_forward) {
        size_t size = t->forward_count(layer->n_x, layer->n_q);
        t->pack_forward(g->packed + layer->forward_at + index * size, w, layer->n_columns,
                        layer->n_out, layer->n_x, layer->n_q, index);
    } else if (index - n_forward < nn_n_panels(t, layer->n_x)) {
        size_t size = t->backward_count(layer->n_out);
        index -= n_forward;
        t->pack_backward(g->packed + layer->backward_at + index * size, w, layer->n_columns,
                         layer->n_out, layer->n_x, index);
    }
}

void network_pack(struct generator *g)
{
    uint32_t per_layer = 2 * nn_n_panels(&g->kernels, g->width_padded);
    pool_run(g->pool, g->n_layers * per_layer, pack_panel, g);
}

void network_bias(const struct generator *g, const float *v, float *bias)
{
    for (uint32_t l = 0; l < g->n_layers; l++, bias += g->width_padded) {
        const struct layer *layer = &g->layers[l];
        uint32_t first = layer->n_x + layer->n_q;
        for (uint32_t o = 0; o < layer->n_out; o++) {
            const float *row = g->weights + layer->w_at + (size_t)o * layer->n_columns;
            float sum = g->weights[layer->b_at + o];
            for (uint32_t k = first; k < layer->n_columns; k++) sum += row[k] * v[k - first];
            bias[o] = sum;
        }
    }
}

uint32_t network_load(const struct generator *g, const float *inputs, uint32_t n, float *q)
{
    enum { SKIP = GENERATOR_INPUTS - N_Q };
    uint32_t panel = g->kernels.panel, rows = g->kernels.rows,
             n_rows = (n + rows - 1) / rows * rows;
    for (uint32_t r = 0; r < n; r++, q += panel, inputs += GENERATOR_INPUTS) {
        memcpy(q, inputs + SKIP, N_Q * sizeof *q);
        q[Q_ONE] = 1.0f;
    }
    memset(q, 0, (size_t)(n_rows - n) * panel * sizeof *q);
    return n_rows;
}

void network_forward(const struct generator *g, const struct worker *w, const float *bias,
                     uint32_t n_rows, const float *q, float *h, uint32_t n_kept)
{
    for (uint32_t l = 0; l < g->n_layers; l++) {
        const struct layer *layer = &g->layers[l];
        bool is_position = l == 0, is_output = l + 1 == g->n_layers;
        const float *x = is_position ? q : h + (l - 1) % n_kept * g->tile_size;
        struct nn_forward a = {
            .n_rows = n_rows,
            .n_out = layer->n_out,
            .n_in = layer->n_x,
            .n_q = layer->n_q,
            .x = x,
            .q = is_position ? q + Q_POSITION : q,
            .w = g->packed + layer->forward_at,
            .b = bias + (size_t)l * g->width_padded,
            .y = is_output ? w->y : h + l % n_kept * g->tile_size,
            .stride = g->stride,
            .linear = is_output,
            .scratch = w->scratch,
        };
        g->kernels.forward(&a);
    }
}

void network_backward(const struct generator *g, const struct worker *w, uint32_t n_rows,
                      const float *q, const float *h, float *gradient, bool first, bool first_tile)
{
    const float *dy = w->dy;
    for (uint32_t l = g->n_layers; l-- > 0;) {
        const struct layer *layer = &g->layers[l];
        const float *x = l > 0 ? h + (size_t)(l - 1) * g->tile_size : NULL;
        struct nn_outer outer = {
            .n_rows = n_rows,
            .n_out = layer->n_out,
            .n_in = layer->n_x,
            .n_q = N_Q_LANES,
            .dy = dy,
            .x = x,
            .q = q,
            .dw = gradient + layer->w_at,
            .dq = w->dq + (size_t)l * g->width_padded * Q_GRADIENT,
            .ld_w = layer->n_columns,
            .ld_q = Q_GRADIENT,
            .stride = g->stride,
            .add_w = !first,
            .add_q = !first_tile,
            .scratch = w->scratch,
        };
        g->kernels.outer(&outer);
        if (l == 0) return;

        struct nn_backward back = {
            .n_rows = n_rows,
            .n_out = layer->n_out,
            .n_in = layer->n_x,
            .dy = dy,
            .w = g->packed + layer->backward_at,
            .h = x,
            .dh = w->dh + l % 2 * g->tile_size,
            .stride = g->stride,
            .scratch = w->scratch,
        };
        g->kernels.backward(&back);
        dy = back.dh;
    }
}

/* to (+)= from * scale */
static void add_scaled(float *to, const float *from, uint32_t n, float scale, bool overwrite)
{
    for (uint32_t i = 0; i < n; i++) to[i] = overwrite ? scale * from[i] : to[i] + scale * from[i];
}

void network_backward_rest(const struct generator *g, const struct worker *w, const float *v,
                           float *gradient, bool first)
{
    for (uint32_t l = 0; l < g->n_layers; l++) {
        const struct layer *layer = &g->layers[l];
        const float *dq = w->dq + (size_t)l * g->width_padded * Q_GRADIENT;
        for (uint32_t o = 0; o < layer->n_out; o++, dq += Q_GRADIENT) {
            float *row = gradient + layer->w_at + (size_t)o * layer->n_columns + layer->n_x;
            add_scaled(row, l == 0 ? dq + Q_POSITION : dq, layer->n_q, 1.0f, first);
            add_scaled(gradient + layer->b_at + o, dq + Q_ONE, 1, 1.0f, first);
            if (l > 0) add_scaled(row + layer->n_q, v, g->config.n_variables, dq[Q_ONE], first);
        }
    }
}
