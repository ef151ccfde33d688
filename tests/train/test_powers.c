/* SPDX-License-Identifier: Apache-2.0 */
/* Variables that only change the power of lights, and pictures by group of lights. */
#include "train/powers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/mem.h"
#include "render/view.h"
#include "tiny.h"
#include "train/sight.h"

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

/* Each test edits the scene: a new one every time. */
static int setup(void **state)
{
    (void)state;
    tiny_init(&tiny, 1);
    return 0;
}

static uint32_t variable(const char *name)
{
    for (uint32_t i = 0; i < tiny.scene->n_variables; i++)
        if (strcmp(tiny.scene->variables[i].name, name) == 0) return i;
    fail_msg("no variable %s", name);
    return 0;
}

static struct powers make(void)
{
    struct powers p;
    struct error err = {{0}};
    if (powers_init(&p, tiny.scene, false, &err) != LMN_OK) fail_msg("%s", err.text);
    return p;
}

static const char last_variable[] = "  {\"name\": \"shown\", \"kind\": \"visible\", \"targets\": "
                                    "\"ball\", \"default\": true}\n";

/* Puts variables after the scene's own. */
static void add_variables(const char *text)
{
    char both[1024];
    snprintf(both, sizeof both,
             "  {\"name\": \"shown\", \"kind\": \"visible\", \"targets\": "
             "\"ball\", \"default\": true},\n%s\n",
             text);
    tiny_edit(&tiny, last_variable, both);
}

static void add_bulb(const char *id)
{
    char both[512];
    snprintf(
        both, sizeof both,
        "  <emitter type=\"point\" id=\"%s\"><point name=\"position\" x=\"1\" y=\"2\" z=\"1\"/>"
        "<rgb name=\"intensity\" value=\"2, 3, 4\"/></emitter>\n</scene>\n",
        id);
    tiny_edit(&tiny, "</scene>\n", both);
}

static void without_such_variables_there_is_one_group(void **state)
{
    (void)state;
    struct powers p = make();
    float lights[3];
    assert_int_equal(p.n, 1);
    assert_int_equal(p.n_variables, 0);
    powers_at(&p, &tiny.scene->defaults, lights);
    for (int c = 0; c < 3; c++) assert_true(lights[c] == 1.0f);
    powers_release(&p);
}

static void a_dimmer_leaves_the_learnt_space(void **state)
{
    (void)state;
    add_bulb("bulb");
    add_variables("{\"name\": \"dim\", \"kind\": \"intensity\", \"targets\": \"bulb\",\n"
                  " \"range\": [0.5, 2], \"default\": 1}");
    struct powers p = make();
    struct sight sight;
    struct scene_state at;
    float u[8] = {0}, lights[6];
    struct error err = {{0}};
    const uint32_t dim = variable("dim");
    assert_int_equal(p.n, 2); /* the lamp's power is fixed */
    assert_int_equal(p.first[0], SCENE_NONE);
    assert_int_equal(p.n_variables, 1);
    assert_true(powers_has(&p, dim) && !powers_has(&p, variable("alpha")));
    powers_set_reference(&p, u);
    assert_true(u[dim] == 1.0f);
    assert_int_equal(scene_state_init(tiny.scene, &at, &err), LMN_OK);
    for (int k = 0; k < 3; k++) {
        const float want[] = {0.25f, 0.625f, 1.0f};
        u[dim] = 0.5f * (float)k;
        scene_apply(tiny.scene, u, &at);
        powers_at(&p, &at, lights);
        for (int c = 0; c < 3; c++) {
            assert_true(lights[c] == 1.0f);
            assert_true(fabsf(lights[3 + c] - want[k]) < 1e-6f);
        }
    }
    assert_int_equal(sight_init(&sight, tiny.scene, 0, &err), LMN_OK);
    assert_int_equal(sight_field(&sight).n_lights, 2);
    for (uint32_t i = 0; i < sight.n_variables; i++) assert_true(sight.variables[i] != dim);
    sight_release(&sight);
    scene_state_release(&at);
    powers_release(&p);
}

/* One variable for a light and something else: it must be learnt. */
static void what_drives_more_stays(void **state)
{
    (void)state;
    add_bulb("bulb");
    tiny_edit(&tiny, "\"metal.alpha\"", "[\"metal.alpha\", \"bulb.scale\"]");
    struct powers p = make();
    assert_int_equal(p.n, 1);
    assert_int_equal(p.n_variables, 0);
    powers_release(&p);
}

static void lights_that_dim_together_share_a_group(void **state)
{
    (void)state;
    add_bulb("one");
    add_bulb("two");
    add_bulb("three");
    add_variables("{\"name\": \"pair\", \"kind\": \"intensity\", \"targets\": [\"one\", \"two\"],\n"
                  " \"range\": [0, 1], \"default\": 1},\n"
                  "{\"name\": \"single\", \"kind\": \"intensity\", \"targets\": \"three\",\n"
                  " \"range\": [0, 1], \"default\": 1}");
    struct powers p = make();
    assert_int_equal(p.n, 3);
    assert_int_equal(p.n_variables, 2);
    uint32_t n_of[3] = {0};
    for (uint32_t e = 0; e < tiny.scene->n_emitters; e++) n_of[p.group_of[e]]++;
    assert_int_equal(n_of[0], 1);
    assert_int_equal(n_of[1] + n_of[2], 3);
    powers_release(&p);
}

/* More than there is room for: the others are learnt as any variable. */
static void too_many_lights_are_learnt(void **state)
{
    enum { BULBS = FIELD_MAX_LIGHTS + 2 };
    (void)state;
    char text[2048] = "";
    for (int i = 0; i < BULBS; i++) {
        char id[16];
        snprintf(id, sizeof id, "bulb%d", i);
        add_bulb(id);
        const size_t n = strlen(text);
        snprintf(text + n, sizeof text - n,
                 "%s{\"name\": \"d%d\", \"kind\": \"intensity\", \"targets\": \"%s\", \"range\": "
                 "[0, 1], \"default\": 1}",
                 i > 0 ? ",\n" : "", i, id);
    }
    char both[3072];
    snprintf(both, sizeof both,
             "  {\"name\": \"shown\", \"kind\": \"visible\", \"targets\": "
             "\"ball\", \"default\": true},\n%s\n",
             text);
    tiny_edit(&tiny, last_variable, both);
    struct powers p = make();
    assert_int_equal(p.n, FIELD_MAX_LIGHTS);
    assert_int_equal(p.n_variables, FIELD_MAX_LIGHTS - 1); /* one group is that of fixed powers */
    for (uint32_t e = 0; e < tiny.scene->n_emitters; e++) assert_true(p.group_of[e] < p.n);
    powers_release(&p);
}

/* Targets by group, weighed by the powers of a configuration, are what is traced there. */
static void weighed_groups_are_the_picture(void **state)
{
    enum { N = 64, SPP = 1024 };
    static float groups[4 * N * 3], buffers[N * BUFFER_CHANNELS], split[N * 6], color[N * 3];
    static float whole[N * 3];
    float u[8] = {0.5f, 0.5f, 0.9f}, lights[6];
    struct error err = {{0}};
    struct pixel_at pixels[N];
    struct view *view;
    struct trace_settings t;
    (void)state;
    add_bulb("bulb");
    add_variables("{\"name\": \"dim\", \"kind\": \"intensity\", \"targets\": \"bulb\",\n"
                  " \"range\": [0, 2], \"default\": 1}");
    struct powers p = make();
    assert_int_equal(p.n, 2);
    for (uint32_t i = 0; i < N; i++) pixels[i] = (struct pixel_at){4 + i % 8 * 5, 3 + i / 8 * 3};
    assert_int_equal(view_new(tiny.world, &view, &err), LMN_OK);
    trace_settings_init(&t, tiny.scene);
    t.spp = SPP;
    t.splats = false;
    t.shares_rays = true;
    powers_set_reference(&p, u);
    view_set(view, u);
    struct trace_output by_group = {.color = color,
                                    .buffers = buffers,
                                    .groups = groups,
                                    .n_groups = 4,
                                    .group_of = p.group_of,
                                    .chain_group = 2};
    view_trace_pixels(view, &t, 48, 32, pixels, N, &by_group);
    sight_split_targets(groups, buffers, N, 2, split);
    /* Their sum is the picture less what is seen of the lamp. */
    sight_targets(color, buffers, N, whole);
    for (int i = 0; i < N * 3; i++) {
        float sum = split[i / 3 * 6 + i % 3] + split[i / 3 * 6 + 3 + i % 3];
        assert_true(fabsf(sum - whole[i]) < 1e-4f * (1.0f + whole[i]));
    }
    u[variable("dim")] = 0.3f;
    view_set(view, u);
    powers_at(&p, view_state(view), lights);
    struct trace_output plain = {.color = color, .buffers = buffers};
    view_trace_pixels(view, &t, 48, 32, pixels, N, &plain);
    sight_targets(color, buffers, N, whole);
    double off = 0, mean = 0;
    for (int i = 0; i < N * 3; i++) {
        const int c = i % 3;
        const float x = lights[c] * split[i / 3 * 6 + c] + lights[3 + c] * split[i / 3 * 6 + 3 + c];
        off += fabs((double)(x - whole[i]));
        mean += (double)whole[i];
    }
    if (!(off < 0.02 * mean)) fail_msg("off by %.2f %%", 100 * off / mean);
    view_free(view);
    powers_release(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(without_such_variables_there_is_one_group, setup,
                                        tiny_teardown),
        cmocka_unit_test_setup_teardown(a_dimmer_leaves_the_learnt_space, setup, tiny_teardown),
        cmocka_unit_test_setup_teardown(what_drives_more_stays, setup, tiny_teardown),
        cmocka_unit_test_setup_teardown(lights_that_dim_together_share_a_group, setup,
                                        tiny_teardown),
        cmocka_unit_test_setup_teardown(too_many_lights_are_learnt, setup, tiny_teardown),
        cmocka_unit_test_setup_teardown(weighed_groups_are_the_picture, setup, tiny_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
