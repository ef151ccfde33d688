/* SPDX-License-Identifier: Apache-2.0 */
/* Glass, smooth and rough (Walter et al. 2007, "Microfacet models for refraction through rough
 * surfaces"), from both sides. */
#include "render/bsdf.h"
#include "render/facets.h"

void dielectric_sample(const struct bsdf_point *p, struct vec3 wi, float u1, struct bsdf_sample *s)
{
    struct fresnel f = fresnel_dielectric(wi.z, p->eta);
    s->lobe = LOBE_SPECULAR;
    if (u1 <= f.r) {
        s->wo = vec3(-wi.x, -wi.y, wi.z);
        s->pdf = f.r;
        s->weight = p->specular_reflectance;
    } else {
        s->wo = vec3(-f.eta_ti * wi.x, -f.eta_ti * wi.y, f.cos_t);
        s->pdf = 1.0f - f.r;
        s->eta = f.eta_it;
        /* Radiance changes with the square of the index (solid angle compression). */
        s->weight = vec3_scale(p->specular_transmittance, f.eta_ti * f.eta_ti);
    }
}

/* A sheet so thin that light goes straight through; what is reflected back and forth between its
 * two faces is summed: r + t r t + t r^3 t + ... = 2 r / (1 + r). */
void thin_dielectric_sample(const struct bsdf_point *p, struct vec3 wi, float u1,
                            struct bsdf_sample *s)
{
    float r = fresnel_dielectric(fabsf(wi.z), p->eta).r;
    r *= 2.0f / (1.0f + r);
    bool is_reflection = u1 <= r;
    s->wo = is_reflection ? vec3(-wi.x, -wi.y, wi.z) : vec3_neg(wi);
    s->pdf = is_reflection ? r : 1.0f - r;
    s->lobe = is_reflection ? LOBE_SPECULAR : LOBE_NULL;
    s->weight = is_reflection ? p->specular_reflectance : p->specular_transmittance;
}

#define OF_KIND(f, name, ...)                                            \
    ((f)->kind == MICROFACET_GGX                                         \
         ? name(MICROFACET_GGX, (f)->alpha_u, (f)->alpha_v, __VA_ARGS__) \
         : name(MICROFACET_BECKMANN, (f)->alpha_u, (f)->alpha_v, __VA_ARGS__))

void rough_dielectric_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo,
                           struct vec3 *value, float *pdf)
{
    OF_KIND(&p->facets, facets_dielectric_eval, p->eta, p->specular_reflectance,
            p->specular_transmittance, wi, wo, value, pdf);
}

void rough_dielectric_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2,
                             float v2, struct bsdf_sample *s)
{
    s->lobe = LOBE_GLOSSY;
    OF_KIND(&p->facets, facets_dielectric_sample, p->eta, p->specular_reflectance,
            p->specular_transmittance, wi, u1, u2, v2, &s->wo, &s->weight, &s->pdf, &s->eta);
}
