/* SPDX-License-Identifier: Apache-2.0 */
/* Fine-tuning: a training that starts from the model of another version of the scene. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/mem.h"
#include "tiny.h"
#include "train/layout.h"
#include "train/model.h"
#include "train/options.h"
#include "train/trainer_inside.h"

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

enum { BASE_STEPS = 120, SHORT_STEPS = 12 };

static const lmn_eval_options test_options = {.n = 3, .resolution = 24, .spp = 64, .seed = 7};

static void must(lmn_status status, const struct error *err)
{
    if (status != LMN_OK) fail_msg("%s", err->text);
}

static lmn_train_options options(void)
{
    lmn_train_options o;
    options_init_method(&o, LMN_METHOD_IMPROVED);
    o.seed = 5;
    o.width = 32;
    o.depth = 2;
    o.memory_mib = 16;
    o.resolution_max = 48;
    o.spp = 4;
    return o;
}

static struct trainer *make(void)
{
    struct error err = {0};
    struct trainer *t = NULL;
    const lmn_train_options o = options();
    must(trainer_new(&tiny.place, &o, &t, &err), &err);
    return t;
}

/* From the model that setup() made. *report may be NULL. */
static struct trainer *make_from_base(const char **report)
{
    struct error err = {0};
    struct trainer *t = make();
    must(trainer_start_from(t, tiny_path(&tiny, "base.lmn"), report, &err), &err);
    return t;
}

static void run(struct trainer *t, int n)
{
    struct error err = {0};
    for (int i = 0; i < n; i++) must(trainer_step(t, NULL, &err), &err);
}

static double error_of(struct trainer *t)
{
    struct error err = {0};
    lmn_metrics m;
    must(trainer_eval(t, &test_options, NULL, NULL, &m, &err), &err);
    return m.mape;
}

static int setup(void **state)
{
    struct error err = {0};
    tiny_setup(state);
    struct trainer *t = make();
    for (int i = 0; i < BASE_STEPS; i++)
        if (trainer_step(t, NULL, &err) != LMN_OK) return -1;
    if (trainer_save(t, tiny_path(&tiny, "base.lmn"), &err) != LMN_OK) return -1;
    trainer_free(t);
    return 0;
}

static void same_scene_starts_where_the_model_is(void **state)
{
    (void)state;
    struct error err = {0};
    struct model *m;
    lmn_eval_result result;
    const char *report;
    struct trainer *t = make_from_base(&report);
    must(model_load(&tiny.place, tiny_path(&tiny, "base.lmn"), false, &m, &err), &err);
    must(model_eval(m, &test_options, NULL, NULL, &result, NULL, NULL, &err), &err);
    assert_true(error_of(t) == result.mean.mape);
    assert_string_equal(report, "taken over: grid of the scene\n"
                                "taken over: grid of ball\n"
                                "taken over: features of the surface\n"
                                "taken over: features of ball\n"
                                "taken over: features of light from lamp\n"
                                "taken over: features of light from lamp past ball\n"
                                "taken over: features of bounces\n"
                                "taken over: variable alpha\n"
                                "taken over: variable ball\n"
                                "taken over: variable shown\n"
                                "taken over: light of fixed power\n"
                                "taken over: 2 layers of 32");
    model_free(m);
    trainer_free(t);
}

/* With everything changed that can be without other inputs: colours, light, geometry. A dozen steps
 * from the model are better than as many from nothing, and than the model alone. */
static void changed_scene_is_learnt_sooner(void **state)
{
    (void)state;
    const char *report;
    tiny_edit(&tiny, "value=\"8, 7, 6\"", "value=\"5, 8, 14\"");
    tiny_edit(&tiny, "value=\"0.6, 0.3, 0.2\"", "value=\"0.2, 0.6, 0.5\"");
    tiny_edit(&tiny, "y=\"2.5\" z=\"0.5\"", "y=\"2.4\" z=\"0\"");
    struct trainer *tuned = make_from_base(&report), *fresh = make();
    assert_null(strstr(report, "new: "));
    assert_null(strstr(report, "dropped: "));
    const double before = error_of(tuned);
    run(tuned, SHORT_STEPS);
    run(fresh, SHORT_STEPS);
    const double after = error_of(tuned), from_nothing = error_of(fresh);
    if (!(after < 0.8 * before && after < 0.7 * from_nothing))
        fail_msg("%.3f, before %.3f, from nothing %.3f", after, before, from_nothing);
    trainer_free(tuned);
    trainer_free(fresh);
    tiny_edit(&tiny, "value=\"5, 8, 14\"", "value=\"8, 7, 6\"");
    tiny_edit(&tiny, "value=\"0.2, 0.6, 0.5\"", "value=\"0.6, 0.3, 0.2\"");
    tiny_edit(&tiny, "y=\"2.4\" z=\"0\"", "y=\"2.5\" z=\"0.5\"");
}

/* Columns of the first layer, [n_out][n] into `out`. */
static void columns(const float *weights, const struct field_config *c, uint32_t first, uint32_t n,
                    float *out)
{
    struct layout_tensor w;
    layout_field_get(c, c->n_grids, &w);
    for (uint32_t row = 0; row < w.n_out; row++)
        memcpy(out + row * n, weights + w.at + (size_t)row * w.n_in + first, n * sizeof *out);
}

/* One variable goes, one is renamed, one comes, and with it something else that moves. */
static void inputs_are_matched_by_name(void **state)
{
    (void)state;
    const char *report;
    static float ball[32], light[32 * 5], now[32 * 5];
    struct trainer *t = make_from_base(NULL);
    const struct field_config from = *learner_field_config(t->learner);
    const uint32_t per_grid = from.grid.n_levels * GRID_FEATURES;
    /* the column of the ball's place, the second variable; five of the light's */
    columns(trainer_weights(t), &from, from.n_grids * per_grid + from.n_features + 1, 1, ball);
    columns(trainer_weights(t), &from, from.n_grids * per_grid + 14 + 4, 5, light);
    trainer_free(t);
    static const char alpha[] =
        "  {\"name\": \"alpha\", \"kind\": \"float\", \"targets\": \"metal.alpha\",\n"
        "   \"range\": [0.1, 0.5], \"default\": 0.3},\n";
    static const char shown[] = "  {\"name\": \"shown\", \"kind\": \"visible\", \"targets\": "
                                "\"ball\", \"default\": true}\n";
    static const char there_and_lift[] =
        "  {\"name\": \"there\", \"kind\": \"visible\", \"targets\": \"ball\", \"default\": "
        "true},\n"
        "  {\"name\": \"lift\", \"kind\": \"translate\", \"targets\": \"lamp\",\n"
        "   \"direction\": [0, 1, 0], \"range\": [-0.5, 0], \"default\": 0}\n";
    static const char start[] = "{\"variables\": [\n";
    tiny_edit(&tiny, alpha, "");
    tiny_edit(&tiny, shown, there_and_lift);
    t = make_from_base(&report);
    const struct field_config to = *learner_field_config(t->learner);
    assert_string_equal(report, "taken over: grid of the scene\n"
                                "taken over: grid of ball\n"
                                "new: grid of lamp\n"
                                "taken over: features of the surface\n"
                                "taken over: features of ball\n"
                                "new: features of lamp\n"
                                "taken over: features of light from lamp\n"
                                "taken over: features of light from lamp past ball\n"
                                "new: features of light from lamp past lamp\n"
                                "taken over: features of bounces\n"
                                "taken over: variable ball\n"
                                "new: variable there\n"
                                "new: variable lift\n"
                                "taken over: light of fixed power\n"
                                "dropped: variable alpha\n"
                                "dropped: variable shown\n"
                                "taken over: 2 layers of 32");
    /* the first variable now; the lamp's own features come before the light's */
    columns(trainer_weights(t), &to, to.n_grids * per_grid + to.n_features, 1, now);
    assert_memory_equal(ball, now, sizeof ball);
    columns(trainer_weights(t), &to, to.n_grids * per_grid + 14 + 8, 5, now);
    assert_memory_equal(light, now, sizeof light);
    assert_true(isfinite(error_of(t)));
    run(t, 2);
    trainer_free(t);
    char with_alpha[256];
    snprintf(with_alpha, sizeof with_alpha, "%s%s", start, alpha);
    tiny_edit(&tiny, there_and_lift, shown);
    tiny_edit(&tiny, start, with_alpha);
}

/* Positions in the scene's box mean something else in another box. */
static void scenes_of_another_size_start_anew(void **state)
{
    (void)state;
    const char *report;
    tiny_edit(&tiny, "y=\"2.5\" z=\"0.5\"", "y=\"4.5\" z=\"0.5\"");
    struct trainer *t = make_from_base(&report);
    assert_non_null(strstr(report, "new: grid of the scene\n"));
    assert_non_null(strstr(report, "dropped: grid of the scene\n"));
    assert_non_null(strstr(report, "taken over: grid of ball\n"));
    trainer_free(t);
    tiny_edit(&tiny, "y=\"4.5\" z=\"0.5\"", "y=\"2.5\" z=\"0.5\"");
}

/* After the start it is a training as any other: it goes on without the model. */
static void resuming_needs_no_model(void **state)
{
    (void)state;
    struct error err = {0};
    struct trainer *whole = make_from_base(NULL), *t = make_from_base(NULL);
    run(whole, 4);
    run(t, 2);
    must(trainer_save(whole, tiny_path(&tiny, "whole.lmn"), &err), &err);
    must(trainer_save(t, tiny_path(&tiny, "part.lmn"), &err), &err);
    trainer_free(whole);
    trainer_free(t);
    char hidden[512];
    strcpy(hidden, tiny_path(&tiny, "hidden.lmn"));
    assert_int_equal(rename(tiny_path(&tiny, "base.lmn"), hidden), 0);
    must(trainer_resume(&tiny.place, tiny_path(&tiny, "part.lmn"), false, &t, &err), &err);
    run(t, 2);
    must(trainer_save(t, tiny_path(&tiny, "part.lmn"), &err), &err);
    trainer_free(t);
    assert_int_equal(rename(hidden, tiny_path(&tiny, "base.lmn")), 0);
    size_t n_a, n_b;
    char *a = tiny_read(tiny_path(&tiny, "whole.lmn.state"), &n_a);
    char *b = tiny_read(tiny_path(&tiny, "part.lmn.state"), &n_b);
    assert_int_equal(n_a, n_b);
    assert_memory_equal(a, b, n_a);
    mem_free(a);
    mem_free(b);

    /* another training than one from nothing: the state of one is not the other's */
    t = make();
    run(t, 4);
    must(trainer_save(t, tiny_path(&tiny, "part.lmn"), &err), &err);
    trainer_free(t);
    assert_int_equal(
        rename(tiny_path(&tiny, "part.lmn.state"), tiny_path(&tiny, "whole.lmn.state")), 0);
    t = NULL;
    assert_int_equal(trainer_resume(&tiny.place, tiny_path(&tiny, "whole.lmn"), false, &t, &err),
                     LMN_ERR_ARGUMENT);
    assert_non_null(strstr(err.text, "another training"));
}

static void assert_refused(struct trainer *t, const char *name, const char *message)
{
    struct error err = {0};
    const char *report = "untouched";
    assert_int_not_equal(trainer_start_from(t, tiny_path(&tiny, name), &report, &err), LMN_OK);
    if (!strstr(err.text, message)) fail_msg("%s", err.text);
    assert_null(strchr(err.text, '\n'));
    assert_string_equal(report, "untouched");
}

static void what_cannot_be_taken_over_is_refused(void **state)
{
    (void)state;
    struct error err = {0};
    struct trainer *t = make(), *other = NULL;
    lmn_train_options o = tiny_options();
    assert_refused(t, "missing.lmn", "cannot open");
    assert_refused(t, "scene.xml", "not a model file");
    must(trainer_new(&tiny.place, &o, &other, &err), &err);
    must(trainer_save(other, tiny_path(&tiny, "faithful.lmn"), &err), &err);
    assert_refused(t, "faithful.lmn", "faithful method");
    assert_refused(other, "base.lmn", "only a new training by the improved method");
    trainer_free(other);
    o = options();
    o.width = 16;
    must(trainer_new(&tiny.place, &o, &other, &err), &err);
    assert_refused(other, "base.lmn", "width 32 and depth 2, not 16 and 2");
    trainer_free(other);
    run(t, 1);
    assert_refused(t, "base.lmn", "only a new training");
    trainer_free(t);
}

static void short_memory_is_an_error(void **state)
{
    (void)state;
    uint32_t n_failed = 0;
    struct trainer *t = make();
    char path[512];
    strcpy(path, tiny_path(&tiny, "base.lmn"));
    for (uint64_t n = 1; n < 1000; n++) {
        struct error err = {0};
        mem_fail_after(n);
        lmn_status status = trainer_start_from(t, path, NULL, &err);
        mem_fail_after(0);
        if (status == LMN_OK) break;
        n_failed++;
    }
    assert_in_range(n_failed, 10, 998);
    trainer_free(t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_scene_starts_where_the_model_is),
        cmocka_unit_test(changed_scene_is_learnt_sooner),
        cmocka_unit_test(inputs_are_matched_by_name),
        cmocka_unit_test(scenes_of_another_size_start_anew),
        cmocka_unit_test(resuming_needs_no_model),
        cmocka_unit_test(what_cannot_be_taken_over_is_refused),
        cmocka_unit_test(short_memory_is_an_error),
    };
    return cmocka_run_group_tests_name("start", tests, setup, tiny_teardown);
}
