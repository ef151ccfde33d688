/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_TRAINER_INSIDE_H
#define TRAIN_TRAINER_INSIDE_H

#include "base/str.h"
#include "nn/adam.h"
#include "train/evaluate.h"
#include "train/explorer.h"
#include "train/learner.h"
#include "train/replay.h"
#include "train/reuse.h"
#include "train/trainer.h"

/* The inside of struct trainer, for trainer.c, trainer_file.c and run_log.c. */

/* Rendered patches as the network takes them, P = patch_size^2; owned. */
struct patches {
    float *inputs;  /* [n][P][GENERATOR_INPUTS] */
    float *targets; /* [n][P][3] */
    float *v;       /* [n][n_variables] */
};

/* What one worker renders a patch in; owned. */
struct easel {
    struct view *view;
    float *color;                  /* [P][3] */
    float *buffers;                /* [P][BUFFER_CHANNELS] */
    struct photon_passes *photons; /* NULL: without photons */
};

/* The patches of the step under way: pointers into the memories that hold them. */
struct batch {
    uint32_t n;
    const float **inputs, **targets, **v; /* [max_batch] */
    float *losses;                        /* [max_batch] */
};

struct trainer {
    struct workplace place;
    lmn_train_options options;
    struct trace_settings trace; /* but for the seed */
    bool has_photons;
    struct learner *learner; /* the improved method; NULL: the faithful one, whose parts follow */

    struct generator_config config;
    uint32_t n_pixels; /* P */

    struct generator *generator;
    struct adam adam;
    float *gradient; /* [n_weights] */

    struct explorer explorer;
    struct patches states, proposals; /* [n_chains]: what the chains' u and proposals look like */
    uint64_t *serials; /* [n_chains]: the states' serial numbers in the replay memory */
    struct replay replay;
    struct reuse reuse;
    struct history history;

    struct easel *easels; /* [n_easels], one per worker */
    uint32_t n_easels;
    struct batch batch;
    float *p;          /* [2][n_chains]: target function of states and proposals */
    float *norms;      /* [2 * n_chains] */
    bool *is_accepted; /* [n_chains] */
    uint32_t *slots;   /* [reuse_batch] */
    uint64_t memory_size;

    uint64_t training; /* which one this is: what it started from, hashed */

    /* How far training is. */
    uint64_t step, n_traced;
    double acceptance; /* running average */

    /* The last step. */
    bool has_stepped; /* since this object was made */
    double loss;
    bool is_fresh;
    uint32_t batch_size;

    /* Processor time / threads. */
    double cpu_s, trace_s, network_s;

    struct str start_report; /* trainer_start.c */

    /* run_log.c */
    struct str line;
    uint64_t chains_told_step; /* last line with the chains; 0: none */

    /* evaluate.c: made when first asked for. */
    struct test_set tests;
    struct painter painter;
    bool has_painter, has_eval;
    lmn_metrics eval;
    lmn_eval_options eval_options;
};

size_t trainer_n_weights(const struct trainer *t);
/* Computes t->training, for a training that is at its start. */
void trainer_identify(struct trainer *t);
float *trainer_weights(const struct trainer *t); /* those that are shown */

/* The virtual resolution of a step (Sec. 6.2). */
uint32_t trainer_resolution(const lmn_train_options *o, uint64_t step);

#endif
