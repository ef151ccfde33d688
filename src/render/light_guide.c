/* SPDX-License-Identifier: Apache-2.0 */
/* Which light to sample. */
#include "render/light.h"

static float mean_of(const struct view *v, uint32_t texture)
{
    return texture == SCENE_NONE ? 1.0f : texture_mean(&v->textures, texture);
}

/* Irradiance at distance 1 of something on the light's axis; of lights far away, irradiance. */
static float power_of(const struct view *v, const struct light *l)
{
    const struct emitter *e = &v->state.emitters[l->emitter];
    if (emitter_is_surface(e->kind)) {
        struct light_point at;
        light_point_sample(v, l, 0.5f, 0.5f, &at);
        /* A sphere shows a quarter of itself. */
        float area = (l->shape->kind == SHAPE_SPHERE ? 0.25f : 1.0f) / at.pdf;
        return mean_of(v, e->radiance) * e->scale * area;
    }
    if (emitter_is_environment(e->kind)) return light_environment_power(v, l);
    return mean_of(v, e->radiance) * e->scale;
}

static void add_hint(struct light_guide *g, const struct view *v, const struct light *l)
{
    const struct emitter *e = &v->state.emitters[l->emitter];
    struct light_hint h = {.power = power_of(v, l), .radius2 = 1e-12f, .near = 1.0f, .base = 1.0f};
    if (emitter_is_surface(e->kind)) {
        const struct view_instance *i = &v->instances[l->instance];
        float extent = l->shape->extent * cbrtf(fabsf(i->determinant));
        h.center = transform_point(i->to_world, l->shape->center);
        h.radius2 = max_float(extent * extent, 1e-12f);
        struct light_point at;
        if (l->shape->flat_side != 0.0f || l->shape->kind == SHAPE_DISK) {
            light_point_sample(v, l, 0.5f, 0.5f, &at);
            h.normal = at.n;
            h.base = 0.1f;
            h.slope = 0.9f;
        }
    } else if (emitter_is_environment(e->kind) || e->kind == EMITTER_DIRECTIONAL) {
        h.near = 0.0f;
    } else {
        h.center = transform_point(&e->to_world, vec3_splat(0.0f));
    }
    g->hints[g->n++] = h;
}

/* By power and a share for all alike. */
static void init_cdf(const struct view *v)
{
    uint32_t n = v->n_lights;
    double sum = 0, before = 0;
    for (uint32_t i = 0; i < n; i++) {
        float power = power_of(v, &v->lights[i]);
        v->light_cdf[i + 1] = power > 0.0f && power < INFINITY ? power : 0.0f;
        sum += v->light_cdf[i + 1];
    }
    v->light_cdf[0] = 0.0f;
    for (uint32_t i = 0; i < n; i++) {
        double share = sum > 0 ? v->light_cdf[i + 1] / sum : 1.0 / n;
        before += LIGHT_EVEN / n + (1.0 - LIGHT_EVEN) * share;
        v->light_cdf[i + 1] = i + 1 == n ? 1.0f : (float)before;
    }
}

void light_guide_init(struct light_guide *g, const struct view *v)
{
    g->n = 0;
    if (v->n_lights < 2) return;
    if (v->n_lights > LIGHT_GUIDES) {
        init_cdf(v);
        return;
    }
    for (uint32_t i = 0; i < v->n_lights; i++) add_hint(g, v, &v->lights[i]);
}

/* Weights of all lights, and their sum. */
static float weigh(const struct light_guide *g, struct vec3 p, float weights[LIGHT_GUIDES])
{
    float sum = 0.0f;
    for (uint32_t k = 0; k < g->n; k++) weights[k] = light_weight(&g->hints[k], p);
    for (uint32_t k = 0; k < g->n; k++) sum += weights[k];
    return sum;
}

uint32_t light_choose(const struct view *v, struct vec3 p, float *u1, float *probability)
{
    const struct light_guide *g = &v->guide;
    *probability = 1.0f;
    if (v->n_lights == 1) return 0;
    if (g->n == 0) {
        uint32_t low = 0, high = v->n_lights; /* cdf[low] <= u1 < cdf[high] */
        while (high - low > 1) {
            uint32_t middle = (low + high) / 2;
            if (v->light_cdf[middle] <= *u1)
                low = middle;
            else
                high = middle;
        }
        *probability = v->light_cdf[low + 1] - v->light_cdf[low];
        *u1 = light_rest(*u1 - v->light_cdf[low], *probability);
        return low;
    }
    float weights[LIGHT_GUIDES], sum = weigh(g, p, weights), rest = *u1;
    const struct light_shares shares = light_shares(g->n, sum);
    for (uint32_t k = 0;; k++) {
        *probability = light_share(shares, weights[k]);
        if (rest < *probability || k + 1 == g->n) {
            *u1 = light_rest(rest, *probability);
            return k;
        }
        rest -= *probability;
    }
}

float light_probability(const struct view *v, struct vec3 p, uint32_t light)
{
    const struct light_guide *g = &v->guide;
    float weights[LIGHT_GUIDES];
    if (v->n_lights == 1) return 1.0f;
    if (g->n == 0) return v->light_cdf[light + 1] - v->light_cdf[light];
    float sum = weigh(g, p, weights);
    return light_share(light_shares(g->n, sum), weights[light]);
}
