/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_POWERS_H
#define TRAIN_POWERS_H

#include "base/rng.h"
#include "nn/field.h"
#include "scene/scene.h"

/*
 * Radiance is linear in the power and colour of each light. Variables that change nothing else
 * leave the space that is learnt (method 2.3): lights that one of them drives form a group, the
 * network gives the radiance that each group brings at a reference power, and a configuration
 * weighs their sum. What was traced once teaches all powers.
 */
struct powers {
    uint32_t n;                       /* groups, 1 .. FIELD_MAX_LIGHTS */
    uint32_t *group_of;               /* [n_emitters] */
    uint32_t first[FIELD_MAX_LIGHTS]; /* an emitter of the group; SCENE_NONE: its power is fixed */
    float reference[FIELD_MAX_LIGHTS][3]; /* that emitter's radiance there */
    uint32_t n_variables;
    uint32_t *variables; /* [n_variables], into scene->variables: those that change powers alone */
    float *at; /* [n_variables], u of the reference: the end of the range that is brighter */
};

/* is_off: no variable leaves, and all lights are one group. */
lmn_status powers_init(struct powers *p, const struct scene *scene, bool is_off, struct error *err);
void powers_release(struct powers *p);

bool powers_has(const struct powers *p, uint32_t variable);

/* Sets the variables of a configuration u to the reference, or to uniform draws. */
void powers_set_reference(const struct powers *p, float *u);
void powers_draw(const struct powers *p, struct rng *r, float *u);

/* The groups' powers in a configuration, relative to the reference: out [n][3]. */
void powers_at(const struct powers *p, const struct scene_state *state, float *out);

#endif
