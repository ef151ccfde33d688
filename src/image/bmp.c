/* SPDX-License-Identifier: Apache-2.0 */
/* Windows BMP of 1, 4, 8, 16, 24 and 32 bits, not packed. Read only. */
#include "image/codecs.h"

#include <string.h>

#include "base/mem.h"

enum { FILE_HEADER = 14, CORE_HEADER = 12, INFO_HEADER = 40 };
enum { PLAIN = 0, MASKS = 3, MASKS_WITH_ALPHA = 6 };

struct bmp {
    const unsigned char *bytes;
    size_t size;
    uint32_t width, height, depth, compression;
    bool is_top_down;
    const unsigned char *palette;
    uint32_t n_colours, colour_size;
    uint32_t masks[4];
    size_t pixels, row_size;
};

static uint32_t u16(const unsigned char *p)
{
    return p[0] | (uint32_t)p[1] << 8;
}

static uint32_t u32(const unsigned char *p)
{
    return u16(p) | u16(p + 2) << 16;
}

bool bmp_is(const void *bytes, size_t size)
{
    return size >= FILE_HEADER + CORE_HEADER && memcmp(bytes, "BM", 2) == 0;
}

static const char *read_masks(struct bmp *b, uint32_t header)
{
    static const uint32_t usual[2][4] = {{0x7C00, 0x3E0, 0x1F, 0}, {0xFF0000, 0xFF00, 0xFF, 0}};
    memcpy(b->masks, usual[b->depth == 32], sizeof b->masks);
    if (b->compression == PLAIN) return NULL;
    size_t at = FILE_HEADER + INFO_HEADER; /* in a longer header, or right after the short one */
    uint32_t n = header >= 56 || b->compression == MASKS_WITH_ALPHA ? 4 : 3;
    if (at + 4 * n > b->size) return "cut off";
    b->masks[3] = 0;
    for (uint32_t i = 0; i < n; i++) b->masks[i] = u32(b->bytes + at + 4 * i);
    return NULL;
}

/* What is wrong, or NULL. */
static const char *read_header(struct bmp *b)
{
    const unsigned char *p = b->bytes + FILE_HEADER;
    uint32_t header = u32(p);
    if (header != CORE_HEADER && header < INFO_HEADER) return "unknown header";
    if (header > b->size - FILE_HEADER) return "cut off";
    b->pixels = u32(b->bytes + 10);
    if (header == CORE_HEADER) {
        b->width = u16(p + 4);
        b->height = u16(p + 6);
        b->depth = u16(p + 10);
        b->colour_size = 3;
    } else {
        uint32_t height = u32(p + 8);
        b->is_top_down = (height & 0x80000000u) != 0;
        b->width = u32(p + 4);
        b->height = b->is_top_down ? 0u - height : height;
        b->depth = u16(p + 14);
        b->compression = u32(p + 16);
        b->n_colours = u32(p + 32);
        b->colour_size = 4;
    }
    if (b->depth != 1 && b->depth != 4 && b->depth != 8 && b->depth != 16 && b->depth != 24 &&
        b->depth != 32)
        return "unknown number of bits per pixel";
    bool can_have_masks = b->depth == 16 || b->depth == 32;
    if (b->compression != PLAIN &&
        !(can_have_masks && (b->compression == MASKS || b->compression == MASKS_WITH_ALPHA)))
        return "packed pictures are not supported";
    if (can_have_masks) return read_masks(b, header);
    if (b->depth <= 8) {
        if (b->n_colours == 0 || b->n_colours > 1u << b->depth) b->n_colours = 1u << b->depth;
        b->palette = p + header;
        if ((size_t)b->n_colours * b->colour_size > b->size - FILE_HEADER - header)
            return "cut off";
    }
    return NULL;
}

/* The bits of a mask, stretched to eight. */
static uint8_t field(uint32_t v, uint32_t mask)
{
    if (!mask) return 0;
    uint32_t shift = (uint32_t)__builtin_ctz(mask), most = mask >> shift;
    return (uint8_t)(((uint64_t)((v & mask) >> shift) * 255 + most / 2) / most);
}

static bool read_row(const struct bmp *b, const unsigned char *row, uint32_t n_channels,
                     uint8_t *to)
{
    for (uint32_t x = 0; x < b->width; x++, to += n_channels) {
        if (b->depth <= 8) {
            uint32_t bit = x * b->depth, low = 8 - b->depth - bit % 8;
            uint32_t index = (uint32_t)row[bit / 8] >> low & ((1u << b->depth) - 1);
            if (index >= b->n_colours) return false;
            const unsigned char *c = b->palette + (size_t)index * b->colour_size;
            for (int k = 0; k < 3; k++) to[k] = c[2 - k];
        } else if (b->depth == 24) {
            for (int k = 0; k < 3; k++) to[k] = row[3 * (size_t)x + 2 - (size_t)k];
        } else {
            uint32_t v = b->depth == 16 ? u16(row + 2 * (size_t)x) : u32(row + 4 * (size_t)x);
            for (uint32_t k = 0; k < n_channels; k++) to[k] = field(v, b->masks[k]);
        }
    }
    return true;
}

lmn_status bmp_decode(const char *path, const void *bytes, size_t size, struct bitmap *out,
                      struct error *err)
{
    lmn_status status = LMN_OK;
    struct bitmap im = {.is_srgb = true};
    struct bmp b = {.bytes = bytes, .size = size};
    const char *wrong = read_header(&b);
    if (wrong) {
        status = fail(err, LMN_ERR_PARSE, "%s: BMP: %s", path, wrong);
        goto done;
    }
    im.width = b.width;
    im.height = b.height;
    im.n_channels = b.masks[3] ? 4 : 3;
    TRY(codec_check_size(path, b.width, b.height, im.n_channels, 1, size, err));
    b.row_size = ((size_t)b.width * b.depth + 31) / 32 * 4;
    if (b.pixels > size || (size - b.pixels) / b.row_size < b.height) {
        status = fail(err, LMN_ERR_PARSE, "%s: BMP: cut off", path);
        goto done;
    }
    im.u8 = mem_new((size_t)im.width * im.height, im.n_channels);
    if (!im.u8) {
        status = fail_memory(err, path);
        goto done;
    }
    for (uint32_t y = 0; y < b.height; y++) {
        uint32_t to = b.is_top_down ? y : b.height - 1 - y;
        if (read_row(&b, b.bytes + b.pixels + y * b.row_size, im.n_channels,
                     im.u8 + (size_t)to * b.width * im.n_channels))
            continue;
        status = fail(err, LMN_ERR_PARSE, "%s: BMP: a colour that the palette does not have", path);
        goto done;
    }
    *out = im;
    im = (struct bitmap){0}; /* ownership moved to the caller */
done:
    bitmap_release(&im);
    return status;
}
