/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_LOSS_H
#define NN_LOSS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 * The loss of one square patch and its gradient (Diolatzis et al. 2022, Sec. 6.1; Granskog et al.
 * 2020): mean(2 |f - t|) + 1 - SSIM(f, t), both in the log1p domain.
 *
 * SSIM (Wang et al. 2004) with an 11x11 Gaussian of sigma 1.5, C1 = 1e-4, C2 = 9e-4, zero padded,
 * averaged over pixels and colours. `legacy` gives the axes of the authors' code: the window slides
 * over (column, colour) of each row alone.
 */

/* Floats of scratch that loss_patch() needs for patches of this side. */
size_t loss_scratch_count(uint32_t side);

/*
 * f, t   [3][side * side], planes
 * df     [3][side * side], gradient of the loss with respect to f; NULL when not wanted
 * Returns the loss.
 */
double loss_patch(uint32_t side, bool legacy, const float *f, const float *t, float *df,
                  float *scratch);

#endif
