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

#define TABLE_RATE 5.0
#define BETA2      0.99
#define EPSILON    1e-12

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

    struct field_config config;
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
};

struct grid_config learner_grid(void)
{
    return (struct grid_config){.n_levels = 8, .log2_size = 15, .base = 8, .growth = 1.5f};
}

void learner_options_init(struct learner_options *o, const lmn_train_options *from)
{
    *o = (struct learner_options){.seed = from->seed,
                                  .width = from->width,
                                  .depth = from->depth,
                                  .n_fresh = 64,
                                  .n_pixels = 64,
                                  .spp = from->spp > 0 ? from->spp : 16,
                                  .n_batch = 128,
                                  .memory_mib = from->memory_mib,
                                  .resolution = from->resolution_max,
                                  .explores = from->explore == LMN_EXPLORE_ACTIVE,
                                  .learning_rate = from->learning_rate,
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
        return fail(err, LMN_ERR_ARGUMENT,
                    "training option memory_mib = %u holds no %u configurations", o->memory_mib,
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
    l->desks = take(l, pool_n_workers(l->place.pool), sizeof *l->desks, &is_short);
    if (is_short) return fail_memory(err, "the learner");
    lmn_status status = LMN_OK;
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
                       const struct trace_settings *trace, struct learner **out, struct error *err)
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
    l->sight.cpu = place->cpu;
    l->trace = *trace;
    l->trace.spp = options->spp;
    l->trace.splats = false;
    l->trace.shares_rays = true; /* targets are the rays' own radiance less their own emission */
    inputs_picture_size(place->scene, options->resolution, 1, &l->width, &l->height);
    l->config = sight_field(&l->sight);
    l->config.grid = learner_grid();
    l->config.width = options->width;
    l->config.depth = options->depth;
    l->config.max_pixels = options->n_batch * options->n_pixels;
    TRY(field_new(&l->config, place->pool, place->cpu, &l->field, err));
    field_init(l->field, rng_mix(options->seed ^ STREAM_WEIGHTS));
    const size_t n_table = field_n_table_weights(l->field);
    TRY(adam_init(&l->tables, n_table, options->learning_rate, err));
    TRY(adam_init(&l->layers, field_n_weights(l->field) - n_table, options->learning_rate, err));
    l->tables.cpu = l->layers.cpu = place->cpu;
    l->tables.beta2 = l->layers.beta2 = BETA2;
    l->tables.eps = l->layers.eps = EPSILON;
    l->stats.memory_bytes = field_memory_size(l->field) +
                            2 * field_n_weights(l->field) * sizeof(float); /* Adam's moments */
    TRY(take_all(l, err));
    memcpy(l->average, field_weights(l->field), field_n_weights(l->field) * sizeof(float));
    l->tables.average = l->average;
    l->layers.average = l->average + n_table;
    *out = l;
    l = NULL;
done:
    learner_free(l);
    return status;
}

void learner_start(struct learner *l)
{
    field_weights_changed(l->field);
    memcpy(l->average, field_weights(l->field), field_n_weights(l->field) * sizeof(float));
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
    void *const blocks[] = {l->desks,        l->gradient,         l->average,
                            l->kept,         l->memory.positions, l->memory.features,
                            l->memory.scale, l->memory.targets,   l->memory.v,
                            l->runs,         l->losses,           l->u};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) mem_free(blocks[i]);
    adam_release(&l->tables);
    adam_release(&l->layers);
    field_free(l->field);
    sight_release(&l->sight);
    mem_free(l);
}

/* ---- Tracing -------------------------------------------------------------------------------- */

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
    sight_targets(d->color, d->buffers, n, m->targets + 3 * first);
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
    const size_t n_table = field_n_table_weights(l->field);
    const double step = (double)l->stats.step, warm = l->options.warm_steps;
    float *w = field_weights(l->field);
    l->layers.learning_rate = l->options.learning_rate / sqrt(1.0 + step / warm);
    l->tables.learning_rate = TABLE_RATE * l->layers.learning_rate;
    l->tables.share = l->layers.share = (float)(1.0 / fmin(l->options.average, 1.0 + 0.1 * step));
    adam_step(&l->tables, l->place.pool, w, l->gradient);
    adam_step(&l->layers, l->place.pool, w + n_table, l->gradient + n_table);
    field_weights_changed(l->field);
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
    if (!isfinite(sum)) {
        l->memory.n_added -= l->options.n_fresh; /* the next step traces the same again */
        return fail(err, LMN_ERR_ARGUMENT,
                    "training came apart at step %llu: the loss is not a number; a lower learning "
                    "rate may help",
                    (unsigned long long)l->stats.step);
    }
    step_weights(l);
    l->stats.step++;
    l->stats.loss = sum / l->options.n_batch;
    l->stats.n_batch = l->options.n_batch;
    l->stats.n_configurations = l->memory.n_added;
    l->stats.trace_s += (traced - start) / threads;
    l->stats.network_s += (clock_cpu_s() - traced) / threads;
    if (stats) *stats = l->stats;
    return LMN_OK;
}

/* ---- What others see ------------------------------------------------------------------------ */

void learner_show_average(struct learner *l, bool is_shown)
{
    const size_t size = field_n_weights(l->field) * sizeof(float);
    float *w = field_weights(l->field);
    if (is_shown) memcpy(l->kept, w, size);
    memcpy(w, is_shown ? l->average : l->kept, size);
    field_weights_changed(l->field);
}

struct painter_network learner_network(const struct learner *l)
{
    return (struct painter_network){.field = l->field, .sight = &l->sight};
}

const struct field_config *learner_field_config(const struct learner *l)
{
    return &l->config;
}

float *learner_average(struct learner *l)
{
    return l->average;
}

void learner_get_stats(const struct learner *l, struct learner_stats *stats)
{
    *stats = l->stats;
}

/* ---- Checkpoints ---------------------------------------------------------------------------- */

uint32_t learner_tensors(struct learner *l, struct tensor *out)
{
    const struct memory *m = &l->memory;
    const uint64_t n = field_n_weights(l->field), n_table = field_n_table_weights(l->field);
    const uint64_t held = m->n_added < m->capacity ? m->n_added : m->capacity;
    const uint64_t n_pixels = l->options.n_pixels;
    const struct tensor list[LEARNER_TENSORS] = {
        {"training.weights", TENSOR_F32, 1, {n}, field_weights(l->field)},
        {"adam.grid.m", TENSOR_F32, 1, {n_table}, l->tables.m},
        {"adam.grid.v", TENSOR_F32, 1, {n_table}, l->tables.v},
        {"adam.layer.m", TENSOR_F32, 1, {n - n_table}, l->layers.m},
        {"adam.layer.v", TENSOR_F32, 1, {n - n_table}, l->layers.v},
        {"memory.positions",
         TENSOR_F32,
         4,
         {held, n_pixels, l->sight.n_positions, 3},
         m->positions},
        {"memory.features", TENSOR_F32, 3, {held, n_pixels, l->sight.n_features}, m->features},
        {"memory.scale", TENSOR_F32, 3, {held, n_pixels, 3}, m->scale},
        {"memory.targets", TENSOR_F32, 3, {held, n_pixels, 3}, m->targets},
        {"memory.v", TENSOR_F32, 2, {held, l->sight.n_variables}, m->v},
    };
    memcpy(out, list, sizeof list);
    return LEARNER_TENSORS;
}

bool learner_set_progress(struct learner *l, uint64_t step, uint64_t n_configurations)
{
    l->stats.step = l->tables.t = l->layers.t = step;
    l->stats.n_configurations = l->memory.n_added = n_configurations;
    return n_configurations == step * l->options.n_fresh;
}

lmn_status learner_restore(struct learner *l, const char *path, struct error *err)
{
    for (size_t i = 0; i < l->tables.n; i++)
        if (l->tables.v[i] < 0)
            return fail(err, LMN_ERR_PARSE, "%s: \"adam.grid.v\" is negative somewhere", path);
    for (size_t i = 0; i < l->layers.n; i++)
        if (l->layers.v[i] < 0)
            return fail(err, LMN_ERR_PARSE, "%s: \"adam.layer.v\" is negative somewhere", path);
    field_weights_changed(l->field);
    return LMN_OK;
}
