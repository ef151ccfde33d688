/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/materials.h"
#include "scene/reader_mitsuba_private.h"

/* One function per material; defaults are Mitsuba 3's. */
typedef lmn_status bsdf_fn(struct props *p, struct bsdf *f);

/* specular_reflectance and specular_transmittance stay absent when they are: 1 for the light, but
 * the buffers tell the difference (the paper's albedo of glass without a colour is 0). */
static const struct vec3 half = {0.5f, 0.5f, 0.5f}, tenth = {0.1f, 0.1f, 0.1f};

/* ---- Shared properties -------------------------------------------------------------------- */

/* An index of refraction: a number or the name of a substance. */
static lmn_status read_ior(struct props *p, const char *name, float *out)
{
    lmn_status status = LMN_OK;
    const char *substance = NULL;
    if (!props_is_string(p, name)) {
        TRY(props_positive(p, name, out));
    } else {
        TRY(props_string(p, name, &substance));
        if (find_ior(substance, out)) return LMN_OK;
        const char *names[MAX_MATERIAL_NAMES];
        size_t n = ior_names(names, MAX_MATERIAL_NAMES);
        return fail_unknown(p->r, p->node, "unknown substance", substance, names, n);
    }
done:
    return status;
}

static lmn_status read_eta(struct props *p, float int_ior, float *eta)
{
    lmn_status status = LMN_OK;
    float ext_ior = 1.000277f; /* air */
    TRY(read_ior(p, "int_ior", &int_ior));
    TRY(read_ior(p, "ext_ior", &ext_ior));
    *eta = int_ior / ext_ior;
    if (!isfinite(*eta) || !(*eta > 0.0f))
        return fail_node(p->r, p->node, "int_ior / ext_ior is out of range");
done:
    return status;
}

static lmn_status read_roughness(struct props *p, struct bsdf *f)
{
    static const char *const words[] = {"beckmann", "ggx"};
    lmn_status status = LMN_OK;
    uint32_t distribution = MICROFACET_BECKMANN;
    bool sample_visible = true;
    TRY(props_choice(p, "distribution", words, 2, &distribution));
    f->distribution = (enum microfacet_kind)distribution;
    /* How directions are drawn changes no expectation; visible normals are always used. */
    TRY(props_boolean(p, "sample_visible", &sample_visible));
    if (props_has(p, "alpha_u") || props_has(p, "alpha_v")) {
        if (props_has(p, "alpha"))
            return fail_node(p->r, p->node, "either \"alpha\" or \"alpha_u\" and \"alpha_v\"");
        TRY(props_texture(p, "alpha_u", &tenth, &f->alpha_u));
        TRY(props_texture(p, "alpha_v", &tenth, &f->alpha_v));
    } else {
        TRY(props_texture(p, "alpha", &tenth, &f->alpha_u));
        f->alpha_v = f->alpha_u;
    }
done:
    return status;
}

/* Mitsuba 0.x gives conductors the index of the medium around them, which scales eta and k. */
static lmn_status divide_by_outside(struct props *p, const struct bsdf *f)
{
    lmn_status status = LMN_OK;
    struct builder *b = p->r->b;
    float ext_eta = 1.0f;
    const uint32_t textures[] = {f->eta_texture, f->k_texture};
    TRY(props_positive(p, "ext_eta", &ext_eta));
    for (int i = 0; i < 2 && ext_eta != 1.0f; i++) {
        struct builder_texture *t = &b->textures[textures[i]];
        if (t->object.id)
            return fail_node(p->r, p->node, "\"ext_eta\" with a texture is not supported");
        t->texture.value = vec3_scale(t->texture.value, 1.0f / ext_eta);
    }
done:
    return status;
}

/* Complex index of refraction: a material's name, or eta and k. */
static lmn_status read_conductor(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    struct vec3 eta = vec3(0, 0, 0), k = vec3(1, 1, 1); /* "none": a perfect mirror */
    const char *material = NULL;
    TRY(props_string(p, "material", &material));
    if (material && (props_has(p, "eta") || props_has(p, "k")))
        return fail_node(p->r, p->node, "either \"material\" or \"eta\" and \"k\"");
    if (material && !find_conductor(material, &eta, &k)) {
        const char *names[MAX_MATERIAL_NAMES];
        size_t n = conductor_names(names, MAX_MATERIAL_NAMES);
        return fail_unknown(p->r, p->node, "unknown material", material, names, n);
    }
    TRY(props_texture(p, "eta", &eta, &f->eta_texture));
    TRY(props_texture(p, "k", &k, &f->k_texture));
    TRY(divide_by_outside(p, f));
    TRY(props_texture(p, "specular_reflectance", NULL, &f->specular_reflectance));
done:
    return status;
}

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

/* ---- Materials ---------------------------------------------------------------------------- */

static lmn_status read_diffuse(struct props *p, struct bsdf *f)
{
    f->kind = BSDF_DIFFUSE;
    return props_texture(p, "reflectance", &half, &f->reflectance);
}

static lmn_status read_smooth_conductor(struct props *p, struct bsdf *f)
{
    f->kind = BSDF_CONDUCTOR;
    return read_conductor(p, f);
}

static lmn_status read_rough_conductor(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = BSDF_ROUGH_CONDUCTOR;
    TRY(read_roughness(p, f));
    TRY(read_conductor(p, f));
done:
    return status;
}

static lmn_status read_dielectric(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = BSDF_DIELECTRIC;
    TRY(read_eta(p, 1.5046f, &f->eta)); /* bk7 */
    TRY(props_texture(p, "specular_reflectance", NULL, &f->specular_reflectance));
    TRY(props_texture(p, "specular_transmittance", NULL, &f->specular_transmittance));
done:
    return status;
}

static lmn_status read_rough_dielectric(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    TRY(read_dielectric(p, f));
    f->kind = BSDF_ROUGH_DIELECTRIC;
    if (f->eta == 1.0f)
        return fail_node(p->r, p->node, "roughdielectric needs int_ior different from ext_ior");
    TRY(read_roughness(p, f));
done:
    return status;
}

static lmn_status read_plastic(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = BSDF_PLASTIC;
    TRY(read_eta(p, 1.49f, &f->eta)); /* polypropylene */
    TRY(props_texture(p, "diffuse_reflectance", &half, &f->reflectance));
    TRY(props_texture(p, "specular_reflectance", NULL, &f->specular_reflectance));
    TRY(props_boolean(p, "nonlinear", &f->is_nonlinear));
done:
    return status;
}

static lmn_status read_twosided(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = BSDF_TWOSIDED;
    TRY(read_child(p, &f->child[0], true));
    f->child[1] = f->child[0];
    TRY(read_child(p, &f->child[1], false));
done:
    return status;
}

static lmn_status read_mask(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = BSDF_MASK;
    TRY(props_texture(p, "opacity", &half, &f->opacity));
    TRY(read_child(p, &f->child[0], true));
done:
    return status;
}

/* ---- Table -------------------------------------------------------------------------------- */

static const struct {
    const char *type;
    bsdf_fn *read; /* NULL: known, not supported yet */
} plugins[] = {
    {"diffuse", read_diffuse},
    {"conductor", read_smooth_conductor},
    {"roughconductor", read_rough_conductor},
    {"dielectric", read_dielectric},
    {"roughdielectric", read_rough_dielectric},
    {"plastic", read_plastic},
    {"twosided", read_twosided},
    {"mask", read_mask},
    {"roughdiffuse", NULL},
    {"thindielectric", NULL},
    {"roughplastic", NULL},
    {"principled", NULL},
    {"principledthin", NULL},
    {"phong", NULL},
    {"blinnphong", NULL},
    {"ward", NULL},
    {"coating", NULL},
    {"roughcoating", NULL},
    {"blendbsdf", NULL},
    {"mixturebsdf", NULL},
    {"bumpmap", NULL},
    {"normalmap", NULL},
    {"null", NULL},
    {"hair", NULL},
    {"measured", NULL},
    {"polarizer", NULL},
    {"retarder", NULL},
    {"circular", NULL},
    {"pplastic", NULL},
};
enum { N_PLUGINS = sizeof plugins / sizeof *plugins };

lmn_status load_bsdf(struct reader *r, struct xml_node *node, uint32_t *index)
{
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_object object;
    struct bsdf f = {.reflectance = SCENE_NONE,
                     .specular_reflectance = SCENE_NONE,
                     .specular_transmittance = SCENE_NONE,
                     .alpha_u = SCENE_NONE,
                     .alpha_v = SCENE_NONE,
                     .eta_texture = SCENE_NONE,
                     .k_texture = SCENE_NONE,
                     .eta = 1.0f,
                     .opacity = SCENE_NONE,
                     .child = {SCENE_NONE, SCENE_NONE}};
    const char *names[N_PLUGINS];
    bsdf_fn *read = NULL;
    for (size_t i = 0; i < N_PLUGINS; i++) {
        names[i] = plugins[i].type;
        if (strcmp(p.type, plugins[i].type) != 0) continue;
        read = plugins[i].read;
        if (!read) return fail_unsupported(r, node);
    }
    if (!read) return fail_unknown(r, node, "unknown bsdf", p.type, names, N_PLUGINS);
    TRY(read(&p, &f));
    TRY(props_finish(&p, &object));
    TRY(builder_add_bsdf(r->b, &object, &f, index, r->err));
done:
    return status;
}
