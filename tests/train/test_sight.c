/* SPDX-License-Identifier: Apache-2.0 */
/* What the compact network sees follows the scene's variables. */
#include "train/sight.h"

#include <math.h>
#include <string.h>

#include "base/cpu.h"
#include "base/mem.h"
#include "tiny.h"
#include "train/history.h"
#include "train/layout.h"
#include "train/learner.h"
#include "train/options.h"
#include "train/sight_inside.h"

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

/* The variables of the tiny scene. */
enum { ALPHA, BALL, IS_THERE, N_VARIABLES };

static struct sight sight;
static struct view *view;

static int setup(void **state)
{
    struct error err = {{0}};
    tiny_setup(state);
    return sight_init(&sight, tiny.scene, 0, &err) || view_new(tiny.place.world, &view, &err);
}

static int teardown(void **state)
{
    view_free(view);
    sight_release(&sight);
    return tiny_teardown(state);
}

/* A point of the picture as the network sees it. */
struct seen {
    float positions[1 + SIGHT_FRAMES][3], features[128], scale[3];
};

static struct seen look(const float *u, const float *buffers)
{
    struct seen seen = {0};
    assert_true(sight.n_features <= 128);
    view_set(view, u);
    sight_look(&sight, view_state(view), buffers, 1, seen.positions[0], seen.features, seen.scale);
    return seen;
}

/* A diffuse point at p. */
static void set_point(float *buffers, float x, float y, float z)
{
    memset(buffers, 0, BUFFER_CHANNELS * sizeof *buffers);
    const float p[3] = {x, y, z}, albedo[3] = {0.5f, 0.25f, 0.0f};
    memcpy(buffers + BUFFER_POSITION, p, sizeof p);
    memcpy(buffers + BUFFER_ALBEDO, albedo, sizeof albedo);
    buffers[BUFFER_NORMAL + 1] = buffers[BUFFER_ROUGHNESS] = 1.0f;
    buffers[BUFFER_WO + 2] = 1.0f;
    buffers[BUFFER_DEPTH] = 1.0f;
}

static void frames_follow_their_things(void **state)
{
    float buffers[BUFFER_CHANNELS], u[N_VARIABLES] = {0.5f, 0.25f, 0.9f};
    (void)state;
    assert_int_equal(sight.n_frames, 1);
    assert_int_equal(sight.n_lights, 1);
    assert_int_equal(sight.n_variables, N_VARIABLES);
    set_point(buffers, 0.0f, 0.1f, 0.2f);
    struct seen before = look(u, buffers);
    /* The ball goes to the right, and the point with it. */
    u[BALL] = 0.75f;
    set_point(buffers, 0.7f, 0.1f, 0.2f);
    struct seen after = look(u, buffers);
    for (int c = 0; c < 3; c++) {
        assert_true(fabsf(before.positions[1][c] - after.positions[1][c]) < 1e-5f);
        assert_true(before.positions[1][c] > 0.0f && before.positions[1][c] < 1.0f);
    }
    assert_true(fabsf(before.positions[0][0] - after.positions[0][0]) > 0.1f);
}

static void hidden_things_give_zeros(void **state)
{
    float buffers[BUFFER_CHANNELS], u[N_VARIABLES] = {0.5f, 0.25f, 0.9f};
    (void)state;
    set_point(buffers, 0.3f, 0.1f, 0.2f);
    struct seen there = look(u, buffers);
    u[IS_THERE] = 0.1f;
    struct seen gone = look(u, buffers);
    uint32_t n_zeros = 0, n_were = 0;
    for (uint32_t i = 0; i < sight.n_features; i++) {
        n_zeros += gone.features[i] == 0.0f;
        n_were += there.features[i] == 0.0f;
    }
    assert_true(n_zeros >= n_were + 6);
    for (int c = 0; c < 3; c++) assert_true(gone.positions[1][c] == 0.5f);
}

/* Only glossy surfaces look different from elsewhere; scale is albedo, but on those not too little
 * to tell anything by; broken numbers do no harm. */
static void surfaces_are_told_apart(void **state)
{
    float buffers[BUFFER_CHANNELS], u[N_VARIABLES] = {0.5f, 0.25f, 0.9f};
    (void)state;
    set_point(buffers, 0.3f, 0.1f, 0.2f);
    struct seen a = look(u, buffers);
    buffers[BUFFER_WO] = 0.6f;
    struct seen b = look(u, buffers);
    assert_memory_equal(a.features, b.features, sizeof a.features);
    assert_true(a.scale[0] == 0.5f && a.scale[1] == 0.25f);
    assert_true(a.scale[2] == 0.0f);
    buffers[BUFFER_WI] = buffers[BUFFER_WI + 2] = 0.5f;
    struct seen glossy = look(u, buffers);
    assert_memory_not_equal(a.features, glossy.features, sizeof a.features);
    assert_true(glossy.scale[0] == 0.5f && glossy.scale[2] > 0.0f && glossy.scale[2] < 0.25f);

    sight.ignores_albedo = true;
    glossy = look(u, buffers);
    buffers[BUFFER_WI] = buffers[BUFFER_WI + 2] = 0.0f;
    a = look(u, buffers);
    sight.ignores_albedo = false;
    for (int c = 0; c < 3; c++) assert_true(a.scale[c] == 1.0f && glossy.scale[c] == 1.0f);

    for (int i = 0; i < BUFFER_CHANNELS; i++) buffers[i] = i % 2 ? NAN : INFINITY;
    struct seen broken = look(u, buffers);
    for (uint32_t i = 0; i < sight.n_features; i++) assert_true(isfinite(broken.features[i]));
    for (int c = 0; c < 3; c++) assert_true(isfinite(broken.scale[c]));
    memset(buffers, 0, sizeof buffers);
    struct seen nothing = look(u, buffers);
    for (int c = 0; c < 3; c++) assert_true(nothing.scale[c] == 0.0f);
}

/* What is kept of pixels is seen as they were, with the bounces they had. */
static void kept_pixels_look_the_same(void **state)
{
    enum { DIFFUSE, GLOSSY, NOTHING, N };
    float buffers[N * BUFFER_CHANNELS], again[N * BUFFER_CHANNELS], kept[N * SIGHT_KEPT];
    float u[N_VARIABLES] = {0.5f, 0.25f, 0.9f}, back[N];
    const float bounces[N] = {0.4f, 0.6f, 1.0f};
    (void)state;
    for (int i = 0; i < N; i++) {
        float *b = buffers + (size_t)i * BUFFER_CHANNELS;
        set_point(b, 0.3f, 0.1f, 0.2f);
        b[BUFFER_GEO_NORMAL + 2] = i == GLOSSY ? -1.0f : 1.0f; /* seen from behind */
    }
    buffers[GLOSSY * BUFFER_CHANNELS + BUFFER_WI] = 0.5f;
    memset(buffers + (size_t)NOTHING * BUFFER_CHANNELS, 0, sizeof(float[BUFFER_CHANNELS]));
    sight_keep(buffers, bounces, N, kept);
    sight_recall(kept, N, again, back);
    assert_true(back[DIFFUSE] == bounces[DIFFUSE] && back[GLOSSY] == bounces[GLOSSY]);
    for (size_t i = 0; i < N; i++) {
        struct seen a = look(u, buffers + i * BUFFER_CHANNELS);
        struct seen b = look(u, again + i * BUFFER_CHANNELS);
        for (int k = 0; k < 3; k++) assert_true(a.scale[k] == b.scale[k]);
        for (int k = 0; k < 6; k++)
            assert_true(a.positions[k / 3][k % 3] == b.positions[k / 3][k % 3]);
        for (uint32_t k = 0; k < sight.n_features; k++) assert_true(a.features[k] == b.features[k]);
        sight_set_bounces(&sight, bounces + i, 1, a.features);
        assert_true(a.features[sight.n_features - 1] == bounces[i]);
        assert_true(a.features[sight.n_features - 2] == b.features[sight.n_features - 2]);
    }
    const struct sight six = {.max_depth = 6}, unbounded = {.max_depth = -1};
    assert_true(sight_bounces(&six, 3) == 0.5f && sight_bounces(&unbounded, -1) == 1.0f);
}

/* Whole frames with every kind of pixel, seen with every instruction set: the same bytes. */
static void instruction_sets_agree(void **state)
{
    enum { W = 23, H = 17, N = W * H };
    static const uint32_t sets[] = {CPU_AVX2, CPU_AVX2 | CPU_AVX512};
    const size_t n_positions = (size_t)N * sight.n_positions * 3;
    const size_t n_features = (size_t)N * sight.n_features;
    float u[N_VARIABLES] = {0.5f, 0.25f, 0.9f},
          *buffers = mem_new(N, sizeof(float[BUFFER_CHANNELS]));
    float *positions = mem_new(2 * n_positions, sizeof(float));
    float *features = mem_new(2 * n_features, sizeof(float));
    float *scale = mem_new(2 * 3 * N, sizeof(float));
    struct trace_settings t;
    struct trace_output output = {.buffers = buffers};
    const struct window window = {W, H, 0, 0, W, H};
    (void)state;
    assert_true(buffers && positions && features && scale);
    trace_settings_init(&t, tiny.scene);
    for (int k = 0; k < 2; k++) {
        u[IS_THERE] = k ? 0.1f : 0.9f;
        view_set(view, u);
        view_trace(view, &t, &window, &output);
        for (int i = 0; i < BUFFER_CHANNELS; i++) buffers[i * (BUFFER_CHANNELS + 1)] = NAN;
        for (size_t i = 0; i < sizeof sets / sizeof *sets; i++) {
            if ((cpu_detect() & sets[i]) != sets[i]) continue;
            for (uint32_t n = 1; n <= N; n += n < 40 ? 1 : N - 40) {
                sight.cpu = 0;
                sight_look(&sight, view_state(view), buffers, n, positions, features, scale);
                sight.cpu = sets[i];
                sight_look(&sight, view_state(view), buffers, n, positions + n_positions,
                           features + n_features, scale + 3 * N);
                sight.cpu = 0;
                assert_memory_equal(positions, positions + n_positions,
                                    3 * (size_t)n * sight.n_positions * sizeof(float));
                assert_memory_equal(features, features + n_features,
                                    (size_t)n * sight.n_features * sizeof(float));
                assert_memory_equal(scale, scale + 3 * N, 3 * (size_t)n * sizeof(float));
            }
        }
    }
    mem_free(buffers);
    mem_free(positions);
    mem_free(features);
    mem_free(scale);
}

/* The parts of what is seen, by name, are as many as the network takes. */
static void all_inputs_have_a_meaning(void **state)
{
    (void)state;
    struct error err = {{0}};
    struct meaning m, read;
    struct str text = {0};
    struct json j = {.out = &text};
    assert_int_equal(sight_describe(&sight, &m, &err), LMN_OK);
    const struct field_config want = sight_field(&sight), got = meaning_field(&m);
    assert_memory_equal(&want, &got, sizeof want);
    meaning_write(&m, &j);
    assert_false(text.failed);
    assert_int_equal(meaning_read(&read, text.text, "here", &err), LMN_OK);
    assert_int_equal(read.n_parts, m.n_parts);
    for (size_t i = 0; i < m.n_parts; i++)
        assert_ptr_equal(meaning_find(&read, &m, &m.parts[i]), &read.parts[i]);
    meaning_release(&read);
    meaning_release(&m);
    str_release(&text);
}

/* A model with all frames and lights that are seen, twelve variables and the longest history. */
static void models_are_small(void **state)
{
    (void)state;
    lmn_train_options o;
    options_init_method(&o, LMN_METHOD_IMPROVED);
    struct field_config c = {.n_grids = 1 + SIGHT_FRAMES,
                             .grid = learner_grid(),
                             .n_features = SIGHT_MOST_FEATURES,
                             .n_variables = 12,
                             .n_lights = FIELD_MAX_LIGHTS,
                             .width = o.width,
                             .depth = o.depth};
    const size_t history = HISTORY_ROWS * HISTORY_COLUMNS * sizeof(double) +
                           (size_t)HISTORY_SNAPSHOTS * o.n_chains * (12 + 2) * sizeof(float);
    const size_t size = layout_field_n_weights(&c) * sizeof(float) + history + (64 << 10);
    if (size > 16 << 20) fail_msg("%zu bytes", size);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_follow_their_things), cmocka_unit_test(hidden_things_give_zeros),
        cmocka_unit_test(surfaces_are_told_apart),    cmocka_unit_test(kept_pixels_look_the_same),
        cmocka_unit_test(instruction_sets_agree),     cmocka_unit_test(all_inputs_have_a_meaning),
        cmocka_unit_test(models_are_small),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
