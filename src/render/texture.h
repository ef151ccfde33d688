/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_TEXTURE_H
#define RENDER_TEXTURE_H

#include "image/half.h"
#include "math/warp.h"
#include "scene/scene.h"

/* A point of a mesh: p = (1-b1-b2) p0 + b1 p1 + b2 p2 of the triangle. */
struct mesh_place {
    const struct mesh *mesh;
    uint32_t triangle;
    float b1, b2;
};

/*
 * Texture lookup with Mitsuba's conventions: v = 0 is the picture's top row, texel (i, j) has its
 * centre at ((i + .5) / width, (j + .5) / height), 8-bit pictures are sRGB-decoded unless raw.
 */
struct texture_set {
    const struct texture *textures; /* the state's */
    const struct bitmap *bitmaps;   /* the scene's */
    const float (*decode)[256];     /* [2]: sRGB, raw; from texture_decode_init() */
    struct mesh_place place;        /* for mesh attributes; its mesh is NULL where there are none */
};

void texture_decode_init(float decode[2][256]);

/* For textures that are not constant. */
struct vec3 texture_lookup(const struct texture_set *set, const struct texture *t, float u,
                           float v);

/* Where a lookup reads a bitmap: four texels, by row and column, as numbers of their first channel,
 * and the shares of the second row and column. */
struct texture_spot {
    const struct texture *texture;
    size_t at[2][2];
    float share_x, share_y;
};

/* The lookup of a TEXTURE_BITMAP in two steps: memory is asked for between them. */
void texture_locate(struct texture_spot *spot, const struct texture_set *set,
                    const struct texture *t, float u, float v);
void texture_prefetch(const struct texture_set *set, const struct texture_spot *spot);
struct vec3 texture_read(const struct texture_set *set, const struct texture_spot *spot);

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

/* A float of a picture that may be sRGB-encoded (16-bit PNG): between the entries of the table. */
static inline float decode_between(const float decode[256], float v)
{
    float x = min_float(max_float(v, 0.0f), 1.0f) * 255.0f, i = min_float(floor_float(x), 254.0f);
    const float *p = decode + (int)i;
    return p[0] + (x - i) * (p[1] - p[0]);
}

/* A texel of a bitmap as RGB, by the number of its first channel; grey pictures are spread, alpha
 * is ignored. */
static inline struct vec3 bitmap_texel_at(const struct bitmap *b, const float decode[256],
                                          size_t at)
{
    int g = b->n_channels < 3 ? 0 : 1, h = 2 * g;
    if (b->u8) {
        const uint8_t *p = b->u8 + at;
        return vec3(decode[p[0]], decode[p[g]], decode[p[h]]);
    }
    if (b->f16) {
        const uint16_t *p = b->f16 + at;
        return vec3(half_to_float(p[0]), half_to_float(p[g]), half_to_float(p[h]));
    }
    const float *p = b->f32 + at;
    if (!b->is_srgb) return vec3(p[0], p[g], p[h]);
    return vec3(decode_between(decode, p[0]), decode_between(decode, p[g]),
                decode_between(decode, p[h]));
}

/* Texel (x, y). */
static inline struct vec3 bitmap_texel(const struct bitmap *b, const float decode[256], uint32_t x,
                                       uint32_t y)
{
    return bitmap_texel_at(b, decode, ((size_t)y * b->width + x) * b->n_channels);
}

/* Width / height of a bitmap, as projectors throw it; 1 for others. */
double texture_aspect(const struct texture_set *set, uint32_t index);

/* Average over the texture and its channels: a guide for sampling, not exact for large bitmaps. */
float texture_mean(const struct texture_set *set, uint32_t index);

#endif
