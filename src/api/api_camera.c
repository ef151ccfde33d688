/* SPDX-License-Identifier: Apache-2.0 */
/* Public cameras: where a picture is seen from. */
#include "api/handles.h"

static struct vec3 read_vector(const double v[3])
{
    return vec3((float)v[0], (float)v[1], (float)v[2]);
}

static void write_vector(struct vec3 v, double to[3])
{
    to[0] = (double)v.x;
    to[1] = (double)v.y;
    to[2] = (double)v.z;
}

lmn_status scene_pose(const lmn_scene *scene, const lmn_camera *camera, struct pose *out,
                      struct error *err)
{
    *out = (struct pose){.origin = read_vector(camera->origin),
                         .target = read_vector(camera->target),
                         .up = read_vector(camera->up),
                         .fov = (float)camera->fov};
    return pose_check(out, &scene->scene->defaults.sensor, err);
}

lmn_status lmn_scene_get_camera(lmn_context *context, const lmn_scene *scene, const double *values,
                                lmn_camera *out)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    struct scene_state state = {0};
    TRY(scene_units(scene, values, scene->cache->u, err));
    TRY(scene_state_init(scene->scene, &state, err));
    scene_apply(scene->scene, scene->cache->u, &state);
    const struct pose p = pose_of_sensor(&state.sensor, &scene->scene->bounds);
    *out = (lmn_camera){.fov = (double)p.fov};
    write_vector(p.origin, out->origin);
    write_vector(p.target, out->target);
    write_vector(p.up, out->up);
done:
    scene_state_release(&state);
    return status;
}
