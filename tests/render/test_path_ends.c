/* SPDX-License-Identifier: Apache-2.0 */
/* Paths that are cut, and rays in place of pixels: what lies beyond the ends is what is missing. */
#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "base/rng.h"
#include "made_scene.h"
#include "picture.h"
#include "render/photon.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

enum { WIDTH = 64, HEIGHT = 48, N = 600, SPP = 32, DEPTH = 6, MOST = N * SPP };

static struct path_end ends[MOST];
static float end_buffers[MOST][BUFFER_CHANNELS];

static struct path_ends no_ends(void)
{
    return (struct path_ends){.capacity = MOST, .ends = ends, .buffers = end_buffers[0]};
}

static void scatter(struct pixel_at *pixels)
{
    struct rng r = rng_keyed(1, 0, 0);
    for (uint32_t i = 0; i < N; i++)
        pixels[i] = (struct pixel_at){rng_below(&r, WIDTH), rng_below(&r, HEIGHT)};
}

/* A closed box with a lamp. */
static struct made_scene *made_empty_box(void)
{
    struct made_scene *m = made_scene_new();
    const uint32_t white = made_diffuse(m, vec3(0.7f, 0.6f, 0.5f));
    const uint32_t lamp = made_emitter(m, EMITTER_AREA, vec3(9, 8, 7));
    const struct vec3 x = {4, 0, 0}, y = {0, 4, 0}, z = {0, 0, 4};
    made_quad(m, vec3(-2, -2, -2), x, y, white, SCENE_NONE);
    made_quad(m, vec3(-2, -2, 2), y, x, white, SCENE_NONE);
    made_quad(m, vec3(-2, -2, -2), y, z, white, SCENE_NONE);
    made_quad(m, vec3(2, -2, -2), z, y, white, SCENE_NONE);
    made_quad(m, vec3(-2, -2, -2), z, x, white, SCENE_NONE);
    made_quad(m, vec3(-2, 2, -2), x, z, white, SCENE_NONE);
    made_quad(m, vec3(-1, 1.9f, -1), vec3(2, 0, 0), vec3(0, 0, 2), white, lamp);
    made_camera(m, vec3(0, 0, 1.9f), vec3(0, -0.4f, 0), 70, WIDTH, HEIGHT);
    return m;
}

/* In it a metal that is passed on and one that is rough enough to end at. */
static struct made_scene *made_box(void)
{
    struct made_scene *m = made_empty_box();
    const uint32_t sharp = made_rough(m, BSDF_ROUGH_CONDUCTOR, MICROFACET_GGX, 0.1f);
    const uint32_t blunt = made_rough(m, BSDF_ROUGH_CONDUCTOR, MICROFACET_GGX, 0.8f);
    made_sphere(m, vec3(-0.8f, -1.2f, 0), 0.7f, sharp, SCENE_NONE);
    made_sphere(m, vec3(0.9f, -1.2f, 0), 0.7f, blunt, SCENE_NONE);
    return m;
}

/* What an end's surface scatters along its ray. */
static struct vec3 scattered(const struct view *v, const struct trace_settings *t,
                             const struct path_end *end)
{
    float color[3], buffers[BUFFER_CHANNELS];
    struct trace_settings settings = *t;
    struct trace_output out = {.color = color, .buffers = buffers};
    settings.max_depth = end->max_depth;
    view_trace_rays(v, &settings, &end->ray, 1, &out);
    return vec3_sub(vec3_load(color), vec3_load(buffers + BUFFER_EMISSION));
}

/* Caustics of the metal that is passed on. */
static struct photon_map *send_photons(const struct view *v, const struct trace_settings *t)
{
    struct photon_map *m;
    struct error err = {""};
    if (photon_map_new(20000, &m, &err)) fail_msg("%s", err.text);
    photon_map_trace(m, v, NULL, t, 0);
    photon_map_build(m, photon_map_typical_radius(m, 4.0f));
    assert_true(m->n > 1000);
    return m;
}

/* Cut paths with the light beyond their ends have the mean of whole ones; without it they are
 * darker. */
static void check_nothing_is_lost(bool has_photons)
{
    static float cut[N][3], whole[N][3];
    double beyond[N] = {0};
    struct pixel_at pixels[N];
    struct made_scene *m = made_box();
    struct view *v = made_view(m);
    struct trace_settings t = made_settings(m, DEPTH, SPP), one = made_settings(m, DEPTH, 2);
    struct path_ends list = no_ends();
    struct trace_output out = {.color = cut[0], .ends = &list};
    double sum = 0, squares = 0, dark = 0, all = 0;
    struct photon_map *photons = has_photons ? send_photons(v, &t) : NULL;
    scatter(pixels);
    t.photons[0] = t.photons[1] = photons;
    view_trace_pixels(v, &t, WIDTH, HEIGHT, pixels, N, &out);
    photon_map_free(photons);
    t.photons[0] = t.photons[1] = NULL;
    assert_true(list.n > MOST / 2 && list.n < MOST);
    for (uint32_t i = 0; i < list.n; i++) {
        const struct path_end *end = &ends[i];
        assert_true(end->pixel < N && end->sample < SPP);
        assert_true(end->max_depth >= 3 && end->max_depth < DEPTH);
        assert_true(end_buffers[i][BUFFER_ROUGHNESS] > 0.5f);
        one.seed = 1000 + i;
        const struct vec3 light = vec3_mul(end->throughput, scattered(v, &one, end));
        beyond[end->pixel] += (double)(light.x + light.y + light.z) / SPP;
    }
    t.seed = 5;
    t.spp = 256;
    out = (struct trace_output){.color = whole[0]};
    view_trace_pixels(v, &t, WIDTH, HEIGHT, pixels, N, &out);
    for (uint32_t i = 0; i < N; i++) {
        double a = 0, b = 0;
        for (int c = 0; c < 3; c++) {
            a += (double)cut[i][c];
            b += (double)whole[i][c];
        }
        const double d = a + beyond[i] - b;
        sum += d;
        squares += d * d;
        dark += a;
        all += b;
    }
    const double deviation = sqrt((squares - sum * sum / N) * N / (N - 1));
    if (!(fabs(sum) < 4 * deviation))
        fail_msg("off by %g of %g, standard deviation %g", sum, all, deviation);
    assert_true(deviation < 0.01 * all); /* so that it would be noticed */
    assert_true(dark < 0.9 * all);
    made_scene_free(m);
}

static void nothing_is_lost(void **state)
{
    (void)state;
    check_nothing_is_lost(false);
}

static void nothing_is_lost_with_photons(void **state)
{
    (void)state;
    check_nothing_is_lost(true);
}

/* What buffers say of an end is what they say of its ray. */
static void ends_are_seen(void **state)
{
    (void)state;
    static float color[N][3];
    struct pixel_at pixels[N];
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    struct trace_settings t = made_settings(m, DEPTH, 8);
    struct path_ends list = no_ends();
    struct trace_output out = {.color = color[0], .ends = &list};
    scatter(pixels);
    t.sampler = SAMPLER_SOBOL;
    view_trace_pixels(v, &t, WIDTH, HEIGHT, pixels, N, &out);
    assert_true(list.n > N);
    for (uint32_t i = 0; i < list.n; i += 7) {
        float one[3], buffers[BUFFER_CHANNELS];
        out = (struct trace_output){.color = one, .buffers = buffers};
        t.spp = 1;
        view_trace_rays(v, &t, &ends[i].ray, 1, &out);
        for (int c = 0; c < BUFFER_CHANNELS; c++) {
            const float x = end_buffers[i][c], y = buffers[c];
            if (!(fabsf(x - y) <= 1e-4f * (1.0f + fabsf(y))))
                fail_msg("end %u: %s is %g, not %g", i, buffer_channel_names[c], (double)x,
                         (double)y);
        }
    }
    made_scene_free(m);
}

/* A list that is full cuts no more paths. */
static void lists_are_bounded(void **state)
{
    (void)state;
    static float color[2][N][3];
    struct pixel_at pixels[N];
    struct made_scene *m = made_box();
    struct view *v = made_view(m);
    const struct trace_settings t = made_settings(m, DEPTH, 4);
    struct path_ends list = no_ends();
    struct trace_output out = {.color = color[0][0]};
    scatter(pixels);
    view_trace_pixels(v, &t, WIDTH, HEIGHT, pixels, N, &out);
    list.capacity = 0;
    out = (struct trace_output){.color = color[1][0], .ends = &list};
    view_trace_pixels(v, &t, WIDTH, HEIGHT, pixels, N, &out);
    assert_int_equal(list.n, 0);
    assert_memory_equal(color[0], color[1], sizeof color[0]);
    list.capacity = 10;
    view_trace_pixels(v, &t, WIDTH, HEIGHT, pixels, N, &out);
    assert_int_equal(list.n, 10);
    made_scene_free(m);
}

/* Without roulette each path in a closed box scatters as often as it may, but for the few that get
 * behind the lamp; its last ray only looks for what shines. */
static void lengths_are_counted(void **state)
{
    (void)state;
    static float color[2][N][3];
    struct pixel_at pixels[N];
    struct made_scene *m = made_empty_box();
    struct view *v = made_view(m);
    const uint64_t paths = (uint64_t)N * 4;
    scatter(pixels);
    for (int32_t depth = 1; depth <= DEPTH; depth++) {
        const struct trace_settings t = made_settings(m, depth, 4);
        struct path_lengths lengths = {0};
        struct trace_output out = {.color = color[0][0]};
        view_trace_pixels(v, &t, WIDTH, HEIGHT, pixels, N, &out);
        out = (struct trace_output){.color = color[1][0], .lengths = &lengths};
        view_trace_pixels(v, &t, WIDTH, HEIGHT, pixels, N, &out);
        assert_memory_equal(color[0], color[1], sizeof color[0]);
        const uint64_t second = depth > 2 ? paths : 0;
        const uint64_t later = depth > 3 ? paths * (uint64_t)(depth - 3) : 0;
        assert_in_range(lengths.second, second - second / 50, second);
        assert_in_range(lengths.later, later - later / 50, later);
    }
    made_scene_free(m);
}

/* Rays in place of pixels: the camera's own give the same light, up to noise, and the same
 * buffers. */
static void rays_stand_for_pixels(void **state)
{
    (void)state;
    enum { COUNT = 40 };
    float color[COUNT][3], buffers[COUNT][BUFFER_CHANNELS], again[COUNT][BUFFER_CHANNELS];
    struct pixel_at pixels[N];
    struct ray rays[COUNT];
    struct made_scene *m = made_box();
    struct view *v = made_view(m);
    struct trace_settings t = made_settings(m, DEPTH, 16);
    struct trace_output out = {.color = color[0], .buffers = buffers[0]};
    double sums[2] = {0};
    scatter(pixels);
    /* Pixels so small that all samples share a ray. */
    for (uint32_t i = 0; i < COUNT; i++) {
        pixels[i].x *= 400;
        pixels[i].y *= 400;
    }
    view_trace_pixels(v, &t, WIDTH * 400, HEIGHT * 400, pixels, COUNT, &out);
    for (uint32_t i = 0; i < COUNT; i++) {
        const struct vec3 p = vec3_load(buffers[i] + BUFFER_POSITION);
        const struct vec3 wo = vec3_normalize(vec3_load(buffers[i] + BUFFER_WO));
        const float depth = buffers[i][BUFFER_DEPTH];
        rays[i] = (struct ray){.o = vec3_madd(p, wo, depth), .d = vec3_neg(wo), .t_max = INFINITY};
        for (int c = 0; c < 3; c++) sums[0] += (double)color[i][c];
    }
    out.buffers = again[0];
    view_trace_rays(v, &t, rays, COUNT, &out);
    for (uint32_t i = 0; i < COUNT; i++) {
        for (int c = 0; c < BUFFER_SHAPE_ID; c++)
            assert_true(fabsf(again[i][c] - buffers[i][c]) < 0.02f * (1 + fabsf(buffers[i][c])));
        for (int c = 0; c < 3; c++) sums[1] += (double)color[i][c];
    }
    assert_true(fabs(sums[1] - sums[0]) < 0.15 * sums[0]);
    made_scene_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_lost),     cmocka_unit_test(nothing_is_lost_with_photons),
        cmocka_unit_test(ends_are_seen),       cmocka_unit_test(lists_are_bounded),
        cmocka_unit_test(lengths_are_counted), cmocka_unit_test(rays_stand_for_pixels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
