/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_PLOT_COMPARE_H
#define TRAIN_PLOT_COMPARE_H

#include <stdint.h>

#include "base/error.h"
#include "base/str.h"

/*
 * Draws several runs over each other against the seconds of training: a table of what they reached,
 * which is the legend too, the evaluated errors, the loss of fresh batches, the share of replayed
 * batches and the steps made. When a run knows no times, all are drawn over steps.
 *
 * paths  n_paths runs as plot_run_read() takes them.
 * s      gets the elements of the SVG from y = 0 down, *y where they end.
 */
lmn_status plot_compare(const char *const *paths, uint32_t n_paths, struct str *s, double *y,
                        struct error *err);

#endif
