/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_PLOT_H
#define TRAIN_PLOT_H

#include <stdint.h>

#include "base/error.h"

/*
 * Draws a training run as one self-contained SVG: the loss of fresh and replayed batches over steps
 * (and seconds), acceptance and reuse, the errors that were evaluated on the way, and for every
 * dimension of the exploration where the chains were. Curves are thinned to medians of at most 1000
 * bins. Several runs are compared in one picture instead: see plot_compare.h. svg_path "-" is
 * standard output.
 *
 * paths  n_paths, at least one: what the trainer wrote, metrics.jsonl, one JSON object per line. A
 *        last line without its end (a run that was killed) is left out; where a resumed run repeats
 *        steps, the later lines count. Anything else malformed is an error with file:line.
 *        Or a model: then the metrics beside it are drawn, or else the history inside, which is
 *        coarser and knows no times and no evaluated errors.
 */
lmn_status plot_svg(const char *const *paths, uint32_t n_paths, const char *svg_path,
                    struct error *err);

#endif
