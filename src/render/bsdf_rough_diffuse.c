/* SPDX-License-Identifier: Apache-2.0 */
/* Matte surfaces of V-shaped grooves: Oren & Nayar 1994, "Generalization of Lambert's reflectance
 * model", with the light that bounces once between facets (eq. 30, 31), or their shorter formula.
 * alpha is the rms slope as Beckmann has it; sigma = alpha / sqrt(2), as Mitsuba 0.x does it. */
#include "render/bsdf.h"

/* What is common to both directions. */
struct grooves {
    float cos_phi;             /* of the azimuths' difference */
    float sin_alpha, sin_beta; /* of the greater and the smaller inclination */
    float cos_alpha, cos_beta;
};

static struct grooves grooves(struct vec3 wi, struct vec3 wo)
{
    float sin_i = sqrtf(max_float(0.0f, 1.0f - wi.z * wi.z)),
          sin_o = sqrtf(max_float(0.0f, 1.0f - wo.z * wo.z));
    struct grooves g = {.cos_phi = 0.0f};
    if (sin_i > 1e-4f && sin_o > 1e-4f) {
        float c = (wi.x * wo.x + wi.y * wo.y) / (sin_i * sin_o);
        g.cos_phi = max_float(-1.0f, min_float(c, 1.0f));
    }
    bool is_lower = wi.z < wo.z;
    g.sin_alpha = is_lower ? sin_i : sin_o;
    g.sin_beta = is_lower ? sin_o : sin_i;
    g.cos_alpha = is_lower ? wi.z : wo.z;
    g.cos_beta = is_lower ? wo.z : wi.z;
    return g;
}

/* Reflectance rho -> rho single + rho^2 twice; without the cosine / pi. */
static void factors(const struct bsdf_point *p, const struct grooves *g, float *single,
                    float *twice)
{
    float s2 = 0.5f * p->facets.alpha_u * p->facets.alpha_u;
    float c1 = 1.0f - 0.5f * s2 / (s2 + 0.33f), c2 = 0.45f * s2 / (s2 + 0.09f);
    float tan_beta = g->sin_beta / g->cos_beta;
    *twice = 0.0f;
    if (p->is_approximate) {
        *single = c1 + c2 * max_float(g->cos_phi, 0.0f) * g->sin_alpha * tan_beta;
        return;
    }
    float alpha = acosf(min_float(g->cos_alpha, 1.0f)), beta = acosf(min_float(g->cos_beta, 1.0f));
    float b = 2.0f * beta * MATH_INV_PI, ab = 4.0f * alpha * beta * MATH_INV_PI * MATH_INV_PI;
    float c3 = 0.125f * s2 / (s2 + 0.09f) * ab * ab;
    c2 *= g->cos_phi > 0.0f ? g->sin_alpha : g->sin_alpha - b * b * b;
    float tan_half = (g->sin_alpha + g->sin_beta) / (g->cos_alpha + g->cos_beta);
    *single = c1 + g->cos_phi * c2 * tan_beta + (1.0f - fabsf(g->cos_phi)) * c3 * tan_half;
    *twice = 0.17f * s2 / (s2 + 0.13f) * (1.0f - g->cos_phi * b * b);
}

void rough_diffuse_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo,
                        struct vec3 *value, float *pdf)
{
    if (wi.z <= 0.0f || wo.z <= 0.0f) return;
    struct grooves g = grooves(wi, wo);
    float single, twice;
    factors(p, &g, &single, &twice);
    struct vec3 rho = p->reflectance;
    *pdf = wo.z * MATH_INV_PI;
    *value = vec3_scale(vec3_madd(vec3_scale(rho, single), vec3_mul(rho, rho), twice), *pdf);
}

void rough_diffuse_sample(const struct bsdf_point *p, struct vec3 wi, float u2, float v2,
                          struct bsdf_sample *s)
{
    if (wi.z <= 0.0f) return;
    struct vec3 value = {0};
    s->wo = warp_cosine_hemisphere(u2, v2);
    s->lobe = LOBE_DIFFUSE;
    rough_diffuse_eval(p, wi, s->wo, &value, &s->pdf);
    if (s->pdf > 0.0f) s->weight = vec3_scale(value, 1.0f / s->pdf);
}
