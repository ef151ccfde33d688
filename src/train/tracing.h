/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_TRACING_H
#define TRAIN_TRACING_H

#include "render/photon.h"
#include "train/trainer.h"

/*
 * How patches and references are traced. With photons a patch gets maps of its own, of its
 * configuration: fewer than a picture has, as a patch has fewer pixels, and traced by the worker
 * that traces the patch.
 */

/* With photons? Where that is left to the scene: when its default configuration wants them, or one
 * of a few drawn at random. A function of the scene and the settings alone.
 * integrator: LMN_INTEGRATOR_*. */
lmn_status tracing_has_photons(uint32_t integrator, const struct workplace *place,
                               const struct trace_settings *t, bool *out, struct error *err);

/* Photons in each map of a patch of n_pixels, traced with spp samples. */
uint32_t tracing_n_photons(uint32_t n_pixels, uint32_t spp);

#endif
