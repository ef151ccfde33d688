/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CAMERA_PATH_H
#define CAMERA_PATH_H

#include "app.h"

/*
 * A path of key frames through configurations and cameras, as the viewer's page exports it and
 * previews it (viewer/web/spline.js): values go along straight lines, choices hold until the next
 * key, cameras follow the cubic Hermite curve whose tangents are those of Catmull and Rom for keys
 * that are not equally far apart.
 *
 *   {"lumenaut_path": 1, "fps": 24, "keys": [
 *     {"time": 0, "values": {"door": 0.5}, "camera": null},
 *     {"time": 2, "values": {}, "camera":
 *         {"origin": [..], "target": [..], "up": [..], "fov": 40}}]}
 *
 * What a key leaves out is the scene's default; a camera of null is the one that its values give.
 */
struct path_key {
    double time;    /* seconds */
    double *values; /* [n_variables], owned */
    lmn_camera camera;
    bool has_camera; /* of its own */
};

struct camera_path {
    struct path_key *keys; /* [n_keys], by time; owned */
    uint32_t n_keys, n_variables;
    double fps;
    bool has_cameras; /* some key has one: then pictures have, too */
    double most_fov;
};

/* Returns an exit code after saying why. */
int camera_path_load(struct camera_path *p, struct app *app, const lmn_scene *scene,
                     const char *file);
void camera_path_release(struct camera_path *p);

/* Frames from the start to the last key. */
uint32_t camera_path_n_frames(const struct camera_path *p);

/* The configuration of a frame, values [n_variables], and its camera, or NULL. */
const lmn_camera *camera_path_at(const struct camera_path *p, const lmn_scene *scene,
                                 uint32_t frame, double *values, lmn_camera *camera);

#endif
