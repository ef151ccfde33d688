/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/field_inside.h"

#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "base/mem.h"
#include "base/pool.h"
#include "base/rng.h"

enum { MAX_GRIDS = 64, MAX_FEATURES = 1024, MAX_VARIABLES = 65536, MAX_WIDTH = 512 };

#define TABLE_BOUND 1e-4f
#define LAST_LAYER  0.1f

/* ---- Creation ------------------------------------------------------------------------------- */

static lmn_status check(const struct field_config *c, struct error *err)
{
    const struct {
        const char *name;
        uint32_t value, least, most;
    } rows[] = {
        {"grids", c->n_grids, 0, MAX_GRIDS},
        {"grid levels", c->grid.n_levels, 1, GRID_MAX_LEVELS},
        {"grid log2 size", c->grid.log2_size, 1, GRID_MAX_LOG2_SIZE},
        {"grid base", c->grid.base, 1, 1 << 16},
        {"features", c->n_features, 0, MAX_FEATURES},
        {"variables", c->n_variables, 0, MAX_VARIABLES},
        {"lights", c->n_lights, 1, FIELD_MAX_LIGHTS},
        {"width", c->width, 1, MAX_WIDTH},
        {"depth", c->depth, 1, MAX_DEPTH},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (rows[i].value < rows[i].least || rows[i].value > rows[i].most)
            return fail(err, LMN_ERR_ARGUMENT, "network %s %u: must be %u to %u", rows[i].name,
                        rows[i].value, rows[i].least, rows[i].most);
    if (!(c->grid.growth >= 1.0f && c->grid.growth <= 16.0f))
        return fail(err, LMN_ERR_ARGUMENT, "network grid growth %g: must be 1 to 16",
                    (double)c->grid.growth);
    if (c->n_grids == 0 && c->n_features == 0)
        return fail(err, LMN_ERR_ARGUMENT, "the network has no inputs");
    return LMN_OK;
}

static void shape(struct field *f)
{
    const struct field_config *c = &f->config;
    const struct nn_kernels *t = &f->kernels;
    grid_init(&f->grid, &c->grid);
    f->n_encoded = c->n_grids * f->grid.n_levels * GRID_FEATURES;
    f->n_in = f->n_encoded + c->n_features;
    f->n_table = c->n_grids * f->grid.at[f->grid.n_levels];
    f->n_layers = c->depth + 1;
    f->n_out = c->n_lights * N_COLORS + 1;
    f->width_padded = nn_n_panels(t, c->width) * t->panel;
    size_t at = f->n_table, packed = 0, rounded = 0;
    for (uint32_t l = 0; l < f->n_layers; l++) {
        struct layer *layer = &f->layers[l];
        layer->n_out = l < c->depth ? c->width : f->n_out;
        layer->n_in = l == 0 ? f->n_in : c->width;
        layer->n_columns = layer->n_in + (l == 0 ? c->n_variables : 0);
        layer->w_at = at;
        at += (size_t)layer->n_out * layer->n_columns;
        layer->b_at = at;
        at += layer->n_out;
        layer->forward_at = packed;
        packed += nn_n_panels(t, layer->n_out) * t->forward_count(layer->n_in, 0);
        layer->backward_at = packed;
        packed += nn_n_panels(t, layer->n_in) * t->backward_count(layer->n_out);
        layer->rounded_at = rounded;
        rounded += nn_n_panels(t, layer->n_out) * nn_rounded_count(layer->n_in);
    }
    f->n_rounded = f->rounded ? rounded : 0;
    f->n_weights = at;
    f->n_packed = packed;
    f->tile_rows = round_up(FIELD_PART, t->rows);      /* all layers within the cache */
    f->stride = (size_t)(f->tile_rows + 1) * t->panel; /* panels must not collide in the cache */
    f->tile_size = nn_n_panels(t, c->width) * f->stride;
}

/* Takes `count` zeroed floats and counts them. */
static lmn_status take(struct field *f, size_t count, float **out, struct error *err)
{
    *out = mem_new(count, sizeof **out);
    if (!*out) return fail_memory(err, "the network's workspace");
    f->memory_size += count * sizeof **out;
    return LMN_OK;
}

static lmn_status take_worker(struct field *f, struct worker *w, struct error *err)
{
    lmn_status status = LMN_OK;
    uint32_t most = f->n_in > f->config.width ? f->n_in : f->config.width;
    if (f->n_out > most) most = f->n_out;
    const size_t inputs_size = nn_n_panels(&f->kernels, f->n_in) * f->stride;
    const size_t outputs_size = nn_n_panels(&f->kernels, f->n_out) * f->stride;
    TRY(take(f, inputs_size, &w->e, err));
    TRY(take(f, f->config.depth * f->tile_size, &w->h, err));
    TRY(take(f, outputs_size, &w->y, err));
    TRY(take(f, f->width_padded, &w->bias, err));
    TRY(take(f, f->kernels.scratch_count(f->tile_rows, most), &w->scratch, err));
    if (f->config.max_pixels == 0) goto done;
    TRY(take(f, f->stride, &w->q, err));
    TRY(take(f, (size_t)f->n_layers * f->width_padded * DQ_STRIDE, &w->dq, err));
    TRY(take(f, outputs_size, &w->dy, err));
    TRY(take(f, 2 * f->tile_size, &w->dh, err));
    TRY(take(f, inputs_size, &w->de, err));
done:
    return status;
}

lmn_status field_new(const struct field_config *config, struct pool *pool, uint32_t cpu,
                     struct field **out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct field *f = NULL;
    *out = NULL;
    TRY(check(config, err));
    f = mem_new(1, sizeof *f);
    if (!f) {
        status = fail_memory(err, "the network");
        goto done;
    }
    f->config = *config;
    f->pool = pool;
    nn_kernels_init(&f->kernels, cpu);
    f->rounded = nn_rounded_for(cpu);
    f->grids = grid_kernels_for(cpu);
    shape(f);
    TRY(take(f, f->n_weights, &f->weights, err));
    TRY(take(f, f->n_packed, &f->packed, err));
    TRY(take(f, f->n_rounded + 1, &f->packed_rounded, err));
    TRY(take(f, (f->rounded ? f->n_table / GRID_FEATURES : 0) + 1, &f->pairs, err));
    TRY(take(f, (size_t)f->n_layers * f->width_padded, &f->biases, err));
    TRY(take(f, f->width_padded, &f->frame_bias, err));
    if (config->max_pixels > 0) {
        size_t n_ones = nn_n_panels(&f->kernels, f->n_in) * f->stride;
        TRY(take(f, n_ones, &f->ones, err));
        for (size_t i = 0; i < n_ones; i++) f->ones[i] = 1.0f;
        f->encoded_rows = (size_t)config->max_pixels + 24;
        TRY(take(f, f->encoded_rows * f->n_encoded, &f->d_encoded, err));
        TRY(take(f, MAX_GROUPS * (f->n_weights - f->n_table), &f->gradients, err));
    }
    f->workers = mem_new(pool_n_workers(pool), sizeof *f->workers);
    if (!f->workers) {
        status = fail_memory(err, "the network's workers");
        goto done;
    }
    f->n_workers = pool_n_workers(pool);
    for (uint32_t i = 0; i < f->n_workers; i++) TRY(take_worker(f, &f->workers[i], err));
    *out = f;
    f = NULL;
done:
    field_free(f);
    return status;
}

void field_free(struct field *f)
{
    if (!f) return;
    for (uint32_t i = 0; i < f->n_workers; i++) {
        struct worker *w = &f->workers[i];
        float *blocks[] = {w->e, w->h, w->y, w->bias, w->scratch, w->q, w->dq, w->dy, w->dh, w->de};
        for (size_t j = 0; j < sizeof blocks / sizeof *blocks; j++) mem_free(blocks[j]);
    }
    mem_free(f->workers);
    mem_free(f->gradients);
    mem_free(f->d_encoded);
    mem_free(f->ones);
    mem_free(f->frame_bias);
    mem_free(f->biases);
    mem_free(f->packed);
    mem_free(f->packed_rounded);
    mem_free(f->pairs);
    mem_free(f->weights);
    mem_free(f);
}

void field_init(struct field *f, uint64_t seed)
{
    struct rng r = rng_keyed(seed, f->n_layers, 0);
    for (size_t i = 0; i < f->n_table; i++)
        f->weights[i] = TABLE_BOUND * (2.0f * rng_float(&r) - 1.0f);
    for (uint32_t l = 0; l < f->n_layers; l++) {
        const struct layer *layer = &f->layers[l];
        const bool is_last = l + 1 == f->n_layers;
        float bound = (is_last ? LAST_LAYER : 1.0f) / sqrtf((float)layer->n_columns);
        for (uint32_t o = 0; o < layer->n_out; o++) {
            r = rng_keyed(seed, l, o);
            float *row = f->weights + layer->w_at + (size_t)o * layer->n_columns;
            for (uint32_t k = 0; k < layer->n_columns; k++)
                row[k] = bound * (2.0f * rng_float(&r) - 1.0f);
            f->weights[layer->b_at + o] = is_last ? 0.0f : bound * (2.0f * rng_float(&r) - 1.0f);
        }
    }
    field_weights_changed(f);
}

uint32_t field_n_variables(const struct field *f)
{
    return f->config.n_variables;
}

size_t field_n_weights(const struct field *f)
{
    return f->n_weights;
}

size_t field_n_table_weights(const struct field *f)
{
    return f->n_table;
}

float *field_weights(struct field *f)
{
    return f->weights;
}

uint64_t field_memory_size(const struct field *f)
{
    return f->memory_size;
}

void field_weights_changed(struct field *f)
{
    const struct nn_kernels *t = &f->kernels;
    f->is_rounded = false;
    for (uint32_t l = 0; l < f->n_layers; l++) {
        const struct layer *layer = &f->layers[l];
        const float *w = f->weights + layer->w_at;
        const size_t forward = t->forward_count(layer->n_in, 0);
        const size_t backward = t->backward_count(layer->n_out);
        memcpy(f->biases + (size_t)l * f->width_padded, f->weights + layer->b_at,
               layer->n_out * sizeof *f->biases);
        for (uint32_t i = 0; i < nn_n_panels(t, layer->n_out); i++)
            t->pack_forward(f->packed + layer->forward_at + i * forward, w, layer->n_columns,
                            layer->n_out, layer->n_in, 0, i);
        for (uint32_t i = 0; i < nn_n_panels(t, layer->n_in); i++)
            t->pack_backward(f->packed + layer->backward_at + i * backward, w, layer->n_columns,
                             layer->n_out, layer->n_in, i);
    }
}

/* ---- Forward -------------------------------------------------------------------------------- */

void field_fold(const struct field *f, const float *v, float *bias)
{
    const struct layer *layer = &f->layers[0];
    enum { LANES = 8 }; /* sums side by side, for vectors */
    const uint32_t n = f->config.n_variables;
    for (uint32_t o = 0; o < layer->n_out; o++) {
        const float *row = f->weights + layer->w_at + (size_t)o * layer->n_columns + layer->n_in;
        float sums[LANES] = {f->weights[layer->b_at + o]}, sum = 0.0f;
        uint32_t k = 0;
        for (; k + LANES <= n; k += LANES)
            for (uint32_t i = 0; i < LANES; i++) sums[i] += row[k + i] * v[k + i];
        for (; k < n; k++) sums[k % LANES] += row[k] * v[k];
        for (uint32_t i = 0; i < LANES; i++) sum += sums[i];
        bias[o] = sum;
    }
}

uint32_t field_load(const struct field *f, const struct field_run *run, uint32_t first, uint32_t n,
                    const struct nn_rounded *rounded, float *e)
{
    const uint32_t n_grids = f->config.n_grids, n_features = f->config.n_features;
    const uint32_t n_rows = round_up(n, f->kernels.rows), panel = f->kernels.panel;
    const struct grid_kernels *grids = rounded ? rounded->grids : f->grids;
    const float *table = rounded ? f->pairs : f->weights;
    const size_t table_size = f->grid.at[f->grid.n_levels] / (rounded ? GRID_FEATURES : 1);
    for (uint32_t g = 0; g < n_grids; g++) {
        const struct grid_encode a = {
            .grid = &f->grid,
            .table = table + g * table_size,
            .positions = run->positions + ((size_t)first * n_grids + g) * 3,
            .pitch = 3 * (size_t)n_grids,
            .n = n,
            .first = g * f->grid.n_levels * GRID_FEATURES,
            .tile = e,
            .stride = f->stride,
            .panel = panel,
        };
        grids->encode(&a);
    }
    const struct grid_spread a = {
        .rows = n_features > 0 ? run->features + (size_t)first * n_features : NULL,
        .n = n,
        .count = n_features,
        .first = f->n_encoded,
        .tile = e,
        .stride = f->stride,
        .panel = panel,
    };
    if (n_features > 0) grids->spread(&a);
    for (uint32_t k = 0; k < nn_n_panels(&f->kernels, f->n_in); k++)
        memset(e + k * f->stride + (size_t)n * panel, 0, (size_t)(n_rows - n) * panel * sizeof *e);
    return n_rows;
}

void field_forward(const struct field *f, const struct worker *w, const float *bias,
                   uint32_t n_rows, const struct nn_rounded *rounded)
{
    for (uint32_t l = 0; l < f->n_layers; l++) {
        const struct layer *layer = &f->layers[l];
        const bool is_output = l + 1 == f->n_layers;
        struct nn_forward a = {
            .n_rows = n_rows,
            .n_out = layer->n_out,
            .n_in = layer->n_in,
            .x = l == 0 ? w->e : w->h + (l - 1) * f->tile_size,
            .w = rounded ? f->packed_rounded + layer->rounded_at : f->packed + layer->forward_at,
            .b = l == 0 ? bias : f->biases + (size_t)l * f->width_padded,
            .y = is_output ? w->y : w->h + l * f->tile_size,
            .stride = f->stride,
            .linear = is_output,
            .scratch = w->scratch,
        };
        if (rounded)
            rounded->forward(&a);
        else
            f->kernels.forward(&a);
    }
}

void field_outputs(const struct field *f, const struct worker *w, uint32_t first, uint32_t count,
                   uint32_t n, float *o, float *values)
{
    const uint32_t panel = f->kernels.panel;
    for (uint32_t k = 0; k < count;) { /* panel by panel */
        const uint32_t room = panel - (first + k) % panel, rest = count - k;
        const uint32_t some = rest < room ? rest : room;
        const float *from = w->y + place(f, 0, first + k);
        float *to = o + k;
        for (uint32_t r = 0; r < n; r++, from += panel, to += count)
            for (uint32_t i = 0; i < some; i++) to[i] = from[i];
        k += some;
    }
    f->kernels.exponentials(o, n * count, values);
}

static void pack_rounded(struct field *f)
{
    nn_rounded_pack_pairs(f->pairs, f->weights, f->n_table / GRID_FEATURES);
    for (uint32_t l = 0; l < f->n_layers; l++) {
        const struct layer *layer = &f->layers[l];
        for (uint32_t i = 0; i < nn_n_panels(&f->kernels, layer->n_out); i++)
            nn_rounded_pack(
                f->packed_rounded + layer->rounded_at + i * nn_rounded_count(layer->n_in),
                f->weights + layer->w_at, layer->n_columns, layer->n_out, layer->n_in, i);
    }
    f->is_rounded = true;
}

void field_begin(struct field *f, const float *v, bool may_round)
{
    f->rounds = may_round && f->rounded;
    if (f->rounds && !f->is_rounded) pack_rounded(f);
    field_fold(f, v, f->frame_bias);
    for (uint32_t i = 0; i < f->n_workers; i++)
        f->workers[i].encode_ticks = f->workers[i].layer_ticks = 0;
}

void field_ticks(const struct field *f, uint64_t *encode, uint64_t *layers)
{
    *encode = *layers = 0;
    for (uint32_t i = 0; i < f->n_workers; i++) {
        *encode += f->workers[i].encode_ticks;
        *layers += f->workers[i].layer_ticks;
    }
}

double field_flop(const struct field *f)
{
    double n = 0.0;
    for (uint32_t l = 0; l < f->n_layers; l++) n += (double)f->layers[l].n_out * f->layers[l].n_in;
    return 2.0 * n;
}

/* values [n][n_lights][3] times the lights' powers, to their sums [n][3] at the start of it. Four
 * numbers at a time: the fourth, of the next light or pixel, is not used. */
static void sum_lights(float *values, uint32_t n, uint32_t n_lights, const float *powers)
{
    float weights[FIELD_MAX_LIGHTS][4] = {0};
    const float *from = values;
    for (uint32_t l = 0; l < n_lights; l++)
        for (uint32_t c = 0; c < N_COLORS; c++)
            weights[l][c] = powers ? powers[l * N_COLORS + c] : 1.0f;
    for (uint32_t i = 0; i < n; i++, values += N_COLORS) {
        float sum[4] = {0};
        for (uint32_t l = 0; l < n_lights; l++, from += N_COLORS)
            for (uint32_t c = 0; c < 4; c++) sum[c] += weights[l][c] * from[c];
        memcpy(values, sum, N_COLORS * sizeof *sum);
    }
}

void field_render_part(const struct field *f, uint32_t worker, const struct field_run *run,
                       float *out)
{
    struct worker *w = &f->workers[worker];
    const struct nn_rounded *rounded = f->rounds ? f->rounded : NULL;
    const uint32_t n_lights = f->config.n_lights, count = n_lights * N_COLORS;
    float o[MAX_TILE_ROWS * MAX_OUTPUTS], values[MAX_TILE_ROWS * MAX_OUTPUTS];
    for (uint32_t first = 0; first < run->n; first += f->tile_rows) {
        const uint32_t rest = run->n - first, n = rest < f->tile_rows ? rest : f->tile_rows;
        const float *scale = run->scale + (size_t)first * N_COLORS;
        float *to = out + (size_t)first * N_COLORS;
        const uint64_t start = clock_ticks();
        const uint32_t n_rows = field_load(f, run, first, n, rounded, w->e);
        const uint64_t encoded = clock_ticks();
        field_forward(f, w, f->frame_bias, n_rows, rounded);
        field_outputs(f, w, 0, count, n, o, values);
        if (n_lights > 1 || run->lights) sum_lights(values, n, n_lights, run->lights);
        for (uint32_t i = 0; i < n * N_COLORS; i++) to[i] = scale[i] * values[i];
        w->encode_ticks += encoded - start;
        w->layer_ticks += clock_ticks() - encoded;
    }
}

struct frame {
    struct field *f;
    const struct field_run *run;
    float *out;
};

static void render_tile(void *ctx, uint32_t item, uint32_t worker)
{
    const struct frame *frame = ctx;
    const struct field *f = frame->f;
    const uint32_t at = item * f->tile_rows, rest = frame->run->n - at;
    const size_t first = at;
    struct field_run part = *frame->run;
    part.n = rest < f->tile_rows ? rest : f->tile_rows;
    part.positions += first * f->config.n_grids * 3;
    if (part.features) part.features += first * f->config.n_features;
    part.scale += first * N_COLORS;
    field_render_part(f, worker, &part, frame->out + first * N_COLORS);
}

void field_render(struct field *f, const struct field_run *run, float *out)
{
    struct frame frame = {.f = f, .run = run, .out = out};
    field_begin(f, run->v, false);
    pool_run(f->pool, (run->n + f->tile_rows - 1) / f->tile_rows, render_tile, &frame);
}

static void expect_run(void *ctx, uint32_t item, uint32_t worker)
{
    const struct frame *frame = ctx;
    const struct field *f = frame->f;
    const struct field_run *run = &frame->run[item];
    const struct worker *w = &f->workers[worker];
    float *out = frame->out, o[MAX_TILE_ROWS];
    for (uint32_t i = 0; i < item; i++) out += frame->run[i].n;
    field_fold(f, run->v, w->bias);
    for (uint32_t first = 0; first < run->n; first += f->tile_rows) {
        const uint32_t n = run->n - first < f->tile_rows ? run->n - first : f->tile_rows;
        field_forward(f, w, w->bias, field_load(f, run, first, n, NULL, w->e), NULL);
        field_outputs(f, w, f->n_out - 1, 1, n, o, out + first);
    }
}

static void group_run(void *ctx, uint32_t item, uint32_t worker)
{
    const struct frame *frame = ctx;
    const struct field *f = frame->f;
    const struct field_run *run = &frame->run[item];
    const struct worker *w = &f->workers[worker];
    const uint32_t count = f->config.n_lights * N_COLORS;
    float *out = frame->out, o[MAX_TILE_ROWS * MAX_OUTPUTS];
    for (uint32_t i = 0; i < item; i++) out += (size_t)frame->run[i].n * count;
    field_fold(f, run->v, w->bias);
    for (uint32_t first = 0; first < run->n; first += f->tile_rows) {
        const uint32_t n = run->n - first < f->tile_rows ? run->n - first : f->tile_rows;
        float *values = out + (size_t)first * count;
        field_forward(f, w, w->bias, field_load(f, run, first, n, NULL, w->e), NULL);
        field_outputs(f, w, 0, count, n, o, values);
        for (uint32_t i = 0; i < n * count; i++)
            values[i] *= run->scale[(size_t)(first + i / count) * N_COLORS + i % N_COLORS];
    }
}

void field_render_groups(struct field *f, const struct field_run *runs, uint32_t n_runs,
                         float *groups)
{
    struct frame frame = {.f = f, .run = runs, .out = groups};
    pool_run(f->pool, n_runs, group_run, &frame);
}

void field_expect(struct field *f, const struct field_run *runs, uint32_t n_runs, float *expected)
{
    struct frame frame = {.f = f, .run = runs, .out = expected};
    pool_run(f->pool, n_runs, expect_run, &frame);
}
