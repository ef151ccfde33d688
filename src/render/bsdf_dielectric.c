/* SPDX-License-Identifier: Apache-2.0 */
/* Glass, smooth and rough (Walter et al. 2007, "Microfacet models for refraction through rough
 * surfaces"), from both sides. */
#include "render/bsdf.h"
#include "render/fresnel.h"

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

static float square(float x)
{
    return x * x;
}

/* m on the normal's side, or the other: wi flipped so that it faces the facets' front. */
static struct vec3 front(struct vec3 w, float z)
{
    return z < 0.0f ? vec3_neg(w) : w;
}

void rough_dielectric_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo,
                           struct vec3 *value, float *pdf)
{
    if (wi.z == 0.0f) return;
    bool is_reflection = wi.z * wo.z > 0.0f;
    float eta = wi.z > 0.0f ? p->eta : 1.0f / p->eta;
    struct vec3 m = vec3_madd(wi, wo, is_reflection ? 1.0f : eta);
    float length = vec3_length(m);
    if (!(length > 0.0f)) return;
    m = vec3_scale(m, 1.0f / length);
    m = front(m, m.z);
    float i_m = vec3_dot(wi, m), o_m = vec3_dot(wo, m);
    /* Micro- and macrosurface must agree on the side. */
    if (!(i_m * wi.z > 0.0f && o_m * wo.z > 0.0f)) return;
    float d = microfacet_d(&p->facets, m);
    if (d == 0.0f) return;
    float g_i = microfacet_g1(&p->facets, wi, m), g_o = microfacet_g1(&p->facets, wo, m);
    float r = fresnel_dielectric(i_m, p->eta).r;
    float visible = d * g_i * fabsf(i_m / wi.z); /* density of m */
    if (is_reflection) {
        *pdf = visible * r / (4.0f * fabsf(o_m));
        *value = vec3_scale(p->specular_reflectance, *pdf * g_o);
    } else {
        *pdf = visible * (1.0f - r) * eta * eta * fabsf(o_m) / square(i_m + eta * o_m);
        *value = vec3_scale(p->specular_transmittance, *pdf * g_o / (eta * eta));
    }
}

void rough_dielectric_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2,
                             float v2, struct bsdf_sample *s)
{
    if (wi.z == 0.0f) return;
    float pdf;
    struct vec3 m = microfacet_sample(&p->facets, front(wi, wi.z), u2, v2, &pdf);
    if (pdf == 0.0f) return;
    float i_m = vec3_dot(wi, m);
    struct fresnel f = fresnel_dielectric(i_m, p->eta);
    s->lobe = LOBE_GLOSSY;
    if (u1 <= f.r) {
        s->wo = fresnel_reflect(wi, m);
        s->pdf = pdf * f.r / (4.0f * fabsf(vec3_dot(s->wo, m)));
        s->weight = p->specular_reflectance;
    } else {
        s->wo = fresnel_refract(wi, m, f.cos_t, f.eta_ti);
        s->eta = f.eta_it;
        float o_m = vec3_dot(s->wo, m);
        s->pdf = pdf * (1.0f - f.r) * square(f.eta_it) * fabsf(o_m) / square(i_m + f.eta_it * o_m);
        s->weight = vec3_scale(p->specular_transmittance, square(f.eta_ti));
    }
    s->weight = vec3_scale(s->weight, microfacet_g1(&p->facets, s->wo, m));
    if (!(s->pdf > 0.0f) || !isfinite(s->pdf)) s->weight = vec3_splat(0.0f);
}
