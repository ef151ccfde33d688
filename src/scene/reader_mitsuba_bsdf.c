/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/materials.h"
#include "scene/reader_mitsuba_bsdf.h"

/* specular_reflectance and specular_transmittance stay absent when they are: 1 for the light, but
 * the buffers tell the difference (the paper's albedo of glass without a colour is 0). */
static const struct vec3 black = {0, 0, 0}, tenth = {0.1f, 0.1f, 0.1f}, fifth = {0.2f, 0.2f, 0.2f},
                         half = {0.5f, 0.5f, 0.5f}, thirty = {30, 30, 30};

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
    if (!(*eta >= 1e-3f && *eta <= 1e3f))
        return fail_node(p->r, p->node, "int_ior / ext_ior must be from 0.001 to 1000");
done:
    return status;
}

static lmn_status read_roughness(struct props *p, struct bsdf *f)
{
    /* Mitsuba 0.x: "phong" and "as" take the exponent that looks like Beckmann's alpha. */
    static const char *const words[] = {"beckmann", "ggx", "phong", "as"};
    lmn_status status = LMN_OK;
    uint32_t distribution = MICROFACET_BECKMANN;
    bool sample_visible = true;
    TRY(props_choice(p, "distribution", words, 4, &distribution));
    if (distribution > MICROFACET_GGX) {
        note_ignored(p->r, p->node, "distribution phong (read as beckmann)");
        distribution = MICROFACET_BECKMANN;
    }
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
    if (p->node->is_legacy && !props_has(p, "eta") && !props_has(p, "k")) material = "Cu";
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

static lmn_status read_rough_plastic(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    TRY(read_plastic(p, f));
    f->kind = BSDF_ROUGH_PLASTIC;
    if (f->eta == 1.0f)
        return fail_node(p->r, p->node, "roughplastic needs int_ior different from ext_ior");
    TRY(read_roughness(p, f));
    if (f->alpha_u != f->alpha_v)
        return fail_node(p->r, p->node, "roughplastic has one \"alpha\" for all directions");
done:
    return status;
}

static lmn_status read_thin_dielectric(struct props *p, struct bsdf *f)
{
    lmn_status status = read_dielectric(p, f);
    f->kind = BSDF_THIN_DIELECTRIC;
    return status;
}

static lmn_status read_rough_diffuse(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = BSDF_ROUGH_DIFFUSE;
    TRY(props_texture(p,
                      props_has(p, "diffuse_reflectance") ? "diffuse_reflectance" : "reflectance",
                      &half, &f->reflectance));
    TRY(props_texture(p, "alpha", &fifth, &f->alpha_u));
    f->alpha_v = f->alpha_u;
    TRY(props_boolean(p, "use_fast_approx", &f->is_approximate));
done:
    return status;
}

static lmn_status read_phong(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    f->kind = strcmp(p->type, "phong") == 0 ? BSDF_PHONG : BSDF_BLINN_PHONG;
    TRY(props_texture(p, "exponent", &thirty, &f->exponent));
    TRY(props_texture(p, "diffuse_reflectance", &half, &f->reflectance));
    TRY(props_texture(p, "specular_reflectance", &fifth, &f->specular_reflectance));
done:
    return status;
}

/* Index of refraction of a principled material: itself, or by the reflectance it gives. */
static lmn_status read_specular(struct props *p, struct bsdf *f)
{
    lmn_status status = LMN_OK;
    float specular = 0.5f;
    if (props_has(p, "eta") && props_has(p, "specular"))
        return fail_node(p->r, p->node, "either \"eta\" or \"specular\"");
    if (props_has(p, "eta")) {
        TRY(props_positive(p, "eta", &f->eta));
        if (f->eta >= 1e-3f && f->eta <= 1e3f) return LMN_OK;
        return fail_node(p->r, p->node, "\"eta\" must be from 0.001 to 1000");
    }
    TRY(props_float(p, "specular", &specular));
    if (!(specular >= 0.0f && specular <= 1.0f))
        return fail_node(p->r, p->node, "\"specular\" must be from 0 to 1");
    f->eta = 2.0f / (1.0f - sqrtf(0.08f * specular)) - 1.0f;
done:
    return status;
}

static lmn_status read_principled(struct props *p, struct bsdf *f)
{
    static const char *const names[PRINCIPLED_SLOTS] = {
        [PRINCIPLED_ANISOTROPIC] = "anisotropic",
        [PRINCIPLED_METALLIC] = "metallic",
        [PRINCIPLED_SPEC_TRANS] = "spec_trans",
        [PRINCIPLED_SPEC_TINT] = "spec_tint",
        [PRINCIPLED_SHEEN] = "sheen",
        [PRINCIPLED_SHEEN_TINT] = "sheen_tint",
        [PRINCIPLED_FLATNESS] = "flatness",
        [PRINCIPLED_CLEARCOAT] = "clearcoat",
        [PRINCIPLED_CLEARCOAT_GLOSS] = "clearcoat_gloss",
    };
    lmn_status status = LMN_OK;
    f->kind = BSDF_PRINCIPLED;
    TRY(props_texture(p, "base_color", &half, &f->reflectance));
    TRY(props_texture(p, "roughness", &half, &f->alpha_u));
    f->alpha_v = f->alpha_u;
    for (int i = 0; i < PRINCIPLED_SLOTS; i++)
        TRY(props_texture(p, names[i], &black, &f->principled[i]));
    TRY(read_specular(p, f));
    /* No light would be refracted at all. */
    if (f->eta == 1.0f) f->eta = 1.001f;
    TRY(props_positive(p, "diffuse_reflectance_sampling_rate", &f->diffuse_rate));
    TRY(props_positive(p, "main_specular_sampling_rate", &f->specular_rate));
    TRY(props_positive(p, "clearcoat_sampling_rate", &f->clearcoat_rate));
done:
    return status;
}

static lmn_status read_null(struct props *p, struct bsdf *f)
{
    (void)p;
    f->kind = BSDF_NULL;
    return LMN_OK;
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
    {"roughplastic", read_rough_plastic},
    {"thindielectric", read_thin_dielectric},
    {"roughdiffuse", read_rough_diffuse},
    {"principled", read_principled},
    {"phong", read_phong},
    {"blinnphong", read_phong},
    {"null", read_null},
    {"twosided", read_twosided},
    {"mask", read_mask},
    {"blendbsdf", read_blend},
    {"mixturebsdf", read_mixture},
    {"bumpmap", read_bumpmap},
    {"normalmap", read_normalmap},
    {"principledthin", NULL},
    {"ward", NULL},
    {"coating", NULL},
    {"roughcoating", NULL},
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
    struct bsdf f = bsdf_blank(BSDF_DIFFUSE);
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
