/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_VARIABLE_SET_H
#define SCENE_VARIABLE_SET_H

#include "scene/binding.h"
#include "scene/params.h"

/*
 * Variables while the scene is in the making: what readers of variables fill (the JSON file, the
 * authors' var_ objects) and variables_resolve() turns into scene->variables and scene->bindings.
 * Everything is in the builder's arena; builder->variables points to it.
 */
enum { VARIABLES_MAX = 256 };

/* One target that a run of variables writes. Which of the fields below `kind` count depends on it:
 * see struct binding. */
struct write {
    struct target target;
    struct place place;    /* where it was declared */
    uint32_t first, count; /* the variables that write it */
    enum binding_kind kind;
    struct drive drive[3];
    struct binding_step step;
    bool replaces_base; /* TRANSFORM: the target's own to_world does not count */
    struct binding_camera *camera;
    /* CAMERA: the target's x and z are in the middle third of the scene's bounding box, its y at a
     * third of its height; `drive.variable` of the camera's target says which variables these are.
     */
    bool aims_at_middle;
    uint32_t variable, *options;        /* CHOICE */
    struct binding_condition condition; /* VISIBLE */
};

struct variable_set {
    struct variable variables[VARIABLES_MAX];
    struct place places[VARIABLES_MAX];
    uint32_t n_variables;
    struct write *writes;
    size_t n_writes, capacity;
    struct target_list targets; /* heap; only while declaring */
};

/* An empty set at b->variables, with the list of targets. */
lmn_status variable_set_new(struct builder *b, struct error *err);

/* `value`, which came through a float, if it is in the range, else the middle of the range. */
double variable_default(double value, double min, double max);

/* Adds a variable: checks that its name is usable and new. Strings must live in the arena. */
lmn_status variable_set_add(struct builder *b, struct place place, const struct variable *v,
                            uint32_t *index, struct error *err);

/* Adds a write: makes shapes movable, and refuses what another variable writes already. A target
 * without a path says that there was no memory for one. */
lmn_status variable_set_write(struct builder *b, const struct write *w, struct error *err);

/* Sets the text of targets of `count` variables from the writes that they share. */
lmn_status variable_set_name_targets(struct builder *b, uint32_t first, uint32_t count,
                                     struct error *err);

#endif
