/* SPDX-License-Identifier: Apache-2.0 */
#include "render/bsdf.h"

enum { MAX_NESTING = 12 };

static float clamp01(float x)
{
    return min_float(max_float(x, 0.0f), 1.0f);
}

/* ---- Bump and normal maps -------------------------------------------------------------------- */

/* The normal, of any length, that a map gives at the place. */
static struct vec3 mapped_normal(const struct bsdf *b, const struct texture_set *textures,
                                 const struct bsdf_place *at)
{
    if (b->kind == BSDF_NORMALMAP) {
        struct vec3 c = texture_eval(textures, b->normals, at->u, at->v);
        return vec3(2.0f * c.x - 1.0f, 2.0f * c.y - 1.0f, 2.0f * c.z - 1.0f);
    }
    /* The surface moved along its normal by the height; what the normal's own change adds is left
     * out, as usual. */
    struct vec2 slope = texture_gradient_1(textures, b->normals, at->u, at->v);
    struct vec3 dp_du = vec3(at->dp_du.x, at->dp_du.y, b->scale * slope.x);
    struct vec3 dp_dv = vec3(at->dp_dv.x, at->dp_dv.y, b->scale * slope.y);
    struct vec3 n = vec3_cross(dp_du, dp_dv);
    return vec3_dot(n, at->n) < 0.0f ? vec3_neg(n) : n;
}

/* Turns the frame, and `at` into it. */
static void turn(struct bsdf_point *p, const struct bsdf *b, const struct texture_set *textures,
                 struct bsdf_place *at)
{
    struct vec3 n = mapped_normal(b, textures, at);
    if (b->flips_normals && at->wi.z * vec3_dot(at->wi, n) <= 0.0f) n = vec3(-n.x, -n.y, n.z);
    float length = vec3_length(n);
    if (!(length > 0.0f) || !isfinite(length)) return; /* nothing to go by: the surface's own */
    n = vec3_scale(n, 1.0f / length);
    struct frame f = {.n = n};
    struct vec3 s = vec3_madd(vec3(1.0f, 0.0f, 0.0f), n, -n.x);
    float along = vec3_length(s);
    f.s = along > 0.0f ? vec3_scale(s, 1.0f / along) : vec3(0.0f, 1.0f, 0.0f);
    f.t = vec3_cross(n, f.s);
    at->wi = frame_to_local(&f, at->wi);
    at->n = frame_to_local(&f, at->n);
    at->dp_du = frame_to_local(&f, at->dp_du);
    at->dp_dv = frame_to_local(&f, at->dp_dv);
    float z2 = n.z * n.z;
    p->shadow = b->has_shadowing ? min_float(0.125f * (1.0f - z2) / z2, 1.0f) : 0.0f;
    if (!p->is_turned) {
        p->turn = (struct frame){{1, 0, 0}, {0, 1, 0}, {0, 0, p->is_mirrored ? -1.0f : 1.0f}};
        p->is_turned = true;
    }
    const struct frame outer = p->turn;
    p->turn.s = frame_to_world(&outer, f.s);
    p->turn.t = frame_to_world(&outer, f.t);
    p->turn.n = frame_to_world(&outer, f.n);
}

/* ---- Wrappers -------------------------------------------------------------------------------- */

/* Follows wrappers down to a material; NULL when they never end. */
static const struct material *unwrap(struct bsdf_point *p, const struct material *materials,
                                     const struct material *m, const struct texture_set *textures,
                                     struct bsdf_place *at)
{
    for (int depth = 0; depth <= MAX_NESTING; depth++) {
        const struct bsdf *b = m->bsdf;
        uint32_t child = b->child[0];
        switch (b->kind) {
        case BSDF_TWOSIDED:
            if (at->wi.z >= 0.0f) break;
            at->wi.z = -at->wi.z;
            p->is_mirrored = !p->is_mirrored;
            if (p->is_turned) p->turn.n = vec3_neg(p->turn.n);
            if (b->child[1] != SCENE_NONE) child = b->child[1];
            break;
        case BSDF_MASK:
            p->opacity *= clamp01(texture_eval_1(textures, b->opacity, at->u, at->v));
            break;
        case BSDF_BUMPMAP:
        case BSDF_NORMALMAP:
            turn(p, b, textures, at);
            break;
        default:
            return m;
        }
        m = &materials[child];
    }
    return NULL;
}

/* ---- Materials ------------------------------------------------------------------------------- */

static void look_up_facets(struct bsdf_point *p, const struct bsdf *b,
                           const struct texture_set *textures, float u, float v)
{
    float alpha_u = texture_eval_1(textures, b->alpha_u, u, v), alpha_v = alpha_u;
    if (b->alpha_v != b->alpha_u && b->alpha_v != SCENE_NONE)
        alpha_v = texture_eval_1(textures, b->alpha_v, u, v);
    p->facets = microfacet(b->distribution, alpha_u, alpha_v);
}

static void look_up_principled(struct bsdf_point *p, const struct bsdf *b,
                               const struct texture_set *textures, float u, float v)
{
    float value[PRINCIPLED_SLOTS];
    for (int i = 0; i < PRINCIPLED_SLOTS; i++)
        value[i] = clamp01(texture_eval_1(textures, b->principled[i], u, v));
    float roughness = clamp01(texture_eval_1(textures, b->alpha_u, u, v));
    p->principled = (struct principled){
        .anisotropic = value[PRINCIPLED_ANISOTROPIC],
        .roughness = roughness,
        .metallic = value[PRINCIPLED_METALLIC],
        .spec_trans = value[PRINCIPLED_SPEC_TRANS],
        .spec_tint = value[PRINCIPLED_SPEC_TINT],
        .sheen = value[PRINCIPLED_SHEEN],
        .sheen_tint = value[PRINCIPLED_SHEEN_TINT],
        .flatness = value[PRINCIPLED_FLATNESS],
        .clearcoat = value[PRINCIPLED_CLEARCOAT],
        .clearcoat_gloss = value[PRINCIPLED_CLEARCOAT_GLOSS],
        .diffuse_rate = b->diffuse_rate,
        .specular_rate = b->specular_rate,
        .clearcoat_rate = b->clearcoat_rate,
    };
    p->reflectance = texture_eval(textures, b->reflectance, u, v);
    /* Burley 2012: roughness squared looks even; the ellipse keeps its area. */
    float alpha = roughness * roughness;
    float aspect = sqrtf(1.0f - 0.9f * value[PRINCIPLED_ANISOTROPIC]);
    p->facets = microfacet(MICROFACET_GGX, max_float(0.001f, alpha / aspect),
                           max_float(0.001f, alpha * aspect));
    p->eta = b->eta;
    p->has_specular_reflectance = false;
}

/* Colours that sum to more than 1 are scaled down, for no light to be made. */
static void look_up_phong(struct bsdf_point *p, const struct bsdf *b,
                          const struct texture_set *textures, float u, float v)
{
    p->reflectance = texture_eval(textures, b->reflectance, u, v);
    p->specular_reflectance = texture_eval(textures, b->specular_reflectance, u, v);
    p->exponent = max_float(texture_eval_1(textures, b->exponent, u, v), 0.0f);
    float sum = vec3_max(vec3_add(p->reflectance, p->specular_reflectance));
    if (!(sum > 1.0f)) return;
    p->reflectance = vec3_scale(p->reflectance, 1.0f / sum);
    p->specular_reflectance = vec3_scale(p->specular_reflectance, 1.0f / sum);
}

static void look_up_coat(struct bsdf_point *p, const struct material *m)
{
    p->is_nonlinear = m->bsdf->is_nonlinear;
    p->specular_weight = m->specular_weight;
    p->internal_reflection = m->internal_reflection;
    if (!m->coat) return;
    p->coat = coat_at(m->coat, p->facets.alpha_u);
    p->internal_reflection = coat_internal(&p->coat);
}

void bsdf_point_init(struct bsdf_point *p, const struct material *materials, uint32_t index,
                     const struct texture_set *textures, const struct bsdf_place *where)
{
    const struct material *m = &materials[index];
    const struct texture_set *shared = textures;
    struct texture_set here;
    float u = where->u, v = where->v;
    if (m->has_attributes) {
        here = *textures;
        here.place = where->mesh;
        textures = &here;
    }
    p->lobes = m->lobes;
    p->is_mirrored = p->is_turned = p->has_specular_reflectance = false;
    p->opacity = 1.0f;
    if (bsdf_n_children(m->bsdf->kind) > 0) {
        struct bsdf_place at = *where;
        m = unwrap(p, materials, m, textures, &at);
        if (!m) { /* a loop in the nesting: black */
            p->kind = BSDF_DIFFUSE;
            p->reflectance = vec3_splat(0.0f);
            return;
        }
        if (m->bsdf->kind == BSDF_BLEND) p->place = at;
    }
    const struct bsdf *b = m->bsdf;
    p->kind = b->kind;
    switch (b->kind) {
    case BSDF_DIFFUSE:
        p->reflectance = texture_eval(textures, b->reflectance, u, v);
        return;
    case BSDF_ROUGH_DIFFUSE:
        p->reflectance = texture_eval(textures, b->reflectance, u, v);
        p->is_approximate = b->is_approximate;
        look_up_facets(p, b, textures, u, v);
        return;
    case BSDF_PRINCIPLED:
        look_up_principled(p, b, textures, u, v);
        return;
    case BSDF_PHONG:
    case BSDF_BLINN_PHONG:
        p->specular_weight = m->specular_weight;
        look_up_phong(p, b, textures, u, v);
        return;
    case BSDF_NULL:
        return;
    case BSDF_BLEND:
        p->materials = materials;
        p->textures = shared;
        p->child[0] = b->child[0];
        p->child[1] = b->child[1];
        p->weight = clamp01(texture_eval_1(textures, b->weight, u, v));
        return;
    case BSDF_ROUGH_CONDUCTOR:
    case BSDF_ROUGH_DIELECTRIC:
        look_up_facets(p, b, textures, u, v);
        break;
    case BSDF_ROUGH_PLASTIC:
        look_up_facets(p, b, textures, u, v);
        p->reflectance = texture_eval(textures, b->reflectance, u, v);
        look_up_coat(p, m);
        break;
    case BSDF_PLASTIC:
        p->reflectance = texture_eval(textures, b->reflectance, u, v);
        look_up_coat(p, m);
        break;
    default:
        break;
    }
    p->eta = b->eta;
    p->has_specular_reflectance = b->specular_reflectance != SCENE_NONE;
    p->specular_reflectance = texture_eval_or(textures, b->specular_reflectance, u, v, 1.0f);
    p->specular_transmittance = vec3_splat(1.0f);
    if (b->specular_transmittance != SCENE_NONE)
        p->specular_transmittance = texture_eval(textures, b->specular_transmittance, u, v);
    if (b->kind == BSDF_CONDUCTOR || b->kind == BSDF_ROUGH_CONDUCTOR) {
        /* Without an index the metal is a perfect mirror: eta = 0, k = 1 reflects everything. */
        p->eta_rgb = texture_eval_or(textures, b->eta_texture, u, v, 0.0f);
        p->k_rgb = texture_eval_or(textures, b->k_texture, u, v, 1.0f);
    }
}
