/* SPDX-License-Identifier: Apache-2.0 */
/* Metals, smooth and rough (Cook & Torrance 1982 with Smith's separable shadowing), one-sided. */
#include "render/bsdf.h"
#include "render/fresnel.h"

void conductor_sample(const struct bsdf_point *p, struct vec3 wi, struct bsdf_sample *s)
{
    if (wi.z <= 0.0f) return;
    s->wo = vec3(-wi.x, -wi.y, wi.z);
    s->pdf = 1.0f;
    s->lobe = LOBE_SPECULAR;
    s->weight = vec3_mul(fresnel_conductor(wi.z, p->eta_rgb, p->k_rgb), p->specular_reflectance);
}

void rough_conductor_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo,
                          struct vec3 *value, float *pdf)
{
    if (wi.z <= 0.0f || wo.z <= 0.0f) return;
    struct vec3 m = vec3_normalize(vec3_add(wi, wo));
    float cos_m = vec3_dot(wi, m);
    float d = microfacet_d(&p->facets, m);
    float g_i = microfacet_g1(&p->facets, wi, m), g_o = microfacet_g1(&p->facets, wo, m);
    if (d == 0.0f || g_i == 0.0f || g_o == 0.0f) return;
    /* The density of m, D G1(wi) (wi.m) / wi.z, by the Jacobian 1 / (4 wo.m). */
    *pdf = d * g_i / (4.0f * wi.z);
    *value = vec3_scale(
        vec3_mul(fresnel_conductor(cos_m, p->eta_rgb, p->k_rgb), p->specular_reflectance),
        *pdf * g_o);
}

void rough_conductor_sample(const struct bsdf_point *p, struct vec3 wi, float u2, float v2,
                            struct bsdf_sample *s)
{
    if (wi.z <= 0.0f) return;
    float pdf;
    struct vec3 m = microfacet_sample(&p->facets, wi, u2, v2, &pdf);
    s->wo = fresnel_reflect(wi, m);
    float cos_m = vec3_dot(wi, m);
    if (pdf == 0.0f || s->wo.z <= 0.0f || cos_m <= 0.0f) return;
    s->pdf = pdf / (4.0f * cos_m);
    s->lobe = LOBE_GLOSSY;
    s->weight = vec3_scale(
        vec3_mul(fresnel_conductor(cos_m, p->eta_rgb, p->k_rgb), p->specular_reflectance),
        microfacet_g1(&p->facets, s->wo, m));
}
