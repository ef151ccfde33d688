/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_NN_PLAIN_H
#define TESTS_NN_PLAIN_H

#include "nn/generator.h"

/* The network and its loss written down once more in doubles, straight from their definitions and
 * sharing nothing with src/nn: what fast code is compared with and differentiated through. */

/* One pixel: inputs [16], v [D], weights in the checkpoint's order; f [3] in the log1p domain. */
void plain_pixel(const struct generator_config *config, const double *weights, const double *inputs,
                 const double *v, double *f);

/* mean(2 |f - t|) + 1 - SSIM(f, t); f, t [side][side][3]. */
double plain_loss(uint32_t side, bool legacy, const double *f, const double *t);

/* The mean over patches of plain_loss() of the network's output. */
double plain_batch_loss(const struct generator_config *config, const double *weights,
                        const struct generator_batch *batch, bool legacy);

#endif
