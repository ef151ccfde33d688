/* SPDX-License-Identifier: Apache-2.0 */
#include "render/bsdf.h"

#include "render/fresnel.h"

/* Nested materials (mask of twosided of ...) are followed this deep; deeper ones end here. */
enum { MAX_NESTING = 8 };

static uint32_t lobes_of(const struct bsdf *bsdfs, uint32_t index, int depth)
{
    const struct bsdf *b = &bsdfs[index];
    switch (b->kind) {
    case BSDF_DIFFUSE:
        return LOBE_DIFFUSE;
    case BSDF_CONDUCTOR:
        return LOBE_SPECULAR;
    case BSDF_ROUGH_CONDUCTOR:
        return LOBE_GLOSSY;
    case BSDF_DIELECTRIC:
        return LOBE_SPECULAR;
    case BSDF_ROUGH_DIELECTRIC:
        return LOBE_GLOSSY;
    case BSDF_PLASTIC:
        return LOBE_DIFFUSE | LOBE_SPECULAR;
    case BSDF_TWOSIDED:
    case BSDF_MASK:
        break;
    }
    if (depth == MAX_NESTING) return 0;
    uint32_t lobes = lobes_of(bsdfs, b->child[0], depth + 1);
    if (b->kind == BSDF_MASK) return lobes | LOBE_NULL;
    if (b->child[1] != SCENE_NONE) lobes |= lobes_of(bsdfs, b->child[1], depth + 1);
    return lobes;
}

static bool varies(const struct texture_set *textures, uint32_t index)
{
    return index != SCENE_NONE && textures->textures[index].kind != TEXTURE_CONSTANT;
}

/* Whether the bsdf or one below it needs texture coordinates, or a tangent. */
static void find_needs(struct material *m, const struct bsdf *bsdfs, uint32_t index,
                       const struct texture_set *textures, int depth)
{
    const struct bsdf *b = &bsdfs[index];
    const uint32_t used[] = {b->reflectance,
                             b->specular_reflectance,
                             b->specular_transmittance,
                             b->alpha_u,
                             b->alpha_v,
                             b->eta_texture,
                             b->k_texture,
                             b->opacity};
    for (size_t i = 0; i < sizeof used / sizeof *used; i++)
        if (varies(textures, used[i])) m->has_uv = true;
    bool is_rough = b->kind == BSDF_ROUGH_CONDUCTOR || b->kind == BSDF_ROUGH_DIELECTRIC;
    if (is_rough && b->alpha_v != SCENE_NONE && b->alpha_v != b->alpha_u) m->has_direction = true;
    if ((b->kind != BSDF_TWOSIDED && b->kind != BSDF_MASK) || depth == MAX_NESTING) return;
    find_needs(m, bsdfs, b->child[0], textures, depth + 1);
    if (b->kind == BSDF_TWOSIDED && b->child[1] != SCENE_NONE)
        find_needs(m, bsdfs, b->child[1], textures, depth + 1);
}

/* Sees whether the material is plain. */
static void find_plain(struct material *m, const struct bsdf *bsdfs,
                       const struct texture_set *textures)
{
    const struct bsdf *b = m->bsdf;
    m->is_twosided = b->kind == BSDF_TWOSIDED;
    if (m->is_twosided && b->child[1] != SCENE_NONE && b->child[1] != b->child[0]) return;
    if (m->is_twosided) b = &bsdfs[b->child[0]];
    m->is_plain = b->kind == BSDF_DIFFUSE && !m->has_uv;
    if (m->is_plain) m->reflectance = textures->textures[b->reflectance].value;
}

void material_init(struct material *materials, const struct bsdf *bsdfs, uint32_t n_bsdfs,
                   const struct texture_set *textures)
{
    for (uint32_t i = 0; i < n_bsdfs; i++) {
        const struct bsdf *b = &bsdfs[i];
        struct material *m = &materials[i];
        *m = (struct material){.bsdf = b, .lobes = lobes_of(bsdfs, i, 0)};
        find_needs(m, bsdfs, i, textures, 0);
        find_plain(m, bsdfs, textures);
        if (b->kind == BSDF_PLASTIC) {
            m->internal_reflection = fresnel_diffuse_reflectance(1.0f / b->eta);
            float base = texture_mean(textures, b->reflectance), coat = 1.0f;
            if (b->specular_reflectance != SCENE_NONE)
                coat = texture_mean(textures, b->specular_reflectance);
            m->specular_weight = base + coat > 0.0f ? coat / (base + coat) : 0.5f;
        }
    }
}

void bsdf_point_init(struct bsdf_point *p, const struct material *materials, uint32_t index,
                     const struct texture_set *textures, float u, float v, float wi_z)
{
    const struct material *m = &materials[index];
    p->lobes = m->lobes;
    p->is_mirrored = p->has_specular_reflectance = false;
    p->opacity = 1.0f;
    for (int depth = 0; m->bsdf->kind == BSDF_TWOSIDED || m->bsdf->kind == BSDF_MASK; depth++) {
        const struct bsdf *b = m->bsdf;
        uint32_t child = b->child[0];
        if (b->kind == BSDF_TWOSIDED) {
            if (p->is_mirrored ? wi_z > 0.0f : wi_z < 0.0f) {
                p->is_mirrored = !p->is_mirrored;
                if (b->child[1] != SCENE_NONE) child = b->child[1];
            }
        } else {
            float opacity = texture_eval_1(textures, b->opacity, u, v);
            p->opacity *= min_float(max_float(opacity, 0.0f), 1.0f);
        }
        m = &materials[child];
        if (depth == MAX_NESTING) { /* a loop in the nesting: black */
            p->kind = BSDF_DIFFUSE;
            p->reflectance = vec3_splat(0.0f);
            return;
        }
    }
    const struct bsdf *b = m->bsdf;
    p->kind = b->kind;
    switch (b->kind) {
    case BSDF_DIFFUSE:
        p->reflectance = texture_eval(textures, b->reflectance, u, v);
        return;
    case BSDF_ROUGH_CONDUCTOR:
    case BSDF_ROUGH_DIELECTRIC: {
        float alpha_u = texture_eval_1(textures, b->alpha_u, u, v), alpha_v = alpha_u;
        if (b->alpha_v != b->alpha_u && b->alpha_v != SCENE_NONE)
            alpha_v = texture_eval_1(textures, b->alpha_v, u, v);
        p->facets = microfacet(b->distribution, alpha_u, alpha_v);
        break;
    }
    case BSDF_PLASTIC:
        p->reflectance = texture_eval(textures, b->reflectance, u, v);
        p->is_nonlinear = b->is_nonlinear;
        p->specular_weight = m->specular_weight;
        p->internal_reflection = m->internal_reflection;
        break;
    default:
        break;
    }
    p->eta = b->eta;
    p->has_specular_reflectance = b->specular_reflectance != SCENE_NONE;
    p->specular_reflectance = texture_eval_or(textures, b->specular_reflectance, u, v, 1.0f);
    p->specular_transmittance = vec3_splat(1.0f);
    if (b->kind == BSDF_DIELECTRIC || b->kind == BSDF_ROUGH_DIELECTRIC)
        p->specular_transmittance = texture_eval_or(textures, b->specular_transmittance, u, v,
                                                    1.0f);
    if (b->kind == BSDF_CONDUCTOR || b->kind == BSDF_ROUGH_CONDUCTOR) {
        /* Without an index the metal is a perfect mirror: eta = 0, k = 1 reflects everything. */
        p->eta_rgb = texture_eval_or(textures, b->eta_texture, u, v, 0.0f);
        p->k_rgb = texture_eval_or(textures, b->k_texture, u, v, 1.0f);
    }
}

void bsdf_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
               float *pdf)
{
    *value = vec3_splat(0.0f);
    *pdf = 0.0f;
    if (p->is_mirrored) {
        wi.z = -wi.z;
        wo.z = -wo.z;
    }
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
    default:
        return;
    }
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
    if (p->is_mirrored) wi.z = -wi.z;
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
    default:
        break;
    }
    if (p->is_mirrored) s.wo.z = -s.wo.z;
    s.pdf *= p->opacity;
    return s;
}

struct vec3 bsdf_albedo(const struct bsdf_point *p)
{
    switch (p->kind) {
    case BSDF_DIFFUSE:
    case BSDF_PLASTIC:
        return p->reflectance;
    default:
        return p->has_specular_reflectance ? p->specular_reflectance : vec3_splat(0.0f);
    }
}

float bsdf_roughness(const struct bsdf_point *p)
{
    switch (p->kind) {
    case BSDF_DIFFUSE:
        return 1.0f;
    case BSDF_ROUGH_CONDUCTOR:
    case BSDF_ROUGH_DIELECTRIC:
        return p->facets.alpha_u == p->facets.alpha_v
                   ? p->facets.alpha_u
                   : sqrtf(p->facets.alpha_u * p->facets.alpha_v);
    default:
        return 0.0f;
    }
}
