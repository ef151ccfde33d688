/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MATH_VEC_H
#define MATH_VEC_H

#include <math.h>
#include <stdbool.h>

/* Functions that loops of vector code call: they must vanish in them. */
#define MATH_INLINE static inline __attribute__((always_inline))

/* fmaxf() and fminf() are calls into libm on baseline x86-64, for the sake of NaN; these are one
 * instruction. With a NaN among the arguments they return the second. */
static inline float max_float(float a, float b)
{
    return a > b ? a : b;
}

static inline float min_float(float a, float b)
{
    return a < b ? a : b;
}

/* floorf() for |x| < 2^31, without the call. */
static inline float floor_float(float x)
{
    float t = (float)(int)x;
    return t > x ? t - 1.0f : t;
}

/* Three floats by value: points, directions and RGB colours. */
struct vec3 {
    float x, y, z;
};

static inline struct vec3 vec3(float x, float y, float z)
{
    return (struct vec3){x, y, z};
}

static inline struct vec3 vec3_splat(float s)
{
    return (struct vec3){s, s, s};
}

/* Of three floats in an array. */
static inline struct vec3 vec3_load(const float *p)
{
    return (struct vec3){p[0], p[1], p[2]};
}

static inline struct vec3 vec3_add(struct vec3 a, struct vec3 b)
{
    return (struct vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline struct vec3 vec3_sub(struct vec3 a, struct vec3 b)
{
    return (struct vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

/* Component by component: for colours. */
static inline struct vec3 vec3_mul(struct vec3 a, struct vec3 b)
{
    return (struct vec3){a.x * b.x, a.y * b.y, a.z * b.z};
}

static inline struct vec3 vec3_scale(struct vec3 a, float s)
{
    return (struct vec3){a.x * s, a.y * s, a.z * s};
}

/* a + b * s */
static inline struct vec3 vec3_madd(struct vec3 a, struct vec3 b, float s)
{
    return (struct vec3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}

static inline struct vec3 vec3_neg(struct vec3 a)
{
    return (struct vec3){-a.x, -a.y, -a.z};
}

static inline float vec3_dot(struct vec3 a, struct vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct vec3 vec3_cross(struct vec3 a, struct vec3 b)
{
    return (struct vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline float vec3_length(struct vec3 a)
{
    return sqrtf(vec3_dot(a, a));
}

static inline struct vec3 vec3_normalize(struct vec3 a)
{
    return vec3_scale(a, 1.0f / vec3_length(a));
}

static inline float vec3_max(struct vec3 a)
{
    return max_float(a.x, max_float(a.y, a.z));
}

static inline float vec3_mean(struct vec3 a)
{
    return (a.x + a.y + a.z) * (1.0f / 3.0f);
}

static inline bool vec3_is_zero(struct vec3 a)
{
    return a.x == 0.0f && a.y == 0.0f && a.z == 0.0f;
}

static inline bool vec3_is_finite(struct vec3 a)
{
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}

/* Luminance of linear sRGB (ITU-R BT.709). */
static inline float vec3_luminance(struct vec3 c)
{
    return 0.212671f * c.x + 0.715160f * c.y + 0.072169f * c.z;
}

/* An orthonormal frame. */
struct frame {
    struct vec3 s, t, n;
};

/* A frame around n (Duff et al. 2017, "Building an orthonormal basis, revisited"). */
static inline struct frame frame_from_normal(struct vec3 n)
{
    float sign = copysignf(1.0f, n.z);
    float a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    return (struct frame){
        .s = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x},
        .t = {b, sign + n.y * n.y * a, -n.y},
        .n = n,
    };
}

static inline struct vec3 frame_to_local(const struct frame *f, struct vec3 v)
{
    return (struct vec3){vec3_dot(v, f->s), vec3_dot(v, f->t), vec3_dot(v, f->n)};
}

static inline struct vec3 frame_to_world(const struct frame *f, struct vec3 v)
{
    return vec3_madd(vec3_madd(vec3_scale(f->s, v.x), f->t, v.y), f->n, v.z);
}

#endif
