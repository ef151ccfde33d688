/* SPDX-License-Identifier: Apache-2.0 */
#include "render/chain.h"

#include "render/light.h"

/* By kind, whatever the variables: a blend or a bump map has its parts in the list as well. */
bool view_has_chains(const struct scene *s)
{
    for (uint32_t i = 0; i < s->n_bsdfs; i++) switch (s->defaults.bsdfs[i].kind) {
        case BSDF_CONDUCTOR:
        case BSDF_DIELECTRIC:
        case BSDF_THIN_DIELECTRIC:
        case BSDF_NULL:
        case BSDF_MASK:
            return true;
        default:
            break;
        }
    return false;
}

void chain_follow(struct chain *c, const struct view *v, const struct trace_settings *t,
                  struct sampler *sampler, struct ray *ray, struct hit *hit, float *offset)
{
    *c = (struct chain){.throughput = {1, 1, 1}};
    for (int32_t depth = 0; depth < CHAIN_MAX; depth++) {
        if (t->max_depth >= 0 && depth + 1 >= t->max_depth) return;
        if (!chain_may_start(v, hit)) return;
        struct surface s;
        struct bsdf_point bsdf;
        surface_init(&s, v, ray, hit);
        surface_bsdf(&s, v, &bsdf);
        /* The numbers of a path: light, direction, lobe, roulette. */
        sampler_skip_to(sampler, path_dimension(depth));
        sampler_next_2d(sampler);
        const struct vec2 u = sampler_next_2d(sampler);
        const float u_lobe = sampler_next_1d(sampler);
        sampler_next_1d(sampler);
        const struct bsdf_sample b = bsdf_sample(&bsdf, s.wi, u_lobe, u.x, u.y);
        if (!chain_goes_on(&bsdf, &b)) return;
        const struct vec3 throughput = vec3_mul(c->throughput, b.weight);
        if (!vec3_is_finite(throughput)) return;
        if (s.shape->emitter != SCENE_NONE && chain_shows_emitters(t, c->n))
            chain_end(c, light_surface_radiance(v, &s, ray->d));
        c->throughput = throughput;
        if (!(vec3_max(throughput) > 0.0f)) return;
        *ray = surface_ray(s.p, s.n, frame_to_world(&s.frame, b.wo));
        *offset += s.t + vec3_dot(vec3_sub(ray->o, s.p), ray->d);
        accel_intersect(v->top, ray, hit);
        c->n++;
    }
}
