/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_RENDER_SHELF_H
#define TESTS_RENDER_SHELF_H

#include <math.h>
#include <string.h>

#include "base/rng.h"
#include "bsdf_checks.h"

#include "../image/cmocka_all.h"

/* Materials by their descriptions, as a scene's state has them: put() one, prepare() all, look one
 * up with point_at(). Emptied by shelf.n_bsdfs = shelf.n_textures = 0. */
enum { MAX_BSDFS = 64, MAX_TEXTURES = 256, MAX_COATS = 4 };

/* A state in small. */
struct shelf {
    struct bsdf bsdfs[MAX_BSDFS];
    struct material materials[MAX_BSDFS];
    struct texture textures[MAX_TEXTURES];
    struct coat coats[MAX_COATS];
    struct bsdf_point ready[2 * MAX_BSDFS];
    struct texture_set set;
    uint32_t n_bsdfs, n_textures;
};

static struct shelf shelf;

static inline uint32_t color(float r, float g, float b)
{
    assert_true(shelf.n_textures < MAX_TEXTURES);
    shelf.textures[shelf.n_textures] = (struct texture){.value = {r, g, b}};
    return shelf.n_textures++;
}

static inline uint32_t number(float x)
{
    return color(x, x, x);
}

/* A new description, white in x. */
static inline struct bsdf *put(enum bsdf_kind kind)
{
    assert_true(shelf.n_bsdfs < MAX_BSDFS);
    struct bsdf *f = &shelf.bsdfs[shelf.n_bsdfs++];
    *f = bsdf_blank(kind);
    f->eta = 1.5f;
    f->reflectance = color(1, 0.5f, 0.25f);
    return f;
}

static inline uint32_t index_of(const struct bsdf *f)
{
    return (uint32_t)(f - shelf.bsdfs);
}

static inline struct bsdf *rough(enum bsdf_kind kind, enum microfacet_kind facets, float alpha)
{
    struct bsdf *f = put(kind);
    f->distribution = facets;
    f->alpha_u = f->alpha_v = number(alpha);
    return f;
}

static inline struct bsdf *phong(enum bsdf_kind kind, float exponent)
{
    struct bsdf *f = put(kind);
    f->reflectance = color(0.4f, 0.3f, 0.1f);
    f->specular_reflectance = color(0.6f, 0.2f, 0.5f);
    f->exponent = number(exponent);
    return f;
}

static inline struct bsdf *blend(const struct bsdf *a, const struct bsdf *b, float weight)
{
    struct bsdf *f = put(BSDF_BLEND);
    f->child[0] = index_of(a);
    f->child[1] = index_of(b);
    f->weight = number(weight);
    return f;
}

static inline struct bsdf *around(enum bsdf_kind kind, const struct bsdf *child)
{
    struct bsdf *f = put(kind);
    f->child[0] = f->child[1] = index_of(child);
    return f;
}

/* A principled material with the slots that a list of (slot, value) names. */
static inline struct bsdf *principled(float roughness, const float (*values)[2], int n)
{
    struct bsdf *f = put(BSDF_PRINCIPLED);
    f->alpha_u = f->alpha_v = number(roughness);
    for (int i = 0; i < PRINCIPLED_SLOTS; i++) f->principled[i] = number(0);
    for (int i = 0; i < n; i++) f->principled[(int)values[i][0]] = number(values[i][1]);
    return f;
}

static inline void prepare(void)
{
    shelf.set = (struct texture_set){.textures = shelf.textures};
    material_init(shelf.materials, shelf.bsdfs, shelf.n_bsdfs, &shelf.set, shelf.coats,
                  shelf.ready);
}

static inline struct bsdf_point point_at(const struct bsdf *f, struct vec3 wi)
{
    struct bsdf_point p;
    const struct bsdf_place at = {.wi = wi, .n = {0, 0, 1}, .dp_du = {1, 0, 0}, .dp_dv = {0, 1, 0}};
    bsdf_point_init(&p, shelf.materials, index_of(f), &shelf.set, &at);
    return p;
}

#endif
