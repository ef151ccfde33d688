/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "scene/reader_mitsuba_private.h"

/* One function per emitter; defaults are Mitsuba 3's. */
typedef lmn_status emitter_fn(struct props *p, struct emitter *e);

static lmn_status read_area(struct props *p, struct emitter *e)
{
    e->kind = EMITTER_AREA;
    if (props_has(p, "to_world"))
        return fail_node(p->r, p->node, "an area emitter has no \"to_world\": its shape has");
    return props_radiance(p, "radiance", &e->radiance);
}

static lmn_status read_constant(struct props *p, struct emitter *e)
{
    e->kind = EMITTER_CONSTANT;
    return props_radiance(p, "radiance", &e->radiance);
}

static lmn_status read_envmap(struct props *p, struct emitter *e)
{
    lmn_status status = LMN_OK;
    const char *name = NULL, *path;
    e->kind = EMITTER_ENVMAP;
    TRY(props_string(p, "filename", &name));
    if (!name) return fail_node(p->r, p->node, "envmap needs a \"filename\"");
    TRY(props_float(p, "scale", &e->scale));
    TRY(props_transform(p, "to_world", &e->to_world));
    TRY(find_file(p->r, p->node, name, &path));
    TRY(builder_add_bitmap(p->r->b, path, p->node->place, &e->bitmap, p->r->err));
done:
    return status;
}

static lmn_status read_point(struct props *p, struct emitter *e)
{
    lmn_status status = LMN_OK;
    struct vec3 position;
    e->kind = EMITTER_POINT;
    TRY(props_transform(p, "to_world", &e->to_world));
    if (props_has(p, "position")) {
        if (props_has(p, "to_world"))
            return fail_node(p->r, p->node, "either \"position\" or \"to_world\"");
        TRY(props_point(p, "position", &position));
        e->to_world = transform_translate(position);
    }
    TRY(props_radiance(p, "intensity", &e->radiance));
done:
    return status;
}

static const struct {
    const char *type;
    emitter_fn *read; /* NULL: known, not supported yet */
} plugins[] = {
    {"area", read_area},
    {"constant", read_constant},
    {"envmap", read_envmap},
    {"point", read_point},
    {"spot", NULL},
    {"directional", NULL},
    {"directionalarea", NULL},
    {"projector", NULL},
    {"sun", NULL},
    {"sky", NULL},
    {"sunsky", NULL},
    {"timed_sunsky", NULL},
    {"collimated", NULL},
};
enum { N_PLUGINS = sizeof plugins / sizeof *plugins };

lmn_status load_emitter(struct reader *r, struct xml_node *node, uint32_t *index)
{
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_object object;
    struct emitter e = {.radiance = SCENE_NONE,
                        .scale = 1.0f,
                        .bitmap = SCENE_NONE,
                        .to_world = transform_identity()};
    const char *names[N_PLUGINS];
    emitter_fn *read = NULL;
    for (size_t i = 0; i < N_PLUGINS; i++) {
        names[i] = plugins[i].type;
        if (strcmp(p.type, plugins[i].type) != 0) continue;
        read = plugins[i].read;
        if (!read) return fail_unsupported(r, node);
    }
    if (!read) return fail_unknown(r, node, "unknown emitter", p.type, names, N_PLUGINS);
    TRY(read(&p, &e));
    props_ignore(&p, "sampling_weight");
    TRY(props_finish(&p, &object));
    if (e.kind != EMITTER_AREA && e.radiance != SCENE_NONE &&
        r->b->textures[e.radiance].texture.kind != TEXTURE_CONSTANT)
        return fail_node(r, node, "<emitter type=\"%s\">: it takes a colour, not a texture",
                         p.type);
    TRY(builder_add_emitter(r->b, &object, &e, index, r->err));
done:
    return status;
}
