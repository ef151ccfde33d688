/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_MICROFACET_H
#define RENDER_MICROFACET_H

#include "math/warp.h"
#include "scene/scene.h"

/*
 * Distributions of microfacet normals m on rough surfaces, in the shading frame (z: normal), with
 * Smith shadowing and sampling of the normals visible from wi (Heitz & d'Eon 2014; GGX: Heitz
 * 2018; Beckmann: Jakob 2014). Same functions as Mitsuba's, its rational fit of Beckmann's G1
 * included.
 */
struct microfacet {
    enum microfacet_kind kind;
    float alpha_u, alpha_v; /* at least 1e-4 */
};

static inline struct microfacet microfacet(enum microfacet_kind kind, float alpha_u, float alpha_v)
{
    return (struct microfacet){kind, max_float(alpha_u, 1e-4f), max_float(alpha_v, 1e-4f)};
}

/* D(m): density of facets, per projected area and solid angle. */
float microfacet_d(const struct microfacet *f, struct vec3 m);

/* G1(v, m): the fraction of facets of normal m that v sees. */
float microfacet_g1(const struct microfacet *f, struct vec3 v, struct vec3 m);

/* A normal visible from wi (wi.z > 0), and its density D(m) G1(wi, m) |wi.m| / wi.z. */
struct vec3 microfacet_normal(const struct microfacet *f, struct vec3 wi, float u, float v);
float microfacet_pdf(const struct microfacet *f, struct vec3 wi, struct vec3 m);

#endif
