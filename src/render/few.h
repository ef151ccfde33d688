/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_FEW_H
#define RENDER_FEW_H

#include "render/embree.h"

struct view;

/*
 * Scenes of few primitives: asking each of them is quicker in vector code than walking a tree. They
 * lie in world space, for one configuration: parallelograms (two triangles in one), triangles,
 * disks and spheres. stream.c casts its rays into them; the plain loop always asks Embree.
 */
enum { FEW_FACES = 32, FEW_SPHERES = 8 };

/* A point of its plane is p + x e0 + y e1. */
struct few_face {
    struct vec3 p, n;         /* n: of any length */
    struct vec3 to_x, to_y;   /* x and y by dot products with what is left of p */
    float most;               /* x + y in a triangle: 1; in a parallelogram: 2 */
    float most2;              /* x^2 + y^2 in a disk: 1; in others: 2 */
    float least;              /* x, y in a disk: -1; in others: 0 */
    struct vec3 ng;           /* as in struct hit */
    uint32_t instance, shape; /* as in struct hit */
    uint32_t triangle[2];     /* where x + y <= 1, and beyond */
    uint8_t corner[2][2];     /* which of the weights 1 - x - y, x, y (beyond: x + y - 1, 1 - y,
                                 1 - x) are the hit's u and v */
};

struct few_sphere {
    double center[3], radius;
    uint32_t instance, shape;
};

struct few {
    uint32_t n_faces, n_spheres; /* both 0: too many primitives, or of other kinds */
    struct few_face faces[FEW_FACES];
    struct few_sphere spheres[FEW_SPHERES];
};

/* Looks whether the view's primitives are few. */
void few_init(struct few *f, const struct view *v);

static inline bool few_is_used(const struct few *f)
{
    return f->n_faces + f->n_spheres > 0;
}

/* What was hit at t: face `index` at (x, y), or sphere index - n_faces; below 0: nothing. */
void few_hit(const struct few *f, int32_t index, float t, float x, float y, struct hit *hit);

#endif
