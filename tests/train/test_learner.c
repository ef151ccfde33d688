/* SPDX-License-Identifier: Apache-2.0 */
/* The improved method on a tiny scene. */
#include "train/learner.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "scene/assign.h"
#include "tiny.h"
#include "train/options.h"

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

enum { WIDTH = 30, HEIGHT = 20, N = WIDTH * HEIGHT * 3, TESTS = 4 };

static struct learner_options defaults(void)
{
    lmn_train_options from;
    struct learner_options o;
    options_init_method(&from, LMN_METHOD_IMPROVED);
    learner_options_init(&o, &from);
    return o;
}

static lmn_status make_with(const struct learner_options *o, struct learner **out,
                            struct error *err)
{
    struct trace_settings trace;
    trace_settings_init(&trace, tiny.scene);
    return learner_new(&tiny.place, o, &trace, out, err);
}

/* Of a few seconds. */
static struct learner_options short_options(void)
{
    struct learner_options o = defaults();
    o.width = 32;
    o.depth = 2;
    o.n_fresh = 16;
    o.n_pixels = 32;
    o.n_roots = 8;
    o.cut_after = 2;
    o.n_batch = 64;
    o.memory_mib = 16;
    return o;
}

static struct learner *make_with_looks(uint32_t n_looks, double children)
{
    struct learner *l;
    struct error err = {{0}};
    struct learner_options o = short_options();
    o.n_looks = n_looks;
    o.children = children;
    if (make_with(&o, &l, &err) != LMN_OK) fail_msg("%s", err.text);
    return l;
}

static struct learner *make(void)
{
    return make_with_looks(0, 0);
}

static struct learner *make_exploring(void)
{
    return make_with_looks(128, 0.25);
}

static void run(struct learner *l, int n)
{
    struct error err = {{0}};
    for (int i = 0; i < n; i++)
        if (learner_step(l, NULL, &err) != LMN_OK) fail_msg("%s", err.text);
}

static void paint(struct learner *l, uint32_t index, float *out)
{
    float u[8];
    struct error err = {{0}};
    struct painter p;
    struct image image;
    const struct painter_network network = learner_network(l);
    const struct model_render_options o = {.window = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT},
                                           .buffer_spp = 4};
    assert_true(tiny.scene->n_variables <= 8);
    scene_random_units(tiny.scene, 99, index, u);
    learner_show_average(l, true);
    if (painter_init(&p, &tiny.place, &network, &err) != LMN_OK ||
        painter_render(&p, u, &o, &image, NULL, NULL, NULL, &err) != LMN_OK)
        fail_msg("%s", err.text);
    learner_show_average(l, false);
    memcpy(out, image.data, N * sizeof *out);
    image_release(&image);
    painter_release(&p);
}

static void trace(uint32_t index, float *out)
{
    float u[8];
    struct view *view;
    struct trace_settings t;
    struct error err = {{0}};
    const struct window w = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT};
    struct trace_output output = {.color = out};
    assert_int_equal(view_new(tiny.place.world, &view, &err), LMN_OK);
    scene_random_units(tiny.scene, 99, index, u);
    view_set(view, u);
    trace_settings_init(&t, tiny.scene);
    t.spp = 256;
    t.splats = false;
    assert_int_equal(view_trace_parallel(view, tiny.pool, &t, &w, &output, NULL, NULL, &err),
                     LMN_OK);
    view_free(view);
}

/* Mean of |x - r| / (r + .01) over configurations that were not learnt. */
static double error_of(struct learner *l)
{
    static float x[N], r[N];
    double sum = 0;
    for (uint32_t k = 0; k < TESTS; k++) {
        paint(l, k, x);
        trace(k, r);
        for (int i = 0; i < N; i++) sum += fabs((double)(x[i] - r[i])) / ((double)r[i] + 0.01);
    }
    return sum / (N * TESTS);
}

static void learning_helps(void **state)
{
    (void)state;
    struct learner *l = make();
    double before = error_of(l);
    run(l, 400);
    double after = error_of(l);
    if (!(after < 0.12 && after < 0.2 * before)) fail_msg("error %.3f, was %.3f", after, before);
    learner_free(l);
}

static void threads_do_not_matter(void **state)
{
    static float pictures[4][N];
    (void)state;
    for (uint32_t k = 0; k < 4; k++) {
        tiny_set_threads(&tiny, 1 + 2 * (k & 1));
        struct learner *l = k < 2 ? make() : make_exploring();
        run(l, 5);
        paint(l, 0, pictures[k]);
        learner_free(l);
    }
    tiny_set_threads(&tiny, 2);
    assert_memory_equal(pictures[0], pictures[1], sizeof pictures[0]);
    assert_memory_equal(pictures[2], pictures[3], sizeof pictures[0]);
    assert_memory_not_equal(pictures[0], pictures[2], sizeof pictures[0]);
}

/* Pixels chosen by what is expected of them, with weights: the same is learnt. */
static void exploration_learns_the_same(void **state)
{
    (void)state;
    struct learner *l = make_exploring();
    double before = error_of(l);
    run(l, 400);
    double after = error_of(l);
    if (!(after < 0.12 && after < 0.2 * before)) fail_msg("error %.3f, was %.3f", after, before);
    learner_free(l);
}

/* Each part can be left out, and is. */
static void parts_can_be_left_out(void **state)
{
    (void)state;
    struct learner *whole = make();
    const struct field_config *all = learner_field_config(whole);
    for (uint32_t part = LMN_WITHOUT_FRAMES; part <= LMN_WITHOUT_CHAINS; part *= 2) {
        struct learner *l;
        struct learner_stats stats;
        struct error err = {{0}};
        lmn_train_options from;
        struct learner_options o;
        options_init_method(&from, LMN_METHOD_IMPROVED);
        from.without = part;
        from.memory_mib = 16;
        from.width = 16;
        from.spp = 4;
        learner_options_init(&o, &from);
        assert_int_equal(o.n_photons == 0, part == LMN_WITHOUT_PHOTONS);
        o.n_pixels = 32;
        o.cut_after = 2;
        if (make_with(&o, &l, &err) != LMN_OK) fail_msg("%u: %s", part, err.text);
        run(l, 4);
        learner_get_stats(l, &stats);
        assert_true(isfinite(stats.loss) && stats.loss > 0);
        const struct field_config *c = learner_field_config(l);
        assert_int_equal(c->n_grids < all->n_grids, part == LMN_WITHOUT_FRAMES);
        assert_int_equal(c->n_features < all->n_features,
                         part == LMN_WITHOUT_FRAMES || part == LMN_WITHOUT_LIGHTS);
        assert_int_equal(c->ignores_halves, part == LMN_WITHOUT_HALVES);
        assert_int_equal(learner_network(l).sight->ignores_albedo, part == LMN_WITHOUT_ALBEDO);
        assert_int_equal(stats.n_batch < 32, part == LMN_WITHOUT_REPLAY);
        const bool is_last = memcmp(learner_average(l), field_weights(learner_network(l).field),
                                    field_n_weights(learner_network(l).field) * sizeof(float)) == 0;
        assert_int_equal(is_last, part == LMN_WITHOUT_AVERAGE);
        learner_free(l);
    }
    learner_free(whole);
}

/* A wall that is a mirror shows the ball, which is learnt as what it is. */
static void mirrors_are_looked_through(void **state)
{
    static const char rough[] = "<bsdf type=\"diffuse\" id=\"wall\">\n    <rgb name=\"";
    static const char smooth[] = "<bsdf type=\"conductor\" id=\"wall\">\n    <rgb name=\"specular_";
    double errors[2];
    (void)state;
    tiny_edit(&tiny, rough, smooth);
    for (uint32_t k = 0; k < 2; k++) {
        struct learner *l;
        struct error err = {{0}};
        struct learner_options o = short_options();
        o.without = k == 0 ? 0 : LMN_WITHOUT_CHAINS;
        if (make_with(&o, &l, &err) != LMN_OK) fail_msg("%s", err.text);
        assert_int_equal(learner_network(l).sight->follows_delta, k == 0);
        run(l, 400);
        errors[k] = error_of(l);
        learner_free(l);
    }
    if (!(errors[0] < 0.12 && errors[0] < 0.8 * errors[1]))
        fail_msg("error %.3f, without chains %.3f", errors[0], errors[1]);
    static float pictures[2][N];
    for (uint32_t k = 0; k < 2; k++) {
        tiny_set_threads(&tiny, 1 + 2 * k);
        struct learner *l = make();
        run(l, 5);
        paint(l, 0, pictures[k]);
        learner_free(l);
    }
    tiny_set_threads(&tiny, 2);
    assert_memory_equal(pictures[0], pictures[1], sizeof pictures[0]);
    tiny_edit(&tiny, smooth, rough);
}

/* Behind a mirror are the bounces that training left, whatever the scene says. */
static void pictures_count_the_bounces_of_training(void **state)
{
    static const char rough[] = "<bsdf type=\"diffuse\" id=\"wall\">\n    <rgb name=\"";
    static const char smooth[] = "<bsdf type=\"conductor\" id=\"wall\">\n    <rgb name=\"specular_";
    static float pictures[2][N];
    (void)state;
    tiny_edit(&tiny, rough, smooth);
    for (uint32_t k = 0; k < 2; k++) { /* the scene's own 3, or training's over the scene's 6 */
        struct learner *l;
        struct error err = {{0}};
        struct trace_settings trace;
        const struct learner_options o = short_options();
        if (k == 1) tiny_edit(&tiny, "max_depth\" value=\"3\"", "max_depth\" value=\"6\"");
        trace_settings_init(&trace, tiny.scene);
        assert_int_equal(trace.max_depth, k == 0 ? 3 : 6);
        trace.max_depth = 3;
        if (learner_new(&tiny.place, &o, &trace, &l, &err) != LMN_OK) fail_msg("%s", err.text);
        run(l, 5);
        paint(l, 0, pictures[k]);
        learner_free(l);
    }
    tiny_edit(&tiny, "max_depth\" value=\"6\"", "max_depth\" value=\"3\"");
    tiny_edit(&tiny, smooth, rough);
    assert_memory_equal(pictures[0], pictures[1], sizeof pictures[0]);
}

/* Light paths end early where that spares much: in a closed room, and not in the open. */
static void only_long_paths_end_early(void **state)
{
    static const char open[] = "<shape type=\"rectangle\" id=\"back\">";
    static const char closed[] =
        "<shape type=\"sphere\" id=\"dome\"><float name=\"radius\" value=\"6\"/>"
        "<boolean name=\"flip_normals\" value=\"true\"/><bsdf type=\"diffuse\"/></shape>"
        "<shape type=\"rectangle\" id=\"back\">";
    static float pictures[3][N];
    (void)state;
    tiny_edit(&tiny, "max_depth\" value=\"3\"", "max_depth\" value=\"8\"");
    for (int is_closed = 0; is_closed < 2; is_closed++) {
        if (is_closed) tiny_edit(&tiny, open, closed);
        for (int k = 0; k < 3; k++) { /* may end early, with threads, may not */
            struct learner *l;
            struct error err = {{0}};
            struct learner_options o = short_options();
            if (k == 2) o.n_roots = 0;
            tiny_set_threads(&tiny, k == 1 ? 3 : 1);
            if (make_with(&o, &l, &err) != LMN_OK) fail_msg("%s", err.text);
            run(l, 5);
            paint(l, 0, pictures[k]);
            learner_free(l);
        }
        const bool ends = memcmp(pictures[0], pictures[2], sizeof pictures[0]) != 0;
        assert_int_equal(ends, is_closed);
        assert_memory_equal(pictures[0], pictures[1], sizeof pictures[0]);
    }
    tiny_set_threads(&tiny, 2);
    tiny_edit(&tiny, closed, open);
    tiny_edit(&tiny, "max_depth\" value=\"8\"", "max_depth\" value=\"3\"");
}

/* The ring of configurations comes round. */
static void memory_is_bounded(void **state)
{
    struct learner *l;
    struct error err = {{0}};
    struct learner_options o = defaults();
    struct learner_stats stats;
    (void)state;
    o.memory_mib = 1;
    o.n_fresh = 1 << 12;
    assert_int_equal(make_with(&o, &l, &err), LMN_ERR_ARGUMENT);
    assert_null(l);
    o.n_fresh = 40;
    o.n_batch = 50;
    if (make_with(&o, &l, &err) != LMN_OK) fail_msg("%s", err.text);
    run(l, 12);
    assert_int_equal(learner_step(l, &stats, &err), LMN_OK);
    assert_int_equal(stats.step, 13);
    assert_int_equal(stats.n_configurations, 13 * 40);
    assert_true(isfinite(stats.loss) && stats.loss > 0);
    learner_free(l);
}

/* A step that fails can be saved after: the memory holds what the counters say. */
static void failed_steps_change_nothing(void **state)
{
    struct learner *l = make();
    struct error err = {{0}};
    struct learner_stats before, after;
    struct tensor a[LEARNER_TENSORS], b[LEARNER_TENSORS];
    (void)state;
    run(l, 3);
    learner_get_stats(l, &before);
    learner_tensors(l, a);
    struct field *f = learner_network(l).field;
    float *last = &field_weights(f)[field_n_weights(f) - 2], kept = *last; /* blue of the light */
    *last = NAN;
    field_weights_changed(f);
    assert_int_equal(learner_step(l, NULL, &err), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(err.text, "came apart"));
    learner_get_stats(l, &after);
    learner_tensors(l, b);
    assert_int_equal(after.step, before.step);
    assert_int_equal(after.n_configurations, before.n_configurations);
    for (int i = 0; i < LEARNER_TENSORS; i++) assert_int_equal(a[i].shape[0], b[i].shape[0]);
    *last = kept;
    field_weights_changed(f);
    run(l, 1);
    learner_free(l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(learning_helps),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(exploration_learns_the_same),
        cmocka_unit_test(parts_can_be_left_out),
        cmocka_unit_test(memory_is_bounded),
        cmocka_unit_test(failed_steps_change_nothing),
        cmocka_unit_test(mirrors_are_looked_through),
        cmocka_unit_test(pictures_count_the_bounces_of_training),
        cmocka_unit_test(only_long_paths_end_early),
    };
    return cmocka_run_group_tests(tests, tiny_setup, tiny_teardown);
}
