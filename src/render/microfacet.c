/* SPDX-License-Identifier: Apache-2.0 */
#include "render/microfacet.h"

static inline float square(float x)
{
    return x * x;
}

float microfacet_d(const struct microfacet *f, struct vec3 m)
{
    float area = MATH_PI * f->alpha_u * f->alpha_v, c2 = m.z * m.z, d;
    float slope = square(m.x / f->alpha_u) + square(m.y / f->alpha_v);
    if (f->kind == MICROFACET_BECKMANN)
        d = expf(-slope / c2) / (area * c2 * c2);
    else
        d = 1.0f / (area * square(slope + c2));
    return d * m.z > 1e-20f ? d : 0.0f;
}

float microfacet_g1(const struct microfacet *f, struct vec3 v, struct vec3 m)
{
    /* The back of a facet cannot be seen from the front, and the other way round. */
    if (vec3_dot(v, m) * v.z <= 0.0f) return 0.0f;
    float xy = square(f->alpha_u * v.x) + square(f->alpha_v * v.y);
    if (xy == 0.0f) return 1.0f;
    float tan2 = xy / (v.z * v.z);
    if (f->kind == MICROFACET_GGX) return 2.0f / (1.0f + sqrtf(1.0f + tan2));
    float a = 1.0f / sqrtf(tan2), a2 = a * a;
    if (a >= 1.6f) return 1.0f;
    return (3.535f * a + 2.181f * a2) / (1.0f + 2.276f * a + 2.577f * a2);
}

float microfacet_pdf(const struct microfacet *f, struct vec3 wi, struct vec3 m)
{
    return microfacet_d(f, m) * microfacet_g1(f, wi, m) * fabsf(vec3_dot(wi, m)) / wi.z;
}

/* Inverse error function in single precision (Giles 2010). */
static float erf_inverse(float x)
{
    float w = -logf((1.0f - x) * (1.0f + x)), p;
    if (w < 5.0f) {
        w -= 2.5f;
        p = 2.81022636e-08f;
        p = 3.43273939e-07f + p * w;
        p = -3.5233877e-06f + p * w;
        p = -4.39150654e-06f + p * w;
        p = 0.00021858087f + p * w;
        p = -0.00125372503f + p * w;
        p = -0.00417768164f + p * w;
        p = 0.246640727f + p * w;
        p = 1.50140941f + p * w;
    } else {
        w = sqrtf(w) - 3.0f;
        p = -0.000200214257f;
        p = 0.000100950558f + p * w;
        p = 0.00134934322f + p * w;
        p = -0.00367342844f + p * w;
        p = 0.00573950773f + p * w;
        p = -0.0076224613f + p * w;
        p = 0.00943887047f + p * w;
        p = 1.00167406f + p * w;
        p = 2.83297682f + p * w;
    }
    return p * x;
}

/* A visible slope of a surface of roughness 1 seen under cos_i: inverts the distribution function
 * in the erf() domain by three Newton steps from the solution for grazing view. */
static struct vec2 visible_slope_beckmann(float cos_i, float u, float v)
{
    const float inv_sqrt_pi = 0.56418958354775628695f;
    float tan_i = sqrtf(max_float(0.0f, 1.0f - cos_i * cos_i)) / cos_i, cot_i = 1.0f / tan_i;
    float most = erff(cot_i);
    u = max_float(min_float(u, 1.0f - 1e-6f), 1e-6f);
    v = max_float(min_float(v, 1.0f - 1e-6f), 1e-6f);
    float x = most - (most + 1.0f) * erff(sqrtf(-logf(u)));
    u *= 1.0f + most + inv_sqrt_pi * tan_i * expf(-square(cot_i));
    for (int i = 0; i < 3; i++) {
        float slope = erf_inverse(x);
        float value = 1.0f + x + inv_sqrt_pi * tan_i * expf(-square(slope)) - u;
        float derivative = 1.0f - slope * tan_i;
        x -= value / derivative;
    }
    return (struct vec2){erf_inverse(x), erf_inverse(2.0f * v - 1.0f)};
}

/* A normal visible from the unit vector wi for GGX with roughness 1: a point of the projected
 * hemisphere, half of which is seen in full and half foreshortened. */
static struct vec3 visible_normal_ggx(struct vec3 wi, float u, float v)
{
    struct vec2 p = warp_disk(u, v);
    float s = 0.5f * (1.0f + wi.z);
    float rim = sqrtf(max_float(0.0f, 1.0f - p.x * p.x));
    p.y = rim + (p.y - rim) * s;
    float z = sqrtf(max_float(0.0f, 1.0f - p.x * p.x - p.y * p.y));
    float length2 = wi.x * wi.x + wi.y * wi.y;
    struct vec3 t1 = length2 > 0.0f ? vec3_scale(vec3(-wi.y, wi.x, 0.0f), 1.0f / sqrtf(length2))
                                    : vec3(1.0f, 0.0f, 0.0f);
    struct vec3 t2 = vec3_cross(wi, t1);
    return vec3_madd(vec3_madd(vec3_scale(wi, z), t2, p.y), t1, p.x);
}

struct vec3 microfacet_normal(const struct microfacet *f, struct vec3 wi, float u, float v)
{
    struct vec3 stretched = vec3_normalize(vec3(f->alpha_u * wi.x, f->alpha_v * wi.y, wi.z));
    struct vec3 m;
    if (f->kind == MICROFACET_GGX) {
        struct vec3 n = visible_normal_ggx(stretched, u, v);
        m = vec3_normalize(vec3(f->alpha_u * n.x, f->alpha_v * n.y, max_float(n.z, 1e-6f)));
    } else {
        struct vec2 slope = visible_slope_beckmann(stretched.z, u, v);
        float sine = sqrtf(stretched.x * stretched.x + stretched.y * stretched.y);
        float c = sine > 0.0f ? stretched.x / sine : 1.0f,
              s = sine > 0.0f ? stretched.y / sine : 0.0f;
        m = vec3_normalize(vec3(-(c * slope.x - s * slope.y) * f->alpha_u,
                                -(s * slope.x + c * slope.y) * f->alpha_v, 1.0f));
    }
    return m;
}

struct vec3 microfacet_sample(const struct microfacet *f, struct vec3 wi, float u, float v,
                              float *pdf)
{
    struct vec3 m = microfacet_normal(f, wi, u, v);
    *pdf = microfacet_pdf(f, wi, m);
    return m;
}
