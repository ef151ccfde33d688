/* SPDX-License-Identifier: Apache-2.0 */
/* Changing a view's configuration: what moves, what is seen, and what it costs. */
#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "base/mem.h"
#include "made_scene.h"
#include "picture.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

enum { SIDE = 64 };

/* ---- Motion ---------------------------------------------------------------------------------- */

static const struct vec3 axis = {0.2f, 1, 0.1f}, pivot = {0.3f, 0, 0.2f}, way = {0.6f, 0.3f, -0.4f};
static const float angle = 110;

/* The same motion by a part x of its length. */
static struct transform motion(float x)
{
    struct transform there = transform_translate(pivot), turn = transform_rotate(axis, x * angle);
    struct transform back = transform_translate(vec3_neg(pivot));
    struct transform move = transform_translate(vec3_scale(way, x));
    turn = transform_mul(&turn, &back);
    turn = transform_mul(&there, &turn);
    return transform_mul(&move, &turn);
}

static struct vec3 vertex(const struct transform *t, float x, float y, float z)
{
    return transform_point(t, vec3(x, y, z));
}

/* A floor, and a ball, a card and two lamps that move: by `x` baked into their shapes, and through
 * the instance by the variable when it `has_variable`. */
static struct made_scene *moving(float x, bool has_variable)
{
    struct made_scene *m = made_scene_new();
    struct transform t = motion(x), place, at, identity = transform_identity();
    uint32_t grey = made_diffuse(m, vec3(0.5f, 0.4f, 0.3f));
    uint32_t light = made_emitter(m, EMITTER_AREA, vec3(4, 5, 6));
    made_emitter(m, EMITTER_CONSTANT, vec3_splat(0.05f));
    made_quad(m, vec3(-3, -0.5f, 3), vec3(6, 0, 0), vec3(0, 0, -6), grey, SCENE_NONE);
    made_group(m);
    uint32_t instance = made_instance(m, 1, &identity);
    if (has_variable) made_motion(m, instance, made_variable(m, 0), axis, pivot, angle, way);
    uint32_t plastic = made_bsdf(m, BSDF_PLASTIC);
    m->bsdfs[plastic].reflectance = made_texture(m, vec3(0.2f, 0.5f, 0.3f));
    made_sphere(m, vertex(&t, 0.5f, 0.1f, 0), 0.5f, plastic, SCENE_NONE);
    struct vec3 p = vertex(&t, -1, 0, -0.4f);
    made_quad(m, p, transform_vector(&t, vec3(0.9f, 0, 0)), transform_vector(&t, vec3(0, 1, 0.2f)),
              made_twosided(m, grey), SCENE_NONE);
    made_sphere(m, vertex(&t, 0.2f, 1.4f, 0.3f), 0.2f, grey, light);
    at = transform_translate(vec3(-0.6f, 1.2f, 0.6f));
    place = transform_rotate(vec3(1, 0, 0.1f), 100);
    place = transform_mul(&at, &place);
    place = transform_mul(&t, &place);
    made_disk(m, &place, grey, light);
    made_camera(m, vec3(0, 1.2f, 5), vec3(0, 0.4f, 0), 45, SIDE, SIDE);
    made_view(m);
    return m;
}

static struct picture shot(const struct made_scene *m)
{
    struct trace_settings t = made_settings(m, 4, 8);
    struct window w = picture_whole(SIDE, SIDE);
    return picture_trace(view_trace, m->view, &t, &w);
}

/* Edges fall a rounding error apart, and what a path does behind one is another matter: so not all
 * pixels. Emitted light is compared too: the lamps move along. */
static void motion_is_as_baked(void **state)
{
    (void)state;
    const float places[] = {0, 0.37f, 1};
    struct made_scene *m = moving(0, true);
    for (int i = 0; i < 3; i++) {
        view_set(m->view, &places[i]);
        struct made_scene *baked = moving(places[i], false);
        struct picture a = shot(m), b = shot(baked);
        double colors = picture_different(a.color, b.color, a.n_pixels, 3, 1e-3);
        double buffers = picture_different(a.buffers, b.buffers, a.n_pixels, BUFFER_CHANNELS, 1e-3);
        double mean_a = picture_mean(a.color, 3 * a.n_pixels);
        double mean_b = picture_mean(b.color, 3 * b.n_pixels);
        if (colors > 0.01 || buffers > 0.01 || fabs(mean_a - mean_b) > 1e-3 * mean_b)
            fail_msg("at %g: %.2f %% of colours and %.2f %% of buffers differ; means %g, %g",
                     (double)places[i], 100 * colors, 100 * buffers, mean_a, mean_b);
        picture_release(&a);
        picture_release(&b);
        made_scene_free(baked);
    }
    made_scene_free(m);
}

static void moving_back_leaves_no_trace(void **state)
{
    (void)state;
    struct made_scene *m = moving(0, true);
    struct picture fresh = shot(m);
    const float places[] = {0.37f, 1, 0.6f, 0.37f, 0, 0};
    struct picture first = {0};
    for (int i = 0; i < 6; i++) {
        view_set(m->view, &places[i]);
        struct picture p = shot(m);
        if (i == 0) {
            first = p;
            assert_false(picture_is_crop(&first, &fresh, 0, 0));
            continue;
        }
        assert_true(picture_is_crop(&p, &first, 0, 0) == (places[i] == places[0]));
        assert_true(picture_is_crop(&p, &fresh, 0, 0) == (places[i] == 0.0f));
        picture_release(&p);
    }
    picture_release(&first);
    picture_release(&fresh);
    made_scene_free(m);
}

/* ---- What is seen ---------------------------------------------------------------------------- */

/* A lamp with a ball, and another one elsewhere: the first is seen at choice 0, the other at choice
 * 1, none at choice 2. `fixed`: as at this choice, without a variable. */
static struct made_scene *toggled(int fixed)
{
    struct made_scene *m = made_scene_new();
    struct transform move = transform_translate(vec3(0.7f, 0.2f, 0)), identity;
    uint32_t grey = made_diffuse(m, vec3_splat(0.5f));
    uint32_t light = made_emitter(m, EMITTER_AREA, vec3(4, 5, 6));
    identity = transform_identity();
    made_quad(m, vec3(-3, -0.5f, 3), vec3(6, 0, 0), vec3(0, 0, -6), grey, SCENE_NONE);
    made_group(m);
    made_sphere(m, vec3(0, 0, 0), 0.4f, grey, SCENE_NONE);
    made_sphere(m, vec3(0, 1.2f, 0), 0.3f, grey, light);
    made_instance(m, 1, &identity);
    made_instance(m, 1, &move);
    uint32_t variable = fixed < 0 ? made_variable(m, 3) : SCENE_NONE;
    for (uint32_t i = 0; i < 2; i++) {
        if (fixed < 0)
            made_visible(m, 1 + i, variable, i);
        else
            m->instances[1 + i].is_visible = fixed == (int)i;
    }
    made_camera(m, vec3(0, 1.2f, 5), vec3(0, 0.4f, 0), 45, SIDE, SIDE);
    made_view(m);
    return m;
}

static void choices_show_and_hide(void **state)
{
    (void)state;
    const float choices[] = {0.5f, 0.9f, 0.1f, 0.5f};
    struct made_scene *m = toggled(-1);
    for (int i = 0; i < 4; i++) {
        int choice = (int)(3 * choices[i]);
        view_set(m->view, &choices[i]);
        struct made_scene *fixed = toggled(choice);
        struct picture a = shot(m), b = shot(fixed);
        if (!picture_is_crop(&a, &b, 0, 0)) fail_msg("choice %d: another picture", choice);
        double mean = picture_mean(a.color, 3 * a.n_pixels);
        assert_true(choice == 2 ? mean == 0 : mean > 0.05);
        picture_release(&a);
        picture_release(&b);
        made_scene_free(fixed);
    }
    made_scene_free(m);
}

/* ---- What it costs --------------------------------------------------------------------------- */

static void setting_allocates_nothing(void **state)
{
    (void)state;
    struct made_scene *m = moving(0, true), *other = moving(0, true);
    const float places[] = {0.2f, 0.9f, 0.5f};
    mem_fail_after(1);
    for (int i = 0; i < 3; i++) view_set(m->view, &places[i]);
    mem_fail_after(0);
    view_set(other->view, &places[2]);
    struct picture a = shot(m), b = shot(other);
    assert_true(picture_is_crop(&a, &b, 0, 0));
    picture_release(&a);
    picture_release(&b);
    made_scene_free(m);
    made_scene_free(other);
}

/* A wavy sheet of about 400,000 triangles in front of a floor. */
static struct made_scene *heavy(void)
{
    enum { N = 448 };
    struct made_scene *m = made_scene_new();
    struct transform identity = transform_identity();
    uint32_t grey = made_diffuse(m, vec3_splat(0.5f));
    made_emitter(m, EMITTER_CONSTANT, vec3_splat(1));
    made_quad(m, vec3(-3, -1, 3), vec3(6, 0, 0), vec3(0, 0, -6), grey, SCENE_NONE);
    made_group(m);
    made_motion(m, made_instance(m, 1, &identity), made_variable(m, 0), axis, pivot, angle, way);
    float *positions = mem_new((size_t)N * N * 3, sizeof(float));
    uint32_t *indices = mem_new((size_t)(N - 1) * (N - 1) * 6, sizeof(uint32_t)), n = 0;
    assert_true(positions && indices);
    for (uint32_t i = 0; i < N * N; i++) {
        float x = (float)(i % N) / (N - 1) - 0.5f, y = (float)(i / N) / (N - 1) - 0.5f;
        positions[3 * i + 0] = x;
        positions[3 * i + 1] = y;
        positions[3 * i + 2] = 0.05f * sinf(40 * x) * cosf(50 * y);
        if (i % N == N - 1 || i / N == N - 1) continue;
        const uint32_t corners[6] = {i, i + 1, i + N, i + 1, i + N + 1, i + N};
        memcpy(indices + n, corners, sizeof corners);
        n += 6;
    }
    made_mesh(m, N * N, positions, n / 3, indices, made_twosided(m, grey), SCENE_NONE);
    mem_free(positions);
    mem_free(indices);
    made_camera(m, vec3(0, 1.2f, 5), vec3(0, 0.4f, 0), 45, SIDE, SIDE);
    made_view(m);
    return m;
}

/* Only the top level is built again: a mesh of any size moves in well under a millisecond. The
 * quickest of many tries counts, other work on the machine does not. */
static void large_meshes_move_quickly(void **state)
{
    (void)state;
    struct made_scene *m = heavy();
    double least = INFINITY;
    for (int i = 1; i <= 200; i++) {
        float u = (float)i / 200.0f;
        double start = clock_wall_s();
        view_set(m->view, &u);
        least = fmin(least, clock_wall_s() - start);
    }
    print_message("moving %u triangles takes %.1f us\n", m->meshes[1].n_triangles, 1e6 * least);
    assert_true(m->meshes[1].n_triangles > 390000);
    if (least > 1e-3) fail_msg("moving a mesh takes %g ms", 1e3 * least);
    struct picture p = shot(m);
    size_t n_seen = 0; /* it is still there, where it ought to be */
    for (size_t i = 0; i < p.n_pixels; i++)
        n_seen += p.buffers[i * BUFFER_CHANNELS + BUFFER_SHAPE_ID] == 2;
    assert_true(n_seen > 50);
    picture_release(&p);
    made_scene_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(motion_is_as_baked),        cmocka_unit_test(moving_back_leaves_no_trace),
        cmocka_unit_test(choices_show_and_hide),     cmocka_unit_test(setting_allocates_nothing),
        cmocka_unit_test(large_meshes_move_quickly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
