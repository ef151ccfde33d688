/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/pose.h"

/* Of the view's length: a target nearer than this is no direction, an up vector nearer to the view
 * than its sine no upright. */
#define LEAST_LENGTH 1e-6f
#define LEAST_SINE   1e-4f

/* Of the scene's diagonal: nearer targets are hard to turn around. */
#define LEAST_DISTANCE 0.02f

struct pose pose_of_sensor(const struct sensor *s, const struct bounds *scene)
{
    const struct vec3 origin = transform_point(&s->to_world, vec3_splat(0.0f));
    const struct vec3 ahead = vec3_normalize(
        transform_vector(&s->to_world, vec3(0.0f, 0.0f, 1.0f)));
    const struct vec3 middle = vec3_scale(vec3_add(scene->min, scene->max), 0.5f);
    const float size = vec3_length(vec3_sub(scene->max, scene->min));
    float distance = vec3_dot(vec3_sub(middle, origin), ahead);
    if (s->kind == SENSOR_THINLENS) distance = s->focus_distance;
    if (!(distance > LEAST_DISTANCE * size)) distance = size > 0.0f ? 0.5f * size : 1.0f;
    return (struct pose){
        .origin = origin,
        .target = vec3_madd(origin, ahead, distance),
        .up = vec3_normalize(transform_vector(&s->to_world, vec3(0.0f, 1.0f, 0.0f))),
        .fov = s->kind == SENSOR_ORTHOGRAPHIC ? 2.0f * s->scale_x : s->fov};
}

lmn_status pose_check(const struct pose *p, const struct sensor *s, struct error *err)
{
    const struct vec3 view = vec3_sub(p->target, p->origin);
    const float length = vec3_length(view), size = vec3_length(p->origin);
    if (!vec3_is_finite(p->origin) || !vec3_is_finite(p->target) || !vec3_is_finite(p->up) ||
        !(length < 1e18f))
        return fail(err, LMN_ERR_ARGUMENT, "camera: a coordinate is not a number, or too large");
    if (!(length > LEAST_LENGTH * max_float(size, 1e-6f)))
        return fail(err, LMN_ERR_ARGUMENT, "camera: origin and target are equal");
    if (!(vec3_length(p->up) > 0.0f) ||
        !(vec3_length(vec3_cross(vec3_normalize(p->up), vec3_scale(view, 1.0f / length))) >
          LEAST_SINE))
        return fail(err, LMN_ERR_ARGUMENT, "camera: up is along the view, or zero");
    if (s->kind == SENSOR_ORTHOGRAPHIC && !(p->fov >= 1e-9f && p->fov <= 1e12f))
        return fail(err, LMN_ERR_ARGUMENT,
                    "camera: fov %g: of this orthographic camera a width, from 1e-9 to 1e12",
                    (double)p->fov);
    if (s->kind != SENSOR_ORTHOGRAPHIC && !(p->fov > 0.0f && p->fov < 180.0f))
        return fail(err, LMN_ERR_ARGUMENT, "camera: fov %g: more than 0 and less than 180 degrees",
                    (double)p->fov);
    return LMN_OK;
}

void pose_apply(const struct pose *p, struct sensor *s)
{
    const struct transform mirror = transform_scale(vec3(-1.0f, 1.0f, 1.0f));
    const bool is_mirrored = transform_flips(&s->to_world);
    s->to_world = transform_look_at(p->origin, p->target, vec3_normalize(p->up));
    if (is_mirrored) s->to_world = transform_mul(&s->to_world, &mirror);
    if (s->kind != SENSOR_ORTHOGRAPHIC) {
        s->fov = p->fov;
    } else if (p->fov != 2.0f * s->scale_x) { /* a film keeps its proportions */
        s->scale_y *= 0.5f * p->fov / s->scale_x;
        s->scale_x = 0.5f * p->fov;
    }
}
