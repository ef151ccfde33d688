/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene.h"

#include <stddef.h>
#include <string.h>

#include "scene/reader_mitsuba.h"
#include "scene/variables.h"

lmn_status scene_load(const char *path, const struct scene_load_options *options,
                      struct scene **out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct builder *b = NULL;
    struct scene *s = NULL;
    TRY(builder_new(path, &b, err));
    TRY(reader_mitsuba_read(b, options, err));
    TRY(variables_declare(b, options ? options->variables_path : NULL, err));
    TRY(builder_finish(b, &s, err));
    TRY(variables_resolve(b, s, err));
    *out = s;
    s = NULL; /* ownership moved to the caller */
done:
    builder_free(b);
    scene_free(s);
    return status;
}

void scene_free(struct scene *s)
{
    if (!s) return;
    for (uint32_t i = 0; i < s->n_bitmaps; i++) bitmap_release(&s->bitmaps[i]);
    arena_release(&s->arena);
    mem_free(s);
}

/* ---- Materials ------------------------------------------------------------------------------ */

#define PRINCIPLED(slot) offsetof(struct bsdf, principled) + PRINCIPLED_##slot * sizeof(uint32_t)
const uint32_t bsdf_texture_offsets[BSDF_TEXTURES] = {
    offsetof(struct bsdf, reflectance),
    offsetof(struct bsdf, specular_reflectance),
    offsetof(struct bsdf, specular_transmittance),
    offsetof(struct bsdf, alpha_u),
    offsetof(struct bsdf, alpha_v),
    offsetof(struct bsdf, eta_texture),
    offsetof(struct bsdf, k_texture),
    offsetof(struct bsdf, exponent),
    offsetof(struct bsdf, opacity),
    offsetof(struct bsdf, weight),
    offsetof(struct bsdf, normals),
    PRINCIPLED(ANISOTROPIC),
    PRINCIPLED(METALLIC),
    PRINCIPLED(SPEC_TRANS),
    PRINCIPLED(SPEC_TINT),
    PRINCIPLED(SHEEN),
    PRINCIPLED(SHEEN_TINT),
    PRINCIPLED(FLATNESS),
    PRINCIPLED(CLEARCOAT),
    PRINCIPLED(CLEARCOAT_GLOSS),
};
#undef PRINCIPLED

struct bsdf bsdf_blank(enum bsdf_kind kind)
{
    struct bsdf f = {.kind = kind,
                     .eta = 1.0f,
                     .scale = 1.0f,
                     .flips_normals = true,
                     .has_shadowing = true,
                     .diffuse_rate = 1.0f,
                     .specular_rate = 1.0f,
                     .clearcoat_rate = 1.0f,
                     .child = {SCENE_NONE, SCENE_NONE}};
    for (int i = 0; i < BSDF_TEXTURES; i++) {
        const uint32_t none = SCENE_NONE;
        memcpy((char *)&f + bsdf_texture_offsets[i], &none, sizeof none);
    }
    return f;
}
