/* SPDX-License-Identifier: Apache-2.0 */
/* Photons on their way: from lights towards casters, over these, to the first receiver. */
#include "base/pool.h"
#include "render/light.h"
#include "render/path.h"
#include "render/photon.h"
#include "scene/bounds.h"

enum { MAX_TARGETS = 32, CHUNK = 1024, ROULETTE_FROM = 4, MAX_BOUNCES = 64 };

/* Spheres around casters; photons start towards one of them, chosen with equal chances. */
struct targets {
    uint32_t n;
    struct vec3 center[MAX_TARGETS];
    float radius[MAX_TARGETS];
    struct vec3 scene_center;
    float scene_radius;
};

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

static void add_target(struct targets *t, const struct bounds *b)
{
    t->center[t->n] = vec3_scale(vec3_add(b->min, b->max), 0.5f);
    t->radius[t->n] = 0.5f * vec3_length(vec3_sub(b->max, b->min)) * 1.001f;
    t->n++;
}

static void targets_init(struct targets *t, const struct view *v)
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
            struct bounds b = bounds_transform(&shape->bounds, v->instances[i].to_world);
            if (bounds_is_empty(&b)) continue;
            bounds_add(&all, b.min);
            bounds_add(&all, b.max);
            if (t->n == MAX_TARGETS)
                is_too_many = true;
            else
                add_target(t, &b);
        }
    }
    if (is_too_many) {
        t->n = 0;
        add_target(t, &all);
    }
    t->scene_center = vec3_scale(vec3_add(scene.min, scene.max), 0.5f);
    t->scene_radius = 0.5f * vec3_length(vec3_sub(scene.max, scene.min)) * 1.001f;
}

/* ---- Starting -------------------------------------------------------------------------------- */

/* 1 - cos of the cone of a sphere seen from p; 2 from inside: all directions. */
static float cone_of(const struct targets *t, uint32_t k, struct vec3 p, struct vec3 *axis)
{
    *axis = vec3_sub(t->center[k], p);
    float d2 = vec3_dot(*axis, *axis), r2 = t->radius[k] * t->radius[k];
    if (d2 <= r2 * 1.0001f) return 2.0f;
    *axis = vec3_scale(*axis, 1.0f / sqrtf(d2));
    float sin2 = r2 / d2;
    return sin2 / (1.0f + sqrtf(1.0f - sin2));
}

/* A direction from p into one of the cones, and its density: that of all cones that hold it. */
static struct vec3 aim_from(const struct targets *t, struct vec3 p, struct rng *u, float *pdf)
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

/* A point from which a ray along d runs through one of the spheres, and its density per area
 * across d. */
static struct vec3 aim_along(const struct targets *t, struct vec3 d, struct rng *u, float *pdf)
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

/* A photon's first ray, and its power before the division by the number of photons. */
static bool emit(const struct view *v, const struct targets *t, struct rng *u, struct ray *ray,
                 struct vec3 *power)
{
    float u1 = rng_float(u), u2, pdf, choice;
    const struct light *l = &v->lights[light_choose(v, t->center[0], &u1, &choice)];
    u1 = rng_float(u);
    u2 = rng_float(u);
    if (emitter_is_surface(l->kind)) {
        struct light_point a;
        light_point_sample(v, l, u1, u2, &a);
        if (l->kind == EMITTER_DIRECTIONAL_AREA) { /* along its normals, power per area */
            *power = vec3_scale(a.radiance, 1.0f / (choice * a.pdf));
            *ray = surface_ray(a.p, a.n, a.n);
            return true;
        }
        struct vec3 d = aim_from(t, a.p, u, &pdf);
        float cosine = vec3_dot(d, a.n);
        if (!(cosine > 0.0f)) return false;
        *power = vec3_scale(a.radiance, cosine / (choice * a.pdf * pdf));
        *ray = surface_ray(a.p, a.n, d);
        return true;
    }
    struct light_sample s = {0};
    if (emitter_is_environment(l->kind)) {
        if (!light_environment_sample(v, l, u1, u2, &s) || !(s.pdf > 0.0f)) return false;
    } else if (!light_sample_delta(v, l, t->scene_center, &s) || !s.is_infinite) {
        /* From a point: intensity is what arrives at distance 1. */
        struct vec3 p = transform_point(&v->state.emitters[l->emitter].to_world, vec3_splat(0.0f));
        struct vec3 d = aim_from(t, p, u, &pdf);
        if (!light_sample_delta(v, l, vec3_add(p, d), &s)) return false;
        *power = vec3_scale(s.weight, 1.0f / (choice * s.pdf * pdf));
        *ray = (struct ray){p, 0.0f, d, INFINITY};
        return true;
    }
    struct vec3 d = vec3_neg(s.d), p = aim_along(t, d, u, &pdf);
    *power = vec3_scale(s.weight, 1.0f / (choice * s.pdf * pdf));
    *ray = (struct ray){p, 0.0f, d, INFINITY};
    return true;
}

/* ---- Flying ---------------------------------------------------------------------------------- */

/* Shading normals make scattering asymmetric (Veach 1997, 5.3): what radiance has weighed, flux has
 * to undo. Refraction likewise compresses radiance, not flux. */
static float flux_correction(const struct surface *s, const struct bsdf_sample *b, struct vec3 wi,
                             struct vec3 wo)
{
    float up = fabsf(s->wi.z * vec3_dot(wo, s->n));
    float down = fabsf(b->wo.z * vec3_dot(wi, s->n));
    return down > 0.0f ? b->eta * b->eta * up / down : 0.0f;
}

static void fly(const struct view *v, const struct targets *t, const struct trace_settings *set,
                struct rng *u, float share, struct photon *out)
{
    struct ray ray;
    struct vec3 power;
    out->n_casters = 0;
    if (!emit(v, t, u, &ray, &power)) return;
    power = vec3_scale(power, share);
    uint32_t n_casters = 0;
    for (uint32_t bounce = 0; bounce < MAX_BOUNCES; bounce++) {
        struct hit hit;
        struct surface s;
        struct bsdf_point b;
        accel_intersect(v->top, &ray, &hit);
        if (hit.shape == SCENE_NONE) return;
        surface_init(&s, v, &ray, &hit);
        uint32_t material = v->state.shape_bsdfs[s.shape->index];
        const struct bsdf_place at = surface_place(&s, &v->materials[material]);
        bsdf_point_init(&b, v->materials, material, &v->textures, &at);
        bool is_caster = photon_is_caster(&b);
        if (!is_caster && (b.lobes & LOBE_SMOOTH)) {
            if (b.opacity < 1.0f && rng_float(u) >= b.opacity) {
                ray = surface_ray(s.p, s.n, ray.d); /* straight through */
                continue;
            }
            if (n_casters > 0 && vec3_is_finite(power)) {
                power = vec3_scale(power, 1.0f / b.opacity);
                *out = (struct photon){s.p, vec3_neg(ray.d), s.n, power, n_casters};
            }
            return;
        }
        float u_lobe = rng_float(u), u1 = rng_float(u);
        struct bsdf_sample bs = bsdf_sample(&b, s.wi, u_lobe, u1, rng_float(u));
        if (!(vec3_max(bs.weight) > 0.0f)) return;
        struct vec3 wo = frame_to_world(&s.frame, bs.wo);
        if (!(bs.lobe & LOBE_NULL)) {
            n_casters++;
            if (set->max_depth >= 0 && (int32_t)n_casters + 2 > set->max_depth) return;
            power = vec3_scale(power, flux_correction(&s, &bs, vec3_neg(ray.d), wo));
        }
        power = vec3_mul(power, bs.weight);
        if (bounce >= ROULETTE_FROM) {
            float survival = min_float(vec3_max(bs.weight), 0.95f);
            if (rng_float(u) >= survival) return;
            power = vec3_scale(power, 1.0f / survival);
        }
        ray = surface_ray(s.p, s.n, wo);
    }
}

struct flight {
    struct photon_map *map;
    const struct view *view;
    const struct trace_settings *settings;
    struct targets targets;
    uint64_t key;
};

static void fly_chunk(void *ctx, uint32_t item, uint32_t worker)
{
    const struct flight *f = ctx;
    uint32_t end = (item + 1) * CHUNK < f->map->n_emitted ? (item + 1) * CHUNK : f->map->n_emitted;
    (void)worker;
    for (uint32_t i = item * CHUNK; i < end; i++) {
        struct rng u = rng_keyed(f->settings->seed, f->key, i);
        fly(f->view, &f->targets, f->settings, &u, 1.0f / (float)f->map->n_emitted,
            &f->map->landed[i]);
    }
}

void photon_map_trace(struct photon_map *m, const struct view *v, struct pool *pool,
                      const struct trace_settings *t, uint64_t key)
{
    struct flight f = {.map = m, .view = v, .settings = t, .key = key};
    targets_init(&f.targets, v);
    for (uint32_t i = 0; i < m->n_emitted; i++) m->landed[i].n_casters = 0;
    if (f.targets.n == 0 || v->n_lights == 0) return;
    pool_run(pool, (m->n_emitted + CHUNK - 1) / CHUNK, fly_chunk, &f);
}
