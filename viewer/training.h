/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VIEWER_TRAINING_H
#define VIEWER_TRAINING_H

#include "messages.h"

/*
 * What pages are told of a training: its curve, thinned out to CURVE_POINTS, the time that viewing
 * takes, and where it learns.
 */
enum { CURVE_POINTS = 400, TOLD_STATES = 64 };

struct training {
    lmn_trainer *trainer;
    uint32_t n_variables;
    bool has_chains;                /* the paper's method: acceptance and reuse mean something */
    double points[CURVE_POINTS][2]; /* seconds, mean loss since the last point */
    uint32_t n_points;
    double every_s, next_s; /* of training time: between points, and the next one */
    double loss_sum;
    uint32_t n_losses;
    /* Late time, in seconds that fade: of viewing, of all; and steps then. */
    double view_s, all_s, steps;
    double last_clock_s, told_clock_s;
    uint64_t last_step;
    double *states; /* [TOLD_STATES][n_variables], owned */
};

bool training_init(struct training *t, lmn_trainer *trainer, uint32_t n_variables);
void training_release(struct training *t);

/* A step was made, and then viewing took so long. */
void training_note(struct training *t, const lmn_train_stats *stats, double view_s);
double training_view_share(const struct training *t);

/* Whether it is time to tell pages again. */
bool training_is_due(struct training *t);
char *training_text(struct training *t, const lmn_train_stats *stats, bool is_running,
                    bool is_whole);

#endif
