/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/generator.h"

#include <math.h>

#include "base/mem.h"
#include "base/pool.h"
#include "base/rng.h"
#include "nn/loss.h"
#include "nn/network.h"

enum {
    TILE_ROWS =
        344, /* 0.7 MiB of each layer at width 512: two of them fit the second-level cache */
    MIN_GROUPS = 4,
    MAX_GROUPS = 32,
    GROUPS_SIZE = 192 << 20, /* bytes that sums of gradients may take above MIN_GROUPS */
};

static uint32_t round_up(uint32_t n, uint32_t to)
{
    return (n + to - 1) / to * to;
}

/* Takes `count` zeroed floats and counts them. */
static lmn_status take(struct generator *g, size_t count, float **out, struct error *err)
{
    *out = mem_new(count, sizeof **out);
    if (!*out) return fail_memory(err, "the network's workspace");
    g->memory_size += count * sizeof **out;
    return LMN_OK;
}

static lmn_status take_worker(struct generator *g, struct worker *w, struct error *err)
{
    lmn_status status = LMN_OK;
    uint32_t side = g->config.patch_size, area = side * side;
    size_t panel_size = g->stride, n_features = (size_t)g->n_layers * g->width_padded;
    TRY(take(g, g->n_tiles * panel_size, &w->q, err));
    TRY(take(g, g->n_tiles * g->n_kept * g->tile_size, &w->h, err));
    TRY(take(g, panel_size, &w->y, err));
    TRY(take(g, g->kernels.scratch_count(g->tile_rows, g->config.width), &w->scratch, err));
    if (side == 0) goto done;
    TRY(take(g, n_features, &w->bias, err));
    TRY(take(g, 2 * g->tile_size, &w->dh, err));
    TRY(take(g, panel_size, &w->dy, err));
    TRY(take(g, n_features * Q_GRADIENT, &w->dq, err));
    TRY(take(g, (size_t)N_OUT * area, &w->f, err));
    TRY(take(g, (size_t)N_OUT * area, &w->t, err));
    TRY(take(g, (size_t)N_OUT * area, &w->df, err));
    TRY(take(g, loss_scratch_count(side), &w->loss, err));
done:
    return status;
}

static lmn_status check(const struct generator_config *c, struct error *err)
{
    if (c->width < 1 || c->width > MAX_WIDTH)
        return fail(err, LMN_ERR_ARGUMENT, "network width %u: must be 1 to %d", c->width,
                    MAX_WIDTH);
    if (c->depth > MAX_DEPTH)
        return fail(err, LMN_ERR_ARGUMENT, "network depth %u: must be 0 to %d", c->depth,
                    MAX_DEPTH);
    if (c->n_variables > MAX_VARIABLES)
        return fail(err, LMN_ERR_ARGUMENT, "%u variables: the network takes at most %d",
                    c->n_variables, MAX_VARIABLES);
    if (c->patch_size > MAX_PATCH_SIZE)
        return fail(err, LMN_ERR_ARGUMENT, "patch size %u: must be 1 to %d", c->patch_size,
                    MAX_PATCH_SIZE);
    return LMN_OK;
}

static void choose_sizes(struct generator *g)
{
    uint32_t rows = g->kernels.rows, panel = g->kernels.panel;
    uint32_t area = g->config.patch_size * g->config.patch_size;
    g->n_tiles = area > 0 ? (area + TILE_ROWS - 1) / TILE_ROWS : 1;
    g->tile_rows = round_up(area > 0 ? (area + g->n_tiles - 1) / g->n_tiles : TILE_ROWS, rows);
    g->n_kept = area > 0 ? g->n_layers - 1 : 2;
    g->stride = (size_t)(g->tile_rows + 1) *
                panel; /* one row more, so that panels do not collide */
    g->tile_size = nn_n_panels(&g->kernels, g->config.width) * g->stride;

    size_t fit = GROUPS_SIZE / (g->n_weights * sizeof(float));
    g->n_groups = MAX_GROUPS;
    while (g->n_groups > MIN_GROUPS && g->n_groups > fit) g->n_groups /= 2;
    g->n_workers = pool_n_workers(g->pool);
    g->n_gradients = g->n_groups > g->n_workers ? g->n_groups : g->n_workers;
}

lmn_status generator_new(const struct generator_config *config, struct pool *pool, uint32_t cpu,
                         struct generator **out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct generator *g = NULL;
    *out = NULL;
    TRY(check(config, err));
    g = mem_new(1, sizeof *g);
    if (!g) {
        status = fail_memory(err, "the network");
        goto done;
    }
    g->config = *config;
    g->pool = pool;
    nn_kernels_init(&g->kernels, cpu);
    network_shape(g);
    choose_sizes(g);

    TRY(take(g, g->n_weights, &g->weights, err));
    TRY(take(g, g->n_packed, &g->packed, err));
    TRY(take(g, (size_t)g->n_layers * g->width_padded, &g->frame_bias, err));
    if (config->patch_size > 0) TRY(take(g, g->n_gradients * g->n_weights, &g->gradients, err));
    g->workers = mem_new(g->n_workers, sizeof *g->workers);
    if (!g->workers) {
        status = fail_memory(err, "the network's workers");
        goto done;
    }
    for (uint32_t i = 0; i < g->n_workers; i++) TRY(take_worker(g, &g->workers[i], err));
    *out = g;
    g = NULL;
done:
    generator_free(g);
    return status;
}

void generator_free(struct generator *g)
{
    if (!g) return;
    for (uint32_t i = 0; g->workers && i < g->n_workers; i++) {
        struct worker *w = &g->workers[i];
        float *blocks[] = {w->q,  w->h,  w->scratch, w->y, w->bias, w->dh,
                           w->dy, w->dq, w->f,       w->t, w->df,   w->loss};
        for (size_t j = 0; j < sizeof blocks / sizeof *blocks; j++) mem_free(blocks[j]);
    }
    mem_free(g->workers);
    mem_free(g->gradients);
    mem_free(g->frame_bias);
    mem_free(g->packed);
    mem_free(g->weights);
    mem_free(g);
}

void generator_init(struct generator *g, uint64_t seed)
{
    for (uint32_t l = 0; l < g->n_layers; l++) {
        const struct layer *layer = &g->layers[l];
        float bound = 1.0f / sqrtf((float)layer->n_columns);
        for (uint32_t o = 0; o < layer->n_out; o++) {
            struct rng r = rng_keyed(seed, l, o);
            float *row = g->weights + layer->w_at + (size_t)o * layer->n_columns;
            for (uint32_t k = 0; k < layer->n_columns; k++)
                row[k] = bound * (2.0f * rng_float(&r) - 1.0f);
            g->weights[layer->b_at + o] = bound * (2.0f * rng_float(&r) - 1.0f);
        }
    }
    generator_weights_changed(g);
}

size_t generator_n_weights(const struct generator *g)
{
    return g->n_weights;
}

float *generator_weights(struct generator *g)
{
    return g->weights;
}

void generator_weights_changed(struct generator *g)
{
    network_pack(g);
}

uint64_t generator_memory_size(const struct generator *g)
{
    return g->memory_size;
}

/* ---- Rendering ---- */

struct frame {
    const struct generator *g;
    const float *inputs;
    float *out;
    size_t n_pixels;
};

static void render_tile(void *ctx, uint32_t item, uint32_t worker)
{
    const struct frame *frame = ctx;
    const struct generator *g = frame->g;
    const struct worker *w = &g->workers[worker];
    size_t first = (size_t)item * g->tile_rows, rest = frame->n_pixels - first;
    uint32_t n = rest < g->tile_rows ? (uint32_t)rest : g->tile_rows;
    const float *inputs = frame->inputs + first * GENERATOR_INPUTS;
    float *out = frame->out + first * N_OUT;

    uint32_t n_rows = network_load(g, inputs, n, w->q);
    network_forward(g, w, g->frame_bias, n_rows, w->q, w->h, 2);
    for (uint32_t r = 0; r < n; r++) {
        for (uint32_t c = 0; c < N_OUT; c++) {
            float le = inputs[r * GENERATOR_INPUTS + c], e = le != 0.0f ? log1pf(le) : 0.0f;
            float y = w->y[(size_t)r * g->kernels.panel + c];
            out[r * N_OUT + c] = e > 1.0f ? le : expm1f(y + e);
        }
    }
}

void generator_render(const struct generator *g, const float *inputs, const float *v,
                      size_t n_pixels, float *out)
{
    struct frame frame = {.g = g, .inputs = inputs, .out = out, .n_pixels = n_pixels};
    network_bias(g, v, g->frame_bias);
    pool_run(g->pool, (uint32_t)((n_pixels + g->tile_rows - 1) / g->tile_rows), render_tile,
             &frame);
}

/* ---- Training ---- */

struct pass {
    struct generator *g;
    const struct generator_batch *batch;
    const struct generator_loss *loss;
    const struct adam *adam;
    float *losses, *norms, *gradient;
    uint32_t n_groups;
    float scale; /* of the gradient: 1 / patches in the mean */
};

static uint32_t tile_n(const struct generator *g, uint32_t tile)
{
    uint32_t area = g->config.patch_size * g->config.patch_size, first = tile * g->tile_rows;
    return area - first < g->tile_rows ? area - first : g->tile_rows;
}

/* Forward: fills w's q, h, f and t. Where emission wins, f does not depend on the network. */
static void patch_forward(const struct generator *g, struct worker *w, const float *inputs,
                          const float *targets, const float *v)
{
    uint32_t area = g->config.patch_size * g->config.patch_size, panel = g->kernels.panel;
    network_bias(g, v, w->bias);
    for (uint32_t tile = 0; tile < g->n_tiles; tile++) {
        uint32_t n = tile_n(g, tile), first = tile * g->tile_rows;
        float *q = w->q + tile * g->stride, *h = w->h + tile * g->n_kept * g->tile_size;
        uint32_t n_rows = network_load(g, inputs + (size_t)first * GENERATOR_INPUTS, n, q);
        network_forward(g, w, w->bias, n_rows, q, h, g->n_kept);
        for (uint32_t r = 0; r < n; r++) {
            for (uint32_t c = 0; c < N_OUT; c++) {
                size_t pixel = first + r;
                float le = inputs[pixel * GENERATOR_INPUTS + c];
                float e = le != 0.0f ? log1pf(le) : 0.0f, y = w->y[(size_t)r * panel + c];
                w->f[c * area + pixel] = e > 1.0f ? e : y + e;
                w->t[c * area + pixel] = targets[pixel * N_OUT + c];
            }
        }
    }
}

/* Backward from w's df: adds scale * gradient to `gradient`, or with `first` overwrites it. */
static void patch_backward(const struct generator *g, struct worker *w, const float *inputs,
                           const float *v, float scale, float *gradient, bool first)
{
    uint32_t area = g->config.patch_size * g->config.patch_size, panel = g->kernels.panel;
    for (uint32_t tile = 0; tile < g->n_tiles; tile++) {
        uint32_t n = tile_n(g, tile), n_rows = round_up(n, g->kernels.rows);
        for (uint32_t r = 0; r < n_rows; r++) {
            for (uint32_t c = 0; c < N_OUT; c++) {
                size_t pixel = (size_t)tile * g->tile_rows + r;
                float le = r < n ? inputs[pixel * GENERATOR_INPUTS + c] : 0.0f;
                bool passes = r < n && !(le != 0.0f && log1pf(le) > 1.0f);
                w->dy[(size_t)r * panel + c] = passes ? scale * w->df[c * area + pixel] : 0.0f;
            }
        }
        network_backward(g, w, n_rows, w->q + tile * g->stride,
                         w->h + tile * g->n_kept * g->tile_size, gradient, first && tile == 0,
                         tile == 0);
    }
    network_backward_rest(g, w, v, gradient, first);
}

/* Loss of one patch, and with gradient != NULL its gradient. */
static void run_patch(const struct pass *p, uint32_t patch, struct worker *w, float *gradient,
                      bool first)
{
    const struct generator *g = p->g;
    const float *inputs = p->batch->inputs[patch], *v = p->batch->v[patch];
    patch_forward(g, w, inputs, p->batch->targets[patch], v);
    p->losses[patch] = (float)loss_patch(g->config.patch_size, p->loss->legacy_ssim, w->f, w->t,
                                         gradient ? w->df : NULL, w->loss);
    if (gradient) patch_backward(g, w, inputs, v, p->scale, gradient, first);
}

static void run_loss(void *ctx, uint32_t item, uint32_t worker)
{
    const struct pass *p = ctx;
    run_patch(p, item, &p->g->workers[worker], NULL, true);
}

static void run_group(void *ctx, uint32_t item, uint32_t worker)
{
    const struct pass *p = ctx;
    struct generator *g = p->g;
    uint64_t n = p->batch->n_patches;
    uint32_t begin = (uint32_t)(item * n / p->n_groups);
    uint32_t end = (uint32_t)((item + 1) * n / p->n_groups);
    for (uint32_t patch = begin; patch < end; patch++)
        run_patch(p, patch, &g->workers[worker], g->gradients + item * g->n_weights,
                  patch == begin);
}

enum { SUM_CHUNK = 1 << 14 };

/* gradient = sum of the groups', in order. */
static void sum_chunk(void *ctx, uint32_t item, uint32_t worker)
{
    const struct pass *p = ctx;
    const struct generator *g = p->g;
    size_t first = (size_t)item * SUM_CHUNK, rest = g->n_weights - first;
    size_t n = rest < SUM_CHUNK ? rest : SUM_CHUNK;
    float *restrict sum = p->gradient + first;
    (void)worker;
    for (size_t i = 0; i < n; i++) sum[i] = 0.0f;
    for (uint32_t group = 0; group < p->n_groups; group++) {
        const float *restrict part = g->gradients + group * g->n_weights + first;
        for (size_t i = 0; i < n; i++) sum[i] += part[i];
    }
}

void generator_gradient(struct generator *g, const struct generator_batch *batch,
                        const struct generator_loss *loss, float *losses, float *gradient)
{
    uint32_t n = batch->n_patches;
    struct pass p = {
        .g = g,
        .batch = batch,
        .loss = loss,
        .losses = losses,
        .gradient = gradient,
        .n_groups = n < g->n_groups ? n : g->n_groups,
        .scale = n > 0 ? 1.0f / (float)n : 0.0f,
    };
    if (!gradient) {
        pool_run(g->pool, n, run_loss, &p);
        return;
    }
    pool_run(g->pool, p.n_groups, run_group, &p);
    pool_run(g->pool, (uint32_t)((g->n_weights + SUM_CHUNK - 1) / SUM_CHUNK), sum_chunk, &p);
}

static double euclidean_norm(const float *x, size_t n)
{
    double sum[4] = {0};
    size_t i = 0;
    for (; i + 4 <= n; i += 4)
        for (size_t j = 0; j < 4; j++) sum[j] += (double)x[i + j] * (double)x[i + j];
    for (; i < n; i++) sum[0] += (double)x[i] * (double)x[i];
    return sqrt(sum[0] + sum[1] + (sum[2] + sum[3]));
}

/* Gradients go to the worker's own place: they do not outlive the item. */
static void probe_patch(void *ctx, uint32_t item, uint32_t worker)
{
    const struct pass *p = ctx;
    struct generator *g = p->g;
    float *gradient = g->gradients + worker * g->n_weights;
    run_patch(p, item, &g->workers[worker], gradient, true);
    p->norms[item] = (float)(p->adam ? adam_step_norm(p->adam, gradient)
                                     : euclidean_norm(gradient, g->n_weights));
}

void generator_probe(struct generator *g, const struct adam *adam,
                     const struct generator_batch *batch, const struct generator_loss *loss,
                     float *losses, float *norms)
{
    struct pass p = {.g = g,
                     .batch = batch,
                     .loss = loss,
                     .adam = adam,
                     .losses = losses,
                     .norms = norms,
                     .scale = 1.0f};
    if (adam && adam->t == 0) {
        for (uint32_t i = 0; i < batch->n_patches; i++) norms[i] = 1.0f;
        pool_run(g->pool, batch->n_patches, run_loss, &p);
        return;
    }
    pool_run(g->pool, batch->n_patches, probe_patch, &p);
}
