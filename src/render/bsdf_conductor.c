/* SPDX-License-Identifier: Apache-2.0 */
/* Metals, smooth and rough (Cook & Torrance 1982 with Smith's separable shadowing), one-sided. */
#include "render/bsdf.h"
#include "render/facets.h"

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
    const struct microfacet *f = &p->facets;
    if (f->kind == MICROFACET_GGX)
        facets_conductor_eval(MICROFACET_GGX, f->alpha_u, f->alpha_v, p->eta_rgb, p->k_rgb,
                              p->specular_reflectance, wi, wo, value, pdf);
    else
        facets_conductor_eval(MICROFACET_BECKMANN, f->alpha_u, f->alpha_v, p->eta_rgb, p->k_rgb,
                              p->specular_reflectance, wi, wo, value, pdf);
}

void rough_conductor_sample(const struct bsdf_point *p, struct vec3 wi, float u2, float v2,
                            struct bsdf_sample *s)
{
    const struct microfacet *f = &p->facets;
    s->lobe = LOBE_GLOSSY;
    if (f->kind == MICROFACET_GGX)
        facets_conductor_sample(MICROFACET_GGX, f->alpha_u, f->alpha_v, p->eta_rgb, p->k_rgb,
                                p->specular_reflectance, wi, u2, v2, &s->wo, &s->weight, &s->pdf);
    else
        facets_conductor_sample(MICROFACET_BECKMANN, f->alpha_u, f->alpha_v, p->eta_rgb, p->k_rgb,
                                p->specular_reflectance, wi, u2, v2, &s->wo, &s->weight, &s->pdf);
}
