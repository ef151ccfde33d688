/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "train/explorer.h"

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

static const struct explorer_options usual = {.n_chains = 16,
                                              .dim = 4,
                                              .seed = 7,
                                              .large_step = 0.3,
                                              .step_min = 1.0 / 25,
                                              .step_max = 1.0 / 20};

static struct explorer make(const struct explorer_options *options)
{
    struct explorer e;
    assert_int_equal(explorer_init(&e, options, NULL), LMN_OK);
    return e;
}

/* Pearson's statistic of n counts that should be equal. */
static double chi_square(const uint32_t *counts, uint32_t n_bins, double n_total)
{
    double expected = n_total / n_bins, sum = 0;
    for (uint32_t i = 0; i < n_bins; i++)
        sum += (counts[i] - expected) * (counts[i] - expected) / expected;
    return sum;
}

/* The signed way from a to b around the unit circle, in (-1/2, 1/2]. */
static double around(float a, float b)
{
    double d = (double)b - (double)a;
    return d - floor(d + 0.5);
}

static void small_steps_have_kelemens_density(void **state)
{
    (void)state;
    enum { N = 40000, BINS = 20 };
    const double s1 = 1.0 / 25, s2 = 1.0 / 20;
    uint32_t counts[BINS] = {0}, n_up = 0;
    for (uint32_t i = 0; i < N; i++) {
        struct rng r = rng_keyed(3, i, 0);
        float u[2] = {0.5f, 0.25f}, v[2];
        explorer_small_step(u, 2, s1, s2, &r, v);
        double d = (double)v[i & 1] - (double)u[i & 1];
        n_up += d > 0;
        /* ln(d / s1) / ln(s2 / s1) is uniform under the density 1 / (d ln(s2 / s1)). */
        double t = log(fabs(d) / s1) / log(s2 / s1);
        assert_true(t > -1e-5 && t < 1 + 1e-5);
        int bin = (int)(t * BINS);
        counts[bin < 0 ? 0 : bin >= BINS ? BINS - 1 : bin]++;
    }
    assert_true(chi_square(counts, BINS, N) < 50.8); /* 1e-4 of 19 degrees of freedom */
    assert_true(fabs(n_up - N / 2.0) < 4 * sqrt(N / 4.0));
}

static void small_steps_wrap_around(void **state)
{
    (void)state;
    const float starts[] = {0.0f, 0x1p-30f, 0.01f, 0.96f, 0.99f, 0x1.fffffep-1f};
    uint32_t n_wrapped = 0;
    for (uint32_t i = 0; i < 6000; i++) {
        struct rng r = rng_keyed(5, i, 0);
        float u = starts[i % 6], v;
        explorer_small_step(&u, 1, 1.0 / 25, 1.0 / 20, &r, &v);
        assert_true(v >= 0.0f && v < 1.0f);
        double d = fabs(around(u, v));
        assert_true(d > 1.0 / 25 - 1e-6 && d < 1.0 / 20 + 1e-6);
        n_wrapped += fabs((double)v - (double)u) > 0.5;
    }
    assert_true(n_wrapped > 2000);
}

static void first_states_are_uniform_and_accepted(void **state)
{
    (void)state;
    struct explorer_options options = usual;
    options.n_chains = 1024;
    options.large_step = 0;
    struct explorer e = make(&options);
    bool accepted[1024];
    uint32_t counts[16] = {0};
    explorer_propose(&e);
    assert_int_equal(explorer_decide(&e, NULL, NULL, accepted), 1024);
    assert_memory_equal(e.u, e.proposals, 1024 * 4 * sizeof *e.u);
    for (uint32_t i = 0; i < 1024 * 4; i++) counts[(int)(e.u[i] * 16)]++;
    assert_true(chi_square(counts, 16, 1024 * 4) < 44.3); /* 1e-4 of 15 */
    for (uint32_t i = 0; i < 1024; i++) assert_true(e.is_large[i] && accepted[i]);
    explorer_release(&e);
}

static void large_steps_have_their_share(void **state)
{
    (void)state;
    enum { GENERATIONS = 2000 };
    struct explorer e = make(&usual);
    float p[16] = {0};
    bool accepted[16];
    double n_large = 0;
    for (uint32_t g = 0; g < GENERATIONS; g++) {
        explorer_propose(&e);
        for (uint32_t i = 0; g > 0 && i < 16; i++) {
            n_large += e.is_large[i];
            for (uint32_t k = 0; k < 4 && !e.is_large[i]; k++) {
                double d = fabs(around(e.u[4 * i + k], e.proposals[4 * i + k]));
                assert_true(d > 0.0399 && d < 0.0501);
            }
        }
        explorer_decide(&e, p, p, accepted); /* equal: accepted */
        assert_true(accepted[3]);
    }
    double n = 16.0 * (GENERATIONS - 1);
    assert_true(fabs(n_large - 0.3 * n) < 4 * sqrt(0.21 * n));
    explorer_release(&e);
}

static void worse_proposals_are_refused(void **state)
{
    (void)state;
    struct explorer e = make(&usual);
    bool accepted[16];
    float before[16 * 4];
    explorer_propose(&e);
    explorer_decide(&e, NULL, NULL, accepted);
    memcpy(before, e.u, sizeof before);
    explorer_propose(&e);
    float p_states[16], p_proposals[16];
    for (int i = 0; i < 16; i++) {
        p_states[i] = 1;
        p_proposals[i] = i % 4 == 0 ? 0.5f : i % 4 == 1 ? 1.0f : i % 4 == 2 ? 2.0f : NAN;
    }
    assert_int_equal(explorer_decide(&e, p_states, p_proposals, accepted), 12);
    for (uint32_t i = 0; i < 16; i++) {
        assert_int_equal(accepted[i], i % 4 != 0);
        const float *from = accepted[i] ? e.proposals : before;
        assert_memory_equal(e.u + 4 * i, from + 4 * i, 4 * sizeof(float));
    }
    explorer_release(&e);
}

static void uniform_baseline_draws_uniformly(void **state)
{
    (void)state;
    struct explorer_options options = usual;
    options.large_step = 1;
    options.accepts_all = true;
    struct explorer e = make(&options);
    bool accepted[16];
    uint32_t counts[20] = {0};
    for (uint32_t g = 0; g < 1000; g++) {
        explorer_propose(&e);
        assert_int_equal(explorer_decide(&e, NULL, NULL, accepted), 16);
        for (uint32_t i = 0; i < 64; i++) counts[(int)(e.u[i] * 20)]++;
    }
    assert_true(chi_square(counts, 20, 64000) < 50.8);
    explorer_release(&e);
}

/* A fixed target: Eq. 4 never goes down, and every chain ends near the top of a smooth hill. */
static void chains_climb_a_fixed_target(void **state)
{
    (void)state;
    struct explorer_options options = usual;
    options.dim = 2;
    struct explorer e = make(&options);
    float p_states[16] = {0}, p_proposals[16];
    bool accepted[16];
    for (uint32_t g = 0; g < 2000; g++) {
        explorer_propose(&e);
        for (uint32_t i = 0; i < 16; i++) {
            const float *v = e.proposals + 2 * i;
            double dx = around(0.7f, v[0]), dy = around(0.2f, v[1]);
            p_proposals[i] = (float)exp(-10 * (dx * dx + dy * dy));
        }
        explorer_decide(&e, p_states, p_proposals, accepted);
        for (uint32_t i = 0; i < 16; i++) {
            if (!accepted[i]) continue;
            assert_true(p_proposals[i] >= p_states[i]);
            p_states[i] = p_proposals[i];
        }
    }
    for (uint32_t i = 0; i < 16; i++) assert_true(p_states[i] > 0.98f);
    explorer_release(&e);
}

/*
 * A target that training wears down where it is visited, p_b = w_b / (1 + visits of bin b): the
 * chains must level p, that is, spend their visits in proportion to w (the paper's Fig. 6).
 */
static void visits_follow_a_target_that_learns(void **state)
{
    (void)state;
    enum { BINS = 25, GENERATIONS = 20000 };
    struct explorer_options options = usual;
    options.dim = 1;
    struct explorer e = make(&options);
    double w[BINS], visits[BINS] = {0}, w_sum = 0;
    for (uint32_t b = 0; b < BINS; b++) {
        w[b] = b >= 10 && b < 13 ? 20 : 1 + 0.1 * b;
        w_sum += w[b];
    }
    float p_states[16], p_proposals[16];
    bool accepted[16];
    for (uint32_t g = 0; g < GENERATIONS; g++) {
        explorer_propose(&e);
        for (uint32_t i = 0; i < 16; i++) {
            uint32_t now = (uint32_t)(e.u[i] * BINS), next = (uint32_t)(e.proposals[i] * BINS);
            p_states[i] = (float)(w[now] / (1 + visits[now]));
            p_proposals[i] = (float)(w[next] / (1 + visits[next]));
        }
        explorer_decide(&e, p_states, p_proposals, accepted);
        for (uint32_t i = 0; i < 16; i++) visits[(uint32_t)(e.u[i] * BINS)]++;
    }
    double n = 0, distance = 0;
    for (uint32_t b = 0; b < BINS; b++) n += visits[b];
    for (uint32_t b = 0; b < BINS; b++) distance += 0.5 * fabs(visits[b] / n - w[b] / w_sum);
    assert_true(distance < 0.05);
    explorer_release(&e);
}

/* Numbers are keyed by the generation: a restored explorer goes on as if it had not stopped. */
static void generations_can_be_repeated(void **state)
{
    (void)state;
    struct explorer a = make(&usual), b = make(&usual);
    bool accepted[16];
    for (uint32_t g = 0; g < 5; g++) {
        explorer_propose(&a);
        explorer_decide(&a, a.u, a.u, accepted);
    }
    b.generation = a.generation;
    memcpy(b.u, a.u, 16 * 4 * sizeof *a.u);
    explorer_propose(&a);
    explorer_propose(&b);
    assert_memory_equal(a.proposals, b.proposals, 16 * 4 * sizeof *a.u);
    explorer_release(&a);
    explorer_release(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_steps_have_kelemens_density),
        cmocka_unit_test(small_steps_wrap_around),
        cmocka_unit_test(first_states_are_uniform_and_accepted),
        cmocka_unit_test(large_steps_have_their_share),
        cmocka_unit_test(worse_proposals_are_refused),
        cmocka_unit_test(uniform_baseline_draws_uniformly),
        cmocka_unit_test(chains_climb_a_fixed_target),
        cmocka_unit_test(visits_follow_a_target_that_learns),
        cmocka_unit_test(generations_can_be_repeated),
    };
    return cmocka_run_group_tests_name("explorer", tests, NULL, NULL);
}
