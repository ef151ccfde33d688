/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "scene/mesh.h"
#include "scene/reader_mitsuba_private.h"

/* One function per texture; defaults are Mitsuba 3's. */
typedef lmn_status texture_fn(struct props *p, struct texture *t);

/* 0.x: u' = uscale (u + uoffset), as Mitsuba 3 reads it. */
static lmn_status read_old_uv(struct props *p, struct transform *m)
{
    lmn_status status = LMN_OK;
    float both = 1.0f, offset[2] = {0.0f, 0.0f}, scale[2];
    TRY(props_float(p, "uvscale", &both));
    scale[0] = scale[1] = both;
    TRY(props_float(p, "uscale", &scale[0]));
    TRY(props_float(p, "vscale", &scale[1]));
    TRY(props_float(p, "uoffset", &offset[0]));
    TRY(props_float(p, "voffset", &offset[1]));
    for (int i = 0; i < 2; i++) {
        m->m[i][i] = scale[i];
        m->m[i][3] = scale[i] * offset[i];
    }
done:
    return status;
}

static lmn_status read_to_uv(struct props *p, struct texture *t)
{
    lmn_status status = LMN_OK;
    struct transform m = transform_identity();
    if (p->node->is_legacy && !props_has(p, "to_uv")) TRY(read_old_uv(p, &m));
    TRY(props_transform(p, "to_uv", &m));
    for (int i = 0; i < 2; i++) {
        t->to_uv[i][0] = m.m[i][0];
        t->to_uv[i][1] = m.m[i][1];
        t->to_uv[i][2] = m.m[i][3];
    }
done:
    return status;
}

/* 0.x has a mode for each direction; one for both is what there is here. */
static lmn_status read_wrap(struct props *p, struct texture *t)
{
    static const char *const names[] = {"wrap_mode", "wrap_mode_u", "wrap_mode_v"};
    static const char *const wraps[] = {"repeat", "mirror", "clamp"};
    lmn_status status = LMN_OK;
    uint32_t wrap[3] = {TEXTURE_REPEAT, TEXTURE_REPEAT, TEXTURE_REPEAT};
    for (int i = 0; i < 3; i++) {
        if (i > 0) wrap[i] = wrap[0];
        if (i == 0 || p->node->is_legacy) TRY(props_choice(p, names[i], wraps, 3, &wrap[i]));
    }
    if (p->node->is_legacy && wrap[1] != wrap[2])
        return fail_node(p->r, p->node, "wrapModeU and wrapModeV that differ are not supported");
    t->wrap = (enum texture_wrap)(p->node->is_legacy ? wrap[1] : wrap[0]);
done:
    return status;
}

/* 0.x: the exponent of 8-bit files; 1 means that they are linear, -1 that they are sRGB. */
static lmn_status read_gamma(struct props *p, struct texture *t)
{
    float gamma = -1.0f;
    lmn_status status = props_float(p, "gamma", &gamma);
    if (status != LMN_OK) return status;
    if (gamma == 1.0f) t->is_raw = true;
    /* 2.2 is what people write for sRGB. */
    if (gamma != 1.0f && gamma != -1.0f && fabsf(gamma - 2.2f) > 0.01f)
        return fail_node(p->r, p->node, "bitmap: a gamma of %g is not supported", (double)gamma);
    return LMN_OK;
}

static lmn_status read_bitmap(struct props *p, struct texture *t)
{
    /* Mitsuba 3 has the first two; what 0.x has besides filters across texels of smaller versions
     * of the picture, which many samples per pixel do as well. */
    static const char *const filters[] = {"bilinear", "nearest", "trilinear", "ewa"};
    static const char *const ignored[] = {"max_anisotropy", "cache", "format", "accel"};
    lmn_status status = LMN_OK;
    const char *name = NULL, *path;
    uint32_t filter = 0;
    t->kind = TEXTURE_BITMAP;
    TRY(props_string(p, "filename", &name));
    if (!name) return fail_node(p->r, p->node, "bitmap needs a \"filename\"");
    TRY(props_choice(p, "filter_type", filters, 4, &filter));
    t->filter = filter == 1 ? TEXTURE_NEAREST : TEXTURE_BILINEAR;
    TRY(read_wrap(p, t));
    TRY(props_boolean(p, "raw", &t->is_raw));
    if (p->node->is_legacy) TRY(read_gamma(p, t));
    TRY(read_to_uv(p, t));
    for (size_t i = 0; i < sizeof ignored / sizeof *ignored; i++) props_ignore(p, ignored[i]);
    TRY(find_file(p->r, p->node, name, &path));
    TRY(builder_add_bitmap(p->r->b, path, p->node->place, &t->bitmap, p->r->err));
done:
    return status;
}

static lmn_status read_checkerboard(struct props *p, struct texture *t)
{
    lmn_status status = LMN_OK;
    t->kind = TEXTURE_CHECKERBOARD;
    t->color0 = vec3_splat(0.4f);
    t->color1 = vec3_splat(0.2f);
    TRY(props_colour(p, "color0", &t->color0));
    TRY(props_colour(p, "color1", &t->color1));
    TRY(read_to_uv(p, t));
done:
    return status;
}

/* Of 0.x: lines of color1 on color0. */
static lmn_status read_grid(struct props *p, struct texture *t)
{
    lmn_status status = LMN_OK;
    t->kind = TEXTURE_GRID;
    t->color0 = vec3_splat(0.2f);
    t->color1 = vec3_splat(0.4f);
    t->line_width = 0.01f;
    TRY(props_colour(p, "color0", &t->color0));
    TRY(props_colour(p, "color1", &t->color1));
    TRY(props_float(p, "line_width", &t->line_width));
    TRY(read_to_uv(p, t));
done:
    return status;
}

/* Numbers that the mesh brings. 0.x has only vertex colours, under a name of their own. */
static lmn_status read_mesh_attribute(struct props *p, struct texture *t)
{
    lmn_status status = LMN_OK;
    const char *name = strcmp(p->type, "vertexcolors") == 0 ? "vertex_color" : NULL;
    float scale = 1.0f;
    if (!name) TRY(props_string(p, "name", &name));
    if (!name) return fail_node(p->r, p->node, "mesh_attribute needs a \"name\"");
    if (!str_starts(name, "vertex_") && !str_starts(name, "face_"))
        return fail_node(p->r, p->node,
                         "the name of a mesh attribute begins with \"vertex_\" or \"face_\"");
    TRY(props_float(p, "scale", &scale));
    if (scale < 0.0f) return fail_node(p->r, p->node, "\"scale\" must not be negative");
    t->kind = TEXTURE_MESH_ATTRIBUTE;
    t->attribute = mesh_attribute_key(name);
    p->r->has_mesh_attributes = true;
    t->value = vec3_splat(scale);
done:
    return status;
}

/* Spectra as plugins: the same everywhere, and white where Mitsuba's RGB variants make them so. */
static lmn_status read_even(struct props *p, struct texture *t)
{
    lmn_status status = LMN_OK;
    bool is_d65 = strcmp(p->type, "d65") == 0, is_srgb = strcmp(p->type, "srgb") == 0;
    const char *name = is_d65 || is_srgb ? "color" : "value";
    float scale = 1.0f;
    t->kind = TEXTURE_CONSTANT;
    if (is_srgb && !props_has(p, name)) return fail_node(p->r, p->node, "srgb needs a \"color\"");
    TRY(props_colour(p, name, &t->value));
    if (is_d65) TRY(props_float(p, "scale", &scale));
    t->value = vec3_scale(t->value, scale);
    if (t->value.x < 0.0f || t->value.y < 0.0f || t->value.z < 0.0f)
        return fail_node(p->r, p->node, "%s must not be negative", p->type);
done:
    return status;
}

/* Of 0.x: another texture times a factor. It is a copy: what drives the other one does not change
 * this one. */
static lmn_status read_scale(struct props *p, struct texture *t)
{
    lmn_status status = LMN_OK;
    struct reader *r = p->r;
    struct xml_node *node;
    struct vec3 factor = vec3_splat(1.0f);
    struct vec3 value;
    TRY(props_colour(p, "scale", &factor));
    if (factor.x < 0.0f || factor.y < 0.0f || factor.z < 0.0f)
        return fail_node(r, p->node, "\"scale\" must not be negative");
    TRY(props_object(p, EL_TEXTURE, &node));
    if (node) {
        TRY(load_object(r, node));
        *t = r->b->textures[node->index].texture;
    } else {
        if (!props_has(p, "value"))
            return fail_node(r, p->node, "the texture \"scale\" needs another one in it");
        TRY(props_colour(p, "value", &value));
        t->kind = TEXTURE_CONSTANT;
        t->value = value;
    }
    t->value = vec3_mul(t->value, factor);
done:
    return status;
}

static const struct {
    const char *type;
    texture_fn *read; /* NULL: known, not supported yet */
} plugins[] = {
    {"uniform", read_even},     {"d65", read_even},      {"srgb", read_even},
    {"rawconstant", read_even}, {"bitmap", read_bitmap}, {"checkerboard", read_checkerboard},
    {"gridtexture", read_grid}, {"scale", read_scale},   {"mesh_attribute", read_mesh_attribute},
    {"volume", NULL},           {"wireframe", NULL},     {"vertexcolors", read_mesh_attribute},
};
enum { N_PLUGINS = sizeof plugins / sizeof *plugins };

lmn_status load_texture(struct reader *r, struct xml_node *node, uint32_t *index)
{
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_object object;
    struct texture t = {.value = {1, 1, 1}, .bitmap = SCENE_NONE};
    const char *names[N_PLUGINS];
    texture_fn *read = NULL;
    for (size_t i = 0; i < N_PLUGINS; i++) {
        names[i] = plugins[i].type;
        if (strcmp(p.type, plugins[i].type) != 0) continue;
        read = plugins[i].read;
        if (!read) return fail_unsupported(r, node);
    }
    if (!read) return fail_unknown(r, node, "unknown texture", p.type, names, N_PLUGINS);
    TRY(read(&p, &t));
    TRY(props_finish(&p, &object));
    TRY(builder_add_texture(r->b, &object, &t, index, r->err));
done:
    return status;
}
