/* SPDX-License-Identifier: Apache-2.0 */
/* What the compact network sees, pixel by pixel: what sight_lanes.h must compute, and what runs
 * where there is no AVX2. */
#include "train/sight_inside.h"

#include <math.h>

static float finite_or_zero(float x)
{
    return isfinite(x) ? x : 0.0f;
}

static struct vec3 load(const float *b, int channel)
{
    return vec3(finite_or_zero(b[channel]), finite_or_zero(b[channel + 1]),
                finite_or_zero(b[channel + 2]));
}

static float *put(float *to, struct vec3 v)
{
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
    return to + 3;
}

/* Direction, and how near what lies at v from the origin is: 1 there, 0 far away. */
static float *put_direction(float *to, struct vec3 v)
{
    float length = vec3_length(v);
    to = put(to, vec3_scale(v, length > 0.0f ? 1.0f / length : 0.0f));
    *to++ = 1.0f / (1.0f + length);
    return to;
}

/* The normal on the side that is looked at. */
static struct vec3 facing_normal(const float *b)
{
    const struct vec3 n = load(b, BUFFER_NORMAL), wo = load(b, BUFFER_WO);
    const float side = vec3_dot(load(b, BUFFER_GEO_NORMAL), wo);
    return side < 0.0f ? vec3_sub(n, vec3_scale(n, 2.0f)) : n;
}

/* That buffer is zero on diffuse surfaces. */
static bool is_glossy(const float *b)
{
    return !vec3_is_zero(load(b, BUFFER_WI));
}

static float *surface(const float *b, struct vec3 n, float *to)
{
    struct vec3 wo = load(b, BUFFER_WO);
    const bool has_gloss = is_glossy(b);
    const struct vec3 none = {0, 0, 0};
    struct vec3 mirrored = vec3_sub(vec3_scale(n, 2.0f * vec3_dot(n, wo)), wo);
    to = put(to, n);
    to = put(to, has_gloss ? wo : none);
    to = put(to, has_gloss ? mirrored : none);
    *to++ = finite_or_zero(b[BUFFER_ROUGHNESS]);
    to = put(to, load(b, BUFFER_ALBEDO));
    *to++ = has_gloss ? 1.0f : 0.0f;
    return to;
}

/* The point of the segment from p to q that is closest to the origin. */
static struct vec3 closest(struct vec3 p, struct vec3 q)
{
    struct vec3 d = vec3_sub(q, p);
    float length2 = vec3_dot(d, d);
    float t = length2 > 0.0f ? -vec3_dot(p, d) / length2 : 0.0f;
    return vec3_madd(p, d, min_float(max_float(t, 0.0f), 1.0f));
}

static void scale_of(const float *b, float *to)
{
    const bool is_hit = b[BUFFER_DEPTH] > 0.0f;
    const float least = is_glossy(b) ? LEAST_SCALE : 0.0f;
    for (int c = 0; c < 3; c++) {
        const float albedo = finite_or_zero(b[BUFFER_ALBEDO + c]);
        to[c] = is_hit ? max_float(albedo, least) : 0.0f;
    }
}

/* Returns where the next features go. */
static float *look_at_frame(const struct scene_frame *frame, struct vec3 p, struct vec3 *local,
                            float *x, float *f)
{
    if (!frame->is_visible) {
        put(x, vec3_splat(0.5f));
        f = put(f, vec3_splat(0.0f));
        *f++ = 0.0f;
        return f;
    }
    *local = transform_point(&frame->to_local, p);
    float scale_to_cube = 0.5f / (1.0f + vec3_length(*local));
    put(x, vec3_madd(vec3_splat(0.5f), *local, scale_to_cube));
    return put_direction(f, *local);
}

static float *look_at_passage(const struct scene_frame *frame, struct vec3 local, struct vec3 light,
                              float *f)
{
    struct vec3 at = closest(local, light);
    float nearness = frame->is_visible ? 1.0f / (1.0f + vec3_length(at)) : 0.0f;
    f = put(f, vec3_scale(at, nearness));
    *f++ = nearness;
    return f;
}

void sight_look_plain(const struct sight_job *j)
{
    const struct sight_moment *m = j->moment;
    for (size_t i = 0; i < j->n; i++) {
        const float *b = j->buffers + i * BUFFER_CHANNELS;
        float *x = j->positions + i * (1 + m->n_frames) * 3;
        float *f = j->features + i * m->n_features;
        const struct vec3 p = load(b, BUFFER_POSITION), normal = facing_normal(b);
        const struct vec3 in_box = vec3_sub(p, m->corner);
        struct vec3 local[SIGHT_FRAMES] = {0};
        x = put(x, vec3(in_box.x / m->size.x, in_box.y / m->size.y, in_box.z / m->size.z));
        f = surface(b, normal, f);
        for (uint32_t k = 0; k < m->n_frames; k++, x += 3)
            f = look_at_frame(&m->frames[k], p, &local[k], x, f);
        for (uint32_t l = 0; l < m->n_lights; l++) {
            f = put_direction(f, vec3_scale(vec3_sub(m->lights[l], p), m->light_scale));
            *f = vec3_dot(vec3(f[-4], f[-3], f[-2]), normal);
            f++;
            for (uint32_t k = 0; k < m->n_frames; k++)
                f = look_at_passage(&m->frames[k], local[k], m->local_lights[l][k], f);
        }
        *f++ = 1.0f;
        scale_of(b, j->scale + 3 * i);
    }
}
