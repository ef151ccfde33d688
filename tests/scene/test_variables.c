/* SPDX-License-Identifier: Apache-2.0 */
#include "variables_text.h"

#include <math.h>

#include "base/clock.h"
#include "base/rng.h"

/* What each kind of variable writes, and that applying leaves nothing behind. */

#define NEAR 2e-6f

static void assert_vec(const float *v, float x, float y, float z)
{
    assert_float_equal(v[0], x, NEAR);
    assert_float_equal(v[1], y, NEAR);
    assert_float_equal(v[2], z, NEAR);
}

static struct vec3 moved(const struct scene *s, struct scene_state *state, const char *path,
                         struct vec3 p)
{
    return transform_point((const struct transform *)text_value(s, state, path), p);
}

/* Loads, applies u, hands over scene and state. */
static struct scene *at(const char *variables, const float *u, struct scene_state *state)
{
    struct scene *s = text_variables(variables);
    *state = text_state(s);
    scene_apply(s, u, state);
    return s;
}

static void done(struct scene *s, struct scene_state *state)
{
    scene_state_release(state);
    scene_free(s);
}

static void translates(void **unused)
{
    struct scene_state state;
    const float u[] = {1.0f, 0.25f};
    (void)unused;
    struct scene *s = at("{\"name\": \"m\", \"kind\": \"translate\", \"targets\": \"ball\","
                         " \"range\": {\"min\": [-1, 5, 0], \"max\": [1, 5, 4]}}",
                         u, &state);
    assert_int_equal(s->n_variables, 2);
    assert_string_equal(s->variables[0].name, "m.x");
    assert_string_equal(s->variables[1].name, "m.z");
    assert_string_equal(s->variables[1].group, "m");
    assert_string_equal(s->variables[1].kind, "translate");
    assert_string_equal(s->variables[1].unit, "");
    assert_string_equal(s->variables[1].targets, "ball.to_world");
    assert_float_equal(s->variables[0].value, 0, 0); /* where it is */
    assert_float_equal(s->variables[1].value, 0, 0);
    struct vec3 p = moved(s, &state, "ball.to_world", vec3(0, 0, 0));
    assert_vec(&p.x, 1, 5, 1);
    done(s, &state);
}

static void translates_along(void **unused)
{
    struct scene_state state;
    const float u[] = {0.5f};
    (void)unused;
    struct scene *s = at(
        "{\"name\": \"m\", \"kind\": \"translate\", \"targets\": [\"ball\", \"box\"],"
        " \"direction\": [0, 2, -1], \"range\": [1, 3], \"unit\": \"m\"}",
        u, &state);
    assert_int_equal(s->n_variables, 1);
    assert_string_equal(s->variables[0].name, "m");
    assert_string_equal(s->variables[0].unit, "m");
    assert_string_equal(s->variables[0].targets, "ball.to_world box.to_world");
    assert_float_equal(s->variables[0].value, 2, 0);
    struct vec3 p = moved(s, &state, "ball.to_world", vec3(0, 0, 0));
    assert_vec(&p.x, 0, 4, -2);
    p = moved(s, &state, "box.to_world", vec3(1, 1, 1));
    assert_vec(&p.x, 1, 5, -1);
    done(s, &state);
}

/* Geometry has its own to_world in it, so the pivot is the box's place: x = 3. */
static void rotates(void **unused)
{
    struct scene_state state;
    const float u[] = {0.5f};
    (void)unused;
    struct scene *s = at("{\"name\": \"r\", \"kind\": \"rotate\", \"targets\": \"box\","
                         " \"axis\": [0, 3, 0], \"range\": [0, 180]}",
                         u, &state);
    assert_string_equal(s->variables[0].unit, "deg");
    struct vec3 p = moved(s, &state, "box.to_world", vec3(4, 1, 0));
    assert_vec(&p.x, 3, 1, -1);
    done(s, &state);

    s = at("{\"name\": \"r\", \"kind\": \"rotate\", \"targets\": \"box.to_world\","
           " \"axis\": [0, 1, 0], \"pivot\": [0, 0, 0], \"range\": [0, 180]}",
           u, &state);
    p = moved(s, &state, "box.to_world", vec3(4, 1, 0));
    assert_vec(&p.x, 0, 1, -4);
    done(s, &state);
}

static void scales(void **unused)
{
    struct scene_state state;
    const float u[] = {0.5f, 1.0f};
    (void)unused;
    struct scene *s = at("{\"name\": \"k\", \"kind\": \"scale\", \"targets\": \"box\","
                         " \"range\": [1, 3]}",
                         u, &state);
    assert_int_equal(s->n_variables, 1);
    assert_float_equal(s->variables[0].value, 1, 0);
    struct vec3 p = moved(s, &state, "box.to_world", vec3(4, 1, 1));
    assert_vec(&p.x, 5, 2, 2);
    done(s, &state);

    s = at("{\"name\": \"k\", \"kind\": \"scale\", \"targets\": \"box\", \"pivot\": [4, 0, 0],"
           " \"range\": {\"min\": [1, 1, 2], \"max\": [3, 2, 2]}}",
           u, &state);
    assert_int_equal(s->n_variables, 2);
    p = moved(s, &state, "box.to_world", vec3(5, 1, 1));
    assert_vec(&p.x, 6, 2, 2);
    done(s, &state);
}

/* translate * rotate * scale * base, whatever the order of the file; an instance keeps its base. */
static void composes(void **unused)
{
    struct scene_state state;
    const float u[] = {1.0f, 1.0f, 1.0f, 1.0f};
    (void)unused;
    struct scene *s = at("{\"name\": \"k\", \"kind\": \"scale\", \"targets\": \"one\","
                         " \"pivot\": [0, 0, 0], \"range\": [1, 2]},"
                         "{\"name\": \"t\", \"kind\": \"translate\", \"targets\": \"one\","
                         " \"direction\": [0, 1, 0], \"range\": [0, 10]},"
                         "{\"name\": \"r\", \"kind\": \"rotate\", \"targets\": \"one\","
                         " \"axis\": [0, 1, 0], \"pivot\": [0, 0, 0], \"range\": [0, 90]},"
                         "{\"name\": \"q\", \"kind\": \"rotate\", \"targets\": \"one\","
                         " \"axis\": [1, 0, 0], \"pivot\": [0, 0, 0], \"range\": [0, 90]}",
                         u, &state);
    /* (0,1,0) -base-> (-3,2,0) -scale-> (-6,4,0) -q-> (-6,0,4) -r-> (4,0,6) -t-> (4,10,6) */
    struct vec3 p = moved(s, &state, "one.to_world", vec3(0, 1, 0));
    assert_vec(&p.x, 4, 10, 6);
    done(s, &state);
}

/* A shape of a shapegroup moves in the space of the group, the instance takes it along. */
static void moves_parts(void **unused)
{
    struct scene_state state;
    const float u[] = {1.0f, 0.5f};
    (void)unused;
    struct scene *s = at("{\"name\": \"t\", \"kind\": \"translate\", \"targets\": \"part\","
                         " \"direction\": [0, 1, 0], \"range\": [0, 1]},"
                         "{\"name\": \"i\", \"kind\": \"translate\", \"targets\": \"one\","
                         " \"direction\": [0, 0, 1], \"range\": [0, 1]}",
                         u, &state);
    struct vec3 p = moved(s, &state, "part.to_world", vec3(0, 1, 0));
    assert_vec(&p.x, -3, 4, 0.5f);
    p = moved(s, &state, "one.to_world", vec3(0, 1, 0)); /* the lid, which stays in the group */
    assert_vec(&p.x, -3, 2, 0.5f);
    done(s, &state);
}

static void colours(void **unused)
{
    struct scene_state state;
    const float u[] = {0.0f, 0.5f, 1.0f, 0.25f};
    (void)unused;
    struct scene *s = at("{\"name\": \"c\", \"kind\": \"color\", \"targets\": \"wall.reflectance\","
                         " \"range\": [0, 0.5]},"
                         "{\"name\": \"b\", \"kind\": \"color\", \"targets\": \"light.radiance\","
                         " \"from\": [0, 0, 8], \"to\": [4, 8, 0], \"default\": 1}",
                         u, &state);
    assert_int_equal(s->n_variables, 4);
    assert_string_equal(s->variables[2].name, "c.b");
    assert_float_equal(text_variable(s, "c.g")->value, 0.2, 1e-6); /* the scene's own */
    assert_vec(text_value(s, &state, "wall.reflectance.value"), 0, 0.25f, 0.5f);
    assert_vec(text_value(s, &state, "light.radiance.value"), 1, 2, 6);
    assert_vec(text_value(s, &s->defaults, "light.radiance.value"), 4, 8, 0);
    done(s, &state);

    s = at("{\"name\": \"c\", \"kind\": \"color\", \"targets\": [\"tiles.color0\", \"floor_mat."
           "reflectance\"], \"range\": {\"min\": [0, 1, 0], \"max\": [1, 1, 0]}}",
           u + 1, &state);
    assert_int_equal(s->n_variables, 1);
    assert_vec(text_value(s, &state, "tiles.color0.value"), 0.5f, 1, 0);
    assert_vec(text_value(s, &state, "tiles.value"), 0.5f, 1, 0);
    done(s, &state);
}

static void numbers(void **unused)
{
    struct scene_state state;
    const float u[] = {0.5f, 1.0f, 0.0f};
    (void)unused;
    struct scene *s = at(
        "{\"name\": \"a\", \"kind\": \"float\", \"targets\": [\"glass.alpha\", \"metal.alpha\","
        " \"glass.eta\"], \"range\": [0.1, 0.5]},"
        "{\"name\": \"f\", \"kind\": \"float\", \"targets\": \"sensor.fov\","
        " \"range\": [20, 60], \"unit\": \"deg\"},"
        "{\"name\": \"g\", \"kind\": \"float\", \"targets\": \"wall.reflectance.value\","
        " \"range\": [0.3, 0.5]}",
        u, &state);
    assert_float_equal(s->variables[0].value, 0.1, 1e-8);
    assert_float_equal(s->variables[1].value, 40, 1e-6);
    assert_float_equal(text_value(s, &state, "glass.alpha.value")[0], 0.3f, NEAR);
    assert_float_equal(text_value(s, &state, "metal.brdf_0.alpha.value")[0], 0.3f, NEAR);
    assert_float_equal(text_value(s, &state, "glass.eta")[0], 0.3f, NEAR);
    assert_float_equal(state.sensor.fov, 60, NEAR);
    assert_vec(text_value(s, &state, "wall.reflectance.value"), 0.3f, 0.3f, 0.3f);
    done(s, &state);
}

static void lights(void **unused)
{
    struct scene_state state;
    const float u[] = {0.5f, 0.25f};
    (void)unused;
    struct scene *s = at("{\"name\": \"i\", \"kind\": \"intensity\","
                         " \"targets\": [\"light\", \"spark.scale\"], \"range\": [0, 3]},"
                         "{\"name\": \"e\", \"kind\": \"envmap\", \"range\": [0, 360]}",
                         u, &state);
    assert_float_equal(s->variables[0].value, 1, 0);
    assert_string_equal(s->variables[1].targets, "sky.to_world");
    assert_float_equal(text_value(s, &state, "light.scale")[0], 1.5f, NEAR);
    assert_float_equal(text_value(s, &state, "spark.scale")[0], 1.5f, NEAR);
    struct vec3 p = moved(s, &state, "sky.to_world", vec3(1, 0, 0));
    assert_vec(&p.x, 0, 0, -1);
    done(s, &state);

    s = at("{\"name\": \"i\", \"kind\": \"intensity\", \"targets\": \"lamp\", \"range\": [0, 4]}",
           u, &state);
    assert_float_equal(text_value(s, &state, "light.scale")[0], 2, NEAR);
    done(s, &state);
}

static void cameras(void **unused)
{
    struct scene_state state;
    const float u[] = {0.5f, 1.0f, 0.0f};
    (void)unused;
    struct scene *s = at("{\"name\": \"camera\", \"kind\": \"camera\", \"up\": [0, 0, 1],"
                         " \"origin\": {\"min\": [-2, 1, 5], \"max\": [2, 1, 9]},"
                         " \"target\": {\"min\": [0, 0.5, 0], \"max\": [0, 3, 0]}}",
                         u, &state);
    static const char *const names[] = {"camera.x", "camera.z", "camera.target_y"};
    assert_int_equal(s->n_variables, 3);
    for (int i = 0; i < 3; i++) assert_string_equal(s->variables[i].name, names[i]);
    assert_float_equal(s->variables[0].value, 0, 1e-6); /* the scene's own camera */
    assert_float_equal(s->variables[1].value, 5, 1e-6);
    assert_float_equal(s->variables[2].value, 1, 1e-6);
    struct transform wanted = transform_look_at(vec3(0, 1, 9), vec3(0, 0.5f, 0), vec3(0, 0, 1));
    assert_memory_equal(&state.sensor.to_world, &wanted, sizeof wanted);
    done(s, &state);

    /* From a point at itself, and straight up: something finite. */
    s = at("{\"name\": \"camera\", \"kind\": \"camera\","
           " \"origin\": {\"min\": [0, 0, 0], \"max\": [0, 2, 0]}, \"target\": [0, 1, 0]}",
           u, &state);
    assert_int_equal(s->n_variables, 1);
    for (float x = 0; x <= 1; x += 0.25f) {
        scene_apply(s, &x, &state);
        for (int i = 0; i < 12; i++)
            assert_true(isfinite(state.sensor.to_world.m[i / 4][i % 4]) &&
                        isfinite(state.sensor.to_world.inv[i / 4][i % 4]));
    }
    done(s, &state);
}

static void choices(void **unused)
{
    struct scene_state state;
    const float first[] = {0.0f, 0.3f, 0.0f}, last[] = {1.0f, 0.7f, 1.0f};
    (void)unused;
    struct scene *s = at(
        "{\"name\": \"t\", \"kind\": \"choice\", \"targets\": \"floor_mat.reflectance\","
        " \"choices\": [\"stripes\", \"tiles\"]},"
        "{\"name\": \"m\", \"kind\": \"choice\", \"targets\": [\"box\", \"floor.bsdf\"],"
        " \"choices\": [\"metal\", \"glass\", \"wall\"], \"default\": \"glass\"},"
        "{\"name\": \"v\", \"kind\": \"choice\","
        " \"choices\": [\"ball\", {\"name\": \"both\", \"shapes\": [\"box\", \"one\"]}]}",
        first, &state);
    assert_int_equal(s->n_variables, 3);
    assert_int_equal(s->variables[0].n_choices, 2);
    assert_float_equal(s->variables[0].value, 1, 0); /* tiles: what is there */
    assert_float_equal(s->variables[1].value, 1, 0);
    assert_string_equal(s->variables[1].choices[2], "wall");
    assert_string_equal(s->variables[2].choices[1], "both");
    uint32_t textures[2], bsdfs[2];
    memcpy(&textures[0], text_value(s, &state, "floor_mat.reflectance"), 4);
    memcpy(&bsdfs[0], text_value(s, &state, "floor.bsdf"), 4);
    assert_memory_equal(text_value(s, &state, "box.bsdf"), &bsdfs[0], 4);
    assert_int_equal(state.bsdfs[bsdfs[0]].kind, BSDF_TWOSIDED);
    assert_true(*(const bool *)text_value(s, &state, "ball.visible"));
    assert_false(*(const bool *)text_value(s, &state, "box.visible"));
    assert_false(*(const bool *)text_value(s, &state, "one.visible"));
    scene_apply(s, last, &state);
    memcpy(&textures[1], text_value(s, &state, "floor_mat.reflectance"), 4);
    memcpy(&bsdfs[1], text_value(s, &state, "floor.bsdf"), 4);
    assert_int_not_equal(textures[0], textures[1]);
    assert_int_equal(state.bsdfs[bsdfs[1]].kind, BSDF_DIFFUSE);
    assert_false(*(const bool *)text_value(s, &state, "ball.visible"));
    assert_true(*(const bool *)text_value(s, &state, "box.visible"));
    assert_true(*(const bool *)text_value(s, &state, "one.visible"));
    done(s, &state);
}

/* Visible when all say so; the lamp of an invisible instance is off with it. */
static void shows(void **unused)
{
    struct scene_state state;
    const float u[] = {0.9f, 0.1f};
    (void)unused;
    struct scene *s = at(
        "{\"name\": \"a\", \"kind\": \"visible\", \"targets\": [\"part\", \"box\"]},"
        "{\"name\": \"b\", \"kind\": \"visible\", \"targets\": \"one\","
        " \"default\": false}",
        u, &state);
    assert_int_equal(s->variables[0].n_choices, 2);
    assert_float_equal(s->variables[0].value, 1, 0);
    assert_string_equal(s->variables[0].choices[0], "off");
    assert_true(*(const bool *)text_value(s, &state, "box.visible"));
    assert_false(*(const bool *)text_value(s, &state, "part.visible"));
    assert_false(*(const bool *)text_value(s, &state, "one.visible"));
    assert_false(*(const bool *)text_value(s, &s->defaults, "one.visible"));
    done(s, &state);
}

#define MANY                                                                                     \
    "{\"name\": \"k\", \"kind\": \"scale\", \"targets\": \"one\", \"range\": [1, 2]},"           \
    "{\"name\": \"t\", \"kind\": \"translate\", \"targets\": [\"one\", \"ball\"],"               \
    " \"range\": {\"min\": [-1, -1, -1], \"max\": [1, 1, 1]}},"                                  \
    "{\"name\": \"r\", \"kind\": \"rotate\", \"targets\": [\"one\", \"box\"], \"axis\": [1, 2, " \
    "3],"                                                                                        \
    " \"range\": [-90, 270]},"                                                                   \
    "{\"name\": \"c\", \"kind\": \"color\", \"targets\": \"wall.reflectance\", \"range\": [0, "  \
    "1]},"                                                                                       \
    "{\"name\": \"f\", \"kind\": \"float\", \"targets\": \"cam.fov\", \"range\": [20, 60]},"     \
    "{\"name\": \"i\", \"kind\": \"intensity\", \"targets\": \"light\", \"range\": [0, 3]},"     \
    "{\"name\": \"e\", \"kind\": \"envmap\", \"range\": [0, 360]},"                              \
    "{\"name\": \"m\", \"kind\": \"choice\", \"targets\": \"box\","                              \
    " \"choices\": [\"metal\", \"glass\", \"wall\"]},"                                           \
    "{\"name\": \"v\", \"kind\": \"visible\", \"targets\": \"part\"},"                           \
    "{\"name\": \"w\", \"kind\": \"camera\", \"target\": [0, 1, 0],"                             \
    " \"origin\": {\"min\": [-1, 1, 4], \"max\": [1, 1, 6]}}"

/* No configuration is told from how it was come by. */
static void leaves_nothing_behind(void **unused)
{
    (void)unused;
    struct scene *s = text_variables(MANY);
    struct scene_state a = text_state(s), b = text_state(s);
    float u[32], zero[32] = {0}, defaults[32];
    struct rng rng = rng_keyed(1, 2, 3);
    assert_in_range(s->n_variables, 10, 32);
    for (uint32_t i = 0; i < s->n_variables; i++)
        defaults[i] = variable_to_unit(&s->variables[i], s->variables[i].value);
    for (int k = 0; k < 100; k++) {
        for (uint32_t i = 0; i < s->n_variables; i++) u[i] = rng_float(&rng);
        scene_apply(s, u, &a);
        scene_apply(s, zero, &b);
        scene_apply(s, u, &b);
        scene_apply(s, u, &b);
        assert_true(text_is_equal(s, &a, &b));
        scene_apply(s, defaults, &a);
        assert_true(text_is_equal(s, &a, &s->defaults));
        assert_false(text_is_equal(s, &a, &b));
    }
    done(s, &a);
    scene_state_release(&b);
}

static void takes_any_u(void **unused)
{
    (void)unused;
    struct scene *s = text_variables(MANY);
    struct scene_state a = text_state(s), b = text_state(s);
    static const float bad[] = {NAN, -1.0f, 2.0f, INFINITY, -INFINITY};
    static const float instead[] = {0.0f, 0.0f, 1.0f, 1.0f, 0.0f};
    float u[32], v[32];
    for (int k = 0; k < 5; k++) {
        for (int i = 0; i < 32; i++) {
            u[i] = bad[k];
            v[i] = instead[k];
        }
        scene_apply(s, u, &a);
        scene_apply(s, v, &b);
        assert_true(text_is_equal(s, &a, &b));
    }
    done(s, &a);
    scene_state_release(&b);
}

static void is_quick(void **unused)
{
    (void)unused;
    struct scene *s = text_variables(MANY);
    struct scene_state a = text_state(s);
    float u[32] = {0};
    mem_fail_after(1); /* an allocation would fail, and be seen as a crash or a wrong state */
    double start = clock_cpu_s();
    for (int k = 0; k < 2000; k++) {
        u[0] = (float)k / 2000.0f;
        scene_apply(s, u, &a);
    }
    double each = (clock_cpu_s() - start) / 2000;
    mem_fail_after(0);
    printf("scene_apply: %.2f us for %u variables\n", each * 1e6, s->n_variables);
    assert_true(each < 1e-3);
    done(s, &a);
}

static void converts_units(void **unused)
{
    const struct variable range = {.min = -15, .max = 65}, choice = {.max = 2, .n_choices = 3};
    (void)unused;
    assert_float_equal(variable_to_unit(&range, 25), 0.5f, 0);
    assert_float_equal(variable_to_unit(&range, 1e9), 1.0f, 0);
    assert_float_equal(variable_from_unit(&range, 0.25f), 5, 1e-12);
    for (uint32_t k = 0; k < 3; k++)
        assert_float_equal(variable_from_unit(&choice, variable_to_unit(&choice, k)), k, 0);
    assert_float_equal(variable_from_unit(&choice, 1.0f), 2, 0);
    assert_float_equal(variable_from_unit(&choice, 0.34f), 1, 0);
}

/* The hash tells scenes apart by what u means, not by names and defaults. */
static void hashes_meaning(void **unused)
{
    static const char *const texts[] = {
        "{\"name\": \"a\", \"kind\": \"float\", \"targets\": \"cam.fov\", \"range\": [20, 60]}",
        ("{\"name\": \"b\", \"kind\": \"float\", \"targets\": \"sensor.fov\", \"range\": [20, 60],"
         " \"default\": 30, \"description\": \"x\"}"),
        "{\"name\": \"a\", \"kind\": \"float\", \"targets\": \"cam.fov\", \"range\": [20, 61]}",
        "{\"name\": \"a\", \"kind\": \"float\", \"targets\": \"glass.eta\", \"range\": [20, 60]}",
    };
    uint64_t hashes[4];
    (void)unused;
    for (int i = 0; i < 4; i++) {
        struct scene *s = text_variables(texts[i]);
        hashes[i] = s->hash;
        scene_free(s);
    }
    assert_true(hashes[0] == hashes[1]);
    assert_true(hashes[0] != hashes[2]);
    assert_true(hashes[0] != hashes[3]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(translates),
        cmocka_unit_test(translates_along),
        cmocka_unit_test(rotates),
        cmocka_unit_test(scales),
        cmocka_unit_test(composes),
        cmocka_unit_test(moves_parts),
        cmocka_unit_test(colours),
        cmocka_unit_test(numbers),
        cmocka_unit_test(lights),
        cmocka_unit_test(cameras),
        cmocka_unit_test(choices),
        cmocka_unit_test(shows),
        cmocka_unit_test(leaves_nothing_behind),
        cmocka_unit_test(takes_any_u),
        cmocka_unit_test(is_quick),
        cmocka_unit_test(converts_units),
        cmocka_unit_test(hashes_meaning),
    };
    return cmocka_run_group_tests_name("variables", tests, text_setup, text_teardown);
}
