/* SPDX-License-Identifier: Apache-2.0 */
/* Sampled distances from the pixel's centre against the filters' profiles, whole and cut off at a
 * picture's border. All chi-square tests together fail by chance once in 100 times (Bonferroni);
 * seeds are fixed. */
#include <math.h>

#include "../math/chi2.h"
#include "base/rng.h"
#include "render/filter.h"

#include "../image/cmocka_all.h"

enum { N = 400000 };

struct filter_case {
    const char *name;
    enum filter_kind kind;
    float radius, stddev;
};

static const struct filter_case filters[] = {
    {"box", FILTER_BOX, 0.5f, 0},
    {"wide box", FILTER_BOX, 1.3f, 0},
    {"tent", FILTER_TENT, 1, 0},
    {"wide tent", FILTER_TENT, 2.5f, 0},
    {"gaussian", FILTER_GAUSSIAN, 2, 0.5f},
    {"gaussian cut at 2 sigma", FILTER_GAUSSIAN, 1, 0.5f},
    {"narrow gaussian", FILTER_GAUSSIAN, 1, 0.2f},
};

/* Where the picture may end, in filter radii from the pixel's centre. */
static const float borders[][2] = {
    {-INFINITY, INFINITY}, {-0.25f, INFINITY}, {-INFINITY, 0.4f}, {-0.3f, 0.1f}, {-0.7f, 0.9f}};

enum {
    N_FILTERS = sizeof filters / sizeof *filters,
    N_BORDERS = sizeof borders / sizeof *borders,
};

struct cut_filter {
    struct filter filter;
    float low, high;
    double part; /* of the profile between them */
};

static bool draw(const void *ctx, const float u[3], double *x, double *y)
{
    const struct cut_filter *c = ctx;
    *x = filter_sample(&c->filter, u[0], c->low, c->high);
    *y = 0.5;
    return true;
}

static double density(const void *ctx, double x, double y)
{
    const struct cut_filter *c = ctx;
    (void)y;
    return filter_eval(&c->filter, (float)x) / c->part;
}

/* Simpson's rule, from a to b. */
static double integral(const struct filter *f, double a, double b)
{
    enum { STEPS = 2000 };
    double sum = 0, h = (b - a) / STEPS;
    for (int i = 0; i <= STEPS; i++) {
        double weight = i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2;
        double x = fmin(fmax(a + i * h, a), b);
        sum += weight * filter_eval(f, (float)x);
    }
    return sum * h / 3;
}

static struct cut_filter make(int f, int b)
{
    struct cut_filter c;
    const struct filter_case *k = &filters[f];
    filter_init(&c.filter, k->kind, k->radius, k->stddev);
    c.low = borders[b][0] * k->radius;
    c.high = borders[b][1] * k->radius;
    c.part = integral(&c.filter, fmaxf(c.low, -k->radius), fminf(c.high, k->radius));
    return c;
}

static void profiles(void **state)
{
    (void)state;
    for (int f = 0; f < N_FILTERS; f++) {
        struct cut_filter c = make(f, 0);
        double r = c.filter.radius;
        if (fabs(c.part - 1) > 2e-4) fail_msg("%s: the integral is %g", filters[f].name, c.part);
        assert_true(filter_eval(&c.filter, (float)(r * 1.001)) == 0);
        for (int i = 0; i < 50; i++) {
            float x = (float)(r * i / 50);
            assert_true(filter_eval(&c.filter, x) == filter_eval(&c.filter, -x));
        }
        /* The table that splatting reads. */
        for (int i = 0; i < 997; i++) {
            float x = (float)(r * (1.2 * i / 997 - 0.1)), from = filter_weight(&c.filter, x);
            if (filters[f].kind == FILTER_BOX ||
                fabsf(from - filter_eval(&c.filter, x)) < 4e-5f * filter_eval(&c.filter, 0))
                continue;
            fail_msg("%s: weight %g at %g", filters[f].name, (double)from, (double)x);
        }
    }
}

static void distances_follow_the_profile(void **state)
{
    (void)state;
    for (int f = 0; f < N_FILTERS; f++) {
        for (int b = 0; b < N_BORDERS; b++) {
            struct cut_filter c = make(f, b);
            float r = c.filter.radius;
            const struct chi2_domain line = {
                fmaxf(c.low, -r), fminf(c.high, r), 0, 1, 100, 1, false};
            struct chi2_result t = chi2_test(&line, draw, density, &c, N, (uint64_t)(16 * f + b));
            if (t.p < 0.01 / (N_FILTERS * N_BORDERS))
                fail_msg("%s from %g to %g: p = %g\n", filters[f].name, (double)c.low,
                         (double)c.high, t.p);
        }
    }
}

/* Samples stay inside and grow with u, so that strata stay together. */
static void distances_are_in_order(void **state)
{
    (void)state;
    for (int f = 0; f < N_FILTERS; f++) {
        for (int b = 0; b < N_BORDERS; b++) {
            struct cut_filter c = make(f, b);
            float last = -INFINITY;
            for (int i = 0; i <= 4096; i++) {
                float u = fminf((float)i / 4096.0f, 0x1.fffffep-1f);
                float x = filter_sample(&c.filter, u, c.low, c.high);
                assert_true(x >= c.low && x <= c.high && fabsf(x) <= c.filter.radius && x >= last);
                last = x;
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(profiles),
        cmocka_unit_test(distances_follow_the_profile),
        cmocka_unit_test(distances_are_in_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
