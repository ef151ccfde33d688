/* SPDX-License-Identifier: Apache-2.0 */
/* Photons: a mirrored light against the formula, caustics that path tracing finds as well against
 * path tracing, streams against the plain loop, threads and windows. */
#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "base/pool.h"
#include "base/rng.h"
#include "made_scene.h"
#include "math/warp.h"
#include "picture.h"
#include "render/photon.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

static struct picture with_photons(const struct view *v, const struct trace_settings *t,
                                   const struct window *w, uint32_t n_threads)
{
    struct picture p = picture_new(w);
    struct trace_output out = picture_output(&p);
    struct error err = {""};
    struct pool *pool = pool_new(n_threads);
    if (view_trace_photons(v, pool, t, w, &out, NULL, NULL, &err)) fail_msg("%s", err.text);
    pool_free(pool);
    return p;
}

/* A point light beside a mirror: the floor has its light and that of its image behind the mirror,
 * which path tracing cannot find. */
static void mirrored_light(void **state)
{
    (void)state;
    struct made_scene *m = made_scene_new();
    uint32_t grey = made_diffuse(m, vec3_splat(0.5f)), mirror = made_bsdf(m, BSDF_CONDUCTOR);
    made_quad(m, vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -18), grey, SCENE_NONE);
    made_quad(m, vec3(0, 0, 3), vec3(0, 0, -6), vec3(0, 4, 0), mirror, SCENE_NONE);
    made_point(m, vec3(1, 1, 0), vec3_splat(10.0f));
    made_camera(m, vec3(1, 3, 0.5f), vec3(1, 0, 0), 3.0f, 8, 8);
    struct view *v = made_view(m);
    struct trace_settings t = made_settings(m, 4, 512);
    struct window w = picture_whole(8, 8);
    struct picture p = with_photons(v, &t, &w, 1);
    double direct = 10.0, image = 10.0 / (5.0 * sqrt(5.0));
    double expected = 0.5 / (double)MATH_PI * (direct + image);
    double found = picture_mean(p.color, 3 * p.n_pixels);
    if (fabs(found / expected - 1.0) > 0.01) fail_msg("%g instead of %g", found, expected);
    picture_release(&p);
    made_scene_free(m);
}

/* Irradiance of a floor by the map, summed over it, and the largest. */
static double sum_over_floor(const struct photon_map *m, double *most)
{
    enum { SIDE = 400 };
    double sum = 0;
    *most = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const struct vec3 up = {0, 0, 1};
        const float x = 2.0f * ((float)(i % SIDE) + 0.5f) / SIDE - 1.0f;
        const float y = 2.0f * ((float)i / SIDE) / SIDE - 1.0f;
        const struct photon_receiver at = {.p = {x, y, 0},
                                           .n = up,
                                           .frame = frame_from_normal(up),
                                           .wi = up,
                                           .reflectance = vec3_splat(MATH_PI),
                                           .side = 1.0f};
        const double light = (double)photon_map_gather(m, &at, -1, NULL).x;
        sum += light * 4 / (SIDE * SIDE);
        *most = fmax(*most, light);
    }
    return sum;
}

/* Photons that spread less bring the same light, those in a crowd to a smaller place. */
static void sharper(void **state)
{
    (void)state;
    enum { CROWD = 60, ALONE = 20 };
    struct photon_map *m;
    struct error err = {""};
    double most, sharp_most;
    if (photon_map_new(CROWD + ALONE, &m, &err)) fail_msg("%s", err.text);
    for (uint32_t i = 0; i < CROWD + ALONE; i++) {
        struct rng r = rng_keyed(1, i, 0);
        const float reach = i < CROWD ? 0.05f : 0.8f;
        const float x = reach * (2.0f * rng_float(&r) - 1.0f);
        m->landed[i] = (struct photon){.p = {x, reach * (2.0f * rng_float(&r) - 1.0f), 0},
                                       .n = {0, 0, 1},
                                       .wo = {0, 0, 1},
                                       .power = vec3_splat(1.0f),
                                       .n_casters = 1};
    }
    photon_map_build(m, 0.15f);
    const double wide = sum_over_floor(m, &most);
    photon_map_sharpen(m, 3.0f);
    const double sharp = sum_over_floor(m, &sharp_most);
    for (uint32_t i = 0; i < m->n; i++) {
        const bool is_alone = fabsf(m->photons[i].p.x) > 0.3f || fabsf(m->photons[i].p.y) > 0.3f;
        if (is_alone) assert_float_equal(m->photons[i].radius2, 0.15f * 0.15f, 1e-6f);
    }
    if (fabs(wide - CROWD - ALONE) > 0.5 || fabs(sharp - CROWD - ALONE) > 2)
        fail_msg("%g and %g instead of %d", wide, sharp, CROWD + ALONE);
    assert_true(sharp_most > 3 * most);
    photon_map_free(m);
}

/* A room with a ball, lit by a panel; or by the sky. */
static struct made_scene *room(uint32_t (*ball)(struct made_scene *), bool has_sky)
{
    struct made_scene *m = made_scene_new();
    uint32_t grey = made_twosided(m, made_diffuse(m, vec3(0.6f, 0.5f, 0.4f)));
    made_quad(m, vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4), grey, SCENE_NONE);
    made_quad(m, vec3(-2, 0, -2), vec3(4, 0, 0), vec3(0, 4, 0), grey, SCENE_NONE);
    made_sphere(m, vec3(0, 0.8f, 0), 0.5f, ball(m), SCENE_NONE);
    if (has_sky) {
        made_emitter(m, EMITTER_CONSTANT, vec3(0.8f, 0.9f, 1.0f));
    } else {
        uint32_t panel = made_emitter(m, EMITTER_AREA, vec3_splat(6.0f));
        made_quad(m, vec3(-1, 3, -1), vec3(2, 0, 0), vec3(0, 0, 2), grey, panel);
    }
    made_camera(m, vec3(0, 1.5f, 4), vec3(0, 0.6f, 0), 50.0f, 32, 32);
    return m;
}

static uint32_t frosted(struct made_scene *m)
{
    return made_rough(m, BSDF_ROUGH_DIELECTRIC, MICROFACET_GGX, 0.24f);
}

static uint32_t mirror_ball(struct made_scene *m)
{
    return made_bsdf(m, BSDF_CONDUCTOR);
}

static void compare_with_paths(const char *name, struct made_scene *m, int32_t max_depth)
{
    struct view *v = made_view(m);
    struct window w = picture_whole(32, 32);
    struct trace_settings t = made_settings(m, max_depth, 256);
    struct picture q = with_photons(v, &t, &w, 1);
    t.spp = 1024;
    struct picture p = picture_trace(view_trace, v, &t, &w);
    size_t n = 3 * p.n_pixels;
    double expected = picture_mean(p.color, n), found = picture_mean(q.color, n);
    /* Noise of the path tracer's mean, from its halves: 2 sigma of |a - b| / 2. */
    double noise = fabs(picture_mean(p.half_a, n) - picture_mean(p.half_b, n));
    if (fabs(found - expected) > 0.004 * expected + noise)
        fail_msg("%s, depth %d: mean %g instead of %g +- %g", name, max_depth, found, expected,
                 noise);
    picture_release(&p);
    picture_release(&q);
}

static void paths_agree(void **state)
{
    (void)state;
    static const int32_t depths[] = {3, 4, 7};
    for (size_t i = 0; i < sizeof depths / sizeof *depths; i++) {
        struct made_scene *m = room(frosted, false);
        compare_with_paths("frosted ball, panel", m, depths[i]);
        made_scene_free(m);
        m = room(mirror_ball, true);
        compare_with_paths("mirror ball, sky", m, depths[i]);
        made_scene_free(m);
    }
}

static void streams_agree(void **state)
{
    (void)state;
    struct made_scene *m = made_all_kinds(48, 32);
    struct view *v = made_view(m);
    struct trace_settings t = made_settings(m, 6, 32);
    struct error err = {""};
    struct photon_map *maps[2];
    struct pool *pool = pool_new(1);
    struct window w = picture_whole(48, 32);
    for (int k = 0; k < 2; k++) {
        if (photon_map_new(20000, &maps[k], &err)) fail_msg("%s", err.text);
        photon_map_trace(maps[k], v, pool, &t, (uint64_t)k);
        photon_map_build(maps[k], 0.2f);
        assert_true(maps[k]->n > 100);
        t.photons[k] = maps[k];
    }
    struct picture a = picture_trace(view_trace, v, &t, &w);
    struct picture b = picture_trace(view_trace_plain, v, &t, &w);
    double different = picture_different(a.color, b.color, a.n_pixels, 3, 1e-4);
    if (different > 0.01) fail_msg("%.1f %% of pixels differ", 100 * different);
    t.photons[0] = t.photons[1] = NULL;
    struct picture c = picture_trace(view_trace, v, &t, &w);
    assert_true(picture_different(a.color, c.color, a.n_pixels, 3, 1e-4) > 0.1);
    for (int k = 0; k < 2; k++) photon_map_free(maps[k]);
    pool_free(pool);
    picture_release(&a);
    picture_release(&b);
    picture_release(&c);
    made_scene_free(m);
}

/* Threads and windows change nothing; the halves are independent and make the whole. */
static void same_bytes(void **state)
{
    (void)state;
    struct made_scene *m = room(frosted, false);
    struct view *v = made_view(m);
    struct trace_settings t = made_settings(m, 5, 40);
    struct window w = picture_whole(32, 32), part = {32, 32, 5, 9, 20, 11};
    struct picture one = with_photons(v, &t, &w, 1);
    for (uint32_t n = 2; n <= 3; n++) {
        struct picture p = with_photons(v, &t, &w, n);
        if (!picture_is_crop(&p, &one, 0, 0)) fail_msg("%u threads", n);
        picture_release(&p);
    }
    struct picture crop = with_photons(v, &t, &part, 2);
    assert_true(picture_is_crop(&crop, &one, 5, 9));
    for (size_t i = 0; i < 3 * one.n_pixels; i++) {
        float mean = 0.5f * (one.half_a[i] + one.half_b[i]);
        assert_true(fabsf(mean - one.color[i]) <= 1e-5f * (1.0f + mean));
    }
    assert_true(picture_different(one.half_a, one.half_b, one.n_pixels, 3, 1e-3) > 0.5);
    picture_release(&one);
    picture_release(&crop);
    made_scene_free(m);
}

/* ---- Where they are used --------------------------------------------------------------------- */

static uint32_t thin_ball(struct made_scene *m)
{
    return made_bsdf(m, BSDF_THIN_DIELECTRIC);
}

static uint32_t glass_ball(struct made_scene *m)
{
    return made_bsdf(m, BSDF_DIELECTRIC);
}

static uint32_t grey_ball(struct made_scene *m)
{
    return made_diffuse(m, vec3_splat(0.5f));
}

enum lamp { LAMP_POINT, LAMP_SMALL, LAMP_SKY };

/* By itself: does the room want photons? */
static bool wants(uint32_t (*ball)(struct made_scene *), enum lamp lamp, int32_t max_depth)
{
    struct made_scene *m = made_scene_new();
    uint32_t grey = made_twosided(m, made_diffuse(m, vec3_splat(0.5f)));
    made_quad(m, vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4), grey, SCENE_NONE);
    made_sphere(m, vec3(0, 0.8f, 0), 0.5f, ball(m), SCENE_NONE);
    if (lamp == LAMP_POINT) made_point(m, vec3(1, 3, 0), vec3_splat(10.0f));
    if (lamp == LAMP_SKY) made_emitter(m, EMITTER_CONSTANT, vec3_splat(1.0f));
    if (lamp == LAMP_SMALL) {
        uint32_t panel = made_emitter(m, EMITTER_AREA, vec3_splat(60.0f));
        made_quad(m, vec3(1, 3, 0), vec3(0.3f, 0, 0), vec3(0, 0, 0.3f), grey, panel);
    }
    made_camera(m, vec3(0, 1.5f, 4), vec3(0, 0.6f, 0), 50.0f, 32, 32);
    struct trace_settings t = made_settings(m, max_depth, 1);
    struct error err = {""};
    struct view *v = made_view(m);
    bool first = false;
    for (uint32_t n_threads = 1; n_threads <= 2; n_threads++) {
        bool answer;
        struct pool *pool = pool_new(n_threads);
        if (view_wants_photons(v, pool, &t, &answer, &err)) fail_msg("%s", err.text);
        pool_free(pool);
        if (n_threads == 1) first = answer;
        assert_true(answer == first);
    }
    made_scene_free(m);
    return first;
}

static void where_they_help(void **state)
{
    (void)state;
    assert_true(wants(glass_ball, LAMP_POINT, 6));
    assert_true(wants(mirror_ball, LAMP_SMALL, -1));
    assert_false(wants(glass_ball, LAMP_POINT, 2)); /* no paths that long */
    assert_false(wants(mirror_ball, LAMP_SKY, 6));
    assert_false(wants(frosted, LAMP_SMALL, 6));
    assert_false(wants(thin_ball, LAMP_POINT, 6));
    assert_false(wants(grey_ball, LAMP_POINT, 6));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mirrored_light), cmocka_unit_test(sharper),
        cmocka_unit_test(paths_agree),    cmocka_unit_test(streams_agree),
        cmocka_unit_test(same_bytes),     cmocka_unit_test(where_they_help),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
