/* SPDX-License-Identifier: Apache-2.0 */
/* Lists of pixels: the bytes of the picture, in the order of the list. */
#include <string.h>

#include "base/mem.h"
#include "base/rng.h"
#include "made_scene.h"
#include "picture.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

enum { WIDTH = 83, HEIGHT = 61, MAX_GROUPS = 16, PARTS = 5 };

/* All that can be asked for, of n pixels. */
struct result {
    struct trace_output out;
    size_t n;
};

static float *new_floats(size_t n, size_t channels)
{
    float *a = mem_new(n, channels * sizeof *a);
    assert_non_null(a);
    return a;
}

static void result_release(struct result *r)
{
    mem_free(r->out.color);
    mem_free(r->out.half_a);
    mem_free(r->out.half_b);
    mem_free(r->out.buffers);
    mem_free(r->out.chain);
    mem_free(r->out.groups);
}

static struct result result_new(size_t n, const uint32_t *group_of, uint32_t n_groups)
{
    struct result r = {.n = n};
    r.out.color = new_floats(n, 3);
    r.out.half_a = new_floats(n, 3);
    r.out.half_b = new_floats(n, 3);
    r.out.buffers = new_floats(n, BUFFER_CHANNELS);
    r.out.chain = new_floats(n, CHAIN_CHANNELS);
    if (!group_of) return r;
    r.out.groups = new_floats(n, 3 * (size_t)n_groups);
    r.out.group_of = group_of;
    r.out.n_groups = n_groups;
    return r;
}

static void check_part(const char *what, const float *of_list, const float *of_picture,
                       const struct pixel_at *pixels, size_t n, size_t n_channels)
{
    for (size_t i = 0; i < n; i++) {
        const size_t place = (size_t)pixels[i].y * WIDTH + pixels[i].x;
        if (memcmp(of_list + i * n_channels, of_picture + place * n_channels,
                   n_channels * sizeof *of_list) != 0)
            fail_msg("%s of pixel %zu (%u, %u) is another", what, i, pixels[i].x, pixels[i].y);
    }
}

static void check(const struct result *list, const struct result *picture,
                  const struct pixel_at *pixels)
{
    const struct trace_output *a = &list->out, *b = &picture->out;
    check_part("color", a->color, b->color, pixels, list->n, 3);
    check_part("half_a", a->half_a, b->half_a, pixels, list->n, 3);
    check_part("half_b", a->half_b, b->half_b, pixels, list->n, 3);
    check_part("buffers", a->buffers, b->buffers, pixels, list->n, BUFFER_CHANNELS);
    check_part("chain", a->chain, b->chain, pixels, list->n, CHAIN_CHANNELS);
    for (uint32_t g = 0; a->groups && g < a->n_groups; g++)
        check_part("a group", a->groups + g * 3 * list->n, b->groups + g * 3 * picture->n, pixels,
                   list->n, 3);
}

/* Pixels out of order: the corners, then random ones, of which every seventh comes again at once
 * and every fifth after others. */
static void scatter(struct pixel_at *pixels, uint32_t n, uint64_t seed)
{
    static const struct pixel_at corners[4] = {
        {WIDTH - 1, HEIGHT - 1}, {0, 0}, {WIDTH - 1, 0}, {0, HEIGHT - 1}};
    struct rng r = rng_keyed(seed, 0, 0);
    for (uint32_t i = 0; i < n; i++) {
        pixels[i].x = rng_below(&r, WIDTH);
        pixels[i].y = rng_below(&r, HEIGHT);
        if (i < 4) pixels[i] = corners[i];
        if (i > 0 && i % 7 == 0) pixels[i] = pixels[i - 1];
        if (i > 3 && i % 5 == 0) pixels[i] = pixels[i - 3];
    }
}

/* Of a picture with buffers, chains and perhaps groups; lists of several lengths. */
static void compare(const struct view *v, const struct trace_settings *t, const uint32_t *group_of,
                    uint32_t n_groups)
{
    static const uint32_t lengths[] = {1, 16, 97, 1500};
    const struct window whole = picture_whole(WIDTH, HEIGHT);
    struct trace_settings plain = *t;
    struct result picture = result_new((size_t)WIDTH * HEIGHT, group_of, n_groups);
    plain.splats = false;
    view_trace(v, &plain, &whole, &picture.out);
    assert_true(picture_mean(picture.out.color, 3 * picture.n) > 0.01);
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        struct pixel_at pixels[1500];
        struct result list = result_new(lengths[i], group_of, n_groups);
        scatter(pixels, lengths[i], i);
        view_trace_pixels(v, t, WIDTH, HEIGHT, pixels, lengths[i], &list.out);
        check(&list, &picture, pixels);
        result_release(&list);
    }
    result_release(&picture);
}

/* Of few samples and of more, which put buffers in packets of their own or not, and of more than a
 * stream holds; with a filter wider than a pixel, roulette, and splats, which are left out. */
static void lists_are_of_the_picture(void **state)
{
    (void)state;
    static const uint32_t spp[] = {2, 4, 8, 22, 2, 134};
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    for (uint32_t i = 0; i < 6; i++) {
        struct trace_settings t = made_settings(m, 6, spp[i]);
        t.rr_depth = 2;
        t.sampler = i & 1 ? SAMPLER_SOBOL : SAMPLER_INDEPENDENT;
        t.filter = FILTER_GAUSSIAN;
        t.filter_radius = 2;
        t.splats = true;
        t.first_sample = i == 4 ? 6 : 0;
        t.follows_delta = i % 3 != 0;
        compare(v, &t, NULL, 0);
        t.shares_rays = true;
        if (i < 2) compare(v, &t, NULL, 0);
    }
    made_scene_free(m);
}

/* Buffers from the rays of light are the others but for rounding, which at outlines is another
 * object; the light does not change. */
static void shared_rays_see_the_same(void **state)
{
    (void)state;
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    const struct window whole = picture_whole(WIDTH, HEIGHT);
    for (uint32_t spp = 2; spp <= 6; spp += 2) {
        struct trace_settings t = made_settings(m, 4, spp);
        t.sampler = spp == 4 ? SAMPLER_SOBOL : SAMPLER_INDEPENDENT;
        t.follows_delta = spp == 6;
        struct picture own = picture_trace(view_trace, v, &t, &whole);
        t.shares_rays = true;
        struct picture shared = picture_trace(view_trace, v, &t, &whole);
        assert_memory_equal(own.color, shared.color, own.n_pixels * 3 * sizeof(float));
        assert_memory_equal(own.half_a, shared.half_a, own.n_pixels * 3 * sizeof(float));
        const double off = picture_different(own.buffers, shared.buffers, own.n_pixels,
                                             BUFFER_CHANNELS, 1e-4);
        if (off > 0.005) fail_msg("%u samples: %.2f %% of pixels differ", spp, 100 * off);
        picture_release(&own);
        picture_release(&shared);
    }
    made_scene_free(m);
}

static void groups_are_of_the_picture(void **state)
{
    (void)state;
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    uint32_t group_of[MAX_GROUPS];
    assert_in_range(m->scene.n_emitters, 3, MAX_GROUPS);
    for (uint32_t k = 0; k < m->scene.n_emitters; k++) group_of[k] = k % 3;
    for (uint32_t i = 0; i < 2; i++) {
        struct trace_settings t = made_settings(m, 4, i ? 4 : 18);
        t.sampler = i & 1 ? SAMPLER_SOBOL : SAMPLER_INDEPENDENT;
        compare(v, &t, group_of, 3);
    }
    made_scene_free(m);
}

/* So few triangles that no tree is used, through a lens. */
static void small_scenes_too(void **state)
{
    (void)state;
    struct made_scene *m = made_scene_new();
    uint32_t grey = made_diffuse(m, vec3(0.2f, 0.5f, 0.7f));
    uint32_t lamp = made_emitter(m, EMITTER_AREA, vec3(9, 8, 7));
    made_quad(m, vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4), grey, SCENE_NONE);
    made_quad(m, vec3(-1, 0, -1), vec3(2, 0, 0), vec3(0, 2, 0), grey, SCENE_NONE);
    made_quad(m, vec3(-0.5f, 2, -0.5f), vec3(1, 0, 0), vec3(0, 0, 1), grey, lamp);
    made_camera(m, vec3(0, 1, 5), vec3(0, 1, 0), 50, WIDTH, HEIGHT);
    m->scene.defaults.sensor.kind = SENSOR_THINLENS;
    m->scene.defaults.sensor.aperture_radius = 0.1f;
    m->scene.defaults.sensor.focus_distance = 5;
    struct view *v = made_view(m);
    for (uint32_t i = 0; i < 2; i++) {
        struct trace_settings t = made_settings(m, 6, i ? 4 : 18);
        t.sampler = i & 1 ? SAMPLER_SOBOL : SAMPLER_INDEPENDENT;
        compare(v, &t, NULL, 0);
    }
    made_scene_free(m);
}

/* What is not asked for changes nothing, and an empty list is fine. */
static void parts_alone(void **state)
{
    (void)state;
    enum { N = 200 };
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    struct pixel_at pixels[N];
    scatter(pixels, N, 9);
    for (uint32_t spp = 4; spp <= 12; spp += 8) {
        struct trace_settings t = made_settings(m, 5, spp);
        t.follows_delta = true;
        struct result all = result_new(N, NULL, 0), alone = result_new(N, NULL, 0);
        const struct trace_output *a = &alone.out;
        struct trace_output each[PARTS] = {{.color = a->color},
                                           {.half_a = a->half_a},
                                           {.half_b = a->half_b},
                                           {.buffers = a->buffers},
                                           {.buffers = a->buffers, .chain = a->chain}};
        view_trace_pixels(v, &t, WIDTH, HEIGHT, pixels, N, &all.out);
        view_trace_pixels(v, &t, WIDTH, HEIGHT, pixels, 0, &all.out);
        for (int k = 0; k < PARTS; k++)
            view_trace_pixels(v, &t, WIDTH, HEIGHT, pixels, N, &each[k]);
        assert_memory_equal(a->color, all.out.color, N * 3 * sizeof(float));
        assert_memory_equal(a->half_a, all.out.half_a, N * 3 * sizeof(float));
        assert_memory_equal(a->half_b, all.out.half_b, N * 3 * sizeof(float));
        assert_memory_equal(a->buffers, all.out.buffers, N * BUFFER_CHANNELS * sizeof(float));
        assert_memory_equal(a->chain, all.out.chain, N * CHAIN_CHANNELS * sizeof(float));
        result_release(&all);
        result_release(&alone);
    }
    made_scene_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lists_are_of_the_picture),
        cmocka_unit_test(shared_rays_see_the_same),
        cmocka_unit_test(groups_are_of_the_picture),
        cmocka_unit_test(small_scenes_too),
        cmocka_unit_test(parts_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
