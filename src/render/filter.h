/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_FILTER_H
#define RENDER_FILTER_H

#include "math/warp.h"
#include "scene/scene.h"

/*
 * Pixel filters, importance-sampled (Ernst et al. 2006): a pixel's samples are distributed around
 * its centre like the filter's values, and weigh the same. All filters are products of a profile
 * in x and one in y, symmetric about 0. The gaussian is shifted down to end at 0, as Mitsuba's.
 */
enum { FILTER_STEPS = 512 };

struct filter {
    enum filter_kind kind;
    float radius, stddev;
    float steps;      /* of the profile's table, per pixel */
    float table[257]; /* gaussian: quantiles of |x|, at steps that get finer in the tail */
    float profile[FILTER_STEPS + 2]; /* at |x| = radius * i / FILTER_STEPS; 0 at the end */
};

void filter_init(struct filter *f, enum filter_kind kind, float radius, float stddev);

/* The profile, with integral 1. */
float filter_eval(const struct filter *f, float x);

/* The same from a table, for splatting. */
static inline float filter_weight(const struct filter *f, float x)
{
    float at = min_float(fabsf(x) * f->steps, (float)FILTER_STEPS);
    uint32_t i = (uint32_t)at;
    return f->profile[i] + (at - (float)i) * (f->profile[i + 1] - f->profile[i]);
}

/* The distance from the pixel's centre that u in [0,1) falls on, for f->kind, which vector code
 * knows beforehand. */
static inline float filter_quantile(const struct filter *f, enum filter_kind kind, float u)
{
    float r = f->radius;
    if (kind == FILTER_BOX) return r * (2.0f * u - 1.0f);
    if (kind == FILTER_TENT) return r * warp_tent(u);
    float rest = 2.0f * (u < 0.5f ? u : 1.0f - u), part = 256.0f * (1.0f - sqrtf(rest));
    int i = (int)part;
    i = i > 255 ? 255 : i;
    float x = f->table[i] + (f->table[i + 1] - f->table[i]) * (part - (float)i);
    return u < 0.5f ? -x : x;
}

/* A distance from the pixel's centre, u uniform in [0,1), restricted to [low, high] (-INFINITY and
 * INFINITY for the whole filter): pixels at the border of a picture take no samples from beyond. */
float filter_sample(const struct filter *f, float u, float low, float high);

#endif
