/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_FEW_H
#define RENDER_FEW_H

#include "render/embree.h"

struct view;

/*
 * Scenes of few primitives: asking each of them is quicker in vector code than walking a tree. They
 * lie in world space, for one configuration: boxes (six parallelograms in one), walls (rectangles
 * along the axes), parallelograms (two triangles in one), triangles, disks and spheres. stream.c
 * casts its rays into them; the plain loop always asks Embree.
 */
enum {
    FEW_LOOSE = 32, /* faces that are no part of a box: walls and others */
    FEW_BOXES = 8,
    FEW_FACES = FEW_LOOSE + 6 * FEW_BOXES,
    FEW_SPHERES = 8,
    FEW_ALL = FEW_FACES + FEW_SPHERES
};

/* A point of its plane is p + x e0 + y e1. */
struct few_face {
    struct vec3 p, e0, e1, n; /* n: of any length */
    struct vec3 to_x, to_y;   /* x and y by dot products with what is left of p */
    float most;               /* x + y in a triangle: 1; in a parallelogram: 2 */
    float most2;              /* x^2 + y^2 in a disk: 1; in others: 2 */
    float least;              /* x, y in a disk: -1; in others: 0 */
    struct vec3 ng;           /* as in struct hit */
    uint32_t instance, shape; /* as in struct hit */
    bool shades;              /* false: nothing lies beyond it that could lose light by it */
    uint32_t triangle[2];     /* where x + y <= 1, and beyond */
    uint8_t corner[2][2];     /* which of the weights 1 - x - y, x, y (beyond: x + y - 1, 1 - y,
                                 1 - x) are the hit's u and v */
};

/* x[axis] = at, between `low` and `high` along the next two axes. */
struct few_wall {
    float at, low[2], high[2];
    bool shades;
};

/* Inside is where to_local[k] . (x - center) is in [-1, 1] for all k. */
struct few_box {
    struct vec3 center, to_local[3];
    int32_t face[3][2]; /* at -1 and at 1 */
};

struct few_sphere {
    double center[3], radius;
    uint32_t instance, shape;
};

struct few_vectors {
    float x[FEW_ALL], y[FEW_ALL], z[FEW_ALL];
};

/* What rays find, by number of face. Most faces are plain (bsdf.h), do not shine, and have one
 * colour and one normal all over: vector code needs no more of these. Others are not even. */
enum few_flag {
    FEW_EVEN = 1,
    FEW_TWOSIDED = 2,
    FEW_OPPOSITE = 4 /* to its outer side: shading normals */
};

struct few_look {
    float flags[FEW_ALL];
    struct few_vectors reflectance, shading; /* shading: normal, of any length */
};

struct few {
    uint32_t n_faces, n_spheres; /* both 0: too many primitives, or of other kinds */
    uint32_t n_loose, n_boxes;   /* the first faces; boxes of the last ones */
    uint32_t first_wall[4];      /* those between are walls, by axis: faces[n_loose + wall] */
    struct few_face faces[FEW_FACES];
    struct few_wall walls[FEW_LOOSE];
    struct few_box boxes[FEW_BOXES];
    struct few_sphere spheres[FEW_SPHERES];
    struct few_look look;
};

/* Looks whether the view's primitives are few. */
void few_init(struct few *f, const struct view *v);

/* Fills in `look`, by the view's materials. */
void few_look_init(struct few *f, const struct view *v);

static inline bool few_is_used(const struct few *f)
{
    return f->n_faces + f->n_spheres > 0;
}

/* What the ray from o along d has hit at t: face `index`, or sphere index - n_faces; below 0:
 * nothing. */
void few_hit(const struct few *f, int32_t index, struct vec3 o, struct vec3 d, float t,
             struct hit *hit);

#endif
