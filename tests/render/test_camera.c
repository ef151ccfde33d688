/* SPDX-License-Identifier: Apache-2.0 */
/* Rays of all kinds of sensors: what must hold of each by geometry. */
#include <math.h>

#include "base/rng.h"
#include "render/camera.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

enum { WIDTH = 60, HEIGHT = 40 };

static struct sensor make_sensor(enum sensor_kind kind)
{
    return (struct sensor){
        .kind = kind,
        .to_world = transform_look_at(vec3(1, 2, 3), vec3(2, 2.5f, 0), vec3(0, 1, 0.1f)),
        .fov = 50,
        .near_clip = 0.5f,
        .far_clip = 20,
        .aperture_radius = 0.2f,
        .focus_distance = 4,
        .scale_x = 1.5f,
        .scale_y = 3};
}

static struct camera make_camera(const struct sensor *s)
{
    struct camera c;
    camera_init(&c, s, WIDTH, HEIGHT);
    return c;
}

static void assert_near(struct vec3 a, struct vec3 b)
{
    if (!(vec3_length(vec3_sub(a, b)) <= 1e-4f))
        fail_msg("(%g %g %g) instead of (%g %g %g)", (double)a.x, (double)a.y, (double)a.z,
                 (double)b.x, (double)b.y, (double)b.z);
}

/* A point of the ray in camera space. */
static struct vec3 in_camera(const struct sensor *s, const struct ray *r, float t)
{
    return transform_point_inverse(&s->to_world, vec3_madd(r->o, r->d, t));
}

/* Every ray starts in the near plane and ends in the far one, with a direction of length 1. */
static void rays_run_from_plane_to_plane(void **state)
{
    (void)state;
    for (int kind = SENSOR_PERSPECTIVE; kind <= SENSOR_ORTHOGRAPHIC; kind++) {
        struct sensor s = make_sensor((enum sensor_kind)kind);
        struct camera c = make_camera(&s);
        struct rng rng = rng_keyed(1, (uint64_t)kind, 0);
        for (int i = 0; i < 200; i++) {
            float x = WIDTH * rng_float(&rng), y = HEIGHT * rng_float(&rng), offset;
            float u = rng_float(&rng), v = rng_float(&rng);
            struct ray r = camera_ray_any(&c, x, y, u, v, &offset);
            assert_float_equal(vec3_length(r.d), 1, 1e-5);
            assert_float_equal(in_camera(&s, &r, 0).z, 0.5, 1e-5);
            assert_float_equal(in_camera(&s, &r, r.t_max).z, 20, 1e-3);
            assert_float_equal(in_camera(&s, &r, -offset).z, 0, 1e-5);
        }
    }
}

static void corners_are_where_they_should(void **state)
{
    (void)state;
    float offset, tx = tanf(25 * 3.14159265f / 180);
    struct sensor s = make_sensor(SENSOR_PERSPECTIVE);
    struct camera c = make_camera(&s);
    struct ray r = camera_ray_any(&c, 0, HEIGHT, 0, 0, &offset); /* bottom left: +x, -y */
    struct vec3 p = in_camera(&s, &r, 0);
    assert_near(vec3_scale(p, 1 / p.z), vec3(tx, -tx * HEIGHT / WIDTH, 1));
    s = make_sensor(SENSOR_ORTHOGRAPHIC);
    c = make_camera(&s);
    r = camera_ray_any(&c, 0, HEIGHT, 0, 0, &offset);
    assert_near(in_camera(&s, &r, 0), vec3(1.5f, -3.0f * HEIGHT / WIDTH, 0.5f));
    assert_near(in_camera(&s, &r, 1), vec3(1.5f, -3.0f * HEIGHT / WIDTH, 1.5f));

    /* Mirrored: left and right change places. */
    struct transform mirror = transform_scale(vec3(-1, 1, 1));
    s = make_sensor(SENSOR_PERSPECTIVE);
    s.to_world = transform_mul(&s.to_world, &mirror);
    struct camera mirrored = make_camera(&s);
    s = make_sensor(SENSOR_PERSPECTIVE);
    c = make_camera(&s);
    assert_near(camera_ray_any(&mirrored, 7, 5, 0, 0, &offset).d,
                camera_ray_any(&c, WIDTH - 7, 5, 0, 0, &offset).d);
}

/* Whatever part of the lens they come from, rays of a point of the film meet in the focal plane,
 * where the pinhole's ray is, and the lens is a disk of even weight. */
static void lenses_focus(void **state)
{
    (void)state;
    enum { N = 4000 };
    struct sensor s = make_sensor(SENSOR_THINLENS);
    struct camera lens = make_camera(&s);
    s.aperture_radius = 0;
    struct camera pinhole = make_camera(&s);
    float offset;
    struct ray r = camera_ray(&pinhole, 13, 31, &offset);
    struct vec3 sharp = in_camera(&s, &r, (4 - 0.5f) / vec3_dot(r.d, pinhole.ahead));
    assert_float_equal(sharp.z, 4, 1e-5);
    struct rng rng = rng_keyed(2, 0, 0);
    double squares = 0, x = 0, y = 0;
    for (int i = 0; i < N; i++) {
        float u = rng_float(&rng), v = rng_float(&rng);
        r = camera_ray_any(&lens, 13, 31, u, v, &offset);
        float speed = vec3_dot(r.d, lens.ahead);
        assert_near(in_camera(&s, &r, (4 - 0.5f) / speed), sharp);
        struct vec3 p = in_camera(&s, &r, -offset);
        double radius2 = (double)p.x * p.x + (double)p.y * p.y;
        assert_true(radius2 <= 0.04 * (1 + 1e-4));
        squares += radius2 / N;
        x += p.x / N;
        y += p.y / N;
    }
    assert_float_equal(squares, 0.02, 0.001); /* R^2 / 2; standard error .0002 */
    assert_float_equal(x, 0, 0.008);          /* R / 2 sqrt N = .0016 */
    assert_float_equal(y, 0, 0.008);
    /* Without a lens it is a pinhole. */
    struct ray a = camera_ray_any(&pinhole, 3, 4, 0.1f, 0.9f, &offset);
    struct ray b = camera_ray(&pinhole, 3, 4, &offset);
    assert_near(a.o, b.o);
    assert_near(a.d, b.d);
}

/* A crop shows the rays of its part of the film; a shift of the principal point those beside. */
static void crops_and_shifts(void **state)
{
    (void)state;
    for (int kind = SENSOR_PERSPECTIVE; kind <= SENSOR_ORTHOGRAPHIC; kind++) {
        struct sensor s = make_sensor((enum sensor_kind)kind);
        struct camera whole = make_camera(&s), part, shifted;
        float offset;
        s.crop.left = 12.0f / WIDTH;
        s.crop.right = 8.0f / WIDTH;
        s.crop.top = 10.0f / HEIGHT;
        s.crop.bottom = 5.0f / HEIGHT;
        camera_init(&part, &s, WIDTH - 20, HEIGHT - 15);
        struct ray a = camera_ray_any(&whole, 12 + 7, 10 + 9, 0.2f, 0.6f, &offset);
        struct ray b = camera_ray_any(&part, 7, 9, 0.2f, 0.6f, &offset);
        assert_near(a.o, b.o);
        assert_near(a.d, b.d);
        camera_init(&part, &s, 3 * (WIDTH - 20), 3 * (HEIGHT - 15)); /* the same, larger */
        b = camera_ray_any(&part, 3 * 7, 3 * 9, 0.2f, 0.6f, &offset);
        assert_near(a.d, b.d);
        s = make_sensor((enum sensor_kind)kind);
        s.shift_x = 6.0f / WIDTH;
        s.shift_y = -4.0f / HEIGHT;
        shifted = make_camera(&s);
        a = camera_ray_any(&whole, 20, 20, 0.2f, 0.6f, &offset);
        b = camera_ray_any(&shifted, 14, 24, 0.2f, 0.6f, &offset);
        assert_near(a.o, b.o);
        assert_near(a.d, b.d);
    }
}

/* What a ray through the middle of the lens meets is projected to where the ray came from. */
static void points_are_projected_back(void **state)
{
    (void)state;
    for (int kind = SENSOR_PERSPECTIVE; kind <= SENSOR_ORTHOGRAPHIC; kind++) {
        struct sensor s = make_sensor((enum sensor_kind)kind);
        s.shift_x = 0.1f;
        s.crop.left = 0.2f;
        const struct camera c = make_camera(&s);
        struct rng rng = rng_keyed(3, (uint64_t)kind, 0);
        for (int i = 0; i < 200; i++) {
            const float x = WIDTH * rng_float(&rng), y = HEIGHT * rng_float(&rng);
            float offset, to_x, to_y;
            const struct ray r = camera_ray_any(&c, x, y, 0.5f, 0.5f, &offset);
            const struct vec3 p = vec3_madd(r.o, r.d, 15 * rng_float(&rng));
            assert_true(camera_project(&c, p, &to_x, &to_y));
            assert_float_equal(to_x, x, 1e-3);
            assert_float_equal(to_y, y, 1e-3);
            assert_false(camera_project(&c, vec3_madd(c.origin, r.d, -1), &to_x, &to_y));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_run_from_plane_to_plane),
        cmocka_unit_test(corners_are_where_they_should),
        cmocka_unit_test(lenses_focus),
        cmocka_unit_test(crops_and_shifts),
        cmocka_unit_test(points_are_projected_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
