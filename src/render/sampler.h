/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_SAMPLER_H
#define RENDER_SAMPLER_H

#include "base/rng.h"
#include "math/warp.h"
#include "scene/scene.h"

/*
 * Random numbers of one light path: a function of (seed, pixel, sample, dimension) alone.
 *
 * independent  PCG32 keyed by (seed, pixel, sample), drawn in order.
 * sobol        Owen-scrambled Sobol points in two dimensions, one freshly shuffled and scrambled
 *              set for every pair of dimensions and every pixel (Burley 2020, "Practical
 *              hash-based Owen scrambling"; the hash is Laine & Karras 2011). The even and the odd
 *              samples of a pixel are two independently scrambled sequences, so that the
 *              half-buffers stay independent estimates.
 */
struct sampler {
    enum sampler_kind kind;
    struct rng rng;
    uint32_t seed, index; /* sobol: of the pixel and half; position in the sequence */
    uint32_t dimension;
};

/* Pixel numbers are those of the full picture, so that a window repeats the whole. */
static inline struct sampler sampler_start(enum sampler_kind kind, uint64_t seed, uint64_t pixel,
                                           uint32_t sample)
{
    struct sampler s = {.kind = kind};
    if (kind == SAMPLER_INDEPENDENT) {
        s.rng = rng_keyed(seed, pixel, sample);
    } else {
        s.seed = (uint32_t)(rng_mix(rng_mix(rng_mix(seed) ^ pixel) + (sample & 1u)) >> 32);
        s.index = sample >> 1;
    }
    return s;
}

/* Dimensions below `dimension` are spent: paths of one pixel stay in step from bounce to bounce
 * whatever they drew before. */
static inline void sampler_skip_to(struct sampler *s, uint32_t dimension)
{
    s->dimension = dimension;
}

static inline uint32_t sampler_hash(uint32_t x)
{
    /* "lowbias32" (Wellons 2018) */
    x = (x ^ (x >> 16)) * 0x7FEB352Du;
    x = (x ^ (x >> 15)) * 0x846CA68Bu;
    return x ^ (x >> 16);
}

static inline uint32_t sampler_reverse(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = ((x & 0x0F0F0F0Fu) << 4) | ((x >> 4) & 0x0F0F0F0Fu);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
}

/* Owen scrambling of a bit-reversed fraction: every bit is flipped by a hash of the bits below it,
 * which are the digits before it. */
static inline uint32_t sampler_scramble_reversed(uint32_t x, uint32_t seed)
{
    x += seed;
    x ^= x * 0x6C50B47Cu;
    x ^= x * 0xB82F1E52u;
    x ^= x * 0xC7AFE638u;
    return x ^ x * 0x8D22F6E6u;
}

/* The second Sobol dimension, bit-reversed. Its matrix belongs to the primitive polynomial x + 1:
 * Pascal's triangle modulo 2, a product of five shifts. (The first is the bit-reversed index.) */
static inline uint32_t sampler_sobol_1(uint32_t index)
{
    uint32_t x = index;
    x ^= x >> 16;
    x ^= (x & 0xFF00FF00u) >> 8;
    x ^= (x & 0xF0F0F0F0u) >> 4;
    x ^= (x & 0xCCCCCCCCu) >> 2;
    x ^= (x & 0xAAAAAAAAu) >> 1;
    return x;
}

/* Uniform in [0,1): the top 24 bits. */
static inline float sampler_unit(uint32_t x)
{
    return (float)(x >> 8) * 0x1p-24f;
}

static inline struct vec2 sampler_next_2d(struct sampler *s)
{
    if (s->kind == SAMPLER_INDEPENDENT) {
        float x = rng_float(&s->rng);
        return (struct vec2){x, rng_float(&s->rng)};
    }
    uint32_t seed = sampler_hash(s->seed ^ (s->dimension * 0x9E3779B9u));
    s->dimension += 2;
    /* Shuffle the order of the points (a nested uniform scramble of the index), then scramble. */
    uint32_t index = sampler_reverse(sampler_scramble_reversed(sampler_reverse(s->index), seed));
    uint32_t x = sampler_scramble_reversed(index, sampler_hash(seed ^ 1u));
    uint32_t y = sampler_scramble_reversed(sampler_sobol_1(index), sampler_hash(seed ^ 2u));
    x = sampler_reverse(x);
    y = sampler_reverse(y);
    return (struct vec2){sampler_unit(x), sampler_unit(y)};
}

static inline float sampler_next_1d(struct sampler *s)
{
    if (s->kind == SAMPLER_INDEPENDENT) return rng_float(&s->rng);
    uint32_t seed = sampler_hash(s->seed ^ (s->dimension++ * 0x9E3779B9u));
    uint32_t index = sampler_reverse(sampler_scramble_reversed(sampler_reverse(s->index), seed));
    uint32_t x = sampler_scramble_reversed(index, sampler_hash(seed ^ 1u));
    return sampler_unit(sampler_reverse(x));
}

#endif
