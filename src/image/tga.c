/* SPDX-License-Identifier: Apache-2.0 */
/* Truevision TGA: grey, colour and palettes, plain or packed. Read only. "Truevision TGA File
 * Format Specification", version 2.0. */
#include "image/codecs.h"

#include <string.h>

#include "base/mem.h"

enum { HEADER_SIZE = 18 };

struct tga {
    const unsigned char *at, *end;
    const unsigned char *palette; /* of palette_depth bits each */
    unsigned first, n_colours, palette_depth;
    unsigned kind; /* 1: palette, 2: colour, 3: grey */
    bool is_packed, is_top_down, is_mirrored;
    unsigned depth; /* bits per pixel */
    uint32_t width, height;
};

static unsigned u16(const unsigned char *p)
{
    return p[0] | (unsigned)p[1] << 8;
}

/* The format has no mark at its beginning: all that a header can say must make sense. */
static bool read_header(struct tga *t, const void *bytes, size_t size)
{
    const unsigned char *p = bytes;
    if (size < HEADER_SIZE) return false;
    t->kind = p[2] & 7;
    t->is_packed = (p[2] & 8) != 0;
    t->first = u16(p + 3);
    t->n_colours = u16(p + 5);
    t->palette_depth = p[7];
    t->width = u16(p + 12);
    t->height = u16(p + 14);
    t->depth = p[16];
    t->is_top_down = (p[17] & 0x20) != 0;
    t->is_mirrored = (p[17] & 0x10) != 0;
    t->at = p + HEADER_SIZE + p[0];
    t->end = p + size;
    bool has_palette = p[1] == 1;
    if (p[1] > 1 || (p[2] & ~0xBu) || t->kind < 1 || t->kind > 3 || (p[17] & 0xC0)) return false;
    if (t->width == 0 || t->height == 0 || (size_t)HEADER_SIZE + p[0] > size) return false;
    if (has_palette && t->palette_depth != 15 && t->palette_depth != 16 && t->palette_depth != 24 &&
        t->palette_depth != 32)
        return false;
    if (has_palette) {
        size_t palette_size = (size_t)t->n_colours * ((t->palette_depth + 7) / 8);
        if (palette_size > (size_t)(t->end - t->at)) return false;
        t->palette = t->at;
        t->at += palette_size;
    }
    if (t->kind == 1) return has_palette && t->depth == 8;
    if (t->kind == 3) return t->depth == 8;
    return t->depth == 15 || t->depth == 16 || t->depth == 24 || t->depth == 32;
}

bool tga_is(const void *bytes, size_t size)
{
    struct tga t = {0};
    return read_header(&t, bytes, size);
}

/* Blue, green, red (, alpha) of so many bits. */
static void colour(const unsigned char *p, unsigned depth, uint8_t *to)
{
    if (depth <= 16) {
        unsigned v = u16(p);
        for (int c = 0; c < 3; c++) {
            unsigned five = v >> (10 - 5 * c) & 31;
            to[c] = (uint8_t)(five << 3 | five >> 2);
        }
        return;
    }
    to[0] = p[2];
    to[1] = p[1];
    to[2] = p[0];
    if (depth == 32) to[3] = p[3];
}

/* A pixel of the file as bytes of the picture; false: a colour that the palette does not have. */
static bool convert(const struct tga *t, const unsigned char *p, uint8_t *to)
{
    if (t->kind == 3) {
        *to = *p;
    } else if (t->kind == 2) {
        colour(p, t->depth, to);
    } else {
        if (*p < t->first || *p - t->first >= t->n_colours) return false;
        colour(t->palette + (size_t)(*p - t->first) * ((t->palette_depth + 7) / 8),
               t->palette_depth, to);
    }
    return true;
}

static bool read_pixels(struct tga *t, struct bitmap *b)
{
    size_t n = (size_t)t->width * t->height, step = (t->depth + 7) / 8;
    size_t run = 0, left = 0; /* pixels until the next packet; of these, alike */
    for (size_t i = 0; i < n; i++) {
        if (t->is_packed && left == 0) {
            if (t->at == t->end) return false;
            left = (size_t)(*t->at & 127) + 1;
            run = *t->at++ & 128 ? left : 0;
        }
        if ((size_t)(t->end - t->at) < step) return false;
        size_t x = i % t->width, y = i / t->width;
        if (t->is_mirrored) x = t->width - 1 - x;
        if (!t->is_top_down) y = t->height - 1 - y;
        if (!convert(t, t->at, b->u8 + (y * t->width + x) * b->n_channels)) return false;
        if (t->is_packed) left--;
        if (!run || left == 0) t->at += step;
    }
    return true;
}

lmn_status tga_decode(const char *path, const void *bytes, size_t size, struct bitmap *out,
                      struct error *err)
{
    lmn_status status = LMN_OK;
    struct bitmap b = {.is_srgb = true};
    struct tga t = {0};
    if (!read_header(&t, bytes, size)) {
        status = fail(err, LMN_ERR_PARSE, "%s: TGA: damaged header", path);
        goto done;
    }
    unsigned depth = t.kind == 1 ? t.palette_depth : t.depth;
    b.width = t.width;
    b.height = t.height;
    b.n_channels = t.kind == 3 ? 1 : depth == 32 ? 4 : 3;
    TRY(codec_check_size(path, b.width, b.height, b.n_channels, 1, (uint64_t)(t.end - t.at), err));
    b.u8 = mem_new((size_t)b.width * b.height, b.n_channels);
    if (!b.u8) {
        status = fail_memory(err, path);
        goto done;
    }
    if (!read_pixels(&t, &b)) {
        status = fail(err, LMN_ERR_PARSE, "%s: TGA: damaged or cut off", path);
        goto done;
    }
    *out = b;
    b = (struct bitmap){0}; /* ownership moved to the caller */
done:
    bitmap_release(&b);
    return status;
}
