/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_SURFACE_H
#define RENDER_SURFACE_H

#include "render/world.h"

/* A point on a surface in world space. */
struct surface {
    struct vec3 p;
    struct vec3 n;      /* geometric normal, unit, on the shape's outer side */
    struct frame frame; /* shading frame */
    struct vec3 wi;     /* against the ray, in the shading frame */
    float u, v;         /* texture coordinates */
    float t;            /* along the ray */
    const struct world_shape *shape;
    uint32_t instance, primitive;
};

/* Offsets against self-intersection, as Mitsuba: relative to the largest coordinate. */
#define SURFACE_RAY_EPSILON    (1500.0f * 0x1p-24f)
#define SURFACE_SHADOW_EPSILON (10.0f * SURFACE_RAY_EPSILON)

/* Works out the point of a hit (hit->shape must not be SCENE_NONE). */
void surface_init(struct surface *s, const struct view *v, const struct ray *r,
                  const struct hit *hit);

/* A point beside the surface on the side of d, from which rays do not meet it again. */
static inline struct vec3 surface_offset(const struct surface *s, struct vec3 d)
{
    float most = max_float(fabsf(s->p.x), max_float(fabsf(s->p.y), fabsf(s->p.z)));
    return vec3_madd(s->p, s->n, copysignf((1.0f + most) * SURFACE_RAY_EPSILON, vec3_dot(s->n, d)));
}

/* A ray from the surface without end. */
static inline struct ray surface_ray(const struct surface *s, struct vec3 d)
{
    return (struct ray){surface_offset(s, d), 0.0f, d, INFINITY};
}

/* A ray from the surface that ends shortly before p. */
static inline struct ray surface_ray_to(const struct surface *s, struct vec3 p)
{
    struct vec3 o = surface_offset(s, vec3_sub(p, s->p)), d = vec3_sub(p, o);
    float distance = vec3_length(d);
    return (struct ray){o, 0.0f, vec3_scale(d, 1.0f / distance),
                        distance * (1.0f - SURFACE_SHADOW_EPSILON)};
}

#endif
