/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR: files of every kind as the OpenEXR project writes them
 * (scripts/references/exr_files.py), and our own. */
#include "image/half.h"
#include "image/image.h"

#include <math.h>

#include <OpenEXR/openexr.h>

#include "ok.h"
#include "temp.h"

enum { WIDTH = 13, HEIGHT = 37 };

static const char *data_path(const char *stem)
{
    static char path[512];
    const char *root = getenv("LMN_REFERENCES");
    if (root)
        snprintf(path, sizeof path, "%s/image/%s.exr", root, stem);
    else
        snprintf(path, sizeof path, "%s/tests/image/data/%s.exr", LMN_SOURCE_DIR, stem);
    return path;
}

/* What exr_files.py put into pixel (x, y). */
static float expected(uint32_t channel, uint32_t x, uint32_t y)
{
    float fx = (float)x, fy = (float)y;
    switch (channel) {
    case 0:
        return (fx + 32 * fy) / 64;
    case 1:
        return fy / 16;
    case 2:
        return -fx / 16;
    case 3:
        return 0.25f * fx + 3.5f * fy - 7;
    default:
        return fx + 100 * fy;
    }
}

static void test_kinds(void **state)
{
    (void)state;
    static const struct {
        const char *stem;
        float tolerance; /* of the half floats; B44 is lossy on them */
    } files[] = {{"none", 0},       {"rle", 0},       {"zips", 0},   {"zip", 0},
                 {"piz", 0},        {"pxr24", 0},     {"b44", 0.3f}, {"b44a", 0.3f},
                 {"tiled_none", 0}, {"tiled_zip", 0}, {"window", 0}, {"decreasing", 0},
                 {"parts", 0}};
    static const char *const names[] = {"R", "G", "B", "depth.Z", "id.Y"};
    for (size_t f = 0; f < sizeof files / sizeof *files; f++) {
        struct image im;
        struct bitmap b;
        OK(image_load(data_path(files[f].stem), &im, &err));
        OK(bitmap_load(data_path(files[f].stem), &b, &err));
        assert_true(im.width == WIDTH && im.height == HEIGHT && im.n_channels == 5);
        assert_true(b.width == WIDTH && b.height == HEIGHT && b.n_channels == 3);
        assert_true((b.f16 || b.f32) && !b.u8 && !b.is_srgb);
        for (uint32_t c = 0; c < 5; c++) assert_string_equal(im.names[c], names[c]);
        for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
            for (uint32_t c = 0; c < 5; c++) {
                float want = expected(c, i % WIDTH, i / WIDTH), got = im.data[5 * i + c];
                if (!(fabsf(got - want) <= (c < 3 ? files[f].tolerance : 0)))
                    fail_msg("%s: %s of pixel %u is %g, not %g", files[f].stem, names[c], i,
                             (double)got, (double)want);
                float texel = c >= 3  ? got
                              : b.f16 ? half_to_float(b.f16[3 * i + c])
                                      : b.f32[3 * i + c];
                assert_true(texel == got);
            }
        image_release(&im);
        bitmap_release(&b);
    }
}

static void test_refused(void **state)
{
    (void)state;
    struct image im;
    assert_int_equal(image_load(data_path("deep"), &im, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "deep.exr: holds only deep data"));
    assert_int_equal(image_load(data_path("dwaa"), &im, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "dwaa.exr: OpenEXR: DWA/A"));
}

static void test_round_trip(void **state)
{
    (void)state;
    /* more than a chunk of lines; names not in the order that files have them */
    const char *names[] = {"R",        "G",        "B",        "albedo.R",
                           "albedo.G", "albedo.B", "normal.X", "normal.Y",
                           "normal.Z", "a.R",      "depth.Z",  "position.with.dots.X"};
    enum { N = 12, W = 7, H = 35 };
    struct image im, back;
    OK(image_init(&im, W, H, N, names, &err));
    for (uint32_t i = 0; i < W * H * N; i++) im.data[i] = (float)(i % 2048) / 8 + 1 / 3.0f;
    const char *path = temp_path("a.exr");
    OK(image_save(&im, path, NULL, 3, &err));
    OK(image_load(path, &back, &err));
    assert_true(back.width == W && back.height == H && back.n_channels == N);
    assert_string_equal(back.names[0], "R");
    assert_string_equal(back.names[2], "B");
    for (uint32_t c = 0; c < N; c++) {
        int to = image_channel(&back, names[c]);
        assert_true(to >= 0);
        bool is_half = c < 6;
        for (uint32_t i = 0; i < W * H; i++) {
            float a = im.data[i * N + c], b = back.data[i * N + (uint32_t)to];
            assert_true(fabsf(a - b) <= (is_half ? a * 0x1p-11f : 0));
        }
    }
    image_release(&back);
    image_release(&im);
    unlink(path);
}

/* 65504 is the largest half; what is larger would come back as infinite. */
static void test_large_values(void **state)
{
    (void)state;
    struct image im, back;
    const char *path = temp_path("a.exr");
    OK(image_init(&im, 2, 2, 3, NULL, &err));
    im.data[4] = 1e6f;
    im.data[5] = 1.0f / 3;
    OK(image_save(&im, path, NULL, 1, &err));
    OK(image_load(path, &back, &err));
    assert_true(back.data[4] == 1e6f && back.data[5] == 1.0f / 3);
    image_release(&back);
    im.data[4] = INFINITY; /* not finite stays what it is, for whoever looks for it */
    im.data[0] = NAN;
    OK(image_save(&im, path, NULL, 1, &err));
    OK(image_load(path, &back, &err));
    assert_true(isinf(back.data[4]) && isnan(back.data[0]));
    image_release(&back);
    struct bitmap b;
    assert_int_equal(bitmap_load(path, &b, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "a.exr: channel R is not finite at pixel (0, 0)"));
    image_release(&im);
    unlink(path);
}

static void test_same_bytes(void **state)
{
    (void)state;
    struct image im;
    char bytes[2][4096];
    size_t size[2];
    OK(image_init(&im, 9, 20, 4, NULL, &err));
    for (uint32_t i = 0; i < 9 * 20 * 4; i++) im.data[i] = (float)i;
    for (int k = 0; k < 2; k++) {
        const char *path = temp_path(k ? "a.exr" : "other.exr");
        OK(image_save(&im, path, NULL, 1, &err));
        FILE *f = fopen(path, "rb");
        size[k] = fread(bytes[k], 1, sizeof bytes[k], f);
        fclose(f);
        unlink(path);
    }
    assert_true(size[0] > 100 && size[0] < sizeof bytes[0]);
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    image_release(&im);
}

/* Names that the format keeps for itself. */
static void test_attribute_clash(void **state)
{
    (void)state;
    struct image im;
    OK(image_init(&im, 2, 2, 1, NULL, &err));
    OK(image_set_attribute(&im, "compression", "none", &err));
    const char *path = temp_path("a.exr");
    assert_int_not_equal(image_save(&im, path, NULL, 1, &err), LMN_OK);
    assert_non_null(strstr(err.text, "a.exr: OpenEXR: "));
    assert_int_equal(access(path, F_OK), -1);
    image_release(&im);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kinds),      cmocka_unit_test(test_refused),
        cmocka_unit_test(test_round_trip), cmocka_unit_test(test_large_values),
        cmocka_unit_test(test_same_bytes), cmocka_unit_test(test_attribute_clash),
    };
    return cmocka_run_group_tests(tests, temp_setup, temp_teardown);
}
