/* SPDX-License-Identifier: Apache-2.0 */
/* What one configuration's pictures promise: windows, threads, half-buffers, first-hit buffers. */
#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "base/pool.h"
#include "made_scene.h"
#include "picture.h"
#include "render/world.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

enum { WIDTH = 83, HEIGHT = 61 };

/* ---- The same bytes -------------------------------------------------------------------------- */

/* A filter wider than a pixel, packets that are not full, roulette. */
static struct trace_settings busy_settings(const struct made_scene *m, enum sampler_kind sampler,
                                           bool splats)
{
    struct trace_settings t = made_settings(m, 6, 6);
    t.rr_depth = 2;
    t.sampler = sampler;
    t.filter = FILTER_GAUSSIAN;
    t.filter_radius = 2;
    t.splats = splats;
    return t;
}

static void windows_are_crops(void **state)
{
    (void)state;
    static const uint32_t places[][4] = {{0, 0, 83, 61}, {5, 7, 40, 33},   {33, 1, 50, 60},
                                         {82, 60, 1, 1}, {17, 30, 13, 31}, {0, 31, 83, 2}};
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    for (int k = 0; k < 4; k++) {
        struct trace_settings t = busy_settings(m, k & 1 ? SAMPLER_SOBOL : SAMPLER_INDEPENDENT,
                                                k & 2);
        struct window all = picture_whole(WIDTH, HEIGHT);
        struct picture whole = picture_trace(view_trace, v, &t, &all);
        for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
            const uint32_t *p = places[i];
            struct window w = {WIDTH, HEIGHT, p[0], p[1], p[2], p[3]};
            struct picture part = picture_trace(view_trace, v, &t, &w);
            if (!picture_is_crop(&part, &whole, p[0], p[1]))
                fail_msg("window %u,%u %ux%u is another picture", p[0], p[1], p[2], p[3]);
            picture_release(&part);
        }
        picture_release(&whole);
    }
    made_scene_free(m);
}

static void threads(bool splats)
{
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    struct trace_settings t = busy_settings(m, SAMPLER_SOBOL, splats);
    struct window w = picture_whole(WIDTH, HEIGHT);
    struct picture alone = picture_trace(view_trace, v, &t, &w);
    for (uint32_t n = 1; n <= 3; n++) {
        struct pool *pool = pool_new(n);
        struct picture p = picture_new(&w);
        struct trace_output out = picture_output(&p);
        struct error err;
        assert_non_null(pool);
        assert_int_equal(view_trace_parallel(v, pool, &t, &w, &out, NULL, NULL, &err), LMN_OK);
        if (!picture_is_crop(&p, &alone, 0, 0)) fail_msg("%u threads: another picture", n);
        picture_release(&p);
        pool_free(pool);
    }
    picture_release(&alone);
    made_scene_free(m);
}

static void threads_change_nothing(void **state)
{
    (void)state;
    threads(false);
    threads(true);
}

/* Leaving parts out changes nothing in the others, and seeds do. With few samples buffers have
 * packets of their own, with more those of the paths. */
static void parts(bool splats, uint32_t spp)
{
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    struct trace_settings t = busy_settings(m, SAMPLER_INDEPENDENT, splats);
    t.spp = spp;
    struct window w = picture_whole(WIDTH, HEIGHT);
    struct picture all = picture_trace(view_trace, v, &t, &w), p = picture_new(&w);
    struct trace_output color = {.color = p.color}, half = {.half_a = p.half_a},
                        other = {.half_b = p.half_b}, buffers = {.buffers = p.buffers};
    view_trace(v, &t, &w, &color);
    view_trace(v, &t, &w, &buffers);
    t.spp--; /* odd: rounded up where halves are wanted */
    view_trace(v, &t, &w, &half);
    view_trace(v, &t, &w, &other);
    assert_true(picture_is_crop(&p, &all, 0, 0));
    t.spp++;
    t.seed++;
    view_trace(v, &t, &w, &color);
    assert_true(picture_different(p.color, all.color, p.n_pixels, 3, 1e-4) > 0.5);
    picture_release(&all);
    picture_release(&p);
    made_scene_free(m);
}

static void parts_alone(void **state)
{
    (void)state;
    parts(false, 6);
    parts(true, 6);
    parts(false, 22);
}

/* ---- Half-buffers ---------------------------------------------------------------------------- */

static void halves_make_the_whole(void **state)
{
    (void)state;
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    struct trace_settings t = busy_settings(m, SAMPLER_SOBOL, false);
    struct window w = picture_whole(WIDTH, HEIGHT);
    struct picture p = picture_trace(view_trace, v, &t, &w);
    for (size_t i = 0; i < 3 * p.n_pixels; i++) {
        double both = 0.5 * ((double)p.half_a[i] + p.half_b[i]);
        if (fabs(both - p.color[i]) > 1e-6 * both) fail_msg("%g instead of %g", both, p.color[i]);
    }
    picture_release(&p);
    made_scene_free(m);
}

/* Through a camera with hardly any field of view all pixels expect the same light, so that their
 * errors can be told: those of the halves must not go together, and neither is the brighter one.
 * Both sums must be within 4 of their standard errors. */
static void halves_are_independent(void **state)
{
    (void)state;
    enum { SIDE = 64 };
    struct made_scene *m = made_all_kinds(SIDE, SIDE);
    m->scene.defaults.sensor.fov = 1e-3f;
    struct view *v = made_view(m);
    struct window w = picture_whole(SIDE, SIDE);
    for (int k = 0; k < 2; k++) {
        struct trace_settings t = made_settings(m, 4, 16);
        t.sampler = k ? SAMPLER_SOBOL : SAMPLER_INDEPENDENT;
        struct picture p = picture_trace(view_trace, v, &t, &w);
        double mean = picture_mean(p.color, 3 * p.n_pixels);
        double difference = 0, differences = 0, product = 0, products = 0, squares = 0;
        for (size_t i = 0; i < p.n_pixels; i++) {
            double a = -mean, b = -mean;
            for (size_t c = 3 * i; c < 3 * i + 3; c++) {
                a += p.half_a[c] / 3.0;
                b += p.half_b[c] / 3.0;
            }
            difference += a - b;
            differences += (a - b) * (a - b);
            product += a * b;
            products += a * a * b * b;
            squares += a * a;
        }
        double noise = sqrt(squares / (double)p.n_pixels) / mean;
        if (noise < 0.02) fail_msg("noise of %g is too little to see anything", noise);
        if (fabs(difference) > 4 * sqrt(differences) || fabs(product) > 4 * sqrt(products))
            fail_msg("sampler %d: %g standard errors apart, correlated by %g", k,
                     difference / sqrt(differences), product / squares);
        picture_release(&p);
    }
    made_scene_free(m);
}

/* ---- First-hit buffers ----------------------------------------------------------------------- */

/* What a pixel must show, in scalars: a ball on a floor under a lamp, before a sky. */
static const double ball_center[3] = {0.2, 0.8, -0.3}, ball_radius = 0.8;
static const double lamp_center[3] = {-1.1, 2, -0.5}, lamp_radius = 0.6;
enum { BALL_ID = 1, FLOOR_ID = 2, LAMP_ID = 3 };

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalize(double a[3])
{
    double length = sqrt(dot(a, a));
    for (int i = 0; i < 3; i++) a[i] /= length;
}

/* The paper's encoding of d: x and y moved to [0,1] in a frame around n whose tangent is what is
 * left of (1,1,1) beside n, and |z|. */
static void encode(const double n[3], const double d[3], double to[3])
{
    double s[3], along = (n[0] + n[1] + n[2]) / sqrt(3.0);
    for (int i = 0; i < 3; i++) s[i] = 1 / sqrt(3.0) - along * n[i];
    normalize(s);
    const double t[3] = {n[1] * s[2] - n[2] * s[1], n[2] * s[0] - n[0] * s[2],
                         n[0] * s[1] - n[1] * s[0]};
    to[0] = 0.5 * (dot(s, d) + 1);
    to[1] = 0.5 * (dot(t, d) + 1);
    to[2] = fabs(dot(n, d));
}

/* Fills `to` [BUFFER_CHANNELS] with what the ray from o along d sees. False near outlines, where
 * rounding decides. */
static bool expected_buffers(const double o[3], const double d[3], double *to)
{
    double t_hit = INFINITY, oc[3], n[3] = {0};
    for (int i = 0; i < BUFFER_CHANNELS; i++) to[i] = 0;
    for (int i = 0; i < 3; i++) oc[i] = o[i] - ball_center[i];
    double b = dot(oc, d), rest = b * b - dot(oc, oc) + ball_radius * ball_radius;
    if (fabs(rest) < 1e-3) return false;
    if (rest > 0) {
        t_hit = -b - sqrt(rest);
        for (int i = 0; i < 3; i++) n[i] = (oc[i] + t_hit * d[i]) / ball_radius;
        to[BUFFER_SHAPE_ID] = BALL_ID;
        to[BUFFER_ROUGHNESS] = 0.2;
        for (int i = 0; i < 3; i++) to[BUFFER_ALBEDO + i] = 0.9 - 0.2 * i; /* specular */
    }
    double t = -o[1] / d[1], x = o[0] + t * d[0], z = o[2] + t * d[2];
    if (fabs(fabs(x) - 2) < 1e-3 || fabs(fabs(z) - 2) < 1e-3) return false;
    if (t > 0 && t < t_hit && fabs(x) < 2 && fabs(z) < 2) {
        t_hit = t;
        n[0] = n[2] = 0;
        n[1] = 1;
        to[BUFFER_SHAPE_ID] = FLOOR_ID;
        /* The quad starts at (-2, 0, 2); its first triangle has the larger first coordinate. */
        to[BUFFER_PRIMITIVE_ID] = x + 2 > 2 - z ? 0 : 1;
        if (fabs(x + z) < 1e-3) return false;
        to[BUFFER_ROUGHNESS] = 1;
        for (int i = 0; i < 3; i++) to[BUFFER_ALBEDO + i] = 0.2 * (i + 1);
    }
    t = (lamp_center[1] - o[1]) / d[1];
    x = o[0] + t * d[0] - lamp_center[0];
    z = o[2] + t * d[2] - lamp_center[2];
    double outside = x * x + z * z - lamp_radius * lamp_radius;
    if (fabs(outside) < 1e-3) return false;
    if (t > 0 && t < t_hit && outside < 0) {
        t_hit = t;
        n[0] = n[2] = 0;
        n[1] = -1;
        to[BUFFER_SHAPE_ID] = LAMP_ID;
        to[BUFFER_PRIMITIVE_ID] = 0;
        to[BUFFER_ROUGHNESS] = 1;
        for (int i = 0; i < 3; i++) to[BUFFER_ALBEDO + i] = 0.5;
        for (int i = 0; i < 3; i++) to[BUFFER_EMISSION + i] = 5 - i;
    }
    if (to[BUFFER_SHAPE_ID] == 0) {
        for (int i = 0; i < 3; i++) to[BUFFER_EMISSION + i] = 0.3 * (i + 1);
        return true;
    }
    const double wo[3] = {-d[0], -d[1], -d[2]};
    to[BUFFER_DEPTH] = t_hit;
    for (int i = 0; i < 3; i++) {
        to[BUFFER_POSITION + i] = o[i] + t_hit * d[i];
        to[BUFFER_NORMAL + i] = to[BUFFER_GEO_NORMAL + i] = n[i];
        to[BUFFER_WO + i] = wo[i];
    }
    if (to[BUFFER_SHAPE_ID] == BALL_ID) encode(n, wo, to + BUFFER_WI);
    return true;
}

static struct made_scene *ball_on_floor(void)
{
    struct made_scene *m = made_scene_new();
    uint32_t metal = made_rough(m, BSDF_ROUGH_CONDUCTOR, MICROFACET_GGX, 0.2f);
    m->bsdfs[metal].specular_reflectance = made_texture(m, vec3(0.9f, 0.7f, 0.5f));
    m->bsdfs[metal].eta_texture = made_texture(m, vec3_splat(0.2f));
    m->bsdfs[metal].k_texture = made_texture(m, vec3_splat(3.9f));
    uint32_t lamp = made_emitter(m, EMITTER_AREA, vec3(5, 4, 3));
    made_emitter(m, EMITTER_CONSTANT, vec3(0.3f, 0.6f, 0.9f));
    made_sphere(m, vec3(0.2f, 0.8f, -0.3f), 0.8f, metal, SCENE_NONE);
    made_quad(m, vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4),
              made_diffuse(m, vec3(0.2f, 0.4f, 0.6f)), SCENE_NONE);
    struct transform turn = transform_rotate(vec3(1, 0, 0), 90), place, scale;
    scale = transform_scale(vec3_splat(0.6f));
    turn = transform_mul(&turn, &scale);
    place = transform_translate(vec3(-1.1f, 2, -0.5f));
    place = transform_mul(&place, &turn);
    made_disk(m, &place, made_diffuse(m, vec3_splat(0.5f)), lamp);
    made_camera(m, vec3(0, 1, 5), vec3(0, 1, 0), 50, WIDTH, HEIGHT);
    m->scene.defaults.sensor.near_clip = 0.7f; /* depth counts from the pinhole all the same */
    return m;
}

static void buffers_are_what_is_seen(void **state)
{
    (void)state;
    struct made_scene *m = ball_on_floor();
    struct view *v = made_view(m);
    struct trace_settings t = made_settings(m, 3, 2);
    t.filter_radius = 1e-6f; /* all samples at the pixels' centres */
    struct window w = picture_whole(WIDTH, HEIGHT);
    for (int k = 0; k < 2; k++) {
        t.hide_emitters = k;
        struct picture p = picture_trace(view_trace, v, &t, &w);
        size_t n_seen[4] = {0};
        for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
            /* The camera looks along -z; x grows to the right, y up. */
            double tangent = tan(25 * 3.14159265358979 / 180), expected[BUFFER_CHANNELS];
            double d[3] = {tangent * ((i % WIDTH + 0.5) * 2 / WIDTH - 1),
                           tangent * (HEIGHT - (i / WIDTH + 0.5) * 2) / WIDTH, -1};
            const double o[3] = {0, 1, 5};
            normalize(d);
            if (!expected_buffers(o, d, expected)) continue;
            n_seen[(int)expected[BUFFER_SHAPE_ID]]++;
            for (int c = 0; c < BUFFER_CHANNELS; c++) {
                double is = p.buffers[i * BUFFER_CHANNELS + (uint32_t)c], should = expected[c];
                if (t.hide_emitters && c >= BUFFER_EMISSION && c < BUFFER_EMISSION + 3) should = 0;
                if (fabs(is - should) > 1e-4 * fmax(1, fabs(should)))
                    fail_msg("pixel %u: %s is %g instead of %g", i, buffer_channel_names[c], is,
                             should);
            }
        }
        for (int s = 0; s < 4; s++) assert_true(n_seen[s] > 50);
        picture_release(&p);
    }
    made_scene_free(m);
}

/* Over a pixel, buffers are means by the filter: with a wide one, the lamp's emission leaks out. */
static void buffers_are_filtered(void **state)
{
    (void)state;
    struct made_scene *m = ball_on_floor();
    struct view *v = made_view(m);
    struct window w = picture_whole(WIDTH, HEIGHT);
    struct trace_settings t = made_settings(m, 1, 64);
    t.filter = FILTER_TENT;
    t.filter_radius = 2;
    struct picture p = picture_trace(view_trace, v, &t, &w);
    /* With depth 1 the picture is the emission of the first hits. */
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
        for (uint32_t c = 0; c < 3; c++) {
            double emission = p.buffers[i * BUFFER_CHANNELS + BUFFER_EMISSION + c];
            assert_true(fabs(emission - p.color[3 * i + c]) <= 1e-5 * (1 + emission));
        }
    picture_release(&p);
    made_scene_free(m);
}

/* Lanes against one sample at a time, for all that the vector code knows. Packets may place a hit
 * differently in the last bit, which at outlines is another object. */
static void buffers_as_the_plain_ones(void **state)
{
    (void)state;
    static const uint32_t spp[] = {1, 3, 7, 8, 21};
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    for (uint32_t i = 0; i < 30; i++) {
        struct trace_settings t = made_settings(m, 1, spp[i % 5]);
        struct window w = {WIDTH, HEIGHT, i % 4, i % 3, WIDTH - i % 4 - i % 5, HEIGHT - i % 3};
        t.sampler = i & 1 ? SAMPLER_SOBOL : SAMPLER_INDEPENDENT;
        t.filter = i % 3 == 0 ? FILTER_BOX : i % 3 == 1 ? FILTER_TENT : FILTER_GAUSSIAN;
        t.filter_radius = i % 3 == 0 ? 0.5f : 1.5f;
        t.hide_emitters = i == 7;
        struct picture a = picture_new(&w), b = picture_new(&w);
        struct trace_output fast = {.buffers = a.buffers}, plain = {.buffers = b.buffers};
        view_trace(v, &t, &w, &fast);
        view_trace_plain(v, &t, &w, &plain);
        double off = picture_different(a.buffers, b.buffers, a.n_pixels, BUFFER_CHANNELS, 1e-4);
        if (off > 0.005) fail_msg("%u samples: %.2f %% of pixels differ", t.spp, 100 * off);
        assert_true(picture_mean(a.buffers, BUFFER_CHANNELS * a.n_pixels) > 0.1);
        picture_release(&a);
        picture_release(&b);
    }
    made_scene_free(m);
}

/* What a normal map does to the buffers: the normal leans, whatever the frame around it, and the
 * position's own normal stays. */
static void mapped_normals_are_seen(void **state)
{
    (void)state;
    struct made_scene *m = made_scene_new();
    uint32_t map = made_bsdf(m, BSDF_NORMALMAP);
    m->bsdfs[map].child[0] = made_diffuse(m, vec3(0.2f, 0.4f, 0.6f));
    m->bsdfs[map].normals = made_texture(m, vec3(0.8f, 0.5f, 0.9f)); /* (0.6, 0, 0.8) */
    made_quad(m, vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4), map, SCENE_NONE);
    made_camera(m, vec3(0, 3, 0), vec3(0, 0, 0), 30, 8, 8);
    struct view *v = made_view(m);
    struct trace_settings t = made_settings(m, 2, 1);
    struct window w = picture_whole(8, 8);
    struct picture p = picture_trace(view_trace, v, &t, &w);
    for (size_t i = 0; i < 64; i++) {
        const float *b = p.buffers + i * BUFFER_CHANNELS, *n = b + BUFFER_NORMAL;
        assert_true(b[BUFFER_GEO_NORMAL + 1] > 0.9999f);
        assert_true(fabsf(n[1] - 0.8f) < 1e-5f);
        assert_true(fabsf(n[0] * n[0] + n[2] * n[2] - 0.36f) < 1e-5f);
        assert_true(b[BUFFER_ALBEDO + 1] == 0.4f && b[BUFFER_ROUGHNESS] == 1.0f);
    }
    picture_release(&p);
    made_scene_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(windows_are_crops),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(parts_alone),
        cmocka_unit_test(halves_make_the_whole),
        cmocka_unit_test(halves_are_independent),
        cmocka_unit_test(buffers_are_what_is_seen),
        cmocka_unit_test(buffers_are_filtered),
        cmocka_unit_test(buffers_as_the_plain_ones),
        cmocka_unit_test(mapped_normals_are_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
