/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_PLOT_LEARNING_H
#define TRAIN_PLOT_LEARNING_H

#include "base/error.h"

/*
 * Draws what `lumenaut bench learn` found on one scene: errors against seconds of training, tracing
 * included, both logarithmic; a panel per metric and test set. Of each method the median over its
 * seeds, within a band from the least to the largest; the references' own noise as a dashed line.
 *
 * path   results.json; a malformed one is an error that names it.
 * scene  the name of a scene in it.
 */
lmn_status plot_learning_svg(const char *path, const char *scene, const char *svg_path,
                             struct error *err);

#endif
