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

struct vec3 transform_point(const struct transform *t, struct vec3 p);
struct vec3 transform_vector(const struct transform *t, struct vec3 v);

/* A normal, by the inverse transpose; not normalised. */
struct vec3 transform_normal(const struct transform *t, struct vec3 n);

/* The same with the inverse map. */
struct vec3 transform_point_inverse(const struct transform *t, struct vec3 p);
struct vec3 transform_vector_inverse(const struct transform *t, struct vec3 v);

/* True when the map mirrors (negative determinant). */
bool transform_flips(const struct transform *t);

#endif
