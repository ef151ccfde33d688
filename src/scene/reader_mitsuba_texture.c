/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "scene/reader_mitsuba_private.h"

/* One function per texture; defaults are Mitsuba 3's. */
typedef lmn_status texture_fn(struct props *p, struct texture *t);

static lmn_status read_to_uv(struct props *p, struct texture *t)
{
    struct transform m = transform_identity();
    lmn_status status = props_transform(p, "to_uv", &m);
    for (int i = 0; i < 2; i++) {
        t->to_uv[i][0] = m.m[i][0];
        t->to_uv[i][1] = m.m[i][1];
        t->to_uv[i][2] = m.m[i][3];
    }
    return status;
}

static lmn_status read_bitmap(struct props *p, struct texture *t)
{
    static const char *const filters[] = {"bilinear", "nearest"};
    static const char *const wraps[] = {"repeat", "mirror", "clamp"};
    lmn_status status = LMN_OK;
    const char *name = NULL, *path;
    uint32_t filter = TEXTURE_BILINEAR, wrap = TEXTURE_REPEAT;
    t->kind = TEXTURE_BITMAP;
    TRY(props_string(p, "filename", &name));
    if (!name) return fail_node(p->r, p->node, "bitmap needs a \"filename\"");
    TRY(props_choice(p, "filter_type", filters, 2, &filter));
    TRY(props_choice(p, "wrap_mode", wraps, 3, &wrap));
    TRY(props_boolean(p, "raw", &t->is_raw));
    TRY(read_to_uv(p, t));
    t->filter = (enum texture_filter)filter;
    t->wrap = (enum texture_wrap)wrap;
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

static const struct {
    const char *type;
    texture_fn *read; /* NULL: known, not supported yet */
} plugins[] = {
    {"bitmap", read_bitmap},  {"checkerboard", read_checkerboard},
    {"gridtexture", NULL},    {"scale", NULL},
    {"mesh_attribute", NULL}, {"volume", NULL},
    {"wireframe", NULL},      {"vertexcolors", NULL},
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
