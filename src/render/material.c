/* SPDX-License-Identifier: Apache-2.0 */
#include "render/bsdf.h"
#include "render/fresnel.h"

/* Nested materials (mask of twosided of ...) are followed this deep; deeper ones end here. */
enum { MAX_NESTING = 12 };

static uint32_t lobes_of(const struct bsdf *bsdfs, uint32_t index, int depth)
{
    const struct bsdf *b = &bsdfs[index];
    uint32_t lobes = 0;
    switch (b->kind) {
    case BSDF_DIFFUSE:
    case BSDF_ROUGH_DIFFUSE:
        return LOBE_DIFFUSE;
    case BSDF_CONDUCTOR:
    case BSDF_DIELECTRIC:
        return LOBE_SPECULAR;
    case BSDF_ROUGH_CONDUCTOR:
    case BSDF_ROUGH_DIELECTRIC:
        return LOBE_GLOSSY;
    case BSDF_PLASTIC:
        return LOBE_DIFFUSE | LOBE_SPECULAR;
    case BSDF_ROUGH_PLASTIC:
    case BSDF_PRINCIPLED:
    case BSDF_PHONG:
    case BSDF_BLINN_PHONG:
        return LOBE_DIFFUSE | LOBE_GLOSSY;
    case BSDF_THIN_DIELECTRIC:
        return LOBE_SPECULAR | LOBE_NULL;
    case BSDF_NULL:
        return LOBE_NULL;
    case BSDF_MASK:
        lobes = LOBE_NULL;
        break;
    case BSDF_TWOSIDED:
    case BSDF_BLEND:
    case BSDF_BUMPMAP:
    case BSDF_NORMALMAP:
    case BSDF_KINDS:
        break;
    }
    for (int i = 0; i < bsdf_n_children(b->kind) && depth < MAX_NESTING; i++)
        if (b->child[i] != SCENE_NONE) lobes |= lobes_of(bsdfs, b->child[i], depth + 1);
    return lobes;
}

static bool varies(const struct texture_set *textures, uint32_t index)
{
    return index != SCENE_NONE && textures->textures[index].kind != TEXTURE_CONSTANT;
}

static bool is_anisotropic(const struct bsdf *b, const struct texture_set *textures)
{
    if (b->kind == BSDF_PRINCIPLED) {
        uint32_t t = b->principled[PRINCIPLED_ANISOTROPIC];
        return varies(textures, t) || textures->textures[t].value.x != 0.0f;
    }
    return b->alpha_v != SCENE_NONE && b->alpha_v != b->alpha_u;
}

/* Whether the bsdf or one below it needs texture coordinates, or tangents. */
static void find_needs(struct material *m, const struct bsdf *bsdfs, uint32_t index,
                       const struct texture_set *textures, int depth)
{
    const struct bsdf *b = &bsdfs[index];
    int n_textures = b->kind == BSDF_PRINCIPLED ? BSDF_TEXTURES : BSDF_TEXTURES - PRINCIPLED_SLOTS;
    for (int i = 0; i < n_textures; i++)
        if (varies(textures, bsdf_texture(b, i))) {
            const enum texture_kind kind = textures->textures[bsdf_texture(b, i)].kind;
            m->has_uv = true;
            if (kind == TEXTURE_MESH_ATTRIBUTE) m->has_attributes = true;
            if (kind == TEXTURE_BITMAP && m->picture == SCENE_NONE) m->picture = bsdf_texture(b, i);
        }
    if (is_anisotropic(b, textures) || b->kind == BSDF_NORMALMAP) m->has_direction = true;
    if (b->kind == BSDF_BUMPMAP) m->has_tangents = true;
    for (int i = 0; i < bsdf_n_children(b->kind) && depth < MAX_NESTING; i++)
        if (b->child[i] != SCENE_NONE) find_needs(m, bsdfs, b->child[i], textures, depth + 1);
}

/* Sees whether the material is plain. */
static void find_plain(struct material *m, const struct bsdf *bsdfs,
                       const struct texture_set *textures)
{
    const struct bsdf *b = m->bsdf;
    m->is_twosided = b->kind == BSDF_TWOSIDED;
    if (m->is_twosided && b->child[1] != SCENE_NONE && b->child[1] != b->child[0]) return;
    if (m->is_twosided) b = &bsdfs[b->child[0]];
    m->is_plain = b->kind == BSDF_DIFFUSE && !m->has_attributes;
    if (!m->is_plain) return;
    m->reflectance = textures->textures[b->reflectance].value;
    if (m->has_uv) m->texture = b->reflectance;
}

/* What is the same at all points is looked up once. Twosided turns to the viewer, and no other that
 * is left here asks where that is. */
static void find_ready(struct material *m, const struct material *materials, uint32_t index,
                       const struct texture_set *textures, struct bsdf_point points[2])
{
    if (m->has_uv || m->has_direction || m->has_tangents || m->is_plain) return;
    for (int i = 0; i < 2; i++) {
        const struct bsdf_place at = {.wi = {0, 0, i == 0 ? 1.0f : -1.0f}};
        bsdf_point_init(&points[i], materials, index, textures, &at);
        if (points[i].is_turned || points[i].kind == BSDF_BLEND) return;
    }
    m->ready = points;
}

/* Of these all but the colour is looked up once. */
static void find_tinted(struct material *m, const struct material *materials, uint32_t index,
                        const struct texture_set *textures, struct bsdf_point points[2])
{
    const struct bsdf *b = m->bsdf;
    uint32_t n_varying = 0;
    if (m->is_plain || m->has_attributes || m->has_direction || m->has_tangents) return;
    if (b->kind == BSDF_TWOSIDED) {
        if (b->child[1] != SCENE_NONE && b->child[1] != b->child[0]) return;
        b = materials[b->child[0]].bsdf;
    }
    if (b->kind != BSDF_ROUGH_PLASTIC && b->kind != BSDF_ROUGH_CONDUCTOR) return;
    uint32_t color = b->kind == BSDF_ROUGH_PLASTIC ? b->reflectance : b->specular_reflectance;
    for (int i = 0; i < BSDF_TEXTURES - PRINCIPLED_SLOTS; i++)
        n_varying += varies(textures, bsdf_texture(b, i));
    if (n_varying != 1 || !varies(textures, color)) return;
    for (int i = 0; i < 2; i++) {
        const struct bsdf_place at = {.wi = {0, 0, i == 0 ? 1.0f : -1.0f}};
        bsdf_point_init(&points[i], materials, index, textures, &at);
    }
    m->tinted = points;
    m->texture = color;
}

/* Preference for what is specular over what is diffuse: by their mean colours. */
static float specular_weight(const struct bsdf *b, const struct texture_set *textures)
{
    float base = texture_mean(textures, b->reflectance), coat = 1.0f;
    if (b->specular_reflectance != SCENE_NONE)
        coat = texture_mean(textures, b->specular_reflectance);
    return base + coat > 0.0f ? coat / (base + coat) : 0.5f;
}

static struct coat *prepare_coat(struct coat *coats, uint32_t n, const struct bsdf *b,
                                 const struct texture_set *textures)
{
    /* Materials that differ in roughness only share one. */
    struct coat *c = coats + n;
    for (uint32_t i = 0; i < n; i++)
        if (coats[i].kind == b->distribution && coats[i].eta == b->eta) c = coats + i;
    coat_init(c, b->distribution, b->eta);
    const struct texture *alpha = &textures->textures[b->alpha_u];
    if (alpha->kind == TEXTURE_CONSTANT)
        coat_prepare(c, alpha->value.x, alpha->value.x);
    else
        coat_prepare(c, 0.0f, 1.0f);
    return c;
}

uint32_t material_count_coats(const struct bsdf *bsdfs, uint32_t n_bsdfs)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < n_bsdfs; i++) n += bsdfs[i].kind == BSDF_ROUGH_PLASTIC;
    return n;
}

void material_init(struct material *materials, const struct bsdf *bsdfs, uint32_t n_bsdfs,
                   const struct texture_set *textures, struct coat *coats, struct bsdf_point *ready)
{
    uint32_t n_coats = 0;
    for (uint32_t i = 0; i < n_bsdfs; i++) {
        const struct bsdf *b = &bsdfs[i];
        struct material *m = &materials[i];
        *m = (struct material){.bsdf = b,
                               .lobes = lobes_of(bsdfs, i, 0),
                               .picture = SCENE_NONE,
                               .texture = SCENE_NONE};
        find_needs(m, bsdfs, i, textures, 0);
        find_plain(m, bsdfs, textures);
        if (b->kind == BSDF_PLASTIC)
            m->internal_reflection = fresnel_diffuse_reflectance(1.0f / b->eta);
        if (b->kind == BSDF_ROUGH_PLASTIC) m->coat = prepare_coat(coats, n_coats++, b, textures);
        if (b->kind == BSDF_PLASTIC || b->kind == BSDF_ROUGH_PLASTIC || b->kind == BSDF_PHONG ||
            b->kind == BSDF_BLINN_PHONG)
            m->specular_weight = specular_weight(b, textures);
    }
    for (uint32_t i = 0; i < n_bsdfs; i++) {
        find_ready(&materials[i], materials, i, textures, ready + 2 * (size_t)i);
        find_tinted(&materials[i], materials, i, textures, ready + 2 * (size_t)i);
    }
}
