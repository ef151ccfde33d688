/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_SPHERE_H
#define RENDER_SPHERE_H

#include "math/warp.h"

/* Directions to a sphere, uniform in the cone that it fills; without branches, for vector code. */
struct sphere {
    struct vec3 center;
    float radius; /* world space; 0: an ellipsoid, which has no cone */
};

/* The squared sine of half the cone's opening from a point, of which to_center is the vector to the
 * centre; 0 where there is none: inside, or next to the sphere. */
MATH_INLINE float sphere_cone(const struct sphere *s, struct vec3 to_center)
{
    float r2 = s->radius * s->radius, d2 = vec3_dot(to_center, to_center);
    float share = r2 / d2;
    return d2 > r2 * (1.0f + 1e-4f) ? share : 0.0f;
}

/* Density of directions in it. */
MATH_INLINE float sphere_cone_pdf(float sin_max2)
{
    float height = sin_max2 / (1.0f + sqrtf(1.0f - sin_max2)); /* 1 - cos, without cancellation */
    return 0.5f * MATH_INV_PI / height;
}

/* The normal where a direction of the cone first meets the sphere. */
MATH_INLINE struct vec3 sphere_cone_sample(struct vec3 to_center, float sin_max2, float u1,
                                           float u2)
{
    float h = sin_max2 / (1.0f + sqrtf(1.0f - sin_max2)) * u1; /* 1 - cos */
    float sin2 = h * (2.0f - h), cosine = 1.0f - h;
    /* The angle at the centre, between the axis to the reference and the point. */
    float cos_alpha = sin2 / sqrtf(sin_max2) +
                      cosine * sqrtf(max_float(0.0f, 1.0f - sin2 / sin_max2));
    float sin_alpha = sqrtf(max_float(0.0f, 1.0f - cos_alpha * cos_alpha));
    float sin_phi, cos_phi;
    warp_sincos_turn(u2, &sin_phi, &cos_phi);
    struct frame f = frame_from_normal(vec3_neg(vec3_normalize(to_center)));
    return frame_to_world(&f, vec3(cos_phi * sin_alpha, sin_phi * sin_alpha, cos_alpha));
}

#endif
