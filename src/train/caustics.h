/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_CAUSTICS_H
#define TRAIN_CAUSTICS_H

#include "render/photon.h"

/*
 * Caustics of the configurations that a worker traces: two small maps of photons, one for each half
 * of the samples. A picture wants many thousands of photons; here a few dozen suffice, as each
 * configuration has its own and the network averages over thousands of them. They cost a fraction
 * of the configuration's paths, which find a caustic seldom and are then far too bright.
 */
struct caustics {
    struct photon_map *maps[2];
};

/* n_photons are emitted for each map. */
lmn_status caustics_init(struct caustics *c, uint32_t n_photons, struct error *err);
void caustics_release(struct caustics *c);
uint64_t caustics_memory_size(const struct caustics *c);

/* Photons of the view's configuration, keyed by the settings' seed, on the calling thread. Each
 * spreads over a circle with a few others: what is focused stays sharp, and what is not makes
 * little noise. Circles shrink with the training's steps, whose network averages over more and more
 * of them, as those of passes do (Knaus & Zwicker 2011), so that no blur stays. */
void caustics_trace(struct caustics *c, const struct view *v, const struct trace_settings *t,
                    uint64_t step);

#endif
