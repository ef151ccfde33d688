/* SPDX-License-Identifier: Apache-2.0 */
/* Disney's material: Burley 2012, "Physically based shading at Disney", and 2015, "Extending the
 * Disney BRDF to a BSDF with integrated subsurface scattering", as Mitsuba's `principled` puts it
 * together. From the front: a diffuse base with sheen, a main lobe of GGX facets that reflects and
 * refracts, and a clear coat of sharper facets. From behind, the main lobe only. */
#include "render/bsdf.h"
#include "render/fresnel.h"

static float square(float x)
{
    return x * x;
}

static float lerp(float a, float b, float t)
{
    return a + (b - a) * t;
}

/* (1 - c)^5 */
static float schlick_weight(float c)
{
    float m = max_float(0.0f, min_float(1.0f - c, 1.0f));
    return square(square(m)) * m;
}

/* How far Schlick's approximation goes from its value at normal incidence to 1. */
static float schlick_part(float cos_i, float eta)
{
    struct fresnel f = fresnel_dielectric(cos_i, eta);
    return schlick_weight(f.eta_it > 1.0f ? fabsf(cos_i) : fabsf(f.cos_t));
}

static struct vec3 towards_white(struct vec3 c, float t)
{
    return vec3(lerp(c.x, 1.0f, t), lerp(c.y, 1.0f, t), lerp(c.z, 1.0f, t));
}

/* The hue and saturation of the base colour. */
static struct vec3 tint(const struct bsdf_point *p)
{
    float l = vec3_luminance(p->reflectance);
    return l > 0.0f ? vec3_scale(p->reflectance, 1.0f / l) : vec3_splat(1.0f);
}

/* ---- The clear coat's facets ----------------------------------------------------------------- */

static float coat_alpha(const struct principled *d)
{
    return lerp(0.1f, 0.001f, d->clearcoat_gloss);
}

/* GTR1: a distribution with longer tails than GGX. */
static float coat_d(const struct principled *d, float cos_m)
{
    float a2 = square(coat_alpha(d));
    float value = (a2 - 1.0f) * MATH_INV_PI / (logf(a2) * (1.0f + (a2 - 1.0f) * cos_m * cos_m));
    return value * cos_m > 1e-20f ? value : 0.0f;
}

static struct vec3 coat_sample(const struct principled *d, float u, float v)
{
    float a2 = square(coat_alpha(d)), sine, cosine;
    float c2 = (1.0f - powf(a2, 1.0f - v)) / (1.0f - a2);
    float r = sqrtf(max_float(0.0f, 1.0f - c2));
    warp_sincos_turn(u, &sine, &cosine);
    return vec3(r * cosine, r * sine, sqrtf(max_float(0.0f, c2)));
}

/* ---- Chances of the lobes -------------------------------------------------------------------- */

struct chances {
    float diffuse, coat, specular; /* sum 1 */
    float refraction; /* of what a facet does not reflect: the part that gets through */
};

static struct chances chances(const struct bsdf_point *p, float wi_z)
{
    const struct principled *d = &p->principled;
    float through = (1.0f - d->metallic) * d->spec_trans;
    if (wi_z < 0.0f) return (struct chances){0.0f, 0.0f, through > 0.0f ? 1.0f : 0.0f, 1.0f};
    float diffuse = (1.0f - d->metallic) * (1.0f - d->spec_trans) * d->diffuse_rate;
    float coat = 0.25f * d->clearcoat * d->clearcoat_rate;
    float scale = 1.0f / (diffuse + coat + d->specular_rate);
    return (struct chances){diffuse * scale, coat * scale, d->specular_rate * scale, through};
}

/* ---- Parts ----------------------------------------------------------------------------------- */

/* What a facet of the main lobe reflects of light at wi.m = cos_m, seen from the front. */
static struct vec3 front_fresnel(const struct bsdf_point *p, float r, float cos_m)
{
    const struct principled *d = &p->principled;
    float part = schlick_part(cos_m, p->eta);
    struct vec3 metal = towards_white(p->reflectance, part);
    struct vec3 sum = vec3_splat((1.0f - d->metallic) * (1.0f - d->spec_tint) * r);
    sum = vec3_madd(sum, metal, d->metallic);
    if (d->spec_tint == 0.0f) return sum;
    struct vec3 r0 = vec3_scale(tint(p), square((p->eta - 1.0f) / (p->eta + 1.0f)));
    return vec3_madd(sum, towards_white(r0, part), (1.0f - d->metallic) * d->spec_tint);
}

/* The diffuse base and sheen, with the cosine. */
static struct vec3 base_value(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo,
                              float cos_d)
{
    const struct principled *d = &p->principled;
    float f_o = schlick_weight(wo.z), f_i = schlick_weight(wi.z);
    float diffuse = (1.0f - 0.5f * f_i) * (1.0f - 0.5f * f_o);
    float r = 2.0f * d->roughness * square(cos_d);
    float retro = r * (f_o + f_i + f_o * f_i * (r - 1.0f));
    /* Hanrahan & Krueger's flat look of what scatters below the surface. */
    float fss = lerp(1.0f, 0.5f * r, f_o) * lerp(1.0f, 0.5f * r, f_i);
    float flat = 1.25f * (fss * (1.0f / (wo.z + wi.z) - 0.5f) + 0.5f);
    float brdf = (1.0f - d->metallic) * (1.0f - d->spec_trans);
    struct vec3 sum = vec3_scale(p->reflectance, brdf * wo.z * MATH_INV_PI *
                                                     lerp(diffuse + retro, flat, d->flatness));
    if (d->sheen == 0.0f) return sum;
    struct vec3 color = vec3_madd(vec3_splat(1.0f - d->sheen_tint), tint(p), d->sheen_tint);
    return vec3_madd(sum, color,
                     d->sheen * (1.0f - d->metallic) * schlick_weight(fabsf(cos_d)) * wo.z);
}

/* Shadowing of the clear coat, whatever its own roughness. */
static float coat_g(struct vec3 wi, struct vec3 wo, struct vec3 m)
{
    const struct microfacet f = {MICROFACET_GGX, 0.25f, 0.25f};
    return microfacet_g1(&f, wi, m) * microfacet_g1(&f, wo, m);
}

static void add_coat(const struct bsdf_point *p, const struct chances *c, struct vec3 wi,
                     struct vec3 wo, struct vec3 m, struct vec3 *value, float *pdf)
{
    const struct principled *d = &p->principled;
    float i_m = vec3_dot(wi, m), density = coat_d(d, m.z);
    float r = lerp(0.04f, 1.0f, schlick_part(i_m, p->eta));
    *pdf += c->coat * density * m.z / (4.0f * fabsf(vec3_dot(wo, m)));
    *value = vec3_add(*value,
                      vec3_splat(0.25f * d->clearcoat * r * density * coat_g(wi, wo, m) * wo.z));
}

/* ---- All of it ------------------------------------------------------------------------------- */

void principled_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
                     float *pdf)
{
    const struct principled *d = &p->principled;
    bool is_front = wi.z > 0.0f, is_reflection = wi.z * wo.z > 0.0f;
    struct chances c = chances(p, wi.z);
    if (wi.z == 0.0f || wo.z == 0.0f || (!is_front && c.specular == 0.0f)) return;
    float eta = is_front ? p->eta : 1.0f / p->eta, through = (1.0f - d->metallic) * d->spec_trans;
    struct vec3 m = vec3_madd(wi, wo, is_reflection ? 1.0f : eta);
    float length = vec3_length(m);
    if (!(length > 0.0f)) return;
    m = vec3_scale(m, m.z < 0.0f ? -1.0f / length : 1.0f / length);
    float i_m = vec3_dot(wi, m), o_m = vec3_dot(wo, m);
    if (is_front && is_reflection) {
        *pdf = c.diffuse * wo.z * MATH_INV_PI;
        *value = base_value(p, wi, wo, o_m);
    }
    /* Micro- and macrosurface must agree on the side. */
    if (!(i_m * wi.z > 0.0f && o_m * wo.z > 0.0f)) return;
    if (is_front && is_reflection && d->clearcoat > 0.0f) add_coat(p, &c, wi, wo, m, value, pdf);

    float density = microfacet_d(&p->facets, m);
    float g_i = microfacet_g1(&p->facets, wi, m), g_o = microfacet_g1(&p->facets, wo, m);
    float r = fresnel_dielectric(i_m, p->eta).r;
    float visible = density * g_i * fabsf(i_m / wi.z); /* density of m */
    if (is_reflection) {
        float jacobian = 1.0f / (4.0f * fabsf(o_m));
        *pdf += c.specular * visible * (1.0f - c.refraction * (1.0f - r)) * jacobian;
        struct vec3 f = is_front ? front_fresnel(p, r, i_m) : vec3_splat(through * r);
        if (r > 0.0f) *value = vec3_madd(*value, f, visible * jacobian * g_o);
    } else if (through > 0.0f) {
        float jacobian = eta * eta * fabsf(o_m) / square(i_m + eta * o_m);
        *pdf += c.specular * visible * c.refraction * (1.0f - r) * jacobian;
        struct vec3 color = vec3(sqrtf(p->reflectance.x), sqrtf(p->reflectance.y),
                                 sqrtf(p->reflectance.z));
        *value = vec3_madd(*value, color,
                           through * (1.0f - r) * visible * jacobian * g_o / (eta * eta));
    }
}

/* A direction of the main lobe; false when there is none. u1 chooses between its two sides. */
static bool sample_facet(const struct bsdf_point *p, const struct chances *c, struct vec3 wi,
                         float u1, float u2, float v2, struct bsdf_sample *s)
{
    struct vec3 m = microfacet_normal(&p->facets, wi.z < 0.0f ? vec3_neg(wi) : wi, u2, v2);
    struct fresnel f = fresnel_dielectric(vec3_dot(wi, m), p->eta);
    if (u1 >= c->refraction * (1.0f - f.r)) {
        s->wo = fresnel_reflect(wi, m);
        return s->wo.z * wi.z > 0.0f;
    }
    s->wo = fresnel_refract(wi, m, f.cos_t, f.eta_ti);
    s->eta = f.eta_it;
    return s->wo.z * wi.z < 0.0f;
}

void principled_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2, float v2,
                       struct bsdf_sample *s)
{
    struct chances c = chances(p, wi.z);
    if (wi.z == 0.0f || (wi.z < 0.0f && c.specular == 0.0f)) return;
    s->lobe = LOBE_GLOSSY;
    if (u1 < c.diffuse) {
        s->wo = warp_cosine_hemisphere(u2, v2);
        s->lobe = LOBE_DIFFUSE;
    } else if (u1 < c.diffuse + c.coat) {
        s->wo = fresnel_reflect(wi, coat_sample(&p->principled, u2, v2));
        if (s->wo.z <= 0.0f) return;
    } else {
        float rest = max_float(u1 - c.diffuse - c.coat, 0.0f) / c.specular;
        if (!sample_facet(p, &c, wi, rest, u2, v2, s)) return;
    }
    struct vec3 value = {0};
    float pdf = 0.0f;
    principled_eval(p, wi, s->wo, &value, &pdf);
    s->pdf = pdf;
    if (pdf > 0.0f && isfinite(pdf)) s->weight = vec3_scale(value, 1.0f / pdf);
}
