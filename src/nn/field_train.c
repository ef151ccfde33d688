/* SPDX-License-Identifier: Apache-2.0 */
/* Loss and gradient of the compact network. */
#include "nn/field_inside.h"

#include <math.h>
#include <string.h>

#include "base/pool.h"

enum { SUM_CHUNK = 1 << 14 };

#define LOSS_EPSILON  0.01f
#define MOST_PULL     12.0f /* of an output, times its caution: 2 is twice the truth, or far less */
#define MOST_SURPRISE 30.0f /* a single bright sample must not upset what is expected */

struct pass {
    struct field *f;
    const struct field_run *runs;
    uint32_t n_runs, n_groups;
    float *losses, *errors, *gradient;
    float scale; /* of the gradient: 1 / numbers in the mean */
};

/* Sums over pixels and channels. */
struct verdict {
    double loss, error;
};

static float luminance(const float *c)
{
    return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
}

/* What a squared error is divided by, where the other half of the samples has luminance y; `share`
 * is y's part in it. */
static float per(float f, float y, float share)
{
    return 1.0f / (f * ((1.0f - share) * f + share * fmaxf(y, 0.0f)) + LOSS_EPSILON);
}

/* Would a step against the gradient take an output further beyond its bounds? */
static bool leads_out(float o, float d)
{
    return (o <= NN_LEAST_EXPONENT && d > 0.0f) || (o >= NN_MOST_EXPONENT && d < 0.0f);
}

/* The loss of a tile's pixels, added to `sum`; its gradient by the outputs, times `scale`, in
 * w->dy. */
static void judge(const struct field *f, const struct worker *w, const struct field_run *run,
                  uint32_t first, uint32_t n, float scale, struct verdict *sum)
{
    const uint32_t n_out = f->n_out, n_parts = n_out - 1;
    float o[MAX_TILE_ROWS * MAX_OUTPUTS], values[MAX_TILE_ROWS * MAX_OUTPUTS];
    static const float zero[N_COLORS];
    field_outputs(f, w, 0, n_out, n, o, values);
    memset(w->dy, 0, nn_n_panels(&f->kernels, n_out) * f->stride * sizeof *w->dy);
    for (uint32_t r = 0; r < n; r++) {
        const float *at = o + r * n_out, *factor = run->scale + (size_t)(first + r) * N_COLORS;
        const float *y = run->targets + (size_t)(first + r) * N_COLORS;
        const float weight = run->weights ? run->weights[first + r] : 1.0f;
        const float *half = run->halves ? run->halves + (size_t)(first + r) * N_COLORS : zero;
        float *part = values + r * n_out, d[MAX_OUTPUTS], value[N_COLORS] = {0}, loss = 0.0f,
              error = 0.0f;
        for (uint32_t k = 0; k < n_parts; k++) {
            part[k] *= factor[k % N_COLORS] * (run->lights ? run->lights[k] : 1.0f);
            value[k % N_COLORS] += part[k];
        }
        const float l = luminance(value), ly = luminance(y), l_half = luminance(half);
        const float caution = run->cautions ? run->cautions[first + r] : FIELD_CAUTION;
        const float share = f->config.ignores_halves ? 0.0f : caution;
        const float per_a = per(l, ly + l_half, share), per_b = per(l, ly - l_half, share);
        const float most = MOST_PULL / caution * scale * weight;
        float pull[N_COLORS];
        for (uint32_t c = 0; c < N_COLORS; c++) {
            const float a = value[c] - (y[c] + half[c]), b = value[c] - (y[c] - half[c]);
            loss += 0.5f * (a * a * per_b + b * b * per_a);
            error += a * b / (l * l + LOSS_EPSILON);
            pull[c] = scale * weight * (a * per_b + b * per_a);
        }
        for (uint32_t k = 0; k < n_parts; k++)
            d[k] = fminf(fmaxf(pull[k % N_COLORS] * part[k], -most), most);
        const float ratio = loss / (N_COLORS * part[n_parts]);
        d[n_parts] = scale * (1.0f - (ratio < MOST_SURPRISE ? ratio : MOST_SURPRISE));
        for (uint32_t k = 0; k < n_out; k++)
            w->dy[place(f, r, k)] = leads_out(at[k], d[k]) ? 0.0f : d[k];
        sum->loss += (double)(weight * loss);
        sum->error += (double)(weight * error);
    }
}

/* What is expected reads the layers below and does not change them. */
static void forget_expectation(const struct field *f, const struct worker *w, uint32_t n_rows)
{
    for (uint32_t r = 0; r < n_rows; r++) w->dy[place(f, r, f->n_out - 1)] = 0.0f;
}

/* From w->dy: adds to (or with `is_first` overwrites) the layers' weights in `gradient`, adds to
 * (or with `is_first_tile` overwrites) w->dq; w->de. */
static void backward(const struct field *f, const struct worker *w, uint32_t n_rows,
                     float *gradient, bool is_first, bool is_first_tile)
{
    const float *dy = w->dy;
    for (uint32_t l = f->n_layers; l-- > 0;) {
        const struct layer *layer = &f->layers[l];
        const float *x = l == 0 ? w->e : w->h + (l - 1) * f->tile_size;
        struct nn_outer outer = {
            .n_rows = n_rows,
            .n_out = layer->n_out,
            .n_in = layer->n_in,
            .n_q = 1,
            .dy = dy,
            .x = x,
            .q = w->q,
            .dw = gradient + (layer->w_at - f->n_table),
            .dq = w->dq + (size_t)l * f->width_padded * DQ_STRIDE,
            .ld_w = layer->n_columns,
            .ld_q = DQ_STRIDE,
            .stride = f->stride,
            .add_w = !is_first,
            .add_q = !is_first_tile,
            .scratch = w->scratch,
        };
        f->kernels.outer(&outer);
        if (l == f->n_layers - 1) forget_expectation(f, w, n_rows);
        if (l == 0 && f->n_encoded == 0) return;
        struct nn_backward back = {
            .n_rows = n_rows,
            .n_out = layer->n_out,
            .n_in = l == 0 ? f->n_encoded : layer->n_in,
            .dy = dy,
            .w = f->packed + layer->backward_at,
            .h = l == 0 ? f->ones : x,
            .dh = l == 0 ? w->de : w->dh + l % 2 * f->tile_size,
            .stride = f->stride,
            .scratch = w->scratch,
        };
        f->kernels.backward(&back);
        dy = back.dh;
    }
}

/* Biases and the columns of v, from w->dq of a run. */
static void backward_rest(const struct field *f, const struct worker *w, const float *v,
                          float *gradient, bool is_first)
{
    for (uint32_t l = 0; l < f->n_layers; l++) {
        const struct layer *layer = &f->layers[l];
        const float *dq = w->dq + (size_t)l * f->width_padded * DQ_STRIDE;
        float *b = gradient + (layer->b_at - f->n_table);
        for (uint32_t o = 0; o < layer->n_out; o++) {
            const float d = dq[(size_t)o * DQ_STRIDE];
            float *row = gradient + (layer->w_at - f->n_table) + (size_t)o * layer->n_columns;
            b[o] = is_first ? d : b[o] + d;
            for (uint32_t k = layer->n_in; k < layer->n_columns; k++)
                row[k] = (is_first ? 0.0f : row[k]) + d * v[k - layer->n_in];
        }
    }
}

/* What reached the grids, level by level, for n pixels of the batch from `pixel` on. */
static void keep_encoded(const struct field *f, const struct worker *w, size_t pixel, uint32_t n)
{
    for (uint32_t item = 0; item < f->config.n_grids * f->grid.n_levels; item++) {
        const float *from = w->de + place(f, 0, item * GRID_FEATURES);
        float *to = f->d_encoded + (item * f->encoded_rows + pixel) * GRID_FEATURES;
        for (uint32_t r = 0; r < n; r++, from += f->kernels.panel, to += GRID_FEATURES)
            memcpy(to, from, sizeof(float[GRID_FEATURES]));
    }
}

/* `pixel`: the run's first in the batch. */
static void pass_run(const struct pass *p, uint32_t index, const struct worker *w, size_t pixel,
                     float *gradient, bool is_first)
{
    const struct field *f = p->f;
    const struct field_run *run = &p->runs[index];
    struct verdict sum = {0};
    field_fold(f, run->v, w->bias);
    for (uint32_t first = 0; first < run->n; first += f->tile_rows) {
        const uint32_t n = run->n - first < f->tile_rows ? run->n - first : f->tile_rows;
        const uint32_t n_rows = field_load(f, run, first, n, NULL, w->e);
        field_forward(f, w, w->bias, n_rows, NULL);
        judge(f, w, run, first, n, p->scale, &sum);
        if (!gradient) continue;
        for (uint32_t r = 0; r < n_rows; r++) w->q[(size_t)r * f->kernels.panel] = r < n;
        backward(f, w, n_rows, gradient, is_first && first == 0, first == 0);
        keep_encoded(f, w, pixel + first, n);
    }
    p->losses[index] = (float)(sum.loss / (N_COLORS * (double)run->n));
    if (p->errors) p->errors[index] = (float)(sum.error / (N_COLORS * (double)run->n));
    if (gradient) backward_rest(f, w, run->v, gradient, is_first);
}

static void run_loss(void *ctx, uint32_t item, uint32_t worker)
{
    const struct pass *p = ctx;
    pass_run(p, item, &p->f->workers[worker], 0, NULL, true);
}

static void run_group(void *ctx, uint32_t item, uint32_t worker)
{
    const struct pass *p = ctx;
    struct field *f = p->f;
    const uint64_t n = p->n_runs;
    uint32_t begin = (uint32_t)(item * n / p->n_groups);
    uint32_t end = (uint32_t)((item + 1) * n / p->n_groups);
    size_t pixel = 0;
    for (uint32_t i = 0; i < begin; i++) pixel += p->runs[i].n;
    for (uint32_t i = begin; i < end; pixel += p->runs[i++].n)
        pass_run(p, i, &f->workers[worker], pixel,
                 f->gradients + item * (f->n_weights - f->n_table), i == begin);
}

/* The gradient of one level of one grid: all pixels, in order. */
static void run_level(void *ctx, uint32_t item, uint32_t worker)
{
    const struct pass *p = ctx;
    const struct field *f = p->f;
    const struct grid *grid = &f->grid;
    const uint32_t g = item / grid->n_levels, level = item % grid->n_levels;
    const float *d = f->d_encoded + item * f->encoded_rows * GRID_FEATURES;
    float *gradient = p->gradient + g * grid->at[grid->n_levels] + grid->at[level];
    (void)worker;
    memset(gradient, 0, (grid->at[level + 1] - grid->at[level]) * sizeof *gradient);
    for (uint32_t i = 0; i < p->n_runs; i++) {
        const struct grid_back a = {
            .grid = grid,
            .level = level,
            .positions = p->runs[i].positions + 3 * (size_t)g,
            .pitch = 3 * (size_t)f->config.n_grids,
            .n = p->runs[i].n,
            .d = d,
            .gradient = gradient,
        };
        f->grids->back(&a);
        d += (size_t)a.n * GRID_FEATURES;
    }
}

/* The layers' gradient: the sum of the groups', in order. */
static void sum_chunk(void *ctx, uint32_t item, uint32_t worker)
{
    const struct pass *p = ctx;
    const struct field *f = p->f;
    const size_t n_layers = f->n_weights - f->n_table, first = (size_t)item * SUM_CHUNK;
    const size_t n = n_layers - first < SUM_CHUNK ? n_layers - first : SUM_CHUNK;
    float *restrict sum = p->gradient + f->n_table + first;
    (void)worker;
    memset(sum, 0, n * sizeof *sum);
    for (uint32_t group = 0; group < p->n_groups; group++) {
        const float *restrict part = f->gradients + group * n_layers + first;
        for (size_t i = 0; i < n; i++) sum[i] += part[i];
    }
}

void field_gradient(struct field *f, const struct field_run *runs, uint32_t n_runs, float *losses,
                    float *errors, float *gradient)
{
    size_t n_pixels = 0;
    for (uint32_t i = 0; i < n_runs; i++) n_pixels += runs[i].n;
    struct pass p = {
        .f = f,
        .runs = runs,
        .n_runs = n_runs,
        .n_groups = n_runs < MAX_GROUPS ? n_runs : MAX_GROUPS,
        .losses = losses,
        .errors = errors,
        .gradient = gradient,
        .scale = n_pixels > 0 ? 1.0f / (N_COLORS * (float)n_pixels) : 0.0f,
    };
    if (!gradient) {
        pool_run(f->pool, n_runs, run_loss, &p);
        return;
    }
    const size_t n_layers = f->n_weights - f->n_table;
    pool_run(f->pool, p.n_groups, run_group, &p);
    pool_run(f->pool, f->config.n_grids * f->grid.n_levels, run_level, &p);
    pool_run(f->pool, (uint32_t)((n_layers + SUM_CHUNK - 1) / SUM_CHUNK), sum_chunk, &p);
}
