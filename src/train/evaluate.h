/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_EVALUATE_H
#define TRAIN_EVALUATE_H

#include "train/painter.h"

/*
 * The fixed test set: n configurations drawn uniformly by scene_random_units(), keyed by (seed,
 * index), so that a larger n only adds; their path-traced references; and the network's error on
 * them.
 */
struct test_set {
    lmn_eval_options options;    /* with the defaults filled in */
    struct trace_settings trace; /* of the references, but for the seed */
    bool has_photons;            /* the references; false until someone sets it */
    uint32_t width, height;
    float *u;                 /* [n][n_variables]; owned, as all below */
    struct image *references; /* [n], R G B */
    double *trace_s;          /* [n] */
    lmn_metrics noise;        /* the noise floor, see test_set_trace() */
    uint32_t n_traced;
};

/* options' zeros become the documented defaults; of `trace` the path depths count. */
lmn_status test_set_init(struct test_set *set, const struct scene *s,
                         const lmn_eval_options *options, const struct trace_settings *trace,
                         struct error *err);
void test_set_release(struct test_set *set);

/*
 * Traces the references that are missing. The noise floor is the error of one half of the samples
 * against the mean m = (a + b) / 2 of both: a - m = (a - b) / 2 has exactly the variance of m's own
 * noise, so this is what a perfect picture would be charged, for every metric.
 */
lmn_status test_set_trace(struct test_set *set, const struct workplace *place,
                          lmn_progress_fn *progress, void *progress_user, struct error *err);

/* Renders the set by the network and compares. each [n] and sheet may be NULL. */
lmn_status test_set_evaluate(const struct test_set *set, struct painter *painter,
                             lmn_eval_result *out, lmn_metrics *each, struct image *sheet,
                             struct error *err);

#endif
