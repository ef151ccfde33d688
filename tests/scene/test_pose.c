/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras that are moved by hand. */
#include "scene/pose.h"

#include <math.h>
#include <string.h>

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

static const struct bounds box = {{-1, 0, -2}, {3, 2, 4}};

static struct sensor sensor_at(struct vec3 origin, struct vec3 target, struct vec3 up)
{
    return (struct sensor){.kind = SENSOR_PERSPECTIVE,
                           .to_world = transform_look_at(origin, target, up),
                           .fov = 40,
                           .scale_x = 1.5f,
                           .scale_y = 0.75f,
                           .focus_distance = 7};
}

static void assert_same(const struct transform *a, const struct transform *b)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            assert_true(fabsf(a->m[i][j] - b->m[i][j]) < 1e-5f);
            assert_true(fabsf(a->inv[i][j] - b->inv[i][j]) < 1e-5f);
        }
}

/* What a sensor's pose says gives the sensor again, mirrored ones too. */
static void poses_come_back(void **state)
{
    static const struct vec3 ups[] = {{0, 1, 0}, {0.3f, 5, -0.2f}, {1, 0, 0}};
    static const enum sensor_kind kinds[] = {SENSOR_PERSPECTIVE, SENSOR_THINLENS,
                                             SENSOR_ORTHOGRAPHIC};
    const struct transform mirror = transform_scale(vec3(-1, 1, 1));
    (void)state;
    for (int i = 0; i < 18; i++) {
        struct error err = {{0}};
        struct sensor s = sensor_at(vec3(1, 1.5f, 6), vec3(0.2f, 0.5f, -1), ups[i % 3]);
        s.kind = kinds[i / 3 % 3];
        if (i >= 9) s.to_world = transform_mul(&s.to_world, &mirror);
        struct sensor moved = s, again = s;
        const struct pose p = pose_of_sensor(&s, &box);
        assert_int_equal(pose_check(&p, &s, &err), LMN_OK);
        moved.to_world = transform_look_at(vec3(9, 9, 9), vec3(0, 0, 0), vec3(0, 1, 0));
        if (i >= 9) moved.to_world = transform_mul(&moved.to_world, &mirror);
        moved.fov = 80;
        moved.scale_x = 4;
        moved.scale_y = 2;
        pose_apply(&p, &again);
        pose_apply(&p, &moved);
        assert_same(&again.to_world, &s.to_world);
        assert_same(&moved.to_world, &s.to_world);
        const bool is_flat = s.kind == SENSOR_ORTHOGRAPHIC;
        assert_true(moved.fov == (is_flat ? 80.0f : 40.0f));
        assert_true(moved.scale_x == (is_flat ? 1.5f : 4.0f));
        assert_true(moved.scale_y == (is_flat ? 0.75f : 2.0f));
        assert_true(again.scale_x == s.scale_x && again.scale_y == s.scale_y);
        assert_int_equal(transform_flips(&moved.to_world), i >= 9);
    }
}

/* Targets are as far away as what is looked at. */
static void targets_are_in_the_scene(void **state)
{
    (void)state;
    struct sensor s = sensor_at(vec3(1, 1, 9), vec3(1, 1, 8), vec3(0, 1, 0));
    assert_true(fabsf(pose_of_sensor(&s, &box).target.z - 1) < 1e-5f);
    s.kind = SENSOR_THINLENS;
    assert_true(fabsf(pose_of_sensor(&s, &box).target.z - 2) < 1e-5f);
    /* Looking away from the middle: half a diagonal ahead. */
    s = sensor_at(vec3(1, 1, 9), vec3(1, 1, 10), vec3(0, 1, 0));
    const float half = 0.5f * sqrtf(16 + 4 + 36);
    assert_true(fabsf(pose_of_sensor(&s, &box).target.z - (9 + half)) < 1e-4f);
    const struct bounds nothing = {{0, 0, 0}, {0, 0, 0}};
    s = sensor_at(vec3(0, 0, 0), vec3(0, 0, 1), vec3(0, 1, 0));
    assert_true(fabsf(pose_of_sensor(&s, &nothing).target.z - 1) < 1e-6f);
}

static void impossible_cameras_are_refused(void **state)
{
    static const struct {
        struct pose pose;
        const char *why;
    } cases[] = {
        {{{NAN, 0, 0}, {0, 0, 1}, {0, 1, 0}, 40}, "not a number"},
        {{{0, 0, 0}, {0, INFINITY, 1}, {0, 1, 0}, 40}, "not a number"},
        {{{0, 0, 0}, {0, 0, 1e25f}, {0, 1, 0}, 40}, "too large"},
        {{{5, 5, 5}, {5, 5, 5}, {0, 1, 0}, 40}, "equal"},
        {{{5000, 5, 5}, {5000, 5, 5.001f}, {0, 1, 0}, 40}, "equal"},
        {{{0, 0, 0}, {0, 0, 1}, {0, 0, 0}, 40}, "up"},
        {{{0, 0, 0}, {0, 0, 1}, {0, 0, -3}, 40}, "up"},
        {{{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0}, "fov 0"},
        {{{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 180}, "fov 180"},
        {{{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, NAN}, "fov"},
    };
    const struct sensor s = sensor_at(vec3(0, 0, 0), vec3(0, 0, 1), vec3(0, 1, 0));
    struct sensor flat = s;
    struct error err = {{0}};
    struct pose p = {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 40};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(pose_check(&cases[i].pose, &s, &err), LMN_ERR_ARGUMENT);
        if (!strstr(err.text, cases[i].why)) fail_msg("%zu: %s", i, err.text);
    }
    assert_int_equal(pose_check(&p, &s, &err), LMN_OK);
    flat.kind = SENSOR_ORTHOGRAPHIC;
    p.fov = 400;
    assert_int_equal(pose_check(&p, &flat, &err), LMN_OK);
    p.fov = 0;
    assert_int_equal(pose_check(&p, &flat, &err), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(err.text, "orthographic"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(poses_come_back),
        cmocka_unit_test(targets_are_in_the_scene),
        cmocka_unit_test(impossible_cameras_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
