/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_FRESNEL_H
#define RENDER_FRESNEL_H

#include "math/vec.h"

/* Reflection and refraction at smooth interfaces, for unpolarised light. */

struct fresnel {
    float r;     /* reflected fraction */
    float cos_t; /* of the refracted direction, opposite sign to cos_i; 0: total reflection */
    float eta_it, eta_ti; /* relative index in the direction of travel, and its reciprocal */
};

/* eta = index inside / outside; cos_i > 0 comes from outside (the side of the normal). Without
 * branches, for vector code. */
MATH_INLINE struct fresnel fresnel_dielectric(float cos_i, float eta)
{
    bool is_outside = cos_i >= 0.0f;
    float inverse = 1.0f / eta, ci = fabsf(cos_i);
    float eta_it = is_outside ? eta : inverse, eta_ti = is_outside ? inverse : eta;
    float ct = sqrtf(max_float(1.0f - (1.0f - cos_i * cos_i) * eta_ti * eta_ti, 0.0f));
    float s = (ci - eta_it * ct) / (ci + eta_it * ct), p = (ct - eta_it * ci) / (ct + eta_it * ci);
    float r = 0.5f * (s * s + p * p);
    r = ci == 0.0f ? 1.0f : r;
    return (struct fresnel){.r = eta == 1.0f ? 0.0f : r,
                            .cos_t = is_outside ? -ct : ct,
                            .eta_it = eta_it,
                            .eta_ti = eta_ti};
}

/* The reflected fraction for light from outside, cos_i >= 0, without branches. */
MATH_INLINE float fresnel_outside(float cos_i, float eta)
{
    float inverse = 1.0f / eta;
    float ct = sqrtf(max_float(1.0f - (1.0f - cos_i * cos_i) * inverse * inverse, 0.0f));
    float s = (cos_i - eta * ct) * (ct + eta * cos_i), p = (ct - eta * cos_i) * (cos_i + eta * ct);
    float most = (ct + eta * cos_i) * (cos_i + eta * ct);
    float r = 0.5f * (s * s + p * p) / (most * most); /* of both polarisations */
    r = ct == 0.0f ? 1.0f : r; /* where small numbers leave nothing to divide */
    return eta == 1.0f ? 0.0f : r;
}

/* One channel of a conductor with complex index eta + i k (Moeller, "Optics"). */
static inline float fresnel_conductor_1(float cos_i, float eta, float k)
{
    float c2 = cos_i * cos_i, s2 = 1.0f - c2;
    float t = eta * eta - k * k - s2;
    float a2b2 = sqrtf(max_float(0.0f, t * t + 4.0f * k * k * eta * eta));
    float a = sqrtf(max_float(0.0f, 0.5f * (a2b2 + t)));
    float t1 = a2b2 + c2, t2 = 2.0f * cos_i * a;
    float t3 = a2b2 * c2 + s2 * s2, t4 = t2 * s2;
    /* (rs + rp) / 2 of rs = (t1 - t2) / (t1 + t2), rp = rs (t3 - t4) / (t3 + t4) */
    return (t1 - t2) * t3 / ((t1 + t2) * (t3 + t4));
}

static inline struct vec3 fresnel_conductor(float cos_i, struct vec3 eta, struct vec3 k)
{
    return vec3(fresnel_conductor_1(cos_i, eta.x, k.x), fresnel_conductor_1(cos_i, eta.y, k.y),
                fresnel_conductor_1(cos_i, eta.z, k.z));
}

/* The mean over a diffuse (cosine-weighted) hemisphere: fits of Egan & Hilgeman 1973 for eta < 1
 * and d'Eon & Irving 2011 above, as Mitsuba uses them. */
static inline float fresnel_diffuse_reflectance(float eta)
{
    float i = 1.0f / eta;
    if (eta < 1.0f) return 0.0636f * i + (eta * (eta * -1.4399f + 0.7099f) + 0.6681f);
    return 0.919317f +
           i * (-3.4793f + i * (6.75335f + i * (-7.80989f + i * (4.98554f + i * -1.36881f))));
}

/* wi mirrored about the unit vector m. */
static inline struct vec3 fresnel_reflect(struct vec3 wi, struct vec3 m)
{
    return vec3_sub(vec3_scale(m, 2.0f * vec3_dot(wi, m)), wi);
}

/* wi refracted at an interface of normal m; cos_t and eta_ti from fresnel_dielectric(). */
static inline struct vec3 fresnel_refract(struct vec3 wi, struct vec3 m, float cos_t, float eta_ti)
{
    return vec3_sub(vec3_scale(m, vec3_dot(wi, m) * eta_ti + cos_t), vec3_scale(wi, eta_ti));
}

#endif
