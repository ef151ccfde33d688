/* SPDX-License-Identifier: Apache-2.0 */
/* Random numbers of paths: uniform in every dimension, stratified where Sobol points are asked for,
 * unrelated between dimensions, pixels and seeds. Seeds are fixed. */
#include <math.h>
#include <string.h>

#include "../math/chi2.h"
#include "render/sampler.h"

#include "../image/cmocka_all.h"

static const enum sampler_kind kinds[] = {SAMPLER_INDEPENDENT, SAMPLER_SOBOL};

/* Pairs of dimensions, many pixels: 16 x 16 bins. */
static void points_are_uniform(void **state)
{
    (void)state;
    enum { PIXELS = 2000, SPP = 16, PAIRS = 6, SIDE = 16 };
    for (int k = 0; k < 2; k++) {
        static int counts[PAIRS][SIDE * SIDE];
        memset(counts, 0, sizeof counts);
        for (uint32_t i = 0; i < PIXELS * SPP; i++) {
            struct sampler s = sampler_start(kinds[k], 5, i / SPP, i % SPP);
            for (int pair = 0; pair < PAIRS; pair++) {
                struct vec2 u = sampler_next_2d(&s);
                assert_true(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1);
                counts[pair][(int)(u.x * SIDE) * SIDE + (int)(u.y * SIDE)]++;
            }
        }
        for (int pair = 0; pair < PAIRS; pair++) {
            const double expected = (double)PIXELS * SPP / (SIDE * SIDE);
            double chi2 = 0;
            for (int b = 0; b < SIDE * SIDE; b++)
                chi2 += pow(counts[pair][b] - expected, 2) / expected;
            /* Sobol points are more even than chance. */
            double p = chi2_tail(chi2, SIDE * SIDE - 1);
            if (p < 1e-4) fail_msg("kind %d, pair %d: p = %g", k, pair, p);
        }
    }
}

/* 2^m Sobol points have one in each of 2^m boxes, whatever the boxes' proportions: in every pair of
 * dimensions and for each half of a pixel's samples. */
static void sobol_points_are_strata(void **state)
{
    (void)state;
    enum { M = 6, N = 1 << M };
    for (uint32_t pixel = 0; pixel < 50; pixel++) {
        for (uint32_t half = 0; half < 2; half++) {
            for (int pair = 0; pair < 5; pair++) {
                struct vec2 u[N];
                for (uint32_t i = 0; i < N; i++) {
                    struct sampler s = sampler_start(SAMPLER_SOBOL, 3, pixel, 2 * i + half);
                    sampler_skip_to(&s, 2 * (uint32_t)pair);
                    u[i] = sampler_next_2d(&s);
                }
                for (int columns = 0; columns <= M; columns++) {
                    bool is_taken[N] = {false};
                    for (int i = 0; i < N; i++) {
                        int x = (int)ldexpf(u[i].x, columns), y = (int)ldexpf(u[i].y, M - columns);
                        int box = x << (M - columns) | y;
                        assert_false(is_taken[box]);
                        is_taken[box] = true;
                    }
                }
            }
        }
    }
}

/* Correlations of numbers that should have nothing to do with each other, in standard errors. */
static void dimensions_are_unrelated(void **state)
{
    (void)state;
    enum { N = 100000, D = 8 };
    for (int k = 0; k < 2; k++) {
        double products[D][D] = {{0}}, with_next[D] = {0}, with_seed[D] = {0};
        for (uint32_t i = 0; i < N; i++) {
            struct sampler a = sampler_start(kinds[k], 1, i, 3),
                           next = sampler_start(kinds[k], 1, i + 1, 3),
                           other = sampler_start(kinds[k], 2, i, 3);
            double u[D];
            for (int d = 0; d < D; d++) {
                u[d] = (double)sampler_next_1d(&a) - 0.5;
                with_next[d] += u[d] * ((double)sampler_next_1d(&next) - 0.5);
                with_seed[d] += u[d] * ((double)sampler_next_1d(&other) - 0.5);
            }
            for (int d = 0; d < D; d++)
                for (int e = 0; e < d; e++) products[d][e] += u[d] * u[e];
        }
        const double error = sqrt((double)N) / 12;
        for (int d = 0; d < D; d++) {
            assert_true(fabs(with_next[d]) < 4.5 * error);
            assert_true(fabs(with_seed[d]) < 4.5 * error);
            for (int e = 0; e < d; e++) assert_true(fabs(products[d][e]) < 4.5 * error);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_uniform),
        cmocka_unit_test(sobol_points_are_strata),
        cmocka_unit_test(dimensions_are_unrelated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
