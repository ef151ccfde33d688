/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_EMBREE_H
#define RENDER_EMBREE_H

#include <stdbool.h>
#include <stdint.h>

#include "scene/scene.h"

/*
 * Ray casting. embree.c is the only file that knows Embree; a move to another version or library
 * stays in it.
 *
 * accel      what all configurations share: one bottom-level structure per group.
 * accel_top  one configuration: the groups' instances. A scene whose only instance is the first one
 *            (everything that stays, at identity) is traced without a top level.
 */
struct accel;
struct accel_top;

struct ray {
    struct vec3 o;
    float t_min;
    struct vec3 d; /* need not be of unit length; t counts in it */
    float t_max;
};

struct hit {
    float t;
    float u, v;         /* barycentric: p = (1-u-v) p0 + u p1 + v p2; spheres and disks: 0 */
    struct vec3 ng;     /* geometric normal in the group's space, any length, not flipped */
    uint32_t shape;     /* within the group; SCENE_NONE: nothing was hit */
    uint32_t primitive; /* triangle of a mesh */
    uint32_t instance;
};

/* Builds the bottom levels (high quality, on the calling thread). `scene` must outlive *out. */
lmn_status accel_new(const struct scene *scene, uint32_t cpu, struct accel **out,
                     struct error *err);
void accel_free(struct accel *a);

/* The top level starts with all instances of scene->defaults, not yet ready to trace. */
lmn_status accel_top_new(const struct accel *a, struct accel_top **out, struct error *err);
void accel_top_free(struct accel_top *t);

/* Tells what changed, then accel_top_commit() once. No allocation of ours. */
void accel_top_set_instance(struct accel_top *t, uint32_t instance,
                            const struct transform *to_world, bool is_visible);
void accel_top_commit(struct accel_top *t);

/* Safe from many threads at once. */
void accel_intersect(const struct accel_top *t, const struct ray *r, struct hit *hit);

/* Rays from t = 0 in arrays, one lane each. */
struct accel_rays {
    const float *o[3], *d[3], *t_max;
};

/* The rays of `lanes` [n], n <= ACCEL_PACKET, at once; hits and flags are indexed by lane.
 * is_coherent: rays from one place in nearly one direction. */
enum { ACCEL_PACKET = 16 };
void accel_intersect_packet(const struct accel_top *t, const struct accel_rays *rays,
                            const uint32_t *lanes, uint32_t n, bool is_coherent, struct hit *hits);
void accel_occluded_packet(const struct accel_top *t, const struct accel_rays *rays,
                           const uint32_t *lanes, uint32_t n, bool *is_occluded);

/* Anything between t_min and t_max? */
bool accel_occluded(const struct accel_top *t, const struct ray *r);

#endif
