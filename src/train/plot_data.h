/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_PLOT_DATA_H
#define TRAIN_PLOT_DATA_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "train/history.h"

/* Points of a curve, x rising. */
struct series {
    double *x, *y; /* n each; owned */
    size_t n, x_capacity, y_capacity;
};

enum plot_curve {
    PLOT_LOSS_FRESH_BATCH, /* the batch's own loss, when it was traced */
    PLOT_LOSS_REPLAYED_BATCH,
    PLOT_LOSS_ALL,   /* of batches of both kinds, when they are not told apart */
    PLOT_LOSS_FRESH, /* running averages */
    PLOT_LOSS_REPLAYED,
    PLOT_ACCEPTANCE,
    PLOT_REUSE,
    PLOT_SECONDS, /* of training by then */
    PLOT_MAPE,    /* evaluated */
    PLOT_RELMSE,
    PLOT_FLIP,
    PLOT_DSSIM,
    PLOT_N_CURVES
};

/* A training run as plots show it; everything over the step. {0} is a valid empty run. */
struct plot_run {
    struct series curves[PLOT_N_CURVES];
    char **names; /* dimensions of the exploration; n_names, owned */
    size_t n_names;
    struct series *chains; /* n_names: all chains' values in [0,1], x does not fall; owned */
    char *title;           /* may be NULL; owned */
    double first_step, last_step;
};

/* Reads metrics.jsonl or a model; see plot.h. *out must be released in any case. */
lmn_status plot_run_read(const char *path, struct plot_run *out, struct error *err);
/* What a model remembers of its training; names [h->dim]. *out must be released in any case. */
lmn_status plot_run_from_history(const struct history *h, char *const *names, const char *title,
                                 struct plot_run *out, struct error *err);
void plot_run_release(struct plot_run *run);

/* Appends a point; false when memory is short. */
bool series_add(struct series *s, double x, double y);

/* At most n_bins points: medians of bins of equal width. *out is initialised here. */
lmn_status series_thin(const struct series *s, size_t n_bins, struct series *out,
                       struct error *err);
void series_release(struct series *s);

#endif
