/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_BOUNDS_H
#define SCENE_BOUNDS_H

#include "scene/scene.h"

/* Nothing: min > max. */
struct bounds bounds_empty(void);
bool bounds_is_empty(const struct bounds *b);
void bounds_add(struct bounds *b, struct vec3 p);

/* Around all of b after a map. */
struct bounds bounds_transform(const struct bounds *b, const struct transform *t);

/* Of a shape, or all shapes of a group, in the group's space. */
struct bounds shape_bounds(const struct scene *s, const struct shape *shape);
struct bounds group_bounds(const struct scene *s, const struct group *g);

#endif
