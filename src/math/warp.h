/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MATH_WARP_H
#define MATH_WARP_H

#include "math/vec.h"

/*
 * Maps from the unit square to the places that a renderer samples, each with its density. All take
 * (u, v) in [0,1)^2 and keep strata together (equal areas go to connected regions).
 */

#define MATH_PI     3.14159265358979323846f
#define MATH_INV_PI 0.31830988618379067154f

struct vec2 {
    float x, y;
};

/* sin and cos of a in [-pi/4, pi/4]: Taylor to the power 9 and 8, error below 2^-24. */
static inline void warp_sincos_quarter(float a, float *s, float *c)
{
    float q = a * a;
    *s = a * (1.0f + q * (-1.0f / 6 + q * (1.0f / 120 + q * (-1.0f / 5040 + q / 362880))));
    *c = 1.0f + q * (-0.5f + q * (1.0f / 24 + q * (-1.0f / 720 + q / 40320)));
}

/* sin and cos of 2 pi t for t in [0,1]. */
MATH_INLINE void warp_sincos_turn(float t, float *s, float *c)
{
    float quarter = floor_float(4.0f * t + 0.5f); /* 0 .. 4 */
    float a, b;
    warp_sincos_quarter((t - 0.25f * quarter) * (2.0f * MATH_PI), &a, &b);
    int q = (int)quarter & 3;
    float sine = q & 1 ? b : a, cosine = q & 1 ? a : b;
    *s = q & 2 ? -sine : sine;
    *c = ((q + 1) & 2) != 0 ? -cosine : cosine;
}

/* The unit disk by the concentric map (Shirley & Chiu 1997); density 1/pi. */
MATH_INLINE struct vec2 warp_disk(float u, float v)
{
    float x = 2.0f * u - 1.0f, y = 2.0f * v - 1.0f;
    /* Without branches, which would be mispredicted half of the time. */
    bool is_flat = fabsf(x) >= fabsf(y);
    float r = is_flat ? x : y, other = is_flat ? y : x, s, c;
    warp_sincos_quarter(0.25f * MATH_PI * (other / (r == 0.0f ? 1.0f : r)), &s, &c);
    return (struct vec2){r * (is_flat ? c : s), r * (is_flat ? s : c)};
}

/* The upper hemisphere, density z/pi. */
MATH_INLINE struct vec3 warp_cosine_hemisphere(float u, float v)
{
    struct vec2 d = warp_disk(u, v);
    float z = 1.0f - (d.x * d.x + d.y * d.y);
    return vec3(d.x, d.y, z > 0.0f ? sqrtf(z) : 0.0f);
}

static inline float warp_cosine_hemisphere_pdf(float z)
{
    return z > 0.0f ? z * MATH_INV_PI : 0.0f;
}

/* The unit sphere, density 1/(4 pi). */
MATH_INLINE struct vec3 warp_sphere(float u, float v)
{
    float z = 1.0f - 2.0f * v, r = sqrtf(max_float(0.0f, 1.0f - z * z)), s, c;
    warp_sincos_turn(u, &s, &c);
    return vec3(r * c, r * s, z);
}

#define WARP_SPHERE_PDF (0.25f * MATH_INV_PI)

/* Barycentric coordinates (b1, b2), uniform over a triangle: density 1/area. */
static inline struct vec2 warp_triangle(float u, float v)
{
    float t = sqrtf(max_float(0.0f, 1.0f - u));
    return (struct vec2){1.0f - t, t * v};
}

/* Density of directions uniform in a cone around an axis. */
static inline float warp_cone_pdf(float cos_max)
{
    return 1.0f / (2.0f * MATH_PI * (1.0f - cos_max));
}

/* [-1,1] with density 1 - |x|. */
static inline float warp_tent(float u)
{
    return u < 0.5f ? sqrtf(2.0f * u) - 1.0f : 1.0f - sqrtf(2.0f - 2.0f * u);
}

#endif
