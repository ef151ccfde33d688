/* SPDX-License-Identifier: Apache-2.0 */
#include "variables_text.h"

#include <math.h>

#include "scene/assign.h"

/* Values as people give them, and random ones. */

#define VARIABLES                                                                           \
    "{\"name\": \"door\", \"kind\": \"rotate\", \"targets\": \"box\", \"axis\": [0, 1, 0]," \
    " \"range\": [-15, 65], \"default\": 20},"                                              \
    "{\"name\": \"wall\", \"kind\": \"color\", \"targets\": \"wall.reflectance\","          \
    " \"range\": [0, 0.8]},"                                                                \
    "{\"name\": \"stuff\", \"kind\": \"choice\", \"targets\": \"box\","                     \
    " \"choices\": [\"wall\", \"metal\", \"glass\"]},"                                      \
    "{\"name\": \"cover\", \"kind\": \"visible\", \"targets\": \"lid\"}"

enum { N = 6 };

static void accepts(void **unused)
{
    static const struct {
        const char *text;
        double values[N];
    } cases[] = {
        {"door=0.5", {0.5, .1, .2, .3, 0, 1}},       {"door=-15", {-15, .1, .2, .3, 0, 1}},
        {" door = 30 deg ", {30, .1, .2, .3, 0, 1}}, {"door=30deg", {30, .1, .2, .3, 0, 1}},
        {"door=50%", {25, .1, .2, .3, 0, 1}},        {"door=100%", {65, .1, .2, .3, 0, 1}},
        {"wall=.2,.3,.4", {20, .2, .3, .4, 0, 1}},   {"wall=0%, 50%, 0.8", {20, 0, .4, .8, 0, 1}},
        {"wall.g=5e-1", {20, .1, .5, .3, 0, 1}},     {"stuff=glass", {20, .1, .2, .3, 2, 1}},
        {"stuff=1", {20, .1, .2, .3, 1, 1}},         {"stuff=50%", {20, .1, .2, .3, 1, 1}},
        {"stuff=100%", {20, .1, .2, .3, 2, 1}},      {"cover=off", {20, .1, .2, .3, 0, 0}},
        {"cover=true", {20, .1, .2, .3, 0, 1}},      {"cover=no", {20, .1, .2, .3, 0, 0}},
    };
    (void)unused;
    struct scene *s = text_variables(VARIABLES);
    assert_int_equal(s->n_variables, N);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double values[N];
        struct error err = {{0}};
        scene_default_values(s, values);
        if (scene_parse_value(s, cases[i].text, values, &err) != LMN_OK)
            fail_msg("%s: %s", cases[i].text, err.text);
        for (int k = 0; k < N; k++) {
            if (fabs(values[k] - cases[i].values[k]) > 1e-6)
                fail_msg("%s: %g at %d", cases[i].text, values[k], k);
        }
    }
    scene_free(s);
}

static void refuses(void **unused)
{
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"door", "\"door\" is not NAME=VALUE"},
        {"dor=1", "unknown variable \"dor\"; did you mean \"door\"?"},
        {"=1", "unknown variable \"\""},
        {"wal=1,1,1", "unknown variable \"wal\"; did you mean \"wall\"?"},
        {"something=1", "unknown variable \"something\"; the first of this scene is \"door\""},
        {"door=66", "door: 66 is outside its range -15 .. 65 deg; did you mean 65?"},
        {"door=-16", "door: -16 is outside its range -15 .. 65 deg; did you mean -15?"},
        {"door=101%", "door: 101% is outside 0% .. 100%"},
        {"door=-1%", "door: -1% is outside 0% .. 100%"},
        {"door=x%", "door: \"x%\" is not a number"},
        {"door=", "door: \"\" is not a number"},
        {"door=nan", "door: \"nan\" is not a number"},
        {"door=1,2", "door takes one value, not 2"},
        {"wall=1", "wall takes 3 values (wall.r,wall.g,wall.b), not 1"},
        {"wall=.1,.2,9", "wall.b: 9 is outside its range 0 .. 0.8; did you mean 0.8?"},
        {"stuff=glas", "stuff: \"glas\" is not among its choices; did you mean \"glass\"?"},
        {"stuff=3", "stuff: \"3\" is not among its choices"},
        {"stuff=1.5", "stuff: \"1.5\" is not among its choices"},
        {"cover=maybe", "cover: \"maybe\" is not among its choices"},
    };
    (void)unused;
    struct scene *s = text_variables(VARIABLES);
    double values[N], before[N];
    scene_default_values(s, values);
    memcpy(before, values, sizeof before);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct error err = {{0}};
        assert_int_equal(scene_parse_value(s, cases[i].text, values, &err), LMN_ERR_ARGUMENT);
        if (strncmp(err.text, cases[i].message, strlen(cases[i].message)) != 0)
            fail_msg("\"%s\" instead of \"%s\"", err.text, cases[i].message);
        assert_memory_equal(values, before, sizeof before);
    }
    scene_free(s);
}

static void draws(void **unused)
{
    enum { DRAWS = 4000 };
    double mean[N] = {0}, a[N], b[N];
    uint32_t counts[3] = {0};
    (void)unused;
    struct scene *s = text_variables(VARIABLES);
    for (uint64_t i = 0; i < DRAWS; i++) {
        scene_random_values(s, 5, i, a);
        for (int k = 0; k < N; k++) {
            const struct variable *v = &s->variables[k];
            assert_true(a[k] >= v->min && a[k] <= v->max);
            mean[k] += (a[k] - v->min) / (v->max - v->min) / DRAWS;
        }
        counts[(int)a[4]]++;
    }
    /* 4.5 standard errors of a mean of uniform (and of coin) draws */
    for (int k = 0; k < N; k++) assert_float_equal(mean[k], 0.5, 4.5 * 0.5 / sqrt(DRAWS));
    for (int k = 0; k < 3; k++) assert_in_range(counts[k], 1200, 1467);

    float u[N];
    scene_random_values(s, 5, 17, a);
    scene_random_values(s, 5, 17, b);
    assert_memory_equal(a, b, sizeof a);
    scene_random_units(s, 5, 17, u);
    for (int k = 0; k < N; k++)
        assert_float_equal(variable_from_unit(&s->variables[k], u[k]), a[k], 0);
    scene_random_values(s, 6, 17, b);
    assert_memory_not_equal(a, b, sizeof a);
    scene_free(s);
}

static void round_trips(void **unused)
{
    float u[N], w[N];
    double values[N];
    (void)unused;
    struct scene *s = text_variables(VARIABLES);
    struct scene_state a = text_state(s);
    scene_values_to_units(s, NULL, u);
    scene_default_values(s, values);
    scene_values_to_units(s, values, w);
    assert_memory_equal(u, w, sizeof u);
    scene_apply(s, u, &a);
    assert_true(text_is_equal(s, &a, &s->defaults));
    scene_state_release(&a);
    scene_free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(accepts), cmocka_unit_test(refuses),
                                       cmocka_unit_test(draws), cmocka_unit_test(round_trips)};
    return cmocka_run_group_tests_name("assignments", tests, text_setup, text_teardown);
}
