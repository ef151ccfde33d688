/* SPDX-License-Identifier: Apache-2.0 */
/* The loss and its gradient against the definition in doubles and its central differences. */
#include "nn/loss.h"

#include <math.h>

#include "base/mem.h"
#include "plain.h"
#include "toy.h"

enum { MAX_SIDE = 16, MAX_N = MAX_SIDE * MAX_SIDE * 3 };

/* Pixels interleaved, for plain_loss(). */
static void interleave(uint32_t side, const float *planes, double *out)
{
    uint32_t area = side * side;
    for (uint32_t i = 0; i < area; i++)
        for (uint32_t c = 0; c < 3; c++) out[i * 3 + c] = (double)planes[c * area + i];
}

static void check(uint32_t side, bool legacy)
{
    uint32_t area = side * side, n = 3 * area;
    static float f[MAX_N], t[MAX_N], df[MAX_N];
    static double pf[MAX_N], pt[MAX_N];
    float *scratch = toy_take(loss_scratch_count(side), sizeof *scratch);
    toy_fill(f, n, 10 + side);
    toy_fill(t, n, 20 + side);
    for (uint32_t i = 0; i < n; i++) {
        t[i] = 0.8f + 0.5f * t[i];
        f[i] = t[i] + 0.3f * f[i];
    }
    f[0] = t[0]; /* |0| has no derivative: 0, as PyTorch's */
    interleave(side, f, pf);
    interleave(side, t, pt);

    double want = plain_loss(side, legacy, pf, pt);
    double got = loss_patch(side, legacy, f, t, NULL, scratch);
    if (!(fabs(got - want) < 2e-6)) fail_msg("side %u: loss %.9g, not %.9g", side, got, want);
    assert_true(loss_patch(side, legacy, f, t, df, scratch) == got);

    double largest = 0.0, worst = 0.0;
    for (uint32_t i = 0; i < n; i++) {
        double h = 1e-5, before = pf[i];
        pf[i] = before + h;
        double up = plain_loss(side, legacy, pf, pt);
        pf[i] = before - h;
        double slope = (up - plain_loss(side, legacy, pf, pt)) / (2 * h);
        pf[i] = before;
        double error = fabs(slope - (double)df[i % 3 * area + i / 3]);
        if (fabs(slope) > largest) largest = fabs(slope);
        if (error > worst) worst = error;
    }
    if (!(worst < 1e-4 * largest))
        fail_msg("side %u: gradient off by %.3g of %.3g", side, worst, largest);
    mem_free(scratch);
}

static void test_correct_axes(void **state)
{
    (void)state;
    check(1, false);
    check(4, false);
    check(13, false);
}

static void test_legacy_axes(void **state)
{
    (void)state;
    check(1, true);
    check(4, true);
    check(13, true);
}

/* Equal pictures: SSIM is 1 and nothing is left to learn. */
static void test_perfect(void **state)
{
    enum { SIDE = 16 };
    static float f[MAX_N], df[MAX_N];
    float *scratch = toy_take(loss_scratch_count(SIDE), sizeof *scratch);
    (void)state;
    toy_fill(f, MAX_N, 1);
    for (int legacy = 0; legacy < 2; legacy++) {
        assert_true(fabs(loss_patch(SIDE, legacy, f, f, df, scratch)) < 1e-6);
        for (int i = 0; i < MAX_N; i++) assert_true(fabsf(df[i]) < 1e-6f);
    }
    mem_free(scratch);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_correct_axes),
        cmocka_unit_test(test_legacy_axes),
        cmocka_unit_test(test_perfect),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
