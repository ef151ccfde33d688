/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_PHOTON_TARGETS_H
#define RENDER_PHOTON_TARGETS_H

#include "base/rng.h"
#include "render/view.h"

enum { PHOTON_TARGETS = 32 };

/* Spheres around casters; photons start towards one of them, chosen with equal chances. */
struct photon_targets {
    uint32_t n;
    struct vec3 center[PHOTON_TARGETS];
    float radius[PHOTON_TARGETS];
    struct vec3 scene_center;
    float scene_radius;
};

void photon_targets_init(struct photon_targets *t, const struct view *v);

/* A direction from p into one of the cones that the spheres fill, and its density: that of all
 * cones that hold it. */
struct vec3 photon_targets_from(const struct photon_targets *t, struct vec3 p, struct rng *u,
                                float *pdf);

/* A point from which a ray along d runs through one of the spheres, and its density per area across
 * d. */
struct vec3 photon_targets_along(const struct photon_targets *t, struct vec3 d, struct rng *u,
                                 float *pdf);

#endif
