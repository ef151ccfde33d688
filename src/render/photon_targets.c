/* SPDX-License-Identifier: Apache-2.0 */
/* Where photons are sent: around what may cast light. */
#include "render/photon_targets.h"

#include "render/photon.h"
#include "render/world.h"
#include "scene/bounds.h"

/* Can a material be a caster anywhere? */
static bool may_cast(const struct view *v, uint32_t index)
{
    const struct material *m = &v->materials[index];
    const struct bsdf_place anywhere = {.wi = {0, 0, 1}, .n = {0, 0, 1}};
    struct bsdf_point p;
    if ((m->lobes & LOBE_DIFFUSE) || !(m->lobes & (LOBE_GLOSSY | LOBE_SPECULAR))) return false;
    if (!(m->lobes & LOBE_GLOSSY) || m->has_uv) return true;
    bsdf_point_init(&p, v->materials, index, &v->textures, &anywhere);
    return photon_is_caster(&p);
}

static struct vec3 middle_of(const struct bounds *b)
{
    return vec3_scale(vec3_add(b->min, b->max), 0.5f);
}

static void add_target(struct photon_targets *t, struct vec3 center, float radius)
{
    t->center[t->n] = center;
    t->radius[t->n] = radius * 1.001f;
    t->n++;
}

/* A sphere around a shape of an instance, and the shape's box; radius 0 where there is nothing. */
static float sphere_around(const struct view_instance *i, const struct world_shape *shape,
                           struct bounds *box, struct vec3 *center)
{
    const struct bounds *b = &shape->bounds;
    if (bounds_is_empty(b)) return 0.0f;
    *box = bounds_transform(b, i->to_world);
    float corner = 0.5f * vec3_length(vec3_sub(box->max, box->min));
    float reach = shape->reach * i->scale;
    bool is_tight = i->scale > 0.0f && reach < corner;
    *center = is_tight ? transform_point(i->to_world, middle_of(b)) : middle_of(box);
    return is_tight ? reach : corner;
}

void photon_targets_init(struct photon_targets *t, const struct view *v)
{
    const struct scene *s = v->world->scene;
    struct bounds all = bounds_empty(), scene = scene_bounds(s, &v->state);
    bool is_too_many = false;
    t->n = 0;
    for (uint32_t i = 0; i < s->n_instances; i++) {
        const struct instance *instance = &v->state.instances[i];
        const struct group *g = &s->groups[instance->group];
        for (uint32_t k = 0; k < g->n_shapes && instance->is_visible; k++) {
            const struct world_shape *shape = &v->instances[i].shapes[k];
            if (!may_cast(v, v->state.shape_bsdfs[shape->index])) continue;
            struct bounds b;
            struct vec3 center;
            float radius = sphere_around(&v->instances[i], shape, &b, &center);
            if (!(radius > 0.0f)) continue;
            bounds_add(&all, b.min);
            bounds_add(&all, b.max);
            if (t->n == PHOTON_TARGETS)
                is_too_many = true;
            else
                add_target(t, center, radius);
        }
    }
    if (is_too_many) {
        t->n = 0;
        add_target(t, middle_of(&all), 0.5f * vec3_length(vec3_sub(all.max, all.min)));
    }
    t->scene_center = middle_of(&scene);
    t->scene_radius = 0.5f * vec3_length(vec3_sub(scene.max, scene.min)) * 1.001f;
}

/* ---- Aiming ---------------------------------------------------------------------------------- */

/* 1 - cos of the cone of a sphere seen from p; 2 from inside: all directions. */
static float cone_of(const struct photon_targets *t, uint32_t k, struct vec3 p, struct vec3 *axis)
{
    *axis = vec3_sub(t->center[k], p);
    float d2 = vec3_dot(*axis, *axis), r2 = t->radius[k] * t->radius[k];
    if (d2 <= r2 * 1.0001f) return 2.0f;
    *axis = vec3_scale(*axis, 1.0f / sqrtf(d2));
    float sin2 = r2 / d2;
    return sin2 / (1.0f + sqrtf(1.0f - sin2));
}

struct vec3 photon_targets_from(const struct photon_targets *t, struct vec3 p, struct rng *u,
                                float *pdf)
{
    uint32_t chosen = (uint32_t)(rng_float(u) * (float)t->n);
    if (chosen >= t->n) chosen = t->n - 1;
    struct vec3 axis;
    float height = cone_of(t, chosen, p, &axis), u1 = rng_float(u), u2 = rng_float(u);
    struct vec3 d;
    if (height == 2.0f) {
        d = warp_sphere(u1, u2);
    } else {
        float h = height * u1, sine = sqrtf(h * (2.0f - h)), s, c;
        warp_sincos_turn(u2, &s, &c);
        struct frame f = frame_from_normal(axis);
        d = frame_to_world(&f, vec3(c * sine, s * sine, 1.0f - h));
    }
    *pdf = 0.0f;
    for (uint32_t k = 0; k < t->n; k++) {
        float h = cone_of(t, k, p, &axis);
        bool holds = k == chosen || h == 2.0f || vec3_dot(d, axis) >= 1.0f - h;
        if (holds) *pdf += 0.5f * MATH_INV_PI / h;
    }
    *pdf /= (float)t->n;
    return d;
}

struct vec3 photon_targets_along(const struct photon_targets *t, struct vec3 d, struct rng *u,
                                 float *pdf)
{
    uint32_t chosen = (uint32_t)(rng_float(u) * (float)t->n);
    if (chosen >= t->n) chosen = t->n - 1;
    float u1 = rng_float(u);
    struct vec2 disk = warp_disk(u1, rng_float(u));
    struct frame f = frame_from_normal(d);
    float r = t->radius[chosen];
    struct vec3 p = vec3_madd(vec3_madd(t->center[chosen], f.s, r * disk.x), f.t, r * disk.y);
    *pdf = 0.0f;
    for (uint32_t k = 0; k < t->n; k++) {
        struct vec3 to = vec3_sub(p, t->center[k]);
        struct vec3 across = vec3_madd(to, d, -vec3_dot(to, d));
        bool holds = k == chosen || vec3_dot(across, across) <= t->radius[k] * t->radius[k];
        if (holds) *pdf += MATH_INV_PI / (t->radius[k] * t->radius[k]);
    }
    *pdf /= (float)t->n;
    float back = vec3_dot(vec3_sub(p, t->scene_center), d) + 2.0f * t->scene_radius;
    return vec3_madd(p, d, -back);
}
