/* SPDX-License-Identifier: Apache-2.0 */
#include "image/ssim.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"

enum { N_TAPS = 2 * SSIM_RADIUS + 1, N_MOMENTS = 5 };

static const double sigma = 1.5, c1 = 1e-4, c2 = 9e-4;

/* Doubles: the variances are differences of nearly equal numbers, to be compared with c2. */
struct ssim {
    uint32_t width, height;
    double taps[N_TAPS];
    double *row;                /* width + 2 * SSIM_RADIUS: a row between zeros */
    double *sums;               /* width: a row being summed */
    double *moments[N_MOMENTS]; /* width * height each: a, b, aa, bb, ab, filtered along rows */
};

lmn_status ssim_new(uint32_t width, uint32_t height, struct ssim **out, struct error *err)
{
    struct ssim *s = mem_new(1, sizeof *s);
    *out = NULL;
    if (!s) return fail_memory(err, "SSIM");
    s->width = width;
    s->height = height;
    double total = 0;
    for (int i = 0; i < N_TAPS; i++) {
        double x = i - SSIM_RADIUS;
        s->taps[i] = exp(-x * x / (2 * sigma * sigma));
        total += s->taps[i];
    }
    for (int i = 0; i < N_TAPS; i++) s->taps[i] /= total;
    size_t n = (size_t)width * height;
    s->row = mem_new((size_t)width + 2 * SSIM_RADIUS, sizeof *s->row);
    s->sums = mem_new(width, N_MOMENTS * sizeof *s->sums);
    bool ok = s->row && s->sums;
    for (int m = 0; m < N_MOMENTS; m++) {
        s->moments[m] = mem_new(n, sizeof *s->moments[m]);
        ok = ok && s->moments[m];
    }
    if (!ok) {
        ssim_free(s);
        return fail_memory(err, "SSIM");
    }
    *out = s;
    return LMN_OK;
}

void ssim_free(struct ssim *s)
{
    if (!s) return;
    for (int m = 0; m < N_MOMENTS; m++) mem_free(s->moments[m]);
    mem_free(s->sums);
    mem_free(s->row);
    mem_free(s);
}

/* One of the five products that the moments are means of. */
static double product(int moment, double a, double b)
{
    switch (moment) {
    case 0:
        return a;
    case 1:
        return b;
    case 2:
        return a * a;
    case 3:
        return b * b;
    default:
        return a * b;
    }
}

static void filter_rows(struct ssim *s, const float *a, const float *b, uint32_t stride)
{
    uint32_t w = s->width;
    for (uint32_t y = 0; y < s->height; y++) {
        for (int m = 0; m < N_MOMENTS; m++) {
            double *to = s->moments[m] + (size_t)y * w;
            for (uint32_t x = 0; x < w; x++) {
                size_t i = ((size_t)y * w + x) * stride;
                s->row[x + SSIM_RADIUS] = product(m, (double)a[i], (double)b[i]);
            }
            memset(to, 0, w * sizeof *to);
            for (int t = 0; t < N_TAPS; t++)
                for (uint32_t x = 0; x < w; x++) to[x] += s->taps[t] * s->row[x + (uint32_t)t];
        }
    }
}

/* The five moments of row y, filtered along columns, into s->sums. */
static void filter_columns(struct ssim *s, uint32_t y)
{
    uint32_t w = s->width;
    memset(s->sums, 0, (size_t)w * N_MOMENTS * sizeof *s->sums);
    for (int t = 0; t < N_TAPS; t++) {
        int64_t from = (int64_t)y + t - SSIM_RADIUS;
        if (from < 0 || from >= (int64_t)s->height) continue;
        for (int m = 0; m < N_MOMENTS; m++) {
            const double *row = s->moments[m] + (size_t)from * w;
            double *to = s->sums + (size_t)m * w;
            for (uint32_t x = 0; x < w; x++) to[x] += s->taps[t] * row[x];
        }
    }
}

double ssim_plane(struct ssim *s, const float *a, const float *b, uint32_t stride, float *map)
{
    uint32_t w = s->width;
    double total = 0;
    filter_rows(s, a, b, stride);
    for (uint32_t y = 0; y < s->height; y++) {
        filter_columns(s, y);
        for (uint32_t x = 0; x < w; x++) {
            const double *m = s->sums + x;
            double mu_a = m[0], mu_b = m[w], mu_ab = mu_a * mu_b;
            double var_a = m[2 * (size_t)w] - mu_a * mu_a;
            double var_b = m[3 * (size_t)w] - mu_b * mu_b;
            double cov = m[4 * (size_t)w] - mu_ab;
            double v = (2 * mu_ab + c1) * (2 * cov + c2) /
                       ((mu_a * mu_a + mu_b * mu_b + c1) * (var_a + var_b + c2));
            total += v;
            if (map) map[(size_t)y * w + x] = (float)v;
        }
    }
    return total;
}

lmn_status ssim_mean(const float *a, const float *b, uint32_t width, uint32_t height,
                     uint32_t n_channels, double *out, struct error *err)
{
    struct ssim *s;
    lmn_status status = ssim_new(width, height, &s, err);
    if (status != LMN_OK) return status;
    double total = 0;
    for (uint32_t c = 0; c < n_channels; c++)
        total += ssim_plane(s, a + c, b + c, n_channels, NULL);
    *out = total / ((double)width * height * n_channels);
    ssim_free(s);
    return LMN_OK;
}

lmn_status ssim_mean_legacy(const float *a, const float *b, uint32_t width, uint32_t height,
                            uint32_t n_channels, double *out, struct error *err)
{
    struct ssim *s;
    lmn_status status = ssim_new(n_channels, width, &s, err);
    if (status != LMN_OK) return status;
    double total = 0;
    size_t row = (size_t)width * n_channels;
    for (uint32_t y = 0; y < height; y++) total += ssim_plane(s, a + y * row, b + y * row, 1, NULL);
    *out = total / ((double)row * height);
    ssim_free(s);
    return LMN_OK;
}
