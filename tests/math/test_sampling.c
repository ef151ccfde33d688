/* SPDX-License-Identifier: Apache-2.0 */
/* Warps and distributions against the densities that they promise. */
#include <math.h>

#include "base/rng.h"
#include "chi2.h"
#include "math/distribution.h"

#include "../image/cmocka_all.h"

enum { N = 200000 };

static void check(struct chi2_result r)
{
    if (r.p < 1e-3) fail_msg("chi-square: p = %g", r.p);
    if (fabs(r.integral - 1) > 2e-3) fail_msg("the density integrates to %g", r.integral);
}

static bool hemisphere_sample(const void *ctx, const float u[3], double *x, double *y)
{
    (void)ctx;
    chi2_from_direction(warp_cosine_hemisphere(u[0], u[1]), x, y);
    return true;
}

static double hemisphere_pdf(const void *ctx, double x, double y)
{
    (void)ctx;
    (void)x;
    return warp_cosine_hemisphere_pdf((float)y);
}

static bool sphere_sample(const void *ctx, const float u[3], double *x, double *y)
{
    (void)ctx;
    chi2_from_direction(warp_sphere(u[0], u[1]), x, y);
    return true;
}

static double sphere_pdf(const void *ctx, double x, double y)
{
    (void)ctx;
    (void)x;
    (void)y;
    return (double)WARP_SPHERE_PDF;
}

static bool triangle_sample(const void *ctx, const float u[3], double *x, double *y)
{
    (void)ctx;
    struct vec2 b = warp_triangle(u[0], u[1]);
    /* The other half of the square is the same triangle, turned: bins stay whole. */
    *x = u[2] < 0.5f ? b.x : 1 - b.x;
    *y = u[2] < 0.5f ? b.y : 1 - b.y;
    return true;
}

/* In polar coordinates, so that no bin lies across the edge: density 2 r dr dphi / (2 pi). */
static bool disk_sample(const void *ctx, const float u[3], double *x, double *y)
{
    (void)ctx;
    struct vec2 d = warp_disk(u[0], u[1]);
    *x = atan2(d.y, d.x);
    *y = sqrt((double)d.x * d.x + (double)d.y * d.y);
    return true;
}

static double disk_pdf(const void *ctx, double x, double y)
{
    (void)ctx;
    (void)x;
    return y / 3.14159265358979;
}

static double one(const void *ctx, double x, double y)
{
    (void)ctx;
    (void)x;
    (void)y;
    return 1;
}

static bool tent_sample(const void *ctx, const float u[3], double *x, double *y)
{
    (void)ctx;
    *x = warp_tent(u[0]);
    *y = warp_tent(u[1]);
    return true;
}

static double tent_pdf(const void *ctx, double x, double y)
{
    (void)ctx;
    return (1 - fabs(x)) * (1 - fabs(y));
}

static bool cell_sample(const void *ctx, const float u[3], double *x, double *y)
{
    float fx, fy, pdf;
    distribution2d_sample(ctx, u[0], u[1], &fx, &fy, &pdf);
    *x = fx;
    *y = fy;
    return pdf > 0;
}

static double cell_pdf(const void *ctx, double x, double y)
{
    return distribution2d_pdf(ctx, (float)x, (float)y);
}

static void warps(void **state)
{
    (void)state;
    const struct chi2_domain square = {0, 1, 0, 1, 20, 20, false},
                             tent = {-1, 1, -1, 1, 20, 20, false},
                             polar = {-3.14159265358979, 3.14159265358979, 0, 1, 24, 20, false};
    check(chi2_test(&chi2_sphere, hemisphere_sample, hemisphere_pdf, NULL, N, 1));
    check(chi2_test(&chi2_sphere, sphere_sample, sphere_pdf, NULL, N, 2));
    check(chi2_test(&square, triangle_sample, one, NULL, N, 3));
    check(chi2_test(&tent, tent_sample, tent_pdf, NULL, N, 4));
    check(chi2_test(&polar, disk_sample, disk_pdf, NULL, N, 6));
}

static void trigonometry(void **state)
{
    (void)state;
    for (int i = 0; i <= 1000; i++) {
        float s, c, t = (float)i / 1000.0f;
        warp_sincos_turn(t, &s, &c);
        assert_true(fabs(s - sin(2 * 3.14159265358979 * t)) < 5e-7);
        assert_true(fabs(c - cos(2 * 3.14159265358979 * t)) < 5e-7);
    }
}

static void cells(void **state)
{
    (void)state;
    const struct chi2_domain square = {0, 1, 0, 1, 35, 20, false};
    float weights[5 * 4];
    for (int i = 0; i < 20; i++) weights[i] = i % 3 == 1 ? 0.0f : (float)(i * i % 7);
    for (int i = 5; i < 10; i++) weights[i] = 0.0f; /* a dark row */
    struct distribution2d d;
    assert_true(distribution2d_init(&d, weights, 5, 4));
    check(chi2_test(&square, cell_sample, cell_pdf, &d, N, 5));
    distribution2d_release(&d);
}

static void items(void **state)
{
    (void)state;
    const float weights[6] = {0, 3, 0, 1, 4, 0};
    struct distribution d;
    assert_true(distribution_init(&d, weights, 6));
    uint32_t counts[6] = {0};
    double rest[6] = {0};
    for (uint32_t i = 0; i < 8000; i++) {
        float u = ((float)i + 0.5f) / 8000.0f;
        uint32_t k = distribution_sample(&d, &u);
        assert_true(u >= 0 && u < 1);
        counts[k]++;
        rest[k] += u;
    }
    for (int i = 0; i < 6; i++) {
        assert_true(fabs(counts[i] - 1000.0 * weights[i]) <= 1);
        if (counts[i]) assert_true(fabs(rest[i] / counts[i] - 0.5) < 1e-3);
        assert_true(fabs(distribution_probability(&d, (uint32_t)i) - weights[i] / 8) < 1e-6);
    }
    distribution_release(&d);
    const float zeros[4] = {0};
    assert_true(distribution_init(&d, zeros, 4));
    assert_true(distribution_probability(&d, 3) == 0.25f);
    distribution_release(&d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(warps),
        cmocka_unit_test(trigonometry),
        cmocka_unit_test(cells),
        cmocka_unit_test(items),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
