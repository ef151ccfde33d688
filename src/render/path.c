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

/* Light from around the scene that the ray runs into. */
static struct vec3 environment_along(const struct view *v, const struct trace_settings *t,
                                     struct vec3 d, float last_pdf, bool last_is_delta)
{
    struct vec3 sum = {0};
    for (uint32_t i = v->first_environment; i < v->n_lights; i++) {
        const struct light *l = &v->lights[i];
        float w = 1.0f;
        if (!last_is_delta) w = mis_weight(t->mis, last_pdf, light_environment_pdf(v, l, d));
        sum = vec3_madd(sum, light_environment_radiance(v, l, d), w);
    }
    return sum;
}

/* Light of the surface that the ray has hit. */
static struct vec3 surface_along(const struct path *p, const struct view *v,
                                 const struct trace_settings *t)
{
    const struct surface *s = &p->surface;
    struct vec3 radiance = light_surface_radiance(v, s, p->ray.d);
    if (p->last_is_delta || vec3_is_zero(radiance)) return radiance;
    struct vec3 d = vec3_sub(s->p, p->last_p);
    float distance = vec3_length(d);
    float pdf = light_surface_pdf(v, p->last_p, s, vec3_scale(d, 1.0f / distance), distance);
    return vec3_scale(radiance, mis_weight(t->mis, p->last_pdf, pdf));
}

void path_start(struct path *p, const struct ray *primary)
{
    p->ray = *primary;
    p->throughput = vec3_splat(1.0f);
    p->radiance = vec3_splat(0.0f);
    p->last_pdf = p->eta = 1.0f;
    p->last_is_delta = true;
}

bool path_arrive(struct path *p, const struct view *v, const struct trace_settings *t,
                 int32_t depth)
{
    if (t->max_depth == 0) return false;
    bool shows_emitters = depth > 0 || !t->hide_emitters;
    if (p->hit.shape == SCENE_NONE) {
        if (shows_emitters && v->first_environment < v->n_lights) {
            struct vec3 around = environment_along(v, t, p->ray.d, p->last_pdf, p->last_is_delta);
            p->radiance = vec3_add(p->radiance, vec3_mul(p->throughput, around));
        }
        return false;
    }
    struct surface *s = &p->surface;
    surface_init(s, v, &p->ray, &p->hit);
    if (s->shape->emitter != SCENE_NONE && shows_emitters)
        p->radiance = vec3_add(p->radiance, vec3_mul(p->throughput, surface_along(p, v, t)));
    if (t->max_depth >= 0 && depth + 1 >= t->max_depth) return false;
    bsdf_point_init(&p->bsdf, v->materials, v->state.shape_bsdfs[s->shape->index], &v->textures,
                    s->u, s->v, s->wi.z);
    return true;
}

bool path_connect(struct path *p, const struct view *v, const struct trace_settings *t,
                  int32_t depth)
{
    sampler_skip_to(&p->sampler, DIMENSIONS_FILM + (uint32_t)depth * DIMENSIONS_BOUNCE);
    struct vec2 u = sampler_next_2d(&p->sampler);
    struct light_sample l;
    struct vec3 value;
    float pdf;
    const struct surface *s = &p->surface;
    if (!(p->bsdf.lobes & LOBE_SMOOTH) || !light_sample(v, s->p, u.x, u.y, &l)) return false;
    bsdf_eval(&p->bsdf, s->wi, frame_to_local(&s->frame, l.d), &value, &pdf);
    if (vec3_is_zero(value) || vec3_is_zero(l.weight)) return false;
    float w = l.is_delta ? 1.0f : mis_weight(t->mis, l.pdf, pdf);
    p->light = vec3_scale(vec3_mul(vec3_mul(value, l.weight), p->throughput), w);
    p->shadow = l.is_infinite ? surface_ray(s, l.d) : surface_ray_to(s, l.p);
    return true;
}

bool path_scatter(struct path *p, const struct trace_settings *t, int32_t depth)
{
    const struct surface *s = &p->surface;
    struct vec2 u = sampler_next_2d(&p->sampler);
    float u_lobe = sampler_next_1d(&p->sampler), u_roulette = sampler_next_1d(&p->sampler);
    struct bsdf_sample bs = bsdf_sample(&p->bsdf, s->wi, u_lobe, u.x, u.y);
    p->throughput = vec3_mul(p->throughput, bs.weight);
    float most = vec3_max(p->throughput);
    if (!(most > 0.0f)) return false;
    p->eta *= bs.eta;
    if (depth + 1 >= t->rr_depth) {
        float survival = min_float(most * p->eta * p->eta, 0.95f);
        if (u_roulette >= survival) return false;
        p->throughput = vec3_scale(p->throughput, 1.0f / survival);
    }
    p->last_p = s->p;
    p->last_pdf = bs.pdf;
    p->last_is_delta = (bs.lobe & LOBE_DELTA) != 0;
    p->ray = surface_ray(s, frame_to_world(&s->frame, bs.wo));
    return true;
}

struct vec3 path_radiance(struct path *p, const struct view *v, const struct trace_settings *t)
{
    for (int32_t depth = 0; path_arrive(p, v, t, depth); depth++) {
        if (path_connect(p, v, t, depth) && !accel_occluded(v->top, &p->shadow))
            p->radiance = vec3_add(p->radiance, p->light);
        if (!path_scatter(p, t, depth)) break;
        accel_intersect(v->top, &p->ray, false, &p->hit);
    }
    return p->radiance;
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
    if (first->shape == SCENE_NONE) {
        if (!t->hide_emitters)
            put3(buffers + BUFFER_EMISSION, environment_along(v, t, primary->d, 1.0f, true));
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
