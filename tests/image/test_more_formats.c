/* SPDX-License-Identifier: Apache-2.0 */
/* Radiance HDR, TGA and BMP: one picture written in every way that is read, then damaged. */
#include "image/image.h"

#include <math.h>

#include "temp.h"

#include "ok.h"

#include "base/mem.h"
#include "base/rng.h"
#include "base/str.h"
#include "image/half.h"

enum { W = 12, H = 5, MAX_FILE = 4096 };

struct file {
    const char *name;
    unsigned char at[MAX_FILE];
    size_t n;
};

static void put(struct file *f, const void *bytes, size_t n)
{
    if (f->n + n > MAX_FILE) abort();
    memcpy(f->at + f->n, bytes, n);
    f->n += n;
}

static void put_byte(struct file *f, unsigned v)
{
    unsigned char c = (unsigned char)v;
    put(f, &c, 1);
}

static void put_le(struct file *f, uint32_t v, int n_bytes)
{
    for (int i = 0; i < n_bytes; i++) put_byte(f, (unsigned)((uint64_t)v >> (8 * i)) & 255);
}

/* The picture, four channels: flat on the left, so that runs have something to do. */
static uint8_t pixel(int x, int y, int c)
{
    if (c == 3) return (uint8_t)(255 - 20 * y);
    return (uint8_t)(x < 6 ? 40 * y + 5 * c : 16 * x + 3 * y + 20 * c);
}

/* ---- TGA ------------------------------------------------------------------------------------- */

enum { TGA_PALETTE = 1, TGA_COLOUR = 2, TGA_GREY = 3, TGA_PACKED = 8 };
enum { TOP_DOWN = 0x20, MIRRORED = 0x10 };

static void put_tga_pixel(struct file *f, int kind, int depth, int x, int y)
{
    if (kind != TGA_COLOUR) {
        put_byte(f, kind == TGA_GREY ? pixel(x, y, 0) : (unsigned)(y * W + x));
    } else if (depth == 16) {
        put_le(f,
               (uint32_t)(pixel(x, y, 0) >> 3) << 10 | (uint32_t)(pixel(x, y, 1) >> 3) << 5 |
                   pixel(x, y, 2) >> 3,
               2);
    } else {
        for (int c = 2; c >= 0; c--) put_byte(f, pixel(x, y, c));
        if (depth == 32) put_byte(f, pixel(x, y, 3));
    }
}

static bool is_same(int x, int y, int kind)
{
    if (kind == TGA_PALETTE) return false;
    for (int c = 0; c < 4; c++)
        if (pixel(x, y, c) != pixel(x + 1, y, c)) return false;
    return true;
}

static struct file make_tga(int kind, int depth, unsigned how)
{
    struct file f = {.name = "a.tga"};
    bool is_packed = (kind & TGA_PACKED) != 0;
    int base = kind & 7;
    put_byte(&f, 3); /* a comment of three bytes */
    put_byte(&f, base == TGA_PALETTE);
    put_byte(&f, (unsigned)kind);
    put_le(&f, 0, 2);
    put_le(&f, base == TGA_PALETTE ? W * H : 0, 2);
    put_byte(&f, base == TGA_PALETTE ? 24 : 0);
    put_le(&f, 0, 4);
    put_le(&f, W, 2);
    put_le(&f, H, 2);
    put_byte(&f, (unsigned)depth);
    put_byte(&f, how);
    put(&f, "abc", 3);
    for (int i = 0; base == TGA_PALETTE && i < W * H; i++)
        for (int c = 2; c >= 0; c--) put_byte(&f, pixel(i % W, i / W, c));
    for (int row = 0; row < H; row++) {
        int y = how & TOP_DOWN ? row : H - 1 - row;
        for (int i = 0; i < W;) {
            int x = how & MIRRORED ? W - 1 - i : i, step = how & MIRRORED ? -1 : 1, run = 1;
            while (is_packed && i + run < W && is_same(step > 0 ? x + run - 1 : x - run, y, base))
                run++;
            if (is_packed) put_byte(&f, run > 1 ? 127u + (unsigned)run : 0);
            put_tga_pixel(&f, base, depth, x, y);
            i += run;
        }
    }
    return f;
}

/* ---- BMP ------------------------------------------------------------------------------------- */

static struct file make_bmp(int depth, bool is_top_down, bool has_masks, bool is_core)
{
    static const uint32_t masks[4] = {0x000000FF, 0x0000FF00, 0x00FF0000, 0xFF000000};
    struct file f = {.name = "a.bmp"};
    uint32_t n_colours = depth != 8 ? 0
                         : is_core  ? 256
                                    : W * H,
             header = is_core     ? 12
                      : has_masks ? 56
                                  : 40;
    put(&f, "BM", 2);
    put_le(&f, 0, 8);
    put_le(&f, 14 + header + n_colours * (is_core ? 3 : 4), 4);
    put_le(&f, header, 4);
    put_le(&f, W, is_core ? 2 : 4);
    put_le(&f, is_top_down ? 0u - H : H, is_core ? 2 : 4);
    put_le(&f, 1, 2);
    put_le(&f, (uint32_t)depth, 2);
    if (!is_core) {
        put_le(&f, has_masks ? 3 : 0, 4);
        for (int i = 0; i < 3; i++) put_le(&f, 0, 4);
        put_le(&f, n_colours, 4);
        put_le(&f, 0, 4);
    }
    for (int i = 0; has_masks && i < 4; i++) put_le(&f, masks[i], 4);
    for (uint32_t i = 0; i < n_colours; i++) {
        for (int c = 2; c >= 0; c--)
            put_byte(&f, i < W * H ? pixel((int)i % W, (int)i / W, c) : 0u);
        if (!is_core) put_byte(&f, 0);
    }
    for (int row = 0; row < H; row++) {
        int y = is_top_down ? row : H - 1 - row;
        size_t start = f.n;
        for (int x = 0; x < W; x++) {
            if (depth == 8) {
                put_byte(&f, (unsigned)(y * W + x));
            } else if (has_masks) {
                for (int c = 0; c < 4; c++) put_byte(&f, pixel(x, y, c));
            } else {
                for (int c = 2; c >= 0; c--) put_byte(&f, pixel(x, y, c));
                if (depth == 32) put_byte(&f, 0);
            }
        }
        while ((f.n - start) % 4) put_byte(&f, 0);
    }
    return f;
}

/* ---- Radiance -------------------------------------------------------------------------------- */

/* Mantissas are the picture's, exponents differ from pixel to pixel. */
static void rgbe_of(int x, int y, unsigned char rgbe[4])
{
    for (int c = 0; c < 3; c++) rgbe[c] = pixel(x, y, c) | 0x80;
    rgbe[3] = (unsigned char)(x < 6 ? 128 : 124 + x);
}

static float radiance(int x, int y, int c)
{
    unsigned char rgbe[4];
    rgbe_of(x, y, rgbe);
    return ldexpf((float)rgbe[c], rgbe[3] - 136);
}

enum { HDR_FLAT, HDR_OLD, HDR_NEW };

static struct file make_hdr(int kind, const char *size_line, bool is_bottom_up)
{
    struct file f = {.name = "a.hdr"};
    static const char head[] = "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\n\n";
    put(&f, head, sizeof head - 1);
    put(&f, size_line, strlen(size_line));
    for (int row = 0; row < H; row++) {
        unsigned char rgbe[W][4];
        for (int x = 0; x < W; x++) rgbe_of(x, is_bottom_up ? H - 1 - row : row, rgbe[x]);
        if (kind == HDR_FLAT) {
            put(&f, rgbe, sizeof rgbe);
        } else if (kind == HDR_OLD) {
            put(&f, rgbe[0], 4);
            put(&f, "\1\1\1\5", 4);
            put(&f, rgbe[6], (W - 6) * sizeof rgbe[0]);
        } else {
            put(&f, "\2\2\0\x0c", 4);
            for (int c = 0; c < 4; c++) {
                put_byte(&f, 128 + 6);
                put_byte(&f, rgbe[0][c]);
                put_byte(&f, W - 6);
                for (int x = 6; x < W; x++) put_byte(&f, rgbe[x][c]);
            }
        }
    }
    return f;
}

/* ---- Good files ------------------------------------------------------------------------------ */

static void check_bytes(const char *what, const struct file *f, uint32_t n_channels, int tolerance)
{
    struct bitmap b;
    struct image im;
    const char *path = temp_write(f->name, f->at, f->n);
    OK(bitmap_load(path, &b, &err));
    OK(image_load(path, &im, &err));
    unlink(path);
    assert_true(b.u8 && !b.f32 && !b.f16 && b.is_srgb);
    assert_true(b.width == W && b.height == H);
    assert_int_equal(b.n_channels, n_channels);
    for (int i = 0; i < W * H * (int)n_channels; i++) {
        int c = i % (int)n_channels, at = i / (int)n_channels;
        int want = pixel(at % W, at / W, c);
        if (abs(b.u8[i] - want) > tolerance)
            fail_msg("%s: value %d is %d, not %d", what, i, b.u8[i], want);
        float linear = c == 3 ? (float)b.u8[i] / 255 : srgb_decode((float)b.u8[i] / 255);
        assert_true(fabsf(im.data[i] - linear) < 1e-6f);
    }
    bitmap_release(&b);
    image_release(&im);
}

static void test_tga(void **state)
{
    static const unsigned hows[] = {0, TOP_DOWN, MIRRORED, TOP_DOWN | MIRRORED};
    (void)state;
    for (int packed = 0; packed <= TGA_PACKED; packed += TGA_PACKED) {
        for (int k = 0; k < 4; k++) {
            struct file f = make_tga(TGA_COLOUR | packed, 24, hows[k]);
            check_bytes("24 bits", &f, 3, 0);
            f = make_tga(TGA_COLOUR | packed, 32, hows[k]);
            check_bytes("32 bits", &f, 4, 0);
            f = make_tga(TGA_COLOUR | packed, 16, hows[k]);
            check_bytes("16 bits", &f, 3, 7);
            f = make_tga(TGA_GREY | packed, 8, hows[k]);
            check_bytes("grey", &f, 1, 0);
            f = make_tga(TGA_PALETTE | packed, 8, hows[k]);
            check_bytes("palette", &f, 3, 0);
        }
    }
}

static void test_bmp(void **state)
{
    (void)state;
    for (int top_down = 0; top_down < 2; top_down++) {
        struct file f = make_bmp(24, top_down, false, false);
        check_bytes("24 bits", &f, 3, 0);
        f = make_bmp(32, top_down, false, false);
        check_bytes("32 bits", &f, 3, 0);
        f = make_bmp(32, top_down, true, false);
        check_bytes("masks", &f, 4, 0);
        f = make_bmp(8, top_down, false, false);
        check_bytes("palette", &f, 3, 0);
    }
    struct file f = make_bmp(24, false, false, true);
    check_bytes("OS/2", &f, 3, 0);
    f = make_bmp(8, false, false, true);
    check_bytes("OS/2, palette", &f, 3, 0);
}

static void test_hdr(void **state)
{
    (void)state;
    for (int kind = HDR_FLAT; kind <= HDR_NEW; kind++) {
        for (int up = 0; up < 2; up++) {
            struct file f = make_hdr(kind, up ? "+Y 5 +X 12\n" : "-Y 5 +X 12\n", up);
            const char *path = temp_write(f.name, f.at, f.n);
            struct image im;
            struct bitmap b;
            OK(image_load(path, &im, &err));
            OK(bitmap_load(path, &b, &err));
            unlink(path);
            assert_true(im.width == W && im.height == H && im.n_channels == 3);
            assert_true(b.f16 && !b.f32 && !b.u8 && !b.is_srgb);
            for (int i = 0; i < W * H * 3; i++) {
                float want = radiance(i / 3 % W, i / 3 / W, i % 3);
                if (im.data[i] != want || half_to_float(b.f16[i]) != want)
                    fail_msg("kind %d: value %d is %g and %g, not %g", kind, i, (double)im.data[i],
                             (double)half_to_float(b.f16[i]), (double)want);
            }
            image_release(&im);
            bitmap_release(&b);
        }
    }
}

/* Every half float of normal size comes back; what is between them is refused. */
static void test_half(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 65536; i++) {
        uint32_t exponent = i >> 10 & 31, rest = i & 0x7fff;
        if (rest && (exponent == 0 || exponent == 31)) continue;
        uint16_t back;
        float f = half_to_float((uint16_t)i);
        float want = rest ? ldexpf((float)(1024 + (i & 1023)), (int)exponent - 25) : 0;
        assert_true(f == (i & 0x8000 ? -want : want));
        assert_true(half_from_float(f, &back) && back == i);
        assert_false(rest && half_from_float(f * (1 + 0x1p-11f), &back) && back == i);
    }
    uint16_t h;
    assert_false(half_from_float(65536, &h));
    assert_false(half_from_float(INFINITY, &h));
    assert_false(half_from_float(NAN, &h));
    assert_false(half_from_float(0x1p-15f, &h));
    assert_false(half_from_float(0.1f, &h));
}

/* ---- Bad ones -------------------------------------------------------------------------------- */

static bool try_load(const struct file *f)
{
    struct image im;
    struct bitmap b;
    struct error why = {0};
    const char *path = temp_write(f->name, f->at, f->n);
    lmn_status status = image_load(path, &im, &why);
    if (status != LMN_OK) {
        assert_int_equal(status, LMN_ERR_PARSE);
        assert_true(str_starts(why.text, path));
        assert_null(im.data);
    }
    image_release(&im);
    assert_int_equal(bitmap_load(path, &b, &why), status);
    bitmap_release(&b);
    unlink(path);
    return status == LMN_OK;
}

static void check_message(const struct file *f, const char *message)
{
    struct image im;
    const char *path = temp_write(f->name, f->at, f->n);
    assert_int_equal(image_load(path, &im, &err), LMN_ERR_PARSE);
    if (!strstr(err.text, message)) fail_msg("\"%s\" lacks \"%s\"", err.text, message);
    unlink(path);
}

static void test_damaged(void **state)
{
    const struct file files[] = {make_tga(TGA_COLOUR, 24, 0),
                                 make_tga(TGA_COLOUR | TGA_PACKED, 32, TOP_DOWN),
                                 make_tga(TGA_PALETTE | TGA_PACKED, 8, 0),
                                 make_bmp(24, false, false, false),
                                 make_bmp(8, true, false, false),
                                 make_bmp(32, false, true, false),
                                 make_hdr(HDR_FLAT, "-Y 5 +X 12\n", false),
                                 make_hdr(HDR_OLD, "-Y 5 +X 12\n", false),
                                 make_hdr(HDR_NEW, "-Y 5 +X 12\n", false)};
    (void)state;
    for (uint64_t i = 0; i < sizeof files / sizeof *files; i++) {
        struct file f = files[i];
        assert_true(try_load(&f));
        for (f.n = files[i].n - 1; f.n > 0; f.n--)
            if (try_load(&f)) fail_msg("file %d: good when cut to %zu", (int)i, f.n);
        for (uint64_t trial = 0; trial < 1500; trial++) {
            struct rng r = rng_keyed(5, i, trial);
            f = files[i];
            uint32_t reach = trial % 2 ? 80 : (uint32_t)f.n;
            for (uint32_t k = 1 + rng_below(&r, 4); k > 0; k--)
                f.at[rng_below(&r, reach)] = (unsigned char)rng_u32(&r);
            try_load(&f);
        }
    }
}

static void test_lies(void **state)
{
    (void)state;
    struct file f = make_hdr(HDR_FLAT, "-Y 12000 +X 12000\n", false);
    check_message(&f, "is too short for 12000x12000 pixels");
    f = make_hdr(HDR_FLAT, "-Y 99999 +X 12\n", false);
    check_message(&f, "a side can have 32768 at most");
    f = make_hdr(HDR_FLAT, "-Y 0 +X 12\n", false);
    check_message(&f, "image without pixels");
    f = make_hdr(HDR_FLAT, "+X 12 -Y 5\n", false);
    check_message(&f, "column by column");
    f = make_hdr(HDR_FLAT, "12 by 5\n", false);
    check_message(&f, "no line with the size");
    f = make_bmp(24, false, false, false);
    memcpy(f.at + 18, "\0\x20\0\0\0\x20\0\0", 8); /* 8192 x 8192 */
    check_message(&f, "is too short for 8192x8192 pixels");
    f = make_bmp(24, false, false, false);
    f.at[30] = 1;
    check_message(&f, "packed pictures are not supported");
    f = make_tga(TGA_COLOUR, 24, 0);
    memcpy(f.at + 12, "\0\x20\0\x20", 4);
    check_message(&f, "is too short for 8192x8192 pixels");
    f = make_tga(TGA_PALETTE, 8, 0);
    f.at[5] = 2; /* a palette of two, whose other colours are now pixels */
    check_message(&f, "TGA: damaged or cut off");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tga),  cmocka_unit_test(test_bmp),     cmocka_unit_test(test_hdr),
        cmocka_unit_test(test_half), cmocka_unit_test(test_damaged), cmocka_unit_test(test_lies),
    };
    return cmocka_run_group_tests(tests, temp_setup, temp_teardown);
}
