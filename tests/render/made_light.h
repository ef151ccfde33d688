/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_RENDER_MADE_LIGHT_H
#define TESTS_RENDER_MADE_LIGHT_H

#include <math.h>

#include "made_scene.h"
#include "render/light.h"

/* Lights for the tests of what they send, and the point that they send it to. */

static const double pi = 3.14159265358979323846;

/* Where light arrives. Lights that are not all around stand about +x from here. */
static const struct vec3 reference = {0.1f, 0.2f, -0.1f};

static inline uint32_t area(struct made_scene *m)
{
    return made_emitter(m, EMITTER_AREA, vec3(1, 2, 3));
}

static inline uint32_t black(struct made_scene *m)
{
    return made_diffuse(m, vec3_splat(0));
}

/* A group of its own for what follows, at a place: instance 0 is always at identity. */
static inline void place_group(struct made_scene *m, struct transform place)
{
    struct transform identity = transform_identity();
    made_group(m);
    made_instance(m, 0, &identity);
    made_group(m);
    made_instance(m, 1, &place);
}

/* A sky whose horizon is a bin's edge, and its sun, large and half set. */
static inline void add_sky(struct made_scene *m)
{
    uint32_t e = made_emitter(m, EMITTER_SKY, vec3_splat(1));
    struct transform turn = transform_rotate(vec3(0, 0, 1), 20),
                     scale = transform_scale(vec3_splat(3));
    m->emitters[e].to_world = transform_mul(&turn, &scale);
    m->emitters[e].turbidity = 2.5f;
    m->emitters[e].sun_elevation = 20;
    m->emitters[e].sun_azimuth = -140;
    m->emitters[e].sky_scale = 1.5f;
    m->emitters[e].sun_aperture = 10;
}

static inline void add_sun(struct made_scene *m)
{
    add_sky(m);
    m->emitters[0].sky_scale = 0;
    m->emitters[0].sun_scale = 2;
    m->emitters[0].sun_elevation = 2;
    m->emitters[0].sun_azimuth = -20;
}

/* The light's surface that the reference point sees in direction d. */
static inline bool seen(const struct view *v, struct vec3 d, struct surface *s)
{
    struct ray r = {reference, 0, d, INFINITY};
    struct hit hit;
    accel_intersect(v->top, &r, &hit);
    if (hit.shape == SCENE_NONE) return false;
    surface_init(s, v, &r, &hit);
    return s->shape->emitter != SCENE_NONE && vec3_dot(s->frame.n, d) < 0;
}

#endif
