/* SPDX-License-Identifier: Apache-2.0 */
/* A diffuse base under a dielectric coat, smooth or rough; light that is reflected back inside is
 * summed in closed form. One-sided. */
#include "render/bsdf.h"
#include "render/facets.h"

/* Chance of choosing the coat's mirror direction. */
static float coat_probability(const struct bsdf_point *p, float r_i)
{
    float coat = r_i * p->specular_weight, base = (1.0f - r_i) * (1.0f - p->specular_weight);
    return coat / (coat + base);
}

/* The base's reflectance seen through the coat, without the cosine / pi. */
static struct vec3 base_value(const struct bsdf_point *p, float r_i, float wo_z)
{
    float r_o = fresnel_dielectric(wo_z, p->eta).r;
    float scale = (1.0f - r_i) * (1.0f - r_o) / (p->eta * p->eta);
    struct vec3 c = p->reflectance;
    float f = p->internal_reflection;
    if (!p->is_nonlinear) return vec3_scale(c, scale / (1.0f - f));
    return vec3(c.x * scale / (1.0f - c.x * f), c.y * scale / (1.0f - c.y * f),
                c.z * scale / (1.0f - c.z * f));
}

void plastic_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
                  float *pdf)
{
    if (wi.z <= 0.0f || wo.z <= 0.0f) return;
    float r_i = fresnel_dielectric(wi.z, p->eta).r;
    float cosine = wo.z * MATH_INV_PI;
    *pdf = cosine * (1.0f - coat_probability(p, r_i));
    *value = vec3_scale(base_value(p, r_i, wo.z), cosine);
}

void plastic_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2, float v2,
                    struct bsdf_sample *s)
{
    if (wi.z <= 0.0f) return;
    float r_i = fresnel_dielectric(wi.z, p->eta).r;
    float coat = coat_probability(p, r_i);
    if (u1 < coat) {
        s->wo = vec3(-wi.x, -wi.y, wi.z);
        s->pdf = coat;
        s->lobe = LOBE_SPECULAR;
        s->weight = vec3_scale(p->specular_reflectance, r_i / coat);
        return;
    }
    s->wo = warp_cosine_hemisphere(u2, v2);
    s->pdf = warp_cosine_hemisphere_pdf(s->wo.z) * (1.0f - coat);
    s->lobe = LOBE_DIFFUSE;
    if (s->pdf > 0.0f) s->weight = vec3_scale(base_value(p, r_i, s->wo.z), 1.0f / (1.0f - coat));
}

/* ---- Rough ----------------------------------------------------------------------------------- */

/* The arguments FACETS_PLASTIC. */
#define PLASTIC_OF(p)                                                                \
    (p)->facets.alpha_u, (p)->facets.alpha_v, (p)->eta, (p)->specular_weight,        \
        (p)->internal_reflection, (p)->is_nonlinear ? 1.0f : 0.0f, (p)->reflectance, \
        (p)->specular_reflectance

void rough_plastic_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo,
                        struct vec3 *value, float *pdf)
{
    if (wi.z <= 0.0f || wo.z <= 0.0f) return;
    float t_i = coat_transmittance(&p->coat, wi.z), t_o = coat_transmittance(&p->coat, wo.z);
    if (p->facets.kind == MICROFACET_GGX)
        facets_plastic_eval(MICROFACET_GGX, PLASTIC_OF(p), wi, wo, t_i, t_o, value, pdf);
    else
        facets_plastic_eval(MICROFACET_BECKMANN, PLASTIC_OF(p), wi, wo, t_i, t_o, value, pdf);
}

void rough_plastic_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2, float v2,
                          struct bsdf_sample *s)
{
    const struct microfacet *f = &p->facets;
    if (wi.z <= 0.0f) return;
    float t_i = coat_transmittance(&p->coat, wi.z), weight = p->specular_weight;
    s->lobe = u1 < facets_coat_chance(weight, t_i) ? LOBE_GLOSSY : LOBE_DIFFUSE;
    if (f->kind == MICROFACET_GGX)
        s->wo = facets_plastic_sample(MICROFACET_GGX, f->alpha_u, f->alpha_v, weight, wi, t_i, u1,
                                      u2, v2);
    else
        s->wo = facets_plastic_sample(MICROFACET_BECKMANN, f->alpha_u, f->alpha_v, weight, wi, t_i,
                                      u1, u2, v2);
    struct vec3 value = {0};
    rough_plastic_eval(p, wi, s->wo, &value, &s->pdf);
    if (s->pdf > 0.0f) s->weight = vec3_scale(value, 1.0f / s->pdf);
}
