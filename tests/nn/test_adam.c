/* SPDX-License-Identifier: Apache-2.0 */
/* Adam against values worked out by hand from Kingma & Ba's Algorithm 1. */
#include "nn/adam.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "toy.h"

/* lr 0.01, beta 0.9 and 0.999, eps 1e-8; weights start at 1, -1, 0.5. */
enum { N = 3, N_STEPS = 3 };
static const float gradients[N_STEPS][N] = {
    {0.5f, -2.0f, 1e-3f}, {1.0f, 0.0f, -1e-3f}, {-0.25f, 4.0f, 1e-3f}};
static const double weights_after[N_STEPS][N] = {
    {0.9900000002, -0.9900000000, 0.4900001000},
    {0.9803481801, -0.9832994176, 0.4905264105},
    {0.9744621128, -0.9866997622, 0.4871685105},
};
static const double step_norms[N_STEPS] = {0.0173204502, 0.0117614812, 0.0075817956};

static void test_by_hand(void **state)
{
    struct pool *pool = pool_new(1);
    struct adam a;
    float w[N] = {1.0f, -1.0f, 0.5f};
    (void)state;
    assert_int_equal(adam_init(&a, N, 0.01, NULL), LMN_OK);
    for (int step = 0; step < N_STEPS; step++) {
        double norm = adam_step_norm(&a, gradients[step]);
        if (!(fabs(norm - step_norms[step]) < 1e-6 * step_norms[step]))
            fail_msg("step %d: norm %.9g, not %.9g", step, norm, step_norms[step]);
        adam_step(&a, pool, w, gradients[step]);
        for (int i = 0; i < N; i++)
            if (!(fabs((double)w[i] - weights_after[step][i]) < 2e-7))
                fail_msg("step %d: weight %d is %.9g, not %.9g", step, i, (double)w[i],
                         weights_after[step][i]);
    }
    assert_int_equal(a.t, N_STEPS);
    adam_release(&a);
    pool_free(pool);
}

/* Chunks and rests: the same change for every element, whatever the length and the threads; and
 * the norm that was announced. */
static void test_lengths(void **state)
{
    static const size_t lengths[] = {1, 7, 1023, 1025, 16384, 16385, 70001};
    (void)state;
    for (size_t l = 0; l < sizeof lengths / sizeof *lengths; l++) {
        size_t n = lengths[l];
        float *g = toy_take(n, sizeof *g), *w = toy_take(n, sizeof *w);
        struct pool *pool = pool_new(1 + l % 3);
        struct adam a;
        assert_int_equal(adam_init(&a, n, 1e-3, NULL), LMN_OK);
        for (size_t i = 0; i < n; i++) g[i] = 0.1f;
        double norm = adam_step_norm(&a, g);
        adam_step(&a, pool, w, g);
        for (size_t i = 0; i < n; i++) assert_true(w[i] == w[0]);
        assert_true(fabs((double)w[0] + 1e-3) < 1e-8);
        assert_true(fabs(norm - 1e-3 * sqrt((double)n)) < 1e-6 * norm);
        adam_release(&a);
        pool_free(pool);
        mem_free(g);
        mem_free(w);
    }
}

/* The same bytes in every instruction set; an average on the way. */
static void test_sets(void **state)
{
    enum { LENGTH = 5003 };
    float *g = toy_take(LENGTH, sizeof *g), *w[2], *average[2];
    struct pool *pool = pool_new(2);
    struct adam a[2];
    (void)state;
    for (size_t set = 0; set < toy_n_levels; set++) {
        if (!toy_level_runs(toy_levels[set])) continue;
        for (int k = 0; k < 2; k++) {
            w[k] = toy_take(LENGTH, sizeof *w[k]);
            average[k] = toy_take(LENGTH, sizeof *average[k]);
            assert_int_equal(adam_init(&a[k], LENGTH, 1e-2, NULL), LMN_OK);
            a[k].average = average[k];
            a[k].share = 0.25f;
            a[k].cpu = k ? toy_levels[set] : 0;
        }
        for (uint64_t step = 0; step < 4; step++) {
            float before[2] = {average[0][7], w[0][7]};
            toy_fill(g, LENGTH, step);
            for (int k = 0; k < 2; k++) adam_step(&a[k], pool, w[k], g);
            assert_true(w[0][7] != before[1]);
            assert_true(average[0][7] == before[0] + 0.25f * (w[0][7] - before[0]));
        }
        assert_memory_equal(w[0], w[1], LENGTH * sizeof *w[0]);
        assert_memory_equal(average[0], average[1], LENGTH * sizeof *w[0]);
        for (int k = 0; k < 2; k++) {
            adam_release(&a[k]);
            mem_free(w[k]);
            mem_free(average[k]);
        }
    }
    mem_free(g);
    pool_free(pool);
}

/* A long average goes where one of every step goes, in larger steps. */
static void test_long_average(void **state)
{
    enum { STEPS = 400 };
    float g = 1.0f, w = 0.0f, average = 0.0f, plain = 0.0f;
    struct pool *pool = pool_new(1);
    struct adam a;
    (void)state;
    assert_int_equal(adam_init(&a, 1, 1e-2, NULL), LMN_OK);
    a.average = &average;
    a.share = 0.02f;
    for (int step = 1; step <= STEPS; step++) {
        const float before = average;
        adam_step(&a, pool, &w, &g);
        plain += a.share * (w - plain);
        assert_true((average != before) == (step % 4 == 0));
    }
    assert_true(fabsf(average - plain) < 0.02f * fabsf(w)); /* 1.5 steps ahead, of 400 */
    adam_release(&a);
    pool_free(pool);
}

static void test_no_memory(void **state)
{
    struct error err = {{0}};
    struct adam a;
    (void)state;
    for (uint64_t n = 1; n <= 2; n++) {
        mem_fail_after(n);
        assert_int_equal(adam_init(&a, 8, 1e-3, &err), LMN_ERR_MEMORY);
        mem_fail_after(0);
        assert_true(strlen(err.text) > 0 && !a.m && !a.v);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_by_hand),   cmocka_unit_test(test_lengths),
        cmocka_unit_test(test_sets),      cmocka_unit_test(test_long_average),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
