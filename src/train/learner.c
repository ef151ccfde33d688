/* SPDX-License-Identifier: Apache-2.0 */
#include "train/learner.h"

#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "base/mem.h"
#include "base/pool.h"
#include "base/rng.h"
#include "scene/assign.h"
#include "train/inputs.h"

/* Keep the random numbers of one seed apart. */
enum {
    STREAM_TRACE = 0x74726163,
    STREAM_PIXELS = 0x70697865,
    STREAM_BATCH = 0x62617463,
    STREAM_WEIGHTS = 0x77656967
};

enum { GRID_LEVELS = 8, GRID_LOG2_SIZE = 15, GRID_BASE = 8, STRIP = 1 << 14 };
#define GRID_GROWTH 1.5f
#define TABLE_RATE  5.0
#define BETA2       0.99
#define EPSILON     1e-12

/* What one worker traces a configuration in; owned. */
struct desk {
    struct view *view;
    struct pixel_at *pixels; /* [n_pixels] */
    float *color, *buffers;  /* [n_pixels][3], [n_pixels][BUFFER_CHANNELS] */
};

/* Pixels of configurations as the network takes them, in a ring; owned. */
struct memory {
    uint64_t n_added;
    uint32_t capacity; /* configurations */
    float *positions, *features, *scale, *targets, *v;
};

struct learner {
    struct workplace place;
    struct learner_options options;
    struct sight sight;
    struct trace_settings trace;
    uint32_t width, height; /* of the pictures */

    struct field *field;
    struct adam tables, layers;
    float *gradient, *average, *kept; /* [n_weights]; kept: aside while the average is shown */

    struct memory memory;
    struct desk *desks;
    uint32_t n_desks;
    struct field_run *runs; /* [n_batch] */
    float *losses;          /* [n_batch] */
    float *u;               /* [n_fresh][n_variables of the scene] */
    struct learner_stats stats;

    /* A strip of a frame. */
    struct view *view;
    float *buffers, *positions, *features, *scale, *v;
};

void learner_options_init(struct learner_options *o)
{
    *o = (struct learner_options){.width = 64,
                                  .depth = 4,
                                  .n_fresh = 64,
                                  .n_pixels = 64,
                                  .spp = 4,
                                  .n_batch = 256,
                                  .memory_mib = 512,
                                  .resolution = 256,
                                  .learning_rate = 2e-3,
                                  .warm_steps = 1000,
                                  .average = 200};
}

/* ---- Creation ------------------------------------------------------------------------------- */

static void *take(struct learner *l, size_t count, size_t size, bool *is_short)
{
    void *block = mem_new(count, size);
    if (block)
        l->stats.memory_bytes += (uint64_t)count * size;
    else
        *is_short = true;
    return block;
}

static lmn_status take_all(struct learner *l, struct error *err)
{
    const struct learner_options *o = &l->options;
    const size_t n_weights = field_n_weights(l->field), n = o->n_pixels;
    const size_t each = (l->sight.n_positions * 3 + l->sight.n_features + 6) * n +
                        l->sight.n_variables;
    struct memory *m = &l->memory;
    bool is_short = false;
    uint64_t capacity = ((uint64_t)o->memory_mib << 20) / (each * sizeof(float));
    m->capacity = capacity < 1u << 24 ? (uint32_t)capacity : 1u << 24;
    if (m->capacity < o->n_fresh)
        return fail(err, LMN_ERR_ARGUMENT, "%u MiB hold no %u configurations", o->memory_mib,
                    o->n_fresh);
    m->positions = take(l, m->capacity * n * l->sight.n_positions * 3, sizeof(float), &is_short);
    m->features = take(l, m->capacity * n * l->sight.n_features, sizeof(float), &is_short);
    m->scale = take(l, m->capacity * n * 3, sizeof(float), &is_short);
    m->targets = take(l, m->capacity * n * 3, sizeof(float), &is_short);
    m->v = take(l, (size_t)m->capacity * l->sight.n_variables, sizeof(float), &is_short);
    l->gradient = take(l, n_weights, sizeof(float), &is_short);
    l->average = take(l, n_weights, sizeof(float), &is_short);
    l->kept = take(l, n_weights, sizeof(float), &is_short);
    l->runs = take(l, o->n_batch, sizeof *l->runs, &is_short);
    l->losses = take(l, o->n_batch, sizeof *l->losses, &is_short);
    l->u = take(l, (size_t)o->n_fresh * l->place.scene->n_variables, sizeof *l->u, &is_short);
    l->buffers = take(l, STRIP, sizeof(float[BUFFER_CHANNELS]), &is_short);
    l->positions = take(l, (size_t)STRIP * l->sight.n_positions * 3, sizeof(float), &is_short);
    l->features = take(l, (size_t)STRIP * l->sight.n_features, sizeof(float), &is_short);
    l->scale = take(l, STRIP, sizeof(float[3]), &is_short);
    l->v = take(l, l->sight.n_variables, sizeof(float), &is_short);
    l->desks = take(l, pool_n_workers(l->place.pool), sizeof *l->desks, &is_short);
    if (is_short) return fail_memory(err, "the learner");
    lmn_status status = view_new(l->place.world, &l->view, err);
    for (uint32_t i = 0; i < pool_n_workers(l->place.pool) && status == LMN_OK; i++) {
        struct desk *d = &l->desks[l->n_desks++];
        d->pixels = take(l, n, sizeof *d->pixels, &is_short);
        d->color = take(l, n, sizeof(float[3]), &is_short);
        d->buffers = take(l, n, sizeof(float[BUFFER_CHANNELS]), &is_short);
        status = is_short ? fail_memory(err, "the learner")
                          : view_new(l->place.world, &d->view, err);
    }
    return status;
}

lmn_status learner_new(const struct workplace *place, const struct learner_options *options,
                       struct learner **out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct learner *l = mem_new(1, sizeof *l);
    *out = NULL;
    if (!l) {
        status = fail_memory(err, "the learner");
        goto done;
    }
    l->place = *place;
    l->options = *options;
    TRY(sight_init(&l->sight, place->scene, err));
    trace_settings_init(&l->trace, place->scene);
    l->trace.spp = options->spp;
    l->trace.splats = false;
    inputs_picture_size(place->scene, options->resolution, 1, &l->width, &l->height);
    const struct field_config config = {
        .n_grids = l->sight.n_positions,
        .grid = {GRID_LEVELS, GRID_LOG2_SIZE, GRID_BASE, GRID_GROWTH},
        .n_features = l->sight.n_features,
        .n_variables = l->sight.n_variables,
        .width = options->width,
        .depth = options->depth,
        .max_pixels = options->n_batch * options->n_pixels};
    TRY(field_new(&config, place->pool, place->cpu, &l->field, err));
    field_init(l->field, rng_mix(options->seed ^ STREAM_WEIGHTS));
    const size_t n_table = field_n_table_weights(l->field);
    TRY(adam_init(&l->tables, n_table, options->learning_rate, err));
    TRY(adam_init(&l->layers, field_n_weights(l->field) - n_table, options->learning_rate, err));
    l->tables.beta2 = l->layers.beta2 = BETA2;
    l->tables.eps = l->layers.eps = EPSILON;
    TRY(take_all(l, err));
    memcpy(l->average, field_weights(l->field), field_n_weights(l->field) * sizeof(float));
    *out = l;
    l = NULL;
done:
    learner_free(l);
    return status;
}

void learner_free(struct learner *l)
{
    if (!l) return;
    for (uint32_t i = 0; i < l->n_desks; i++) {
        view_free(l->desks[i].view);
        mem_free(l->desks[i].pixels);
        mem_free(l->desks[i].color);
        mem_free(l->desks[i].buffers);
    }
    void *const blocks[] = {l->desks,
                            l->gradient,
                            l->average,
                            l->kept,
                            l->memory.features,
                            l->memory.positions,
                            l->memory.scale,
                            l->memory.targets,
                            l->memory.v,
                            l->runs,
                            l->losses,
                            l->u,
                            l->buffers,
                            l->positions,
                            l->features,
                            l->scale,
                            l->v};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) mem_free(blocks[i]);
    view_free(l->view);
    adam_release(&l->tables);
    adam_release(&l->layers);
    field_free(l->field);
    sight_release(&l->sight);
    mem_free(l);
}

/* ---- Tracing -------------------------------------------------------------------------------- */

/* What surfaces scatter: the radiance without what they emit themselves. */
static void set_targets(const float *color, const float *buffers, uint32_t n, float *targets)
{
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t c = 0; c < 3; c++) {
            float y = color[3 * i + c] - buffers[(size_t)i * BUFFER_CHANNELS + BUFFER_EMISSION + c];
            targets[3 * i + c] = y > 0.0f && isfinite(y) ? y : 0.0f;
        }
}

static void trace_configuration(void *ctx, uint32_t item, uint32_t worker)
{
    struct learner *l = ctx;
    struct desk *d = &l->desks[worker];
    struct memory *m = &l->memory;
    const uint32_t n = l->options.n_pixels;
    const uint64_t serial = m->n_added + item;
    const size_t slot = serial % m->capacity, first = slot * n;
    float *u = l->u + (size_t)item * l->place.scene->n_variables;
    scene_random_units(l->place.scene, l->options.seed, serial, u);
    struct rng r = rng_keyed(l->options.seed ^ STREAM_PIXELS, serial, 0);
    for (uint32_t i = 0; i < n; i++)
        d->pixels[i] = (struct pixel_at){rng_below(&r, l->width), rng_below(&r, l->height)};
    struct trace_settings t = l->trace;
    t.seed = rng_keyed(l->options.seed ^ STREAM_TRACE, serial, 0).state;
    struct trace_output output = {.color = d->color, .buffers = d->buffers};
    view_set(d->view, u);
    view_trace_pixels(d->view, &t, l->width, l->height, d->pixels, n, &output);
    sight_look(&l->sight, view_state(d->view), d->buffers, n,
               m->positions + first * l->sight.n_positions * 3,
               m->features + first * l->sight.n_features, m->scale + 3 * first);
    set_targets(d->color, d->buffers, n, m->targets + 3 * first);
    sight_variables(&l->sight, u, m->v + slot * l->sight.n_variables);
}

/* ---- Learning ------------------------------------------------------------------------------- */

static struct field_run run_of(const struct learner *l, uint32_t slot)
{
    const struct memory *m = &l->memory;
    const uint32_t n = l->options.n_pixels;
    const size_t first = (size_t)slot * n;
    return (struct field_run){.n = n,
                              .positions = m->positions + first * l->sight.n_positions * 3,
                              .features = m->features + first * l->sight.n_features,
                              .scale = m->scale + 3 * first,
                              .targets = m->targets + 3 * first,
                              .v = m->v + (size_t)slot * l->sight.n_variables};
}

/* New configurations are learnt at once; the rest of the batch is drawn from memory. */
static void draw_batch(struct learner *l)
{
    struct memory *m = &l->memory;
    struct rng r = rng_keyed(l->options.seed ^ STREAM_BATCH, l->stats.step, 0);
    const uint32_t n_held = m->n_added < m->capacity ? (uint32_t)m->n_added : m->capacity;
    for (uint32_t i = 0; i < l->options.n_batch; i++) {
        uint64_t fresh = m->n_added - 1 - i;
        l->runs[i] = run_of(l, i < l->options.n_fresh ? (uint32_t)(fresh % m->capacity)
                                                      : rng_below(&r, n_held));
    }
}

static void step_weights(struct learner *l)
{
    const size_t n = field_n_weights(l->field), n_table = field_n_table_weights(l->field);
    const double step = (double)l->stats.step, warm = l->options.warm_steps;
    float *w = field_weights(l->field);
    l->layers.learning_rate = l->options.learning_rate / sqrt(1.0 + step / warm);
    l->tables.learning_rate = TABLE_RATE * l->layers.learning_rate;
    adam_step(&l->tables, l->place.pool, w, l->gradient);
    adam_step(&l->layers, l->place.pool, w + n_table, l->gradient + n_table);
    field_weights_changed(l->field);
    const double memory = fmin(l->options.average, 1.0 + 0.1 * step);
    const float share = (float)(1.0 / memory);
    for (size_t i = 0; i < n; i++) l->average[i] += share * (w[i] - l->average[i]);
}

lmn_status learner_step(struct learner *l, struct learner_stats *stats, struct error *err)
{
    const double threads = pool_n_workers(l->place.pool);
    const double start = clock_cpu_s();
    pool_run(l->place.pool, l->options.n_fresh, trace_configuration, l);
    l->memory.n_added += l->options.n_fresh;
    const double traced = clock_cpu_s();
    draw_batch(l);
    field_gradient(l->field, l->runs, l->options.n_batch, l->losses, l->gradient);
    double sum = 0;
    for (uint32_t i = 0; i < l->options.n_batch; i++) sum += (double)l->losses[i];
    if (!isfinite(sum))
        return fail(err, LMN_ERR_ARGUMENT,
                    "training came apart at step %llu: the loss is not a number; a lower learning "
                    "rate may help",
                    (unsigned long long)l->stats.step);
    step_weights(l);
    l->stats.step++;
    l->stats.loss = sum / l->options.n_batch;
    l->stats.n_configurations += l->options.n_fresh;
    l->stats.n_pixels += (uint64_t)l->options.n_fresh * l->options.n_pixels;
    l->stats.trace_s += (traced - start) / threads;
    l->stats.network_s += (clock_cpu_s() - traced) / threads;
    if (stats) *stats = l->stats;
    return LMN_OK;
}

/* ---- Frames --------------------------------------------------------------------------------- */

static void show_average(struct learner *l, bool is_shown)
{
    const size_t size = field_n_weights(l->field) * sizeof(float);
    float *w = field_weights(l->field);
    if (is_shown) memcpy(l->kept, w, size);
    memcpy(w, is_shown ? l->average : l->kept, size);
    field_weights_changed(l->field);
}

lmn_status learner_render(struct learner *l, const float *u, uint32_t width, uint32_t height,
                          uint32_t buffer_spp, float *out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct trace_settings t = l->trace;
    t.spp = buffer_spp;
    t.seed = 0;
    if (width > STRIP) return fail(err, LMN_ERR_ARGUMENT, "no frame is wider than %d", (int)STRIP);
    view_set(l->view, u);
    sight_variables(&l->sight, u, l->v);
    show_average(l, true);
    const uint32_t most = STRIP / width;
    for (uint32_t y = 0; y < height && status == LMN_OK; y += most) {
        const struct window w = {width, height, 0, y, width, height - y < most ? height - y : most};
        const uint32_t n = w.width * w.height;
        struct trace_output output = {.buffers = l->buffers};
        status = view_trace_parallel(l->view, l->place.pool, &t, &w, &output, NULL, NULL, err);
        if (status != LMN_OK) break;
        sight_look(&l->sight, view_state(l->view), l->buffers, n, l->positions, l->features,
                   l->scale);
        const struct field_run run = {.n = n,
                                      .positions = l->positions,
                                      .features = l->features,
                                      .scale = l->scale,
                                      .v = l->v};
        float *rows = out + 3 * (size_t)y * width;
        field_render(l->field, &run, rows);
        for (uint32_t i = 0; i < n; i++)
            for (uint32_t c = 0; c < 3; c++)
                rows[3 * (size_t)i + c] +=
                    l->buffers[(size_t)i * BUFFER_CHANNELS + BUFFER_EMISSION + c];
    }
    show_average(l, false);
    return status;
}
