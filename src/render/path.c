/* SPDX-License-Identifier: Apache-2.0 */
#include "render/path.h"

#include "render/bsdf.h"
#include "render/light.h"

/* Random numbers per bounce: light 2, bsdf 3, roulette 1. The film has the first two. */
enum { DIMENSIONS_FILM = 2, DIMENSIONS_BOUNCE = 6 };

/* The share of a strategy of density a beside one of density b. */
static inline float mis_weight(enum mis_kind kind, float a, float b)
{
    if (kind == MIS_POWER) {
        a *= a;
        b *= b;
    }
    float w = a / (a + b);
    return isfinite(w) ? w : 0.0f;
}

/* What the path remembers of its last bounce. */
struct last_bounce {
    struct vec3 p;
    float pdf;
    bool is_delta; /* no light sample could have found the direction */
};

/* Light from around the scene that the ray runs into. */
static struct vec3 environment_along(const struct view *v, const struct trace_settings *t,
                                     const struct ray *r, const struct last_bounce *last)
{
    struct vec3 sum = {0};
    for (uint32_t i = v->first_environment; i < v->n_lights; i++) {
        const struct light *l = &v->lights[i];
        float w = 1.0f;
        if (!last->is_delta) w = mis_weight(t->mis, last->pdf, light_environment_pdf(v, l, r->d));
        sum = vec3_madd(sum, light_environment_radiance(v, l, r->d), w);
    }
    return sum;
}

/* Light of the surface that the ray has hit. */
static struct vec3 surface_along(const struct view *v, const struct trace_settings *t,
                                 const struct ray *r, const struct surface *s,
                                 const struct last_bounce *last)
{
    struct vec3 radiance = light_surface_radiance(v, s, r->d);
    if (last->is_delta || vec3_is_zero(radiance)) return radiance;
    struct vec3 d = vec3_sub(s->p, last->p);
    float distance = vec3_length(d);
    float pdf = light_surface_pdf(v, last->p, s, vec3_scale(d, 1.0f / distance), distance);
    return vec3_scale(radiance, mis_weight(t->mis, last->pdf, pdf));
}

/* Light that reaches the surface straight from a light chosen for it. */
static struct vec3 direct_light(const struct view *v, const struct trace_settings *t,
                                const struct surface *s, const struct bsdf_point *b, struct vec2 u)
{
    struct light_sample l;
    struct vec3 none = {0}, value;
    float pdf;
    if (!light_sample(v, s->p, u.x, u.y, &l)) return none;
    bsdf_eval(b, s->wi, frame_to_local(&s->frame, l.d), &value, &pdf);
    if (vec3_is_zero(value) || vec3_is_zero(l.weight)) return none;
    struct ray shadow = l.is_infinite ? surface_ray(s, l.d) : surface_ray_to(s, l.p);
    if (accel_occluded(v->top, &shadow)) return none;
    float w = l.is_delta ? 1.0f : mis_weight(t->mis, l.pdf, pdf);
    return vec3_scale(vec3_mul(value, l.weight), w);
}

struct vec3 path_radiance(const struct view *v, const struct trace_settings *t,
                          const struct ray *primary, const struct hit *first,
                          struct sampler *sampler)
{
    struct vec3 radiance = {0}, throughput = vec3_splat(1.0f);
    struct last_bounce last = {.pdf = 1.0f, .is_delta = true};
    struct ray ray = *primary;
    struct hit hit = *first;
    float eta = 1.0f; /* product of relative indices: undoes the scaling of radiance in roulette */
    if (t->max_depth == 0) return radiance;

    for (int32_t depth = 0;; depth++) {
        bool shows_emitters = depth > 0 || !t->hide_emitters;
        if (hit.shape == SCENE_NONE) {
            if (shows_emitters && v->first_environment < v->n_lights)
                radiance = vec3_add(radiance,
                                    vec3_mul(throughput, environment_along(v, t, &ray, &last)));
            break;
        }
        struct surface s;
        surface_init(&s, v, &ray, &hit);
        if (s.shape->emitter != SCENE_NONE && shows_emitters)
            radiance = vec3_add(radiance,
                                vec3_mul(throughput, surface_along(v, t, &ray, &s, &last)));
        if (t->max_depth >= 0 && depth + 1 >= t->max_depth) break;

        struct bsdf_point b;
        bsdf_point_init(&b, v->materials, v->state.shape_bsdfs[s.shape->index], &v->textures, s.u,
                        s.v, s.wi.z);
        sampler_skip_to(sampler, DIMENSIONS_FILM + (uint32_t)depth * DIMENSIONS_BOUNCE);
        struct vec2 u_light = sampler_next_2d(sampler);
        if (b.lobes & LOBE_SMOOTH)
            radiance = vec3_add(radiance,
                                vec3_mul(throughput, direct_light(v, t, &s, &b, u_light)));

        struct vec2 u_direction = sampler_next_2d(sampler);
        float u_lobe = sampler_next_1d(sampler);
        struct bsdf_sample bs = bsdf_sample(&b, s.wi, u_lobe, u_direction.x, u_direction.y);
        throughput = vec3_mul(throughput, bs.weight);
        float most = vec3_max(throughput);
        if (!(most > 0.0f)) break;
        eta *= bs.eta;

        float u_roulette = sampler_next_1d(sampler);
        if (depth + 1 >= t->rr_depth) {
            float survival = fminf(most * eta * eta, 0.95f);
            if (u_roulette >= survival) break;
            throughput = vec3_scale(throughput, 1.0f / survival);
        }
        last = (struct last_bounce){s.p, bs.pdf, (bs.lobe & LOBE_DELTA) != 0};
        ray = surface_ray(&s, frame_to_world(&s.frame, bs.wo));
        accel_intersect(v->top, &ray, false, &hit);
    }
    return radiance;
}

static void put3(float *to, struct vec3 v)
{
    to[0] += v.x;
    to[1] += v.y;
    to[2] += v.z;
}

/* The paper's encoding of the direction to the camera: in a frame whose tangent comes from a fixed
 * vector (method notes 1.2), with |z| and x, y moved to [0,1]. */
static struct vec3 encode_direction(struct vec3 n, struct vec3 d)
{
    const float third = 0.57735026918962576451f;
    struct vec3 fixed = vec3_splat(third);
    struct vec3 s = vec3_madd(fixed, n, -vec3_dot(n, fixed));
    float length = vec3_length(s);
    struct frame f = frame_from_normal(n);
    if (length > 1e-4f) {
        f.s = vec3_scale(s, 1.0f / length);
        f.t = vec3_cross(n, f.s);
    }
    struct vec3 local = frame_to_local(&f, d);
    return vec3(0.5f * (local.x + 1.0f), 0.5f * (local.y + 1.0f), fabsf(local.z));
}

void path_add_buffers(const struct view *v, const struct trace_settings *t,
                      const struct ray *primary, float offset, const struct hit *first,
                      float *buffers)
{
    const struct last_bounce camera = {.pdf = 1.0f, .is_delta = true};
    if (first->shape == SCENE_NONE) {
        if (!t->hide_emitters)
            put3(buffers + BUFFER_EMISSION, environment_along(v, t, primary, &camera));
        return;
    }
    struct surface s;
    struct bsdf_point b;
    surface_init(&s, v, primary, first);
    bsdf_point_init(&b, v->materials, v->state.shape_bsdfs[s.shape->index], &v->textures, s.u, s.v,
                    s.wi.z);
    struct vec3 wo = vec3_neg(primary->d);
    put3(buffers + BUFFER_POSITION, s.p);
    put3(buffers + BUFFER_NORMAL, s.frame.n);
    put3(buffers + BUFFER_GEO_NORMAL, s.n);
    put3(buffers + BUFFER_ALBEDO, bsdf_albedo(&b));
    buffers[BUFFER_ROUGHNESS] += bsdf_roughness(&b);
    put3(buffers + BUFFER_WO, wo);
    if (b.kind != BSDF_DIFFUSE) put3(buffers + BUFFER_WI, encode_direction(s.frame.n, wo));
    if (!t->hide_emitters)
        put3(buffers + BUFFER_EMISSION, light_surface_radiance(v, &s, primary->d));
    buffers[BUFFER_DEPTH] += s.t + offset;
}
