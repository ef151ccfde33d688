/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures with known answers. */
#include <math.h>

#include "base/mem.h"
#include "made_scene.h"
#include "math/warp.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

static double traced_mean(struct made_scene *m, const struct trace_settings *t)
{
    float *rgb = made_trace(m, t);
    double mean = made_mean(rgb, m);
    mem_free(rgb);
    return mean;
}

static void near(double value, double expected, double relative)
{
    if (!(fabs(value - expected) <= relative * fabs(expected)))
        fail_msg("%.6f instead of %.6f", value, expected);
}

/* Inside a sphere that shines with radiance 1 and reflects the part a, every point has radiance
 * 1 + a + a^2 + ..., cut off by the depth. */
static void furnace(void **state)
{
    (void)state;
    struct made_scene *m = made_scene_new();
    uint32_t grey = made_diffuse(m, vec3_splat(0.6f));
    uint32_t light = made_emitter(m, EMITTER_AREA, vec3_splat(1.0f));
    uint32_t s = made_sphere(m, vec3(0, 0, 0), 2.0f, grey, light);
    m->shapes[s].flip_normals = true;
    made_camera(m, vec3(0, 0, 0.5f), vec3(1, 0.2f, 0), 60, 16, 16);
    made_view(m);
    for (int depth = 1; depth <= 4; depth++) {
        struct trace_settings t = made_settings(m, depth, 64);
        near(traced_mean(m, &t), (1 - pow(0.6, depth)) / 0.4, depth == 1 ? 1e-6 : 5e-3);
    }
    struct trace_settings t = made_settings(m, -1, 64);
    t.rr_depth = 3;
    near(traced_mean(m, &t), 1 / 0.4, 1e-2);
    t.sampler = SAMPLER_SOBOL;
    near(traced_mean(m, &t), 1 / 0.4, 1e-2);
    t.mis = MIS_BALANCE;
    near(traced_mean(m, &t), 1 / 0.4, 1e-2);
    made_scene_free(m);
}

/* The same with light from around: a grey sphere that sees only a constant environment. */
static void furnace_environment(void **state)
{
    (void)state;
    struct made_scene *m = made_scene_new();
    uint32_t grey = made_diffuse(m, vec3_splat(0.7f));
    made_emitter(m, EMITTER_CONSTANT, vec3(1, 2, 3));
    made_sphere(m, vec3(0, 0, 0), 1.0f, grey, SCENE_NONE);
    made_camera(m, vec3(0, 0, 3), vec3(0, 0, 0), 10, 8, 8);
    made_view(m);
    struct trace_settings t = made_settings(m, -1, 64);
    near(traced_mean(m, &t), 0.7 * 2, 5e-3);
    made_scene_free(m);
}

/* A point light above a plane: E = I cos^3 / h^2, L = E rho / pi. */
static void point_light(void **state)
{
    (void)state;
    struct made_scene *m = made_scene_new();
    uint32_t grey = made_diffuse(m, vec3_splat(0.5f));
    made_point(m, vec3(0, 2, 0), vec3_splat(10.0f));
    made_quad(m, vec3(-50, 0, 50), vec3(100, 0, 0), vec3(0, 0, -100), grey, SCENE_NONE);
    made_camera(m, vec3(1, 4, 0), vec3(1, 0, 0), 0.01f, 2, 2);
    made_view(m);
    struct trace_settings t = made_settings(m, 2, 4);
    double cosine = 2 / sqrt(5.0);
    near(traced_mean(m, &t), 10 * cosine / 5 * 0.5 / 3.14159265, 1e-4);
    made_scene_free(m);
}

/* A plane under a parallel unit square at distance 1: the irradiance below its centre is pi times
 * the form factor 4 F(1/2, 1/2) with F(a, b) of a corner. */
static void area_light(void **state)
{
    (void)state;
    double x = 0.5 / sqrt(1.25);
    double form = 4 / (2 * 3.14159265358979) * 2 * x * atan(x);
    for (int kind = 0; kind < 3; kind++) { /* as it is; scaled by an instance; seen from behind */
        struct made_scene *m = made_scene_new();
        uint32_t grey = made_diffuse(m, vec3_splat(0.5f)), black = made_diffuse(m, vec3_splat(0));
        uint32_t light = made_emitter(m, EMITTER_AREA, vec3_splat(3.0f));
        made_quad(m, vec3(-50, 0, 50), vec3(100, 0, 0), vec3(0, 0, -100), grey, SCENE_NONE);
        if (kind == 0) {
            made_quad(m, vec3(-0.5f, 1, -0.5f), vec3(1, 0, 0), vec3(0, 0, 1), black, light);
        } else {
            made_group(m);
            made_quad(m, vec3(-1, 0, -1), vec3(2, 0, 0), vec3(0, 0, 2), black, light);
            struct transform scale = transform_scale(vec3(0.25f, 1, 0.25f)),
                             up = transform_translate(vec3(0, 1, 0)), both;
            scale = transform_scale(kind == 1 ? vec3(0.25f, 3, 0.25f) : vec3(0.25f, -1, 0.25f));
            if (kind == 1) m->meshes[1].positions[3] = 1; /* keeps 2 x 2 */
            both = transform_mul(&up, &scale);
            made_instance(m, 1, &both);
        }
        made_camera(m, vec3(3, 1, 0), vec3(0, 0, 0), 0.01f, 8, 8);
        made_view(m);
        struct trace_settings t = made_settings(m, 2, 256);
        double expected = 3 * form * 0.5 * (kind == 0 ? 1 : 1);
        if (kind > 0) { /* 2 x 2 scaled by 1/4: half as wide */
            double y = 0.25 / sqrt(1.0625);
            expected = 3 * (4 / (2 * 3.14159265358979) * 2 * y * atan(y)) * 0.5;
        }
        double mean = traced_mean(m, &t);
        if (kind == 2)
            assert_true(mean == 0.0);
        else
            near(mean, expected, 5e-3);
        made_scene_free(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(furnace),
        cmocka_unit_test(furnace_environment),
        cmocka_unit_test(point_light),
        cmocka_unit_test(area_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
