/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/params_private.h"

/* Wrappers within wrappers further down than this have no path through their parents. */
enum { NESTING_MAX = 4 };

const char *bsdf_kind_name(enum bsdf_kind kind)
{
    static const char *const names[BSDF_KINDS] = {
        [BSDF_DIFFUSE] = "diffuse",
        [BSDF_CONDUCTOR] = "conductor",
        [BSDF_ROUGH_CONDUCTOR] = "roughconductor",
        [BSDF_DIELECTRIC] = "dielectric",
        [BSDF_ROUGH_DIELECTRIC] = "roughdielectric",
        [BSDF_PLASTIC] = "plastic",
        [BSDF_ROUGH_PLASTIC] = "roughplastic",
        [BSDF_THIN_DIELECTRIC] = "thindielectric",
        [BSDF_ROUGH_DIFFUSE] = "roughdiffuse",
        [BSDF_PRINCIPLED] = "principled",
        [BSDF_PHONG] = "phong",
        [BSDF_BLINN_PHONG] = "blinnphong",
        [BSDF_NULL] = "null",
        [BSDF_TWOSIDED] = "twosided",
        [BSDF_MASK] = "mask",
        [BSDF_BLEND] = "blendbsdf",
        [BSDF_BUMPMAP] = "bumpmap",
        [BSDF_NORMALMAP] = "normalmap",
    };
    return names[kind];
}

/* ---- Properties of each material ------------------------------------------------------------ */

#define KIND(k) (1u << BSDF_##k)
enum {
    CONDUCTORS = KIND(CONDUCTOR) | KIND(ROUGH_CONDUCTOR),
    DIELECTRICS = KIND(DIELECTRIC) | KIND(ROUGH_DIELECTRIC) | KIND(THIN_DIELECTRIC),
    PLASTICS = KIND(PLASTIC) | KIND(ROUGH_PLASTIC),
    PHONGS = KIND(PHONG) | KIND(BLINN_PHONG),
    ROUGH = KIND(ROUGH_CONDUCTOR) | KIND(ROUGH_DIELECTRIC) | KIND(ROUGH_PLASTIC) |
            KIND(ROUGH_DIFFUSE),
};

/* Textures: `type` is that of a value. */
static const struct {
    uint32_t kinds; /* a mask of KIND */
    const char *name;
    size_t offset;
    enum param_type type;
    double low, high;
} slots[] = {
#define SLOT(kinds, name, member, type, low, high)                          \
    {                                                                       \
        kinds, name, offsetof(struct bsdf, member), PARAM_##type, low, high \
    }
    SLOT(KIND(DIFFUSE) | KIND(ROUGH_DIFFUSE), "reflectance", reflectance, RGB, 0, 1),
    SLOT(PLASTICS | PHONGS, "diffuse_reflectance", reflectance, RGB, 0, 1),
    SLOT(KIND(PRINCIPLED), "base_color", reflectance, RGB, 0, 1),
    SLOT(CONDUCTORS, "eta", eta_texture, RGB, 0, 1e3),
    SLOT(CONDUCTORS, "k", k_texture, RGB, 0, 1e3),
    SLOT(CONDUCTORS | DIELECTRICS | PLASTICS | PHONGS, "specular_reflectance", specular_reflectance,
         RGB, 0, 1),
    SLOT(DIELECTRICS, "specular_transmittance", specular_transmittance, RGB, 0, 1),
    SLOT(KIND(PRINCIPLED), "roughness", alpha_u, FLOAT, 0, 1),
    SLOT(PHONGS, "exponent", exponent, FLOAT, 0, 1e6),
    SLOT(KIND(MASK), "opacity", opacity, FLOAT, 0, 1),
    SLOT(KIND(BLEND), "weight", weight, FLOAT, 0, 1),
    SLOT(KIND(BUMPMAP), "nested_texture", normals, FLOAT, 0, 1e6),
    SLOT(KIND(NORMALMAP), "normalmap", normals, RGB, 0, 1),
#define PRINCIPLED(name, slot) \
    SLOT(KIND(PRINCIPLED), name, principled[PRINCIPLED_##slot], FLOAT, 0, 1)
    PRINCIPLED("anisotropic", ANISOTROPIC),
    PRINCIPLED("metallic", METALLIC),
    PRINCIPLED("spec_trans", SPEC_TRANS),
    PRINCIPLED("spec_tint", SPEC_TINT),
    PRINCIPLED("sheen", SHEEN),
    PRINCIPLED("sheen_tint", SHEEN_TINT),
    PRINCIPLED("flatness", FLATNESS),
    PRINCIPLED("clearcoat", CLEARCOAT),
    PRINCIPLED("clearcoat_gloss", CLEARCOAT_GLOSS),
#undef PRINCIPLED
#undef SLOT
};
enum { N_SLOTS = sizeof slots / sizeof *slots };

static void walk_properties(struct walk *w, const char *prefix, uint32_t index, bool is_alias)
{
    const struct bsdf *f = &w->b->bsdfs[index].bsdf;
    uint32_t kind = 1u << f->kind;
    for (int i = 0; i < N_SLOTS; i++) {
        if (!(slots[i].kinds & kind)) continue;
        uint32_t texture = *(const uint32_t *)((const char *)f + slots[i].offset);
        walk_slot(w, prefix, slots[i].name, BUILDER_BSDF, index, slots[i].offset, texture,
                  slots[i].type, slots[i].low, slots[i].high, is_alias);
    }
    if (kind & ROUGH) {
        bool is_isotropic = f->alpha_u == f->alpha_v;
        walk_slot(w, prefix, is_isotropic ? "alpha" : "alpha_u", BUILDER_BSDF, index,
                  offsetof(struct bsdf, alpha_u), f->alpha_u, PARAM_FLOAT, 1e-4, 1, is_alias);
        if (!is_isotropic)
            walk_slot(w, prefix, "alpha_v", BUILDER_BSDF, index, offsetof(struct bsdf, alpha_v),
                      f->alpha_v, PARAM_FLOAT, 1e-4, 1, is_alias);
    }
    if (kind & (DIELECTRICS | PLASTICS | KIND(PRINCIPLED)))
        walk_field(w, prefix, "eta", BUILDER_BSDF, index, offsetof(struct bsdf, eta), PARAM_FLOAT,
                   1e-3, 1e3, is_alias);
    if (kind & KIND(BUMPMAP))
        walk_field(w, prefix, "scale", BUILDER_BSDF, index, offsetof(struct bsdf, scale),
                   PARAM_FLOAT, -1e6, 1e6, is_alias);
}

/* ---- Nesting -------------------------------------------------------------------------------- */

static const char *child_name(enum bsdf_kind kind, int i)
{
    static const char *const sides[2] = {"brdf_0", "brdf_1"}, *const parts[2] = {"bsdf_0",
                                                                                 "bsdf_1"};
    if (kind == BSDF_TWOSIDED) return sides[i];
    return kind == BSDF_BLEND ? parts[i] : "nested_bsdf";
}

void walk_bsdf(struct walk *w, const char *prefix, uint32_t index, bool is_alias, bool is_short,
               int depth)
{
    if (!prefix || index >= w->b->n_bsdfs || depth > NESTING_MAX) return;
    const struct bsdf *f = &w->b->bsdfs[index].bsdf;
    if (!is_short && !is_alias) {
        if (w->is_bsdf_named[index]) is_alias = true;
        w->is_bsdf_named[index] = true;
    }
    walk_properties(w, prefix, index, is_alias);
    int n = bsdf_n_children(f->kind);
    if (f->kind == BSDF_TWOSIDED && f->child[1] == f->child[0]) n = 1;
    for (int i = 0; i < n; i++) {
        if (f->child[i] >= w->b->n_bsdfs) continue;
        bool has_own_path = w->b->bsdfs[f->child[i]].object.id != NULL;
        walk_bsdf(w, walk_path(w, "%s.%s", prefix, child_name(f->kind, i)), f->child[i],
                  is_alias || has_own_path, is_short, depth + 1);
        /* A blend has no child that it is about. */
        if (i == 0 && f->kind != BSDF_BLEND)
            walk_bsdf(w, prefix, f->child[i], true, true, depth + 1);
    }
}
