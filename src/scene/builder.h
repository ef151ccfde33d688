/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_BUILDER_H
#define SCENE_BUILDER_H

#include "scene/scene.h"

/*
 * A scene in the making, which no file format shines through: readers add objects to it, variables
 * are declared on it, builder_finish() lowers it to a struct scene.
 *
 *   builder_new()  ->  a reader's builder_add_*() calls  ->  variables_declare(), which calls
 *   builder_make_movable()  ->  builder_finish()  ->  variables_resolve()
 *
 * Indices of textures, bsdfs, emitters, meshes and bitmaps are final from the start. Shapes are
 * sorted into groups by builder_finish(), which also makes the final instances:
 *
 *   - top-level shapes that stay: group 0, placed by final instance 0 at identity;
 *   - a movable shape: a group of its own. Its geometry includes its own to_world, so that its
 *     final instance is at identity (top level), or at its builder instance's to_world (in a
 *     shapegroup: one final instance for each builder instance of that shapegroup);
 *   - what is left of a shapegroup: one group, with one final instance per builder instance.
 *
 * builder->placements tells for each final instance where it came from.
 */

/* Where something was written, for messages. line 0: no position within the file. */
struct place {
    const char *file;
    uint32_t line, column;
};

/* fail() with LMN_ERR_PARSE and "file:line:column: " in front. */
__attribute__((format(printf, 3, 4))) lmn_status fail_at(struct error *err, struct place place,
                                                         const char *format, ...);

/* A child that no plugin of the format asks for: what the authors' variable scenes add to objects
 * (num_parameters, min_bounds, range_bounds, rotation_axis, min_angle, range_angle), and every
 * `reflectance` after the first. */
struct extra {
    const char *name;
    struct place place;
    double values[4];
    uint32_t n_values;
    uint32_t texture; /* a texture-valued extra: index of the texture; else SCENE_NONE */
};

/* What all objects have in common. */
struct builder_object {
    const char *id; /* as the file gives it; NULL when it gives none. Unique among all kinds */
    struct place place;
    const struct extra *extras;
    uint32_t n_extras;
};

struct builder_texture {
    struct builder_object object;
    struct texture texture;
};

/* Colours and numbers written directly in a material are textures (constant, without an id). */
struct builder_bsdf {
    struct builder_object object;
    struct bsdf bsdf;
};

struct builder_emitter {
    struct builder_object object;
    struct emitter emitter;
    const char *light_group; /* NULL: none */
};

struct builder_shape {
    struct builder_object object;
    const char *name; /* id, or a made-up one; unique among shapes */
    enum shape_kind kind;
    uint32_t mesh;             /* SHAPE_MESH; to_world is in its vertices already */
    struct transform to_world; /* as declared; of spheres and disks with centre and radius */
    uint32_t bsdf, emitter;    /* emitter: SCENE_NONE when it does not shine */
    bool flip_normals;
    uint32_t group;       /* builder group, or SCENE_NONE: top level */
    bool is_movable;      /* set by builder_make_movable() */
    uint32_t final_shape; /* set by builder_finish(): into scene->shapes, state->shape_bsdfs */
};

/* A shapegroup: shapes that appear only where an instance places them. */
struct builder_group {
    struct builder_object object;
};

struct builder_instance {
    struct builder_object object;
    const char *name; /* id, or a made-up one; unique among shapes and instances */
    uint32_t group;   /* builder group */
    struct transform to_world;
};

/* Origin of a final instance. */
struct builder_placement {
    uint32_t shape; /* builder shape that is alone in it; SCENE_NONE: a shapegroup, or what stays */
    uint32_t instance; /* builder instance that it belongs to; SCENE_NONE: top level */
};

struct variable_set; /* of src/scene/variables.h */

struct builder {
    struct scene *scene; /* in the making; builder_finish() gives it to the caller */
    struct arena *arena; /* the scene's: for everything that outlives the builder */
    const char *path;    /* of the scene file */
    uint64_t hash;

    struct builder_texture *textures;
    struct builder_bsdf *bsdfs;
    struct builder_emitter *emitters;
    struct builder_shape *shapes;
    struct builder_group *groups;
    struct builder_instance *instances;
    struct mesh *meshes;
    struct bitmap *bitmaps;
    size_t n_textures, n_bsdfs, n_emitters, n_shapes, n_groups, n_instances, n_meshes, n_bitmaps;

    struct builder_object sensor_object; /* its id is NULL when the file gives none: "sensor" */
    struct sensor sensor;
    struct render_settings settings;

    struct builder_placement *placements; /* [scene->n_instances], after builder_finish() */

    struct variable_set *variables; /* variables_declare() keeps its own here, in `arena` */

    struct builder_private *private;
};

lmn_status builder_new(const char *path, struct builder **out, struct error *err);
void builder_free(struct builder *b); /* with the scene, unless builder_finish() gave it away */

/* Each copies what it is given; names and places must live in b->arena or longer. `index`, which
 * may be NULL, gets the new object's index. An id that is taken is an error with both places. */
lmn_status builder_add_texture(struct builder *b, const struct builder_object *object,
                               const struct texture *texture, uint32_t *index, struct error *err);
lmn_status builder_add_bsdf(struct builder *b, const struct builder_object *object,
                            const struct bsdf *bsdf, uint32_t *index, struct error *err);
lmn_status builder_add_emitter(struct builder *b, const struct builder_object *object,
                               const struct emitter *emitter, const char *light_group,
                               uint32_t *index, struct error *err);
/* shape->name is made from the id, else from `stem` ("Mesh015", "rectangle"). */
lmn_status builder_add_shape(struct builder *b, const struct builder_shape *shape, const char *stem,
                             uint32_t *index, struct error *err);
lmn_status builder_add_group(struct builder *b, const struct builder_object *object,
                             uint32_t *index, struct error *err);
lmn_status builder_add_instance(struct builder *b, const struct builder_instance *instance,
                                uint32_t *index, struct error *err);
/* Takes over a mesh whose arrays are in b->arena. */
lmn_status builder_add_mesh(struct builder *b, const struct mesh *mesh, uint32_t *index,
                            struct error *err);
/* Loads a bitmap; the same path again gives the same index. */
lmn_status builder_add_bitmap(struct builder *b, const char *path, struct place place,
                              uint32_t *index, struct error *err);
lmn_status builder_set_sensor(struct builder *b, const struct builder_object *object,
                              const struct sensor *sensor, struct error *err);

/* A texture that is `value` everywhere, without an id. */
lmn_status builder_add_constant(struct builder *b, struct place place, struct vec3 value,
                                uint32_t *index, struct error *err);

/* Feeds bytes that can change an image into the scene's hash. */
void builder_hash(struct builder *b, const void *bytes, size_t size);

enum builder_kind {
    BUILDER_TEXTURE,
    BUILDER_BSDF,
    BUILDER_EMITTER,
    BUILDER_SHAPE,
    BUILDER_GROUP,
    BUILDER_INSTANCE,
    BUILDER_SENSOR
};

/* The object of that id (shapes and instances: also of a made-up name; "sensor": the sensor). */
bool builder_find(const struct builder *b, const char *id, enum builder_kind *kind,
                  uint32_t *index);

/* The id most like `word`, for "did you mean"; NULL when none is close. */
const char *builder_closest(const struct builder *b, const char *word);

/* The common part of an object. */
struct builder_object *builder_object(struct builder *b, enum builder_kind kind, uint32_t index);

/* How many objects of a kind there are. */
uint32_t builder_count(const struct builder *b, enum builder_kind kind);

/* Asks for a group of its own for a shape, because its place or visibility can change. */
void builder_make_movable(struct builder *b, uint32_t shape);

/* Checks what only the whole can tell and lowers it all. Afterwards the caller owns *out; the
 * builder, still readable, points into it. */
lmn_status builder_finish(struct builder *b, struct scene **out, struct error *err);

#endif
