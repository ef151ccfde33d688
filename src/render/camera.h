/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_CAMERA_H
#define RENDER_CAMERA_H

#include "render/embree.h"

/* A pinhole for a picture of given proportions, as Mitsuba's `perspective`. */
struct camera {
    struct vec3 origin;
    struct vec3 corner, step_x, step_y; /* direction through pixel (x, y): corner + x, y steps */
    struct vec3 ahead;                  /* unit, along the optical axis */
    float near_clip, far_clip;
};

void camera_init(struct camera *c, const struct sensor *s, uint32_t width, uint32_t height);

/* Half the picture's width at distance 1: the tangent of half the horizontal angle. */
double camera_half_width(double fov, enum fov_axis axis, double aspect);

/* The ray through (x, y) in pixels from the picture's top left corner; *offset is how far from the
 * pinhole it starts (the near plane). */
static inline struct ray camera_ray(const struct camera *c, float x, float y, float *offset)
{
    struct vec3 d = vec3_normalize(vec3_madd(vec3_madd(c->corner, c->step_x, x), c->step_y, y));
    float inverse = 1.0f / vec3_dot(d, c->ahead);
    float near = c->near_clip * inverse, far = c->far_clip * inverse;
    *offset = near;
    return (struct ray){vec3_madd(c->origin, d, near), 0.0f, d, far - near};
}

#endif
