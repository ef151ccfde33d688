/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_PATH_H
#define RENDER_PATH_H

#include "render/bsdf.h"
#include "render/camera.h"
#include "render/sampler.h"
#include "render/surface.h"
#include "render/view.h"

/*
 * A light path: unidirectional, with a light sampled at every surface and multiple importance
 * sampling between that and the bsdf (Veach & Guibas 1995). Depth, Russian roulette and hidden
 * emitters are counted as Mitsuba's `path` does. path_radiance() is the plain loop, one path at a
 * time: the reference for stream.c, which traces pictures and shares the pieces below.
 */
struct path {
    struct vec3 throughput, radiance;
    struct vec3 last_p; /* where the path last scattered, the density, and whether no light */
    float last_pdf;     /* sample could have found the direction */
    bool last_is_delta;
    float eta;    /* product of relative indices: undoes the scaling of radiance in roulette */
    uint32_t met; /* with photons: PATH_RECEIVER, PATH_CASTER */
};

/* Random numbers: the film has the first two, then a bounce has light 2, direction 2, lobe 1,
 * roulette 1. A lens has two of its own, far from these, as most cameras have none. */
enum { PATH_DIMENSIONS_FILM = 2, PATH_DIMENSIONS_BOUNCE = 6, PATH_DIMENSION_LENS = 1 << 30 };

static inline uint32_t path_dimension(int32_t depth)
{
    return PATH_DIMENSIONS_FILM + (uint32_t)depth * PATH_DIMENSIONS_BOUNCE;
}

/* The share of a strategy of density a beside one of density b. */
static inline float path_mis_weight(enum mis_kind kind, float a, float b)
{
    float x = kind == MIS_POWER ? a * a : a, y = kind == MIS_POWER ? b * b : b, w = x / (x + y);
    return w <= 1.0f ? w : 0.0f; /* 0 / 0, infinity / infinity */
}

/* Chance to go on in Russian roulette. */
static inline float path_survival(float throughput_max, float eta)
{
    return min_float(throughput_max * eta * eta, 0.95f);
}

/* Shadow rays are for light that may add to what the path has gathered (its largest channel):
 * lesser light is weighed up by chance, in whole 4096ths. Those are exact for the number that
 * decides, the lower 12 bits of one that roulette takes its upper bits of. */
static inline float path_light_chance(float gathered, struct vec3 light)
{
    float adds = vec3_max(light), share = adds / max_float(adds, gathered + 1e-30f);
    return (floor_float(share * 4095.0f) + 1.0f) * 0x1p-12f;
}

static inline float path_lower_bits(float u)
{
    float x = u * 4096.0f;
    return x - floor_float(x);
}

/* Light of an environment, one of v->lights, that a ray along d runs into. */
struct vec3 path_environment(const struct view *v, const struct trace_settings *t,
                             const struct path *p, const struct light *l, struct vec3 d);

/* Light of the surface that a ray along d has hit. */
struct vec3 path_emission(const struct view *v, const struct trace_settings *t,
                          const struct path *p, const struct surface *s, struct vec3 d);

/* The primary ray through the point (x, y) of the picture, which the film has drawn. */
struct ray path_start(const struct camera *c, float x, float y, struct sampler *sampler,
                      float *offset);

/* Radiance along the primary ray whose hit is `hit`; the film has drawn its dimensions. `photons`:
 * those of the sample, or NULL. */
struct vec3 path_radiance(const struct view *v, const struct trace_settings *t,
                          const struct ray *primary, const struct hit *hit,
                          const struct photon_map *photons, struct sampler *sampler);

/* The paper's encoding of the direction to the camera: in a frame whose tangent comes from a fixed
 * vector (method notes 1.2), with |z| and x, y moved to [0,1]. */
static inline struct vec3 path_encode_direction(struct vec3 n, struct vec3 d)
{
    const float third = 0.57735026918962576451f;
    struct vec3 fixed = vec3_splat(third);
    struct vec3 s = vec3_madd(fixed, n, -vec3_dot(n, fixed));
    float length = vec3_length(s), scale = 1.0f / length;
    bool is_usable = length > 1e-4f;
    struct frame f = frame_from_normal(n);
    f.s.x = is_usable ? s.x * scale : f.s.x;
    f.s.y = is_usable ? s.y * scale : f.s.y;
    f.s.z = is_usable ? s.z * scale : f.s.z;
    struct vec3 t = vec3_cross(n, f.s);
    f.t.x = is_usable ? t.x : f.t.x;
    f.t.y = is_usable ? t.y : f.t.y;
    f.t.z = is_usable ? t.z : f.t.z;
    struct vec3 local = frame_to_local(&f, d);
    return vec3(0.5f * (local.x + 1.0f), 0.5f * (local.y + 1.0f), fabsf(local.z));
}

/* Adds the first hit's BUFFER_* channels to buffers [BUFFER_CHANNELS], ids excepted. `offset`: how
 * far from the pinhole the ray starts. */
void path_add_buffers(const struct view *v, const struct trace_settings *t,
                      const struct ray *primary, float offset, const struct hit *first,
                      float *buffers);

#endif
