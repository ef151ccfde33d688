/* SPDX-License-Identifier: Apache-2.0 */
/* Loading and saving: finds the format, and converts between images and bitmaps. */
#include "image/image.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "base/mem.h"
#include "image/codecs.h"
#include "image/half.h"

/* Bytes of a file, and floats of an image, that we are willing to hold. */
static const uint64_t max_file_size = (uint64_t)2 << 30, max_data_size = (uint64_t)4 << 30;
/* A file may unpack to that many samples however small it is: 8192x8192 pixels of one colour. */
static const uint64_t max_flat_samples = (uint64_t)1 << 28;

lmn_status codec_check_size(const char *path, uint64_t width, uint64_t height, uint64_t n_channels,
                            uint64_t sample_size, uint64_t file_size, struct error *err)
{
    if (width < 1 || height < 1) return fail(err, LMN_ERR_PARSE, "%s: image without pixels", path);
    if (width > IMAGE_MAX_SIDE || height > IMAGE_MAX_SIDE)
        return fail(err, LMN_ERR_PARSE, "%s: image of %llux%llu pixels; a side can have %d at most",
                    path, (unsigned long long)width, (unsigned long long)height, IMAGE_MAX_SIDE);
    if (n_channels < 1 || n_channels > IMAGE_MAX_CHANNELS)
        return fail(err, LMN_ERR_PARSE, "%s: image of %llu channels; can have 1 to %d", path,
                    (unsigned long long)n_channels, IMAGE_MAX_CHANNELS);
    uint64_t samples = width * height * n_channels; /* < 2^37 */
    if (samples * sizeof(float) > max_data_size)
        return fail(
            err, LMN_ERR_PARSE, "%s: image of %llux%llu pixels and %llu channels: too large", path,
            (unsigned long long)width, (unsigned long long)height, (unsigned long long)n_channels);
    /* No format here packs more than deflate does, 1032 to 1. A file that claims more is cut off or
     * hostile, and we find out before we take the memory. */
    if (samples * sample_size / 1100 > file_size + 1024)
        return fail(err, LMN_ERR_PARSE,
                    "%s: file of %llu bytes is too short for %llux%llu pixels: truncated?", path,
                    (unsigned long long)file_size, (unsigned long long)width,
                    (unsigned long long)height);
    /* What is as packed and yet larger is hostile, too: a gigabyte of one colour in a megabyte. */
    if (samples > max_flat_samples && samples / 64 > file_size)
        return fail(err, LMN_ERR_PARSE,
                    "%s: file of %llu bytes unpacks to %llux%llu pixels: too large", path,
                    (unsigned long long)file_size, (unsigned long long)width,
                    (unsigned long long)height);
    return LMN_OK;
}

uint32_t codec_colour_channels(const struct image *im, int channels[4])
{
    static const char *const rgb[3] = {"R", "G", "B"};
    uint32_t n = 0;
    for (int i = 0; i < 3; i++) {
        channels[i] = image_channel(im, rgb[i]);
        n += channels[i] >= 0;
    }
    int alpha = image_channel(im, "A"), y = image_channel(im, "Y");
    if (n < 3 && y >= 0) {
        n = 1;
        channels[0] = y;
    } else if (n < 3) {
        n = im->n_channels - (alpha >= 0);
        if (n != 1 && n != 3) return 0;
        for (int c = 0, i = 0; c < (int)im->n_channels; c++)
            if (c != alpha) channels[i++] = c;
    }
    if (alpha >= 0) channels[n++] = alpha;
    return n;
}

static lmn_status read_image_file(const char *path, char **bytes, size_t *size, struct error *err)
{
    lmn_status status = file_read(path, (size_t)max_file_size, bytes, size, err);
    if (status != LMN_OK || *size > 0) return status;
    mem_free(*bytes);
    *bytes = NULL;
    return fail(err, LMN_ERR_PARSE, "%s: empty file", path);
}

static lmn_status fail_format(const char *path, struct error *err)
{
    return fail(err, LMN_ERR_PARSE,
                "%s: not an image that can be read (EXR, PNG, JPEG, PFM, HDR, TGA or "
                "BMP)",
                path);
}

/* Keeps the attributes that *im already has. */
static lmn_status linear_image(const struct bitmap *b, struct image *im, struct error *err)
{
    struct image fresh;
    lmn_status status = image_init(&fresh, b->width, b->height, b->n_channels, NULL, err);
    if (status != LMN_OK) return status;
    float table[256];
    for (int i = 0; i < 256; i++) table[i] = srgb_decode((float)i / 255);
    size_t n = (size_t)b->width * b->height * b->n_channels;
    bool has_alpha = b->n_channels % 2 == 0;
    for (size_t i = 0; i < n; i++) {
        bool is_alpha = has_alpha && i % b->n_channels == b->n_channels - 1;
        if (b->u8)
            fresh.data[i] = is_alpha ? (float)b->u8[i] / 255 : table[b->u8[i]];
        else
            fresh.data[i] = is_alpha ? b->f32[i] : srgb_decode(b->f32[i]);
    }
    fresh.attributes = im->attributes;
    fresh.n_attributes = im->n_attributes;
    *im = fresh;
    return LMN_OK;
}

/* The formats of floats: EXR, PFM, HDR. *is_one: it was one of them. */
static lmn_status decode_floats(const char *path, const void *bytes, size_t size, bool colour_only,
                                struct image *out, bool *is_one, struct error *err)
{
    *is_one = true;
    if (exr_is(bytes, size)) return exr_decode(path, bytes, size, colour_only, out, err);
    if (pfm_is(bytes, size)) return pfm_decode(path, bytes, size, out, err);
    if (hdr_is(bytes, size)) return hdr_decode(path, bytes, size, out, err);
    *is_one = false;
    return LMN_OK;
}

/* All others. */
static lmn_status decode_integers(const char *path, const void *bytes, size_t size,
                                  struct bitmap *out, struct image *text, struct error *err)
{
    if (png_is(bytes, size)) return png_decode(path, bytes, size, out, text, err);
    if (jpeg_is(bytes, size)) return jpeg_decode(path, bytes, size, out, err);
    if (bmp_is(bytes, size)) return bmp_decode(path, bytes, size, out, err);
    if (tga_is(bytes, size)) return tga_decode(path, bytes, size, out, err);
    return fail_format(path, err);
}

lmn_status image_load(const char *path, struct image *out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct image im = {0};
    struct bitmap b = {0};
    char *bytes = NULL;
    size_t size = 0;
    bool has_floats;
    *out = (struct image){0};
    TRY(read_image_file(path, &bytes, &size, err));
    TRY(decode_floats(path, bytes, size, false, &im, &has_floats, err));
    if (!has_floats) {
        TRY(decode_integers(path, bytes, size, &b, &im, err));
        TRY(linear_image(&b, &im, err));
    }
    *out = im;
    im = (struct image){0}; /* ownership moved to the caller */
done:
    image_release(&im);
    bitmap_release(&b);
    mem_free(bytes);
    return status;
}

/* Half the memory, where that loses nothing. */
static lmn_status make_half(const char *path, struct bitmap *b, struct error *err)
{
    size_t n = (size_t)b->width * b->height * b->n_channels, i = 0;
    uint16_t h;
    while (i < n && half_from_float(b->f32[i], &h)) i++;
    if (i < n) return LMN_OK;
    b->f16 = mem_new(n, sizeof *b->f16);
    if (!b->f16) return fail_memory(err, path);
    for (i = 0; i < n; i++) half_from_float(b->f32[i], &b->f16[i]);
    mem_free(b->f32);
    b->f32 = NULL;
    return LMN_OK;
}

/* Takes the colour channels out of an image of floats, and checks that a texture can use them. */
static lmn_status bitmap_from_image(const char *path, const struct image *im, struct bitmap *out,
                                    struct error *err)
{
    int channels[4];
    uint32_t n = codec_colour_channels(im, channels);
    if (n == 0)
        return fail(err, LMN_ERR_PARSE, "%s: no channels R, G, B or Y to use as a picture", path);
    size_t n_pixels = (size_t)im->width * im->height;
    struct bitmap b = {.width = im->width, .height = im->height, .n_channels = n};
    b.f32 = mem_new(n_pixels * n, sizeof *b.f32);
    if (!b.f32) return fail_memory(err, path);
    for (size_t i = 0; i < n_pixels; i++) {
        for (uint32_t c = 0; c < n; c++) {
            float v = im->data[i * im->n_channels + (uint32_t)channels[c]];
            if (!isfinite(v)) {
                bitmap_release(&b);
                return fail(err, LMN_ERR_PARSE, "%s: channel %s is not finite at pixel (%zu, %zu)",
                            path, im->names[channels[c]], i % im->width, i / im->width);
            }
            b.f32[i * n + c] = v;
        }
    }
    *out = b;
    return LMN_OK;
}

lmn_status bitmap_load(const char *path, struct bitmap *out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct image im = {0};
    char *bytes = NULL;
    size_t size = 0;
    bool has_floats;
    *out = (struct bitmap){0};
    TRY(read_image_file(path, &bytes, &size, err));
    TRY(decode_floats(path, bytes, size, true, &im, &has_floats, err));
    if (has_floats) {
        TRY(bitmap_from_image(path, &im, out, err));
        TRY(make_half(path, out, err));
    } else {
        TRY(decode_integers(path, bytes, size, out, NULL, err));
    }
done:
    if (status != LMN_OK) bitmap_release(out);
    image_release(&im);
    mem_free(bytes);
    return status;
}

void bitmap_release(struct bitmap *b)
{
    mem_free(b->u8);
    mem_free(b->f16);
    mem_free(b->f32);
    *b = (struct bitmap){0};
}

static const char *format_of(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot && !strchr(dot, '/') ? dot + 1 : "";
}

lmn_status image_save(const struct image *im, const char *path, const char *format, double exposure,
                      struct error *err)
{
    lmn_status status = LMN_OK;
    struct str file = {0};
    struct file_writer w = {0};
    struct error why = {0};
    if (!format) format = format_of(path);
    if (strcasecmp(format, "exr") == 0)
        status = exr_encode(im, &file, &why);
    else if (strcasecmp(format, "png") == 0)
        status = png_encode(im, exposure, &file, &why);
    else if (strcasecmp(format, "pfm") == 0)
        status = pfm_encode(im, &file, &why);
    else
        status = fail(&why, LMN_ERR_ARGUMENT, "cannot write \"%.32s\" images; exr, png or pfm?",
                      format);
    if (status == LMN_OK && file.failed) status = fail_memory(&why, "the encoded image");
    if (status != LMN_OK) {
        fail(err, status, "%s: %s", path, why.text);
        goto done;
    }
    TRY(file_writer_open(&w, path, err));
    fwrite(file.text, 1, file.length, w.f); /* a short write shows in ferror() at the commit */
    TRY(file_writer_commit(&w, err));
done:
    file_writer_release(&w);
    str_release(&file);
    return status;
}
