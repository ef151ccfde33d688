/* SPDX-License-Identifier: Apache-2.0 */
/* The functions of approx.h against libm's in double. */
#include <math.h>

#include "math/approx.h"

#include "../image/cmocka_all.h"

static void exponentials(void **state)
{
    (void)state;
    for (int i = 0; i <= 100000; i++) {
        float x = -87.0f + 175.0f * (float)i / 100000.0f, y = approx_exp(x);
        double want = exp((double)x);
        if (fabs((double)y - want) > 2e-7 * want) fail_msg("exp %g: %g", (double)x, (double)y);
    }
    assert_true(approx_exp(0.0f) == 1.0f);
    assert_true(approx_exp(-88.0f) < 2e-38f);
    assert_true(approx_exp(-INFINITY) < 2e-38f);
    assert_true(isfinite(approx_exp(1000.0f)));
}

static void logarithms(void **state)
{
    (void)state;
    for (int i = 0; i <= 100000; i++) {
        float x = powf(10.0f, -37.0f + 75.0f * (float)i / 100000.0f), y = approx_log(x);
        double want = log((double)x);
        if (fabs((double)y - want) > 2e-7 * fmax(fabs(want), 1e-3))
            fail_msg("log %g: %g", (double)x, (double)y);
    }
    for (int i = 1; i < 1000; i++) { /* relative to what is left near 1 */
        float x = 1.0f - (float)i * 0x1p-24f;
        double want = log((double)x);
        assert_true(fabs((double)approx_log(x) - want) < 1e-6 * fabs(want));
    }
    assert_true(approx_log(1.0f) == 0.0f);
}

static void error_functions(void **state)
{
    (void)state;
    for (int i = -100000; i <= 100000; i++) {
        float x = 6.0f * (float)i / 100000.0f, y = approx_erf(x);
        if (fabs((double)y - erf((double)x)) > 7e-7) fail_msg("erf %g: %g", (double)x, (double)y);
    }
    for (int i = -99990; i <= 99990; i++) {
        float y = (float)i / 100000.0f, x = approx_erf_inverse(y);
        /* The slope of erf there, and what rounding y costs. */
        double slope = 2.0 / sqrt(3.14159265358979) * exp(-(double)x * (double)x);
        double error = (erf((double)x) - (double)y) / slope;
        if (fabs(error) > 1e-6 * fmax(1.0, fabs((double)x)) + 1.2e-7 / slope)
            fail_msg("inverse of erf %g: %g", (double)y, (double)x);
    }
    assert_true(isfinite(approx_erf_inverse(1.0f)) && isfinite(approx_erf_inverse(-1.0f)));
    assert_true(approx_erf_inverse(0.0f) == 0.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exponentials),
        cmocka_unit_test(logarithms),
        cmocka_unit_test(error_functions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
