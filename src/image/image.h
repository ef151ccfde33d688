/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_IMAGE_H
#define IMAGE_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

enum { IMAGE_NAME_SIZE = 48, IMAGE_MAX_SIDE = 32768, IMAGE_MAX_CHANNELS = 128 };

struct image_attribute {
    char *name, *value; /* owned */
};

/*
 * Floats with named channels. data[(y * width + x) * n_channels + c], top row first; linear
 * radiance for colour. {0} is a valid empty image.
 */
struct image {
    uint32_t width, height, n_channels;
    char (*names)[IMAGE_NAME_SIZE]; /* n_channels, owned */
    float *data;                    /* owned, zeroed by image_init() */
    struct image_attribute *attributes;
    uint32_t n_attributes;
};

/* names may be NULL: then "R" | "Y", "A" | "R","G","B" | "R","G","B","A" by count. */
lmn_status image_init(struct image *im, uint32_t width, uint32_t height, uint32_t n_channels,
                      const char *const *names, struct error *err);
void image_release(struct image *im);
lmn_status image_set_attribute(struct image *im, const char *name, const char *value,
                               struct error *err);

/* Index of the channel of that name, or -1. */
int image_channel(const struct image *im, const char *name);

/*
 * EXR, PNG, JPEG, PFM, Radiance HDR, TGA, BMP, by content (never by extension). 8 and 16 bit files
 * are sRGB-decoded, alpha excepted. Of an EXR: the first flat part (scan lines, or the full-size
 * level of tiles), its data window; R, G, B, A first, then layer by layer. Text attributes come
 * along from EXR and PNG.
 */
lmn_status image_load(const char *path, struct image *out, struct error *err);

/*
 * By extension, or by `format` ("exr", "png", "pfm") when not NULL; path "-" is standard output.
 * EXR: scan lines, ZIP; R, G, B, A and the colours of the layers albedo and emission as half floats
 * (unless a value is too large for one: then all as float), everything else as floats; attributes
 * as text. PNG: 8 bit sRGB(clamp(exposure * RGB)), A as it is. PFM: RGB or Y, no attributes.
 */
lmn_status image_save(const struct image *im, const char *path, const char *format, double exposure,
                      struct error *err);

/*
 * A picture as a texture needs it: 8-bit files stay 8-bit (a quarter of the memory), files of
 * floats that half floats can hold exactly become half floats, others stay float. Channels
 * interleaved, top row first, values as stored (no colour decoding). 1: grey, 2: grey and alpha, 3:
 * RGB, 4: RGB and alpha; other channels of an EXR are left out. Float values are finite.
 */
struct bitmap {
    uint32_t width, height, n_channels; /* 1 to 4 */
    uint8_t *u8;                        /* one of the three is set; owned */
    uint16_t *f16;                      /* half.h */
    float *f32;
    bool is_srgb; /* colours are sRGB-encoded (PNG, JPEG, TGA, BMP), not linear (EXR, PFM, HDR) */
};

lmn_status bitmap_load(const char *path, struct bitmap *out, struct error *err);
void bitmap_release(struct bitmap *b);

/* sRGB transfer curve (IEC 61966-2-1), on [0,1]. */
float srgb_encode(float linear);
float srgb_decode(float encoded);

#endif
