/* SPDX-License-Identifier: Apache-2.0 */
/* PFM: "PF" (RGB) or "Pf" (grey), width, height, a scale whose sign is the byte order (negative:
 * little endian), one white space, then rows of floats, the bottom row first. */
#include "image/codecs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool pfm_is(const void *bytes, size_t size)
{
    const char *b = bytes;
    return size > 3 && b[0] == 'P' && (b[1] == 'F' || b[1] == 'f') && strchr(" \t\r\n", b[2]);
}

/* The next word of the header, moved past; false at the end or when it is too long. */
static bool next_word(const char **at, const char *end, char word[32])
{
    while (*at < end && strchr(" \t\r\n", **at)) ++*at;
    int n = 0;
    while (*at < end && **at && !strchr(" \t\r\n", **at) && n < 31) word[n++] = *(*at)++;
    word[n] = '\0';
    return n > 0 && *at < end && strchr(" \t\r\n", **at);
}

static bool is_size(double v)
{
    return v >= 0 && v <= 1e9 && v == floor(v);
}

lmn_status pfm_decode(const char *path, const void *bytes, size_t size, struct image *out,
                      struct error *err)
{
    const char *at = bytes, *end = at + size;
    char words[4][32];
    double numbers[4];
    for (int i = 0; i < 4; i++) {
        if (!next_word(&at, end, words[i]) || (i && !str_to_double(words[i], &numbers[i])))
            return fail(err, LMN_ERR_PARSE, "%s: PFM header is truncated or malformed", path);
    }
    at++; /* the one white space after the scale */
    double width = numbers[1], height = numbers[2], scale = numbers[3];
    if (!is_size(width) || !is_size(height) || scale == 0)
        return fail(err, LMN_ERR_PARSE, "%s: PFM header \"%s %s %s\" makes no sense", path,
                    words[1], words[2], words[3]);
    uint32_t n_channels = words[0][1] == 'F' ? 3 : 1;
    lmn_status status = codec_check_size(path, (uint64_t)width, (uint64_t)height, n_channels,
                                         sizeof(float), size, err);
    if (status != LMN_OK) return status;
    uint32_t w = (uint32_t)width, h = (uint32_t)height;
    size_t row = (size_t)w * n_channels;
    if ((size_t)(end - at) < row * h * sizeof(float))
        return fail(err, LMN_ERR_PARSE, "%s: file ends after %zu of %zu bytes of pixels", path,
                    (size_t)(end - at), row * h * sizeof(float));
    status = image_init(out, w, h, n_channels, NULL, err);
    if (status != LMN_OK) return status;

    float unit = (float)fabs(scale);
    for (uint32_t y = 0; y < h; y++) {
        float *to = out->data + (size_t)(h - 1 - y) * row;
        for (size_t i = 0; i < row; i++, at += 4) {
            uint32_t bits;
            memcpy(&bits, at, 4);
            if (scale > 0) bits = __builtin_bswap32(bits);
            memcpy(&to[i], &bits, 4);
            to[i] *= unit;
        }
    }
    return LMN_OK;
}

lmn_status pfm_encode(const struct image *im, struct str *out, struct error *err)
{
    int channels[4];
    uint32_t n = codec_colour_channels(im, channels);
    if (n == 0) return fail(err, LMN_ERR_ARGUMENT, "no channels R, G, B or Y to write as PFM");
    n = n >= 3 ? 3 : 1; /* PFM has no alpha */
    str_add(out, "%s\n%u %u\n-1.0\n", n == 3 ? "PF" : "Pf", im->width, im->height);
    for (uint32_t y = im->height; y-- > 0;) {
        const float *row = im->data + (size_t)y * im->width * im->n_channels;
        for (uint32_t x = 0; x < im->width; x++)
            for (uint32_t c = 0; c < n; c++)
                str_add_bytes(out, &row[(size_t)x * im->n_channels + (uint32_t)channels[c]], 4);
    }
    return LMN_OK;
}
