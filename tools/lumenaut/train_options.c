/* SPDX-License-Identifier: Apache-2.0 */
/* The options of lumenaut train. */
#include "train_args.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const struct arg_option run_options[] = {
    {.name = "output",
     .letter = 'o',
     .type = ARG_FILE,
     .argument = "FILE",
     .help = "the model to write; beside it go FILE.state, which --resume needs, and the log",
     .offset = offsetof(struct train_args, output)},
    {.name = "steps",
     .type = ARG_WHOLE,
     .argument = "N",
     .help = "stop after N optimiser steps in all",
     .fallback = "no limit",
     .offset = offsetof(struct train_args, steps)},
    {.name = "time",
     .type = ARG_DURATION,
     .argument = "TIME",
     .help = "stop after this much processor time divided by threads, as 90s, 15m or 2h",
     .fallback = "15m when nothing else stops the run",
     .offset = offsetof(struct train_args, time_s)},
    {.name = "target",
     .type = ARG_TEXT,
     .argument = "METRIC=X",
     .help = "stop when the network reaches this error on the test set, as mape=0.1",
     .fallback = "none",
     .offset = offsetof(struct train_args, target)},
    {.name = "from",
     .type = ARG_FILE,
     .argument = "MODEL",
     .help = "start from the weights of a model that was trained on another version of the scene",
     .fallback = "none",
     .offset = offsetof(struct train_args, from)},
    {.name = "resume",
     .type = ARG_FLAG,
     .help = "go on where FILE stopped",
     .offset = offsetof(struct train_args, resume)},
    {.name = "force",
     .type = ARG_FLAG,
     .help = "resume although the scene has changed",
     .offset = offsetof(struct train_args, force)},
    {.name = "checkpoint-every",
     .type = ARG_INTERVAL,
     .argument = "WHEN",
     .help = "write FILE every so many steps (100i) or so often (5m)",
     .fallback = "5m",
     .offset = offsetof(struct train_args, checkpoint_every)},
    {.name = "eval-every",
     .type = ARG_INTERVAL,
     .argument = "WHEN",
     .help = "measure the error on the test set every so many steps (100i) or so much training "
             "time (2m), or never",
     .fallback = "2m",
     .offset = offsetof(struct train_args, eval_every)},
    {.name = "eval-n",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "configurations of the test set",
     .min = 1,
     .max = 4096,
     .offset = offsetof(struct train_args, eval_n)},
    {.name = "eval-size",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "pixels of the longer side of its pictures",
     .min = 11,
     .max = 4096,
     .offset = offsetof(struct train_args, eval_size)},
    {.name = "eval-spp",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "samples per pixel of its references",
     .min = 2,
     .max = 1 << 20,
     .offset = offsetof(struct train_args, eval_spp)},
    {.name = "eval-seed",
     .type = ARG_WHOLE,
     .argument = "N",
     .help = "seed of the test set",
     .offset = offsetof(struct train_args, eval_seed)},
    {.name = "json",
     .type = ARG_FLAG,
     .help = "print one JSON document about the run on stdout",
     .offset = offsetof(struct train_args, json)},
    {.name = "view",
     .type = ARG_FLAG,
     .help = "serve a page that shows the scene as it is learnt, and how; costs nothing while "
             "nobody looks",
     .offset = offsetof(struct train_args, view)},
};

/* Where the options of training find the flag that tells whether they were given. */
#define GIVEN(name) (offsetof(struct train_args, given.name) - offsetof(struct train_args, options))

static const struct arg_option network_options[] = {
    {.name = "method",
     .type = ARG_CHOICE,
     .argument = "NAME",
     .help = "faithful: the paper's network, exploration and reuse; improved: a compact network on "
             "learnt grids, trained on scattered pixels",
     .choices = "faithful improved",
     .fallback = "improved",
     .offset = offsetof(lmn_train_options, method),
     .given = GIVEN(method)},
    {.name = "seed",
     .type = ARG_WHOLE,
     .argument = "N",
     .help = "seed of all random numbers",
     .offset = offsetof(lmn_train_options, seed)},
    {.name = "width",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "features per layer",
     .fallback = "512; improved: 64",
     .min = 1,
     .max = 1024,
     .offset = offsetof(lmn_train_options, width),
     .given = GIVEN(width)},
    {.name = "depth",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "hidden layers after the first two; improved: hidden layers",
     .fallback = "8; improved: 3",
     .min = 0,
     .max = 32,
     .offset = offsetof(lmn_train_options, depth),
     .given = GIVEN(depth)},
    {.name = "learning-rate",
     .type = ARG_NUMBER,
     .argument = "X",
     .help = "step size of Adam",
     .fallback = "0.0001; improved: 0.005, falling",
     .min = 1e-12,
     .max = 1,
     .offset = offsetof(lmn_train_options, learning_rate),
     .given = GIVEN(learning_rate)},
    {.name = "legacy-ssim",
     .type = ARG_FLAG,
     .help = "slide the SSIM window over the axes that the authors' code has",
     .offset = offsetof(lmn_train_options, legacy_ssim)},
};

static const struct arg_option explore_options[] = {
    {.name = "explore",
     .type = ARG_CHOICE,
     .argument = "HOW",
     .help = "where new configurations come from; improved: whether more pixels go to where light "
             "is focused (active) or not (uniform)",
     .choices = "active uniform loss-only",
     .offset = offsetof(lmn_train_options, explore)},
    {.name = "chains",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "Markov chains",
     .min = 1,
     .max = 1024,
     .offset = offsetof(lmn_train_options, n_chains)},
    {.name = "large-step",
     .type = ARG_NUMBER,
     .argument = "X",
     .help = "probability of a fresh uniform proposal",
     .min = 0,
     .max = 1,
     .offset = offsetof(lmn_train_options, large_step)},
    {.name = "step-min",
     .type = ARG_NUMBER,
     .argument = "X",
     .help = "smallest small step (s1 of Kelemen)",
     .min = 1e-6,
     .max = 0.5,
     .offset = offsetof(lmn_train_options, step_min)},
    {.name = "step-max",
     .type = ARG_NUMBER,
     .argument = "X",
     .help = "largest small step (s2 of Kelemen)",
     .min = 1e-6,
     .max = 0.5,
     .offset = offsetof(lmn_train_options, step_max)},
    {.name = "no-preconditioning",
     .type = ARG_FLAG,
     .help = "the ablation of Sec. 7.3: position has no layer of its own",
     .offset = offsetof(lmn_train_options, no_preconditioning)},
};

static const struct arg_option reuse_options[] = {
    {.name = "no-reuse",
     .type = ARG_FLAG,
     .help = "train on new patches only",
     .offset = offsetof(lmn_train_options, no_reuse)},
    {.name = "reuse-bias",
     .type = ARG_NUMBER,
     .argument = "X",
     .help = "beta of Eq. 5",
     .min = -100,
     .max = 100,
     .offset = offsetof(lmn_train_options, reuse_bias)},
    {.name = "reuse-ema",
     .type = ARG_NUMBER,
     .argument = "X",
     .help = "decay of the averages of Eq. 5",
     .min = 0,
     .max = 0.999999,
     .offset = offsetof(lmn_train_options, reuse_ema)},
    {.name = "reuse-warmup",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "batches of new patches before reuse may start",
     .min = 1,
     .max = 1000000000,
     .offset = offsetof(lmn_train_options, reuse_warmup)},
    {.name = "reuse-batch",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "patches per replayed batch",
     .min = 1,
     .max = 4096,
     .offset = offsetof(lmn_train_options, reuse_batch)},
    {.name = "replay-capacity",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "patches kept for reuse, when --memory allows",
     .min = 1,
     .max = 100000000,
     .offset = offsetof(lmn_train_options, replay_capacity)},
    {.name = "memory",
     .type = ARG_COUNT,
     .argument = "MIB",
     .help = "bound of their memory; improved: of the pixels that are kept",
     .fallback = "1024; improved: 256",
     .min = 1,
     .max = 1 << 20,
     .offset = offsetof(lmn_train_options, memory_mib),
     .given = GIVEN(memory)},
};

static const struct arg_option resolution_options[] = {
    {.name = "patch-size",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "side of training patches in pixels",
     .min = 4,
     .max = 256,
     .offset = offsetof(lmn_train_options, patch_size)},
    {.name = "no-growth",
     .type = ARG_FLAG,
     .help = "stay at --resolution-start",
     .offset = offsetof(lmn_train_options, no_growth)},
    {.name = "resolution-start",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "virtual resolution at first",
     .min = 4,
     .max = 16384,
     .offset = offsetof(lmn_train_options, resolution_start)},
    {.name = "resolution-max",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "and at most; improved: of the pictures that pixels are drawn from",
     .fallback = "600; improved: 16384",
     .min = 4,
     .max = 16384,
     .offset = offsetof(lmn_train_options, resolution_max),
     .given = GIVEN(resolution_max)},
    {.name = "resolution-step",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "how much it grows at a time",
     .min = 0,
     .max = 16384,
     .offset = offsetof(lmn_train_options, resolution_step)},
    {.name = "resolution-every",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "after how many steps it grows",
     .min = 1,
     .max = 1000000000,
     .offset = offsetof(lmn_train_options, resolution_every)},
};

static const struct arg_option tracing_options[] = {
    {.name = "spp",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "samples per pixel of training patches",
     .fallback = "the scene's; improved: 8",
     .min = 1,
     .max = 1 << 24,
     .offset = offsetof(lmn_train_options, spp),
     .given = GIVEN(spp)},
    {.name = "max-depth",
     .type = ARG_INTEGER,
     .argument = "N",
     .help = "longest path; 1 shows light sources only, -1 is no limit",
     .fallback = "the scene's",
     .min = -1,
     .max = 1 << 20,
     .offset = offsetof(lmn_train_options, max_depth),
     .given = offsetof(lmn_train_options, has_max_depth)},
    {.name = "rr-depth",
     .type = ARG_INTEGER,
     .argument = "N",
     .help = "path length from which Russian roulette plays",
     .fallback = "the scene's",
     .min = 1,
     .max = 1 << 20,
     .offset = offsetof(lmn_train_options, rr_depth),
     .given = offsetof(lmn_train_options, has_rr_depth)},
    {.name = "integrator",
     .type = ARG_CHOICE,
     .argument = "NAME",
     .help = "how training images and references are traced; photons bring caustics, auto uses "
             "them where the scene wants them",
     .choices = "path path+photons auto",
     .fallback = "path; improved: auto",
     .offset = offsetof(lmn_train_options, integrator),
     .given = GIVEN(integrator)},
};

const struct arg_group train_groups[] = {
    {"Run", run_options, COUNT_OF(run_options), 0},
    {"Network and optimiser", network_options, COUNT_OF(network_options),
     offsetof(struct train_args, options)},
    {"Exploration", explore_options, COUNT_OF(explore_options),
     offsetof(struct train_args, options)},
    {"Sample reuse", reuse_options, COUNT_OF(reuse_options), offsetof(struct train_args, options)},
    {"Resolution", resolution_options, COUNT_OF(resolution_options),
     offsetof(struct train_args, options)},
    {"Ground truth", tracing_options, COUNT_OF(tracing_options),
     offsetof(struct train_args, options)},
    {"Scene", scene_options, COUNT_OF(scene_options), offsetof(struct train_args, scene)},
    {"Page (--view)", view_options, COUNT_OF(view_options), offsetof(struct train_args, page)},
    COMMON_GROUP,
};
const size_t n_train_groups = COUNT_OF(train_groups);

void train_args_init(void *args)
{
    struct train_args *a = args;
    lmn_train_options_init(&a->options);
    view_args_init(&a->page);
    a->checkpoint_every.seconds = 300.0;
    a->eval_every.seconds = 120.0;
    a->eval_n = 8;
    a->eval_size = 64;
    a->eval_spp = 256;
}

static size_t size_of(enum arg_type type)
{
    return type == ARG_NUMBER || type == ARG_WHOLE ? 8 : 4;
}

/* All options of training that the improved method knows. */
static bool is_improved(const char *name)
{
    static const char *const names[] = {"method",   "seed",           "width",      "depth",
                                        "memory",   "learning-rate",  "spp",        "max-depth",
                                        "rr-depth", "resolution-max", "integrator", "explore"};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        if (strcmp(names[i], name) == 0) return true;
    return false;
}

const char *train_args_finish(struct train_args *a)
{
    lmn_train_options faithful, improved;
    lmn_train_options *o = &a->options;
    lmn_train_options_init(&faithful);
    if (!a->given.method && !a->resume) o->method = LMN_METHOD_IMPROVED;
    if (o->method != LMN_METHOD_IMPROVED) return NULL;
    for (size_t g = 0; g < n_train_groups; g++) {
        if (train_groups[g].base != offsetof(struct train_args, options)) continue;
        for (size_t i = 0; i < train_groups[g].n; i++) {
            const struct arg_option *option = &train_groups[g].options[i];
            const char *asked = (const char *)o + option->offset;
            if (memcmp(asked, (const char *)&faithful + option->offset, size_of(option->type)) &&
                !is_improved(option->name))
                return option->name;
        }
    }
    lmn_train_options_init_method(&improved, LMN_METHOD_IMPROVED);
    if (!a->given.width) o->width = improved.width;
    if (!a->given.depth) o->depth = improved.depth;
    if (!a->given.learning_rate) o->learning_rate = improved.learning_rate;
    if (!a->given.memory) o->memory_mib = improved.memory_mib;
    if (!a->given.spp) o->spp = improved.spp;
    if (!a->given.resolution_max) o->resolution_max = improved.resolution_max;
    if (!a->given.integrator) o->integrator = improved.integrator;
    return NULL;
}

static const struct {
    const char *name;
    size_t offset;
} target_names[] = {
    {"mape", offsetof(lmn_metrics, mape)},     {"mae", offsetof(lmn_metrics, mae)},
    {"relmse", offsetof(lmn_metrics, relmse)}, {"mse", offsetof(lmn_metrics, mse)},
    {"psnr", offsetof(lmn_metrics, psnr)},     {"dssim", offsetof(lmn_metrics, dssim)},
    {"flip", offsetof(lmn_metrics, flip)},     {"flip_hdr", offsetof(lmn_metrics, flip_hdr)},
};

bool train_target_parse(const char *text, struct train_target *out)
{
    const char *equals = strchr(text, '=');
    char *end;
    if (!equals) return false;
    for (size_t i = 0; i < COUNT_OF(target_names); i++) {
        const char *name = target_names[i].name;
        if (strlen(name) != (size_t)(equals - text) || strncmp(name, text, strlen(name)) != 0)
            continue;
        out->offset = target_names[i].offset;
        out->is_floor = strcmp(name, "psnr") == 0;
        out->value = strtod(equals + 1, &end);
        return end != equals + 1 && *end == '\0' && isfinite(out->value) && out->value > 0.0;
    }
    return false;
}

bool train_target_reached(const struct train_target *t, const lmn_metrics *m)
{
    double value;
    memcpy(&value, (const char *)m + t->offset, sizeof value);
    return t->is_floor ? value >= t->value : value <= t->value;
}

const char *train_args_conflict(const struct train_args *a, const lmn_train_options *used)
{
    lmn_train_options defaults;
    lmn_train_options_init(&defaults);
    for (size_t g = 0; g < n_train_groups; g++) {
        if (train_groups[g].base != offsetof(struct train_args, options)) continue;
        for (size_t i = 0; i < train_groups[g].n; i++) {
            const struct arg_option *o = &train_groups[g].options[i];
            const char *asked = (const char *)&a->options + o->offset;
            const size_t size = size_of(o->type);
            uint32_t is_given = 1;
            if (o->given) memcpy(&is_given, (const char *)&a->options + o->given, sizeof is_given);
            if (!is_given) continue;
            if (memcmp(asked, (const char *)&defaults + o->offset, size) != 0 &&
                memcmp(asked, (const char *)used + o->offset, size) != 0)
                return o->name;
        }
    }
    return NULL;
}
