/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_CHAIN_H
#define RENDER_CHAIN_H

#include "render/path.h"

/*
 * Delta chains: what a ray meets before the first surface that scatters into more than single
 * directions. Perfect mirrors, smooth glass, thin sheets, null surfaces and the holes of masks are
 * followed; what stands behind or in them is then described in their stead, with
 *
 *   throughput   the product of weights from the camera to that surface
 *   emission     what shines along the way, each times the throughput up to it; that of the last
 *                surface (or of the environment) included
 *
 * so that a pixel's radiance is the mean of emission + throughput * (what the last surface
 * scatters). Where a surface both reflects and transmits, each sample goes one way, chosen at
 * random as a path chooses it, by the same random numbers. The dominant way alone would be free of
 * noise, but it is another picture: the other part would be missing from emission and throughput,
 * and at grazing angles the choice would jump. A sample's weights need no division by a chance that
 * a network would have to know, and the mean over samples is the decomposition itself.
 */
struct chain {
    struct vec3 throughput, emission;
    uint32_t n; /* surfaces that were followed */
};

/* Longer ones end at a smooth surface; so do those that reach the settings' max_depth. */
enum { CHAIN_MAX = 64 };

/* Whether a path that drew b at a surface of this kind is still on its chain. A smooth coat over
 * something rough is no mirror. */
static inline bool chain_goes_on(const struct bsdf_point *p, const struct bsdf_sample *b)
{
    if (b->lobe == LOBE_NULL) return true;
    return b->lobe == LOBE_SPECULAR && !(p->lobes & LOBE_SMOOTH);
}

/* Whether there is anything to follow: most hits are not. */
static inline bool chain_may_start(const struct view *v, const struct hit *hit)
{
    if (hit->shape == SCENE_NONE) return false;
    const struct world_shape *shape = &v->instances[hit->instance].shapes[hit->shape];
    return (v->materials[v->state.shape_bsdfs[shape->index]].lobes & LOBE_DELTA) != 0;
}

/*
 * Follows a primary ray whose hit is given. *ray and *hit become those of the surface to describe,
 * *offset how far the way to the ray's start is. *sampler: where the film and the lens left it; it
 * is used as path_radiance() uses it. Emission leaves out the last surface: see chain_end().
 */
void chain_follow(struct chain *c, const struct view *v, const struct trace_settings *t,
                  struct sampler *sampler, struct ray *ray, struct hit *hit, float *offset);

/* Adds what the last surface emits. */
static inline void chain_end(struct chain *c, struct vec3 emission)
{
    c->emission = vec3_add(c->emission, vec3_mul(c->throughput, emission));
}

/* Whether emitters show to a ray after n followed surfaces. */
static inline bool chain_shows_emitters(const struct trace_settings *t, uint32_t n)
{
    return n > 0 || !t->hide_emitters;
}

#endif
