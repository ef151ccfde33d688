/* SPDX-License-Identifier: Apache-2.0 */
/* The streams and packets of view_trace() against the plain loop of view_trace_plain(): the same
 * paths with the same random numbers. Embree's packets may place a hit differently in the last bit,
 * and a path that then meets an edge on its other side goes elsewhere: so nearly all pixels agree
 * to rounding, and the means agree. Scenes of few primitives are cast without Embree (few.h): where
 * surfaces coincide, as under the boxes that stand on a floor, either may be met first. */
#include <glob.h>
#include <math.h>
#include <string.h>

#include "base/cpu.h"
#include "made_scene.h"
#include "picture.h"
#include "render/stream.h"
#include "render/world.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

/* What the comment above says, in numbers: at most 1 % of pixels differ by more than 1e-4, and the
 * means by 1e-3; with few primitives 5 %, and 2e-2 (test_few.c compares the hits themselves). A
 * picture without light would agree with anything. */
static void compare(const char *name, const struct view *v, const struct trace_settings *t,
                    uint32_t width, uint32_t height)
{
    struct window w = picture_whole(width, height);
    struct picture a = picture_trace(view_trace, v, t, &w);
    struct picture b = picture_trace(view_trace_plain, v, t, &w);
    const bool is_few = few_is_used(&v->few);
    const double most = is_few ? 0.05 : 0.01;
    double colors = picture_different(a.color, b.color, a.n_pixels, 3, 1e-4);
    double halves = picture_different(a.half_b, b.half_b, a.n_pixels, 3, 1e-4);
    double buffers = picture_different(a.buffers, b.buffers, a.n_pixels, BUFFER_CHANNELS, 1e-4);
    if (colors > most || halves > most || buffers > most)
        fail_msg("%s, %u samples: %.2f %% of pixels differ (half: %.2f %%, buffers: %.2f %%)", name,
                 t->spp, 100 * colors, 100 * halves, 100 * buffers);
    double mean_a = picture_mean(a.color, 3 * a.n_pixels),
           mean_b = picture_mean(b.color, 3 * b.n_pixels);
    if (!(mean_b > 0.01) || fabs(mean_a - mean_b) > (is_few ? 2e-2 : 1e-3) * mean_b)
        fail_msg("%s, %u samples: mean %g instead of %g", name, t->spp, mean_a, mean_b);
    picture_release(&a);
    picture_release(&b);
}

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* The scenes that are compared with Mitsuba, each about one bsdf, light or shape. */
static void files(void **state)
{
    (void)state;
    glob_t found;
    assert_int_equal(glob(LMN_SOURCE_DIR "/scenes/tests/*.xml", 0, NULL, &found), 0);
    assert_int_equal(glob(LMN_SOURCE_DIR "/scenes/tests/ours/*.xml", GLOB_APPEND, NULL, &found), 0);
    assert_true(found.gl_pathc >= 30);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        struct scene_load_options options = {0};
        struct scene *s = NULL;
        struct world *w = NULL;
        struct view *v = NULL;
        struct error err = {""};
        if (scene_load(found.gl_pathv[i], &options, &s, &err) ||
            world_new(s, cpu_detect(), &w, &err) || view_new(w, &v, &err))
            fail_msg("%s", err.text);
        struct trace_settings t;
        trace_settings_init(&t, s);
        t.spp = 8;
        t.max_depth = 6;
        t.rr_depth = 2;
        compare(base_name(found.gl_pathv[i]), v, &t, 48, 48);
        view_free(v);
        world_free(w);
        scene_free(s);
    }
    globfree(&found);
}

/* All kinds in one scene, with every setting that the loops look at. */
static void settings(void **state)
{
    (void)state;
    struct made_scene *m = made_all_kinds(64, 48);
    struct view *v = made_view(m);
    for (int i = 0; i < 8; i++) {
        struct trace_settings t = made_settings(m, i == 6 ? 2 : -1, 16);
        if (i == 3) t.max_depth = 1;
        t.rr_depth = i == 5 ? 0 : 4;
        if (i & 1) t.sampler = SAMPLER_SOBOL;
        if (i & 2) t.mis = MIS_BALANCE;
        if (i & 4) t.hide_emitters = true;
        if (i == 3) {
            t.filter = FILTER_GAUSSIAN;
            t.filter_radius = 2;
        }
        if (i == 6) {
            t.filter = FILTER_TENT;
            t.filter_radius = 1;
            t.splats = true;
        }
        compare("all kinds", v, &t, 64, 48);
    }
    made_scene_free(m);
}

/* Sensors whose rays streams make one by one, and a lens that draws numbers of its own. */
static void sensors(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        struct made_scene *m = made_all_kinds(64, 48);
        struct sensor *s = &m->scene.defaults.sensor;
        s->kind = i & 2 ? SENSOR_THINLENS : SENSOR_ORTHOGRAPHIC;
        s->aperture_radius = 0.2f;
        s->focus_distance = 4;
        s->scale_x = s->scale_y = 2;
        struct view *v = made_view(m);
        struct trace_settings t = made_settings(m, 4, 16);
        if (i & 1) t.sampler = SAMPLER_SOBOL;
        compare(i & 2 ? "thin lens" : "orthographic", v, &t, 64, 48);
        made_scene_free(m);
    }
}

/* Packets and streams that are not full: sample counts around their sizes. */
static void counts(void **state)
{
    (void)state;
    struct made_scene *m = made_all_kinds(64, 48);
    struct view *v = made_view(m);
    static const uint32_t spp[] = {2, 4, 6, 14, 16, 18, 62, 64, 66, 126, 128, 130, 258};
    for (size_t i = 0; i < sizeof spp / sizeof *spp; i++) {
        struct trace_settings t = made_settings(m, 5, spp[i]);
        compare("count", v, &t, 19, 11);
    }
    made_scene_free(m);
}

/* The kernels of all instruction sets: the same bytes. */
static void instruction_sets(void **state)
{
    (void)state;
    static const uint32_t sets[] = {0, CPU_AVX2, CPU_AVX2 | CPU_AVX512};
    struct made_scene *m = made_all_kinds(64, 48);
    struct view *v = made_view(m);
    struct window w = picture_whole(64, 48);
    for (int i = 0; i < 4; i++) {
        struct trace_settings t = made_settings(m, 7, i < 2 ? 10 : 3);
        if (i & 1) t.sampler = SAMPLER_SOBOL;
        if (i & 2) t.mis = MIS_BALANCE;
        m->world->kernels = stream_kernels_for(sets[0]);
        struct picture expected = picture_trace(view_trace, v, &t, &w);
        for (size_t k = 1; k < sizeof sets / sizeof *sets; k++) {
            if ((cpu_detect() & sets[k]) != sets[k]) {
                print_message("skipped: no %s on this machine\n", cpu_name(sets[k]));
                continue;
            }
            m->world->kernels = stream_kernels_for(sets[k]);
            struct picture p = picture_trace(view_trace, v, &t, &w);
            if (!picture_is_crop(&p, &expected, 0, 0)) fail_msg("%s", m->world->kernels->name);
            picture_release(&p);
        }
        picture_release(&expected);
    }
    made_scene_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files),  cmocka_unit_test(settings),         cmocka_unit_test(sensors),
        cmocka_unit_test(counts), cmocka_unit_test(instruction_sets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
