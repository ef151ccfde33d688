/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_HALF_H
#define IMAGE_HALF_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* Numbers of 16 bits (IEEE 754 binary16): those that are 0 or of normal size, up to 65504. */

static inline float half_to_float(uint16_t h)
{
    uint32_t rest = h & 0x7fffu, sign = (uint32_t)h >> 15 << 31;
    uint32_t bits = sign | (rest ? (rest << 13) + (112u << 23) : 0u); /* exponents from 15 to 127 */
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

/* False when `f` is not exactly one of them. */
static inline bool half_from_float(float f, uint16_t *h)
{
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    uint32_t sign = bits >> 16 & 0x8000u, rest = bits & 0x7fffffffu;
    *h = (uint16_t)sign;
    if (rest == 0) return true;
    if (rest < 113u << 23 || rest >= 143u << 23 || rest & 0x1fffu) return false;
    *h = (uint16_t)(sign | ((rest - (112u << 23)) >> 13));
    return true;
}

#endif
