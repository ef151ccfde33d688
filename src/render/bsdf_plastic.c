/* SPDX-License-Identifier: Apache-2.0 */
/* A diffuse base under a dielectric coat, smooth or rough; light that is reflected back inside is
 * summed in closed form. One-sided. */
#include "render/bsdf.h"
#include "render/fresnel.h"

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

/* Chance of choosing a facet of the coat; t_i: what it lets in. */
static float facet_probability(const struct bsdf_point *p, float t_i)
{
    float coat = (1.0f - t_i) * p->specular_weight, base = t_i * (1.0f - p->specular_weight);
    return coat + base > 0.0f ? coat / (coat + base) : 1.0f;
}

void rough_plastic_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo,
                        struct vec3 *value, float *pdf)
{
    if (wi.z <= 0.0f || wo.z <= 0.0f) return;
    struct vec3 m = vec3_normalize(vec3_add(wi, wo)), c = p->reflectance;
    float t_i = coat_transmittance(&p->coat, wi.z), t_o = coat_transmittance(&p->coat, wo.z);
    float coat = facet_probability(p, t_i), cosine = wo.z * MATH_INV_PI, f = p->internal_reflection;
    /* The density of m, D G1(wi) (wi.m) / wi.z, by the Jacobian 1 / (4 wo.m). */
    float facets = microfacet_d(&p->facets, m) * microfacet_g1(&p->facets, wi, m) / (4.0f * wi.z);
    float r = fresnel_dielectric(vec3_dot(wi, m), p->eta).r;
    float base = cosine * t_i * t_o / (p->eta * p->eta);
    struct vec3 inside = p->is_nonlinear ? c : vec3_splat(1.0f);
    *pdf = coat * facets + (1.0f - coat) * cosine;
    *value = vec3(c.x * base / (1.0f - inside.x * f), c.y * base / (1.0f - inside.y * f),
                  c.z * base / (1.0f - inside.z * f));
    *value = vec3_madd(*value, p->specular_reflectance,
                       facets * r * microfacet_g1(&p->facets, wo, m));
}

void rough_plastic_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2, float v2,
                          struct bsdf_sample *s)
{
    if (wi.z <= 0.0f) return;
    if (u1 < facet_probability(p, coat_transmittance(&p->coat, wi.z))) {
        s->wo = fresnel_reflect(wi, microfacet_normal(&p->facets, wi, u2, v2));
        s->lobe = LOBE_GLOSSY;
    } else {
        s->wo = warp_cosine_hemisphere(u2, v2);
        s->lobe = LOBE_DIFFUSE;
    }
    struct vec3 value = {0};
    rough_plastic_eval(p, wi, s->wo, &value, &s->pdf);
    if (s->pdf > 0.0f) s->weight = vec3_scale(value, 1.0f / s->pdf);
}
