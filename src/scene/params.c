/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/params.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/str.h"
#include "scene/params_private.h"

const char *param_type_name(enum param_type type)
{
    switch (type) {
    case PARAM_FLOAT:
        return "float";
    case PARAM_RGB:
        return "rgb";
    case PARAM_TRANSFORM:
        return "transform";
    case PARAM_TEXTURE:
        return "texture";
    case PARAM_BSDF:
        return "bsdf";
    case PARAM_BOOL:
        return "bool";
    }
    return "unknown";
}

/* ---- Walking the builder -------------------------------------------------------------------- */

const char *walk_path(struct walk *w, const char *format, ...)
{
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    int n = vsnprintf(NULL, 0, format, args);
    va_end(args);
    char *text = n < 0 ? NULL : arena_new(w->b->arena, (size_t)n + 1, 1);
    if (text) vsnprintf(text, (size_t)n + 1, format, again);
    va_end(again);
    if (!text) w->failed = true;
    return text;
}

static void add(struct walk *w, const char *path, struct target t)
{
    void *block = w->list->items;
    if (!path || !mem_grow(&block, &w->list->capacity, w->list->n + 1, sizeof t)) {
        w->failed = true;
        return;
    }
    w->list->items = block;
    t.path = path;
    w->list->items[w->list->n++] = t;
}

void walk_field(struct walk *w, const char *prefix, const char *name, enum builder_kind owner,
                uint32_t index, size_t offset, enum param_type type, double low, double high,
                bool is_alias)
{
    add(w, walk_path(w, "%s.%s", prefix, name),
        (struct target){.type = type,
                        .is_alias = is_alias,
                        .owner = owner,
                        .index = index,
                        .offset = (uint32_t)offset,
                        .part = PART_FIELD,
                        .low = low,
                        .high = high});
}

/* What is inside a texture, under `prefix`. */
static void walk_texture(struct walk *w, const char *prefix, uint32_t index, enum param_type type,
                         double low, double high, bool is_alias)
{
    const struct texture *t = &w->b->textures[index].texture;
    /* A factor on a picture may brighten it. */
    double factor_high = t->kind == TEXTURE_CONSTANT ? high : 1e6;
    walk_field(w, prefix, "value", BUILDER_TEXTURE, index, offsetof(struct texture, value), type,
               low, factor_high, is_alias);
    if (t->kind != TEXTURE_CHECKERBOARD && t->kind != TEXTURE_GRID) return;
    static const char *const names[2] = {"color0", "color1"};
    const size_t offsets[2] = {offsetof(struct texture, color0), offsetof(struct texture, color1)};
    for (int i = 0; i < 2; i++) {
        const char *color = walk_path(w, "%s.%s", prefix, names[i]);
        if (!color) return;
        walk_field(w, color, "value", BUILDER_TEXTURE, index, offsets[i], type, low, high,
                   is_alias);
        walk_field(w, prefix, names[i], BUILDER_TEXTURE, index, offsets[i], type, low, high, true);
    }
}

void walk_slot(struct walk *w, const char *prefix, const char *name, enum builder_kind owner,
               uint32_t index, size_t offset, uint32_t texture, enum param_type type, double low,
               double high, bool is_alias)
{
    if (texture >= w->b->n_textures) return;
    walk_field(w, prefix, name, owner, index, offset, PARAM_TEXTURE, 0, 0, is_alias);
    const char *path = walk_path(w, "%s.%s", prefix, name);
    bool has_own_path = w->b->textures[texture].object.id != NULL;
    if (path) walk_texture(w, path, texture, type, low, high, is_alias || has_own_path);
}

const char *emitter_radiance_name(enum emitter_kind kind)
{
    if (kind == EMITTER_POINT || kind == EMITTER_SPOT) return "intensity";
    if (kind == EMITTER_DIRECTIONAL || kind == EMITTER_PROJECTOR) return "irradiance";
    return "radiance";
}

static void walk_emitter(struct walk *w, const char *prefix, uint32_t index, bool is_alias)
{
    static const struct {
        const char *name;
        size_t offset;
        double low, high;
        enum emitter_kind kind;
    } numbers[] = {
        {"cutoff_angle", offsetof(struct emitter, cutoff), 0.01, 179.9, EMITTER_SPOT},
        {"beam_width", offsetof(struct emitter, beam_width), 0, 179.9, EMITTER_SPOT},
        {"fov", offsetof(struct emitter, fov), 0.01, 179.9, EMITTER_PROJECTOR},
        {"turbidity", offsetof(struct emitter, turbidity), 1, 10, EMITTER_SKY},
        {"sun_elevation", offsetof(struct emitter, sun_elevation), -90, 90, EMITTER_SKY},
        {"sun_azimuth", offsetof(struct emitter, sun_azimuth), -1e4, 1e4, EMITTER_SKY},
        {"sky_scale", offsetof(struct emitter, sky_scale), 0, 1e12, EMITTER_SKY},
        {"sun_scale", offsetof(struct emitter, sun_scale), 0, 1e12, EMITTER_SKY},
        {"sun_aperture", offsetof(struct emitter, sun_aperture), 1e-3, 179.9, EMITTER_SKY},
    };
    if (!prefix || index >= w->b->n_emitters) return;
    const struct emitter *e = &w->b->emitters[index].emitter;
    if (w->is_emitter_named[index]) is_alias = true;
    w->is_emitter_named[index] = true;
    walk_slot(w, prefix, emitter_radiance_name(e->kind), BUILDER_EMITTER, index,
              offsetof(struct emitter, radiance), e->radiance, PARAM_RGB, 0, 1e12, is_alias);
    walk_slot(w, prefix, "texture", BUILDER_EMITTER, index, offsetof(struct emitter, picture),
              e->picture, PARAM_RGB, 0, 1e12, is_alias);
    walk_field(w, prefix, "scale", BUILDER_EMITTER, index, offsetof(struct emitter, scale),
               PARAM_FLOAT, 0, 1e12, is_alias);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        if (numbers[i].kind != e->kind) continue;
        walk_field(w, prefix, numbers[i].name, BUILDER_EMITTER, index, numbers[i].offset,
                   PARAM_FLOAT, numbers[i].low, numbers[i].high, is_alias);
    }
    if (e->kind != EMITTER_CONSTANT && !emitter_is_surface(e->kind))
        walk_field(w, prefix, "to_world", BUILDER_EMITTER, index,
                   offsetof(struct emitter, to_world), PARAM_TRANSFORM, 0, 0, is_alias);
}

static void walk_part(struct walk *w, const char *prefix, const char *name, enum builder_kind owner,
                      uint32_t index, enum target_part part, enum param_type type)
{
    add(w, walk_path(w, "%s.%s", prefix, name),
        (struct target){.type = type, .owner = owner, .index = index, .part = part});
}

static void walk_shape(struct walk *w, uint32_t index)
{
    const struct builder_shape *s = &w->b->shapes[index];
    walk_part(w, s->name, "to_world", BUILDER_SHAPE, index, PART_TO_WORLD, PARAM_TRANSFORM);
    walk_part(w, s->name, "visible", BUILDER_SHAPE, index, PART_VISIBLE, PARAM_BOOL);
    if (s->bsdf < w->b->n_bsdfs) {
        walk_part(w, s->name, "bsdf", BUILDER_SHAPE, index, PART_BSDF, PARAM_BSDF);
        bool has_own_path = w->b->bsdfs[s->bsdf].object.id != NULL;
        walk_bsdf(w, walk_path(w, "%s.bsdf", s->name), s->bsdf, has_own_path, false, 0);
    }
    if (s->emitter < w->b->n_emitters)
        walk_emitter(w, walk_path(w, "%s.emitter", s->name), s->emitter, false);
}

static void walk_sensor(struct walk *w, const char *prefix, bool is_alias)
{
    enum { PINHOLE = 1 << SENSOR_PERSPECTIVE, LENS = 1 << SENSOR_THINLENS };
    enum { FLAT = 1 << SENSOR_ORTHOGRAPHIC, ALL = PINHOLE | LENS | FLAT };
    static const struct {
        const char *name;
        size_t offset;
        double low, high;
        int kinds;
    } fields[] = {
        {"fov", offsetof(struct sensor, fov), 0.01, 179.9, PINHOLE | LENS},
        {"near_clip", offsetof(struct sensor, near_clip), 1e-9, SENSOR_MAX_NEAR, ALL},
        {"far_clip", offsetof(struct sensor, far_clip), 1e-9, 1e30, ALL},
        {"aperture_radius", offsetof(struct sensor, aperture_radius), 0, SENSOR_MAX_APERTURE, LENS},
        {"focus_distance", offsetof(struct sensor, focus_distance), SENSOR_MIN_FOCUS,
         SENSOR_MAX_FOCUS, LENS},
        {"principal_point_offset_x", offsetof(struct sensor, shift_x), -SENSOR_MAX_SHIFT,
         SENSOR_MAX_SHIFT, PINHOLE | LENS},
        {"principal_point_offset_y", offsetof(struct sensor, shift_y), -SENSOR_MAX_SHIFT,
         SENSOR_MAX_SHIFT, PINHOLE | LENS},
        {"scale_x", offsetof(struct sensor, scale_x), 1e-9, 1e12, FLAT},
        {"scale_y", offsetof(struct sensor, scale_y), 1e-9, 1e12, FLAT},
    };
    const struct sensor *s = &w->b->sensor;
    walk_field(w, prefix, "to_world", BUILDER_SENSOR, 0, offsetof(struct sensor, to_world),
               PARAM_TRANSFORM, 0, 0, is_alias);
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
        if (!(fields[i].kinds & 1 << s->kind)) continue;
        walk_field(w, prefix, fields[i].name, BUILDER_SENSOR, 0, fields[i].offset, PARAM_FLOAT,
                   fields[i].low, fields[i].high, is_alias);
    }
    if (s->kind != SENSOR_ORTHOGRAPHIC && s->fov_axis == FOV_X)
        walk_field(w, prefix, "x_fov", BUILDER_SENSOR, 0, offsetof(struct sensor, fov), PARAM_FLOAT,
                   0.01, 179.9, true);
}

static void walk_objects(struct walk *w)
{
    const struct builder *b = w->b;
    const char *sensor = b->sensor_object.id;
    walk_sensor(w, sensor ? sensor : "sensor", false);
    if (sensor && strcmp(sensor, "sensor") != 0) walk_sensor(w, "sensor", true);

    for (uint32_t i = 0; i < b->n_textures; i++)
        if (b->textures[i].object.id)
            walk_texture(w, b->textures[i].object.id, i, PARAM_RGB, 0, 1, false);
    for (uint32_t i = 0; i < b->n_bsdfs; i++)
        if (b->bsdfs[i].object.id) walk_bsdf(w, b->bsdfs[i].object.id, i, false, false, 0);
    for (uint32_t i = 0; i < b->n_emitters; i++)
        if (b->emitters[i].object.id) walk_emitter(w, b->emitters[i].object.id, i, false);
    for (uint32_t i = 0; i < b->n_shapes; i++) walk_shape(w, i);
    for (uint32_t i = 0; i < b->n_instances; i++) {
        const char *name = b->instances[i].name;
        walk_part(w, name, "to_world", BUILDER_INSTANCE, i, PART_TO_WORLD, PARAM_TRANSFORM);
        walk_part(w, name, "visible", BUILDER_INSTANCE, i, PART_VISIBLE, PARAM_BOOL);
    }

    uint32_t counts[EMITTER_KINDS] = {0}; /* emitters of the scene that have no id, by kind */
    for (uint32_t i = 0; i < b->n_emitters; i++) {
        static const char *const names[EMITTER_KINDS] = {
            "area",        "constant",  "envmap",          "point",  "spot",
            "directional", "projector", "directionalarea", "sunsky", "sun"};
        if (w->is_emitter_named[i]) continue;
        enum emitter_kind kind = b->emitters[i].emitter.kind;
        const char *name;
        enum builder_kind taken;
        uint32_t index;
        do {
            uint32_t n = ++counts[kind];
            name = n == 1 ? names[kind] : walk_path(w, "%s_%u", names[kind], n);
        } while (name && builder_find(b, name, &taken, &index));
        walk_emitter(w, name, i, false);
    }
}

const char *target_name(const struct builder *b, const char *id)
{
    enum builder_kind kind;
    uint32_t index;
    if (!str_starts(id, "var_") || !id[4]) return id;
    bool is_taken = builder_find(b, id + 4, &kind, &index);
    if (is_taken && kind == BUILDER_SENSOR && b->sensor_object.id)
        is_taken = strcmp(b->sensor_object.id, id) != 0; /* "sensor" is its name anyway */
    return is_taken ? id : id + 4;
}

/* Objects "var_door" of the authors' scenes are called "door" where nothing else is; either name
 * will do. */
static void add_short_names(struct walk *w)
{
    size_t n = w->list->n;
    for (size_t i = 0; i < n && !w->failed; i++) {
        struct target t = w->list->items[i];
        const char *end = strchr(t.path, '.');
        if (!str_starts(t.path, "var_") || !end) continue;
        const char *id = walk_path(w, "%.*s", (int)(end - t.path), t.path);
        if (!id || target_name(w->b, id) == id) continue;
        w->list->items[i].path = t.path + 4;
        t.is_alias = true;
        add(w, t.path, t);
    }
}

lmn_status target_list_init(struct target_list *list, const struct builder *b, struct error *err)
{
    *list = (struct target_list){0};
    struct walk w = {.b = b, .list = list};
    w.is_bsdf_named = mem_new(b->n_bsdfs, sizeof *w.is_bsdf_named);
    w.is_emitter_named = mem_new(b->n_emitters, sizeof *w.is_emitter_named);
    w.failed = !w.is_bsdf_named || !w.is_emitter_named;
    if (!w.failed) walk_objects(&w);
    if (!w.failed) add_short_names(&w);
    mem_free(w.is_bsdf_named);
    mem_free(w.is_emitter_named);
    if (!w.failed) return LMN_OK;
    target_list_release(list);
    return fail_memory(err, "the list of parameters");
}

void target_list_release(struct target_list *list)
{
    mem_free(list->items);
    *list = (struct target_list){0};
}

/* ---- Looking up ----------------------------------------------------------------------------- */

/* `path` is `head`, `middle` and `tail` one after the other. */
static bool is_joined(const char *path, const char *head, const char *middle, const char *tail)
{
    size_t n = strlen(head), m = strlen(middle);
    return strncmp(path, head, n) == 0 && strncmp(path + n, middle, m) == 0 &&
           strcmp(path + n + m, tail) == 0;
}

/* The first match wins, and what is no alias before any alias. */
static const struct target *find_exactly(const struct target_list *list, const char *head,
                                         const char *middle, const char *tail)
{
    const struct target *alias = NULL;
    for (size_t i = 0; i < list->n; i++) {
        const struct target *t = &list->items[i];
        if (!is_joined(t->path, head, middle, tail)) continue;
        if (!t->is_alias) return t;
        if (!alias) alias = t;
    }
    return alias;
}

const struct target *target_find(const struct target_list *list, const char *path,
                                 const char *suffix, enum param_type wanted)
{
    const struct target *t = find_exactly(list, path, suffix, "");
    if (t && (t->type == wanted || t->type != PARAM_TEXTURE)) return t;
    const struct target *value = find_exactly(list, path, suffix, ".value");
    return value ? value : t;
}

const char *target_closest(const struct target_list *list, const char *word)
{
    const char **paths = mem_new(list->n, sizeof *paths);
    if (!paths) return NULL;
    for (size_t i = 0; i < list->n; i++) paths[i] = list->items[i].path;
    const char *closest = str_closest(word, paths, list->n);
    mem_free(paths);
    return closest;
}

void *target_in(const struct target *t, const struct builder *b)
{
    char *element = NULL;
    switch (t->owner) {
    case BUILDER_TEXTURE:
        element = (char *)&b->textures[t->index].texture;
        break;
    case BUILDER_BSDF:
        element = (char *)&b->bsdfs[t->index].bsdf;
        break;
    case BUILDER_EMITTER:
        element = (char *)&b->emitters[t->index].emitter;
        break;
    case BUILDER_SENSOR:
        element = (char *)&b->sensor;
        break;
    case BUILDER_SHAPE:
        if (t->part == PART_TO_WORLD) return &b->shapes[t->index].to_world;
        return t->part == PART_BSDF ? &b->shapes[t->index].bsdf : NULL;
    case BUILDER_INSTANCE:
        return t->part == PART_TO_WORLD ? &b->instances[t->index].to_world : NULL;
    case BUILDER_GROUP:
        return NULL;
    }
    return element + t->offset;
}

void target_lower(const struct target *t, const struct builder *b, struct param *out)
{
    *out = (struct param){.path = t->path, .type = t->type, .index = t->index, .offset = t->offset};
    switch (t->owner) {
    case BUILDER_TEXTURE:
        out->array = STATE_TEXTURES;
        return;
    case BUILDER_BSDF:
        out->array = STATE_BSDFS;
        return;
    case BUILDER_EMITTER:
        out->array = STATE_EMITTERS;
        return;
    case BUILDER_SENSOR:
        out->array = STATE_SENSOR;
        return;
    case BUILDER_GROUP:
        break;
    case BUILDER_SHAPE:
        if (t->part == PART_BSDF) {
            out->array = STATE_SHAPE_BSDFS;
            out->index = b->shapes[t->index].final_shape;
            return;
        } /* fall through */
    case BUILDER_INSTANCE:
        for (uint32_t i = 0; i < b->scene->n_instances; i++) {
            const struct builder_placement *p = &b->placements[i];
            if (t->index != (t->owner == BUILDER_SHAPE ? p->shape : p->instance)) continue;
            out->array = STATE_INSTANCES;
            out->index = i;
            out->offset = t->part == PART_VISIBLE ? offsetof(struct instance, is_visible)
                                                  : offsetof(struct instance, to_world);
            return;
        }
    }
    out->array = STATE_NOWHERE;
    out->index = out->offset = 0;
}

/* ---- Texts ---------------------------------------------------------------------------------- */

/* Six digits: what is put through u and back differs from what was written in the seventh. */
static void add_number(struct str *out, double value)
{
    str_add(out, "%s%g", out->length ? " " : "", value);
}

static void add_transform(struct str *out, const struct transform *t)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) add_number(out, (double)t->m[i][j]);
}

static void add_object_name(struct str *out, const struct builder_object *o, const char *kind)
{
    str_add(out, "%s", o->id ? o->id : kind);
}

static void add_value(struct str *out, const struct builder *b, const struct target *t,
                      const struct param *p, struct scene_state *state)
{
    static const char *const textures[] = {"constant", "bitmap", "checkerboard", "gridtexture",
                                           "mesh_attribute"};
    /* What no variable moves is in the vertices; what one moves has it there too, below the
     * instance: the declared transform is what a reader of the scene file expects. */
    if (t->owner == BUILDER_SHAPE && t->part == PART_TO_WORLD) {
        add_transform(out, &b->shapes[t->index].to_world);
        return;
    }
    const void *value = param_in(p, state);
    if (!value) {
        if (t->type == PARAM_BOOL) str_add(out, "true");
        if (t->type == PARAM_TRANSFORM) add_transform(out, target_in(t, b));
        return;
    }
    uint32_t index;
    float rgb[3];
    switch (t->type) {
    case PARAM_FLOAT:
        memcpy(rgb, value, sizeof *rgb);
        add_number(out, (double)rgb[0]);
        break;
    case PARAM_RGB:
        memcpy(rgb, value, sizeof rgb);
        for (int i = 0; i < 3; i++) add_number(out, (double)rgb[i]);
        break;
    case PARAM_TRANSFORM:
        add_transform(out, value);
        break;
    case PARAM_BOOL:
        str_add(out, *(const bool *)value ? "true" : "false");
        break;
    case PARAM_TEXTURE:
        memcpy(&index, value, sizeof index);
        if (index < b->n_textures)
            add_object_name(out, &b->textures[index].object,
                            textures[b->textures[index].texture.kind]);
        break;
    case PARAM_BSDF:
        memcpy(&index, value, sizeof index);
        if (index < b->n_bsdfs)
            add_object_name(out, &b->bsdfs[index].object,
                            bsdf_kind_name(b->bsdfs[index].bsdf.kind));
        break;
    }
}

lmn_status params_resolve(const struct builder *b, struct scene *s, struct error *err)
{
    struct target_list list = {0};
    struct str text = {0};
    lmn_status status = LMN_OK;
    TRY(target_list_init(&list, b, err));
    uint32_t n = 0;
    for (size_t i = 0; i < list.n; i++) n += !list.items[i].is_alias;
    s->params = arena_new(&s->arena, n, sizeof *s->params);
    if (!s->params) {
        status = fail_memory(err, "the parameters");
        goto done;
    }
    for (size_t i = 0; i < list.n; i++) {
        const struct target *t = &list.items[i];
        if (t->is_alias) continue;
        struct param *p = &s->params[s->n_params];
        target_lower(t, b, p);
        text.length = 0;
        add_value(&text, b, t, p, &s->defaults);
        p->value = text.failed ? NULL : arena_strdup(&s->arena, text.length ? text.text : "");
        if (!p->value) {
            status = fail_memory(err, "the parameters");
            goto done;
        }
        s->n_params++;
    }
done:
    str_release(&text);
    target_list_release(&list);
    return status;
}
