/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_PHOTON_H
#define RENDER_PHOTON_H

#include "render/bsdf.h"
#include "render/view.h"

struct pool;

/*
 * Caustics by photons (Jensen 1996), with a radius that shrinks from pass to pass so that the
 * result converges to the truth (Knaus & Zwicker 2011). Surfaces are of two kinds:
 *
 *   casters    smooth or nearly smooth, nothing diffuse: mirrors, glass, polished metal
 *   receivers  all others
 *
 * Light that goes from a light over casters only to a receiver, and on to the camera in any way,
 * comes from photons; path tracing, which hardly finds it, leaves out exactly that: light that a
 * path meets behind a receiver after casters only.
 */

/* Rough casters' largest alpha: rougher ones, path tracing samples well. */
#define PHOTON_ALPHA 0.25f

static inline bool photon_is_caster(const struct bsdf_point *b)
{
    if ((b->lobes & LOBE_DIFFUSE) || !(b->lobes & (LOBE_GLOSSY | LOBE_SPECULAR))) return false;
    return !(b->lobes & LOBE_GLOSSY) || bsdf_roughness(b) <= PHOTON_ALPHA;
}

/* How a surface takes caustics: by Lambert's law, as its material says, not at all. */
enum photon_receiver_kind { RECEIVER_DIFFUSE = 0, RECEIVER_GLOSSY, RECEIVER_NONE };

static inline enum photon_receiver_kind photon_receiver_kind(const struct bsdf_point *b)
{
    if (bsdf_is_diffuse(b)) return RECEIVER_DIFFUSE;
    return photon_is_caster(b) ? RECEIVER_NONE : RECEIVER_GLOSSY;
}

/* What a path has met. After both, light is left to photons. */
enum { PATH_RECEIVER = 1, PATH_CASTER = 2, PATH_CAUSTIC = 3 };

/* What a path has met after a surface, where it scattered into `lobe`. */
static inline uint32_t photon_path_after(uint32_t met, bool is_caster, uint32_t lobe)
{
    if (lobe & LOBE_NULL) return met;
    return is_caster ? met | PATH_CASTER : PATH_RECEIVER;
}

struct photon {
    struct vec3 p;
    struct vec3 n;      /* of the surface, geometric */
    struct vec3 wo;     /* unit, to where it came from */
    struct vec3 power;  /* its share of the flux */
    uint32_t n_casters; /* met on the way, at least 1 */
    uint32_t emitter;   /* where it comes from, into state->emitters */
    float peak;         /* what a path has found that finds it by chance: view_wants_photons() */
    float radius2;      /* squared, that its power spreads over; 64 bytes: one line of cache */
};

/* Photons of one pass, in a hashed grid. */
struct photon_map {
    struct photon *photons; /* [n], by cell */
    float *x, *y, *z;       /* [n]: where they are, again */
    struct photon *landed;  /* [n_emitted], as traced; n_casters 0: lost */
    uint32_t *first;        /* [n_cells + 1] */
    uint32_t n, n_cells, n_emitted;
    float radius;
};

lmn_status photon_map_new(uint32_t n_emitted, struct photon_map **out, struct error *err);
void photon_map_free(struct photon_map *m);
uint64_t photon_map_memory(const struct photon_map *m);

/* Emits and traces photons, keyed by `key`, with all workers of the pool; on the calling thread
 * when that is NULL. */
void photon_map_trace(struct photon_map *m, const struct view *v, struct pool *pool,
                      const struct trace_settings *t, uint64_t key);

/* Sorts what has landed for a radius. */
void photon_map_build(struct photon_map *m, float radius);

/* Lets photons that are close together spread less: each over a circle where it has about `wanted`
 * others, at most the map's. Until then all spread over the map's radius. */
void photon_map_sharpen(struct photon_map *m, float wanted);

/* A radius within which a typical photon has a dozen others; 0 without photons. Builds the map
 * for a radius of its own. */
float photon_map_typical_radius(struct photon_map *m, float scene_radius);

/* A point that may receive caustics. */
struct photon_receiver {
    struct vec3 p, n;   /* n: geometric normal */
    struct frame frame; /* of shading */
    struct vec3 wi;     /* to where it is seen from, in that frame */
    /* Its material; NULL: Lambert's law of this reflectance on one side of the shading normal, 1 or
     * -1. */
    const struct bsdf_point *bsdf;
    struct vec3 reflectance;
    float side;
};

/* Sums by light group: the light of each photon times `throughput` goes to the group of its
 * emitter. */
struct photon_split {
    float *to; /* of group 0 */
    size_t stride;
    const uint32_t *group_of; /* [n_emitters] */
    struct vec3 throughput;
};

/* Caustic light that the point sends to where it is seen from; photons that met more than
 * `max_casters` casters do not count (negative: all do). split may be NULL. */
struct vec3 photon_map_gather(const struct photon_map *m, const struct photon_receiver *r,
                              int32_t max_casters, const struct photon_split *split);

/* What tracing in passes needs beside a view: two maps of n_photons, and a pass's part of what is
 * wanted. For windows of at most `n_pixels` pixels, and the same outputs as `wanted` has. */
struct photon_passes;
lmn_status photon_passes_new(uint32_t n_photons, size_t n_pixels, const struct trace_output *wanted,
                             struct photon_passes **out, struct error *err);
void photon_passes_free(struct photon_passes *p);
uint64_t photon_passes_memory(const struct photon_passes *p);

/* As view_trace_photons(); on the calling thread when pool is NULL, then it cannot fail. */
lmn_status photon_passes_trace(struct photon_passes *p, const struct view *v, struct pool *pool,
                               const struct trace_settings *t, const struct window *w,
                               struct trace_output *out, lmn_progress_fn *progress,
                               void *progress_user, struct error *err);

#endif
