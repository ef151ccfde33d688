/* SPDX-License-Identifier: Apache-2.0 */
#include "render/bsdf.h"

#include "render/fresnel.h"

/* ---- Into the material's own frame ----------------------------------------------------------- */

static struct vec3 inward(const struct bsdf_point *p, struct vec3 w)
{
    if (p->is_turned) return frame_to_local(&p->turn, w);
    if (p->is_mirrored) w.z = -w.z;
    return w;
}

static struct vec3 outward(const struct bsdf_point *p, struct vec3 w)
{
    if (p->is_turned) return frame_to_world(&p->turn, w);
    if (p->is_mirrored) w.z = -w.z;
    return w;
}

/* Whether a direction is on the same side of the shading frame and of the turned one. */
static bool is_same_side(const struct bsdf_point *p, struct vec3 outer, struct vec3 inner)
{
    return (p->is_mirrored ? -outer.z : outer.z) * inner.z > 0.0f;
}

/* Softens the edge of shadow that bumps have, as if they were facets (Estevez, Lecocq & Stein 2019,
 * "A microfacet-based shadowing function to solve the bump terminator problem"). */
static float terminator(const struct bsdf_point *p, struct vec3 wo)
{
    float z2 = wo.z * wo.z, tan2 = (1.0f - z2) / z2;
    return 2.0f / (1.0f + sqrtf(1.0f + p->shadow * max_float(tan2, 0.0f)));
}

/* ---- Kinds ----------------------------------------------------------------------------------- */

void bsdf_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
               float *pdf)
{
    *value = vec3_splat(0.0f);
    *pdf = 0.0f;
    struct vec3 outer = wo;
    wi = inward(p, wi);
    wo = inward(p, wo);
    if (p->is_turned && !is_same_side(p, outer, wo)) return;
    switch (p->kind) {
    case BSDF_DIFFUSE:
        diffuse_eval(p, wi, wo, value, pdf);
        break;
    case BSDF_ROUGH_CONDUCTOR:
        rough_conductor_eval(p, wi, wo, value, pdf);
        break;
    case BSDF_ROUGH_DIELECTRIC:
        rough_dielectric_eval(p, wi, wo, value, pdf);
        break;
    case BSDF_PLASTIC:
        plastic_eval(p, wi, wo, value, pdf);
        break;
    case BSDF_ROUGH_PLASTIC:
        rough_plastic_eval(p, wi, wo, value, pdf);
        break;
    case BSDF_ROUGH_DIFFUSE:
        rough_diffuse_eval(p, wi, wo, value, pdf);
        break;
    case BSDF_PRINCIPLED:
        principled_eval(p, wi, wo, value, pdf);
        break;
    case BSDF_PHONG:
    case BSDF_BLINN_PHONG:
        phong_eval(p, wi, wo, value, pdf);
        break;
    case BSDF_BLEND:
        blend_eval(p, wi, wo, value, pdf);
        break;
    default:
        return;
    }
    if (p->is_turned && p->shadow > 0.0f) *value = vec3_scale(*value, terminator(p, outer));
    if (p->opacity < 1.0f) {
        *value = vec3_scale(*value, p->opacity);
        *pdf *= p->opacity;
    }
}

struct bsdf_sample bsdf_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2,
                               float v2)
{
    struct bsdf_sample s = {.eta = 1.0f};
    if (p->opacity < 1.0f) {
        if (u1 >= p->opacity) {
            s.wo = vec3_neg(wi);
            s.weight = vec3_splat(1.0f);
            s.pdf = 1.0f - p->opacity;
            s.lobe = LOBE_NULL;
            return s;
        }
        u1 /= p->opacity;
    }
    wi = inward(p, wi);
    switch (p->kind) {
    case BSDF_DIFFUSE:
        diffuse_sample(p, wi, u2, v2, &s);
        break;
    case BSDF_CONDUCTOR:
        conductor_sample(p, wi, &s);
        break;
    case BSDF_ROUGH_CONDUCTOR:
        rough_conductor_sample(p, wi, u2, v2, &s);
        break;
    case BSDF_DIELECTRIC:
        dielectric_sample(p, wi, u1, &s);
        break;
    case BSDF_ROUGH_DIELECTRIC:
        rough_dielectric_sample(p, wi, u1, u2, v2, &s);
        break;
    case BSDF_PLASTIC:
        plastic_sample(p, wi, u1, u2, v2, &s);
        break;
    case BSDF_ROUGH_PLASTIC:
        rough_plastic_sample(p, wi, u1, u2, v2, &s);
        break;
    case BSDF_THIN_DIELECTRIC:
        thin_dielectric_sample(p, wi, u1, &s);
        break;
    case BSDF_ROUGH_DIFFUSE:
        rough_diffuse_sample(p, wi, u2, v2, &s);
        break;
    case BSDF_PRINCIPLED:
        principled_sample(p, wi, u1, u2, v2, &s);
        break;
    case BSDF_PHONG:
    case BSDF_BLINN_PHONG:
        phong_sample(p, wi, u1, u2, v2, &s);
        break;
    case BSDF_NULL:
        s.wo = vec3_neg(wi);
        s.weight = vec3_splat(1.0f);
        s.pdf = 1.0f;
        s.lobe = LOBE_NULL;
        break;
    case BSDF_BLEND:
        blend_sample(p, wi, u1, u2, v2, &s);
        break;
    default:
        break;
    }
    s.pdf *= p->opacity;
    /* Absurd values overflow somewhere; rays must have a direction. */
    if (!vec3_is_finite(s.wo)) return (struct bsdf_sample){.wo = {0, 0, 1}, .eta = 1.0f};
    if (!p->is_turned && !p->is_mirrored) return s;
    struct vec3 inner = s.wo;
    s.wo = outward(p, inner);
    if (!p->is_turned) return s;
    if (!is_same_side(p, s.wo, inner))
        s.weight = vec3_splat(0.0f);
    else if (p->shadow > 0.0f)
        s.weight = vec3_scale(s.weight, terminator(p, s.wo));
    return s;
}

/* ---- Buffers --------------------------------------------------------------------------------- */

/* One of a blend's two materials at the point. */
static void child_init(struct bsdf_point *child, const struct bsdf_point *p, int i)
{
    bsdf_point_init(child, p->materials, p->child[i], p->textures, &p->place);
}

struct vec3 bsdf_albedo(const struct bsdf_point *p)
{
    switch (p->kind) {
    case BSDF_DIFFUSE:
    case BSDF_PLASTIC:
    case BSDF_ROUGH_PLASTIC:
    case BSDF_ROUGH_DIFFUSE:
    case BSDF_PRINCIPLED:
        return p->reflectance;
    case BSDF_PHONG:
    case BSDF_BLINN_PHONG:
        return vec3_add(p->reflectance, p->specular_reflectance);
    case BSDF_BLEND: {
        struct bsdf_point a, b;
        child_init(&a, p, 0);
        child_init(&b, p, 1);
        return vec3_madd(vec3_scale(bsdf_albedo(&a), 1.0f - p->weight), bsdf_albedo(&b), p->weight);
    }
    default:
        return p->has_specular_reflectance ? p->specular_reflectance : vec3_splat(0.0f);
    }
}

float bsdf_roughness(const struct bsdf_point *p)
{
    switch (p->kind) {
    case BSDF_DIFFUSE:
    case BSDF_ROUGH_DIFFUSE:
        return 1.0f;
    case BSDF_ROUGH_CONDUCTOR:
    case BSDF_ROUGH_DIELECTRIC:
    case BSDF_ROUGH_PLASTIC:
    case BSDF_PRINCIPLED:
        return p->facets.alpha_u == p->facets.alpha_v
                   ? p->facets.alpha_u
                   : sqrtf(p->facets.alpha_u * p->facets.alpha_v);
    case BSDF_PHONG:
    case BSDF_BLINN_PHONG: /* of the Beckmann surface that looks alike (Walter et al. 2007) */
        return sqrtf(2.0f / (2.0f + p->exponent));
    case BSDF_BLEND: {
        struct bsdf_point a, b;
        child_init(&a, p, 0);
        child_init(&b, p, 1);
        return bsdf_roughness(&a) * (1.0f - p->weight) + bsdf_roughness(&b) * p->weight;
    }
    default:
        return 0.0f;
    }
}

struct vec3 bsdf_normal(const struct bsdf_point *p)
{
    if (!p->is_turned) return vec3(0.0f, 0.0f, 1.0f);
    return p->is_mirrored ? vec3_neg(p->turn.n) : p->turn.n;
}
