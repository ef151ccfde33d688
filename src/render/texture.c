/* SPDX-License-Identifier: Apache-2.0 */
#include "render/texture.h"

#include "image/image.h"

void texture_decode_init(float decode[2][256])
{
    for (int i = 0; i < 256; i++) {
        decode[0][i] = srgb_decode((float)i / 255.0f);
        decode[1][i] = (float)i / 255.0f;
    }
}

/* The column or row that index i, within 2^30, stands for outside of 0 .. n-1; a picture has less
 * than 2^16. Division is slow: 32 bits of it are enough, and less where i is near. */
static uint32_t wrap(int32_t i, uint32_t n_texels, enum texture_wrap mode)
{
    const int32_t n = (int32_t)n_texels;
    if (i >= 0 && i < n) return (uint32_t)i;
    if (mode == TEXTURE_CLAMP) return i < 0 ? 0 : n_texels - 1;
    int32_t period = mode == TEXTURE_MIRROR ? 2 * n : n;
    int32_t r = i < 0 ? i + period : i - period;
    if (r < 0 || r >= period) r = i % period;
    if (r < 0) r += period;
    return (uint32_t)(r < n ? r : period - 1 - r);
}

/* Neighbours a and a + 1 of n columns or rows, and the share of the second, for a coordinate that
 * counts whole pictures; without divisions where the picture repeats. */
struct pair {
    uint32_t a, b;
    float share;
};

static inline struct pair neighbours(float t, uint32_t n, enum texture_wrap mode)
{
    if (mode == TEXTURE_REPEAT) t -= floor_float(t);
    float x = t * (float)n - 0.5f, below = floor_float(x);
    int32_t i = (int32_t)below, last = (int32_t)n - 1;
    struct pair p = {.share = x - below};
    if (mode == TEXTURE_REPEAT) { /* i is -1 .. n */
        i = i < 0 ? last : i > last ? 0 : i;
        p.a = (uint32_t)i;
        p.b = (uint32_t)(i == last ? 0 : i + 1);
    } else {
        p.a = wrap(i, n, mode);
        p.b = wrap(i + 1, n, mode);
    }
    return p;
}

void texture_locate(struct texture_spot *spot, const struct texture_set *set,
                    const struct texture *t, float u, float v)
{
    const struct bitmap *b = &set->bitmaps[t->bitmap];
    float x = t->to_uv[0][0] * u + t->to_uv[0][1] * v + t->to_uv[0][2];
    float y = t->to_uv[1][0] * u + t->to_uv[1][1] * v + t->to_uv[1][2];
    /* Far outside, floats hold no fraction any more and integers would overflow. */
    if (!(fabsf(x * (float)b->width) < 1e9f && fabsf(y * (float)b->height) < 1e9f)) x = y = 0.0f;
    struct pair i = {0}, j = {0};
    if (t->filter == TEXTURE_NEAREST) {
        i.a = i.b = wrap((int32_t)floor_float(x * (float)b->width), b->width, t->wrap);
        j.a = j.b = wrap((int32_t)floor_float(y * (float)b->height), b->height, t->wrap);
    } else {
        i = neighbours(x, b->width, t->wrap);
        j = neighbours(y, b->height, t->wrap);
    }
    const size_t width = b->width, n = b->n_channels;
    *spot = (struct texture_spot){
        .texture = t,
        .at = {{(j.a * width + i.a) * n, (j.a * width + i.b) * n},
               {(j.b * width + i.a) * n, (j.b * width + i.b) * n}},
        .share_x = i.share,
        .share_y = j.share,
    };
}

/* Neighbours in a row are in one line most of the time. */
void texture_prefetch(const struct texture_set *set, const struct texture_spot *spot)
{
    const struct bitmap *b = &set->bitmaps[spot->texture->bitmap];
    for (int j = 0; j < 2; j++) {
        if (b->u8)
            __builtin_prefetch(b->u8 + spot->at[j][0]);
        else if (b->f16)
            __builtin_prefetch(b->f16 + spot->at[j][0]);
        else
            __builtin_prefetch(b->f32 + spot->at[j][0]);
    }
}

/* Between four texels. */
static inline struct vec3 blend(const struct texture_spot *s, struct vec3 a, struct vec3 b,
                                struct vec3 c, struct vec3 d)
{
    struct vec3 top = vec3_madd(vec3_scale(a, 1.0f - s->share_x), b, s->share_x);
    struct vec3 bottom = vec3_madd(vec3_scale(c, 1.0f - s->share_x), d, s->share_x);
    return vec3_mul(vec3_madd(vec3_scale(top, 1.0f - s->share_y), bottom, s->share_y),
                    s->texture->value);
}

struct vec3 texture_read(const struct texture_set *set, const struct texture_spot *spot)
{
    const struct texture *t = spot->texture;
    const struct bitmap *b = &set->bitmaps[t->bitmap];
    const float *decode = set->decode[t->is_raw];
    const size_t(*at)[2] = spot->at;
    if (t->filter == TEXTURE_NEAREST)
        return vec3_mul(bitmap_texel_at(b, decode, at[0][0]), t->value);
    if (b->u8) { /* the common case, for one branch instead of four */
        const struct bitmap bytes = {.n_channels = b->n_channels, .u8 = b->u8};
        return blend(spot, bitmap_texel_at(&bytes, decode, at[0][0]),
                     bitmap_texel_at(&bytes, decode, at[0][1]),
                     bitmap_texel_at(&bytes, decode, at[1][0]),
                     bitmap_texel_at(&bytes, decode, at[1][1]));
    }
    return blend(spot, bitmap_texel_at(b, decode, at[0][0]), bitmap_texel_at(b, decode, at[0][1]),
                 bitmap_texel_at(b, decode, at[1][0]), bitmap_texel_at(b, decode, at[1][1]));
}

struct vec2 texture_gradient_1(const struct texture_set *set, uint32_t index, float u, float v)
{
    const struct texture *t = &set->textures[index];
    if (t->kind != TEXTURE_BITMAP || t->filter == TEXTURE_NEAREST) return (struct vec2){0, 0};
    const struct bitmap *b = &set->bitmaps[t->bitmap];
    const float *decode = set->decode[t->is_raw];
    float x = (t->to_uv[0][0] * u + t->to_uv[0][1] * v + t->to_uv[0][2]) * (float)b->width - 0.5f,
          y = (t->to_uv[1][0] * u + t->to_uv[1][1] * v + t->to_uv[1][2]) * (float)b->height - 0.5f;
    if (!(fabsf(x) < 1e9f && fabsf(y) < 1e9f)) return (struct vec2){0, 0};
    float fx = floor_float(x), fy = floor_float(y), corner[2][2];
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++)
            corner[j][i] = vec3_luminance(
                vec3_mul(bitmap_texel(b, decode, wrap((int32_t)fx + i, b->width, t->wrap),
                                      wrap((int32_t)fy + j, b->height, t->wrap)),
                         t->value));
    float wx = x - fx, wy = y - fy;
    float dx = (corner[0][1] - corner[0][0]) * (1.0f - wy) + (corner[1][1] - corner[1][0]) * wy;
    float dy = (corner[1][0] - corner[0][0]) * (1.0f - wx) + (corner[1][1] - corner[0][1]) * wx;
    dx *= (float)b->width;
    dy *= (float)b->height;
    return (struct vec2){t->to_uv[0][0] * dx + t->to_uv[1][0] * dy,
                         t->to_uv[0][1] * dx + t->to_uv[1][1] * dy};
}

/* Lines lie along whole numbers. */
static bool on_line(const struct texture *t, float x, float y)
{
    float dx = fabsf(x - floor_float(x + 0.5f)), dy = fabsf(y - floor_float(y + 0.5f));
    return dx < t->line_width || dy < t->line_width;
}

/* Zero where the mesh has no such attribute. */
static struct vec3 attribute_eval(const struct mesh_place *place, uint64_t key)
{
    const struct mesh *m = place->mesh;
    for (uint32_t i = 0; m && i < m->n_attributes; i++) {
        const struct mesh_attribute *a = &m->attributes[i];
        if (a->key != key) continue;
        const uint32_t n = a->n_channels, *at = m->indices + 3 * (size_t)place->triangle;
        const uint32_t g = n == 3 ? 1 : 0, h = 2 * g;
        if (a->is_of_faces) {
            const float *c = a->values + (size_t)place->triangle * n;
            return vec3(c[0], c[g], c[h]);
        }
        const float weights[3] = {1.0f - place->b1 - place->b2, place->b1, place->b2};
        struct vec3 sum = {0};
        for (int k = 0; k < 3; k++) {
            const float *c = a->values + (size_t)at[k] * n;
            sum = vec3_madd(sum, vec3(c[0], c[g], c[h]), weights[k]);
        }
        return sum;
    }
    return vec3_splat(0.0f);
}

struct vec3 texture_lookup(const struct texture_set *set, const struct texture *t, float u, float v)
{
    if (t->kind == TEXTURE_CONSTANT) return t->value;
    if (t->kind == TEXTURE_MESH_ATTRIBUTE)
        return vec3_mul(attribute_eval(&set->place, t->attribute), t->value);
    if (t->kind == TEXTURE_BITMAP) {
        struct texture_spot spot;
        texture_locate(&spot, set, t, u, v);
        return texture_read(set, &spot);
    }
    float x = t->to_uv[0][0] * u + t->to_uv[0][1] * v + t->to_uv[0][2];
    float y = t->to_uv[1][0] * u + t->to_uv[1][1] * v + t->to_uv[1][2];
    if (t->kind == TEXTURE_CHECKERBOARD) {
        if (!(fabsf(x) < 1e9f && fabsf(y) < 1e9f)) x = y = 0.0f;
        bool is_right = x - floor_float(x) > 0.5f, is_upper = y - floor_float(y) > 0.5f;
        return vec3_mul(is_right == is_upper ? t->color0 : t->color1, t->value);
    }
    return vec3_mul(on_line(t, x, y) ? t->color1 : t->color0, t->value); /* a grid */
}

double texture_aspect(const struct texture_set *set, uint32_t index)
{
    const struct texture *t = &set->textures[index];
    if (t->kind != TEXTURE_BITMAP) return 1.0;
    const struct bitmap *b = &set->bitmaps[t->bitmap];
    return (double)b->width / (double)b->height;
}

float texture_mean(const struct texture_set *set, uint32_t index)
{
    const struct texture *t = &set->textures[index];
    if (t->kind == TEXTURE_CONSTANT) return vec3_mean(t->value);
    if (t->kind == TEXTURE_CHECKERBOARD)
        return 0.5f * vec3_mean(vec3_mul(vec3_add(t->color0, t->color1), t->value));
    if (t->kind == TEXTURE_GRID) {
        float between = max_float(1.0f - 2.0f * t->line_width, 0.0f);
        struct vec3 mean = vec3_madd(vec3_scale(t->color1, 1.0f - between * between), t->color0,
                                     between * between);
        return vec3_mean(vec3_mul(mean, t->value));
    }
    if (t->kind == TEXTURE_MESH_ATTRIBUTE) return 0.5f * vec3_mean(t->value); /* of no mesh yet */
    const struct bitmap *b = &set->bitmaps[t->bitmap];
    const float *decode = set->decode[t->is_raw];
    enum { GRID = 16 };
    struct vec3 sum = {0};
    for (uint32_t j = 0; j < GRID; j++)
        for (uint32_t i = 0; i < GRID; i++)
            sum = vec3_add(
                sum,
                bitmap_texel(b, decode, (uint32_t)(((2 * i + 1) * (uint64_t)b->width) / (2 * GRID)),
                             (uint32_t)(((2 * j + 1) * (uint64_t)b->height) / (2 * GRID))));
    return vec3_mean(vec3_mul(sum, t->value)) * (1.0f / (GRID * GRID));
}
