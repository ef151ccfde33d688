/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_TAILS_H
#define TRAIN_TAILS_H

#include "train/sight.h"

/*
 * Light paths are cut at the first rough surface after the first hit (trace_output.ends), and what
 * that surface scatters is what the network says by now: the radiance cache of Müller et al. 2021,
 * "Real-time Neural Radiance Caching for Path Tracing", section 3. Samples cost a third, and have a
 * tenth of the variance where light is mostly indirect.
 *
 * The network must know surfaces that no camera sees: some pixels of each configuration are roots,
 * rays that met an end. Scenes count a bounded number of bounces, so that what an end scatters is
 * less than what a camera sees there: the network is told how many are left.
 *
 * An end costs what tracing some more surfaces does, so paths of open or shallow scenes are traced
 * whole: END_COST in learner.c.
 */
struct tails;

/* n_items configurations with at most `capacity` ends each. */
lmn_status tails_new(const struct sight *sight, uint32_t n_items, uint32_t capacity,
                     struct tails **out, struct error *err);
void tails_free(struct tails *t);
uint64_t tails_memory_size(const struct tails *t);

/* An item's list of ends, for trace_output; begins empty with tails_clear(). */
struct path_ends *tails_ends(struct tails *t, uint32_t item);
void tails_clear(struct tails *t, uint32_t item);

/* Ends that were added since the last call belong to targets [n][n_lights][3], means of spp
 * samples. Any thread, one per item. */
void tails_look(struct tails *t, uint32_t item, const struct scene_state *state, float *targets,
                uint32_t spp);

/* Adds to all targets what the network says of the items' configurations us(user, item). */
typedef const float *tails_u_fn(const void *user, uint32_t item);
void tails_add(struct tails *t, struct field *field, tails_u_fn *us, const void *user);

#endif
