/* SPDX-License-Identifier: Apache-2.0 */
/* What buffers show of materials, worked out once for a configuration. */
#include "render/buffers.h"

enum { MAX_NESTING = 12 }; /* as in bsdf_point.c */

static bool is_turned(const struct material *materials, uint32_t index, int depth)
{
    const struct bsdf *b = materials[index].bsdf;
    if (b->kind == BSDF_BUMPMAP || b->kind == BSDF_NORMALMAP) return true;
    for (int i = 0; i < bsdf_n_children(b->kind) && depth < MAX_NESTING; i++)
        if (b->child[i] != SCENE_NONE && is_turned(materials, b->child[i], depth + 1)) return true;
    return false;
}

static bool is_same(const struct look *a, const struct look *b)
{
    return a->albedo.x == b->albedo.x && a->albedo.y == b->albedo.y && a->albedo.z == b->albedo.z &&
           a->roughness == b->roughness && a->is_diffuse == b->is_diffuse;
}

static bool is_constant(const struct texture_set *textures, uint32_t index)
{
    return index == SCENE_NONE || textures->textures[index].kind == TEXTURE_CONSTANT;
}

/* The texture that is the albedo of a material, the same from both sides, of which nothing else
 * that buffers show varies; else SCENE_NONE. */
static uint32_t albedo_texture(const struct material *materials, uint32_t index,
                               const struct texture_set *textures)
{
    const struct bsdf *b = materials[index].bsdf;
    if (materials[index].has_attributes) return SCENE_NONE; /* need to know the place */
    for (int depth = 0; depth < MAX_NESTING; depth++) {
        if (b->kind != BSDF_TWOSIDED && b->kind != BSDF_MASK) break;
        if (b->kind == BSDF_TWOSIDED && b->child[1] != SCENE_NONE && b->child[1] != b->child[0])
            return SCENE_NONE;
        b = materials[b->child[0]].bsdf;
    }
    const bool is_even = is_constant(textures, b->alpha_u) && is_constant(textures, b->alpha_v);
    switch (b->kind) {
    case BSDF_ROUGH_PLASTIC:
        return is_even ? b->reflectance : SCENE_NONE;
    case BSDF_ROUGH_CONDUCTOR:
    case BSDF_ROUGH_DIELECTRIC:
        return is_even ? b->specular_reflectance : SCENE_NONE;
    case BSDF_CONDUCTOR:
    case BSDF_DIELECTRIC:
    case BSDF_THIN_DIELECTRIC:
        return b->specular_reflectance;
    case BSDF_DIFFUSE:
    case BSDF_ROUGH_DIFFUSE:
    case BSDF_PLASTIC:
        return b->reflectance;
    default:
        return SCENE_NONE;
    }
}

void buffers_init_looks(struct look *looks, const struct material *materials, uint32_t n_bsdfs,
                        const struct texture_set *textures)
{
    for (uint32_t i = 0; i < n_bsdfs; i++) {
        struct look *look = &looks[i];
        struct bsdf_point p;
        const uint32_t texture = albedo_texture(materials, i, textures);
        if (is_turned(materials, i, 0)) {
            *look = (struct look){.kind = LOOK_TURNED};
        } else if (materials[i].has_uv && texture == SCENE_NONE) {
            *look = (struct look){.kind = LOOK_VARIES};
        } else {
            struct bsdf_place at = {.wi = {0, 0, 1}};
            bsdf_point_init(&p, materials, i, textures, &at);
            *look = buffers_look(&p);
            at.wi.z = -1.0f;
            bsdf_point_init(&p, materials, i, textures, &at);
            struct look behind = buffers_look(&p);
            if (!is_same(look, &behind)) look->kind = LOOK_VARIES;
            if (!is_constant(textures, texture)) {
                look->kind = LOOK_TEXTURE;
                look->texture = texture;
            }
        }
    }
}

struct look buffers_look(const struct bsdf_point *p)
{
    return (struct look){.albedo = bsdf_albedo(p),
                         .roughness = bsdf_roughness(p),
                         .is_diffuse = p->kind == BSDF_DIFFUSE};
}
