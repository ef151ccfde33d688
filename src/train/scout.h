/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_SCOUT_H
#define TRAIN_SCOUT_H

#include "render/view.h"
#include "train/memory.h"
#include "train/sight.h"
#include "train/trainer.h"

/*
 * Exploration: which configurations, and which of their pixels, are worth the tracing of light
 * paths. More pixels than can be traced are looked at first by their buffers alone, a few
 * hundredths of the cost; the network says what loss it expects of each (field.h), and pixels are
 * drawn in proportion to its square root, which makes the variance of the gradient the least for
 * the number of pixels (Katharopoulos & Fleuret 2018). Weights keep the loss an estimate over the
 * whole space.
 */
struct scout_options {
    uint64_t seed;
    uint32_t n_fresh;  /* configurations of a step */
    uint32_t n_pixels; /* to trace of each */
    uint32_t n_looks;  /* pixels of each that are looked at; n_pixels or more. 0: no exploration */
    double children;   /* share of configurations that are moved copies of bad ones */
    uint32_t width, height; /* of the pictures */
};

struct scout;

/* Everything must outlive it. */
lmn_status scout_new(const struct workplace *place, const struct sight *sight, struct field *field,
                     const struct scout_options *options, struct scout **out, struct error *err);
void scout_free(struct scout *s);
uint64_t scout_memory_size(const struct scout *s);

/* Chooses the configurations of the step whose first has the number `serial`, and what to trace of
 * them. views [workers]. The result is there until the next call. */
void scout_go(struct scout *s, struct view *const *views, const struct memory *memory,
              uint64_t serial);

/* Of the i-th configuration: u [n_variables], lights' powers at the reference; the pixels
 * [n_pixels] and their weights in the mean of the loss. */
const float *scout_u(const struct scout *s, uint32_t i);
const struct pixel_at *scout_pixels(const struct scout *s, uint32_t i);
const float *scout_weights(const struct scout *s, uint32_t i);

#endif
