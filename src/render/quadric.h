/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_QUADRIC_H
#define RENDER_QUADRIC_H

#include <stdbool.h>

#include "scene/scene.h"

/*
 * Spheres, disks and cylinders as rays meet them: exactly, in double, in the space of their group.
 */
struct quadric {
    enum shape_kind kind;
    double center[3], radius;  /* sphere */
    struct transform to_group; /* others */
};

struct quadric_ray {
    double o[3], d[3], t_min, t_max;
};

void quadric_init(struct quadric *q, const struct shape *s);

/* A box around it, with a little room for rounding. */
void quadric_bounds(const struct quadric *q, float low[3], float high[3]);

/* The first t in [t_min, t_max] at which the ray meets it. */
bool quadric_hit(const struct quadric *q, const struct quadric_ray *r, double *t);

/* The outer normal where a hit was found, of any length. */
void quadric_normal(const struct quadric *q, const struct quadric_ray *r, double t, float n[3]);

#endif
