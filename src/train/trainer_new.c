/* SPDX-License-Identifier: Apache-2.0 */
/* trainer_new() and trainer_free(): the parts of both methods. */
#include "train/trainer_inside.h"

#include <unistd.h>

#include "base/hash.h"
#include "base/mem.h"
#include "base/pool.h"
#include "train/layout.h"
#include "train/options.h"
#include "train/tracing.h"

/* Keeps the random numbers of one seed apart from those of trainer.c. */
enum { STREAM_WEIGHTS = 0x77656967 };

enum { PATCH_CORNER_DIMENSIONS = 2 };

static void *take(struct trainer *t, size_t count, size_t size, bool *is_short)
{
    void *block = mem_new(count, size);
    if (block)
        t->memory_size += (uint64_t)count * size;
    else
        *is_short = true;
    return block;
}

static void take_patches(struct trainer *t, uint32_t n, struct patches *p, bool *is_short)
{
    size_t pixels = (size_t)n * t->n_pixels;
    p->inputs = take(t, pixels * GENERATOR_INPUTS, sizeof *p->inputs, is_short);
    p->targets = take(t, pixels * 3, sizeof *p->targets, is_short);
    p->v = take(t, (size_t)n * t->config.n_variables, sizeof *p->v, is_short);
}

static void patches_release(struct patches *p)
{
    mem_free(p->inputs);
    mem_free(p->targets);
    mem_free(p->v);
}

static lmn_status take_photons(struct trainer *t, struct easel *e, struct error *err)
{
    const struct trace_output output = {.color = e->color, .buffers = e->buffers};
    uint32_t n_photons = tracing_n_photons(t->n_pixels, t->trace.spp);
    lmn_status status = photon_passes_new(n_photons, t->n_pixels, &output, &e->photons, err);
    if (status == LMN_OK) t->memory_size += photon_passes_memory(e->photons);
    return status;
}

/* Small things and those whose size the options give. */
static lmn_status take_workspace(struct trainer *t, struct error *err)
{
    const lmn_train_options *o = &t->options;
    bool is_short = false;
    size_t n_weights = generator_n_weights(t->generator);
    size_t max_batch = 2 * (size_t)o->n_chains;
    if (max_batch < o->reuse_batch) max_batch = o->reuse_batch;

    t->gradient = take(t, n_weights, sizeof *t->gradient, &is_short);
    take_patches(t, o->n_chains, &t->states, &is_short);
    take_patches(t, o->n_chains, &t->proposals, &is_short);
    t->serials = take(t, o->n_chains, sizeof *t->serials, &is_short);
    t->batch.inputs = take(t, max_batch, sizeof *t->batch.inputs, &is_short);
    t->batch.targets = take(t, max_batch, sizeof *t->batch.targets, &is_short);
    t->batch.v = take(t, max_batch, sizeof *t->batch.v, &is_short);
    t->batch.losses = take(t, max_batch, sizeof *t->batch.losses, &is_short);
    t->p = take(t, 2 * (size_t)o->n_chains, sizeof *t->p, &is_short);
    t->norms = take(t, 2 * (size_t)o->n_chains, sizeof *t->norms, &is_short);
    t->is_accepted = take(t, o->n_chains, sizeof *t->is_accepted, &is_short);
    t->slots = take(t, o->reuse_batch, sizeof *t->slots, &is_short);
    t->easels = take(t, pool_n_workers(t->place.pool), sizeof *t->easels, &is_short);
    if (is_short) return fail_memory(err, "the trainer");

    for (uint32_t i = 0; i < pool_n_workers(t->place.pool); i++) {
        struct easel *e = &t->easels[i];
        t->n_easels++;
        e->color = take(t, t->n_pixels * (size_t)3, sizeof *e->color, &is_short);
        e->buffers = take(t, t->n_pixels * (size_t)BUFFER_CHANNELS, sizeof *e->buffers, &is_short);
        if (is_short) return fail_memory(err, "the trainer");
        lmn_status status = view_new(t->place.world, &e->view, err);
        if (status == LMN_OK && t->has_photons) status = take_photons(t, e, err);
        if (status != LMN_OK) return status;
    }
    return LMN_OK;
}

/* How many patches are remembered: what was asked for, within the bound of memory and what the
 * machine has. */
static lmn_status replay_room(const struct trainer *t, uint32_t *out, struct error *err)
{
    const lmn_train_options *o = &t->options;
    *out = 0;
    if (o->no_reuse) return LMN_OK;
    uint64_t patch = replay_patch_size(t->n_pixels, t->config.n_variables);
    uint64_t bound = ((uint64_t)o->memory_mib << 20) / patch;
    *out = bound < o->replay_capacity ? (uint32_t)bound : o->replay_capacity;
    if (*out == 0)
        return fail(err, LMN_ERR_ARGUMENT,
                    "training option memory_mib = %u holds no patch of %llu bytes", o->memory_mib,
                    (unsigned long long)patch);
    uint64_t machine = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE);
    if (*out * patch > machine)
        return fail(err, LMN_ERR_MEMORY,
                    "the replay memory would take %llu MiB, this machine has %llu; lower "
                    "memory_mib",
                    (unsigned long long)(*out * patch >> 20), (unsigned long long)(machine >> 20));
    return LMN_OK;
}

static lmn_status new_faithful(struct trainer *t, uint32_t dim, struct error *err)
{
    lmn_status status = LMN_OK;
    const struct scene *s = t->place.scene;
    const lmn_train_options *o = &t->options;
    uint32_t capacity;
    t->n_pixels = o->patch_size * o->patch_size;
    t->config = (struct generator_config){.n_variables = s->n_variables,
                                          .width = o->width,
                                          .depth = o->depth,
                                          .patch_size = o->patch_size};
    TRY(replay_room(t, &capacity, err));

    TRY(generator_new(&t->config, t->place.pool, t->place.cpu, &t->generator, err));
    generator_init(t->generator, rng_mix(o->seed ^ STREAM_WEIGHTS));
    if (o->no_preconditioning)
        layout_cut_position_layer(&t->config, generator_weights(t->generator));
    generator_weights_changed(t->generator);
    TRY(adam_init(&t->adam, generator_n_weights(t->generator), o->learning_rate, err));
    t->adam.cpu = t->place.cpu;

    struct explorer_options walk = {.n_chains = o->n_chains,
                                    .dim = dim,
                                    .seed = o->seed,
                                    .large_step = o->large_step,
                                    .step_min = o->step_min,
                                    .step_max = o->step_max};
    if (o->explore == LMN_EXPLORE_UNIFORM) {
        walk.large_step = 1;
        walk.accepts_all = true;
    }
    TRY(explorer_init(&t->explorer, &walk, err));
    TRY(replay_init(&t->replay, capacity, t->n_pixels, s->n_variables, err));
    t->reuse = (struct reuse){
        .bias = o->reuse_bias, .ema = o->reuse_ema, .warmup = o->reuse_warmup};
    TRY(take_workspace(t, err));

    size_t n_walk = (size_t)o->n_chains * (2 * dim * sizeof(float) + sizeof(bool));
    t->memory_size += sizeof *t + generator_memory_size(t->generator) +
                      2 * t->adam.n * sizeof(float) + n_walk + t->replay.memory_size +
                      t->history.memory_size;
done:
    return status;
}

static lmn_status new_improved(struct trainer *t, struct error *err)
{
    struct learner_options o;
    struct learner_stats stats;
    learner_options_init(&o, &t->options);
    if (!t->has_photons) o.n_photons = 0;
    t->config.n_variables = t->place.scene->n_variables;
    lmn_status status = learner_new(&t->place, &o, &t->trace, &t->learner, err);
    if (status != LMN_OK) return status;
    learner_get_stats(t->learner, &stats);
    t->memory_size = sizeof *t + stats.memory_bytes + t->history.memory_size;
    return LMN_OK;
}

void trainer_identify(struct trainer *t)
{
    const uint64_t scene = t->place.scene->hash;
    t->training = hash_bytes(HASH_START, &scene, sizeof scene);
    t->training = hash_bytes(t->training, trainer_weights(t), trainer_n_weights(t) * sizeof(float));
}

lmn_status trainer_new(const struct workplace *place, const lmn_train_options *options,
                       struct trainer **out, struct error *err)
{
    lmn_status status = LMN_OK;
    const struct scene *s = place->scene;
    uint32_t dim = s->n_variables + PATCH_CORNER_DIMENSIONS;
    struct trainer *t = mem_new(1, sizeof *t);
    if (!t) {
        status = fail_memory(err, "the trainer");
        goto done;
    }
    TRY(options_check(options, err));
    const lmn_train_options *o = &t->options;
    t->options = *options;
    t->place = *place;
    trace_settings_init(&t->trace, s);
    if (o->spp > 0) t->trace.spp = o->spp;
    if (o->has_max_depth) t->trace.max_depth = o->max_depth;
    if (o->has_rr_depth) t->trace.rr_depth = o->rr_depth;
    TRY(tracing_has_photons(o->integrator, place, &t->trace, &t->has_photons, err));
    TRY(history_init(&t->history, o->n_chains, dim, err));
    if (o->method == LMN_METHOD_IMPROVED)
        TRY(new_improved(t, err));
    else
        TRY(new_faithful(t, dim, err));
    trainer_identify(t);
    *out = t;
    t = NULL;
done:
    trainer_free(t);
    return status;
}

void trainer_free(struct trainer *t)
{
    if (!t) return;
    for (uint32_t i = 0; i < t->n_easels; i++) {
        view_free(t->easels[i].view);
        mem_free(t->easels[i].color);
        mem_free(t->easels[i].buffers);
        photon_passes_free(t->easels[i].photons);
    }
    mem_free(t->easels);
    patches_release(&t->states);
    patches_release(&t->proposals);
    mem_free(t->serials);
    mem_free(t->batch.inputs);
    mem_free(t->batch.targets);
    mem_free(t->batch.v);
    mem_free(t->batch.losses);
    mem_free(t->p);
    mem_free(t->norms);
    mem_free(t->is_accepted);
    mem_free(t->slots);
    mem_free(t->gradient);
    explorer_release(&t->explorer);
    replay_release(&t->replay);
    history_release(&t->history);
    adam_release(&t->adam);
    test_set_release(&t->tests);
    if (t->has_painter) painter_release(&t->painter);
    generator_free(t->generator);
    learner_free(t->learner);
    str_release(&t->start_report);
    str_release(&t->line);
    mem_free(t);
}
