/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_CODECS_H
#define IMAGE_CODECS_H

#include "base/str.h"
#include "image/image.h"

/*
 * One file format per .c file, behind image_load(), bitmap_load() and image_save(). Decoders take a
 * whole file in memory, which bounds what they can read; `path` is for messages. They check
 * declared sizes with codec_check_size() before they allocate. Encoders append a whole file to
 * `out`; their messages start without a path, which image_save() puts in front.
 */

/* Refuses images without pixels, with more than IMAGE_MAX_SIDE a side, with more than 4 GiB as
 * floats, or so large that `file_size` bytes cannot hold them even if all pixels are alike, or with
 * more than 2^28 samples from 1/64 of their number of bytes.
 * `sample_size`: bytes a sample takes in the file, uncompressed. */
lmn_status codec_check_size(const char *path, uint64_t width, uint64_t height, uint64_t n_channels,
                            uint64_t sample_size, uint64_t file_size, struct error *err);

/* Indices of the channels that make a picture: R, G, B, or Y alone, or the only channels there are
 * (1 or 3), then A when there is one. Returns how many (1 to 4), or 0 when there is no such choice.
 */
uint32_t codec_colour_channels(const struct image *im, int channels[4]);

/* "PF" or "Pf": float map of Paul Debevec; rows bottom up; both byte orders. */
bool pfm_is(const void *bytes, size_t size);
lmn_status pfm_decode(const char *path, const void *bytes, size_t size, struct image *out,
                      struct error *err);
lmn_status pfm_encode(const struct image *im, struct str *out, struct error *err);

/* colour_only: leaves out all but the channels of codec_colour_channels(). */
bool exr_is(const void *bytes, size_t size);
lmn_status exr_decode(const char *path, const void *bytes, size_t size, bool colour_only,
                      struct image *out, struct error *err);
lmn_status exr_encode(const struct image *im, struct str *out, struct error *err);

/* 8 bits or fewer come as u8, 16 bits as f32 in [0,1]. Text chunks become attributes of `text`,
 * when not NULL. */
bool png_is(const void *bytes, size_t size);
lmn_status png_decode(const char *path, const void *bytes, size_t size, struct bitmap *out,
                      struct image *text, struct error *err);
lmn_status png_encode(const struct image *im, double exposure, struct str *out, struct error *err);

bool jpeg_is(const void *bytes, size_t size);
lmn_status jpeg_decode(const char *path, const void *bytes, size_t size, struct bitmap *out,
                       struct error *err);

/* Radiance RGBE. */
bool hdr_is(const void *bytes, size_t size);
lmn_status hdr_decode(const char *path, const void *bytes, size_t size, struct image *out,
                      struct error *err);

/* Ask for TGA last: it has no mark of its own. */
bool tga_is(const void *bytes, size_t size);
lmn_status tga_decode(const char *path, const void *bytes, size_t size, struct bitmap *out,
                      struct error *err);

bool bmp_is(const void *bytes, size_t size);
lmn_status bmp_decode(const char *path, const void *bytes, size_t size, struct bitmap *out,
                      struct error *err);

#endif
