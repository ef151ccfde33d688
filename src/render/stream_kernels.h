/* SPDX-License-Identifier: Apache-2.0 */
/* The steps of stream.h for one instruction set: included by stream_baseline.c, stream_avx2.c and
 * stream_avx512.c, which define STREAM_KERNELS, the table's name, and STREAM_NAME. What happens
 * in a lane is a function of its own, whose structs compilers take apart before they look for
 * vectors; it has no branches, only choices between values. */
#include "render/light.h"
#include "render/stream.h"

/* All calls are inlined: a loop that calls is no loop of vectors. */
#define LANE   static inline __attribute__((always_inline, flatten))
#define KERNEL static __attribute__((flatten)) void

static inline float choose(bool condition, float a, float b)
{
    return condition ? a : b;
}

static inline void lanes3_choose(struct lanes3 *to, uint32_t i, bool condition, struct vec3 v)
{
    to->x[i] = choose(condition, v.x, to->x[i]);
    to->y[i] = choose(condition, v.y, to->y[i]);
    to->z[i] = choose(condition, v.z, to->z[i]);
}

static inline struct frame lane_frame(const struct stream *s, uint32_t i)
{
    return (struct frame){lanes3_get(&s->frame_s, i), lanes3_get(&s->frame_t, i),
                          lanes3_get(&s->frame_n, i)};
}

#include "render/look_up_kernels.h"

#include "render/facet_kernels.h"
#include "render/few_kernels.h"
#include "render/light_kernels.h"

/* Some loops exist once for each kind of sampler, as a loop of vectors cannot branch. */

LANE void start_lane(struct stream *s, uint32_t i, enum sampler_kind kind, uint64_t seed)
{
    struct sampler r = sampler_start(kind, seed, s->pixel[i], s->sample[i]);
    struct vec2 u = sampler_next_2d(&r);
    s->u[0][i] = u.x;
    s->u[1][i] = u.y;
    if (kind == SAMPLER_INDEPENDENT) {
        s->rng_state[i] = r.rng.state;
        s->rng_stream[i] = r.rng.stream;
    } else {
        s->seed[i] = r.seed;
        s->index[i] = r.index;
    }
}

KERNEL start(struct stream *s, enum sampler_kind kind, uint64_t seed)
{
    uint32_t n = s->n;
    if (kind == SAMPLER_INDEPENDENT) {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) start_lane(s, i, SAMPLER_INDEPENDENT, seed);
    } else {
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) start_lane(s, i, SAMPLER_SOBOL, seed);
    }
}

LANE void look_lane(struct stream *s, uint32_t i, const struct camera *camera)
{
    struct ray ray = camera_ray(camera, s->u[0][i], s->u[1][i], &s->offset[i]);
    lanes3_set(&s->o, i, ray.o);
    lanes3_set(&s->d, i, ray.d);
    s->t_max[i] = ray.t_max;
}

KERNEL look(struct stream *s, const struct camera *camera)
{
    const struct camera c = *camera;
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) look_lane(s, i, &c);
}

/* The Sobol points of a lane, from a dimension on. */
LANE struct sampler sobol_lane(const struct stream *s, uint32_t i, uint32_t dimension)
{
    struct sampler r = {.kind = SAMPLER_SOBOL, .seed = s->seed[i], .index = s->index[i]};
    sampler_skip_to(&r, dimension);
    return r;
}

/* In order: light, direction, lobe, roulette. */
KERNEL draw_independent(struct stream *s)
{
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) {
        struct rng r = {s->rng_state[i], s->rng_stream[i]};
        for (uint32_t k = 0; k < 6; k++) s->u[k][i] = rng_float(&r);
        s->rng_state[i] = r.state;
    }
}

/* Every dimension for itself. */
KERNEL draw(struct stream *s, enum sampler_kind kind, uint32_t dimension, uint32_t wanted)
{
    uint32_t n = s->n;
    if (kind == SAMPLER_INDEPENDENT) {
        draw_independent(s);
        return;
    }
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) {
        struct sampler r = sobol_lane(s, i, dimension);
        struct vec2 light = sampler_next_2d(&r), direction = sampler_next_2d(&r);
        s->u[0][i] = light.x;
        s->u[1][i] = light.y;
        s->u[2][i] = direction.x;
        s->u[3][i] = direction.y;
    }
    for (uint32_t k = 0; k < 2; k++) {
        if (!(wanted & (k == 0 ? STREAM_LOBE : STREAM_ROULETTE))) continue;
        float *u = s->u[4 + k];
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) {
            struct sampler r = sobol_lane(s, i, dimension + 4 + k);
            u[i] = sampler_next_1d(&r);
        }
    }
}

LANE void surface_lane(struct stream *s, uint32_t i)
{
    struct vec3 n = lanes3_get(&s->normal, i), shading = lanes3_get(&s->frame_n, i);
    surface_normals(&n, &shading);
    struct frame frame = frame_from_normal(shading);
    lanes3_set(&s->normal, i, n);
    lanes3_set(&s->frame_s, i, frame.s);
    lanes3_set(&s->frame_t, i, frame.t);
    lanes3_set(&s->frame_n, i, frame.n);
    struct vec3 wi = frame_to_local(&frame, vec3_neg(lanes3_get(&s->d, i)));
    lanes3_set(&s->wi, i, wi);
    s->bsdf_side[i] = choose((s->bsdf_is_twosided[i] != 0) & (wi.z < 0.0f), -1.0f, 1.0f);
}

KERNEL surface(struct stream *s)
{
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) surface_lane(s, i);
}

LANE void eval_lane(struct stream *s, uint32_t i)
{
    struct frame frame = lane_frame(s, i);
    struct vec3 wo = frame_to_local(&frame, lanes3_get(&s->light_d, i));
    float side = s->bsdf_side[i], wi_z = s->wi.z[i] * side, pdf = wo.z * side * MATH_INV_PI;
    bool is_lit = (wi_z > 0.0f) & (wo.z * side > 0.0f);
    pdf = choose(is_lit, pdf, 0.0f);
    lanes3_set(&s->light_wo, i, wo);
    lanes3_set(&s->value, i, vec3_scale(lanes3_get(&s->reflectance, i), pdf));
    s->value_pdf[i] = pdf;
}

KERNEL eval(struct stream *s)
{
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) eval_lane(s, i);
}

LANE void connect_lane(struct stream *s, uint32_t i, enum mis_kind mis)
{
    struct vec3 p = lanes3_get(&s->p, i), normal = lanes3_get(&s->normal, i);
    struct vec3 value = lanes3_get(&s->value, i), weight = lanes3_get(&s->light_weight, i);
    struct vec3 throughput = lanes3_get(&s->throughput, i);
    struct vec3 d = lanes3_get(&s->light_d, i);
    struct ray far = surface_ray(p, normal, d);
    struct ray near = surface_ray_to(p, normal, lanes3_get(&s->light_p, i));
    float share = path_mis_weight(mis, s->light_pdf[i], s->value_pdf[i]);
    bool is_far = s->light_is_infinite[i] != 0;
    share = choose(s->light_is_delta[i] != 0, 1.0f, share);
    struct vec3 light = vec3_scale(vec3_mul(vec3_mul(value, weight), throughput), share);
    bool is_dark = vec3_is_zero(value) || vec3_is_zero(weight);
    lanes3_set(&s->light, i, light);
    lanes3_set(&s->shadow_o, i, near.o);
    lanes3_set(&s->shadow_d, i, near.d);
    lanes3_choose(&s->shadow_o, i, is_far, far.o);
    lanes3_choose(&s->shadow_d, i, is_far, far.d);
    s->shadow_t_max[i] = choose(is_far, far.t_max, near.t_max);
    s->is_connected[i] = s->is_alive[i] & s->has_light[i] & !is_dark;
}

/* Leaves some shadow rays to chance. */
KERNEL save_rays(struct stream *s)
{
    float gathered[STREAM_SIZE];
    uint32_t n = s->n;
    for (uint32_t i = 0; i < n; i++) gathered[i] = vec3_max(lanes3_get(&s->radiance, s->path[i]));
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) {
        struct vec3 light = lanes3_get(&s->light, i);
        float chance = path_light_chance(gathered[i], light);
        lanes3_set(&s->light, i, vec3_scale(light, 1.0f / chance));
        s->is_connected[i] &= path_lower_bits(s->u[5][i]) < chance;
    }
}

KERNEL connect(struct stream *s, enum mis_kind mis, bool saves_rays)
{
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) connect_lane(s, i, mis);
    if (saves_rays) save_rays(s);
}

/* What is hidden becomes zero: whether light arrives is a matter of chance, and a branch for it
 * would seldom be foreseen. */
KERNEL add_lights(struct stream *s)
{
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) {
        bool is_hidden = (s->is_connected[i] & s->is_free[i]) == 0;
        lanes3_choose(&s->light, i, is_hidden, vec3_splat(0.0f));
    }
    for (uint32_t i = 0; i < n; i++) {
        uint32_t path = s->path[i];
        struct vec3 sum = vec3_add(lanes3_get(&s->radiance, path), lanes3_get(&s->light, i));
        lanes3_set(&s->radiance, path, sum);
    }
}

LANE void sample_lane(struct stream *s, uint32_t i)
{
    float side = s->bsdf_side[i];
    struct vec3 wo = warp_cosine_hemisphere(s->u[2][i], s->u[3][i]);
    float pdf = warp_cosine_hemisphere_pdf(wo.z);
    bool is_lit = (s->wi.z[i] * side > 0.0f) & (pdf > 0.0f);
    struct vec3 weight = lanes3_get(&s->reflectance, i);
    lanes3_set(&s->wo, i, vec3(wo.x, wo.y, wo.z * side));
    s->weight.x[i] = choose(is_lit, weight.x, 0.0f);
    s->weight.y[i] = choose(is_lit, weight.y, 0.0f);
    s->weight.z[i] = choose(is_lit, weight.z, 0.0f);
    s->wo_pdf[i] = pdf;
    s->wo_eta[i] = 1.0f;
    s->wo_is_delta[i] = 0;
}

KERNEL sample(struct stream *s)
{
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) sample_lane(s, i);
}

LANE void scatter_lane(struct stream *s, uint32_t i, float least_survival)
{
    struct vec3 throughput = vec3_mul(lanes3_get(&s->throughput, i), lanes3_get(&s->weight, i));
    struct vec3 p = lanes3_get(&s->p, i);
    struct frame frame = lane_frame(s, i);
    float most = vec3_max(throughput), eta = s->eta[i] * s->wo_eta[i];
    float survival = max_float(path_survival(most, eta), least_survival);
    bool survives = (most > 0.0f) & ((s->u[5][i] < survival) | (survival >= 1.0f));
    struct ray ray = surface_ray(p, lanes3_get(&s->normal, i),
                                 frame_to_world(&frame, lanes3_get(&s->wo, i)));
    s->is_alive[i] &= survives;
    lanes3_set(&s->throughput, i, vec3_scale(throughput, 1.0f / survival));
    lanes3_set(&s->last_p, i, p);
    lanes3_set(&s->o, i, ray.o);
    lanes3_set(&s->d, i, ray.d);
    s->t_max[i] = INFINITY;
    s->eta[i] = eta;
    s->last_pdf[i] = s->wo_pdf[i];
    s->last_is_delta[i] = s->wo_is_delta[i];
}

KERNEL scatter(struct stream *s, float least_survival)
{
    uint32_t n = s->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) scatter_lane(s, i, least_survival);
}

LANE bool meets(struct vec3 o, struct vec3 inverse_d, const struct bounds *box)
{
    struct vec3 a = vec3_mul(vec3_sub(box->min, o), inverse_d);
    struct vec3 b = vec3_mul(vec3_sub(box->max, o), inverse_d);
    float near = max_float(max_float(min_float(a.x, b.x), min_float(a.y, b.y)),
                           max_float(min_float(a.z, b.z), 0.0f));
    float far = min_float(min_float(max_float(a.x, b.x), max_float(a.y, b.y)), max_float(a.z, b.z));
    return near <= far;
}

LANE void aim_lane(struct stream *s, uint32_t i, const struct bounds *box, uint32_t is_first)
{
    struct vec3 d = lanes3_get(&s->d, i);
    struct vec3 inverse = vec3(1.0f / d.x, 1.0f / d.y, 1.0f / d.z);
    uint32_t is_met = meets(lanes3_get(&s->o, i), inverse, box);
    s->is_aimed[i] = is_first ? is_met : s->is_aimed[i] | is_met;
}

KERNEL aim(struct stream *s, const struct bounds *boxes, uint32_t n_boxes)
{
    uint32_t n = s->n;
    for (uint32_t k = 0; k < n_boxes; k++) {
        const struct bounds box = boxes[k];
#pragma omp simd
        for (uint32_t i = 0; i < n; i++) aim_lane(s, i, &box, k == 0);
    }
    for (uint32_t i = 0; i < n; i++) s->is_alive[i] &= n_boxes > 0 ? s->is_aimed[i] : 0;
}

#include "render/buffers_kernels.h"

const struct stream_kernels STREAM_KERNELS = {
    .name = STREAM_NAME,
    .start = start,
    .look = look,
    .draw = draw,
    .surface = surface,
    .choose_light = choose_light,
    .light = light,
    .light_around = light_around,
    .eval = eval,
    .connect = connect,
    .add_lights = add_lights,
    .sample = sample,
    .scatter = scatter,
    .aim = aim,
    .look_at = look_at,
    .describe = describe,
    .facets_gather = facets_gather,
    .facets_eval = facets_eval,
    .facets_sample = facets_sample,
    .few_cast = few_cast,
    .few_arrive = few_arrive,
    .few_shade = few_shade,
};
