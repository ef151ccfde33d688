/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "nn/generator.h"
#include "train/replay.h"

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

enum { PIXELS = 2, VARIABLES = 3 };

static void add(struct replay *m, float mark, float loss, bool is_large)
{
    float inputs[PIXELS * GENERATOR_INPUTS], targets[PIXELS * 3], v[VARIABLES];
    for (int i = 0; i < PIXELS * GENERATOR_INPUTS; i++) inputs[i] = mark;
    for (int i = 0; i < PIXELS * 3; i++) targets[i] = mark + 0.25f;
    for (int i = 0; i < VARIABLES; i++) v[i] = mark + 0.5f;
    replay_add(m, inputs, targets, v, loss, is_large);
}

static void assert_sums(const struct replay *m)
{
    for (uint32_t i = 1; i < m->n_leaves; i++)
        assert_true(m->sums[i] == m->sums[2 * i] + m->sums[2 * i + 1]);
    for (uint32_t i = 0; i < m->n_leaves; i++) {
        double loss = i < m->n ? (double)m->losses[i] : 0;
        assert_true(m->sums[m->n_leaves + i] == loss);
    }
}

static void draws_follow_the_losses(void **state)
{
    (void)state;
    enum { N = 13, DRAWS = 200000 };
    struct replay m;
    assert_int_equal(replay_init(&m, N, PIXELS, VARIABLES, NULL), LMN_OK);
    double total = 0, statistic = 0;
    for (int i = 0; i < N; i++) {
        add(&m, (float)i, i == 4 ? 0.0f : 0.1f * (float)(i + 1), false);
        total += m.losses[i];
    }
    uint32_t counts[N] = {0};
    struct rng r = rng_keyed(1, 2, 3);
    for (int i = 0; i < DRAWS; i++) {
        uint32_t slot = replay_draw(&m, &r);
        assert_in_range(slot, 0, N - 1);
        counts[slot]++;
    }
    assert_int_equal(counts[4], 0);
    for (int i = 0; i < N; i++) {
        double expected = DRAWS * m.losses[i] / total;
        if (i != 4) statistic += (counts[i] - expected) * (counts[i] - expected) / expected;
    }
    assert_true(statistic < 37.4); /* 1e-4 of 11 degrees of freedom */
    replay_release(&m);
}

static void draws_are_uniform_without_losses(void **state)
{
    (void)state;
    struct replay m;
    assert_int_equal(replay_init(&m, 8, PIXELS, VARIABLES, NULL), LMN_OK);
    for (int i = 0; i < 5; i++) add(&m, 0, i == 2 ? NAN : i == 3 ? -1.0f : 0.0f, false);
    uint32_t counts[8] = {0};
    struct rng r = rng_keyed(1, 1, 1);
    for (int i = 0; i < 5000; i++) counts[replay_draw(&m, &r)]++;
    for (int i = 0; i < 5; i++) assert_in_range(counts[i], 850, 1150);
    assert_sums(&m);
    replay_release(&m);
}

static void oldest_goes_with_all_its_records(void **state)
{
    (void)state;
    struct replay m;
    assert_int_equal(replay_init(&m, 5, PIXELS, VARIABLES, NULL), LMN_OK);
    for (uint64_t serial = 0; serial < 23; serial++) {
        add(&m, (float)serial, 1.0f + (float)serial, serial % 3 == 0);
        assert_int_equal(m.n_added, serial + 1);
        assert_int_equal(m.n, serial < 5 ? serial + 1 : 5);
        uint64_t oldest = serial < 5 ? 0 : serial - 4;
        double total = 0;
        for (uint64_t s = 0; s <= serial + 2; s++) {
            uint32_t slot = replay_slot(&m, s);
            if (s < oldest || s > serial) {
                assert_int_equal(slot, UINT32_MAX);
                continue;
            }
            assert_true(m.losses[slot] == 1.0f + (float)s);
            assert_int_equal(m.is_large[slot], s % 3 == 0);
            assert_true(m.inputs[(size_t)slot * PIXELS * GENERATOR_INPUTS] == (float)s);
            assert_true(m.inputs[(size_t)(slot + 1) * PIXELS * GENERATOR_INPUTS - 1] == (float)s);
            assert_true(m.targets[(size_t)(slot + 1) * PIXELS * 3 - 1] == (float)s + 0.25f);
            assert_true(m.v[(size_t)slot * VARIABLES] == (float)s + 0.5f);
            total += 1.0 + (double)s;
        }
        assert_true(m.sums[1] == total);
        assert_sums(&m);
    }
    replay_release(&m);
}

static void updates_and_rebuild_agree(void **state)
{
    (void)state;
    enum { N = 37 };
    struct replay m;
    assert_int_equal(replay_init(&m, N, PIXELS, VARIABLES, NULL), LMN_OK);
    struct rng r = rng_keyed(9, 9, 9);
    for (int i = 0; i < 100; i++) {
        add(&m, 0, rng_float(&r), false);
        replay_set_loss(&m, rng_below(&r, m.n), rng_float(&r));
    }
    double before[128];
    assert_int_equal(m.n_leaves, 64);
    memcpy(before, m.sums, sizeof before);
    memset(m.sums, 0, sizeof before);
    replay_rebuild(&m);
    assert_memory_equal(before, m.sums, sizeof before);
    assert_sums(&m);
    replay_release(&m);
}

static void nothing_is_remembered_without_room(void **state)
{
    (void)state;
    struct replay m;
    assert_int_equal(replay_init(&m, 0, PIXELS, VARIABLES, NULL), LMN_OK);
    add(&m, 1, 1, true);
    assert_int_equal(m.n, 0);
    assert_int_equal(replay_slot(&m, 0), UINT32_MAX);
    replay_release(&m);
    struct error err;
    mem_fail_after(3);
    assert_int_equal(replay_init(&m, 5, PIXELS, VARIABLES, &err), LMN_ERR_MEMORY);
    mem_fail_after(0);
    assert_int_equal(replay_init(&m, UINT32_MAX, 1, 3, &err), LMN_ERR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(draws_follow_the_losses),
        cmocka_unit_test(draws_are_uniform_without_losses),
        cmocka_unit_test(oldest_goes_with_all_its_records),
        cmocka_unit_test(updates_and_rebuild_agree),
        cmocka_unit_test(nothing_is_remembered_without_room),
    };
    return cmocka_run_group_tests_name("replay", tests, NULL, NULL);
}
