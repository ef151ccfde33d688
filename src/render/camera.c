/* SPDX-License-Identifier: Apache-2.0 */
#include "render/camera.h"

#include "math/warp.h"

double camera_half_width(double fov, enum fov_axis axis, double aspect)
{
    double t = tan(fov * (3.14159265358979323846 / 360.0));
    switch (axis) {
    case FOV_X:
        return t;
    case FOV_Y:
        return t * aspect;
    case FOV_DIAGONAL:
        return t / sqrt(1.0 + 1.0 / (aspect * aspect));
    case FOV_SMALLER:
        return aspect > 1.0 ? t * aspect : t;
    case FOV_LARGER:
        return aspect > 1.0 ? t : t * aspect;
    }
    return t;
}

void camera_init(struct camera *c, const struct sensor *s, uint32_t width, uint32_t height)
{
    double tx = camera_half_width((double)s->fov, s->fov_axis, (double)width / (double)height);
    /* Camera space: +x to the left, +y up, +z forward; pixels run right and down. d = forward +
     * (px, py) steps, with pixel (0, 0) at the top left corner. */
    struct vec3 left = transform_vector(&s->to_world, vec3(1.0f, 0.0f, 0.0f));
    struct vec3 up = transform_vector(&s->to_world, vec3(0.0f, 1.0f, 0.0f));
    struct vec3 ahead = transform_vector(&s->to_world, vec3(0.0f, 0.0f, 1.0f));
    double step = 2.0 * tx / (double)width, ty = tx * (double)height / (double)width;
    c->origin = transform_point(&s->to_world, vec3_splat(0.0f));
    c->ahead = vec3_normalize(ahead);
    c->corner = vec3_madd(vec3_madd(ahead, left, (float)tx), up, (float)ty);
    c->step_x = vec3_scale(left, (float)-step);
    c->step_y = vec3_scale(up, (float)-step);
    c->near_clip = s->near_clip;
    c->far_clip = s->far_clip;
}
