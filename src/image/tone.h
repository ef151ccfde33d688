/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_TONE_H
#define IMAGE_TONE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/*
 * Linear numbers to the bytes that screens and PNG want: tone_byte(srgb_encode(x)), exactly, by two
 * look-ups. From 2^-13 to 1 an octave of floats is cut into 256 pieces, none of which holds more
 * than one of the places where the byte goes up.
 */
enum { TONE_OCTAVES = 13, TONE_PIECES = 256 };

struct tone {
    float least[257];                          /* the least number of each byte; [256]: infinity */
    uint8_t first[TONE_OCTAVES * TONE_PIECES]; /* the byte of each piece's least number */
};

/* Takes some 0.2 ms. */
void tone_init(struct tone *t);

/* A number of [0,1] to the nearest byte; what is no number becomes 0. */
static inline uint8_t tone_byte(float v)
{
    if (!(v > 0)) return 0;
    return v >= 1 ? 255 : (uint8_t)(v * 255 + 0.5f);
}

static inline uint8_t tone_of(const struct tone *t, float x)
{
    enum { SHIFT = 23 - 8, LEAST = (127 - TONE_OCTAVES) * TONE_PIECES };
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    if (!(x >= 0x1p-13f)) return 0;
    if (x >= 1.0f) return 255;
    const uint8_t first = t->first[(bits >> SHIFT) - LEAST];
    return (uint8_t)(first + (x >= t->least[first + 1]));
}

/* How radiance beyond what a screen shows ends: cut off, or as film does (the fit of Narkowicz 2015
 * to the ACES curve). */
enum tone_curve { TONE_SRGB, TONE_ACES };

struct pool;

/* out [n_pixels][3] from the first three of `stride` numbers of each pixel, times exposure. */
void tone_apply(const struct tone *t, struct pool *pool, const float *linear, size_t n_pixels,
                size_t stride, float exposure, enum tone_curve curve, uint8_t *out);

#endif
