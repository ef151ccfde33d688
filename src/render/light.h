/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_LIGHT_H
#define RENDER_LIGHT_H

#include "render/surface.h"
#include "render/world.h"

/*
 * Choosing directions to lights. A light is chosen uniformly, then a direction to it: meshes and
 * disks by area, spheres by the cone that they fill, environments by radiance. Densities are in
 * solid angle at the reference point and include the choice of the light.
 */
struct light_sample {
    struct vec3 d;      /* unit, to the light */
    struct vec3 p;      /* the point on it, unless is_infinite */
    struct vec3 weight; /* radiance / density (point lights: intensity / distance^2 / choice) */
    float pdf;
    bool is_delta;    /* point light: no other strategy can find it */
    bool is_infinite; /* environment */
};

/* False when there is nothing to add (no lights, seen from behind, ...). */
bool light_sample(const struct view *v, struct vec3 reference, float u1, float u2,
                  struct light_sample *s);

/* Radiance that the surface sends along -d; zero when it does not shine or shows its back. */
struct vec3 light_surface_radiance(const struct view *v, const struct surface *s, struct vec3 d);

/* Density with which light_sample() at `reference` would have found the surface point s, which lies
 * in direction d at `distance`. */
float light_surface_pdf(const struct view *v, struct vec3 reference, const struct surface *s,
                        struct vec3 d, float distance);

/* Environments, lights v->first_environment and on: radiance arriving along -d, and the density of
 * choosing d. */
struct vec3 light_environment_radiance(const struct view *v, const struct light *l, struct vec3 d);
float light_environment_pdf(const struct view *v, const struct light *l, struct vec3 d);

/* Envmaps: light_envmap.c. d is in the map's own space. */
bool envmap_init(struct world_envmap *e, const struct bitmap *b, const float decode[256]);
void envmap_release(struct world_envmap *e);
struct vec3 envmap_eval(const struct world_envmap *e, struct vec3 d);
struct vec3 envmap_sample(const struct world_envmap *e, float u, float v, float *pdf);
float envmap_pdf(const struct world_envmap *e, struct vec3 d);

#endif
