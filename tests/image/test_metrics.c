/* SPDX-License-Identifier: Apache-2.0 */
/* The metrics against scikit-image's and flip-evaluator's, as scripts/references/metrics.py wrote
 * them down, and against what can be computed by hand. */
#include "image/metrics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "cmocka_all.h"
#include "image/flip.h"
#include "image/select.h"
#include "image/ssim.h"

#include "base/rng.h"

static const char *data_path(const char *name)
{
    static char path[512];
    const char *root = getenv("LMN_REFERENCES");
    if (root)
        snprintf(path, sizeof path, "%s/image/%s", root, name);
    else
        snprintf(path, sizeof path, "%s/tests/image/data/%s", LMN_SOURCE_DIR, name);
    return path;
}

static struct image load(const char *stem, const char *role)
{
    char name[64];
    struct error err = {0};
    struct image im;
    snprintf(name, sizeof name, "%s.%s.pfm", stem, role);
    if (image_load(data_path(name), &im, &err) != LMN_OK) fail_msg("%s", err.text);
    return im;
}

/* Relative to the value, or absolute for values near 0. */
static void check_close(const json_t *expected, const char *name, double got, double tolerance)
{
    double want = json_number_value(json_object_get(expected, name));
    if (!(fabs(got - want) <= tolerance * (fabs(want) + 1e-2)))
        fail_msg("%s: got %.9g, expected %.9g", name, got, want);
}

/* The mean of 1 - DSSIM without the border that scikit-image leaves out. */
static double ssim_interior(const float *a, const float *b, uint32_t w, uint32_t h)
{
    struct ssim *s;
    double total = 0;
    float *map = malloc((size_t)w * h * sizeof *map);
    assert_int_equal(ssim_new(w, h, &s, NULL), LMN_OK);
    for (int c = 0; c < 3; c++) {
        ssim_plane(s, a + c, b + c, 3, map);
        for (uint32_t y = SSIM_RADIUS; y < h - SSIM_RADIUS; y++)
            for (uint32_t x = SSIM_RADIUS; x < w - SSIM_RADIUS; x++)
                total += (double)map[(size_t)y * w + x];
    }
    ssim_free(s);
    free(map);
    return total / (3.0 * (w - 2 * SSIM_RADIUS) * (h - 2 * SSIM_RADIUS));
}

static void check_case(const char *stem, const json_t *expected)
{
    struct image g = load(stem, "reference"), p = load(stem, "test"), map;
    lmn_metrics m;
    struct error err = {0};
    if (metrics_compare(&p, &g, &m, &map, &err) != LMN_OK) fail_msg("%s", err.text);
    print_message("%s: dssim %.6f, legacy %.6f, flip %.6f, hdr %.6f\n", stem, m.dssim,
                  m.dssim_legacy, m.flip, m.flip_hdr);
    check_close(expected, "exposure", m.exposure, 1e-6);
    check_close(expected, "mae", m.mae, 1e-6);
    check_close(expected, "mape", m.mape, 1e-6);
    check_close(expected, "mse", m.mse, 1e-6);
    check_close(expected, "relmse", m.relmse, 1e-6);
    check_close(expected, "psnr", m.psnr, 1e-5);
    check_close(expected, "dssim", m.dssim, 1e-5);
    check_close(expected, "dssim_log", m.dssim_log, 1e-5);
    check_close(expected, "dssim_legacy", m.dssim_legacy, 1e-5);
    check_close(expected, "flip", m.flip, 1e-5);
    check_close(expected, "flip_hdr", m.flip_hdr, 1e-5);

    size_t n = 3 * (size_t)g.width * g.height;
    float *a = malloc(n * sizeof *a), *b = malloc(n * sizeof *b);
    for (size_t i = 0; i < n; i++) {
        a[i] = srgb_encode((float)m.exposure * g.data[i]);
        b[i] = srgb_encode((float)m.exposure * p.data[i]);
    }
    check_close(expected, "ssim_interior", ssim_interior(a, b, g.width, g.height), 1e-5);
    assert_true(fabs(1 - metrics_ssim(a, b, g.width, g.height, 3) - m.dssim) < 1e-6);
    for (size_t i = 0; i < n; i++) {
        a[i] = log1pf(g.data[i]);
        b[i] = log1pf(p.data[i]);
    }
    check_close(expected, "ssim_log_interior", ssim_interior(a, b, g.width, g.height), 1e-5);
    free(a);
    free(b);

    assert_int_equal(map.width, g.width);
    assert_int_equal(map.height, g.height);
    assert_int_equal(map.n_channels, 3);
    image_release(&map);
    image_release(&g);
    image_release(&p);
}

static void test_peers(void **state)
{
    (void)state;
    json_error_t where;
    json_t *all = json_load_file(data_path("metrics.json"), 0, &where);
    if (!all) fail_msg("%s: %s", data_path("metrics.json"), where.text);
    assert_true(json_object_size(all) >= 2);
    const char *stem;
    json_t *expected;
    json_object_foreach(all, stem, expected) check_case(stem, expected);
    json_decref(all);
}

static struct image constant(uint32_t w, uint32_t h, uint32_t n, float v)
{
    struct image im;
    assert_int_equal(image_init(&im, w, h, n, NULL, NULL), LMN_OK);
    for (size_t i = 0; i < (size_t)w * h * n; i++) im.data[i] = v;
    return im;
}

static void test_equal_images(void **state)
{
    (void)state;
    struct image g = constant(20, 13, 3, 0.5f), map;
    lmn_metrics m;
    g.data[7] = 3;
    assert_int_equal(metrics_compare(&g, &g, &m, &map, NULL), LMN_OK);
    assert_true(m.mae == 0 && m.mape == 0 && m.mse == 0 && m.relmse == 0);
    assert_true(isinf(m.psnr) && m.psnr > 0);
    assert_true(fabs(m.dssim) < 1e-12 && fabs(m.dssim_log) < 1e-12 && fabs(m.dssim_legacy) < 1e-12);
    assert_true(m.flip == 0 && m.flip_hdr == 0);
    for (int c = 0; c < 3; c++) assert_true(map.data[c] < 0.002f); /* magma starts near black */
    image_release(&map);
    image_release(&g);
}

static void test_by_hand(void **state)
{
    (void)state;
    /* Grey, so that Y alone is enough: errors of constants */
    struct image g = constant(40, 40, 1, 0.25f), p = constant(40, 40, 1, 0.5f);
    lmn_metrics m;
    p.data[5] = 1000.25f; /* the one firefly that relMSE leaves out: 0.1 % of 1600 pixels */
    assert_int_equal(metrics_compare(&p, &g, &m, NULL, NULL), LMN_OK);
    double n = 1600;
    assert_true(fabs(m.mae - (0.25 * (n - 1) + 1000) / n) < 1e-6);
    assert_true(fabs(m.mse - (0.0625 * (n - 1) + 1e6) / n) < 1e-3);
    assert_true(fabs(m.relmse - 0.0625 / 0.0725) < 1e-6);
    assert_true(fabs(m.exposure - 4) < 1e-6);
    image_release(&g);
    image_release(&p);

    /* Black against white: as different as FLIP gets, nearly */
    g = constant(40, 40, 3, 0);
    p = constant(40, 40, 3, 1);
    assert_int_equal(metrics_compare(&p, &g, &m, NULL, NULL), LMN_OK);
    assert_true(m.exposure == 1);
    assert_true(m.flip > 0.9 && m.flip <= 1);
    assert_true(isfinite(m.flip_hdr) && m.flip_hdr > 0.9);
    assert_true(fabs(m.psnr) < 1e-9);
    image_release(&g);
    image_release(&p);
}

/* 1x1, 1 row, 1 column: windows larger than the image. */
static void test_small(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {1, 9}, {9, 1}, {3, 2}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct image g = constant(sizes[i][0], sizes[i][1], 3, 0.25f);
        struct image p = constant(sizes[i][0], sizes[i][1], 3, 0.2f);
        lmn_metrics m;
        assert_int_equal(metrics_compare(&p, &g, &m, NULL, NULL), LMN_OK);
        assert_true(isfinite(m.flip) && m.flip > 0 && m.flip < 1);
        assert_true(isfinite(m.flip_hdr) && isfinite(m.dssim) && isfinite(m.dssim_legacy));
        image_release(&g);
        image_release(&p);
    }
}

static void test_refusals(void **state)
{
    (void)state;
    struct image g = constant(4, 5, 3, 1), p = constant(5, 4, 3, 1), map;
    struct error err = {0};
    lmn_metrics m;
    assert_int_equal(metrics_compare(&p, &g, &m, &map, &err), LMN_ERR_ARGUMENT);
    assert_string_equal(err.text, "images differ in size: 5x4 and 4x5");
    assert_null(map.data);
    image_release(&p);
    p = constant(4, 5, 3, 1);
    p.data[3 * 6 + 1] = NAN;
    assert_int_equal(metrics_compare(&p, &g, &m, NULL, &err), LMN_ERR_ARGUMENT);
    assert_string_equal(err.text, "the test image is not finite at pixel (2, 1), channel G");
    p.data[3 * 6 + 1] = INFINITY;
    assert_int_equal(metrics_compare(&g, &p, &m, NULL, &err), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(err.text, "reference"));
    p.data[3 * 6 + 1] = 3e38f; /* extreme, but a number */
    assert_int_equal(metrics_compare(&g, &p, &m, NULL, &err), LMN_OK);
    assert_int_equal(metrics_compare(&p, &g, &m, NULL, &err), LMN_OK);
    assert_true(isfinite(m.mae) && isfinite(m.flip_hdr));
    image_release(&g);
    image_release(&p);
}

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static void test_select(void **state)
{
    (void)state;
    float v[60], sorted[60];
    for (uint64_t trial = 0; trial < 500; trial++) {
        struct rng r = rng_keyed(1, trial, 0);
        uint32_t n = 1 + rng_below(&r, 60), n_values = 1 + rng_below(&r, 60);
        for (uint32_t i = 0; i < n; i++) v[i] = sorted[i] = (float)rng_below(&r, n_values);
        qsort(sorted, n, sizeof *sorted, by_value);
        uint32_t k = rng_below(&r, n);
        assert_true(select_kth(v, n, k) == sorted[k]);
        for (uint32_t i = 0; i < n; i++) assert_true(i < k ? v[i] <= v[k] : v[i] >= v[k]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_peers),    cmocka_unit_test(test_equal_images),
        cmocka_unit_test(test_by_hand),  cmocka_unit_test(test_small),
        cmocka_unit_test(test_refusals), cmocka_unit_test(test_select),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
