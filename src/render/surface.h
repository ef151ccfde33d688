/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_SURFACE_H
#define RENDER_SURFACE_H

#include "render/world.h"

/* A point on a surface in world space. */
struct surface {
    struct vec3 p;
    struct vec3 n;            /* geometric normal, unit, on the shape's outer side */
    struct frame frame;       /* shading frame */
    struct vec3 wi;           /* against the ray, in the shading frame */
    float u, v;               /* texture coordinates */
    struct vec3 dp_du, dp_dv; /* materials with tangents only */
    float t;                  /* along the ray */
    const struct world_shape *shape;
    uint32_t instance, primitive;
    float b1, b2; /* meshes: barycentric coordinates, as struct mesh_place */
};

/* Offsets against self-intersection, as Mitsuba: relative to the largest coordinate. */
#define SURFACE_RAY_EPSILON    (1500.0f * 0x1p-24f)
#define SURFACE_SHADOW_EPSILON (10.0f * SURFACE_RAY_EPSILON)

/* Works out the point of a hit (hit->shape must not be SCENE_NONE). */
void surface_init(struct surface *s, const struct view *v, const struct ray *r,
                  const struct hit *hit);

/* The material there. */
void surface_bsdf(const struct surface *s, const struct view *v, struct bsdf_point *out);

/* The same in two steps, of which streams take the second for many points at once. The first reads
 * the scene: it leaves normals at any length, both n and frame.n, and for materials that have a
 * direction dp/du in frame.s. */
void surface_fetch(struct surface *s, const struct view *v, const struct ray *r,
                   const struct hit *hit);

/* Of a value at each vertex, the value at a triangle's point: a (1-u-v) + b u + c v. */
static inline struct vec3 surface_interpolate(const float *values, const uint32_t *at, float u,
                                              float v)
{
    return vec3_madd(vec3_madd(vec3_scale(vec3_load(values + 3 * (size_t)at[0]), 1.0f - u - v),
                               vec3_load(values + 3 * (size_t)at[1]), u),
                     vec3_load(values + 3 * (size_t)at[2]), v);
}

static inline struct vec2 surface_uv(const float *uvs, const uint32_t *at, float u, float v)
{
    const float *a = uvs + 2 * (size_t)at[0], *b = uvs + 2 * (size_t)at[1],
                *c = uvs + 2 * (size_t)at[2];
    float w = 1.0f - u - v;
    return (struct vec2){a[0] * w + b[0] * u + c[0] * v, a[1] * w + b[1] * u + c[1] * v};
}

/* Normals to unit length. Shading normals that cancel out (bad files) fall back to the face's. */
static inline void surface_normals(struct vec3 *n, struct vec3 *shading)
{
    float length2 = vec3_dot(*shading, *shading), scale = 1.0f / sqrtf(length2);
    bool is_usable = length2 > 1e-20f;
    *n = vec3_normalize(*n);
    shading->x = is_usable ? shading->x * scale : n->x;
    shading->y = is_usable ? shading->y * scale : n->y;
    shading->z = is_usable ? shading->z * scale : n->z;
}

/* A frame around n whose s lies along dp/du, for materials that have a direction; any frame where
 * there is none. */
struct frame surface_frame_along(struct vec3 n, struct vec3 dp_du);

/* What a material wants to know. */
static inline struct bsdf_place surface_place(const struct surface *s, const struct material *m)
{
    struct bsdf_place at = {.u = s->u, .v = s->v, .wi = s->wi};
    if (m->has_attributes)
        at.mesh = (struct mesh_place){s->shape->mesh, s->primitive, s->b1, s->b2};
    if (!m->has_tangents) return at;
    at.n = frame_to_local(&s->frame, s->n);
    at.dp_du = frame_to_local(&s->frame, s->dp_du);
    at.dp_dv = frame_to_local(&s->frame, s->dp_dv);
    return at;
}

/* A point beside the surface point p with normal n, on the side of d, from which rays do not meet
 * the surface again. */
static inline struct vec3 surface_offset(struct vec3 p, struct vec3 n, struct vec3 d)
{
    float most = max_float(fabsf(p.x), max_float(fabsf(p.y), fabsf(p.z)));
    return vec3_madd(p, n, copysignf((1.0f + most) * SURFACE_RAY_EPSILON, vec3_dot(n, d)));
}

/* A ray from the surface point p with normal n, without end. */
static inline struct ray surface_ray(struct vec3 p, struct vec3 n, struct vec3 d)
{
    return (struct ray){surface_offset(p, n, d), 0.0f, d, INFINITY};
}

/* A ray from there that ends shortly before `end`. */
static inline struct ray surface_ray_to(struct vec3 p, struct vec3 n, struct vec3 end)
{
    struct vec3 o = surface_offset(p, n, vec3_sub(end, p)), d = vec3_sub(end, o);
    float distance = vec3_length(d);
    return (struct ray){o, 0.0f, vec3_scale(d, 1.0f / distance),
                        distance * (1.0f - SURFACE_SHADOW_EPSILON)};
}

#endif
