/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_PHOTON_H
#define RENDER_PHOTON_H

#include "render/bsdf.h"
#include "render/view.h"

struct pool;
struct surface;

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
    struct vec3 wo;     /* unit, to where it came from */
    struct vec3 n;      /* of the surface, geometric */
    struct vec3 power;  /* its share of the flux */
    uint32_t n_casters; /* met on the way, at least 1 */
};

/* Photons of one pass, in a hashed grid. */
struct photon_map {
    struct photon *photons; /* [n], by cell */
    struct photon *landed;  /* [n_emitted], as traced; n_casters 0: lost */
    uint32_t *first;        /* [n_cells + 1] */
    uint32_t n, n_cells, n_emitted;
    float radius;
};

lmn_status photon_map_new(uint32_t n_emitted, struct photon_map **out, struct error *err);
void photon_map_free(struct photon_map *m);

/* Emits and traces photons, keyed by `key`, with all workers of the pool. */
void photon_map_trace(struct photon_map *m, const struct view *v, struct pool *pool,
                      const struct trace_settings *t, uint64_t key);

/* Sorts what has landed for a radius. */
void photon_map_build(struct photon_map *m, float radius);

/* A radius within which a typical photon has a dozen others; 0 without photons. Builds the map
 * for a radius of its own. */
float photon_map_typical_radius(struct photon_map *m, float scene_radius);

/* Caustic light that the surface sends to where it is seen from; photons that met more than
 * `max_casters` casters do not count (negative: all do). */
struct vec3 photon_map_gather(const struct photon_map *m, const struct surface *s,
                              const struct bsdf_point *b, int32_t max_casters);

#endif
