/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/reader_mitsuba_bsdf.h"

static const struct vec3 half = {0.5f, 0.5f, 0.5f};

static lmn_status read_child(struct props *p, uint32_t *index, bool is_needed)
{
    lmn_status status = LMN_OK;
    struct xml_node *node;
    TRY(props_object(p, EL_BSDF, &node));
    if (!node && is_needed)
        return fail_node(p->r, p->node, "<bsdf type=\"%s\"> needs a nested <bsdf>", p->type);
    if (!node) return LMN_OK;
    TRY(load_object(p->r, node));
    *index = node->index;
done:
    return status;
}

lmn_status read_twosided(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = BSDF_TWOSIDED;
    TRY(read_child(p, &f->child[0], true));
    f->child[1] = f->child[0];
    TRY(read_child(p, &f->child[1], false));
done:
    return status;
}

lmn_status read_mask(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = BSDF_MASK;
    TRY(props_texture(p, "opacity", &half, &f->opacity));
    TRY(read_child(p, &f->child[0], true));
done:
    return status;
}

/* ---- Mixtures ------------------------------------------------------------------------------- */

lmn_status read_blend(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = BSDF_BLEND;
    TRY(props_texture(p, "weight", &half, &f->weight));
    TRY(read_child(p, &f->child[0], true));
    TRY(read_child(p, &f->child[1], false));
    if (f->child[1] == SCENE_NONE)
        return fail_node(p->r, p->node, "blendbsdf needs two nested <bsdf>");
done:
    return status;
}

enum { MAX_MIXED = 8 };

/* `weights` of Mitsuba 0.x: numbers with commas or blanks between. */
static lmn_status read_weights(struct props *p, double *weights, uint32_t n)
{
    lmn_status status = LMN_OK;
    const char *text = NULL;
    uint32_t n_weights = 0;
    TRY(props_string(p, "weights", &text));
    struct xml_node *node = props_child(p, "weights");
    if (!node) return fail_node(p->r, p->node, "mixturebsdf needs \"weights\"");
    TRY(read_numbers(p->r, node, "value", weights, MAX_MIXED, &n_weights));
    if (n_weights != n) return fail_node(p->r, node, "%u weights for %u materials", n_weights, n);
    for (uint32_t i = 0; i < n; i++)
        if (!(weights[i] >= 0)) return fail_node(p->r, node, "\"weights\" must not be negative");
done:
    return status;
}

static lmn_status add_part(struct props *p, struct bsdf *part, double weight, uint32_t *index)
{
    lmn_status status = LMN_OK;
    struct builder_object object = {.place = p->node->place};
    TRY(builder_add_constant(p->r->b, object.place, vec3_splat((float)weight), &part->weight,
                             p->r->err));
    if (index) TRY(builder_add_bsdf(p->r->b, &object, part, index, p->r->err));
done:
    return status;
}

/* A sum of materials is blends within blends: of the last two, of that and the one before, ... What
 * is missing to a weight of 1 is black. */
lmn_status read_mixture(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    uint32_t children[MAX_MIXED], n = 0, rest;
    double weights[MAX_MIXED], sum = 0;
    for (; n < MAX_MIXED; n++) {
        children[n] = SCENE_NONE;
        TRY(read_child(p, &children[n], n == 0));
        if (children[n] == SCENE_NONE) break;
    }
    TRY(read_weights(p, weights, n));
    struct builder_object object = {.place = p->node->place};
    struct bsdf black = bsdf_blank(BSDF_DIFFUSE);
    TRY(builder_add_constant(p->r->b, object.place, vec3_splat(0.0f), &black.reflectance,
                             p->r->err));
    TRY(builder_add_bsdf(p->r->b, &object, &black, &rest, p->r->err));
    for (uint32_t i = 0; i < n; i++) sum += weights[i];
    double so_far = sum < 1 ? 1 - sum : 0;
    for (uint32_t i = n; i-- > 0;) {
        struct bsdf part = bsdf_blank(BSDF_BLEND);
        so_far += weights[i];
        part.child[0] = rest;
        part.child[1] = children[i];
        TRY(add_part(p, &part, so_far > 0 ? weights[i] / so_far : 0, i ? &rest : NULL));
        *f = part;
    }
done:
    return status;
}

/* ---- Other normals -------------------------------------------------------------------------- */

/* What both have in common; both features are new in Mitsuba 3.7. */
static lmn_status read_perturbed(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    TRY(props_boolean(p, "flip_invalid_normals", &f->flips_normals));
    TRY(props_boolean(p, "use_shadowing_function", &f->has_shadowing));
    TRY(read_child(p, &f->child[0], true));
done:
    return status;
}

/* The nested texture, whatever its name. */
static lmn_status read_nested_texture(struct props *p, uint32_t *index)
{
    lmn_status status = LMN_OK;
    struct xml_node *node;
    TRY(props_object(p, EL_TEXTURE, &node));
    if (!node) return fail_node(p->r, p->node, "%s needs a nested <texture>", p->type);
    TRY(load_object(p->r, node));
    *index = node->index;
done:
    return status;
}

lmn_status read_bumpmap(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = BSDF_BUMPMAP;
    TRY(props_float(p, "scale", &f->scale));
    TRY(read_nested_texture(p, &f->normals));
    TRY(read_perturbed(p, f));
done:
    return status;
}

lmn_status read_normalmap(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = BSDF_NORMALMAP;
    TRY(props_texture(p, "normalmap", NULL, &f->normals));
    if (f->normals == SCENE_NONE) TRY(read_nested_texture(p, &f->normals));
    TRY(read_perturbed(p, f));
done:
    return status;
}
