/* SPDX-License-Identifier: Apache-2.0 */
/* The vector code of buffers.h: a part of stream_kernels.h, which includes it. */
#include "render/buffers.h"

LANE void look_at_lane(struct first_hits *f, uint32_t i, const struct camera *camera,
                       const struct filter *filter, enum sampler_kind sampler,
                       enum filter_kind kind, uint64_t seed)
{
    struct sampler r = sampler_start(sampler, seed, f->pixel[i], f->sample[i]);
    struct vec2 u = sampler_next_2d(&r);
    float x = f->center_x[i] + filter_quantile(filter, kind, u.x);
    float y = f->center_y[i] + filter_quantile(filter, kind, u.y);
    struct ray ray = camera_ray(camera, x, y, &f->offset[i]);
    lanes3_set(&f->o, i, ray.o);
    lanes3_set(&f->d, i, ray.d);
    f->t_max[i] = ray.t_max;
}

LANE void look_at_lanes(struct first_hits *f, const struct stream_film *film,
                        enum sampler_kind sampler, enum filter_kind kind)
{
    const struct camera camera = film->camera;
    const struct filter *filter = &film->filter;
    const uint64_t seed = film->seed;
    uint32_t n = f->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) look_at_lane(f, i, &camera, filter, sampler, kind, seed);
}

LANE void look_at_with(struct first_hits *f, const struct stream_film *film,
                       enum sampler_kind sampler)
{
    switch (film->filter.kind) {
    case FILTER_BOX:
        look_at_lanes(f, film, sampler, FILTER_BOX);
        break;
    case FILTER_TENT:
        look_at_lanes(f, film, sampler, FILTER_TENT);
        break;
    case FILTER_GAUSSIAN:
        look_at_lanes(f, film, sampler, FILTER_GAUSSIAN);
        break;
    }
}

static void look_at(struct first_hits *f, const struct stream_film *film)
{
    if (film->sampler == SAMPLER_INDEPENDENT)
        look_at_with(f, film, SAMPLER_INDEPENDENT);
    else
        look_at_with(f, film, SAMPLER_SOBOL);
}

LANE void describe_3(struct first_hits *f, uint32_t channel, uint32_t i, bool is_seen,
                     struct vec3 v)
{
    f->values[channel][i] = choose(is_seen, v.x, 0.0f);
    f->values[channel + 1][i] = choose(is_seen, v.y, 0.0f);
    f->values[channel + 2][i] = choose(is_seen, v.z, 0.0f);
}

LANE void describe_lane(struct first_hits *f, uint32_t i)
{
    bool is_hit = f->is_hit[i] != 0, has_wi = is_hit & (f->has_wi[i] != 0);
    struct vec3 n = lanes3_get(&f->normal, i), shading = lanes3_get(&f->shading, i);
    surface_normals(&n, &shading);
    struct vec3 wo = vec3_neg(lanes3_get(&f->d, i));
    describe_3(f, BUFFER_NORMAL, i, is_hit, shading);
    describe_3(f, BUFFER_GEO_NORMAL, i, is_hit, n);
    describe_3(f, BUFFER_WO, i, is_hit, wo);
    describe_3(f, BUFFER_WI, i, has_wi, path_encode_direction(shading, wo));
    f->values[BUFFER_DEPTH][i] = choose(is_hit, f->t[i] + f->offset[i], 0.0f);
}

static void describe(struct first_hits *f)
{
    uint32_t n = f->n;
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) describe_lane(f, i);
}
