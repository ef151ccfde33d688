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
    /* The film, of which the picture may be a part, in pixels of the picture. */
    double film_x = (double)width / (1.0 - (double)s->crop.left - (double)s->crop.right);
    double film_y = (double)height / (1.0 - (double)s->crop.top - (double)s->crop.bottom);
    double first_x = ((double)s->crop.left + (double)s->shift_x) * film_x;
    double first_y = ((double)s->crop.top + (double)s->shift_y) * film_y;
    bool is_flat = s->kind == SENSOR_ORTHOGRAPHIC;
    double tx = is_flat ? (double)s->scale_x
                        : camera_half_width((double)s->fov, s->fov_axis, film_x / film_y);
    double ty = (is_flat ? (double)s->scale_y : tx) * film_y / film_x;
    double step_x = 2.0 * tx / film_x, step_y = 2.0 * ty / film_y;
    /* Camera space: +x to the left, +y up, +z forward; pixels run right and down. d = forward +
     * (px, py) steps, with pixel (0, 0) at the top left corner. */
    struct vec3 left = transform_vector(&s->to_world, vec3(1.0f, 0.0f, 0.0f));
    struct vec3 up = transform_vector(&s->to_world, vec3(0.0f, 1.0f, 0.0f));
    struct vec3 ahead = transform_vector(&s->to_world, vec3(0.0f, 0.0f, 1.0f));
    c->kind = s->kind;
    if (s->kind == SENSOR_THINLENS && !(s->aperture_radius > 0.0f)) c->kind = SENSOR_PERSPECTIVE;
    c->origin = transform_point(&s->to_world, vec3_splat(0.0f));
    c->ahead = vec3_normalize(ahead);
    c->corner = vec3_madd(is_flat ? vec3_scale(ahead, s->near_clip) : ahead, left,
                          (float)(tx - first_x * step_x));
    c->corner = vec3_madd(c->corner, up, (float)(ty - first_y * step_y));
    c->step_x = vec3_scale(left, (float)-step_x);
    c->step_y = vec3_scale(up, (float)-step_y);
    c->near_clip = s->near_clip;
    c->far_clip = s->far_clip;
    c->lens_x = vec3_scale(left, s->aperture_radius);
    c->lens_y = vec3_scale(up, s->aperture_radius);
    c->focus = s->focus_distance;
}

struct ray camera_ray_any(const struct camera *c, float x, float y, float u, float v, float *offset)
{
    if (c->kind == SENSOR_PERSPECTIVE) return camera_ray(c, x, y, offset);
    struct vec3 q = vec3_madd(vec3_madd(c->corner, c->step_x, x), c->step_y, y);
    if (c->kind == SENSOR_ORTHOGRAPHIC) {
        *offset = c->near_clip;
        return (struct ray){vec3_add(c->origin, q), 0.0f, c->ahead, c->far_clip - c->near_clip};
    }
    struct vec2 disk = warp_disk(u, v);
    struct vec3 lens = vec3_madd(vec3_scale(c->lens_x, disk.x), c->lens_y, disk.y);
    struct vec3 d = vec3_normalize(vec3_sub(vec3_scale(q, c->focus), lens));
    float inverse = 1.0f / vec3_dot(d, c->ahead);
    float near = c->near_clip * inverse, far = c->far_clip * inverse;
    *offset = near;
    /* Along the film plane, where only rounding decides: nothing is there. */
    if (!(inverse > 0.0f && near < 1e17f)) return (struct ray){c->origin, 0.0f, c->ahead, 0.0f};
    return (struct ray){vec3_madd(vec3_add(c->origin, lens), d, near), 0.0f, d, far - near};
}

bool camera_project(const struct camera *c, struct vec3 p, float *x, float *y)
{
    struct vec3 q = vec3_sub(p, c->origin);
    const float depth = vec3_dot(q, c->ahead);
    if (!(depth > 0.0f)) return false;
    if (c->kind != SENSOR_ORTHOGRAPHIC) q = vec3_scale(q, 1.0f / depth);
    q = vec3_sub(q, c->corner);
    *x = vec3_dot(q, c->step_x) / vec3_dot(c->step_x, c->step_x);
    *y = vec3_dot(q, c->step_y) / vec3_dot(c->step_y, c->step_y);
    return true;
}
