/* SPDX-License-Identifier: Apache-2.0 */
#include "image/metrics.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "image/codecs.h"
#include "image/flip.h"
#include "image/select.h"
#include "image/ssim.h"

static float positive(float v)
{
    return v > 0 ? v : 0;
}

double metrics_exposure(const float *rgb, size_t n_values)
{
    float *copy = mem_new(n_values, sizeof *copy);
    if (!copy || n_values == 0) {
        mem_free(copy);
        return 1;
    }
    memcpy(copy, rgb, n_values * sizeof *copy);
    /* between the two values around the rank, as numpy.percentile() */
    double rank = 0.99 * (double)(n_values - 1);
    size_t k = (size_t)rank;
    double low = (double)select_kth(copy, n_values, k), high = low;
    if (k + 1 < n_values) high = (double)select_kth(copy + k + 1, n_values - k - 1, 0);
    double percentile = low + (rank - (double)k) * (high - low);
    mem_free(copy);
    return percentile > 0 && isfinite(1 / percentile) ? 1 / percentile : 1;
}

double metrics_ssim(const float *a, const float *b, uint32_t width, uint32_t height,
                    uint32_t n_channels)
{
    double mean;
    return ssim_mean(a, b, width, height, n_channels, &mean, NULL) == LMN_OK ? mean : NAN;
}

/* The image's R, G, B, or three times its Y, as n_pixels x 3; finite. */
static lmn_status copy_rgb(const struct image *im, const char *what, float **out, struct error *err)
{
    int c[4];
    size_t n = (size_t)im->width * im->height;
    uint32_t n_channels = codec_colour_channels(im, c);
    if (n_channels == 0)
        return fail(err, LMN_ERR_ARGUMENT, "the %s image has no channels R, G, B or Y", what);
    if (n_channels < 3) c[1] = c[2] = c[0];
    float *rgb = mem_new(n, 3 * sizeof *rgb);
    if (!rgb) return fail_memory(err, "comparing images");
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < 3; k++) {
            float v = im->data[i * im->n_channels + (uint32_t)c[k]];
            if (!isfinite(v)) {
                mem_free(rgb);
                return fail(err, LMN_ERR_ARGUMENT,
                            "the %s image is not finite at pixel (%zu, %zu), channel %s", what,
                            i % im->width, i / im->width, im->names[c[k]]);
            }
            rgb[3 * i + k] = v;
        }
    }
    *out = rgb;
    return LMN_OK;
}

/* MAE, MAPE, relMSE, MSE on radiance. `scratch`: n_pixels. */
static void compare_radiance(const float *p, const float *g, size_t n_pixels, float *scratch,
                             lmn_metrics *out)
{
    double mae = 0, mape = 0, mse = 0, relmse = 0;
    for (size_t i = 0; i < n_pixels; i++) {
        double pixel = 0;
        for (size_t k = 3 * i; k < 3 * i + 3; k++) {
            double d = (double)p[k] - (double)g[k], ref = (double)positive(g[k]);
            mae += fabs(d);
            mape += fabs(d) / (ref + 0.01);
            mse += d * d;
            pixel += d * d / (ref * ref + 0.01);
        }
        scratch[i] = (float)(pixel / 3);
    }
    /* One firefly can be most of an image's squared error: the largest 0.1 % do not count. */
    size_t n_kept = n_pixels - n_pixels / 1000;
    select_kth(scratch, n_pixels, n_kept - 1);
    for (size_t i = 0; i < n_kept; i++) relmse += (double)scratch[i];
    double n_values = 3 * (double)n_pixels;
    out->mae = mae / n_values;
    out->mape = mape / n_values;
    out->mse = mse / n_values;
    out->relmse = relmse / (double)n_kept;
}

/* v = min(max(k v, 0), 1), and encoded = sRGB(v). */
static void expose(float *v, size_t n, double k, float *encoded)
{
    for (size_t i = 0; i < n; i++) {
        float exposed = positive((float)(k * (double)v[i]));
        v[i] = exposed < 1 ? exposed : 1;
        encoded[i] = srgb_encode(v[i]);
    }
}

static void take_log1p(const float *v, size_t n, float *out)
{
    for (size_t i = 0; i < n; i++) out[i] = log1pf(positive(v[i]));
}

static double psnr_of(const float *a, const float *b, size_t n)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++) {
        double d = (double)a[i] - (double)b[i];
        sum += d * d;
    }
    return sum > 0 ? -10 * log10(sum / (double)n) : INFINITY;
}

/* 17 of magma's 256 colours (Smith and van der Walt 2015, CC0), linear in between; nowhere further
 * off than 0.01. */
void metrics_magma(float v, float rgb[3])
{
    static const uint8_t colors[17][3] = {
        {0, 0, 4},       {10, 8, 34},    {29, 17, 71},   {54, 16, 107},   {81, 18, 124},
        {106, 28, 129},  {131, 38, 129}, {156, 46, 127}, {183, 55, 121},  {207, 64, 112},
        {229, 80, 100},  {244, 105, 92}, {251, 135, 97}, {254, 165, 113}, {254, 194, 135},
        {253, 224, 161}, {252, 253, 191}};
    float at = positive(v) * 16;
    int i = at < 15 ? (int)at : 15;
    float t = at - (float)i < 1 ? at - (float)i : 1;
    for (int c = 0; c < 3; c++) {
        float encoded = (float)colors[i][c] * (1 - t) + (float)colors[i + 1][c] * t;
        rgb[c] = srgb_decode(encoded / 255);
    }
}

lmn_status metrics_compare(const struct image *test, const struct image *reference,
                           lmn_metrics *out, struct image *error_map, struct error *err)
{
    lmn_status status = LMN_OK;
    float *p = NULL, *g = NULL, *a = NULL, *b = NULL, *map = NULL;
    struct flip *flip = NULL;
    lmn_metrics m = {0};
    uint32_t w = reference->width, h = reference->height;
    size_t n = (size_t)w * h;
    double similarity;
    if (error_map) *error_map = (struct image){0};
    if (test->width != w || test->height != h) {
        status = fail(err, LMN_ERR_ARGUMENT, "images differ in size: %ux%u and %ux%u", test->width,
                      test->height, w, h);
        goto done;
    }
    if (n == 0) {
        status = fail(err, LMN_ERR_ARGUMENT, "images without pixels");
        goto done;
    }
    TRY(copy_rgb(test, "test", &p, err));
    TRY(copy_rgb(reference, "reference", &g, err));
    a = mem_new(n, 3 * sizeof *a);
    b = mem_new(n, 3 * sizeof *b);
    map = mem_new(n, sizeof *map);
    if (!a || !b || !map) {
        status = fail_memory(err, "comparing images");
        goto done;
    }
    TRY(flip_new(w, h, &flip, err));

    compare_radiance(p, g, n, map, &m);
    m.exposure = metrics_exposure(g, 3 * n);
    take_log1p(p, 3 * n, a);
    take_log1p(g, 3 * n, b);
    TRY(ssim_mean(a, b, w, h, 3, &similarity, err));
    m.dssim_log = 1 - similarity;
    TRY(ssim_mean_legacy(a, b, w, h, 3, &similarity, err));
    m.dssim_legacy = 1 - similarity;
    m.flip_hdr = flip_hdr(flip, g, p);

    expose(p, 3 * n, m.exposure, a);
    expose(g, 3 * n, m.exposure, b);
    m.psnr = psnr_of(a, b, 3 * n);
    TRY(ssim_mean(a, b, w, h, 3, &similarity, err));
    m.dssim = 1 - similarity;
    m.flip = flip_ldr(flip, g, p, map);
    if (error_map) {
        TRY(image_init(error_map, w, h, 3, NULL, err));
        for (size_t i = 0; i < n; i++) metrics_magma(map[i], error_map->data + 3 * i);
    }
    *out = m;
done:
    flip_free(flip);
    mem_free(p);
    mem_free(g);
    mem_free(a);
    mem_free(b);
    mem_free(map);
    return status;
}
