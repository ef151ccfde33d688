/* SPDX-License-Identifier: Apache-2.0 */
#include "train/trainer_inside.h"

#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "base/pool.h"
#include "train/inputs.h"
#include "train/layout.h"
#include "train/tracing.h"

/* Keep the random numbers of one seed apart. */
enum { STREAM_REUSE = 0x72657573, STREAM_TRACE = 0x74726163 };

size_t trainer_n_weights(const struct trainer *t)
{
    return t->learner ? layout_field_n_weights(learner_field_config(t->learner)) : t->adam.n;
}

float *trainer_weights(const struct trainer *t)
{
    return t->learner ? learner_average(t->learner) : generator_weights(t->generator);
}

const lmn_train_options *trainer_options(const struct trainer *t)
{
    return &t->options;
}

/* ---- Rendering proposals ------------------------------------------------------------------- */

uint32_t trainer_resolution(const lmn_train_options *o, uint64_t step)
{
    if (o->no_growth) return o->resolution_start;
    /* It grows at the start of an epoch, so the very first step is one notch up already. */
    uint64_t n = 1 + step / o->resolution_every;
    uint64_t room = o->resolution_max - o->resolution_start;
    if (o->resolution_step > 0 && n > room / o->resolution_step) return o->resolution_max;
    return o->resolution_start + (uint32_t)n * o->resolution_step;
}

static void render_proposal(void *ctx, uint32_t chain, uint32_t worker)
{
    struct trainer *t = ctx;
    struct easel *e = &t->easels[worker];
    const struct scene *s = t->place.scene;
    const float *u = t->explorer.proposals + (size_t)chain * t->explorer.options.dim;
    const float *corner = u + s->n_variables;
    uint32_t side = t->options.patch_size;
    struct window w = {.width = side, .height = side};
    inputs_picture_size(s, trainer_resolution(&t->options, t->step), side, &w.full_width,
                        &w.full_height);
    w.x = (uint32_t)(corner[0] * (float)(w.full_width - side));
    w.y = (uint32_t)(corner[1] * (float)(w.full_height - side));

    struct trace_settings settings = t->trace;
    settings.seed = rng_keyed(t->options.seed ^ STREAM_TRACE, t->explorer.generation, chain).state;
    struct trace_output output = {.color = e->color, .buffers = e->buffers};
    view_set(e->view, u);
    if (e->photons) /* on this thread: cannot fail */
        photon_passes_trace(e->photons, e->view, NULL, &settings, &w, &output, NULL, NULL, NULL);
    else
        view_trace(e->view, &settings, &w, &output);

    size_t pixels = (size_t)chain * t->n_pixels;
    inputs_from_buffers(s, e->buffers, t->n_pixels,
                        t->proposals.inputs + pixels * GENERATOR_INPUTS);
    inputs_targets(e->color, t->n_pixels, t->proposals.targets + pixels * 3);
    inputs_variables(s, u, t->proposals.v + (size_t)chain * s->n_variables);
}

/* ---- Batches ------------------------------------------------------------------------------- */

static void batch_add(struct trainer *t, const struct patches *from, uint32_t index)
{
    struct batch *b = &t->batch;
    size_t pixels = (size_t)index * t->n_pixels;
    b->inputs[b->n] = from->inputs + pixels * GENERATOR_INPUTS;
    b->targets[b->n] = from->targets + pixels * 3;
    b->v[b->n] = from->v + (size_t)index * t->config.n_variables;
    b->n++;
}

static struct generator_batch batch_view(const struct batch *b)
{
    return (struct generator_batch){
        .n_patches = b->n, .inputs = b->inputs, .targets = b->targets, .v = b->v};
}

/* Trains on the batch; its losses are those before the step. */
static lmn_status train_on_batch(struct trainer *t, struct error *err)
{
    const struct generator_loss loss = {.legacy_ssim = t->options.legacy_ssim != 0};
    struct generator_batch batch = batch_view(&t->batch);
    generator_gradient(t->generator, &batch, &loss, t->batch.losses, t->gradient);
    double sum = 0;
    for (uint32_t i = 0; i < t->batch.n; i++) sum += (double)t->batch.losses[i];
    if (!isfinite(sum))
        return fail(err, LMN_ERR_ARGUMENT,
                    "training came apart at step %llu: the loss is not a number; a lower "
                    "learning rate may help",
                    (unsigned long long)t->step);
    adam_step(&t->adam, t->place.pool, generator_weights(t->generator), t->gradient);
    generator_weights_changed(t->generator);
    t->loss = sum / t->batch.n;
    t->batch_size = t->batch.n;
    return LMN_OK;
}

/* The target function of states and proposals under the network as it is now (Sec. 5.1): p = loss x
 * norm of the step that Adam would make, or the loss alone. A state keeps its old rendering. */
static void evaluate_target(struct trainer *t)
{
    const struct generator_loss loss = {.legacy_ssim = t->options.legacy_ssim != 0};
    uint32_t n = t->options.n_chains;
    t->batch.n = 0;
    for (uint32_t i = 0; i < n; i++) batch_add(t, &t->states, i);
    for (uint32_t i = 0; i < n; i++) batch_add(t, &t->proposals, i);
    struct generator_batch batch = batch_view(&t->batch);
    if (t->options.explore == LMN_EXPLORE_LOSS_ONLY) {
        generator_gradient(t->generator, &batch, &loss, t->p, NULL);
        return;
    }
    generator_probe(t->generator, &t->adam, &batch, &loss, t->p, t->norms);
    for (uint32_t i = 0; i < 2 * n; i++) t->p[i] *= t->norms[i];
}

static void keep_proposal(struct trainer *t, uint32_t chain)
{
    size_t pixels = (size_t)chain * t->n_pixels, n_v = t->config.n_variables;
    memcpy(t->states.inputs + pixels * GENERATOR_INPUTS,
           t->proposals.inputs + pixels * GENERATOR_INPUTS,
           t->n_pixels * sizeof(float[GENERATOR_INPUTS]));
    memcpy(t->states.targets + pixels * 3, t->proposals.targets + pixels * 3,
           t->n_pixels * sizeof(float[3]));
    if (n_v > 0)
        memcpy(t->states.v + chain * n_v, t->proposals.v + chain * n_v, n_v * sizeof(float));
}

/* After training on a generation: remembers what is new, tells the reuse what it cost. The batch
 * holds per chain its state and, when refused, its proposal. */
static void record_generation(struct trainer *t)
{
    uint32_t at = 0;
    float *new_losses = t->p; /* no longer needed */
    for (uint32_t i = 0; i < t->options.n_chains; i++) {
        size_t pixels = (size_t)i * t->n_pixels;
        if (!t->is_accepted[i]) {
            uint32_t slot = replay_slot(&t->replay, t->serials[i]);
            if (slot != UINT32_MAX) replay_set_loss(&t->replay, slot, t->batch.losses[at]);
            at++;
        }
        new_losses[i] = t->batch.losses[at++];
        uint64_t serial = replay_add(&t->replay, t->proposals.inputs + pixels * GENERATOR_INPUTS,
                                     t->proposals.targets + pixels * 3,
                                     t->proposals.v + (size_t)i * t->config.n_variables,
                                     new_losses[i], t->explorer.is_large[i]);
        if (t->is_accepted[i]) t->serials[i] = serial;
    }
    reuse_record_event(&t->reuse, t->loss, new_losses, t->explorer.is_large, t->options.n_chains);
}

/* A generation of the chains: 16 new patches, and a batch of those and the states that stayed. */
static lmn_status step_fresh(struct trainer *t, double *trace_cpu_s, struct error *err)
{
    uint32_t n = t->options.n_chains;
    bool is_first = t->explorer.generation == 0;
    double cpu = clock_cpu_s();
    explorer_propose(&t->explorer);
    pool_run(t->place.pool, n, render_proposal, t);
    *trace_cpu_s = clock_cpu_s() - cpu;

    if (!is_first && !t->explorer.options.accepts_all) evaluate_target(t);
    uint32_t n_accepted = explorer_decide(&t->explorer, t->p, t->p + n, t->is_accepted);
    double share = (double)n_accepted / n;
    bool is_second = t->explorer.generation == 2; /* the first that could refuse */
    if (!is_first) t->acceptance += (is_second ? 1.0 : 0.1) * (share - t->acceptance);

    t->batch.n = 0;
    for (uint32_t i = 0; i < n; i++) {
        if (t->is_accepted[i]) keep_proposal(t, i);
        batch_add(t, &t->states, i);
        if (!t->is_accepted[i]) batch_add(t, &t->proposals, i);
    }
    lmn_status status = train_on_batch(t, err);
    if (status != LMN_OK) return status;
    t->n_traced += n;
    record_generation(t);
    history_add_chains(&t->history, t->explorer.generation - 1, t->step + 1, t->explorer.u);
    return LMN_OK;
}

/* A batch from memory, drawn in proportion to the last recorded losses. */
static lmn_status step_replayed(struct trainer *t, struct rng *r, struct error *err)
{
    struct patches memory = {t->replay.inputs, t->replay.targets, t->replay.v};
    t->batch.n = 0;
    for (uint32_t i = 0; i < t->options.reuse_batch; i++) {
        t->slots[i] = replay_draw(&t->replay, r);
        batch_add(t, &memory, t->slots[i]);
    }
    lmn_status status = train_on_batch(t, err);
    if (status != LMN_OK) return status;
    for (uint32_t i = 0; i < t->batch.n; i++) {
        float loss = t->batch.losses[i];
        reuse_record_replayed(&t->reuse, (double)loss, t->replay.is_large[t->slots[i]]);
        replay_set_loss(&t->replay, t->slots[i], loss);
    }
    return LMN_OK;
}

static lmn_status step_faithful(struct trainer *t, double *trace_cpu_s, struct error *err)
{
    struct rng r = rng_keyed(t->options.seed ^ STREAM_REUSE, t->step, 0);
    t->is_fresh = t->options.no_reuse || !(rng_double(&r) < reuse_probability(&t->reuse));
    return t->is_fresh ? step_fresh(t, trace_cpu_s, err) : step_replayed(t, &r, err);
}

static lmn_status step_improved(struct trainer *t, double *trace_cpu_s, struct error *err)
{
    struct learner_stats before, after;
    learner_get_stats(t->learner, &before);
    lmn_status status = learner_step(t->learner, &after, err);
    if (status != LMN_OK) return status;
    t->loss = after.loss;
    t->is_fresh = true;
    t->batch_size = after.n_batch;
    t->n_traced = after.n_configurations;
    *trace_cpu_s = (after.trace_s - before.trace_s) * pool_n_workers(t->place.pool);
    return LMN_OK;
}

/* Only the faithful method chooses between new patches and replayed ones. */
static bool reuses(const struct trainer *t)
{
    return !t->learner && !t->options.no_reuse;
}

static bool has_averages(const struct trainer *t)
{
    return !t->learner && reuse_is_warm(&t->reuse);
}

static uint32_t resolution_of(const struct trainer *t, uint64_t step)
{
    return t->learner ? t->options.resolution_max : trainer_resolution(&t->options, step);
}

static void record_step(struct trainer *t)
{
    bool is_warm = has_averages(t);
    const double row[HISTORY_COLUMNS] = {
        [HISTORY_STEP] = (double)t->step,
        [HISTORY_LOSS] = t->loss,
        [HISTORY_LOSS_FRESH] = is_warm ? t->reuse.loss_new : NAN,
        [HISTORY_LOSS_REPLAYED] = is_warm ? t->reuse.loss_exist : NAN,
        [HISTORY_REUSE_PROBABILITY] = reuses(t) ? reuse_probability(&t->reuse) : 0,
        [HISTORY_ACCEPTANCE] = t->acceptance,
        [HISTORY_RESOLUTION] = resolution_of(t, t->step - 1),
        [HISTORY_FRESH] = t->is_fresh,
    };
    history_add(&t->history, row);
}

lmn_status trainer_step(struct trainer *t, lmn_train_stats *stats, struct error *err)
{
    lmn_status status = LMN_OK;
    double cpu = clock_cpu_s(), trace_cpu_s = 0;
    if (t->learner)
        TRY(step_improved(t, &trace_cpu_s, err));
    else
        TRY(step_faithful(t, &trace_cpu_s, err));
    t->step++;
    t->has_stepped = true;
    record_step(t);

    double threads = pool_n_workers(t->place.pool);
    double cpu_s = clock_cpu_s() - cpu;
    t->cpu_s += cpu_s / threads;
    t->trace_s += trace_cpu_s / threads;
    t->network_s += (cpu_s - trace_cpu_s) / threads;
    if (stats) trainer_get_stats(t, stats);
done:
    return status;
}

void trainer_get_stats(const struct trainer *t, lmn_train_stats *stats)
{
    bool is_warm = has_averages(t);
    uint64_t last = t->step > 0 ? t->step - 1 : 0;
    *stats = (lmn_train_stats){
        .step = t->step,
        .loss = t->loss,
        .loss_fresh = is_warm ? t->reuse.loss_new : NAN,
        .loss_replayed = is_warm ? t->reuse.loss_exist : NAN,
        .reuse_probability = reuses(t) ? reuse_probability(&t->reuse) : 0,
        .acceptance = t->acceptance,
        .resolution = resolution_of(t, last),
        .fresh = t->is_fresh,
        .batch = t->batch_size,
        .n_traced = t->n_traced,
        .cpu_s = t->cpu_s,
        .trace_s = t->trace_s,
        .network_s = t->network_s,
        .memory_bytes = t->memory_size,
    };
}

bool trainer_state(const struct trainer *t, uint32_t k, float *u)
{
    const struct explorer *e = &t->explorer;
    const float *from = NULL;
    if (t->learner)
        from = learner_configuration(t->learner, k);
    else if (e->generation > 0 && k < e->options.n_chains)
        from = e->u + (size_t)k * e->options.dim;
    if (from) memcpy(u, from, t->place.scene->n_variables * sizeof *u);
    return from != NULL;
}
