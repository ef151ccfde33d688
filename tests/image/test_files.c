/* SPDX-License-Identifier: Apache-2.0 */
/* Images through files and back: PNG, JPEG, PFM, formats told by content, attributes. */
#include "image/image.h"

#include <math.h>

#include <png.h>
#include <turbojpeg.h>

#include "ok.h"
#include "temp.h"

#include "base/file.h"
#include "base/mem.h"
#include "base/str.h"

/* A picture of `n` channels with values from 0 to 1, alike in no two rows or columns. */
static struct image picture(uint32_t w, uint32_t h, uint32_t n)
{
    struct image im;
    assert_int_equal(image_init(&im, w, h, n, NULL, NULL), LMN_OK);
    for (uint32_t y = 0; y < h; y++)
        for (uint32_t x = 0; x < w; x++)
            for (uint32_t c = 0; c < n; c++)
                im.data[((size_t)y * w + x) * n + c] = fmodf(
                    (float)x / (float)w + 0.37f * (float)y + 0.21f * (float)c, 1);
    return im;
}

static void check_near(const struct image *a, const struct image *b, float tolerance)
{
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->n_channels, b->n_channels);
    for (uint32_t c = 0; c < a->n_channels; c++) assert_string_equal(a->names[c], b->names[c]);
    for (size_t i = 0; i < (size_t)a->width * a->height * a->n_channels; i++)
        if (!(fabsf(a->data[i] - b->data[i]) <= tolerance))
            fail_msg("value %zu: %g and %g", i, (double)a->data[i], (double)b->data[i]);
}

static void test_srgb(void **state)
{
    (void)state;
    assert_true(srgb_encode(0) == 0 && srgb_encode(1) == 1 && srgb_encode(7) == 1);
    assert_true(srgb_encode(-1) == 0 && srgb_encode(NAN) == 0 && srgb_decode(NAN) == 0);
    assert_true(fabsf(srgb_encode(0.5f) - 0.735357f) < 1e-5f);
    assert_true(fabsf(srgb_encode(0.002f) - 0.02584f) < 1e-6f);
    for (int i = 0; i <= 255; i++) {
        float v = (float)i / 255;
        assert_true(fabsf(srgb_encode(srgb_decode(v)) - v) < 1e-5f);
    }
}

static void test_init(void **state)
{
    (void)state;
    struct image im;
    assert_int_equal(image_init(&im, 0, 5, 3, NULL, &err), LMN_ERR_ARGUMENT);
    assert_int_equal(image_init(&im, 5, IMAGE_MAX_SIDE + 1, 3, NULL, &err), LMN_ERR_ARGUMENT);
    assert_int_equal(image_init(&im, 5, 5, 5, NULL, &err), LMN_ERR_ARGUMENT);
    const char *twice[] = {"R", "R"};
    assert_int_equal(image_init(&im, 5, 5, 2, twice, &err), LMN_ERR_ARGUMENT);
    char name[IMAGE_NAME_SIZE + 1];
    memset(name, 'x', sizeof name);
    name[IMAGE_NAME_SIZE] = '\0';
    const char *names[] = {name};
    assert_int_equal(image_init(&im, 5, 5, 1, names, &err), LMN_ERR_ARGUMENT);
    name[IMAGE_NAME_SIZE - 1] = '\0';
    assert_int_equal(image_init(&im, 5, 5, 1, names, &err), LMN_OK);
    assert_int_equal(image_channel(&im, name), 0);
    assert_int_equal(image_channel(&im, "R"), -1);
    image_release(&im);
    image_release(&im); /* of an empty image: nothing */
}

static void test_png_round_trip(void **state)
{
    (void)state;
    for (uint32_t n = 1; n <= 4; n++) {
        struct image im = picture(19, 7, n), back;
        const char *path = temp_path("a.png");
        OK(image_save(&im, path, NULL, 1, &err));
        OK(image_load(path, &back, &err));
        check_near(&im, &back, 0.0046f); /* half of a step of 8-bit sRGB near white */
        image_release(&back);
        /* the same bytes as a texture: 8 bits, still encoded */
        struct bitmap b;
        OK(bitmap_load(path, &b, &err));
        assert_true(b.u8 && !b.f32 && b.is_srgb);
        assert_int_equal(b.n_channels, n);
        for (size_t i = 0; i < (size_t)19 * 7 * n; i++) {
            bool is_alpha = n % 2 == 0 && i % n == n - 1;
            float v = is_alpha ? im.data[i] : srgb_encode(im.data[i]);
            assert_int_equal(b.u8[i], (int)(v * 255 + 0.5f));
        }
        bitmap_release(&b);
        image_release(&im);
        unlink(path);
    }
}

static void test_png_exposure(void **state)
{
    (void)state;
    struct image im, back;
    assert_int_equal(image_init(&im, 4, 1, 3, NULL, NULL), LMN_OK);
    const float values[] = {0.25f, 100, NAN, -3};
    for (int i = 0; i < 4; i++)
        for (int c = 0; c < 3; c++) im.data[3 * i + c] = values[i];
    const char *path = temp_path("a.png");
    OK(image_save(&im, path, NULL, 2, &err));
    OK(image_load(path, &back, &err));
    assert_true(fabsf(back.data[0] - 0.5f) < 0.003f);
    assert_true(back.data[3] == 1 && back.data[6] == 0 && back.data[9] == 0);
    image_release(&back);
    image_release(&im);
    unlink(path);
}

/* Writes a PNG that image_save() would not: any depth and colour type, interlaced. */
static void write_png(const char *path, int depth, int color_type, bool interlaced)
{
    enum { W = 5, H = 3 };
    FILE *f = fopen(path, "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    assert_true(f && png && info);
    if (setjmp(png_jmpbuf(png))) fail_msg("libpng refused %d %d", depth, color_type);
    png_init_io(png, f);
    png_set_IHDR(png, info, W, H, depth, color_type,
                 interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (color_type == PNG_COLOR_TYPE_PALETTE) {
        png_color palette[2] = {{255, 0, 0}, {0, 0, 255}};
        png_byte alpha[2] = {255, 128};
        png_set_PLTE(png, info, palette, 2);
        png_set_tRNS(png, info, alpha, 2, NULL);
    }
    png_byte rows[H][64] = {{0}};
    png_bytep pointers[H];
    for (int y = 0; y < H; y++) {
        pointers[y] = rows[y];
        for (int i = 0; i < 64; i++) rows[y][i] = (png_byte)(depth == 1 ? 0x55 : 16 * y + i);
    }
    png_set_rows(png, info, pointers);
    png_write_png(png, info, PNG_TRANSFORM_IDENTITY, NULL);
    png_destroy_write_struct(&png, &info);
    fclose(f);
}

static void test_png_kinds(void **state)
{
    (void)state;
    const char *path = temp_path("k.png");
    struct bitmap b;
    struct image im;
    for (int interlaced = 0; interlaced < 2; interlaced++) {
        write_png(path, 16, PNG_COLOR_TYPE_RGB, interlaced);
        OK(bitmap_load(path, &b, &err));
        assert_true(b.f32 && !b.u8 && b.is_srgb && b.n_channels == 3 && b.width == 5);
        /* row 1, pixel 2, G: bytes 16+14, 16+15 */
        assert_true(fabsf(b.f32[(5 + 2) * 3 + 1] - (float)(30 * 256 + 31) / 65535) < 1e-7f);
        OK(image_load(path, &im, &err));
        assert_true(fabsf(im.data[(5 + 2) * 3 + 1] - srgb_decode(b.f32[(5 + 2) * 3 + 1])) < 1e-7f);
        image_release(&im);
        bitmap_release(&b);

        write_png(path, 1, PNG_COLOR_TYPE_GRAY, interlaced);
        OK(bitmap_load(path, &b, &err));
        assert_true(b.u8 && b.n_channels == 1 && b.u8[0] == 0 && b.u8[1] == 255 && b.u8[2] == 0);
        bitmap_release(&b);

        write_png(path, 1, PNG_COLOR_TYPE_PALETTE, interlaced);
        OK(bitmap_load(path, &b, &err));
        assert_true(b.u8 && b.n_channels == 4);
        assert_memory_equal(b.u8, ((uint8_t[]){255, 0, 0, 255, 0, 0, 255, 128}), 8);
        bitmap_release(&b);

        write_png(path, 8, PNG_COLOR_TYPE_GRAY_ALPHA, interlaced);
        OK(image_load(path, &im, &err));
        assert_int_equal(im.n_channels, 2);
        assert_string_equal(im.names[0], "Y");
        assert_string_equal(im.names[1], "A");
        assert_true(fabsf(im.data[3] - 3.0f / 255) < 1e-6f); /* alpha is not decoded */
        assert_true(fabsf(im.data[2] - srgb_decode(2.0f / 255)) < 1e-6f);
        image_release(&im);
    }
    unlink(path);
}

static void test_jpeg(void **state)
{
    (void)state;
    enum { W = 40, H = 24 };
    uint8_t rgb[W * H * 3];
    for (int i = 0; i < W * H; i++) { /* smooth, so that compression changes little */
        rgb[3 * i] = (uint8_t)(40 + 4 * (i % W));
        rgb[3 * i + 1] = (uint8_t)(200 - 3 * (i / W));
        rgb[3 * i + 2] = 90;
    }
    for (int kind = 0; kind < 3; kind++) {
        tjhandle tj = tjInitCompress();
        unsigned char *bytes = NULL;
        unsigned long size = 0;
        assert_int_equal(tjCompress2(tj, rgb, W, 0, H, TJPF_RGB, &bytes, &size,
                                     kind == 2 ? TJSAMP_GRAY : TJSAMP_444, 98,
                                     kind == 1 ? TJFLAG_PROGRESSIVE : 0),
                         0);
        const char *path = temp_write("a.exr", bytes, size); /* content counts, not the name */
        struct bitmap b;
        struct image im;
        OK(bitmap_load(path, &b, &err));
        OK(image_load(path, &im, &err));
        assert_true(b.u8 && b.is_srgb && b.width == W && b.height == H);
        assert_int_equal(b.n_channels, kind == 2 ? 1 : 3);
        if (kind < 2)
            for (size_t i = 0; i < sizeof rgb; i++) assert_in_range(b.u8[i] + 6 - rgb[i], 0, 12);
        for (size_t i = 0; i < (size_t)W * H * b.n_channels; i++)
            assert_true(fabsf(im.data[i] - srgb_decode((float)b.u8[i] / 255)) < 1e-6f);
        bitmap_release(&b);
        image_release(&im);
        tjFree(bytes);
        tjDestroy(tj);
        unlink(path);
    }
}

static void test_pfm(void **state)
{
    (void)state;
    for (uint32_t n = 1; n <= 3; n += 2) {
        struct image im = picture(6, 5, n), back;
        im.data[1] = 1e30f;
        im.data[2] = -1e-30f;
        const char *path = temp_path("a.pfm");
        OK(image_save(&im, path, NULL, 5, &err)); /* exposure is for PNG */
        OK(image_load(path, &back, &err));
        check_near(&im, &back, 0);
        image_release(&back);
        image_release(&im);
        unlink(path);
    }
    /* big endian, bottom row first, scaled by 2 */
    static const unsigned char big[] = "Pf 1 2\n2.0\n\x3f\x80\x00\x00\xbf\x00\x00\x00";
    const char *path = temp_write("b.pfm", big, sizeof big - 1);
    struct image im;
    OK(image_load(path, &im, &err));
    assert_true(im.width == 1 && im.height == 2 && im.n_channels == 1);
    assert_true(im.data[0] == -1 && im.data[1] == 2);
    image_release(&im);
    unlink(path);
}

static void test_attributes(void **state)
{
    (void)state;
    static const char *const formats[] = {"a.exr", "a.png"};
    for (int i = 0; i < 2; i++) {
        struct image im = picture(3, 3, 3), back;
        OK(image_set_attribute(&im, "seed", "0", &err));
        OK(image_set_attribute(&im, "seed", "42", &err));
        OK(image_set_attribute(&im, "parameters", "door=0.3 lamp=\xc3\xa9t\xc3\xa9", &err));
        const char *path = temp_path(formats[i]);
        OK(image_save(&im, path, NULL, 1, &err));
        OK(image_load(path, &back, &err));
        assert_int_equal(back.n_attributes, 2);
        for (int k = 0; k < 2; k++) {
            const struct image_attribute *a = &back.attributes[k];
            const char *want = strcmp(a->name, "seed") == 0 ? "42" : im.attributes[1].value;
            assert_string_equal(a->value, want);
        }
        image_release(&back);
        image_release(&im);
        unlink(path);
    }
}

static void test_saving(void **state)
{
    (void)state;
    struct image im = picture(3, 3, 3), bad, back;
    const char *path = temp_path("a.jpg");
    assert_int_equal(image_save(&im, path, NULL, 1, &err), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(err.text, "a.jpg: cannot write \"jpg\" images"));
    assert_int_equal(access(path, F_OK), -1);
    /* a format's name beats the extension, whose case does not matter */
    OK(image_save(&im, path, "pfm", 1, &err));
    OK(image_load(path, &back, &err));
    check_near(&im, &back, 0);
    image_release(&back);
    unlink(path);
    path = temp_path("a.EXR");
    OK(image_save(&im, path, NULL, 1, &err));
    assert_int_equal(unlink(path), 0);
    /* no format in a name, a folder with a dot in its own */
    assert_int_equal(image_save(&im, "-", NULL, 1, &err), LMN_ERR_ARGUMENT);
    assert_int_equal(image_save(&im, "/nowhere.png/file", NULL, 1, &err), LMN_ERR_ARGUMENT);
    assert_int_equal(image_save(&im, "/nowhere/file.png", NULL, 1, &err), LMN_ERR_IO);
    assert_string_equal(err.text, "/nowhere/file.png: cannot write: No such file or directory");
    /* what is no picture */
    const char *names[] = {"normal.X", "normal.Y"};
    assert_int_equal(image_init(&bad, 2, 2, 2, names, NULL), LMN_OK);
    path = temp_path("a.png");
    assert_int_equal(image_save(&bad, path, NULL, 1, &err), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(err.text, "no channels R, G, B or Y"));
    assert_int_equal(access(path, F_OK), -1);
    image_release(&bad);
    image_release(&im);
}

static void test_standard_output(void **state)
{
    (void)state;
    struct image im = picture(5, 4, 3), back;
    static const char *const formats[] = {"exr", "png", "pfm"};
    for (int i = 0; i < 3; i++) {
        const char *path = temp_path("out");
        fflush(stdout);
        int kept = dup(STDOUT_FILENO);
        assert_non_null(freopen(path, "wb", stdout));
        lmn_status status = image_save(&im, "-", formats[i], 1, &err);
        fflush(stdout);
        dup2(kept, STDOUT_FILENO);
        close(kept);
        OK(status);
        OK(image_load(path, &back, &err));
        check_near(&im, &back, 0.005f);
        image_release(&back);
        unlink(path);
    }
    image_release(&im);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_srgb),
        cmocka_unit_test(test_init),
        cmocka_unit_test(test_png_round_trip),
        cmocka_unit_test(test_png_exposure),
        cmocka_unit_test(test_png_kinds),
        cmocka_unit_test(test_jpeg),
        cmocka_unit_test(test_pfm),
        cmocka_unit_test(test_attributes),
        cmocka_unit_test(test_saving),
        cmocka_unit_test(test_standard_output),
    };
    return cmocka_run_group_tests(tests, temp_setup, temp_teardown);
}
