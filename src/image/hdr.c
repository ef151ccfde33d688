/* SPDX-License-Identifier: Apache-2.0 */
/* Radiance pictures (.hdr, .pic): RGB with a shared exponent, scan lines plain or packed. Read
 * only. "Real Pixels", G. Ward, Graphics Gems II, 1991, and the manual of Radiance. */
#include "image/codecs.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/mem.h"

struct hdr {
    const char *path;
    const unsigned char *at, *end;
    uint32_t width, height;
    bool is_bottom_up, is_mirrored;
    struct error *err;
};

bool hdr_is(const void *bytes, size_t size)
{
    return (size >= 10 && memcmp(bytes, "#?RADIANCE", 10) == 0) ||
           (size >= 6 && memcmp(bytes, "#?RGBE", 6) == 0);
}

static lmn_status fail_hdr(struct hdr *h, const char *what)
{
    return fail(h->err, LMN_ERR_PARSE, "%s: Radiance: %s", h->path, what);
}

/* The next line, without its end; false when it is too long or cut off. */
static bool read_line(struct hdr *h, char *line, size_t size)
{
    size_t n = 0;
    while (h->at < h->end && *h->at != '\n' && n + 1 < size) line[n++] = (char)*h->at++;
    if (h->at == h->end || *h->at != '\n') return false;
    h->at++;
    if (n > 0 && line[n - 1] == '\r') n--;
    line[n] = '\0';
    return true;
}

static lmn_status read_header(struct hdr *h)
{
    char line[512], axes[2][3];
    unsigned sizes[2];
    do {
        if (!read_line(h, line, sizeof line)) return fail_hdr(h, "the header does not end");
        if (strncmp(line, "FORMAT=", 7) == 0 && !strstr(line, "32-bit_rle_rgbe"))
            return fail_hdr(h, "only the format 32-bit_rle_rgbe is supported");
    } while (line[0]);
    if (!read_line(h, line, sizeof line) ||
        sscanf(line, "%2s %9u %2s %9u", axes[0], &sizes[0], axes[1], &sizes[1]) != 4)
        return fail_hdr(h, "no line with the size");
    if (strcmp(axes[0] + 1, "Y") != 0 || strcmp(axes[1] + 1, "X") != 0)
        return fail_hdr(h, "pictures stored column by column are not supported");
    h->height = sizes[0];
    h->width = sizes[1];
    h->is_bottom_up = axes[0][0] == '+';
    h->is_mirrored = axes[1][0] == '-';
    return LMN_OK;
}

/* A line of the older kind: pixels, of which 1 1 1 n repeats the one before n times; several of
 * these in a row are digits of one count. */
static bool read_old_line(struct hdr *h, unsigned char *rgbe)
{
    uint32_t x = 0, shift = 0;
    while (x < h->width) {
        if (h->end - h->at < 4) return false;
        const unsigned char *p = h->at;
        h->at += 4;
        if (p[0] == 1 && p[1] == 1 && p[2] == 1) {
            uint64_t n = shift < 32 ? (uint64_t)p[3] << shift : h->width;
            if (x == 0 || n > h->width - x) return false;
            for (uint64_t k = 0; k < n; k++, x++) memcpy(rgbe + 4 * x, rgbe + 4 * (x - 1), 4);
            shift += 8;
        } else {
            memcpy(rgbe + 4 * x++, p, 4);
            shift = 0;
        }
    }
    return true;
}

/* A line of the newer kind: the four components one after the other, each in runs. */
static bool read_new_line(struct hdr *h, unsigned char *rgbe)
{
    h->at += 4;
    for (uint32_t c = 0; c < 4; c++) {
        for (uint32_t x = 0; x < h->width;) {
            if (h->end - h->at < 2) return false;
            uint32_t n = *h->at++;
            bool is_run = n > 128;
            if (is_run) n -= 128;
            if (n == 0 || n > h->width - x) return false;
            if (!is_run && (size_t)(h->end - h->at) < n) return false;
            for (uint32_t k = 0; k < n; k++) rgbe[4 * x++ + c] = h->at[is_run ? 0 : k];
            h->at += is_run ? 1 : n;
        }
    }
    return true;
}

static bool read_scan_line(struct hdr *h, unsigned char *rgbe)
{
    const unsigned char *p = h->at;
    if (h->end - p < 4) return false;
    bool is_new = h->width >= 8 && h->width < 32768 && p[0] == 2 && p[1] == 2 &&
                  ((uint32_t)p[2] << 8 | p[3]) == h->width;
    return is_new ? read_new_line(h, rgbe) : read_old_line(h, rgbe);
}

lmn_status hdr_decode(const char *path, const void *bytes, size_t size, struct image *out,
                      struct error *err)
{
    lmn_status status = LMN_OK;
    struct image im = {0};
    struct hdr h = {
        .path = path, .at = bytes, .end = (const unsigned char *)bytes + size, .err = err};
    unsigned char *rgbe = NULL;
    TRY(read_header(&h));
    TRY(codec_check_size(path, h.width, h.height, 3, 1, (uint64_t)(h.end - h.at), err));
    TRY(image_init(&im, h.width, h.height, 3, NULL, err));
    rgbe = mem_new(h.width, 4);
    if (!rgbe) {
        status = fail_memory(err, path);
        goto done;
    }
    for (uint32_t y = 0; y < h.height; y++) {
        if (!read_scan_line(&h, rgbe)) {
            status = fail_hdr(&h, "damaged or cut off");
            goto done;
        }
        float *row = im.data + (size_t)(h.is_bottom_up ? h.height - 1 - y : y) * h.width * 3;
        for (uint32_t x = 0; x < h.width; x++) {
            const unsigned char *p = rgbe + 4 * (size_t)x;
            float scale = p[3] ? ldexpf(1.0f, p[3] - (128 + 8)) : 0.0f;
            float *to = row + 3 * (size_t)(h.is_mirrored ? h.width - 1 - x : x);
            for (int c = 0; c < 3; c++) to[c] = (float)p[c] * scale;
        }
    }
    *out = im;
    im = (struct image){0}; /* ownership moved to the caller */
done:
    image_release(&im);
    mem_free(rgbe);
    return status;
}
