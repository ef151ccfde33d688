/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_LIGHT_TABLE_H
#define RENDER_LIGHT_TABLE_H

#include "render/light.h"

/* Samples of the lights in a table (struct light_table), without branches: for vector code and for
 * light_sample() alike. */

/* A row of the table, in this order: LIGHT_FIELDS numbers. */
struct light_element {
    struct vec3 p;            /* a corner, or the centre */
    float per_area;           /* density of the light's points */
    float radius;             /* spheres; 0 for others */
    struct vec3 e0;           /* edges from the corner; a disk's axes */
    struct vec3 e1;           /* */
    struct vec3 n;            /* on the side that shines; unit in tables without LIGHT_TURNS */
    float cdf, scale;         /* probability of the light's elements before, and 1 / its own */
    float is_whole;           /* 1: a parallelogram */
    struct vec3 turn0, turn1; /* how the normal turns along the edges */
    float is_disk;
};

/* How many of the numbers these kinds of elements use. */
static inline uint32_t light_fields(uint32_t kinds)
{
    return kinds == LIGHT_SPHERES  ? 5
           : kinds == LIGHT_DISKS  ? 14
           : kinds == LIGHT_FACES  ? 17
           : kinds == LIGHT_SMOOTH ? 23
                                   : LIGHT_FIELDS;
}

static inline bool light_table_has(const struct light_table *t, uint32_t light)
{
    return t->n > 0 && (t->holds >> light & 1) != 0; /* else there may be more than 32 */
}

/* Whether it holds all lights. */
static inline bool light_table_is_whole(const struct view *v)
{
    return v->table.n > 0 && v->table.holds == UINT32_MAX >> (32 - v->n_lights);
}

/* The part of [0,1) that u lies in, of as many equal ones as a light has elements; any for the u of
 * a lane that is not in use. */
MATH_INLINE int32_t light_table_part(float u, int32_t count)
{
    int32_t part = (int32_t)(u * (float)count);
    part = part < count ? part : count - 1;
    return part > 0 ? part : 0;
}

/* Where a light sample is on a sphere. */
struct sphere_sample {
    struct vec3 n; /* normal of the point */
    float pdf;     /* in solid angle; 0: uniform by area */
};

/* Uniform in the cone that it fills, and from inside uniform by area. */
MATH_INLINE struct sphere_sample light_sphere_sample(struct vec3 center, float radius,
                                                     struct vec3 reference, float u1, float u2)
{
    const struct sphere sphere = {center, radius};
    struct vec3 to_center = vec3_sub(center, reference);
    float sin_max2 = sphere_cone(&sphere, to_center);
    bool is_cone = sin_max2 > 0.0f;
    struct vec3 a = sphere_cone_sample(to_center, sin_max2, u1, u2), b = warp_sphere(u1, u2);
    float pdf = sphere_cone_pdf(sin_max2);
    return (struct sphere_sample){
        vec3(is_cone ? a.x : b.x, is_cone ? a.y : b.y, is_cone ? a.z : b.z), is_cone ? pdf : 0.0f};
}

/* A sample on an element, which u1 has chosen, of a light chosen with probability `choice`. kinds:
 * the table's; on_sphere: for spheres only. */
MATH_INLINE bool light_element_sample(struct light_sample *s, uint32_t kinds,
                                      struct light_element e, struct vec3 radiance,
                                      struct vec3 reference, float u1, float u2, float choice,
                                      struct sphere_sample on_sphere)
{
    struct vec3 n = on_sphere.n, at = vec3_madd(e.p, n, e.radius);
    float cone_pdf = on_sphere.pdf;
    if (kinds != LIGHT_SPHERES) {
        float u = min_float((u1 - e.cdf) * e.scale, 0x1.fffffep-1f);
        if (kinds == LIGHT_DISKS) u = u1; /* each is a light of its own */
        struct vec2 b = {0.0f, 0.0f};
        if (kinds & LIGHT_FACES) {
            struct vec2 half = warp_triangle(u, u2);
            b.x = e.is_whole != 0.0f ? u : half.x;
            b.y = e.is_whole != 0.0f ? u2 : half.y;
        }
        if (kinds & LIGHT_DISKS) {
            struct vec2 disk = warp_disk(u, u2);
            bool is_disk = kinds == LIGHT_DISKS || e.is_disk != 0.0f;
            b.x = is_disk ? disk.x : b.x;
            b.y = is_disk ? disk.y : b.y;
        }
        struct vec3 m = e.n, on_face = vec3_madd(vec3_madd(e.p, e.e0, b.x), e.e1, b.y);
        if (kinds & LIGHT_TURNS)
            m = vec3_normalize(vec3_madd(vec3_madd(e.n, e.turn0, b.x), e.turn1, b.y));
        bool is_sphere = (kinds & LIGHT_SPHERES) && e.radius > 0.0f;
        n.x = is_sphere ? n.x : m.x;
        n.y = is_sphere ? n.y : m.y;
        n.z = is_sphere ? n.z : m.z;
        at.x = is_sphere ? at.x : on_face.x;
        at.y = is_sphere ? at.y : on_face.y;
        at.z = is_sphere ? at.z : on_face.z;
        cone_pdf = is_sphere ? cone_pdf : 0.0f;
    }
    s->p = at;
    return light_sample_finish(s, reference, n, e.per_area, cone_pdf, radiance, choice);
}

/* The same of a light in the table. */
bool light_table_sample(struct light_sample *s, const struct light_table *t, uint32_t light,
                        struct vec3 reference, float u1, float u2, float choice);

#endif
