/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_LEARNER_H
#define TRAIN_LEARNER_H

#include "nn/field.h"
#include "train/sight.h"
#include "train/trainer.h"

/*
 * The improved method: the compact network (nn/field.h) trained on scattered pixels of very many
 * configurations, each traced with few samples (method 3.2, 3.3). Every step traces some new
 * configurations, keeps their pixels in a memory, and trains on configurations drawn from it.
 *
 * Targets are what surfaces scatter: radiance without what they emit, which buffers know exactly.
 */
struct learner_options {
    uint64_t seed;
    uint32_t width, depth; /* of the network */
    uint32_t n_fresh;      /* configurations traced per step */
    uint32_t n_pixels;     /* of each */
    uint32_t spp;          /* of each pixel */
    uint32_t n_batch;      /* configurations per step to train on */
    uint32_t memory_mib;   /* bound of the memory of pixels */
    uint32_t resolution;   /* of the pictures that pixels are drawn from, longer side */
    double learning_rate;  /* of layers; tables learn TABLE_RATE times as fast */
    double warm_steps;     /* the rate falls as 1 / sqrt(1 + step / warm_steps) */
    double average;        /* weights shown are an exponential average with this memory */
};

void learner_options_init(struct learner_options *o);

struct learner;

lmn_status learner_new(const struct workplace *place, const struct learner_options *options,
                       struct learner **out, struct error *err);
void learner_free(struct learner *l);

struct learner_stats {
    uint64_t step, n_configurations, n_pixels; /* traced so far */
    double loss;                               /* of the last batch */
    double trace_s, network_s;                 /* processor time / threads */
    uint64_t memory_bytes;
};

/* Fails only when the loss is no longer a number. */
lmn_status learner_step(struct learner *l, struct learner_stats *stats, struct error *err);

/* One frame of the configuration u by the averaged weights: out [height][width][3]. */
lmn_status learner_render(struct learner *l, const float *u, uint32_t width, uint32_t height,
                          uint32_t buffer_spp, float *out, struct error *err);

#endif
