/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_PARAMS_H
#define SCENE_PARAMS_H

#include "scene/builder.h"

/*
 * Every value of a scene has a path in the style of Mitsuba's mi.traverse(): names of objects and
 * properties with dots between, as in "lamp.radiance.value" or "Floor.brdf_0.reflectance.value".
 * docs/scene-format.md lists them. An alias is another way to say the same: without ".value", and
 * without the wrappers "brdf_0" and "nested_bsdf".
 *
 * Targets are those paths on the builder, before lowering: what variables are declared on.
 */
struct target {
    const char *path; /* unique; in the builder's arena */
    enum param_type type;
    bool is_alias;
    enum builder_kind owner; /* which array of the builder */
    uint32_t index;          /* into it */
    uint32_t offset;         /* bytes into the element's struct texture, bsdf, emitter, sensor;
                                shapes and instances: see `part` */
    enum target_part { PART_FIELD, PART_TO_WORLD, PART_VISIBLE, PART_BSDF } part;
    double low, high; /* what a number or a colour's channel may be */
};

struct target_list {
    struct target *items;
    size_t n, capacity;
};

/* All targets of the builder, aliases after what they stand for. */
lmn_status target_list_init(struct target_list *list, const struct builder *b, struct error *err);
void target_list_release(struct target_list *list);

/* The target of the path `path` + `suffix`; of type `wanted` when "path.value" has it and the path
 * itself has not. NULL when there is none. */
const struct target *target_find(const struct target_list *list, const char *path,
                                 const char *suffix, enum param_type wanted);

/* What paths call the object of that id: without "var_" (as the authors' scenes mark what varies)
 * unless something else has that name. A part of `id`. */
const char *target_name(const struct builder *b, const char *id);

/* The path most like `word`, or NULL. */
const char *target_closest(const struct target_list *list, const char *word);

/* Where the builder keeps a target's value; NULL for PART_VISIBLE. */
void *target_in(const struct target *t, const struct builder *b);

/* Where the state will have it, after builder_finish(). A shape or an instance can be spread over
 * several final instances: this names the first. */
void target_lower(const struct target *t, const struct builder *b, struct param *out);

/* Fills scene->params: everything but aliases, with texts of scene->defaults. */
lmn_status params_resolve(const struct builder *b, struct scene *s, struct error *err);

/* What paths call emitter->radiance: "radiance", "intensity", "irradiance". */
const char *emitter_radiance_name(enum emitter_kind kind);

/* "float", "rgb", "transform", "texture", "bsdf", "bool" */
const char *param_type_name(enum param_type type);

#endif
