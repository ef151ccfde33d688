/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "base/str.h"
#include "train/history.h"
#include "train/options.h"
#include "train/reuse.h"

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

static void probability_is_equation_5(void **state)
{
    (void)state;
    struct reuse r = {.bias = 4.6, .ema = 0.9, .warmup = 1, .n_events = 1};
    assert_float_equal(reuse_probability(&r), 0.99005, 1e-5); /* the paper's 0.99 */
    r.loss_exist = 0.2;
    r.loss_new = 0.5;
    assert_float_equal(reuse_probability(&r), 0.98661, 1e-5);
    r.loss_exist = 0.6;
    assert_float_equal(reuse_probability(&r), 0.99099, 1e-5);
    r.bias = 0;
    r.loss_exist = 0;
    r.loss_new = log(3);
    assert_float_equal(reuse_probability(&r), 0.25, 1e-12);
}

static void warmup_is_always_new(void **state)
{
    (void)state;
    struct reuse r = {.bias = 4.6, .ema = 0.9, .warmup = 100};
    const float losses[2] = {5, 7};
    const bool is_large[2] = {true, true};
    for (int i = 0; i < 99; i++) {
        assert_true(reuse_probability(&r) == 0);
        reuse_record_event(&r, 9, losses, is_large, 2);
        assert_false(reuse_is_warm(&r));
    }
    reuse_record_event(&r, 0.5, losses, is_large, 2); /* event 100 starts both averages */
    assert_true(reuse_is_warm(&r));
    assert_true(r.loss_new == 0.5 && r.loss_exist == 0.5);
    assert_true(reuse_probability(&r) > 0.99);
}

static void averages_take_large_steps_one_by_one(void **state)
{
    (void)state;
    struct reuse r = {.ema = 0.9, .warmup = 1, .n_events = 1, .loss_new = 1, .loss_exist = 1};
    const float losses[3] = {2, 50, 3};
    const bool is_large[3] = {true, false, true};
    reuse_record_event(&r, 99, losses, is_large, 3);
    assert_float_equal(r.loss_new, 0.1 * 3 + 0.9 * (0.1 * 2 + 0.9 * 1), 1e-12);
    assert_true(r.loss_exist == 1);
    reuse_record_replayed(&r, 4, false);
    assert_true(r.loss_exist == 1);
    reuse_record_replayed(&r, 4, true);
    assert_float_equal(r.loss_exist, 1.3, 1e-12);
}

static void history_is_thinned_by_means(void **state)
{
    (void)state;
    struct history h;
    assert_int_equal(history_init(&h, 2, 3, NULL), LMN_OK);
    const uint32_t n = 10000;
    for (uint32_t i = 1; i <= n; i++) {
        double row[HISTORY_COLUMNS] = {[HISTORY_STEP] = i, [HISTORY_LOSS] = i, [HISTORY_FRESH] = 1};
        history_add(&h, row);
        float u[6] = {(float)i};
        history_add_chains(&h, i - 1, i, u);
    }
    assert_int_equal(h.stride, 8);
    assert_int_equal(h.n_rows, n / 8);
    assert_int_equal(h.n_pending, n % 8);
    for (uint32_t i = 0; i < h.n_rows; i++) {
        assert_true(h.rows[i][HISTORY_STEP] == 8.0 * (i + 1));
        assert_true(h.rows[i][HISTORY_LOSS] == 8.0 * i + 4.5);
        assert_true(h.rows[i][HISTORY_FRESH] == 1);
    }
    assert_int_equal(h.snapshot_stride, 128);
    assert_int_equal(h.n_snapshots, 79);
    for (uint32_t i = 0; i < h.n_snapshots; i++) {
        assert_true(h.snapshot_steps[i] == 128.0 * i + 1);
        assert_true(h.snapshots[(size_t)i * 6] == 128.0f * (float)i + 1);
    }
    history_release(&h);
}

static void options_survive_their_text(void **state)
{
    (void)state;
    lmn_train_options o, back;
    options_init(&o);
    assert_int_equal(options_check(&o, NULL), LMN_OK);
    assert_int_equal(o.width, 512);
    assert_true(o.learning_rate == 1e-4 && o.reuse_bias == 4.6 && o.step_min == 0.04);
    o.seed = UINT64_MAX - 5;
    o.has_max_depth = 1;
    o.max_depth = -1;
    o.learning_rate = 1.0 / 3;
    struct str text = {0};
    struct json j = {.out = &text};
    json_begin_object(&j, NULL);
    options_write(&o, &j);
    json_end(&j);
    assert_int_equal(options_read(text.text, "x", &back, NULL), LMN_OK);
    assert_memory_equal(&o, &back, sizeof o);
    str_release(&text);
}

static void bad_options_are_named(void **state)
{
    (void)state;
    struct error err;
    lmn_train_options o;
    options_init(&o);
    o.width = 0;
    assert_int_equal(options_check(&o, &err), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(err.text, "width"));
    options_init(&o);
    o.learning_rate = NAN;
    assert_int_equal(options_check(&o, &err), LMN_ERR_ARGUMENT);
    options_init(&o);
    o.step_min = 0.2;
    assert_int_equal(options_check(&o, &err), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(err.text, "step_max"));

    const char *const bad[] = {
        "", "[]", "{}", "nonsense", "{\"width\":512}", "{\"seed\":1,\"seed\":2}"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(options_read(bad[i], "m.lmn", &o, &err), LMN_ERR_PARSE);
        assert_true(str_starts(err.text, "m.lmn: "));
        assert_null(strchr(err.text, '\n'));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(probability_is_equation_5),
        cmocka_unit_test(warmup_is_always_new),
        cmocka_unit_test(averages_take_large_steps_one_by_one),
        cmocka_unit_test(history_is_thinned_by_means),
        cmocka_unit_test(options_survive_their_text),
        cmocka_unit_test(bad_options_are_named),
    };
    return cmocka_run_group_tests_name("reuse", tests, NULL, NULL);
}
