/* SPDX-License-Identifier: Apache-2.0 */
/* Lambert's law and a power of a cosine: of the angle to the mirror direction (Phong, normalised as
 * Lafortune & Willems 1994) or of the half vector's inclination (Blinn, normalised to lose nothing
 * at normal incidence, Gotanda & Giesen). One-sided. */
#include "render/bsdf.h"

/* x^n for x in [0,1]. */
static float power(float x, float n)
{
    return n == 0.0f ? 1.0f : powf(max_float(x, 0.0f), n);
}

/* The specular part without the cosine, and its density. */
static float lobe(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, float *pdf)
{
    const float inv_2pi = 0.5f * MATH_INV_PI;
    float n = p->exponent;
    if (p->kind == BSDF_PHONG) {
        float c = wo.z * wi.z - wo.x * wi.x - wo.y * wi.y;
        float x = c > 0.0f ? power(c, n) : 0.0f;
        *pdf = (n + 1.0f) * inv_2pi * x;
        return (n + 2.0f) * inv_2pi * x;
    }
    struct vec3 h = vec3_normalize(vec3_add(wi, wo));
    float x = power(h.z, n);
    *pdf = (n + 1.0f) * inv_2pi * x / (4.0f * vec3_dot(wi, h));
    return (n + 2.0f) * (n + 4.0f) * (0.125f * MATH_INV_PI) / (exp2f(-0.5f * n) + n) * x;
}

void phong_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
                float *pdf)
{
    if (wi.z <= 0.0f || wo.z <= 0.0f) return;
    float specular_pdf, specular = lobe(p, wi, wo, &specular_pdf);
    float diffuse_pdf = wo.z * MATH_INV_PI;
    *pdf = p->specular_weight * specular_pdf + (1.0f - p->specular_weight) * diffuse_pdf;
    *value = vec3_madd(vec3_scale(p->reflectance, diffuse_pdf), p->specular_reflectance,
                       specular * wo.z);
}

void phong_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2, float v2,
                  struct bsdf_sample *s)
{
    if (wi.z <= 0.0f) return;
    if (u1 < p->specular_weight) {
        /* A direction around z whose cosine's power is even. */
        float c = powf(1.0f - v2, 1.0f / (p->exponent + 1.0f)), sine, cosine;
        float r = sqrtf(max_float(0.0f, 1.0f - c * c));
        warp_sincos_turn(u2, &sine, &cosine);
        struct vec3 local = vec3(r * cosine, r * sine, c);
        if (p->kind == BSDF_PHONG) {
            struct frame f = frame_from_normal(vec3(-wi.x, -wi.y, wi.z));
            s->wo = frame_to_world(&f, local);
        } else {
            float i_h = vec3_dot(wi, local);
            s->wo = vec3_sub(vec3_scale(local, 2.0f * i_h), wi);
            if (i_h <= 0.0f) return;
        }
        s->lobe = LOBE_GLOSSY;
    } else {
        s->wo = warp_cosine_hemisphere(u2, v2);
        s->lobe = LOBE_DIFFUSE;
    }
    struct vec3 value = {0};
    phong_eval(p, wi, s->wo, &value, &s->pdf);
    if (s->pdf > 0.0f) s->weight = vec3_scale(value, 1.0f / s->pdf);
}
