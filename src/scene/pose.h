/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_POSE_H
#define SCENE_POSE_H

#include "scene/scene.h"

/* Where a camera stands and looks: what a viewer moves. Kind, film and lens stay the sensor's. */
struct pose {
    struct vec3 origin, target, up; /* world space; up: any direction not along the view */
    float fov; /* degrees along the sensor's axis; orthographic: the film's width, world space */
};

/* The sensor's own. It says where it looks to, not how far: the target is as far away as the middle
 * of the scene, or where a lens is sharp. */
struct pose pose_of_sensor(const struct sensor *s, const struct bounds *scene);

/* Refuses what no camera can do. */
lmn_status pose_check(const struct pose *p, const struct sensor *s, struct error *err);

/* Moves the sensor there. A mirrored one stays mirrored. */
void pose_apply(const struct pose *p, struct sensor *s);

#endif
