/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_BINDING_H
#define SCENE_BINDING_H

#include "scene/scene.h"

/*
 * How variables write into a scene's state. One binding owns one value of the state (no two
 * bindings name the same one), and computes it from the defaults and u alone, never from what the
 * state holds: applying twice is applying once, and nothing drifts.
 *
 * Readers of variables fill the arrays scene->variables and scene->bindings, all in scene->arena.
 */

/* A number that follows a variable, or a constant when `variable` is SCENE_NONE. */
struct drive {
    uint32_t variable; /* into scene->variables, continuous */
    float at_0, at_1;  /* value at u = 0 and at u = 1; constants: at_0 */
};

/* One factor of a transform. */
enum step_kind { STEP_TRANSLATE, STEP_ROTATE, STEP_SCALE, STEP_FIXED };

struct binding_step {
    enum step_kind kind;
    struct drive drive[3];  /* offset; degrees in drive[0]; factors */
    struct vec3 axis;       /* STEP_ROTATE, not zero */
    struct vec3 pivot;      /* STEP_ROTATE, STEP_SCALE: the point that stays */
    struct transform fixed; /* STEP_FIXED */
};

/* A pinhole that stands at `origin` and looks at `target`. */
struct binding_camera {
    struct drive origin[3], target[3];
    struct vec3 up; /* not zero */
};

/* True when the discrete variable takes this choice. */
struct binding_condition {
    uint32_t variable, choice;
};

enum binding_kind {
    BINDING_NUMBER,    /* float = drive[0] */
    BINDING_SPLAT,     /* three equal floats (a number kept as a texture) = drive[0] */
    BINDING_RGB,       /* three floats = drive[0..2] */
    BINDING_TRANSFORM, /* transform = the product of the steps, the last applied first */
    BINDING_CAMERA,    /* transform = look-at */
    BINDING_CHOICE,    /* uint32_t = options[choice of variable] */
    BINDING_VISIBLE    /* bool = all conditions hold */
};

struct binding {
    enum binding_kind kind;
    enum state_array array; /* the place that it writes, as in struct param */
    uint32_t index, offset;
    struct drive drive[3];
    struct binding_step *steps; /* TRANSFORM */
    uint32_t n_steps;
    struct binding_camera *camera;
    uint32_t variable;                    /* CHOICE: discrete */
    uint32_t *options;                    /* CHOICE: [n_choices of the variable] */
    struct binding_condition *conditions; /* VISIBLE */
    uint32_t n_conditions;
};

/* Does what the binding writes depend on the variable? */
bool binding_follows(const struct binding *b, uint32_t variable);

#endif
