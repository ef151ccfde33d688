/* SPDX-License-Identifier: Apache-2.0 */
#include "train/learner.h"

#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "base/mem.h"
#include "base/pool.h"
#include "base/rng.h"
#include "scene/assign.h"
#include "train/caustics.h"
#include "train/guide.h"
#include "train/inputs.h"
#include "train/scout.h"
#include "train/tails.h"

/* Keep the random numbers of one seed apart. */
enum {
    STREAM_TRACE = 0x74726163,
    STREAM_BATCH = 0x62617463,
    STREAM_POWERS = 0x706f7765,
    STREAM_WEIGHTS = 0x77656967,
    STREAM_ROOTS = 0x726f6f74,
    STREAM_PHOTONS = 0x70686f74,
    STREAM_GUIDE = 0x67756964,
    STREAM_CHAINS = 0x63686169,
    STREAM_LENGTHS = 0x6c656e67
};

#define SHARP_ROUGHNESS 0.6f
#define TABLE_RATE      5.0
#define BETA2           0.99
#define EPSILON         1e-12

/* Of a path, in surfaces that it would go on to scatter at: what the network's word of its end
 * takes, roots too. Of scenes with less to spare, sphere-caustic (1.5 each) is learnt a twentieth
 * better by whole paths; the bundled scene (2.2) a fiftieth better by ends. */
#define END_COST 2.0

/* What one worker traces a configuration in, and looks at one again; owned. */
struct desk {
    struct view *view;
    struct scene_state state;
    float *u;                /* [variables of the scene] */
    float *color, *groups;   /* [n_pixels][3], [2 n_lights][n_pixels][3] */
    float *buffers;          /* [2][n_pixels][BUFFER_CHANNELS] */
    struct chain_end *ends;  /* [n_pixels], where sight follows chains */
    struct ray *rays;        /* [n_pixels]: behind them, and roots */
    float *bounces;          /* [n_pixels] */
    struct pixel_at *pixels; /* [n_pixels] */
    struct caustics caustics;
    struct guide guide;
};

/* A batch as the network takes it; owned. */
struct batch {
    uint32_t *slots;        /* [n_batch], of the memory */
    struct field_run *runs; /* [n_batch] */
    float *losses, *errors; /* [n_batch] */
    float *positions, *features, *scale, *targets, *halves, *cautions; /* [n_batch][n_pixels].. */
    float *v, *lights;                                                 /* [n_batch].. */
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
    struct scout *scout;
    struct tails *tails; /* NULL: paths are not cut */
    struct desk *desks;
    struct view **views; /* [n_desks], theirs */
    uint32_t n_desks;
    struct batch batch;
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
                                  .n_fresh = 16,
                                  .n_pixels = 64,
                                  .spp = from->spp > 0 ? from->spp : 16,
                                  .n_roots = 16,
                                  .n_photons = 64,
                                  .cut_after = 200,
                                  .n_batch = 32,
                                  .memory_mib = from->memory_mib,
                                  .resolution = from->resolution_max,
                                  .n_looks = 0,
                                  .children = 0,
                                  .explores = from->explore == LMN_EXPLORE_ACTIVE,
                                  .learning_rate = from->learning_rate,
                                  .warm_steps = 1000,
                                  .average = 0.1,
                                  .without = from->without};
    if (from->without & LMN_WITHOUT_CUTS) o->n_roots = 0;
    if (from->without & LMN_WITHOUT_PHOTONS) o->n_photons = 0;
    if (from->without & LMN_WITHOUT_REPLAY) o->n_batch = o->n_fresh;
    if (from->without & LMN_WITHOUT_AVERAGE) o->average = 0.0;
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

static bool is_guided(const struct learner *l)
{
    return l->options.explores && l->options.n_photons / 2 > 0;
}

static lmn_status take_desk(struct learner *l, struct desk *d, struct error *err)
{
    const size_t n = l->options.n_pixels;
    bool is_short = false;
    d->pixels = take(l, n, sizeof *d->pixels, &is_short);
    d->u = take(l, (size_t)l->place.scene->n_variables + 1, sizeof *d->u, &is_short);
    d->color = take(l, n, sizeof(float[3]), &is_short);
    d->groups = take(l, 2 * n * l->sight.powers.n, sizeof(float[3]), &is_short);
    d->buffers = take(l, 2 * n, sizeof(float[BUFFER_CHANNELS]), &is_short);
    d->ends = take(l, n, sizeof *d->ends, &is_short);
    d->rays = take(l, n, sizeof *d->rays, &is_short);
    d->bounces = take(l, n, sizeof *d->bounces, &is_short);
    if (is_short) return fail_memory(err, "the learner");
    lmn_status status = scene_state_init(l->place.scene, &d->state, err);
    if (status == LMN_OK && l->options.n_photons > 0) {
        status = caustics_init(&d->caustics, l->options.n_photons, err);
        if (status == LMN_OK) l->stats.memory_bytes += caustics_memory_size(&d->caustics);
    }
    if (status == LMN_OK && is_guided(l)) {
        status = guide_init(&d->guide, l->options.n_photons / 2, err);
        if (status == LMN_OK) l->stats.memory_bytes += guide_memory_size(&d->guide);
    }
    return status == LMN_OK ? view_new(l->place.world, &d->view, err) : status;
}

static bool take_batch(struct learner *l)
{
    struct batch *b = &l->batch;
    const size_t n = l->options.n_batch, n_pixels = n * l->options.n_pixels;
    bool is_short = false;
    b->slots = take(l, n, sizeof *b->slots, &is_short);
    b->runs = take(l, n, sizeof *b->runs, &is_short);
    b->losses = take(l, n, sizeof *b->losses, &is_short);
    b->errors = take(l, n, sizeof *b->errors, &is_short);
    b->positions = take(l, n_pixels * l->sight.n_positions, sizeof(float[3]), &is_short);
    b->features = take(l, n_pixels * l->sight.n_features, sizeof(float), &is_short);
    b->scale = take(l, n_pixels, sizeof(float[3]), &is_short);
    b->targets = take(l, n_pixels, sizeof(float[3]), &is_short);
    b->halves = take(l, n_pixels, sizeof(float[3]), &is_short);
    b->cautions = take(l, n_pixels, sizeof(float), &is_short);
    b->v = take(l, n * l->sight.n_variables + 1, sizeof(float), &is_short);
    b->lights = take(l, n * l->sight.powers.n, sizeof(float[3]), &is_short);
    return !is_short;
}

/* Whether ends spare more than they cost, by paths of the first step's configurations: a function
 * of the scene and the seed, so that nothing of it is kept. */
static bool are_paths_long(struct learner *l)
{
    struct desk *d = &l->desks[0];
    struct path_lengths lengths = {0};
    struct trace_output out = {.color = d->color, .lengths = &lengths};
    struct trace_settings t = l->trace;
    t.spp = 2;
    t.seed = rng_keyed(l->options.seed ^ STREAM_LENGTHS, 0, 0).state;
    scout_go(l->scout, l->views, &l->memory, 0);
    for (uint32_t i = 0; i < l->options.n_fresh; i++) {
        view_set(d->view, scout_u(l->scout, i));
        view_trace_pixels(d->view, &t, l->width, l->height, scout_pixels(l->scout, i),
                          l->options.n_pixels, &out);
    }
    return (double)lengths.later > END_COST * (double)lengths.second;
}

static lmn_status take_all(struct learner *l, struct error *err)
{
    lmn_status status = LMN_OK;
    const struct learner_options *o = &l->options;
    const struct memory_shape shape = {l->place.scene->n_variables, o->n_pixels, l->sight.powers.n};
    const struct scout_options scout = {.seed = o->seed,
                                        .n_fresh = o->n_fresh,
                                        .n_pixels = o->n_pixels,
                                        .n_looks = o->explores ? o->n_looks : 0,
                                        .children = o->children,
                                        .width = l->width,
                                        .height = l->height};
    const size_t n_weights = field_n_weights(l->field);
    const uint32_t n_workers = pool_n_workers(l->place.pool);
    bool is_short = false;
    TRY(memory_init(&l->memory, &shape, o->memory_mib, o->n_fresh, err));
    TRY(scout_new(&l->place, &l->sight, l->field, &scout, &l->scout, err));
    l->stats.memory_bytes += l->memory.size + scout_memory_size(l->scout);
    l->gradient = take(l, n_weights, sizeof(float), &is_short);
    l->average = take(l, n_weights, sizeof(float), &is_short);
    l->kept = take(l, n_weights, sizeof(float), &is_short);
    l->desks = take(l, n_workers, sizeof *l->desks, &is_short);
    l->views = take(l, n_workers, sizeof *l->views, &is_short);
    if (is_short || !take_batch(l)) {
        status = fail_memory(err, "the learner");
        goto done;
    }
    while (l->n_desks < n_workers) {
        struct desk *d = &l->desks[l->n_desks++];
        TRY(take_desk(l, d, err));
        l->views[l->n_desks - 1] = d->view;
    }
    if (o->n_roots > 0 && are_paths_long(l)) {
        TRY(tails_new(&l->sight, o->n_fresh, 2 * l->trace.spp * o->n_pixels, &l->tails, err));
        l->stats.memory_bytes += tails_memory_size(l->tails);
    }
done:
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
    TRY(sight_init(&l->sight, place->scene, options->without, err));
    l->sight.cpu = place->cpu;
    l->sight.max_depth = trace->max_depth;
    l->trace = *trace;
    l->trace.spp = (options->spp + 3) / 4 * 2; /* of each half; even, as first_sample */
    l->trace.splats = false;
    l->trace.shares_rays = true; /* targets are the rays' own radiance less their own emission */
    inputs_picture_size(place->scene, options->resolution, 1, &l->width, &l->height);
    l->config = sight_field(&l->sight);
    l->config.grid = learner_grid();
    l->config.ignores_halves = (options->without & LMN_WITHOUT_HALVES) != 0;
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
        struct desk *d = &l->desks[i];
        view_free(d->view);
        scene_state_release(&d->state);
        mem_free(d->pixels);
        mem_free(d->u);
        mem_free(d->color);
        mem_free(d->groups);
        mem_free(d->buffers);
        mem_free(d->ends);
        mem_free(d->rays);
        mem_free(d->bounces);
        caustics_release(&d->caustics);
        guide_release(&d->guide);
    }
    const struct batch *b = &l->batch;
    void *const blocks[] = {l->desks,   l->views,  l->gradient, l->average,   l->kept,     b->slots,
                            b->runs,    b->losses, b->errors,   b->positions, b->features, b->scale,
                            b->targets, b->halves, b->cautions, b->v,         b->lights};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) mem_free(blocks[i]);
    memory_release(&l->memory);
    scout_free(l->scout);
    tails_free(l->tails);
    adam_release(&l->tables);
    adam_release(&l->layers);
    field_free(l->field);
    sight_release(&l->sight);
    mem_free(l);
}

/* ---- Tracing -------------------------------------------------------------------------------- */

static bool cuts_paths(const struct learner *l, uint64_t step)
{
    return l->tails && step >= l->options.cut_after;
}

/* The depth that roots of a configuration are traced to: half of them that of the ends that camera
 * paths have, half that of the roots' own. */
static int32_t root_depth(const struct learner *l, uint64_t serial)
{
    const int32_t most = l->trace.max_depth;
    struct rng r = rng_keyed(l->options.seed ^ STREAM_ROOTS, serial, 1);
    if (most < 4) return most;
    if (rng_float(&r) < 0.5f) return most - 1;
    return 3 + (int32_t)rng_below(&r, (uint32_t)most - 3);
}

/* Of a configuration, whose first pixels the camera sees and whose last are roots. */
struct errand {
    uint32_t item;
    bool is_cut;
    const struct ray *rays; /* NULL: pixels */
    uint32_t first, n;      /* of its pixels */
    int32_t max_depth;
    uint32_t part; /* random numbers of a configuration's errands are kept apart */
};

/* Parts: pixels, roots, and from here on chains by their lengths. */
enum { PART_PIXELS, PART_ROOTS, PART_CHAINS };

/* One half of the samples: its radiance by group of lights, less what surfaces emit themselves, to
 * targets [n_pixels][n_lights][3]. */
static void trace_half(struct learner *l, struct desk *d, const struct errand *e, uint32_t half,
                       float *targets)
{
    const uint32_t n_lights = l->sight.powers.n, n = e->n;
    const uint64_t serial = l->memory.n_added + e->item;
    struct trace_settings t = l->trace;
    float *buffers = d->buffers + ((size_t)half * l->options.n_pixels + e->first) * BUFFER_CHANNELS;
    float *out = targets + (size_t)e->first * n_lights * 3;
    struct trace_output output = {.color = d->color, .buffers = buffers};
    t.seed = rng_keyed(l->options.seed ^ STREAM_TRACE, serial, e->part).state;
    t.max_depth = e->max_depth;
    t.first_sample = half * t.spp;
    if (l->options.n_photons > 0) t.photons[0] = t.photons[1] = d->caustics.maps[half];
    if (n_lights > 1) {
        memset(d->groups, 0, 2 * (size_t)n * n_lights * sizeof(float[3]));
        output.groups = d->groups;
        output.n_groups = 2 * n_lights;
        output.group_of = l->sight.powers.group_of;
        output.chain_group = n_lights;
    }
    if (e->is_cut) output.ends = tails_ends(l->tails, e->item);
    if (e->rays)
        view_trace_rays(d->view, &t, e->rays, n, &output);
    else
        view_trace_pixels(d->view, &t, l->width, l->height, d->pixels, n, &output);
    if (n_lights == 1)
        sight_targets(d->color, buffers, n, out);
    else
        sight_split_targets(d->groups, buffers, n, n_lights, out);
    if (e->is_cut) tails_look(l->tails, e->item, view_state(d->view), out, t.spp);
}

/* Both halves. */
static void trace_errand(struct learner *l, struct desk *d, const struct errand *e,
                         float *const halves[2])
{
    for (uint32_t half = 0; half < 2; half++) trace_half(l, d, e, half, halves[half]);
    for (uint32_t i = e->first; i < e->first + e->n; i++)
        d->bounces[i] = sight_bounces(&l->sight, e->max_depth);
}

/* Camera pixels as surfaces behind mirrors and glass, one way each, in the order of lengths: what
 * is left of the bounces is one number for all that is traced together. Weights go along. */
static void trace_chains(struct learner *l, struct desk *d, const struct errand *pixels,
                         float *const halves[2], float *weights)
{
    const uint32_t item = pixels->item, n = pixels->n;
    const int32_t most = l->trace.max_depth;
    struct trace_settings t = l->trace;
    t.seed = rng_keyed(l->options.seed ^ STREAM_CHAINS, l->memory.n_added + item, 0).state;
    view_follow_pixels(d->view, &t, l->width, l->height, d->pixels, n, d->ends);
    for (uint32_t length = 0, k = 0; k < n; length++) {
        struct errand e = *pixels;
        e.rays = d->rays + k;
        e.first = k;
        e.max_depth = most < 0 ? most : most - (int32_t)length;
        e.part = PART_CHAINS + length;
        for (uint32_t i = 0; i < n; i++)
            if (most < 0 || d->ends[i].n == length) {
                d->rays[k] = d->ends[i].ray;
                weights[k++] = scout_weights(l->scout, item)[i];
            }
        e.n = k - e.first;
        if (e.n > 0) trace_errand(l, d, &e, halves);
    }
}

/* Rays that met ends, picked at random; weight 0 where there are none. */
static void trace_roots(struct learner *l, struct desk *d, const struct errand *pixels,
                        float *const halves[2], float *weights)
{
    const uint32_t n = l->options.n_roots, first = pixels->n;
    const size_t n_colors = (size_t)l->sight.powers.n * 3, n_pixels = l->options.n_pixels;
    const uint64_t serial = l->memory.n_added + pixels->item;
    const struct path_ends *ends = tails_ends(l->tails, pixels->item);
    const uint32_t n_ends = ends->n;
    struct rng r = rng_keyed(l->options.seed ^ STREAM_ROOTS, serial, 0);
    struct errand e = *pixels;
    e.rays = d->rays + first;
    e.first = first;
    e.n = n;
    e.max_depth = root_depth(l, serial);
    e.part = PART_ROOTS;
    for (uint32_t i = first; i < first + n; i++) weights[i] = n_ends > 0 ? 1.0f : 0.0f;
    for (uint32_t i = first; n_ends > 0 && i < first + n; i++)
        d->rays[i] = ends->ends[rng_below(&r, n_ends)].ray;
    if (n_ends > 0) {
        trace_errand(l, d, &e, halves);
        return;
    }
    for (uint32_t half = 0; half < 2; half++) {
        memset(halves[half] + first * n_colors, 0, n * n_colors * sizeof(float));
        memset(d->buffers + (half * n_pixels + first) * BUFFER_CHANNELS, 0,
               n * sizeof(float[BUFFER_CHANNELS]));
    }
}

static void trace_photons(const struct learner *l, struct desk *d, uint32_t item)
{
    struct trace_settings t = l->trace;
    t.seed = rng_keyed(l->options.seed ^ STREAM_PHOTONS, l->memory.n_added + item, 0).state;
    caustics_trace(&d->caustics, d->view, &t, l->stats.step);
}

/* Those of the scout, some of them moved to caustics. */
static void choose_pixels(const struct learner *l, struct desk *d, uint32_t item)
{
    const uint32_t n = l->options.n_pixels;
    memcpy(d->pixels, scout_pixels(l->scout, item), n * sizeof *d->pixels);
    if (!is_guided(l)) return;
    struct trace_settings t = l->trace;
    struct rng r = rng_keyed(l->options.seed ^ STREAM_GUIDE, l->memory.n_added + item, 0);
    t.seed = rng_keyed(l->options.seed ^ STREAM_GUIDE, l->memory.n_added + item, 1).state;
    guide_pixels(&d->guide, d->view, &t, l->width, l->height, &r, d->pixels, n);
}

/* The i-th of the step, into the memory's next slots. */
static void trace_configuration(void *ctx, uint32_t item, uint32_t worker)
{
    struct learner *l = ctx;
    struct desk *d = &l->desks[worker];
    struct memory *m = &l->memory;
    const uint32_t n = l->options.n_pixels;
    const bool is_cut = cuts_paths(l, l->stats.step);
    const size_t slot = (m->n_added + item) % m->capacity,
                 n_colors = (size_t)n * m->shape.n_lights * 3;
    float *const halves[2] = {m->targets + slot * n_colors, m->halves + slot * n_colors};
    float *weights = m->weights + slot * n;
    const float *u = scout_u(l->scout, item);
    struct errand e = {.item = item,
                       .is_cut = is_cut,
                       .n = is_cut ? n - l->options.n_roots : n,
                       .max_depth = l->trace.max_depth,
                       .part = PART_PIXELS};
    view_set(d->view, u);
    choose_pixels(l, d, item);
    if (l->options.n_photons > 0) trace_photons(l, d, item);
    if (is_cut) tails_clear(l->tails, item);
    if (l->sight.follows_delta) {
        trace_chains(l, d, &e, halves, weights);
    } else {
        trace_errand(l, d, &e, halves);
        memcpy(weights, scout_weights(l->scout, item), e.n * sizeof(float));
    }
    if (is_cut) trace_roots(l, d, &e, halves, weights);
    const size_t n_numbers = (size_t)n * BUFFER_CHANNELS;
    for (size_t i = 0; i < n_numbers; i++)
        d->buffers[i] = 0.5f * (d->buffers[i] + d->buffers[n_numbers + i]);
    sight_keep(d->buffers, d->bounces, n, m->kept + slot * n * SIGHT_KEPT);
    memcpy(m->u + slot * m->shape.n_variables, u, m->shape.n_variables * sizeof(float));
    m->errors[slot] = 0.0f;
}

/* From two halves of the samples to their mean and half their difference. */
static void split_configuration(void *ctx, uint32_t item, uint32_t worker)
{
    struct learner *l = ctx;
    struct memory *m = &l->memory;
    const size_t slot = (m->n_added + item) % m->capacity;
    const size_t n_colors = (size_t)m->shape.n_pixels * m->shape.n_lights * 3;
    float *a = m->targets + slot * n_colors, *b = m->halves + slot * n_colors;
    (void)worker;
    for (size_t i = 0; i < n_colors; i++) {
        const float mean = 0.5f * (a[i] + b[i]), half = 0.5f * (a[i] - b[i]);
        a[i] = mean;
        b[i] = half;
    }
}

static const float *fresh_u(const void *user, uint32_t item)
{
    const struct learner *l = user;
    return scout_u(l->scout, item);
}

/* ---- Learning ------------------------------------------------------------------------------- */

/* New configurations are learnt at once; the rest of the batch is drawn from memory. */
static void draw_batch(struct learner *l)
{
    const struct memory *m = &l->memory;
    struct rng r = rng_keyed(l->options.seed ^ STREAM_BATCH, l->stats.step, 0);
    const uint32_t n_held = memory_n_held(m);
    for (uint32_t i = 0; i < l->options.n_batch; i++) {
        uint64_t fresh = m->n_added - 1 - i;
        l->batch.slots[i] = i < l->options.n_fresh ? (uint32_t)(fresh % m->capacity)
                                                   : rng_below(&r, n_held);
    }
}

/* Radiance of the slot's pixels under `lights` [n_lights][3], and half the difference of two
 * estimates. */
static void weigh_lights(const struct memory *m, uint32_t slot, const float *lights, float *targets,
                         float *halves)
{
    const uint32_t n_lights = m->shape.n_lights, n = m->shape.n_pixels;
    const float *y = m->targets + (size_t)slot * n * n_lights * 3;
    const float *half = m->halves + (size_t)slot * n * n_lights * 3;
    for (uint32_t i = 0; i < n; i++, targets += 3, halves += 3) {
        for (uint32_t c = 0; c < 3; c++) {
            float sum = 0.0f, off = 0.0f;
            for (uint32_t g = 0; g < n_lights; g++) {
                sum += lights[3 * g + c] * y[((size_t)i * n_lights + g) * 3 + c];
                off += lights[3 * g + c] * half[((size_t)i * n_lights + g) * 3 + c];
            }
            targets[c] = sum;
            halves[c] = off;
        }
    }
}

/* How far the network's word is trusted where it learns: smooth surfaces show lamps too sharp for
 * it for ever; elsewhere caution falls as the square of the learning rate. */
static void set_cautions(const struct learner *l, const float *buffers, uint32_t n, float *cautions)
{
    const float late = (float)(1.0 + (double)l->stats.step / l->options.warm_steps);
    for (uint32_t i = 0; i < n; i++) {
        const bool is_sharp = buffers[i * BUFFER_CHANNELS + BUFFER_ROUGHNESS] < SHARP_ROUGHNESS;
        cautions[i] = is_sharp ? FIELD_CAUTION : FIELD_CAUTION / late;
    }
}

/* What the memory holds of a configuration, as the network takes it: under other powers of its
 * lights each time. */
static void prepare_run(void *ctx, uint32_t item, uint32_t worker)
{
    struct learner *l = ctx;
    struct desk *d = &l->desks[worker];
    struct batch *b = &l->batch;
    const struct memory *m = &l->memory;
    const uint32_t n = l->options.n_pixels, slot = b->slots[item];
    const size_t first = (size_t)item * n;
    float *lights = b->lights + (size_t)item * l->sight.powers.n * 3;
    float *v = b->v + (size_t)item * l->sight.n_variables;
    struct rng r = rng_keyed(l->options.seed ^ STREAM_POWERS, l->stats.step, item);
    memcpy(d->u, m->u + (size_t)slot * m->shape.n_variables, m->shape.n_variables * sizeof *d->u);
    powers_draw(&l->sight.powers, &r, d->u);
    scene_apply(l->place.scene, d->u, &d->state);
    powers_at(&l->sight.powers, &d->state, lights);
    sight_recall(m->kept + (size_t)slot * n * SIGHT_KEPT, n, d->buffers, d->bounces);
    sight_look(&l->sight, &d->state, d->buffers, n, b->positions + first * l->sight.n_positions * 3,
               b->features + first * l->sight.n_features, b->scale + 3 * first);
    sight_set_bounces(&l->sight, d->bounces, n, b->features + first * l->sight.n_features);
    set_cautions(l, d->buffers, n, b->cautions + first);
    sight_variables(&l->sight, d->u, v);
    weigh_lights(m, slot, lights, b->targets + 3 * first, b->halves + 3 * first);
    b->runs[item] = (struct field_run){.n = n,
                                       .positions = b->positions + first * l->sight.n_positions * 3,
                                       .features = b->features + first * l->sight.n_features,
                                       .scale = b->scale + 3 * first,
                                       .v = v,
                                       .lights = lights,
                                       .targets = b->targets + 3 * first,
                                       .weights = m->weights + (size_t)slot * n,
                                       .halves = b->halves + 3 * first,
                                       .cautions = b->cautions + first};
}

static void step_weights(struct learner *l)
{
    const size_t n_table = field_n_table_weights(l->field);
    const double step = (double)l->stats.step, warm = l->options.warm_steps;
    float *w = field_weights(l->field);
    l->layers.learning_rate = l->options.learning_rate / sqrt(1.0 + step / warm);
    l->tables.learning_rate = TABLE_RATE * l->layers.learning_rate;
    l->tables.share = l->layers.share = (float)(1.0 / (1.0 + l->options.average * step));
    adam_step(&l->tables, l->place.pool, w, l->gradient);
    adam_step(&l->layers, l->place.pool, w + n_table, l->gradient + n_table);
    field_weights_changed(l->field);
}

lmn_status learner_step(struct learner *l, struct learner_stats *stats, struct error *err)
{
    const double threads = pool_n_workers(l->place.pool);
    const double start = clock_cpu_s();
    scout_go(l->scout, l->views, &l->memory, l->memory.n_added);
    pool_run(l->place.pool, l->options.n_fresh, trace_configuration, l);
    if (cuts_paths(l, l->stats.step)) tails_add(l->tails, l->field, fresh_u, l);
    pool_run(l->place.pool, l->options.n_fresh, split_configuration, l);
    l->memory.n_added += l->options.n_fresh;
    const double traced = clock_cpu_s();
    struct batch *b = &l->batch;
    draw_batch(l);
    pool_run(l->place.pool, l->options.n_batch, prepare_run, l);
    field_gradient(l->field, b->runs, l->options.n_batch, b->losses, b->errors, l->gradient);
    double sum = 0;
    for (uint32_t i = 0; i < l->options.n_batch; i++) sum += (double)b->losses[i];
    if (!isfinite(sum)) {
        l->memory.n_added -= l->options.n_fresh; /* the next step traces the same again */
        return fail(err, LMN_ERR_ARGUMENT,
                    "training came apart at step %llu: the loss is not a number; a lower learning "
                    "rate may help",
                    (unsigned long long)l->stats.step);
    }
    for (uint32_t i = 0; i < l->options.n_batch; i++) l->memory.errors[b->slots[i]] = b->errors[i];
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

const float *learner_configuration(const struct learner *l, uint32_t k)
{
    const struct memory *m = &l->memory;
    if (k >= memory_n_held(m)) return NULL;
    return m->u + (size_t)((m->n_added - 1 - k) % m->capacity) * m->shape.n_variables;
}

void learner_get_stats(const struct learner *l, struct learner_stats *stats)
{
    *stats = l->stats;
}

/* ---- Checkpoints ---------------------------------------------------------------------------- */

uint32_t learner_tensors(struct learner *l, struct tensor *out)
{
    const uint64_t n = field_n_weights(l->field), n_table = field_n_table_weights(l->field);
    const struct tensor list[] = {
        {"training.weights", TENSOR_F32, 1, {n}, field_weights(l->field)},
        {"adam.grid.m", TENSOR_F32, 1, {n_table}, l->tables.m},
        {"adam.grid.v", TENSOR_F32, 1, {n_table}, l->tables.v},
        {"adam.layer.m", TENSOR_F32, 1, {n - n_table}, l->layers.m},
        {"adam.layer.v", TENSOR_F32, 1, {n - n_table}, l->layers.v},
    };
    memcpy(out, list, sizeof list);
    memory_tensors(&l->memory, out + sizeof list / sizeof *list);
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
