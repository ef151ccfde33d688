/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MATH_TRANSFORM_H
#define MATH_TRANSFORM_H

#include <stdbool.h>

#include "math/vec.h"

/* An affine map with its inverse: rows of 3x4 matrices, p' = m[:, :3] p + m[:, 3]. */
struct transform {
    float m[3][4];
    float inv[3][4];
};

struct transform transform_identity(void);
struct transform transform_translate(struct vec3 offset);
struct transform transform_scale(struct vec3 factor);

/* Degrees about `axis` (any length but 0), counter-clockwise seen against the axis. */
struct transform transform_rotate(struct vec3 axis, float degrees);

/* Camera to world as Mitsuba has it: +z looks at the target, +x to the left of the picture. */
struct transform transform_look_at(struct vec3 origin, struct vec3 target, struct vec3 up);

/* Rows of a 4x4 matrix whose last row is 0 0 0 1 (up to rounding). False when singular. */
bool transform_from_matrix(const double m[16], struct transform *out);

/* a then applied after b: (a * b) p = a(b(p)). */
struct transform transform_mul(const struct transform *a, const struct transform *b);

/* A point (w = 1) or a vector (w = 0). */
static inline struct vec3 transform_apply(const float m[3][4], struct vec3 v, float w)
{
    return (struct vec3){
        m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z + m[0][3] * w,
        m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z + m[1][3] * w,
        m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z + m[2][3] * w,
    };
}

static inline struct vec3 transform_point(const struct transform *t, struct vec3 p)
{
    return transform_apply(t->m, p, 1.0f);
}

static inline struct vec3 transform_vector(const struct transform *t, struct vec3 v)
{
    return transform_apply(t->m, v, 0.0f);
}

/* A normal, by the inverse transpose; not normalised. */
static inline struct vec3 transform_normal(const struct transform *t, struct vec3 n)
{
    const float(*q)[4] = t->inv;
    return (struct vec3){
        q[0][0] * n.x + q[1][0] * n.y + q[2][0] * n.z,
        q[0][1] * n.x + q[1][1] * n.y + q[2][1] * n.z,
        q[0][2] * n.x + q[1][2] * n.y + q[2][2] * n.z,
    };
}

/* The same with the inverse map. */
static inline struct vec3 transform_point_inverse(const struct transform *t, struct vec3 p)
{
    return transform_apply(t->inv, p, 1.0f);
}

static inline struct vec3 transform_vector_inverse(const struct transform *t, struct vec3 v)
{
    return transform_apply(t->inv, v, 0.0f);
}

/* True when the map mirrors (negative determinant). */
bool transform_flips(const struct transform *t);

#endif
