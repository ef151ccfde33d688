/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of the light of groups of emitters, by paths alone and with photons. */
#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "base/pool.h"
#include "made_scene.h"
#include "picture.h"
#include "render/world.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

enum { MAX_GROUPS = 16, WIDTH = 48, HEIGHT = 32 };

static void with_photons(const struct view *v, const struct trace_settings *t,
                         const struct window *w, struct trace_output *out)
{
    struct error err = {""};
    struct pool *pool = pool_new(2);
    if (view_trace_photons(v, pool, t, w, out, NULL, NULL, &err)) fail_msg("%s", err.text);
    pool_free(pool);
}

static trace_fn *const tracers[2] = {view_trace, with_photons};

/* A picture, and its groups. */
static struct picture trace_groups(trace_fn *fn, const struct view *v,
                                   const struct trace_settings *t, uint32_t n_groups,
                                   const uint32_t *group_of, float **groups)
{
    struct window w = picture_whole(WIDTH, HEIGHT);
    struct picture p = picture_new(&w);
    struct trace_output out = picture_output(&p);
    *groups = mem_new(n_groups * 3 * p.n_pixels, sizeof **groups);
    assert_non_null(*groups);
    out.groups = *groups;
    out.n_groups = n_groups;
    out.group_of = group_of;
    fn(v, t, &w, &out);
    return p;
}

/* Groups add up to the picture exactly, and to the picture without groups up to rounding. */
static void groups_add_up(void **state)
{
    (void)state;
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    struct window w = picture_whole(WIDTH, HEIGHT);
    struct trace_settings t = made_settings(m, 5, 40);
    uint32_t n_emitters = m->scene.n_emitters, group_of[MAX_GROUPS];
    assert_in_range(n_emitters, 3, MAX_GROUPS);
    for (int i = 0; i < 4; i++) {
        uint32_t n_groups = i & 1 ? n_emitters : 2;
        for (uint32_t k = 0; k < n_emitters; k++) group_of[k] = i & 1 ? k : k % 2;
        float *groups;
        struct picture whole = picture_trace(tracers[i / 2], v, &t, &w);
        struct picture parts = trace_groups(tracers[i / 2], v, &t, n_groups, group_of, &groups);
        size_t n = 3 * whole.n_pixels;
        assert_true(picture_different(parts.color, whole.color, whole.n_pixels, 3, 1e-4) == 0);
        for (size_t k = 0; k < n; k++) {
            float sum = 0;
            for (uint32_t g = 0; g < n_groups; g++) sum += groups[g * n + k];
            assert_true(sum == parts.color[k]);
        }
        mem_free(groups);
        picture_release(&whole);
        picture_release(&parts);
    }
    made_scene_free(m);
}

/* Means agree within the noise of both, as their halves show it. */
static void assert_same_light(const char *what, const float *found, const struct picture *expected,
                              double noise)
{
    size_t n = 3 * expected->n_pixels;
    double a = picture_mean(found, n), b = picture_mean(expected->color, n);
    noise += fabs(picture_mean(expected->half_a, n) - picture_mean(expected->half_b, n));
    if (fabs(a - b) > 0.03 * b + 2 * noise + 1e-4) fail_msg("%s: mean %g, alone %g", what, a, b);
}

/* A group is what is left when the other emitters are dark. */
static void groups_are_alone(void **state)
{
    (void)state;
    struct made_scene *m = made_all_kinds(WIDTH, HEIGHT);
    struct view *v = made_view(m);
    struct window w = picture_whole(WIDTH, HEIGHT);
    struct trace_settings t = made_settings(m, 5, 64);
    uint32_t n_groups = m->scene.n_emitters, group_of[MAX_GROUPS];
    for (uint32_t k = 0; k < n_groups; k++) group_of[k] = k;
    for (int i = 0; i < 2; i++) {
        float *groups;
        struct picture parts = trace_groups(tracers[i], v, &t, n_groups, group_of, &groups);
        for (uint32_t g = 0; g < n_groups; g++) {
            for (uint32_t k = 0; k < n_groups; k++)
                v->state.emitters[k].scale = k == g ? m->emitters[k].scale : 0;
            view_refresh(v, false);
            struct picture alone = picture_trace(tracers[i], v, &t, &w);
            assert_same_light("emitter", groups + g * 3 * alone.n_pixels, &alone, 0);
            picture_release(&alone);
        }
        for (uint32_t k = 0; k < n_groups; k++) v->state.emitters[k].scale = m->emitters[k].scale;
        view_refresh(v, false);
        mem_free(groups);
        picture_release(&parts);
    }
    made_scene_free(m);
}

/* A floor and a mirror ball under two panels; a third of the picture's light each, about. */
static struct made_scene *two_panels(void)
{
    struct made_scene *m = made_scene_new();
    uint32_t grey = made_twosided(m, made_diffuse(m, vec3(0.6f, 0.5f, 0.4f)));
    made_quad(m, vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4), grey, SCENE_NONE);
    made_quad(m, vec3(-2, 0, -2), vec3(4, 0, 0), vec3(0, 4, 0), grey, SCENE_NONE);
    made_sphere(m, vec3(0, 0.8f, 0), 0.5f, made_bsdf(m, BSDF_CONDUCTOR), SCENE_NONE);
    for (int i = 0; i < 2; i++) {
        uint32_t panel = made_emitter(m, EMITTER_AREA, i ? vec3(9, 5, 2) : vec3(2, 5, 9));
        made_quad(m, vec3(i ? 0.4f : -1.4f, 3, -1), vec3(1, 0, 0), vec3(0, 0, 1), grey, panel);
    }
    made_camera(m, vec3(0, 1.5f, 4), vec3(0, 0.6f, 0), 50.0f, WIDTH, HEIGHT);
    return m;
}

/* Emitters of other powers: the picture is the sum of the groups of the old one, times the factors,
 * though lights are chosen with other probabilities. Each channel of each third of the rows. */
static void powers_are_weights(void **state)
{
    (void)state;
    static const float factors[2] = {0.3f, 4.0f};
    static const uint32_t group_of[2] = {0, 1};
    for (int i = 0; i < 2; i++) {
        struct made_scene *m = two_panels();
        struct view *v = made_view(m);
        struct window w = picture_whole(WIDTH, HEIGHT);
        struct trace_settings t = made_settings(m, 6, 128);
        float *groups;
        struct picture before = trace_groups(tracers[i], v, &t, 2, group_of, &groups);
        for (int k = 0; k < 2; k++) v->state.emitters[k].scale *= factors[k];
        view_refresh(v, false);
        struct picture after = picture_trace(tracers[i], v, &t, &w);
        for (size_t part = 0; part < 9; part++) {
            size_t third = after.n_pixels / 3, first = part / 3 * third, c = part % 3;
            double sum = 0, expected = 0, noise = 0;
            for (size_t p = first; p < first + third; p++) {
                const float *g = groups + 3 * p + c;
                double a = after.half_a[3 * p + c], b = after.half_b[3 * p + c];
                sum += (double)(factors[0] * g[0] + factors[1] * g[3 * after.n_pixels]);
                expected += (double)after.color[3 * p + c];
                noise += 0.25 * (a - b) * (a - b);
            }
            /* The weighted sum is noisier, as its samples are spread for other powers. */
            double sigma = 2.5 * sqrt(noise);
            if (fabs(sum - expected) > 4 * sigma + 1e-3 * expected)
                fail_msg("%s, part %zu: %g instead of %g +- %g", i ? "photons" : "paths", part, sum,
                         expected, sigma);
            assert_true(sigma < 0.05 * expected); /* else this says nothing */
        }
        mem_free(groups);
        picture_release(&before);
        picture_release(&after);
        made_scene_free(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(groups_add_up),
        cmocka_unit_test(groups_are_alone),
        cmocka_unit_test(powers_are_weights),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
