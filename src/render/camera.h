/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_CAMERA_H
#define RENDER_CAMERA_H

#include "render/embree.h"

/* A sensor for a picture of given proportions, as Mitsuba's of the same names. */
struct camera {
    enum sensor_kind kind;
    struct vec3 origin;
    struct vec3 corner, step_x, step_y; /* direction through pixel (x, y): corner + x, y steps;
                                           orthographic: the place where rays start, from origin */
    struct vec3 ahead;                  /* unit, along the optical axis */
    float near_clip, far_clip;
    struct vec3 lens_x, lens_y; /* thin lens: from its centre to its rim */
    float focus;                /* thin lens: distance of the plane that is sharp */
};

void camera_init(struct camera *c, const struct sensor *s, uint32_t width, uint32_t height);

/* Half the picture's width at distance 1: the tangent of half the horizontal angle. */
double camera_half_width(double fov, enum fov_axis axis, double aspect);

/* A pinhole's ray through (x, y) in pixels from the picture's top left corner; *offset is how far
 * from the pinhole it starts (the near plane). Streams do this in vector code. */
static inline struct ray camera_ray(const struct camera *c, float x, float y, float *offset)
{
    struct vec3 d = vec3_normalize(vec3_madd(vec3_madd(c->corner, c->step_x, x), c->step_y, y));
    float inverse = 1.0f / vec3_dot(d, c->ahead);
    float near = c->near_clip * inverse, far = c->far_clip * inverse;
    *offset = near;
    return (struct ray){vec3_madd(c->origin, d, near), 0.0f, d, far - near};
}

/* The same for all kinds; (u, v) in [0,1)^2 choose the place on a thin lens. */
struct ray camera_ray_any(const struct camera *c, float x, float y, float u, float v,
                          float *offset);

/* Where a point is in the picture, in pixels; false: behind the camera. Of a thin lens, where its
 * middle sees it. */
bool camera_project(const struct camera *c, struct vec3 p, float *x, float *y);

#endif
