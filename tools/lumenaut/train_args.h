/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_ARGS_H
#define TRAIN_ARGS_H

#include "cli_options.h"
#include "view_host.h"

struct train_args {
    struct common_args common;
    struct scene_args scene;
    lmn_train_options options;
    struct {
        uint32_t method, width, depth, learning_rate, memory, spp, resolution_max,
            integrator; /* 1: on the command line */
    } given;
    const char *output, *from;
    /* when to stop: the first that is reached; 0, NULL: not asked for */
    uint64_t steps;
    double time_s;
    const char *target;
    /* what is kept, and how the run is watched */
    uint32_t resume, force;
    struct arg_interval checkpoint_every, eval_every;
    uint32_t eval_n, eval_size, eval_spp;
    uint64_t eval_seed;
    uint32_t json;
    uint32_t view; /* 1: with a page */
    struct view_args page;
};

extern const struct arg_group train_groups[];
extern const size_t n_train_groups;

void train_args_init(void *args);

/* Completes what was read: the method's own defaults for what the command line leaves open. NULL,
 * or the name of an option that the method has not. */
const char *train_args_finish(struct train_args *a);

/* "mape=0.1" */
struct train_target {
    size_t offset; /* of a double in lmn_metrics */
    double value;
    bool is_floor; /* PSNR: more is better */
};
bool train_target_parse(const char *text, struct train_target *out);
bool train_target_reached(const struct train_target *t, const lmn_metrics *m);

/* The options of training that the command line changed and that differ from `used`, the ones of
 * the run that is resumed: the name of the first, or NULL. */
const char *train_args_conflict(const struct train_args *a, const lmn_train_options *used);

#endif
