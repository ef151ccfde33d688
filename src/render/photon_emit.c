/* SPDX-License-Identifier: Apache-2.0 */
/* Photons on their way: from lights towards casters, over these, to the first receiver. */
#include "base/pool.h"
#include "render/light.h"
#include "render/path.h"
#include "render/photon.h"
#include "render/photon_targets.h"

/* Keeps their random numbers apart from those of paths. */
#define STREAM_PHOTONS 0x70686F746F6E7321u

enum { CHUNK = 1024, ROULETTE_FROM = 4, MAX_BOUNCES = 64 };

/* ---- Starting -------------------------------------------------------------------------------- */

/* How a photon starts; power before the division by the number of photons. */
struct start {
    struct ray ray;
    struct vec3 power;
    uint32_t emitter;
    float radiance, extent; /* of the light, and its solid angle, at distance 1 unless is_far */
    bool is_far;
};

/* Lights without extent: small and bright. */
#define SMALL 1e-9f

static bool emit(const struct view *v, const struct photon_targets *t, struct rng *u,
                 struct start *s)
{
    float u1 = rng_float(u), u2, pdf, choice;
    const struct light *l = &v->lights[light_choose(v, t->center[0], &u1, &choice)];
    s->emitter = l->emitter;
    s->extent = SMALL;
    s->is_far = false;
    u1 = rng_float(u);
    u2 = rng_float(u);
    if (emitter_is_surface(l->kind)) {
        struct light_point a;
        light_point_sample(v, l, u1, u2, &a);
        if (l->kind == EMITTER_DIRECTIONAL_AREA) { /* along its normals, power per area */
            s->power = vec3_scale(a.radiance, 1.0f / (choice * a.pdf));
            s->radiance = vec3_max(a.radiance) / SMALL;
            s->is_far = true;
            s->ray = surface_ray(a.p, a.n, a.n);
            return true;
        }
        struct vec3 d = photon_targets_from(t, a.p, u, &pdf);
        float cosine = vec3_dot(d, a.n);
        if (!(cosine > 0.0f)) return false;
        s->power = vec3_scale(a.radiance, cosine / (choice * a.pdf * pdf));
        s->radiance = vec3_max(a.radiance);
        s->extent = cosine / a.pdf;
        s->ray = surface_ray(a.p, a.n, d);
        return true;
    }
    struct light_sample from = {0};
    if (emitter_is_environment(l->kind)) {
        if (!light_environment_sample(v, l, u1, u2, &from) || !(from.pdf > 0.0f)) return false;
        s->extent = 1.0f / from.pdf;
    } else if (!light_sample_delta(v, l, t->scene_center, &from) || !from.is_infinite) {
        /* From a point: intensity is what arrives at distance 1. */
        struct vec3 p = transform_point(&v->state.emitters[l->emitter].to_world, vec3_splat(0.0f));
        struct vec3 d = photon_targets_from(t, p, u, &pdf);
        if (!light_sample_delta(v, l, vec3_add(p, d), &from)) return false;
        s->power = vec3_scale(from.weight, 1.0f / (choice * from.pdf * pdf));
        s->radiance = vec3_max(from.weight) / SMALL;
        s->ray = (struct ray){p, 0.0f, d, INFINITY};
        return true;
    }
    s->radiance = vec3_max(from.weight) / (emitter_is_environment(l->kind) ? 1.0f : SMALL);
    s->is_far = true;
    struct vec3 d = vec3_neg(from.d), p = photon_targets_along(t, d, u, &pdf);
    s->power = vec3_scale(from.weight, 1.0f / (choice * from.pdf * pdf));
    s->ray = (struct ray){p, 0.0f, d, INFINITY};
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

/* What a path carries that finds the light over casters of this roughness by chance: the light's
 * radiance, less where samples of the light find it before, in a lobe wider than it is. */
static float peak_of(const struct start *s, float alpha, float distance)
{
    float extent = s->is_far ? s->extent : s->extent / (distance * distance);
    float lobe = 4.0f * MATH_PI * alpha * alpha;
    if (s->extent == SMALL && !(lobe > 0.0f)) return INFINITY;
    return s->radiance * extent / (extent + lobe);
}

static void fly(const struct view *v, const struct photon_targets *t,
                const struct trace_settings *set, struct rng *u, float share, struct photon *out)
{
    struct start start;
    out->n_casters = 0;
    if (!emit(v, t, u, &start)) return;
    struct ray ray = start.ray;
    struct vec3 power = vec3_scale(start.power, share);
    uint32_t n_casters = 0;
    float alpha = 0.0f, distance = 0.0f; /* of casters; to the first */
    for (uint32_t bounce = 0; bounce < MAX_BOUNCES; bounce++) {
        struct hit hit;
        struct surface s;
        struct bsdf_point b;
        accel_intersect(v->top, &ray, &hit);
        if (hit.shape == SCENE_NONE) return;
        surface_init(&s, v, &ray, &hit);
        surface_bsdf(&s, v, &b);
        bool is_caster = photon_is_caster(&b);
        if (!is_caster && (b.lobes & LOBE_SMOOTH)) {
            if (b.opacity < 1.0f && rng_float(u) >= b.opacity) {
                ray = surface_ray(s.p, s.n, ray.d); /* straight through */
                continue;
            }
            if (n_casters > 0 && vec3_is_finite(power)) {
                power = vec3_scale(power, 1.0f / b.opacity);
                *out = (struct photon){.p = s.p,
                                       .n = s.n,
                                       .wo = vec3_neg(ray.d),
                                       .power = power,
                                       .n_casters = n_casters,
                                       .emitter = start.emitter,
                                       .peak = peak_of(&start, alpha, distance)};
            }
            return;
        }
        float u_lobe = rng_float(u), u1 = rng_float(u);
        struct bsdf_sample bs = bsdf_sample(&b, s.wi, u_lobe, u1, rng_float(u));
        if (!(vec3_max(bs.weight) > 0.0f)) return;
        struct vec3 wo = frame_to_world(&s.frame, bs.wo);
        if (!(bs.lobe & LOBE_NULL)) {
            if (n_casters++ == 0) distance = s.t;
            if (!(bs.lobe & LOBE_SPECULAR)) alpha = max_float(alpha, bsdf_roughness(&b));
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
    struct photon_targets targets;
    uint64_t key;
};

static void fly_chunk(void *ctx, uint32_t item, uint32_t worker)
{
    const struct flight *f = ctx;
    uint32_t end = (item + 1) * CHUNK < f->map->n_emitted ? (item + 1) * CHUNK : f->map->n_emitted;
    (void)worker;
    for (uint32_t i = item * CHUNK; i < end; i++) {
        struct rng u = rng_keyed(f->settings->seed ^ STREAM_PHOTONS, f->key, i);
        fly(f->view, &f->targets, f->settings, &u, 1.0f / (float)f->map->n_emitted,
            &f->map->landed[i]);
    }
}

void photon_map_trace(struct photon_map *m, const struct view *v, struct pool *pool,
                      const struct trace_settings *t, uint64_t key)
{
    struct flight f = {.map = m, .view = v, .settings = t, .key = key};
    photon_targets_init(&f.targets, v);
    for (uint32_t i = 0; i < m->n_emitted; i++) m->landed[i].n_casters = 0;
    if (f.targets.n == 0 || v->n_lights == 0) return;
    uint32_t n_chunks = (m->n_emitted + CHUNK - 1) / CHUNK;
    if (pool)
        pool_run(pool, n_chunks, fly_chunk, &f);
    else
        for (uint32_t i = 0; i < n_chunks; i++) fly_chunk(&f, i, 0);
}
