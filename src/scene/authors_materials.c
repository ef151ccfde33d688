/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "scene/authors_private.h"

/* What the wrappers around a material are about: its innermost one, from the front. */
static uint32_t unwrap(const struct builder *b, uint32_t index)
{
    for (int depth = 0; depth < 64; depth++) {
        const struct bsdf *f = &b->bsdfs[index].bsdf;
        if (bsdf_n_children(f->kind) == 0 || f->child[0] >= b->n_bsdfs) break;
        index = f->child[0];
    }
    return index;
}

static uint32_t count_textures(const struct builder_object *o)
{
    uint32_t n = 1; /* the first reflectance is the material's own */
    for (uint32_t i = 0; i < o->n_extras; i++)
        n += strcmp(o->extras[i].name, "reflectance") == 0 && o->extras[i].texture != SCENE_NONE;
    return n;
}

static lmn_status write_color(struct declaring *d, uint32_t slot, const char *property,
                              const struct drive drive[3])
{
    struct write w = authors_new_write(
        d, authors_field(d->b, d->object->id, property, BUILDER_TEXTURE, slot,
                         offsetof(struct texture, value), PARAM_RGB));
    w.kind = BINDING_RGB;
    memcpy(w.drive, drive, sizeof w.drive);
    return variable_set_write(d->b, &w, d->err);
}

/* 3: the reflectance, which multiplies a texture; 1: which of several textures; 4: both. */
static lmn_status declare_diffuse(struct declaring *d, uint32_t index,
                                  const struct builder_object *said)
{
    lmn_status status = LMN_OK;
    struct builder *b = d->b;
    struct ranges r;
    struct drive drive[3];
    TRY(authors_read_ranges(said, &r, d->err));
    authors_default_to_unit(&r);
    uint32_t n_textures = count_textures(said), n_options = 0;
    uint32_t *options = arena_new(b->arena, n_textures, sizeof *options);
    const char **names = arena_new(b->arena, n_textures, sizeof *names);
    if (!options || !names) {
        status = fail_memory(d->err, "the variables");
        goto done;
    }
    options[n_options++] = b->bsdfs[index].bsdf.reflectance;
    for (uint32_t i = 0; i < said->n_extras; i++)
        if (strcmp(said->extras[i].name, "reflectance") == 0 &&
            said->extras[i].texture != SCENE_NONE)
            options[n_options++] = said->extras[i].texture;
    bool has_color = r.n_parameters >= 3, has_choice = r.n_parameters != 3 && n_options > 1;
    for (uint32_t i = 0; i < n_options; i++) {
        const char *id = options[i] < b->n_textures ? b->textures[options[i]].object.id : NULL;
        char text[24];
        snprintf(text, sizeof text, "texture_%u", i);
        names[i] = id ? id : arena_strdup(b->arena, text);
        if (!names[i]) {
            status = fail_memory(d->err, "the variables");
            goto done;
        }
    }

    if (has_color) {
        d->kind = "color";
        for (uint32_t i = 0; i < n_options; i++) TRY(authors_own_texture(b, &options[i], d->err));
        b->bsdfs[index].bsdf.reflectance = options[0];
        TRY(authors_add_channels(d, &r, b->textures[options[0]].texture.value, drive));
        uint32_t n_written = has_choice ? n_options : 1;
        bool varies = b->variables->n_variables > d->first;
        for (uint32_t i = 0; i < n_written && varies; i++)
            TRY(write_color(d, options[i], "reflectance.value", drive));
    }
    if (has_choice) {
        struct write w = authors_new_write(
            d, authors_field(b, d->object->id, "reflectance", BUILDER_BSDF, index,
                             offsetof(struct bsdf, reflectance), PARAM_TEXTURE));
        d->kind = "choice";
        TRY(authors_add_choice(d, "texture", names, n_options, &w.variable));
        w.kind = BINDING_CHOICE;
        w.options = options;
        TRY(variable_set_write(b, &w, d->err));
    }
done:
    return status;
}

/* 1: alpha, the 4th bound; 3: specular reflectance; 4: both. */
static lmn_status declare_glossy(struct declaring *d, uint32_t index,
                                 const struct builder_object *said)
{
    lmn_status status = LMN_OK;
    struct builder *b = d->b;
    struct ranges r;
    TRY(authors_read_ranges(said, &r, d->err));
    bool has_color = r.n_parameters >= 3, has_alpha = r.n_parameters == 1 || r.n_parameters >= 4;
    if (has_color) {
        struct drive drive[3];
        uint32_t slot = b->bsdfs[index].bsdf.specular_reflectance;
        authors_default_to_unit(&r);
        d->kind = "color";
        TRY(authors_own_texture(b, &slot, d->err));
        b->bsdfs[index].bsdf.specular_reflectance = slot;
        TRY(authors_add_channels(d, &r, b->textures[slot].texture.value, drive));
        if (b->variables->n_variables > d->first)
            TRY(write_color(d, slot, "specular_reflectance.value", drive));
    }
    const struct bsdf *f = &b->bsdfs[index].bsdf;
    bool is_rough = f->kind == BSDF_ROUGH_CONDUCTOR || f->kind == BSDF_ROUGH_DIELECTRIC ||
                    f->kind == BSDF_ROUGH_PLASTIC;
    if (!has_alpha || r.range[3] == 0) goto done;
    if (!is_rough) {
        status = fail_at(d->err, said->place, "\"%s\" has a variable alpha but is not rough",
                         d->object->id);
        goto done;
    }
    if (!(r.min[3] >= 0) || !(r.min[3] + r.range[3] >= 0)) {
        status = fail_at(d->err, said->place, "\"%s\": alpha would be negative", d->object->id);
        goto done;
    }
    uint32_t u = f->alpha_u, v = f->alpha_v;
    d->kind = "float";
    struct write w = authors_new_write(
        d, authors_field(b, d->object->id, "alpha.value", BUILDER_TEXTURE, u,
                         offsetof(struct texture, value), PARAM_FLOAT));
    w.kind = BINDING_SPLAT;
    TRY(authors_own_texture(b, &u, d->err));
    v = v == f->alpha_u ? u : v;
    b->bsdfs[index].bsdf.alpha_u = w.target.index = u;
    b->bsdfs[index].bsdf.alpha_v = v;
    TRY(authors_add_range(d, "alpha", "", r.min[3], r.range[3],
                          (double)b->textures[u].texture.value.x, &w.drive[0]));
    TRY(variable_set_write(b, &w, d->err));
    if (v == u) goto done;
    TRY(authors_own_texture(b, &v, d->err));
    b->bsdfs[index].bsdf.alpha_v = w.target.index = v;
    TRY(variable_set_write(b, &w, d->err));
done:
    return status;
}

/* The id may be on the wrapper of the material that varies, and the ranges with either. */
lmn_status authors_declare_bsdf(struct declaring *d, uint32_t index)
{
    uint32_t inner = unwrap(d->b, index);
    const struct builder_object *said = d->object;
    if (said->n_extras == 0) said = &d->b->bsdfs[inner].object;
    switch (d->b->bsdfs[inner].bsdf.kind) {
    case BSDF_DIFFUSE:
    case BSDF_ROUGH_DIFFUSE:
        return declare_diffuse(d, inner, said);
    case BSDF_PLASTIC:
    case BSDF_ROUGH_PLASTIC:
    case BSDF_THIN_DIELECTRIC:
    case BSDF_CONDUCTOR:
    case BSDF_ROUGH_CONDUCTOR:
    case BSDF_DIELECTRIC:
    case BSDF_ROUGH_DIELECTRIC:
        return declare_glossy(d, inner, said);
    default:
        return LMN_OK;
    }
}
