/* SPDX-License-Identifier: Apache-2.0 */
#include "render/path.h"

#include "render/bsdf.h"
#include "render/light.h"
#include "render/photon.h"

struct vec3 path_environment(const struct view *v, const struct trace_settings *t,
                             const struct path *p, const struct light *l, struct vec3 d)
{
    struct vec3 radiance = light_environment_radiance(v, l, d);
    if (p->last_is_delta) return radiance;
    float pdf = light_environment_pdf(v, l, p->last_p, d);
    return vec3_scale(radiance, path_mis_weight(t->mis, p->last_pdf, pdf));
}

struct vec3 path_emission(const struct view *v, const struct trace_settings *t,
                          const struct path *p, const struct surface *s, struct vec3 d)
{
    struct vec3 radiance = light_surface_radiance(v, s, d);
    if (p->last_is_delta || vec3_is_zero(radiance)) return radiance;
    struct vec3 to = vec3_sub(s->p, p->last_p);
    float distance = vec3_length(to);
    float pdf = light_surface_pdf(v, p->last_p, s, vec3_scale(to, 1.0f / distance), distance);
    return vec3_scale(radiance, path_mis_weight(t->mis, p->last_pdf, pdf));
}

/* Adds the light of one sample of the lights, where nothing is in its way. */
static void connect(struct path *p, const struct view *v, const struct trace_settings *t,
                    const struct surface *s, const struct bsdf_point *bsdf, struct vec2 u,
                    float u_roulette)
{
    struct light_sample l;
    struct vec3 value;
    float pdf;
    if (!(bsdf->lobes & LOBE_SMOOTH) || !light_sample(v, s->p, u.x, u.y, &l)) return;
    bsdf_eval(bsdf, s->wi, frame_to_local(&s->frame, l.d), &value, &pdf);
    if (vec3_is_zero(value) || vec3_is_zero(l.weight)) return;
    float w = l.is_delta ? 1.0f : path_mis_weight(t->mis, l.pdf, pdf);
    struct vec3 light = vec3_scale(vec3_mul(vec3_mul(value, l.weight), p->throughput), w);
    if (view_saves_rays(v)) {
        float chance = path_light_chance(vec3_max(p->radiance), light);
        if (path_lower_bits(u_roulette) >= chance) return;
        light = vec3_scale(light, 1.0f / chance);
    }
    struct ray shadow = l.is_infinite ? surface_ray(s->p, s->n, l.d)
                                      : surface_ray_to(s->p, s->n, l.p);
    if (!accel_occluded(v->top, &shadow)) p->radiance = vec3_add(p->radiance, light);
}

/* Chooses how the path goes on; false when it ends. */
static bool scatter(struct path *p, const struct trace_settings *t, int32_t depth,
                    const struct surface *s, const struct bsdf_sample *b, float u_roulette,
                    struct ray *ray)
{
    p->throughput = vec3_mul(p->throughput, b->weight);
    float most = vec3_max(p->throughput);
    if (!(most > 0.0f)) return false;
    p->eta *= b->eta;
    if (depth + 1 >= t->rr_depth) {
        float survival = path_survival(most, p->eta);
        if (u_roulette >= survival) return false;
        p->throughput = vec3_scale(p->throughput, 1.0f / survival);
    }
    p->last_p = s->p;
    p->last_pdf = b->pdf;
    p->last_is_delta = (b->lobe & LOBE_DELTA) != 0;
    *ray = surface_ray(s->p, s->n, frame_to_world(&s->frame, b->wo));
    return true;
}

struct ray path_start(const struct camera *c, float x, float y, struct sampler *sampler,
                      float *offset)
{
    if (c->kind != SENSOR_THINLENS) return camera_ray_any(c, x, y, 0.0f, 0.0f, offset);
    sampler_skip_to(sampler, PATH_DIMENSION_LENS);
    struct vec2 u = sampler_next_2d(sampler);
    return camera_ray_any(c, x, y, u.x, u.y, offset);
}

struct vec3 path_radiance(const struct view *v, const struct trace_settings *t,
                          const struct ray *primary, const struct hit *first,
                          const struct photon_map *photons, struct sampler *sampler)
{
    struct path p = {.throughput = {1, 1, 1}, .last_pdf = 1.0f, .last_is_delta = true, .eta = 1.0f};
    struct ray ray = *primary;
    struct hit hit = *first;
    for (int32_t depth = 0; t->max_depth != 0; depth++) {
        bool shows_emitters = (depth > 0 || !t->hide_emitters) && p.met != PATH_CAUSTIC;
        if (hit.shape == SCENE_NONE) {
            for (uint32_t i = v->first_environment; shows_emitters && i < v->n_lights; i++) {
                struct vec3 around = path_environment(v, t, &p, &v->lights[i], ray.d);
                p.radiance = vec3_add(p.radiance, vec3_mul(p.throughput, around));
            }
            break;
        }
        struct surface s;
        surface_init(&s, v, &ray, &hit);
        if (s.shape->emitter != SCENE_NONE && shows_emitters) {
            struct vec3 emission = path_emission(v, t, &p, &s, ray.d);
            p.radiance = vec3_add(p.radiance, vec3_mul(p.throughput, emission));
        }
        if (t->max_depth >= 0 && depth + 1 >= t->max_depth) break;
        struct bsdf_point bsdf;
        surface_bsdf(&s, v, &bsdf);
        bool is_caster = photons && photon_is_caster(&bsdf);
        if (photons && !is_caster) {
            const struct photon_receiver at_s = {
                .p = s.p, .n = s.n, .frame = s.frame, .wi = s.wi, .bsdf = &bsdf};
            struct vec3 caustic = photon_map_gather(photons, &at_s, t->max_depth - depth - 2, NULL);
            p.radiance = vec3_add(p.radiance, vec3_mul(p.throughput, caustic));
        }
        sampler_skip_to(sampler, path_dimension(depth));
        struct vec2 u_light = sampler_next_2d(sampler);
        struct vec2 u = sampler_next_2d(sampler);
        float u_lobe = sampler_next_1d(sampler), u_roulette = sampler_next_1d(sampler);
        if (!is_caster || !(p.met & PATH_RECEIVER))
            connect(&p, v, t, &s, &bsdf, u_light, u_roulette);
        struct bsdf_sample b = bsdf_sample(&bsdf, s.wi, u_lobe, u.x, u.y);
        if (!scatter(&p, t, depth, &s, &b, u_roulette, &ray)) break;
        if (photons) p.met = photon_path_after(p.met, is_caster, b.lobe);
        accel_intersect(v->top, &ray, &hit);
    }
    return p.radiance;
}

static void put3(float *to, struct vec3 v)
{
    to[0] += v.x;
    to[1] += v.y;
    to[2] += v.z;
}

void path_add_buffers(const struct view *v, const struct trace_settings *t,
                      const struct ray *primary, float offset, const struct hit *first,
                      float *buffers)
{
    const struct path seen = {.last_is_delta = true};
    if (first->shape == SCENE_NONE) {
        for (uint32_t i = v->first_environment; !t->hide_emitters && i < v->n_lights; i++)
            put3(buffers + BUFFER_EMISSION,
                 path_environment(v, t, &seen, &v->lights[i], primary->d));
        return;
    }
    struct surface s;
    struct bsdf_point b;
    surface_init(&s, v, primary, first);
    surface_bsdf(&s, v, &b);
    struct vec3 wo = vec3_neg(primary->d), n = s.frame.n;
    if (b.is_turned) n = frame_to_world(&s.frame, bsdf_normal(&b));
    put3(buffers + BUFFER_POSITION, s.p);
    put3(buffers + BUFFER_NORMAL, n);
    put3(buffers + BUFFER_GEO_NORMAL, s.n);
    put3(buffers + BUFFER_ALBEDO, bsdf_albedo(&b));
    buffers[BUFFER_ROUGHNESS] += bsdf_roughness(&b);
    put3(buffers + BUFFER_WO, wo);
    if (b.kind != BSDF_DIFFUSE) put3(buffers + BUFFER_WI, path_encode_direction(n, wo));
    if (!t->hide_emitters)
        put3(buffers + BUFFER_EMISSION, light_surface_radiance(v, &s, primary->d));
    buffers[BUFFER_DEPTH] += s.t + offset;
}
