/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BASE_RNG_H
#define BASE_RNG_H

#include <stdint.h>

/*
 * Random numbers that are a pure function of a key, so that results do not depend on threads:
 * hash the key's words into a start state, then draw in order. PCG32 (O'Neill 2014, XSH-RR).
 * The whole state is two words: it can be saved in a checkpoint.
 */
struct rng {
    uint64_t state, stream; /* stream is odd */
};

/* SplitMix64's finaliser (Steele et al. 2014): a bijection with full avalanche. */
static inline uint64_t rng_mix(uint64_t x)
{
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

/* Numbers keyed by (seed, a, b): e.g. (seed, pixel, sample). Different keys are independent. */
static inline struct rng rng_keyed(uint64_t seed, uint64_t a, uint64_t b)
{
    uint64_t h = rng_mix(rng_mix(rng_mix(seed) ^ a) ^ b);
    return (struct rng){.state = h, .stream = (rng_mix(h) << 1) | 1u};
}

static inline uint32_t rng_u32(struct rng *r)
{
    uint64_t s = r->state;
    r->state = s * 6364136223846793005u + r->stream;
    uint32_t x = (uint32_t)(((s >> 18) ^ s) >> 27), rot = (uint32_t)(s >> 59);
    return (x >> rot) | (x << ((32u - rot) & 31u));
}

/* Uniform in [0, 1): never 1. */
static inline float rng_float(struct rng *r)
{
    return (float)(rng_u32(r) >> 8) * 0x1p-24f;
}

static inline double rng_double(struct rng *r)
{
    uint64_t hi = rng_u32(r) >> 5, lo = rng_u32(r) >> 6;
    return (double)(hi * 67108864u + lo) * 0x1p-53;
}

/* Uniform in {0, ..., n-1}, n > 0 (Lemire's multiply; its bias of n/2^32 does not matter here). */
static inline uint32_t rng_below(struct rng *r, uint32_t n)
{
    return (uint32_t)(((uint64_t)rng_u32(r) * n) >> 32);
}

#endif
