/* SPDX-License-Identifier: Apache-2.0 */
/* That the measuring functions measure: they run, count right, and fail cleanly. */
#include "nn/bench_nn.h"

#include <math.h>

#include "base/mem.h"
#include "toy.h"

static void test_results(void **state)
{
    struct generator_config config = {.n_variables = 2, .width = 16, .depth = 1, .patch_size = 8};
    struct pool *pool = pool_new(2);
    struct nn_bench_result frame, step, probe;
    (void)state;
    assert_true(nn_bench_peak_gflops(0, pool) > 0.0);
    assert_string_equal(nn_bench_kernels(0), "baseline");
    assert_int_equal(nn_bench_render(&config, pool, 0, 100, 3, &frame, NULL), LMN_OK);
    assert_int_equal(nn_bench_step(&config, pool, 0, 5, 3, &step, NULL), LMN_OK);
    assert_int_equal(nn_bench_probe(&config, pool, 0, 5, 3, &probe, NULL), LMN_OK);
    /* 3 x 16 + 2 x (29 x 16) + 29 x 3 multiply-adds a pixel */
    assert_true(fabs(frame.gflop - 2e-9 * 1063 * 100) < 1e-12);
    assert_true(fabs(step.gflop - 3 * 2e-9 * 1063 * 5 * 64) < 1e-12);
    assert_true(fabs(probe.gflop - step.gflop) < 1e-12);
    assert_true(frame.seconds > 0 && step.seconds > 0 && probe.seconds > 0);
    assert_true(fabs(frame.gflops * frame.seconds - frame.gflop) < 1e-9);
    assert_true(frame.memory_size < step.memory_size);
    pool_free(pool);
}

static void test_failures(void **state)
{
    struct generator_config config = {.width = 16, .depth = 1, .patch_size = 8};
    struct generator_config no_patch = {.width = 16}, too_wide = {.width = 4000, .patch_size = 8};
    struct pool *pool = pool_new(1);
    struct nn_bench_result r;
    (void)state;
    assert_int_equal(nn_bench_step(&no_patch, pool, 0, 4, 1, &r, NULL), LMN_ERR_ARGUMENT);
    assert_int_equal(nn_bench_step(&too_wide, pool, 0, 4, 1, &r, NULL), LMN_ERR_ARGUMENT);
    assert_int_equal(nn_bench_render(&too_wide, pool, 0, 4, 1, &r, NULL), LMN_ERR_ARGUMENT);
    for (uint64_t n = 1;; n++) {
        mem_fail_after(n);
        lmn_status status = nn_bench_step(&config, pool, 0, 2, 1, &r, NULL);
        mem_fail_after(0);
        if (status == LMN_OK) break;
        assert_int_equal(status, LMN_ERR_MEMORY);
        assert_true(n < 100);
    }
    pool_free(pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_results),
        cmocka_unit_test(test_failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
