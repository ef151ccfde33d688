/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_LIGHT_AROUND_H
#define RENDER_LIGHT_AROUND_H

#include "render/light.h"

/* Directions to environments, without branches: for vector code and for light_environment_sample()
 * alike. */
struct light_around {
    enum emitter_kind kind;
    const struct world_envmap *map; /* SKY, ENVMAP; NULL: shines the same everywhere */
    struct vec3 x, y, z;            /* axes of the map, or around the sun, in world space */
    float scale;                    /* of the map's values */
    struct vec3 radiance;           /* CONSTANT, SUN */
    float sun_height;               /* SUN: 1 - cos of half its aperture */
    struct vec3 up;                 /* SUN: the half of the world that it is seen in */
};

void light_around_init(struct light_around *a, const struct view *v, const struct light *l);

/* Whether vector code can count its map's values. */
static inline bool light_around_is_small(const struct light_around *a)
{
    return !a->map || ((uint64_t)a->map->width + 1) * a->map->height * 3 < INT32_MAX;
}

MATH_INLINE struct vec3 light_around_to_world(const struct light_around *a, struct vec3 d)
{
    return vec3_normalize(vec3_madd(vec3_madd(vec3_scale(a->x, d.x), a->y, d.y), a->z, d.z));
}

/* d, pdf, and radiance as weight. */
MATH_INLINE void light_around_constant(const struct light_around *a, float u1, float u2,
                                       struct light_sample *s)
{
    s->d = warp_sphere(u1, u2);
    s->pdf = WARP_SPHERE_PDF;
    s->weight = a->radiance;
}

MATH_INLINE void light_around_sun(const struct light_around *a, float u1, float u2,
                                  struct light_sample *s)
{
    float h = a->sun_height * u1, sine = sqrtf(h * (2.0f - h)), sin_phi, cos_phi;
    warp_sincos_turn(u2, &sin_phi, &cos_phi);
    s->d = light_around_to_world(a, vec3(cos_phi * sine, sin_phi * sine, 1.0f - h));
    s->pdf = 0.5f * MATH_INV_PI / a->sun_height;
    bool is_up = vec3_dot(s->d, a->up) >= 0.0f;
    s->weight.x = is_up ? a->radiance.x : 0.0f;
    s->weight.y = is_up ? a->radiance.y : 0.0f;
    s->weight.z = is_up ? a->radiance.z : 0.0f;
}

/* Of a place in a cell of the map, which was chosen with this density on the unit square; nodes:
 * the map's values around it. */
MATH_INLINE void light_around_map(const struct light_around *a, int32_t column, int32_t row,
                                  float u, float v, float density, const struct vec3 nodes[4],
                                  struct light_sample *s)
{
    const struct world_envmap *e = a->map;
    float sin_phi, cos_phi, sin_theta, cos_theta;
    float x = min_float(((float)column + u) / (float)e->width, 0x1.fffffep-1f);
    float y = min_float(((float)row + v) / (float)(e->height - 1), 0x1.fffffep-1f);
    warp_sincos_turn(x + 0.5f / (float)e->width, &sin_phi, &cos_phi);
    warp_sincos_turn(y * e->span * (0.5f * MATH_INV_PI), &sin_theta, &cos_theta);
    s->d = light_around_to_world(a, vec3(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta));
    s->pdf = density * envmap_density(e, sin_theta);
    struct vec3 top = vec3_madd(vec3_scale(nodes[0], 1.0f - u), nodes[1], u);
    struct vec3 bottom = vec3_madd(vec3_scale(nodes[2], 1.0f - u), nodes[3], u);
    s->weight = vec3_scale(vec3_madd(vec3_scale(top, 1.0f - v), bottom, v), a->scale);
}

#endif
