/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_FLIP_H
#define IMAGE_FLIP_H

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

/*
 * FLIP, a difference evaluator for alternating images: Andersson et al. 2020 (LDR) and 2021 (HDR),
 * for a display of 0.7 m and 3840 pixels seen from 0.7 m (67 pixels per degree). Images are width x
 * height x 3, interleaved, *linear* RGB; what is compared are their sRGB-encoded selves, as in
 * version 1.7 of the authors' flip-evaluator.
 */
struct flip; /* scratch memory for images of one size */

lmn_status flip_new(uint32_t width, uint32_t height, struct flip **out, struct error *err);
void flip_free(struct flip *f);

/* Writes the LDR-FLIP map (width * height values in [0,1]) of images that are clamped to [0,1]
 * first. Returns its mean. */
double flip_ldr(struct flip *f, const float *reference, const float *test, float *map);

/* The same for radiance, the mean alone: per pixel the largest LDR-FLIP over a range of exposures,
 * which the reference's luminances decide, under the ACES tone curve. */
double flip_hdr(struct flip *f, const float *reference, const float *test);

#endif
