/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_SSIM_H
#define IMAGE_SSIM_H

#include <stdint.h>

#include "base/error.h"

/*
 * The structural similarity map (Wang et al. 2004) of one plane against another: height x width
 * values each, rows contiguous. Gaussian window of 11x11, sigma 1.5, C1 = 0.01^2, C2 = 0.03^2 (a
 * data range of 1). Outside the plane everything is 0 (as pytorch_ssim pads); scikit-image agrees
 * away from the border, which it leaves out of its mean.
 */
enum { SSIM_RADIUS = 5 };

struct ssim; /* scratch memory for planes of one size */

lmn_status ssim_new(uint32_t width, uint32_t height, struct ssim **out, struct error *err);
void ssim_free(struct ssim *s);

/* The value i of a plane is a[i * stride]. map: width * height, may be NULL. Returns the map's sum.
 */
double ssim_plane(struct ssim *s, const float *a, const float *b, uint32_t stride, float *map);

/* Mean SSIM over pixels and channels of interleaved images (each channel a plane). */
lmn_status ssim_mean(const float *a, const float *b, uint32_t width, uint32_t height,
                     uint32_t n_channels, double *out, struct error *err);

/* The same over the axes of the paper's authors' code: each row of the image is a plane, whose
 * window slides over (column, channel). */
lmn_status ssim_mean_legacy(const float *a, const float *b, uint32_t width, uint32_t height,
                            uint32_t n_channels, double *out, struct error *err);

#endif
