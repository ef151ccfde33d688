/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/frames.h"

#include "variables_text.h"

#include <math.h>

#include "scene/assign.h"

/* Frames that variables move: what has one, and that things stay where they are in theirs. */

#define MOVE(name, targets)                                                   \
    "{\"name\": \"" name "\", \"kind\": \"translate\", \"targets\": " targets \
    ", \"range\": {\"min\": [-1, 0, -2], \"max\": [3, 1, 2]}}"
#define TURN(name, targets)                                                \
    "{\"name\": \"" name "\", \"kind\": \"rotate\", \"targets\": " targets \
    ", \"axis\": [1, 2, 0.5], \"range\": [-90, 120]}"

static struct scene_frames frames_of(const struct scene *s)
{
    struct scene_frames f;
    struct error err;
    if (scene_frames_init(s, &f, &err) != LMN_OK) fail_msg("%s", err.text);
    return f;
}

/* The k-th of random configurations; the 0th is that of the file. */
static void set_configuration(const struct scene *s, uint64_t k, struct scene_state *state)
{
    float u[256];
    scene_random_units(s, 5, k, u);
    if (k == 0) scene_values_to_units(s, NULL, u);
    scene_apply(s, u, state);
}

static void done(struct scene *s, struct scene_frames *f)
{
    scene_frames_release(f);
    scene_free(s);
}

static void assert_near(struct vec3 a, struct vec3 b, float tolerance)
{
    const float off = vec3_length(vec3_sub(a, b));
    if (!(off <= tolerance))
        fail_msg("(%g %g %g) is not (%g %g %g)", (double)a.x, (double)a.y, (double)a.z, (double)b.x,
                 (double)b.y, (double)b.z);
}

static bool is_within(struct vec3 p, float side)
{
    return fabsf(p.x) <= side && fabsf(p.y) <= side && fabsf(p.z) <= side;
}

/* Corner i of what the group of an instance fills, in the world. */
static struct vec3 corner(const struct scene *s, const struct scene_state *state, uint32_t instance,
                          int i)
{
    const struct instance *in = &state->instances[instance];
    const struct bounds *b = &s->groups[in->group].bounds;
    return transform_point(&in->to_world,
                           vec3(i & 1 ? b->max.x : b->min.x, i & 2 ? b->max.y : b->min.y,
                                i & 4 ? b->max.z : b->min.z));
}

/* All that moves stays where it is in its frame, and within the cube; the frame's own two ways
 * agree. Objects of one instance fill the cube unless they are thin. Returns how far a centre has
 * moved. */
static float check_objects(const struct scene *s, const struct scene_frames *f)
{
    struct scene_state start = text_state(s), state = text_state(s);
    float most = 0;
    for (uint64_t n = 0; n < 20; n++) {
        set_configuration(s, n, &state);
        for (uint32_t k = 0; k < f->n; k++) {
            struct scene_frame at_start, now;
            scene_frame_at(f, &start, k, &at_start);
            scene_frame_at(f, &state, k, &now);
            assert_float_equal(vec3_length(now.axis), 1, 1e-5);
            assert_near(transform_point(&now.to_local, now.center), vec3_splat(0), 1e-4f);
            most = fmaxf(most, vec3_length(vec3_sub(now.center, at_start.center)));
            if (now.kind != FRAME_OBJECT) continue;
            struct vec3 widest = vec3_splat(0);
            for (int i = 0; i < 8; i++) {
                const struct vec3 p = corner(s, &state, now.index, i);
                const struct vec3 q = corner(s, &start, now.index, i);
                const struct vec3 local = transform_point(&now.to_local, p);
                assert_near(local, transform_point(&at_start.to_local, q), 1e-4f);
                assert_near(transform_point_inverse(&now.to_local, local), p, 1e-4f);
                assert_true(is_within(local, 1.0001f));
                widest = vec3(fmaxf(widest.x, local.x), fmaxf(widest.y, local.y),
                              fmaxf(widest.z, local.z));
            }
            assert_true(vec3_max(widest) > 0.1f);
        }
    }
    scene_state_release(&start);
    scene_state_release(&state);
    return most;
}

static void nothing_moves(void **state)
{
    (void)state;
    struct scene *s = text_variables(
        "{\"name\": \"c\", \"kind\": \"color\", \"targets\": \"wall.reflectance\","
        " \"range\": [0, 1]},"
        "{\"name\": \"camera\", \"kind\": \"camera\","
        " \"origin\": {\"min\": [-1, 1, 3], \"max\": [1, 2, 4]}, \"target\": [0, 1, 0]},"
        "{\"name\": \"v\", \"kind\": \"visible\", \"targets\": \"box\"},"
        "{\"name\": \"i\", \"kind\": \"intensity\", \"targets\": \"spark\", \"range\": [0, 1]}");
    struct scene_frames f = frames_of(s);
    assert_int_equal(f.n, 0);
    done(s, &f);
    s = text_scene("<shape type='cube'/>" TEXT_SENSOR);
    f = frames_of(s);
    assert_int_equal(f.n, 0);
    done(s, &f);
}

static void objects_stay_in_their_frames(void **state)
{
    (void)state;
    struct scene *s = text_variables(MOVE("m", "\"ball\"") "," TURN("t", "\"ball\"") "," TURN(
        "u", "\"box\"") ","
                        "{\"name\": \"z\", \"kind\": \"scale\", \"targets\": \"box\","
                        " \"range\": {\"min\": [0.5, 1, 1], \"max\": [2, 4, 1]}}," //
                                     MOVE("w", "\"one\"") "," MOVE("l", "\"lamp\""));
    struct scene_frames f = frames_of(s);
    assert_int_equal(f.n, 4);
    assert_true(check_objects(s, &f) > 1);
    struct scene_state at = text_state(s);
    uint32_t n_shine = 0, last = 0;
    for (uint32_t k = 0; k < f.n; k++) {
        struct scene_frame x;
        scene_frame_at(&f, &at, k, &x);
        assert_int_equal(x.kind, FRAME_OBJECT);
        assert_true(x.is_visible);
        assert_true(k == 0 || x.index > last);
        last = x.index;
        n_shine += x.shines;
    }
    assert_int_equal(n_shine, 1);
    scene_state_release(&at);
    done(s, &f);
}

/* A ball of radius 1 at (1, 2, 3) has its bounds on the cube; a sheet its sides, and a thickness
 * that is no abyss. */
static void bounds_fill_the_cube(void **state)
{
    (void)state;
    struct scene *s = text_variables(MOVE("m", "\"ball\"") "," MOVE("l", "\"lamp\""));
    struct scene_frames f = frames_of(s);
    struct scene_state at = text_state(s);
    struct scene_frame ball, lamp;
    assert_int_equal(f.n, 2);
    scene_frame_at(&f, &at, 0, &ball);
    scene_frame_at(&f, &at, 1, &lamp);
    assert_near(ball.center, vec3(1, 2, 3), 1e-6f);
    assert_near(transform_point(&ball.to_local, vec3(2, 2, 3)), vec3(1, 0, 0), 1e-6f);
    assert_near(transform_point(&ball.to_local, vec3(0, 1, 4)), vec3(-1, -1, 1), 1e-6f);
    assert_near(transform_point(&lamp.to_local, vec3(1, -1, 0)), vec3(1, -1, 0), 1e-6f);
    assert_near(transform_point(&lamp.to_local, vec3(0, 0, 1)), vec3(0, 0, 1 / FRAME_MIN_SIDE),
                1e-5f);
    scene_state_release(&at);
    done(s, &f);
}

/* Whether all that an instance fills lies in the cube. */
static bool is_inside(const struct scene *s, const struct scene_state *at,
                      const struct scene_frame *x, uint32_t instance)
{
    for (int i = 0; i < 8; i++)
        if (!is_within(transform_point(&x->to_local, corner(s, at, instance, i)), 1.0001f))
            return false;
    return true;
}

/* Things on one variable are one thing, seen while a part of it is; the same motion by another
 * variable is another. */
static void together_is_one(void **state)
{
    (void)state;
    struct scene *s = text_variables(MOVE("m", "[\"ball\", \"lamp\", \"one\"]") "," MOVE(
        "n",
        "\"box\"") ","
                   "{\"name\": \"v\", \"kind\": \"visible\", \"targets\": [\"ball\", \"one\"]},"
                   "{\"name\": \"w\", \"kind\": \"visible\", \"targets\": \"lamp\"}");
    struct scene_frames f = frames_of(s);
    struct scene_state at = text_state(s);
    struct scene_frame box, rest;
    uint32_t n_hidden = 0;
    assert_int_equal(f.n, 2);
    assert_int_equal(s->n_instances, 5);
    check_objects(s, &f);
    for (uint64_t n = 0; n < 40; n++) {
        bool is_seen = false;
        set_configuration(s, n, &at);
        scene_frame_at(&f, &at, 0, &box);
        scene_frame_at(&f, &at, 1, &rest);
        if (box.shines) {
            const struct scene_frame other = box;
            box = rest;
            rest = other;
        }
        assert_true(rest.shines && !box.shines && box.is_visible);
        for (uint32_t i = 1; i < 5; i++) {
            if (i == box.index) continue;
            assert_true(is_inside(s, &at, &rest, i));
            is_seen |= at.instances[i].is_visible;
        }
        assert_int_equal(rest.is_visible, is_seen);
        n_hidden += !is_seen;
    }
    assert_in_range(n_hidden, 3, 20); /* a quarter is expected */
    scene_state_release(&at);
    done(s, &f);
}

static void hidden_is_told(void **state)
{
    (void)state;
    static const char shown_or_not[] = MOVE(
        "m", "\"ball\"") ",{\"name\": \"v\", \"kind\": \"visible\", \"targets\": \"ball\"}";
    struct scene *s = text_variables(shown_or_not);
    struct scene_frames f = frames_of(s);
    struct scene_state at = text_state(s);
    assert_int_equal(f.n, 1);
    for (int shown = 0; shown < 2; shown++) {
        float u[4] = {0.5f, 0.5f, 0.5f, shown ? 0.75f : 0.25f};
        struct scene_frame x;
        assert_int_equal(s->n_variables, 4);
        scene_apply(s, u, &at);
        scene_frame_at(&f, &at, 0, &x);
        assert_int_equal(x.is_visible, shown);
        assert_near(x.center, vec3(2, 2.5f, 3), 1e-5f); /* all the same */
    }
    scene_state_release(&at);
    done(s, &f);
}

/* Shrunk beyond what floats can turn back: hidden, and finite. */
static void nothing_is_finite(void **state)
{
    (void)state;
    struct scene *s = text_variables(MOVE("m", "\"box\""));
    struct scene_frames f = frames_of(s);
    struct scene_state at = text_state(s);
    struct scene_frame x;
    assert_int_equal(f.n, 1);
    scene_frame_at(&f, &at, 0, &x);
    at.instances[x.index].to_world = transform_scale(vec3_splat(0));
    scene_frame_at(&f, &at, 0, &x);
    assert_false(x.is_visible);
    for (int i = 0; i < 12; i++)
        assert_true(isfinite((&x.to_local.m[0][0])[i]) && isfinite((&x.to_local.inv[0][0])[i]));
    assert_true(vec3_is_finite(x.center) && vec3_is_finite(x.axis));
    scene_state_release(&at);
    done(s, &f);
}

static void lights_have_frames(void **state)
{
    (void)state;
    static const char xml[] =
        "<scene version='3.0.0'>" TEXT_SENSOR
        "<shape type='cube' id='c'><transform name='to_world'><scale x='3' y='4' z='12'/>"
        "</transform></shape>"
        "<emitter type='point' id='p'><point name='position' x='1' y='2' z='3'/></emitter>"
        "<emitter type='directional' id='d'><vector name='direction' x='0' y='-1' z='0'/></emitter>"
        "<emitter type='spot' id='s'><transform name='to_world'>"
        "<lookat origin='0,5,0' target='1,5,0' up='0,1,0'/></transform></emitter>"
        "<emitter type='sunsky' id='y'><vector name='sun_direction' x='0' y='0.6' z='0.8'/>"
        "</emitter><emitter type='point' id='q'/></scene>";
    struct scene *s;
    struct error err;
    text_write_string("s.xml", xml);
    text_write_string(
        "s.variables.json",
        "{\"variables\": [" MOVE("m", "\"p\"") "," TURN("t", "\"d\"") "," TURN(
            "r", "\"s\"") ","
                          "{\"name\": \"h\", \"kind\": \"float\", \"targets\": \"y.sun_elevation\","
                          " \"range\": [10, 60]}]}");
    if (text_load_file("s.xml", NULL, &s, &err) != LMN_OK) fail_msg("%s", err.text);
    struct scene_frames f = frames_of(s);
    struct scene_state at = text_state(s);
    struct scene_frame x;
    assert_int_equal(f.n, 4);
    assert_true(check_objects(s, &f) > 1);
    for (uint64_t n = 0; n < 10; n++) {
        set_configuration(s, n, &at);
        for (uint32_t k = 0; k < f.n; k++) {
            scene_frame_at(&f, &at, k, &x);
            const struct emitter *e = &at.emitters[x.index];
            const bool is_far = e->kind == EMITTER_DIRECTIONAL || e->kind == EMITTER_SKY;
            assert_true(x.is_visible && x.shines);
            assert_int_equal(x.kind, is_far ? FRAME_AROUND : FRAME_LIGHT);
            const struct vec3 place = transform_point(&e->to_world, vec3_splat(0));
            assert_near(x.center, is_far ? vec3_splat(0) : place, 1e-5f);
            /* The diagonal is 26 long. */
            const struct vec3 ahead = vec3_add(x.center, vec3_scale(x.axis, is_far ? 13 : 6.5f));
            assert_near(transform_point(&x.to_local, ahead), vec3(0, 0, 1), 1e-5f);
            if (e->kind == EMITTER_POINT) assert_near(x.axis, vec3(0, 0, 1), 1e-6f);
            if (e->kind == EMITTER_DIRECTIONAL || e->kind == EMITTER_SPOT)
                assert_near(x.axis, transform_vector(&e->to_world, vec3(0, 0, 1)), 1e-5f);
            if (e->kind != EMITTER_SKY) continue;
            /* The sun stands above +z of the sky's space. */
            const struct vec3 up = transform_vector(&e->to_world, vec3(0, 0, 1));
            assert_float_equal(-vec3_dot(up, x.axis), sinf(e->sun_elevation * 3.14159265f / 180),
                               1e-5);
        }
    }
    scene_state_release(&at);
    done(s, &f);
}

/* A turned environment keeps its picture in its frame. */
static void environments_turn(void **state)
{
    (void)state;
    struct scene *s = text_variables("{\"name\": \"e\", \"kind\": \"envmap\", \"range\": [0, 360],"
                                     " \"default\": 0}");
    struct scene_frames f = frames_of(s);
    struct scene_state at = text_state(s);
    struct scene_frame start, x;
    assert_int_equal(f.n, 1);
    scene_frame_at(&f, &at, 0, &start);
    for (uint64_t n = 1; n < 10; n++) {
        set_configuration(s, n, &at);
        scene_frame_at(&f, &at, 0, &x);
        assert_int_equal(x.kind, FRAME_AROUND);
        for (int i = 0; i < 3; i++) {
            const struct vec3 d = vec3(i == 0, i == 1, i == 2);
            const struct transform *now = &at.emitters[x.index].to_world;
            const struct transform *then = &s->defaults.emitters[x.index].to_world;
            assert_near(transform_vector(&x.to_local, transform_vector(now, d)),
                        transform_vector(&start.to_local, transform_vector(then, d)), 1e-5f);
        }
        assert_near(x.center, start.center, 1e-5f);
    }
    scene_state_release(&at);
    done(s, &f);
}

/* The bundled scene: ball, knot and lamp. */
static void demo_moves(void **state)
{
    (void)state;
    struct scene *s;
    struct error err;
    struct scene_load_options options = {.note = text_on_note};
    if (scene_load(LMN_SOURCE_DIR "/scenes/demo/scene.xml", &options, &s, &err) != LMN_OK)
        fail_msg("%s", err.text);
    struct scene_frames f = frames_of(s);
    assert_int_equal(f.n, 3);
    assert_true(check_objects(s, &f) > 0.3f);
    done(s, &f);
}

static void memory_runs_out(void **state)
{
    (void)state;
    struct scene *s = text_variables(MOVE("m", "[\"ball\", \"spark\"]"));
    struct scene_frames f;
    struct error err;
    for (uint64_t n = 1; n <= 3; n++) {
        mem_fail_after(n);
        const lmn_status status = scene_frames_init(s, &f, &err);
        mem_fail_after(0);
        assert_int_equal(status, LMN_ERR_MEMORY);
    }
    f = frames_of(s);
    assert_int_equal(f.n, 2);
    done(s, &f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_moves),        cmocka_unit_test(objects_stay_in_their_frames),
        cmocka_unit_test(bounds_fill_the_cube), cmocka_unit_test(together_is_one),
        cmocka_unit_test(hidden_is_told),       cmocka_unit_test(nothing_is_finite),
        cmocka_unit_test(lights_have_frames),   cmocka_unit_test(environments_turn),
        cmocka_unit_test(demo_moves),           cmocka_unit_test(memory_runs_out),
    };
    return cmocka_run_group_tests(tests, text_setup, text_teardown);
}
