/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_LIGHT_H
#define RENDER_LIGHT_H

#include "math/approx.h"
#include "render/sphere.h"
#include "render/surface.h"
#include "render/world.h"

/*
 * Choosing directions to lights. A light is chosen by what it may send to the reference point
 * (struct light_guide; more than LIGHT_GUIDES by power alone), then a direction to it: meshes and
 * disks by area, spheres by the cone that they fill, environments by radiance. Densities are in
 * solid angle at the reference point and include the choice of the light.
 */
struct light_sample {
    struct vec3 d;      /* unit, to the light */
    struct vec3 p;      /* the point on it, unless is_infinite */
    struct vec3 weight; /* radiance / density (point lights: intensity / distance^2 / choice) */
    float pdf;
    uint32_t light;   /* into the view's */
    bool is_delta;    /* from one direction only: no other strategy can find it */
    bool is_infinite; /* environment, directional */
};

/* False when there is nothing to add (no lights, seen from behind, ...). */
bool light_sample(const struct view *v, struct vec3 reference, float u1, float u2,
                  struct light_sample *s);

/* The same of one light, which was chosen with probability `choice` and left u1. */
bool light_sample_chosen(const struct view *v, uint32_t light, struct vec3 reference, float u1,
                         float u2, float choice, struct light_sample *s);

/* A random number's part that a choice of probability p has left over. */
static inline float light_rest(float u, float p)
{
    return min_float(u / p, 0x1.fffffep-1f);
}

/* What a light may send to p, roughly: the root is none to the last digit. */
static inline float light_weight(const struct light_hint *h, struct vec3 p)
{
    struct vec3 d = vec3_sub(p, h->center);
    float inverse = approx_inverse_root(max_float(vec3_dot(d, d), h->radius2));
    float cosine = max_float(vec3_dot(h->normal, d), 0.0f) * inverse;
    float weight = h->power * (h->base + h->slope * cosine);
    return weight * (h->near * (inverse * inverse) + (1.0f - h->near));
}

/* Probabilities of n lights from the sum of their weights: even + scale * weight. */
struct light_shares {
    float even, scale;
};

static inline struct light_shares light_shares(uint32_t n, float sum)
{
    bool has_weight = (sum > 0.0f) & (sum < INFINITY);
    return (struct light_shares){(has_weight ? LIGHT_EVEN : 1.0f) / (float)n,
                                 has_weight ? (1.0f - LIGHT_EVEN) / sum : 0.0f};
}

static inline float light_share(struct light_shares s, float weight)
{
    return s.even + s.scale * weight;
}

void light_guide_init(struct light_guide *g, const struct view *v);

/* Whether lights are few enough for weights of their own. */
static inline bool light_is_guided(const struct view *v)
{
    return v->n_lights <= LIGHT_GUIDES;
}

/* The light that u1 chooses for a point, among n_lights > 0, and its probability; u1 becomes what
 * is left of it. */
uint32_t light_choose(const struct view *v, struct vec3 p, float *u1, float *probability);
float light_probability(const struct view *v, struct vec3 p, uint32_t light);

/* Completes a sample whose point s->p with unit normal n has density per_area, or where that is not
 * 0 cone_pdf in solid angle, for a light that is chosen with probability `choice`. */
MATH_INLINE bool light_sample_finish(struct light_sample *s, struct vec3 reference, struct vec3 n,
                                     float per_area, float cone_pdf, struct vec3 radiance,
                                     float choice)
{
    struct vec3 d = vec3_sub(s->p, reference);
    float distance2 = vec3_dot(d, d);
    s->d = vec3_scale(d, 1.0f / sqrtf(distance2));
    float cosine = -vec3_dot(s->d, n); /* behind, the light does not shine */
    float area_pdf = per_area * distance2 / cosine, pdf = cone_pdf > 0.0f ? cone_pdf : area_pdf;
    s->pdf = pdf * choice;
    s->weight = vec3_scale(radiance, 1.0f / s->pdf);
    s->is_delta = s->is_infinite = false;
    return (distance2 > 0.0f) & (cosine > 0.0f) & (pdf > 0.0f) & (pdf < INFINITY);
}

/* Room for the lights of all instances of the view's scene. */
bool light_table_alloc(struct light_table *t, const struct view *v);
void light_table_release(struct light_table *t);
/* Fills the view's table from its lights. Where nothing `has_moved` only radiance is new. */
void light_table_init(struct light_table *t, const struct view *v, bool has_moved);

/* For photons. A point on an area light, uniform by area: density per area, and what it shines. */
struct light_point {
    struct vec3 p, n, radiance; /* n: unit, on the side that shines */
    float pdf;
};
void light_point_sample(const struct view *v, const struct light *l, float u1, float u2,
                        struct light_point *s);

/* Radiance that the surface sends along -d; zero when it does not shine or shows its back. */
struct vec3 light_surface_radiance(const struct view *v, const struct surface *s, struct vec3 d);

/* Density with which light_sample() at `reference` would have found the surface point s, which lies
 * in direction d at `distance`. */
float light_surface_pdf(const struct view *v, struct vec3 reference, const struct surface *s,
                        struct vec3 d, float distance);

/* Environments, lights v->first_environment and on (light_environment.c): radiance arriving along
 * -d, and the density of choosing d at a point. */
struct vec3 light_environment_radiance(const struct view *v, const struct light *l, struct vec3 d);
float light_environment_pdf(const struct view *v, const struct light *l, struct vec3 reference,
                            struct vec3 d);

/* Irradiance that an environment of this brightness everywhere would bring, roughly. */
float light_environment_power(const struct view *v, const struct light *l);

/* A direction to an environment: d, pdf (of d alone), and radiance as weight. */
bool light_environment_sample(const struct view *v, const struct light *l, float u1, float u2,
                              struct light_sample *s);

/* The sky of an EMITTER_SKY. Refreshing it costs a millisecond where turbidity or the sun's
 * elevation changed, else nothing. */
bool sky_init(struct sky *s);
void sky_release(struct sky *s);
void sky_refresh(struct sky *s, const struct emitter *e);

/* Points, spots, projectors, directional light: light_delta.c. What of the emitter's values is the
 * same for all samples; then a sample, before the choice of the light counts. */
void light_init_delta(struct light *l, const struct view *v);
bool light_sample_delta(const struct view *v, const struct light *l, struct vec3 reference,
                        struct light_sample *s);

/* The same for surfaces that shine along their normals (light_normals.c). `choice` in [0,1) picks
 * one of several places. Meshes are searched triangle by triangle and count as flat faces;
 * ellipsoids are dark. */
bool light_sample_normals(const struct view *v, const struct light *l, struct vec3 reference,
                          float choice, struct light_sample *s);

/* Envmaps: light_envmap.c. d is in the map's own space. */
bool envmap_alloc(struct world_envmap *e, uint32_t width, uint32_t height, float span);
/* Readies a map whose rgb is filled in; weights [height - 1][width] are scratch. */
void envmap_weigh(struct world_envmap *e, float *weights);
bool envmap_init(struct world_envmap *e, const struct bitmap *b, const float decode[256]);
void envmap_release(struct world_envmap *e);
struct vec3 envmap_eval(const struct world_envmap *e, struct vec3 d);
/* Values around a cell: left and right, then the same below. */
void envmap_nodes(const struct world_envmap *e, uint32_t column, uint32_t row,
                  struct vec3 nodes[4]);
float envmap_pdf(const struct world_envmap *e, struct vec3 d);
/* d(place in the unit square) / d(solid angle) = 1 / (2 pi span sin theta). */
MATH_INLINE float envmap_density(const struct world_envmap *e, float sin_theta)
{
    return 1.0f / (2.0f * MATH_PI * e->span * max_float(sin_theta, 1e-7f));
}

#endif
