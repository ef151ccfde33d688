/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_ASSIGN_H
#define SCENE_ASSIGN_H

#include "scene/scene.h"

/*
 * Configurations as people give them: doubles in scene units, one per variable, in the order of
 * scene->variables.
 */

/* Applies "name=value" to values [n_variables]. `name` is a variable's or a group's; the value of a
 * group is a list with commas. Each value is a number in scene units ("0.3", "25deg" when the unit
 * is deg), a part of the range ("50%"), or a choice's name. Fails with LMN_ERR_ARGUMENT and a
 * suggestion, and then leaves values as they were. */
lmn_status scene_parse_value(const struct scene *s, const char *assignment, double *values,
                             struct error *err);

void scene_default_values(const struct scene *s, double *values);

/* The index-th configuration of the stream `seed`, uniform. */
void scene_random_values(const struct scene *s, uint64_t seed, uint64_t index, double *values);

/* The same in [0,1), as scene_apply() takes it. */
void scene_random_units(const struct scene *s, uint64_t seed, uint64_t index, float *u);

/* values NULL: the defaults. */
void scene_values_to_units(const struct scene *s, const double *values, float *u);

#endif
