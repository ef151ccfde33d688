/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_LEARNER_H
#define TRAIN_LEARNER_H

#include "train/memory.h"
#include "train/painter.h"
#include "train/safetensors.h"
#include "train/trainer.h"

/*
 * The improved method: the compact network (nn/field.h) trained on scattered pixels of very many
 * configurations, each traced with few samples (method 3.2, 3.3). Every step traces some new
 * configurations, keeps their pixels in a memory, and trains on configurations drawn from it.
 *
 * Targets are what surfaces scatter: radiance without what they emit, which buffers know exactly.
 * Where light paths meet a rough surface, the network says what it scatters: tails.h.
 */
struct learner_options {
    uint64_t seed;
    uint32_t width, depth; /* of the network */
    uint32_t n_fresh;      /* configurations traced per step */
    uint32_t n_pixels;     /* of each */
    uint32_t spp;          /* of each pixel; rounded up to a multiple of 4 */
    uint32_t n_looks; /* exploration: pixels of each that are looked at to choose them; 0: none */
    double children; /* exploration: share of configurations near bad ones. By default both are off:
                        neither has paid (docs/algorithm.md), unlike guide.h */
    uint32_t n_roots;     /* of these: roots of tails.h, where paths are long; 0: never cut */
    uint32_t n_photons;   /* for each half of a configuration's samples, and for its pixels half as
                             many (guide.h); 0: paths alone, uniform pixels */
    uint64_t cut_after;   /* steps: a network that knows nothing would be believed */
    uint32_t n_batch;     /* configurations per step to train on: n_fresh or more */
    uint32_t memory_mib;  /* bound of the memory of pixels */
    uint32_t resolution;  /* of the pictures that pixels are drawn from, longer side: so large that
                             they are points, as half a pixel of another surface teaches nothing */
    bool explores;        /* false: uniform pixels of uniform configurations */
    double learning_rate; /* of layers; tables learn TABLE_RATE times as fast */
    double warm_steps;    /* the rate falls as 1 / sqrt(1 + step / warm_steps) */
    double average;       /* weights shown are an average over this share of all steps */
    uint32_t without;     /* of LMN_WITHOUT_* */
};

/* The grids of all models. */
struct grid_config learner_grid(void);

/* What a training's options say of it. */
void learner_options_init(struct learner_options *o, const lmn_train_options *from);

struct learner;

/* Paths are traced by `trace`, but for spp, seed and what learning needs otherwise. */
lmn_status learner_new(const struct workplace *place, const struct learner_options *options,
                       const struct trace_settings *trace, struct learner **out, struct error *err);
void learner_free(struct learner *l);

/* The weights of the network, which the caller has changed before the first step, are what learning
 * starts from. */
void learner_start(struct learner *l);

struct learner_stats {
    uint64_t step, n_configurations; /* traced so far */
    double loss;                     /* of the last batch */
    uint32_t n_batch;                /* configurations in it */
    double trace_s, network_s;       /* processor time / threads */
    uint64_t memory_bytes;
};

/* Fails only when the loss is no longer a number; weights, memory and counters are then as they
 * were before the step. */
lmn_status learner_step(struct learner *l, struct learner_stats *stats, struct error *err);

/* The k-th last configuration that was traced; NULL: there are no more. [n_variables] */
const float *learner_configuration(const struct learner *l, uint32_t k);

void learner_get_stats(const struct learner *l, struct learner_stats *stats);

/* The weights that are shown are averages over the last steps. Between a call with `true` and the
 * next with `false` the network has them instead of those that are learnt. */
void learner_show_average(struct learner *l, bool is_shown);
struct painter_network learner_network(const struct learner *l);
const struct field_config *learner_field_config(const struct learner *l);
float *learner_average(struct learner *l); /* [n_weights] */

/*
 * Checkpoints: what training goes on with, besides the averaged weights, to write or to read into.
 * The progress comes first, as it says how much of the memory is in use; false when the numbers
 * contradict each other. learner_restore() after reading: checks values.
 */
enum { LEARNER_TENSORS = 5 + MEMORY_TENSORS };
uint32_t learner_tensors(struct learner *l, struct tensor *out);
bool learner_set_progress(struct learner *l, uint64_t step, uint64_t n_configurations);
lmn_status learner_restore(struct learner *l, const char *path, struct error *err);

#endif
