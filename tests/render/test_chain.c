/* SPDX-License-Identifier: Apache-2.0 */
/* Delta chains: buffers of what mirrors and glass show, and pictures split the same way. */
#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "base/pool.h"
#include "made_scene.h"
#include "picture.h"
#include "render/chain.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

enum { WIDTH = 70, HEIGHT = 45 };

/* A picture's buffers with their chains; freed with result_release(). */
struct result {
    float *buffers, *chain;
    size_t n;
};

static struct result result_new(const struct window *w)
{
    struct result r = {.n = (size_t)w->width * w->height};
    r.buffers = mem_new(r.n, BUFFER_CHANNELS * sizeof(float));
    r.chain = mem_new(r.n, CHAIN_CHANNELS * sizeof(float));
    assert_true(r.buffers && r.chain);
    return r;
}

static void result_release(struct result *r)
{
    mem_free(r->buffers);
    mem_free(r->chain);
}

static struct result follow(trace_fn *fn, const struct view *v, struct trace_settings t,
                            const struct window *w)
{
    struct result r = result_new(w);
    struct trace_output out = {.buffers = r.buffers, .chain = r.chain};
    t.follows_delta = true;
    fn(v, &t, w, &out);
    return r;
}

static bool is_same(const struct result *a, const struct result *b)
{
    return a->n == b->n &&
           memcmp(a->buffers, b->buffers, a->n * BUFFER_CHANNELS * sizeof(float)) == 0 &&
           memcmp(a->chain, b->chain, a->n * CHAIN_CHANNELS * sizeof(float)) == 0;
}

static void near(const char *what, double is, double should, double tolerance)
{
    if (!(fabs(is - should) <= tolerance)) fail_msg("%s: %g instead of %g", what, is, should);
}

static void near_3(const char *what, const float *is, struct vec3 should, double tolerance)
{
    near(what, is[0], should.x, tolerance);
    near(what, is[1], should.y, tolerance);
    near(what, is[2], should.z, tolerance);
}

/* The mean over pixels of a channel. */
static double mean_of(const float *values, size_t n_pixels, int n_channels, int channel)
{
    double sum = 0;
    for (size_t i = 0; i < n_pixels; i++) sum += values[i * (size_t)n_channels + (size_t)channel];
    return sum / (double)n_pixels;
}

/* ---- Analytic -------------------------------------------------------------------------------- */

static uint32_t mirror(struct made_scene *m, struct vec3 reflectance)
{
    uint32_t b = made_bsdf(m, BSDF_CONDUCTOR);
    m->bsdfs[b].specular_reflectance = made_texture(m, reflectance);
    return b;
}

/* A camera at the origin that looks along -z at a mirror at z = -2, turned by 45 degrees, which
 * shows a wall at x = 3. */
static void mirror_shows_a_wall(void **state)
{
    (void)state;
    for (int shines = 0; shines < 2; shines++) {
        struct made_scene *m = made_scene_new();
        uint32_t lamp = made_emitter(m, EMITTER_AREA, vec3(2, 3, 5));
        made_quad(m, vec3(-1, -1, -1), vec3(0, 2, 0), vec3(2, 0, -2),
                  made_twosided(m, mirror(m, vec3(0.9f, 0.8f, 0.7f))), SCENE_NONE);
        made_quad(m, vec3(3, -3, 1), vec3(0, 6, 0), vec3(0, 0, -6),
                  made_twosided(m, made_diffuse(m, vec3(0.1f, 0.5f, 0.3f))),
                  shines ? lamp : SCENE_NONE);
        made_camera(m, vec3(0, 0, 0), vec3(0, 0, -1), 1e-3f, 8, 8);
        struct view *v = made_view(m);
        struct window w = picture_whole(8, 8);
        for (int depth = -1; depth < 3; depth++) {
            struct trace_settings t = made_settings(m, depth, 5);
            t.hide_emitters = depth == 2; /* seen by the mirror it shows all the same */
            struct result r = follow(view_trace, v, t, &w);
            bool is_followed = depth < 0 || depth == 2;
            for (size_t i = 0; i < r.n; i++) {
                const float *b = r.buffers + i * BUFFER_CHANNELS;
                const float *c = r.chain + i * CHAIN_CHANNELS;
                assert_true(b[BUFFER_SHAPE_ID] == (is_followed ? 2 : 1));
                if (!is_followed) {
                    near_3("throughput", c + CHAIN_THROUGHPUT, vec3(1, 1, 1), 0);
                    near_3("emission", c + CHAIN_EMISSION, vec3(0, 0, 0), 0);
                    continue;
                }
                near_3("position", b + BUFFER_POSITION, vec3(3, 0, -2), 1e-3);
                near("depth", b[BUFFER_DEPTH], 5, 1e-3);
                near_3("wo", b + BUFFER_WO, vec3(-1, 0, 0), 1e-3);
                near("normal", fabsf(b[BUFFER_NORMAL]), 1, 1e-5);
                near_3("albedo", b + BUFFER_ALBEDO, vec3(0.1f, 0.5f, 0.3f), 1e-6);
                near("roughness", b[BUFFER_ROUGHNESS], 1, 0);
                near_3("throughput", c + CHAIN_THROUGHPUT, vec3(0.9f, 0.8f, 0.7f), 1e-5);
                struct vec3 light = shines ? vec3(2, 3, 5) : vec3(0, 0, 0);
                near_3("own emission", b + BUFFER_EMISSION, light, 1e-5);
                near_3("emission", c + CHAIN_EMISSION, vec3_mul(light, vec3(0.9f, 0.8f, 0.7f)),
                       1e-4);
            }
            result_release(&r);
        }
        made_scene_free(m);
    }
}

/* Looking straight through a sheet at a wall that shines, past nothing else: each sample shows the
 * wall or, reflected, nothing. What is transmitted is 1 - 2r / (1 + r) with r = ((n-1)/(n+1))^2. */
static void sheets_let_light_through(void **state)
{
    (void)state;
    const double r0 = 0.04, through = 1 - 2 * r0 / (1 + r0);
    const double shares[3] = {through * through, 1.0, 0.3};
    for (int kind = 0; kind < 3; kind++) {
        struct made_scene *m = made_scene_new();
        uint32_t lamp = made_emitter(m, EMITTER_AREA, vec3(1, 2, 4)), sheet;
        sheet = made_bsdf(m, kind == 0 ? BSDF_THIN_DIELECTRIC : kind == 1 ? BSDF_NULL : BSDF_MASK);
        if (kind == 2) {
            m->bsdfs[sheet].child[0] = made_diffuse(m, vec3(0.2f, 0.2f, 0.2f));
            m->bsdfs[sheet].opacity = made_texture(m, vec3_splat(0.7f));
        }
        made_quad(m, vec3(-1, -1, -2), vec3(2, 0, 0), vec3(0, 2, 0), sheet, SCENE_NONE);
        /* A second one behind it: both ways between the two end in some sample. */
        if (kind == 0)
            made_quad(m, vec3(-1, -1, -3), vec3(2, 0, 0), vec3(0, 2, 0), sheet, SCENE_NONE);
        made_quad(m, vec3(-1, -1, -4), vec3(2, 0, 0), vec3(0, 2, 0),
                  made_diffuse(m, vec3(0.5f, 0.5f, 0.5f)), lamp);
        made_camera(m, vec3(0, 0, 0), vec3(0, 0, -1), 1e-3f, 64, 64);
        struct view *v = made_view(m);
        struct window w = picture_whole(64, 64);
        struct trace_settings t = made_settings(m, -1, 16);
        struct result r = follow(view_trace, v, t, &w);
        double share = shares[kind];
        /* Between two sheets light goes to and fro: T^2 / (1 - R^2). */
        if (kind == 0) share /= 1 - (1 - through) * (1 - through);
        double noise = 4 * sqrt(share * (1 - share) / (double)(r.n * 16)) + 1e-5;
        for (int c = 0; c < 3; c++) {
            near("emission", mean_of(r.chain, r.n, CHAIN_CHANNELS, CHAIN_EMISSION + c),
                 share * (1 << c), noise * (1 << c));
            near("throughput", mean_of(r.chain, r.n, CHAIN_CHANNELS, CHAIN_THROUGHPUT + c), 1,
                 1e-5);
        }
        if (kind == 1) /* the wall, as if there were no sheet */
            near("depth", mean_of(r.buffers, r.n, BUFFER_CHANNELS, BUFFER_DEPTH), 4, 1e-4);
        if (kind == 2) /* the wall or what the mask leaves */
            near("albedo", mean_of(r.buffers, r.n, BUFFER_CHANNELS, BUFFER_ALBEDO),
                 0.3 * 0.5 + 0.7 * 0.2, 0.3 * noise);
        result_release(&r);
        made_scene_free(m);
    }
}

/* Two mirrors that face each other: a chain has an end. */
static void chains_end(void **state)
{
    (void)state;
    struct made_scene *m = made_scene_new();
    uint32_t glass = made_twosided(m, mirror(m, vec3_splat(0.99f)));
    made_quad(m, vec3(-9, -9, -1), vec3(18, 0, 0), vec3(0, 18, 0), glass, SCENE_NONE);
    made_quad(m, vec3(-9, -9, 1), vec3(18, 0, 0), vec3(0, 18, 0), glass, SCENE_NONE);
    made_camera(m, vec3(0, 0, 0), vec3(0, 0, -1), 1e-3f, 4, 4);
    struct view *v = made_view(m);
    struct window w = picture_whole(4, 4);
    struct result r = follow(view_trace, v, made_settings(m, -1, 1), &w);
    for (size_t i = 0; i < r.n; i++) {
        near("throughput", r.chain[i * CHAIN_CHANNELS], pow((double)0.99f, CHAIN_MAX), 1e-5);
        assert_true(r.chain[i * CHAIN_CHANNELS + CHAIN_LENGTH] == CHAIN_MAX);
        near("depth", r.buffers[i * BUFFER_CHANNELS + BUFFER_DEPTH], 1 + 2 * CHAIN_MAX, 0.1);
    }
    result_release(&r);
    made_scene_free(m);
}

/* ---- All kinds ------------------------------------------------------------------------------- */

static struct trace_settings settings_of(const struct made_scene *m, uint32_t spp, bool is_sobol)
{
    struct trace_settings t = made_settings(m, 9, spp);
    t.sampler = is_sobol ? SAMPLER_SOBOL : SAMPLER_INDEPENDENT;
    t.filter = FILTER_TENT;
    t.filter_radius = 1;
    return t;
}

/* Windows, threads, and with or without the picture: the same bytes. */
static void the_same_bytes(void **state)
{
    (void)state;
    static const uint32_t spp[] = {1, 6, 22};
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    for (int i = 0; i < 3; i++) {
        struct trace_settings t = settings_of(m, spp[i], i & 1);
        t.hide_emitters = i == 2;
        struct window all = picture_whole(WIDTH, HEIGHT), w = {WIDTH, HEIGHT, 7, 3, 41, 39};
        struct result whole = follow(view_trace, v, t, &all), part = follow(view_trace, v, t, &w);
        for (uint32_t y = 0; y < w.height; y++) {
            size_t a = (size_t)y * w.width, b = (size_t)(y + w.y) * WIDTH + w.x;
            assert_memory_equal(part.buffers + a * BUFFER_CHANNELS,
                                whole.buffers + b * BUFFER_CHANNELS,
                                w.width * BUFFER_CHANNELS * sizeof(float));
            assert_memory_equal(part.chain + a * CHAIN_CHANNELS, whole.chain + b * CHAIN_CHANNELS,
                                w.width * CHAIN_CHANNELS * sizeof(float));
        }
        struct pool *pool = pool_new(3);
        struct picture p = picture_new(&all);
        struct result threads = result_new(&all);
        struct trace_output out = {
            .color = p.color, .buffers = threads.buffers, .chain = threads.chain};
        struct error err;
        t.follows_delta = true;
        assert_non_null(pool);
        assert_int_equal(view_trace_parallel(v, pool, &t, &all, &out, NULL, NULL, &err), LMN_OK);
        if (!is_same(&threads, &whole)) fail_msg("%u samples: other bytes", t.spp);
        pool_free(pool);
        picture_release(&p);
        result_release(&threads);
        result_release(&part);
        result_release(&whole);
    }
    made_scene_free(m);
}

/* Lanes against one sample at a time; only outlines may differ. */
static void as_the_plain_ones(void **state)
{
    (void)state;
    static const uint32_t spp[] = {1, 3, 8, 21};
    for (int i = 0; i < 8; i++) {
        struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
        struct sensor *s = &m->scene.defaults.sensor;
        if (i >= 6) { /* a lens draws numbers of its own */
            s->kind = SENSOR_THINLENS;
            s->aperture_radius = 0.05f;
            s->focus_distance = 4;
        }
        struct view *v = made_view(m);
        struct window w = picture_whole(WIDTH, HEIGHT);
        struct trace_settings t = settings_of(m, spp[i % 4], i & 1);
        t.hide_emitters = i == 4;
        struct result a = follow(view_trace, v, t, &w), b = follow(view_trace_plain, v, t, &w);
        double off = picture_different(a.buffers, b.buffers, a.n, BUFFER_CHANNELS, 1e-3);
        double chains = picture_different(a.chain, b.chain, a.n, CHAIN_CHANNELS, 1e-3);
        if (off > 0.02 || chains > 0.02)
            fail_msg("%u samples: %.2f %% of pixels differ, %.2f %% of chains", t.spp, 100 * off,
                     100 * chains);
        assert_true(mean_of(a.chain, a.n, CHAIN_CHANNELS, CHAIN_THROUGHPUT) < 0.999);
        result_release(&a);
        result_release(&b);
        made_scene_free(m);
    }
}

/* Pixels of which each is followed once a sample, and what its surface scatters is traced from
 * there, in the order of lengths. */
enum { FOLLOWED = 24, FOLLOWED_PIXELS = FOLLOWED * FOLLOWED };

static void add_followed(const struct view *v, struct trace_settings t, double *sums)
{
    static float color[FOLLOWED_PIXELS * 3], own[FOLLOWED_PIXELS * BUFFER_CHANNELS];
    const struct window w = picture_whole(FOLLOWED, FOLLOWED);
    struct pixel_at pixels[FOLLOWED_PIXELS];
    struct chain_end ends[FOLLOWED_PIXELS];
    struct ray rays[FOLLOWED_PIXELS];
    uint32_t of[FOLLOWED_PIXELS];
    t.spp = 1;
    struct result r = follow(view_trace, v, t, &w);
    for (uint32_t i = 0; i < FOLLOWED_PIXELS; i++)
        pixels[i] = (struct pixel_at){i % FOLLOWED, i / FOLLOWED};
    view_follow_pixels(v, &t, FOLLOWED, FOLLOWED, pixels, FOLLOWED_PIXELS, ends);
    for (uint32_t length = 0, n_done = 0; n_done < FOLLOWED_PIXELS; length++) {
        struct trace_settings left = t;
        struct trace_output out = {.color = color, .buffers = own};
        uint32_t n = 0;
        for (uint32_t i = 0; i < FOLLOWED_PIXELS; i++)
            if (ends[i].n == length) of[n++] = i;
        for (uint32_t k = 0; k < n; k++) rays[k] = ends[of[k]].ray;
        left.max_depth -= (int32_t)length;
        left.spp = 2;
        left.seed = 1000 * t.first_sample + length;
        if (n > 0) view_trace_rays(v, &left, rays, n, &out);
        for (uint32_t k = 0; k < n; k++) {
            const float *chain = r.chain + of[k] * CHAIN_CHANNELS;
            assert_true(chain[CHAIN_LENGTH] == (float)length);
            for (uint32_t c = 0; c < 3; c++) {
                float y = color[3 * k + c] - own[k * BUFFER_CHANNELS + BUFFER_EMISSION + c];
                sums[3 * of[k] + c] += (double)chain[CHAIN_EMISSION + c] +
                                       (double)chain[CHAIN_THROUGHPUT + c] * (double)y;
            }
        }
        n_done += n;
    }
    result_release(&r);
}

/* emission + throughput * what the last surface scatters is the picture, also where bounces are
 * counted: a method that knows surfaces knows what mirrors show. */
static void what_chains_leave_is_the_picture(void **state)
{
    enum { SPP = 64 };
    static double sums[FOLLOWED_PIXELS * 3];
    static float color[FOLLOWED_PIXELS * 3];
    const struct window w = picture_whole(FOLLOWED, FOLLOWED);
    (void)state;
    for (int depth = 3; depth <= 6; depth += 3) {
        struct made_scene *m = made_all_kinds(FOLLOWED, FOLLOWED);
        struct view *v = made_view(m);
        struct trace_settings t = settings_of(m, 4 * SPP, true);
        struct trace_output out = {.color = color};
        double sum = 0, sum2 = 0, level = 0;
        t.max_depth = depth;
        t.rr_depth = 100;
        view_trace(v, &t, &w, &out);
        memset(sums, 0, sizeof sums);
        t.seed++;
        for (t.first_sample = 0; t.first_sample < SPP; t.first_sample++) add_followed(v, t, sums);
        for (size_t i = 0; i < sizeof sums / sizeof *sums; i++) {
            const double off = sums[i] / SPP - (double)color[i];
            sum += off;
            sum2 += off * off;
            level += (double)color[i];
        }
        if (!(fabs(sum) < 4 * sqrt(sum2) && sqrt(sum2) < 0.01 * level))
            fail_msg("depth %d: off by %.4f of the light, noise %.4f", depth, sum / level,
                     sqrt(sum2) / level);
        made_scene_free(m);
    }
}

/* ---- Pictures -------------------------------------------------------------------------------- */

/* Traces a picture in its two parts: rest, then what is seen. */
static void split(const struct view *v, const struct trace_settings *t, const struct window *w,
                  struct picture *p, float *groups, const uint32_t *group_of, uint32_t n)
{
    struct trace_output out = picture_output(p);
    memset(groups, 0, 2 * n * 3 * p->n_pixels * sizeof *groups);
    out.half_a = out.half_b = NULL;
    out.groups = groups;
    out.n_groups = 2 * n;
    out.chain_group = n;
    out.group_of = group_of;
    view_trace(v, t, w, &out);
}

/* The parts make the picture; what is seen is what buffers gather along chains, as both draw the
 * same numbers when no roulette is played. */
static void pictures_are_split(void **state)
{
    (void)state;
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    const uint32_t group_of[MADE_MAX] = {0};
    struct window w = picture_whole(WIDTH, HEIGHT);
    for (int i = 0; i < 6; i++) {
        struct trace_settings t = settings_of(m, i == 5 ? 200 : 16, i & 1);
        t.hide_emitters = i == 2;
        if (i == 3) t.max_depth = 2;
        if (i == 5) t.rr_depth = 2;
        struct picture whole = picture_trace(view_trace, v, &t, &w), p = picture_new(&w);
        const size_t n = 3 * p.n_pixels;
        float *groups = mem_new(2 * n, sizeof *groups);
        assert_non_null(groups);
        split(v, &t, &w, &p, groups, group_of, 1);
        assert_true(picture_different(p.color, whole.color, p.n_pixels, 3, 1e-4) == 0);
        for (size_t k = 0; k < n; k++) assert_true(groups[k] + groups[n + k] == p.color[k]);
        struct result r = follow(view_trace, v, t, &w);
        size_t n_off = 0;
        double seen = 0, chains = 0;
        for (size_t k = 0; k < n; k++) {
            double a = groups[n + k], b = r.chain[k / 3 * CHAIN_CHANNELS + CHAIN_EMISSION + k % 3];
            n_off += fabs(a - b) > 1e-3 * fmax(b, 0.01);
            seen += a;
            chains += b;
        }
        if (i < 5 && n_off > n / 100)
            fail_msg("%d: %zu of %zu values differ from the buffers'", i, n_off, n);
        if (fabs(seen - chains) > (i == 5 ? 0.01 : 1e-3) * chains)
            fail_msg("%d: %g seen, %g in buffers", i, seen, chains);
        assert_true(seen > 0.02 * (double)n && picture_mean(groups, n) > (i == 3 ? 0.005 : 0.02));
        result_release(&r);
        mem_free(groups);
        picture_release(&whole);
        picture_release(&p);
    }
    made_scene_free(m);
}

/* Light groups, each in its two parts: the same planes, split further. */
static void groups_are_split(void **state)
{
    (void)state;
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    const uint32_t n_groups = m->scene.n_emitters, none[MADE_MAX] = {0};
    uint32_t group_of[MADE_MAX];
    for (uint32_t i = 0; i < n_groups; i++) group_of[i] = i;
    struct window w = picture_whole(WIDTH, HEIGHT);
    struct trace_settings t = settings_of(m, 8, false);
    struct picture p = picture_new(&w);
    const size_t n = 3 * p.n_pixels;
    float *all = mem_new(2 * n, sizeof *all), *each = mem_new(2 * n_groups * n, sizeof *each);
    assert_true(all && each && n_groups > 2);
    split(v, &t, &w, &p, all, none, 1);
    split(v, &t, &w, &p, each, group_of, n_groups);
    for (uint32_t part = 0; part < 2; part++)
        for (size_t k = 0; k < n; k++) {
            double sum = 0, should = all[part * n + k];
            for (uint32_t g = 0; g < n_groups; g++) sum += each[(part * n_groups + g) * n + k];
            assert_true(fabs(sum - should) <= 1e-5 * fmax(should, 1e-3));
        }
    mem_free(all);
    mem_free(each);
    picture_release(&p);
    made_scene_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mirror_shows_a_wall), cmocka_unit_test(sheets_let_light_through),
        cmocka_unit_test(chains_end),          cmocka_unit_test(the_same_bytes),
        cmocka_unit_test(as_the_plain_ones),   cmocka_unit_test(what_chains_leave_is_the_picture),
        cmocka_unit_test(pictures_are_split),  cmocka_unit_test(groups_are_split),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
