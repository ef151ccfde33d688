/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_TEXTURE_H
#define RENDER_TEXTURE_H

#include "math/warp.h"
#include "scene/scene.h"

/*
 * Texture lookup with Mitsuba's conventions: v = 0 is the picture's top row, texel (i, j) has its
 * centre at ((i + .5) / width, (j + .5) / height), 8-bit pictures are sRGB-decoded unless raw.
 */
struct texture_set {
    const struct texture *textures; /* the state's */
    const struct bitmap *bitmaps;   /* the scene's */
    const float (*decode)[256];     /* [2]: sRGB, raw; from texture_decode_init() */
};

void texture_decode_init(float decode[2][256]);

/* For textures that are not constant. */
struct vec3 texture_lookup(const struct texture_set *set, const struct texture *t, float u,
                           float v);

static inline struct vec3 texture_eval(const struct texture_set *set, uint32_t index, float u,
                                       float v)
{
    const struct texture *t = &set->textures[index];
    return t->kind == TEXTURE_CONSTANT ? t->value : texture_lookup(set, t, u, v);
}

/* A number: colour pictures count by their luminance, as Mitsuba reads them. */
static inline float texture_eval_1(const struct texture_set *set, uint32_t index, float u, float v)
{
    const struct texture *t = &set->textures[index];
    return t->kind == TEXTURE_CONSTANT ? t->value.x : vec3_luminance(texture_lookup(set, t, u, v));
}

/* The same for an optional texture: `otherwise` when there is none. */
static inline struct vec3 texture_eval_or(const struct texture_set *set, uint32_t index, float u,
                                          float v, float otherwise)
{
    return index == SCENE_NONE ? vec3_splat(otherwise) : texture_eval(set, index, u, v);
}

/* How such a number changes with u and v: the slope of the bilinear patch; 0 for what is constant
 * but for edges. */
struct vec2 texture_gradient_1(const struct texture_set *set, uint32_t index, float u, float v);

/* Texel (x, y) of a bitmap as RGB; grey pictures are spread, alpha is ignored. */
static inline struct vec3 bitmap_texel(const struct bitmap *b, const float decode[256], uint32_t x,
                                       uint32_t y)
{
    size_t at = ((size_t)y * b->width + x) * b->n_channels;
    bool is_grey = b->n_channels < 3;
    if (b->u8) {
        const uint8_t *p = b->u8 + at;
        if (is_grey) return vec3_splat(decode[p[0]]);
        return vec3(decode[p[0]], decode[p[1]], decode[p[2]]);
    }
    const float *p = b->f32 + at;
    return is_grey ? vec3_splat(p[0]) : vec3(p[0], p[1], p[2]);
}

/* Width / height of a bitmap, as projectors throw it; 1 for others. */
double texture_aspect(const struct texture_set *set, uint32_t index);

/* Average over the texture and its channels: a guide for sampling, not exact for large bitmaps. */
float texture_mean(const struct texture_set *set, uint32_t index);

#endif
