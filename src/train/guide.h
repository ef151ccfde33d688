/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_GUIDE_H
#define TRAIN_GUIDE_H

#include "base/rng.h"
#include "render/photon.h"

/*
 * Exploration of a configuration's pixels: some go to where light is focused, which is found before
 * any path is traced, by a few photons. What is small and bright there is what the network learns
 * last, and uniform pixels seldom hit it: a sharp caustic is a thousandth of a picture.
 *
 * Pixels there are drawn as densely as GUIDE_MOST times the rest and no more, so that a small
 * caustic costs few of them, and a large one GUIDE_SHARE at most. They weigh as much as others: it
 * is by that factor that the network is made to care. Photons are other ones than those of
 * caustics.h; else pixels would be drawn to where a target is too bright by chance.
 */
#define GUIDE_MOST  8.0f
#define GUIDE_SHARE 0.25f

struct guide {
    struct photon_map *map;
    float *x, *y; /* [n emitted], in pixels: photons in the picture */
};

lmn_status guide_init(struct guide *g, uint32_t n_photons, struct error *err);
void guide_release(struct guide *g);
uint64_t guide_memory_size(const struct guide *g);

/* Moves some of pixels [n] of a picture of the view's configuration; photons are keyed by the
 * settings' seed, what moves where by `r`. */
void guide_pixels(struct guide *g, const struct view *v, const struct trace_settings *t,
                  uint32_t width, uint32_t height, struct rng *r, struct pixel_at *pixels,
                  uint32_t n);

#endif
