/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_FACETS_H
#define RENDER_FACETS_H

#include "math/approx.h"
#include "math/warp.h"
#include "render/fresnel.h"
#include "scene/scene.h"

/*
 * What microfacet.h says, and the rough materials that are made of it, without branches: vector
 * code has many lanes of one kind, the functions of microfacet.h and bsdf.h one. Directions are in
 * the material's own frame.
 */

MATH_INLINE float facets_square(float x)
{
    return x * x;
}

MATH_INLINE float facets_d(enum microfacet_kind kind, float alpha_u, float alpha_v, struct vec3 m)
{
    /* (m.x / alpha_u)^2 + (m.y / alpha_v)^2, by one division for all: steep / area^2. */
    float area = alpha_u * alpha_v, c2 = m.z * m.z, d;
    float steep = facets_square(m.x * alpha_v) + facets_square(m.y * alpha_u);
    if (kind == MICROFACET_BECKMANN) {
        float inverse = 1.0f / (area * c2);
        d = approx_exp(-(steep * inverse) * (c2 * inverse)) * (inverse * area * MATH_INV_PI) *
            inverse;
    } else {
        d = area * area * area / (MATH_PI * facets_square(steep + c2 * area * area));
    }
    return d * m.z > 1e-20f ? d : 0.0f;
}

MATH_INLINE float facets_g1(enum microfacet_kind kind, float alpha_u, float alpha_v, struct vec3 v,
                            struct vec3 m)
{
    float xy = facets_square(alpha_u * v.x) + facets_square(alpha_v * v.y);
    float height = fabsf(v.z), g;
    if (kind == MICROFACET_GGX) {
        g = 2.0f * height / (height + sqrtf(height * height + xy));
    } else {
        float a = min_float(height / sqrtf(xy), 1.6f), a2 = a * a;
        float fit = (3.535f * a + 2.181f * a2) / (1.0f + 2.276f * a + 2.577f * a2);
        g = a < 1.6f ? fit : 1.0f;
    }
    g = xy == 0.0f ? 1.0f : g;
    /* The back of a facet cannot be seen from the front, and the other way round. */
    return vec3_dot(v, m) * v.z <= 0.0f ? 0.0f : g;
}

/* A step of Halley's method, with the second derivative -sqrt(pi)/2 tan_i / bell. */
MATH_INLINE float facets_step(float x, float tan_i, float goal)
{
    const float inv_sqrt_pi = 0.56418958354775628695f, half_sqrt_pi = 0.88622692545275801365f;
    float slope = approx_erf_inverse(x), bell = approx_exp(-facets_square(slope));
    float value = 1.0f + x + inv_sqrt_pi * tan_i * bell - goal, rise = 1.0f - slope * tan_i;
    return x - 2.0f * value * rise * bell /
                   (2.0f * rise * rise * bell + value * (half_sqrt_pi * tan_i));
}

/* A visible slope of a surface of roughness 1 seen under cos_i: inverts the distribution function
 * in the erf() domain by two steps from the solution for grazing view: the error is below 1e-5. */
MATH_INLINE struct vec2 facets_slope_beckmann(float cos_i, float u, float v)
{
    const float inv_sqrt_pi = 0.56418958354775628695f;
    float tan_i = sqrtf(max_float(0.0f, 1.0f - cos_i * cos_i)) / cos_i, cot_i = 1.0f / tan_i;
    float most = approx_erf(min_float(cot_i, 10.0f));
    u = max_float(min_float(u, 1.0f - 1e-6f), 1e-6f);
    v = max_float(min_float(v, 1.0f - 1e-6f), 1e-6f);
    float x = most - (most + 1.0f) * approx_erf(sqrtf(-approx_log(u)));
    u *= 1.0f + most + inv_sqrt_pi * tan_i * approx_exp(-facets_square(min_float(cot_i, 10.0f)));
    x = facets_step(x, tan_i, u);
    x = facets_step(x, tan_i, u);
    return (struct vec2){approx_erf_inverse(x), approx_erf_inverse(2.0f * v - 1.0f)};
}

/* A normal visible from the unit vector wi for GGX with roughness 1: a point of the projected
 * hemisphere, half of which is seen in full and half foreshortened. */
MATH_INLINE struct vec3 facets_normal_ggx(struct vec3 wi, float u, float v)
{
    struct vec2 p = warp_disk(u, v);
    float s = 0.5f * (1.0f + wi.z);
    float rim = sqrtf(max_float(0.0f, 1.0f - p.x * p.x));
    float y = rim + (p.y - rim) * s;
    float z = sqrtf(max_float(0.0f, 1.0f - p.x * p.x - y * y));
    float length2 = wi.x * wi.x + wi.y * wi.y, inverse = 1.0f / sqrtf(length2);
    bool is_tilted = length2 > 0.0f;
    float tx = is_tilted ? -wi.y * inverse : 1.0f, ty = is_tilted ? wi.x * inverse : 0.0f;
    struct vec3 t1 = vec3(tx, ty, 0.0f), t2 = vec3_cross(wi, t1);
    return vec3_madd(vec3_madd(vec3_scale(wi, z), t2, y), t1, p.x);
}

MATH_INLINE struct vec3 facets_normal(enum microfacet_kind kind, float alpha_u, float alpha_v,
                                      struct vec3 wi, float u, float v)
{
    struct vec3 stretched = vec3_normalize(vec3(alpha_u * wi.x, alpha_v * wi.y, wi.z));
    if (kind == MICROFACET_GGX) {
        struct vec3 n = facets_normal_ggx(stretched, u, v);
        return vec3_normalize(vec3(alpha_u * n.x, alpha_v * n.y, max_float(n.z, 1e-6f)));
    }
    struct vec2 slope = facets_slope_beckmann(stretched.z, u, v);
    float sine = sqrtf(stretched.x * stretched.x + stretched.y * stretched.y);
    bool is_tilted = sine > 0.0f;
    float cx = stretched.x / sine, sx = stretched.y / sine;
    float c = is_tilted ? cx : 1.0f, s = is_tilted ? sx : 0.0f;
    return vec3_normalize(
        vec3(-(c * slope.x - s * slope.y) * alpha_u, -(s * slope.x + c * slope.y) * alpha_v, 1.0f));
}

/* ---- Rough conductors ------------------------------------------------------------------------ */

/* Value (with cosine) and density; both 0 where wi or wo is below. */
MATH_INLINE void facets_conductor_eval(enum microfacet_kind kind, float alpha_u, float alpha_v,
                                       struct vec3 eta, struct vec3 k, struct vec3 specular,
                                       struct vec3 wi, struct vec3 wo, struct vec3 *value,
                                       float *pdf)
{
    struct vec3 m = vec3_normalize(vec3_add(wi, wo));
    float d = facets_d(kind, alpha_u, alpha_v, m);
    float g_i = facets_g1(kind, alpha_u, alpha_v, wi, m);
    float g_o = facets_g1(kind, alpha_u, alpha_v, wo, m);
    struct vec3 f = fresnel_conductor(vec3_dot(wi, m), eta, k);
    /* The density of m, D G1(wi) (wi.m) / wi.z, by the Jacobian 1 / (4 wo.m). */
    float density = d * g_i / (4.0f * wi.z), scale = density * g_o;
    bool is_lit = (wi.z > 0.0f) & (wo.z > 0.0f) & (scale > 0.0f);
    *pdf = is_lit ? density : 0.0f;
    value->x = is_lit ? f.x * specular.x * scale : 0.0f;
    value->y = is_lit ? f.y * specular.y * scale : 0.0f;
    value->z = is_lit ? f.z * specular.z * scale : 0.0f;
}

/* The weight is 0 where nothing was sampled. */
MATH_INLINE void facets_conductor_sample(enum microfacet_kind kind, float alpha_u, float alpha_v,
                                         struct vec3 eta, struct vec3 k, struct vec3 specular,
                                         struct vec3 wi, float u, float v, struct vec3 *wo,
                                         struct vec3 *weight, float *pdf)
{
    struct vec3 m = facets_normal(kind, alpha_u, alpha_v, wi, u, v);
    struct vec3 out = fresnel_reflect(wi, m);
    float cos_m = vec3_dot(wi, m);
    float density = facets_d(kind, alpha_u, alpha_v, m) * facets_g1(kind, alpha_u, alpha_v, wi, m) /
                    (4.0f * wi.z);
    float g_o = facets_g1(kind, alpha_u, alpha_v, out, m);
    struct vec3 f = fresnel_conductor(cos_m, eta, k);
    bool is_lit = (wi.z > 0.0f) & (out.z > 0.0f) & (cos_m > 0.0f) & (density > 0.0f);
    *wo = out;
    *pdf = is_lit ? density : 0.0f;
    weight->x = is_lit ? f.x * specular.x * g_o : 0.0f;
    weight->y = is_lit ? f.y * specular.y * g_o : 0.0f;
    weight->z = is_lit ? f.z * specular.z * g_o : 0.0f;
}

/* ---- Rough plastics -------------------------------------------------------------------------- */

/* Chance of choosing a facet of the coat; t_i: what it lets in. */
MATH_INLINE float facets_coat_chance(float specular_weight, float t_i)
{
    float coat = (1.0f - t_i) * specular_weight, sum = coat + t_i * (1.0f - specular_weight);
    float chance = coat / sum;
    return sum > 0.0f ? chance : 1.0f;
}

/* What a coat and the diffuse base under it are, for vector code not as a struct:
 *
 *   alpha_u, alpha_v, eta, specular_weight
 *   internal    reflected back inside by the coat
 *   nonlinear   1: what is reflected inside takes the base's colour, else 0
 *   base, specular: colours
 */
#define FACETS_PLASTIC                                                              \
    float alpha_u, float alpha_v, float eta, float specular_weight, float internal, \
        float nonlinear, struct vec3 base, struct vec3 specular

/* Value (with cosine) and density, of wi and wo above the surface: nobody should ask for others.
 * t_i, t_o: what the coat lets through along wi and wo. */
MATH_INLINE void facets_plastic_eval(enum microfacet_kind kind, FACETS_PLASTIC, struct vec3 wi,
                                     struct vec3 wo, float t_i, float t_o, struct vec3 *value,
                                     float *pdf)
{
    struct vec3 m = vec3_normalize(vec3_add(wi, wo)), c = base;
    float chance = facets_coat_chance(specular_weight, t_i), cosine = wo.z * MATH_INV_PI;
    /* The density of m, D G1(wi) (wi.m) / wi.z, by the Jacobian 1 / (4 wo.m). */
    float density = facets_d(kind, alpha_u, alpha_v, m) * facets_g1(kind, alpha_u, alpha_v, wi, m) /
                    (4.0f * wi.z);
    float coat = density * fresnel_outside(vec3_dot(wi, m), eta) *
                 facets_g1(kind, alpha_u, alpha_v, wo, m);
    float below = cosine * t_i * t_o / (eta * eta), f = internal, n = nonlinear;
    value->x = c.x * below / (1.0f - (n * c.x + (1.0f - n)) * f) + specular.x * coat;
    value->y = c.y * below / (1.0f - (n * c.y + (1.0f - n)) * f) + specular.y * coat;
    value->z = c.z * below / (1.0f - (n * c.z + (1.0f - n)) * f) + specular.z * coat;
    *pdf = chance * density + (1.0f - chance) * cosine;
}

/* A direction for it: of a facet of the coat, or of the base. */
MATH_INLINE struct vec3 facets_plastic_sample(enum microfacet_kind kind, float alpha_u,
                                              float alpha_v, float specular_weight, struct vec3 wi,
                                              float t_i, float u1, float u2, float v2)
{
    struct vec3 m = facets_normal(kind, alpha_u, alpha_v, wi, u2, v2);
    struct vec3 coat = fresnel_reflect(wi, m), base = warp_cosine_hemisphere(u2, v2);
    /* A sum, as compilers would make branches of a choice. */
    float of_coat = u1 < facets_coat_chance(specular_weight, t_i) ? 1.0f : 0.0f;
    return vec3_add(vec3_scale(coat, of_coat), vec3_scale(base, 1.0f - of_coat));
}

/* ---- Rough dielectrics ----------------------------------------------------------------------- */

/* m on the normal's side, or the other: flipped where z is below. */
MATH_INLINE struct vec3 facets_front(struct vec3 m, float z)
{
    return vec3_scale(m, z < 0.0f ? -1.0f : 1.0f);
}

/* Value (with cosine) and density (Walter et al. 2007); both 0 where no facet sends light from one
 * to the other. */
MATH_INLINE void facets_dielectric_eval(enum microfacet_kind kind, float alpha_u, float alpha_v,
                                        float index, struct vec3 reflectance,
                                        struct vec3 transmittance, struct vec3 wi, struct vec3 wo,
                                        struct vec3 *value, float *pdf)
{
    bool is_reflection = wi.z * wo.z > 0.0f;
    float inverse = 1.0f / index, eta = wi.z > 0.0f ? index : inverse;
    struct vec3 half = vec3_madd(wi, wo, is_reflection ? 1.0f : eta);
    float length2 = vec3_dot(half, half);
    struct vec3 m = facets_front(vec3_scale(half, 1.0f / sqrtf(length2)), half.z);
    float i_m = vec3_dot(wi, m), o_m = vec3_dot(wo, m);
    float d = facets_d(kind, alpha_u, alpha_v, m), r = fresnel_dielectric(i_m, index).r;
    float g_o = facets_g1(kind, alpha_u, alpha_v, wo, m);
    /* The density of m, then by the Jacobians of reflection and refraction. */
    float visible = d * facets_g1(kind, alpha_u, alpha_v, wi, m) * fabsf(i_m / wi.z);
    float reflected = visible * r / (4.0f * fabsf(o_m));
    float refracted = visible * (1.0f - r) * eta * eta * fabsf(o_m) /
                      facets_square(i_m + eta * o_m);
    float density = is_reflection ? reflected : refracted;
    float scale = density * g_o, unscaled = scale / (eta * eta);
    scale = is_reflection ? scale : unscaled;
    /* Micro- and macrosurface must agree on the side. */
    bool is_lit = (length2 > 0.0f) & (i_m * wi.z > 0.0f) & (o_m * wo.z > 0.0f) & (d > 0.0f);
    *pdf = is_lit ? density : 0.0f;
    value->x = is_lit ? (is_reflection ? reflectance.x : transmittance.x) * scale : 0.0f;
    value->y = is_lit ? (is_reflection ? reflectance.y : transmittance.y) * scale : 0.0f;
    value->z = is_lit ? (is_reflection ? reflectance.z : transmittance.z) * scale : 0.0f;
}

/* The weight is 0 where nothing was sampled. eta: relative index of what was passed. */
MATH_INLINE void facets_dielectric_sample(enum microfacet_kind kind, float alpha_u, float alpha_v,
                                          float index, struct vec3 reflectance,
                                          struct vec3 transmittance, struct vec3 wi, float u1,
                                          float u2, float v2, struct vec3 *wo, struct vec3 *weight,
                                          float *pdf, float *eta)
{
    struct vec3 above = facets_front(wi, wi.z),
                m = facets_normal(kind, alpha_u, alpha_v, above, u2, v2);
    float visible = facets_d(kind, alpha_u, alpha_v, m) *
                    facets_g1(kind, alpha_u, alpha_v, above, m) * fabsf(vec3_dot(above, m)) /
                    above.z;
    float i_m = vec3_dot(wi, m);
    struct fresnel f = fresnel_dielectric(i_m, index);
    bool is_reflection = u1 <= f.r;
    struct vec3 mirrored = fresnel_reflect(wi, m), bent = fresnel_refract(wi, m, f.cos_t, f.eta_ti);
    wo->x = is_reflection ? mirrored.x : bent.x;
    wo->y = is_reflection ? mirrored.y : bent.y;
    wo->z = is_reflection ? mirrored.z : bent.z;
    float o_m = vec3_dot(*wo, m);
    float reflected = visible * f.r / (4.0f * fabsf(o_m));
    float refracted = visible * (1.0f - f.r) * facets_square(f.eta_it) * fabsf(o_m) /
                      facets_square(i_m + f.eta_it * o_m);
    float density = is_reflection ? reflected : refracted;
    float g_o = facets_g1(kind, alpha_u, alpha_v, *wo, m);
    /* Radiance changes with the square of the index. */
    float scale = g_o * (is_reflection ? 1.0f : facets_square(f.eta_ti));
    bool is_lit = (wi.z != 0.0f) & (density > 0.0f) & (density < INFINITY);
    *pdf = is_lit ? density : 0.0f;
    *eta = is_reflection ? 1.0f : f.eta_it;
    weight->x = is_lit ? (is_reflection ? reflectance.x : transmittance.x) * scale : 0.0f;
    weight->y = is_lit ? (is_reflection ? reflectance.y : transmittance.y) * scale : 0.0f;
    weight->z = is_lit ? (is_reflection ? reflectance.z : transmittance.z) * scale : 0.0f;
}

#endif
