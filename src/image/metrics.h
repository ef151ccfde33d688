/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_METRICS_H
#define IMAGE_METRICS_H

#include "image/image.h"

/*
 * Image errors as users know them; definitions in lumenaut.h (struct lmn_metrics). Each is equal to
 * its public implementation, which tests check (scikit-image for SSIM and PSNR, flip-evaluator for
 * FLIP). Inputs are interleaved RGB, n_pixels x 3.
 */

/* test and reference must have channels R, G, B (or Y alone), equal sizes and finite values; of
 * radiance below 0 the denominators and the encodings take 0. error_map may be NULL; else it is
 * initialised to the false-coloured (magma) LDR-FLIP map. psnr is INFINITY for equal images. */
lmn_status metrics_compare(const struct image *test, const struct image *reference,
                           lmn_metrics *out, struct image *error_map, struct error *err);

/* The exposure k = 1 / 99th percentile of the reference's values, interpolated as numpy's; 1 when
 * that is not positive. */
double metrics_exposure(const float *rgb, size_t n_values);

/* Mean SSIM over pixels and channels, 11x11 Gaussian of sigma 1.5, C1 = 1e-4, C2 = 9e-4, zero
 * padded (as pytorch_ssim; the loss uses the same). NAN when memory is short. */
double metrics_ssim(const float *a, const float *b, uint32_t width, uint32_t height,
                    uint32_t n_channels);

/* The colour (linear) that an error map shows v of [0,1] in. */
void metrics_magma(float v, float rgb[3]);

#endif
