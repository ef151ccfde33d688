/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/builder.h"

#include <stdio.h>
#include <string.h>

#include "base/hash.h"
#include "base/rng.h"
#include "base/str.h"
#include "scene/builder_private.h"

lmn_status fail_at(struct error *err, struct place place, const char *format, ...)
{
    if (!err) return LMN_ERR_PARSE;
    int n = place.line ? snprintf(err->text, sizeof err->text, "%s:%u:%u: ", place.file, place.line,
                                  place.column)
                       : snprintf(err->text, sizeof err->text, "%s: ", place.file);
    if (n < 0 || (size_t)n >= sizeof err->text) return LMN_ERR_PARSE;
    va_list args;
    va_start(args, format);
    vsnprintf(err->text + n, sizeof err->text - (size_t)n, format, args);
    va_end(args);
    return LMN_ERR_PARSE;
}

/* ---- Life --------------------------------------------------------------------------------- */

lmn_status builder_new(const char *path, struct builder **out, struct error *err)
{
    struct builder *b = mem_new(1, sizeof *b);
    if (!b) return fail_memory(err, path);
    b->private = mem_new(1, sizeof *b->private);
    if (b->private) b->private->owns_scene = true;
    b->scene = mem_new(1, sizeof *b->scene);
    b->arena = b->scene ? &b->scene->arena : NULL;
    b->path = b->arena ? arena_strdup(b->arena, path) : NULL;
    if (!b->private || !b->path) {
        builder_free(b);
        return fail_memory(err, path);
    }
    b->scene->path = b->path;
    b->hash = HASH_START;
    b->sensor.to_world = transform_identity();
    b->settings = (struct render_settings){.width = 768,
                                           .height = 576,
                                           .spp = 4,
                                           .max_depth = -1,
                                           .rr_depth = 5,
                                           .filter = FILTER_GAUSSIAN,
                                           .filter_radius = 2.0f,
                                           .filter_stddev = 0.5f};
    *out = b;
    return LMN_OK;
}

void builder_free(struct builder *b)
{
    if (!b) return;
    struct builder_private *p = b->private;
    if (p && p->owns_scene) {
        for (size_t i = 0; i < b->n_bitmaps; i++) bitmap_release(&b->bitmaps[i]);
    }
    if (!p || p->owns_scene) {
        if (b->scene) arena_release(&b->scene->arena);
        mem_free(b->scene);
    }
    mem_free(b->textures);
    mem_free(b->bsdfs);
    mem_free(b->emitters);
    mem_free(b->shapes);
    mem_free(b->groups);
    mem_free(b->instances);
    mem_free(b->meshes);
    mem_free(b->bitmaps);
    mem_free(b->placements);
    if (p) {
        mem_free(p->names);
        mem_free(p->bitmap_paths);
    }
    mem_free(p);
    mem_free(b);
}

void builder_hash(struct builder *b, const void *bytes, size_t size)
{
    /* Four lanes of eight-byte words through a bijective mixer: a file costs next to nothing. */
    const unsigned char *p = bytes;
    uint64_t lanes[4];
    for (uint64_t i = 0; i < 4; i++) lanes[i] = rng_mix(b->hash ^ size) + i;
    for (; size >= 32; size -= 32, p += 32) {
        uint64_t words[4];
        memcpy(words, p, 32);
        for (int i = 0; i < 4; i++) lanes[i] = rng_mix(lanes[i] ^ words[i]);
    }
    uint64_t h = hash_bytes(HASH_START, p, size);
    for (int i = 0; i < 4; i++) h = rng_mix(h ^ lanes[i]);
    b->hash = h;
}

/* ---- Names -------------------------------------------------------------------------------- */

static size_t find_slot(const struct builder_private *p, const char *name)
{
    size_t mask = p->names_capacity - 1;
    size_t i = (size_t)rng_mix(hash_bytes(HASH_START, name, strlen(name))) & mask;
    while (p->names[i].name && strcmp(p->names[i].name, name) != 0) i = (i + 1) & mask;
    return i;
}

static bool grow_names(struct builder_private *p)
{
    if (2 * (p->n_names + 1) <= p->names_capacity) return true;
    size_t capacity = p->names_capacity ? 2 * p->names_capacity : 64;
    struct name_entry *old = p->names, *fresh = mem_new(capacity, sizeof *fresh);
    if (!fresh) return false;
    size_t n = p->names_capacity;
    p->names = fresh;
    p->names_capacity = capacity;
    for (size_t i = 0; i < n; i++) {
        if (old[i].name) fresh[find_slot(p, old[i].name)] = old[i];
    }
    mem_free(old);
    return true;
}

static const char *kind_name(enum builder_kind kind)
{
    static const char *const names[] = {"texture",    "bsdf",     "emitter", "shape",
                                        "shapegroup", "instance", "sensor"};
    return names[kind];
}

/* A name nobody has: the stem, else stem_2, stem_3, ... */
static const char *make_up_name(struct builder *b, const char *stem)
{
    struct builder_private *p = b->private;
    if (!p->names[find_slot(p, stem)].name) return arena_strdup(b->arena, stem);
    struct str s = {0};
    const char *name = NULL;
    /* One counter for all stems keeps this linear in the number of shapes. */
    do {
        s.length = 0;
        str_add(&s, "%s_%u", stem, (unsigned)++p->n_made_up + 1);
    } while (!s.failed && p->names[find_slot(p, s.text)].name);
    if (!s.failed) name = arena_strdup(b->arena, s.text);
    str_release(&s);
    return name;
}

/* Enters the object under its id (or, when `stem` is given, a made-up name); *name gets it. */
static lmn_status enter_name(struct builder *b, enum builder_kind kind, uint32_t index,
                             const struct builder_object *object, const char *stem,
                             const char **name, struct error *err)
{
    struct builder_private *p = b->private;
    const char *key = object->id;
    *name = key;
    if (!key && !stem) return LMN_OK;
    if (!grow_names(p)) return fail_memory(err, "names");
    if (!key && !(key = make_up_name(b, stem))) return fail_memory(err, "names");
    *name = key;
    struct name_entry fresh = {key, kind, index, !object->id, object->place};
    size_t slot = find_slot(p, key);
    struct name_entry old = p->names[slot];
    p->names[slot] = fresh;
    if (!old.name) {
        p->n_names++;
        return LMN_OK;
    }
    if (!old.is_made_up) {
        p->names[slot] = old;
        return fail_at(err, object->place, "%s \"%s\": the id is taken by a %s at line %u",
                       kind_name(kind), key, kind_name(old.kind), old.place.line);
    }
    /* A made-up name gives way to an id: its owner gets another one. */
    if (!grow_names(p)) return fail_memory(err, "names");
    old.name = make_up_name(b, key);
    if (!old.name) return fail_memory(err, "names");
    p->names[find_slot(p, old.name)] = old;
    p->n_names++;
    if (old.kind == BUILDER_SHAPE) b->shapes[old.index].name = old.name;
    if (old.kind == BUILDER_INSTANCE) b->instances[old.index].name = old.name;
    return LMN_OK;
}

bool builder_find(const struct builder *b, const char *id, enum builder_kind *kind, uint32_t *index)
{
    const struct builder_private *p = b->private;
    if (p->names_capacity) {
        const struct name_entry *e = &p->names[find_slot(p, id)];
        if (e->name) {
            *kind = e->kind;
            *index = e->index;
            return true;
        }
    }
    if (!p->has_sensor || strcmp(id, "sensor") != 0) return false;
    *kind = BUILDER_SENSOR;
    *index = 0;
    return true;
}

const char *builder_closest(const struct builder *b, const char *word)
{
    const struct builder_private *p = b->private;
    const char *best[2] = {"sensor", NULL};
    const char *closest = p->has_sensor ? str_closest(word, best, 1) : NULL;
    for (size_t i = 0; i < p->names_capacity; i++) {
        if (!p->names[i].name) continue;
        best[0] = closest ? closest : p->names[i].name;
        best[1] = p->names[i].name;
        closest = str_closest(word, best, 2);
    }
    return closest;
}

uint32_t builder_count(const struct builder *b, enum builder_kind kind)
{
    switch (kind) {
    case BUILDER_TEXTURE:
        return (uint32_t)b->n_textures;
    case BUILDER_BSDF:
        return (uint32_t)b->n_bsdfs;
    case BUILDER_EMITTER:
        return (uint32_t)b->n_emitters;
    case BUILDER_SHAPE:
        return (uint32_t)b->n_shapes;
    case BUILDER_GROUP:
        return (uint32_t)b->n_groups;
    case BUILDER_INSTANCE:
        return (uint32_t)b->n_instances;
    case BUILDER_SENSOR:
        return b->private->has_sensor;
    }
    return 0;
}

struct builder_object *builder_object(struct builder *b, enum builder_kind kind, uint32_t index)
{
    switch (kind) {
    case BUILDER_TEXTURE:
        return &b->textures[index].object;
    case BUILDER_BSDF:
        return &b->bsdfs[index].object;
    case BUILDER_EMITTER:
        return &b->emitters[index].object;
    case BUILDER_SHAPE:
        return &b->shapes[index].object;
    case BUILDER_GROUP:
        return &b->groups[index].object;
    case BUILDER_INSTANCE:
        return &b->instances[index].object;
    case BUILDER_SENSOR:
        break;
    }
    return &b->sensor_object;
}

void builder_make_movable(struct builder *b, uint32_t shape)
{
    b->shapes[shape].is_movable = true;
}

/* ---- Adding ------------------------------------------------------------------------------- */

enum { MAX_OBJECTS = 1 << 24 }; /* of a kind; indices stay far from SCENE_NONE */

/* Room for one more element; leaves through fail_memory() otherwise. */
static lmn_status reserve_one(void **array, size_t n, size_t *capacity, size_t size,
                              struct error *err)
{
    if (n >= MAX_OBJECTS || !mem_grow(array, capacity, n + 1, size))
        return fail_memory(err, "the scene's objects");
    return LMN_OK;
}

/* reserve_one() for the array b->field, whose capacity is b->private->cap_field. */
#define RESERVE(field)                                                                          \
    do {                                                                                        \
        void *block_ = b->field;                                                                \
        status = reserve_one(&block_, b->n_##field, &b->private->cap_##field, sizeof *b->field, \
                             err);                                                              \
        b->field = block_;                                                                      \
        if (status != LMN_OK) return status;                                                    \
    } while (0)

static void store_index(uint32_t *index, size_t n)
{
    if (index) *index = (uint32_t)n;
}

lmn_status builder_add_texture(struct builder *b, const struct builder_object *object,
                               const struct texture *texture, uint32_t *index, struct error *err)
{
    lmn_status status;
    const char *name;
    RESERVE(textures);
    uint32_t i = (uint32_t)b->n_textures;
    status = enter_name(b, BUILDER_TEXTURE, i, object, NULL, &name, err);
    if (status != LMN_OK) return status;
    b->textures[b->n_textures++] = (struct builder_texture){*object, *texture};
    store_index(index, i);
    return LMN_OK;
}

lmn_status builder_add_constant(struct builder *b, struct place place, struct vec3 value,
                                uint32_t *index, struct error *err)
{
    struct builder_object object = {.place = place};
    struct texture t = {.kind = TEXTURE_CONSTANT,
                        .value = value,
                        .to_uv = {{1, 0, 0}, {0, 1, 0}},
                        .bitmap = SCENE_NONE};
    return builder_add_texture(b, &object, &t, index, err);
}

lmn_status builder_add_bsdf(struct builder *b, const struct builder_object *object,
                            const struct bsdf *bsdf, uint32_t *index, struct error *err)
{
    lmn_status status;
    const char *name;
    RESERVE(bsdfs);
    uint32_t i = (uint32_t)b->n_bsdfs;
    status = enter_name(b, BUILDER_BSDF, i, object, NULL, &name, err);
    if (status != LMN_OK) return status;
    b->bsdfs[b->n_bsdfs++] = (struct builder_bsdf){*object, *bsdf};
    store_index(index, i);
    return LMN_OK;
}

lmn_status builder_add_emitter(struct builder *b, const struct builder_object *object,
                               const struct emitter *emitter, const char *light_group,
                               uint32_t *index, struct error *err)
{
    lmn_status status;
    const char *name;
    bool is_environment = emitter->kind == EMITTER_CONSTANT || emitter->kind == EMITTER_ENVMAP;
    for (size_t i = 0; is_environment && i < b->n_emitters; i++) {
        enum emitter_kind kind = b->emitters[i].emitter.kind;
        if (kind == EMITTER_CONSTANT || kind == EMITTER_ENVMAP)
            return fail_at(err, object->place,
                           "a scene can have one environment (constant, envmap); another one is at "
                           "line %u",
                           b->emitters[i].object.place.line);
    }
    RESERVE(emitters);
    uint32_t i = (uint32_t)b->n_emitters;
    status = enter_name(b, BUILDER_EMITTER, i, object, NULL, &name, err);
    if (status != LMN_OK) return status;
    b->emitters[b->n_emitters++] = (struct builder_emitter){*object, *emitter, light_group};
    store_index(index, i);
    return LMN_OK;
}

lmn_status builder_add_shape(struct builder *b, const struct builder_shape *shape, const char *stem,
                             uint32_t *index, struct error *err)
{
    lmn_status status;
    const char *name;
    RESERVE(shapes);
    uint32_t i = (uint32_t)b->n_shapes;
    status = enter_name(b, BUILDER_SHAPE, i, &shape->object, stem, &name, err);
    if (status != LMN_OK) return status;
    b->shapes[b->n_shapes++] = *shape;
    b->shapes[i].name = name;
    b->shapes[i].final_shape = SCENE_NONE;
    store_index(index, i);
    return LMN_OK;
}

lmn_status builder_add_group(struct builder *b, const struct builder_object *object,
                             uint32_t *index, struct error *err)
{
    lmn_status status;
    const char *name;
    RESERVE(groups);
    uint32_t i = (uint32_t)b->n_groups;
    status = enter_name(b, BUILDER_GROUP, i, object, NULL, &name, err);
    if (status != LMN_OK) return status;
    b->groups[b->n_groups++] = (struct builder_group){*object};
    store_index(index, i);
    return LMN_OK;
}

lmn_status builder_add_instance(struct builder *b, const struct builder_instance *instance,
                                uint32_t *index, struct error *err)
{
    lmn_status status;
    const char *name;
    RESERVE(instances);
    uint32_t i = (uint32_t)b->n_instances;
    status = enter_name(b, BUILDER_INSTANCE, i, &instance->object, "instance", &name, err);
    if (status != LMN_OK) return status;
    b->instances[b->n_instances++] = *instance;
    b->instances[i].name = name;
    store_index(index, i);
    return LMN_OK;
}

lmn_status builder_add_mesh(struct builder *b, const struct mesh *mesh, uint32_t *index,
                            struct error *err)
{
    lmn_status status;
    RESERVE(meshes);
    store_index(index, b->n_meshes);
    b->meshes[b->n_meshes++] = *mesh;
    return LMN_OK;
}

lmn_status builder_add_bitmap(struct builder *b, const char *path, struct place place,
                              uint32_t *index, struct error *err)
{
    lmn_status status;
    struct builder_private *p = b->private;
    for (size_t i = 0; i < b->n_bitmaps; i++) {
        if (strcmp(p->bitmap_paths[i], path) == 0) {
            store_index(index, i);
            return LMN_OK;
        }
    }
    RESERVE(bitmaps);
    void *paths = p->bitmap_paths;
    if (!mem_grow(&paths, &p->cap_bitmap_paths, b->n_bitmaps + 1, sizeof *p->bitmap_paths))
        return fail_memory(err, path);
    p->bitmap_paths = paths;
    char *copy = arena_strdup(b->arena, path);
    if (!copy) return fail_memory(err, path);
    struct error why = {{0}};
    struct bitmap bitmap = {0};
    status = bitmap_load(path, &bitmap, &why);
    if (status == LMN_ERR_MEMORY) return fail(err, status, "%s", why.text);
    if (status != LMN_OK) return fail_at(err, place, "%s", why.text);
    size_t n = (size_t)bitmap.width * bitmap.height * bitmap.n_channels;
    if (bitmap.u8) builder_hash(b, bitmap.u8, n);
    if (bitmap.f16) builder_hash(b, bitmap.f16, n * sizeof(uint16_t));
    if (bitmap.f32) builder_hash(b, bitmap.f32, n * sizeof(float));
    p->bitmap_paths[b->n_bitmaps] = copy;
    store_index(index, b->n_bitmaps);
    b->bitmaps[b->n_bitmaps++] = bitmap;
    return LMN_OK;
}

lmn_status builder_set_sensor(struct builder *b, const struct builder_object *object,
                              const struct sensor *sensor, struct error *err)
{
    const char *name;
    if (b->private->has_sensor)
        return fail_at(err, object->place, "a scene can have one sensor; another one is at line %u",
                       b->sensor_object.place.line);
    lmn_status status = enter_name(b, BUILDER_SENSOR, 0, object, NULL, &name, err);
    if (status != LMN_OK) return status;
    b->sensor_object = *object;
    b->sensor = *sensor;
    b->private->has_sensor = true;
    return LMN_OK;
}
