/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "scene/light_groups.h"
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

static lmn_status read_directional_area(struct props *p, struct emitter *e)
{
    lmn_status status = read_area(p, e);
    e->kind = EMITTER_DIRECTIONAL_AREA;
    return status;
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

/* `to_world`, or `name` (a point or a direction) instead of it. */
static lmn_status read_placement(struct props *p, const char *name, struct emitter *e, bool *is_xyz,
                                 struct vec3 *xyz)
{
    lmn_status status = LMN_OK;
    TRY(props_transform(p, "to_world", &e->to_world));
    *is_xyz = props_has(p, name);
    if (!*is_xyz) goto done;
    if (props_has(p, "to_world"))
        return fail_node(p->r, p->node, "either \"%s\" or \"to_world\"", name);
    TRY(props_point(p, name, xyz));
done:
    return status;
}

static lmn_status read_point(struct props *p, struct emitter *e)
{
    lmn_status status = LMN_OK;
    struct vec3 position;
    bool is_given;
    e->kind = EMITTER_POINT;
    TRY(read_placement(p, "position", e, &is_given, &position));
    if (is_given) e->to_world = transform_translate(position);
    TRY(props_radiance(p, "intensity", &e->radiance));
done:
    return status;
}

static lmn_status read_spot(struct props *p, struct emitter *e)
{
    lmn_status status = LMN_OK;
    e->kind = EMITTER_SPOT;
    e->cutoff = 20.0f;
    TRY(props_transform(p, "to_world", &e->to_world));
    TRY(props_radiance(p, "intensity", &e->radiance));
    TRY(props_positive(p, "cutoff_angle", &e->cutoff));
    e->beam_width = 0.75f * e->cutoff;
    TRY(props_float(p, "beam_width", &e->beam_width));
    if (e->cutoff >= 180.0f)
        return fail_node(p->r, p->node, "\"cutoff_angle\" must be below 180 degrees");
    if (!(e->beam_width >= 0.0f && e->beam_width <= e->cutoff))
        return fail_node(p->r, p->node, "\"beam_width\" must be between 0 and \"cutoff_angle\"");
    if (!props_has(p, "texture")) goto done;
    if (e->cutoff >= 90.0f)
        return fail_node(p->r, p->node, "a \"texture\" needs a \"cutoff_angle\" below 90 degrees");
    TRY(props_texture(p, "texture", NULL, &e->picture));
done:
    return status;
}

static lmn_status read_directional(struct props *p, struct emitter *e)
{
    lmn_status status = LMN_OK;
    struct vec3 d;
    bool is_given;
    e->kind = EMITTER_DIRECTIONAL;
    TRY(read_placement(p, "direction", e, &is_given, &d));
    if (is_given) {
        float length = vec3_length(d);
        if (!(length > 0.0f) || !isfinite(length))
            return fail_node(p->r, p->node, "\"direction\" has no length");
        d = vec3_scale(d, 1.0f / length);
        e->to_world = transform_look_at(vec3(0, 0, 0), d, frame_from_normal(d).s);
    }
    TRY(props_radiance(p, "irradiance", &e->radiance));
done:
    return status;
}

static lmn_status read_projector(struct props *p, struct emitter *e)
{
    lmn_status status = LMN_OK;
    e->kind = EMITTER_PROJECTOR;
    TRY(props_transform(p, "to_world", &e->to_world));
    TRY(props_float(p, "scale", &e->scale));
    TRY(read_fov(p, &e->fov, &e->fov_axis));
    TRY(props_radiance(p, "irradiance", &e->radiance));
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
    {"spot", read_spot},
    {"directional", read_directional},
    {"directionalarea", read_directional_area},
    {"projector", read_projector},
    {"sun", read_sky},
    {"sky", read_sky},
    {"sunsky", read_sky},
    {"timed_sunsky", NULL},
    {"collimated", NULL},
};
enum { N_PLUGINS = sizeof plugins / sizeof *plugins };

/* Ours, not Mitsuba's: emitters of one name share a picture of their light. */
static lmn_status read_light_group(struct props *p, const char **out)
{
    const char *name = NULL;
    lmn_status status = props_string(p, "light_group", &name);
    if (status != LMN_OK || !name) return status;
    size_t n = strlen(name);
    if (n == 0 || n > LIGHT_GROUP_NAME)
        return fail_node(p->r, p->node, "\"light_group\" has 1 to %d characters",
                         (int)LIGHT_GROUP_NAME);
    *out = arena_strdup(p->r->b->arena, name);
    return *out ? LMN_OK : fail_memory(p->r->err, "the scene");
}

lmn_status load_emitter(struct reader *r, struct xml_node *node, uint32_t *index)
{
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_object object;
    struct emitter e = {.radiance = SCENE_NONE,
                        .scale = 1.0f,
                        .bitmap = SCENE_NONE,
                        .picture = SCENE_NONE,
                        .to_world = transform_identity()};
    const char *names[N_PLUGINS], *light_group = NULL;
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
    TRY(read_light_group(&p, &light_group));
    TRY(props_finish(&p, &object));
    bool has_place = emitter_is_surface(e.kind) || e.kind == EMITTER_PROJECTOR;
    if (!has_place && e.radiance != SCENE_NONE &&
        r->b->textures[e.radiance].texture.kind != TEXTURE_CONSTANT)
        return fail_node(r, node, "<emitter type=\"%s\">: it takes a colour, not a texture",
                         p.type);
    TRY(builder_add_emitter(r->b, &object, &e, light_group, index, r->err));
done:
    return status;
}
