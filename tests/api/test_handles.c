/* SPDX-License-Identifier: Apache-2.0 */
/* Contexts, images, scenes and path tracing through the public header: life cycles and every way
 * to fail. */
#include "api_test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static void test_context(void **state)
{
    (void)state;
    lmn_context *context = NULL;
    char message[64] = "x";
    lmn_info info;
    assert_int_equal(lmn_context_new(NULL, &context, NULL, 0), LMN_OK);
    lmn_context_info(context, &info);
    assert_true(info.threads >= 1);
    assert_string_equal(info.cpu_used, info.cpu_detected);
    assert_string_equal(info.version, "0.1.0");
    assert_string_equal(lmn_context_message(context), "");
    lmn_context_free(context);

    lmn_context_options options = {.struct_size = sizeof options, .threads = 3, .cpu = "baseline"};
    assert_int_equal(lmn_context_new(&options, &context, message, sizeof message), LMN_OK);
    lmn_context_info(context, &info);
    assert_int_equal(info.threads, 3);
    assert_string_equal(info.cpu_used, "baseline");
    lmn_context_free(context);

    options.cpu = "mmx";
    assert_int_equal(lmn_context_new(&options, &context, message, sizeof message),
                     LMN_ERR_ARGUMENT);
    assert_null(context);
    assert_non_null(strstr(message, "mmx"));
    /* a message that does not fit is cut, not overrun */
    char tiny[4];
    assert_int_equal(lmn_context_new(&options, &context, tiny, sizeof tiny), LMN_ERR_ARGUMENT);
    assert_int_equal(strlen(tiny), 3);
    options.struct_size = 0;
    assert_int_equal(lmn_context_new(&options, &context, message, sizeof message),
                     LMN_ERR_ARGUMENT);
}

/* Structs of options may grow: an old caller's is shorter, a newer caller's longer. */
static void test_struct_size(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    lmn_scene *scene = load_scene(context);
    lmn_image *image = NULL;
    struct {
        lmn_trace_options options;
        uint64_t future[2];
    } o = {.options = {.width = 8, .height = 8, .spp = 1}};
    o.options.struct_size = sizeof o;
    EXPECT(context, lmn_scene_trace(context, scene, NULL, &o.options, &image, NULL), LMN_OK);
    lmn_image_free(image);
    o.future[1] = 1;
    EXPECT(context, lmn_scene_trace(context, scene, NULL, &o.options, &image, NULL),
           LMN_ERR_ARGUMENT);
    assert_null(image);
    /* what lies behind the size that is claimed is not looked at */
    o.options.struct_size = offsetof(lmn_trace_options, spp);
    o.options.mis = (const char *)1;
    EXPECT(context, lmn_scene_trace(context, scene, NULL, &o.options, &image, NULL), LMN_OK);
    assert_int_equal(lmn_image_width(image), 8);
    lmn_image_free(image);
    lmn_scene_free(scene);
    lmn_context_free(context);
}

static void test_image(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    lmn_image *image = NULL, *again = NULL, *map = NULL;
    lmn_metrics m;
    const char *names[4] = {"R", "G", "B", "depth.Z"};
    char path[] = "/tmp/lumenaut-api-XXXXXX.exr";
    const int fd = mkstemps(path, 4);
    assert_true(fd >= 0);
    close(fd);
    EXPECT(context, lmn_image_new(context, 12, 16, 4, names, &image), LMN_OK);
    assert_int_equal(lmn_image_width(image), 12);
    assert_int_equal(lmn_image_height(image), 16);
    assert_int_equal(lmn_image_n_channels(image), 4);
    assert_string_equal(lmn_image_channel_name(image, 3), "depth.Z");
    assert_null(lmn_image_channel_name(image, 4));
    float *data = lmn_image_data(image);
    for (int i = 0; i < 12 * 16 * 4; i++) data[i] = (float)(i % 32) / 32.0f;
    EXPECT(context, lmn_image_set_attribute(context, image, "note", "made by a test"), LMN_OK);
    EXPECT(context, lmn_image_save(context, image, path, NULL, 1.0), LMN_OK);
    EXPECT(context, lmn_image_load(context, path, &again), LMN_OK);
    assert_int_equal(lmn_image_n_channels(again), 4);
    EXPECT(context, lmn_image_compare(context, again, image, &m, &map), LMN_OK);
    const lmn_image *const tests[] = {again, image}, *const references[] = {image, image};
    lmn_metrics all[2];
    EXPECT(context, lmn_image_compare_all(context, 2, tests, references, all), LMN_OK);
    assert_memory_equal(&all[0], &m, sizeof m);
    assert_true(all[1].mae == 0.0);
    assert_true(m.mse == 0.0 && isinf(m.psnr));
    assert_int_equal(lmn_image_width(map), 12);
    lmn_image_free(map);
    lmn_image_free(again);

    EXPECT(context, lmn_image_new(context, 10, 16, 3, NULL, &again), LMN_OK);
    EXPECT(context, lmn_image_compare(context, again, image, &m, &map), LMN_ERR_ARGUMENT);
    assert_null(map);
    const lmn_image *const wrong[] = {image, again};
    EXPECT(context, lmn_image_compare_all(context, 2, wrong, references, all), LMN_ERR_ARGUMENT);
    assert_true(strlen(lmn_context_message(context)) > 0);
    lmn_image_free(again);
    assert_int_not_equal(lmn_image_new(context, 0, 1, 3, NULL, &again), LMN_OK);
    assert_null(again);
    assert_int_not_equal(lmn_image_new(context, UINT32_MAX, UINT32_MAX, 3, NULL, &again), LMN_OK);
    assert_null(again);
    EXPECT(context, lmn_image_save(context, image, "/nowhere/at/all.exr", NULL, 1.0), LMN_ERR_IO);
    assert_int_not_equal(lmn_image_save(context, image, path, "bmp", 1.0), LMN_OK);
    assert_true(strlen(lmn_context_message(context)) > 0);
    EXPECT(context, lmn_image_load(context, "/nowhere/at/all.exr", &again), LMN_ERR_IO);
    assert_non_null(strstr(lmn_context_message(context), "/nowhere/at/all.exr"));
    assert_null(again);
    lmn_image_free(image);
    unlink(path);
    lmn_context_free(context);
}

static void test_scene(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    lmn_scene *scene = (lmn_scene *)1;
    lmn_scene_info info;
    lmn_variable_info v;
    lmn_parameter_info p;
    EXPECT(context, lmn_scene_load(context, "/nowhere/scene.xml", NULL, &scene), LMN_ERR_IO);
    assert_null(scene);
    const char *defines[1] = {"spp=32"};
    lmn_scene_options options = {.struct_size = sizeof options, .n_defines = 1, .defines = defines};
    EXPECT(context, lmn_scene_load(context, SCENE, &options, &scene), LMN_OK);
    lmn_scene_get_info(scene, &info);
    assert_int_equal(info.spp, 32);
    assert_int_equal(info.n_variables, 6);
    assert_int_equal(info.n_triangles, 18);
    assert_string_equal(info.path, SCENE);
    for (uint32_t i = 0; i < info.n_variables; i++) {
        assert_int_equal(lmn_scene_get_variable(scene, i, &v), LMN_OK);
        assert_true(v.name && v.group && v.kind && v.unit && v.targets);
        assert_true(v.n_choices > 0 || (v.min <= v.value && v.value <= v.max));
    }
    assert_int_equal(lmn_scene_get_variable(scene, info.n_variables, &v), LMN_ERR_ARGUMENT);
    for (uint32_t i = 0; i < info.n_parameters; i++) {
        assert_int_equal(lmn_scene_get_parameter(scene, i, &p), LMN_OK);
        assert_true(p.path && p.type && p.value);
    }
    assert_int_equal(lmn_scene_get_parameter(scene, info.n_parameters, &p), LMN_ERR_ARGUMENT);

    double values[6], drawn[6], again[6];
    lmn_scene_default_values(scene, values);
    assert_true(values[0] == 0.0 && values[5] == 1.0);
    EXPECT(context, lmn_scene_parse_value(context, scene, "slide=75%", values), LMN_OK);
    assert_true(fabs(values[0] - 0.5) < 1e-6);
    EXPECT(context, lmn_scene_parse_value(context, scene, "tint=0.1,0.2,0.3", values), LMN_OK);
    assert_true(fabs(values[3] - 0.3) < 1e-6);
    memcpy(again, values, sizeof values);
    EXPECT(context, lmn_scene_parse_value(context, scene, "tint=0.5,0.5,7", values),
           LMN_ERR_ARGUMENT);
    EXPECT(context, lmn_scene_parse_value(context, scene, "", values), LMN_ERR_ARGUMENT);
    EXPECT(context, lmn_scene_parse_value(context, scene, "shown=nan", values), LMN_ERR_ARGUMENT);
    assert_memory_equal(values, again, sizeof values);
    for (uint64_t i = 0; i < 100; i++) {
        lmn_scene_random_values(scene, 7, i, drawn);
        assert_true(drawn[0] >= -1.0 && drawn[0] <= 1.0 && (drawn[5] == 0.0 || drawn[5] == 1.0));
        lmn_scene_random_values(scene, 7, i, again);
        assert_memory_equal(drawn, again, sizeof drawn);
    }
    lmn_scene_free(scene);
    defines[0] = "sqq=1";
    assert_int_not_equal(lmn_scene_load(context, SCENE, &options, &scene), LMN_OK);
    assert_null(scene);
    assert_non_null(strstr(lmn_context_message(context), "spp"));
    lmn_context_free(context);
}

static lmn_status trace(lmn_context *context, const lmn_scene *scene, const double *values,
                        const lmn_trace_options *options)
{
    lmn_image *image = (lmn_image *)1;
    const lmn_status status = lmn_scene_trace(context, scene, values, options, &image, NULL);
    assert_true((status == LMN_OK) == (image != NULL));
    lmn_image_free(image);
    return status;
}

static void test_trace_errors(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    lmn_scene *scene = load_scene(context);
    const lmn_trace_options good = {.struct_size = sizeof good, .width = 8, .height = 8, .spp = 1};
    lmn_trace_options o = good;
    double values[6];
    EXPECT(context, trace(context, scene, NULL, &o), LMN_OK);
    o.width = 0; /* without height */
    EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
    o = good;
    o.width = 40000;
    EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
    o = good;
    o.crop_x = UINT32_MAX;
    o.crop_width = o.crop_height = 2;
    EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
    o = good;
    o.crop_width = 3; /* without height */
    EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
    o = good;
    o.sampler = "random";
    EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(lmn_context_message(context), "sobol"));
    o = good;
    o.mis = "none";
    EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
    o = good;
    o.integrator = "photons";
    EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(lmn_context_message(context), "auto, path or path+photons"));
    o = good;
    o.light_group_names = "all=lmp";
    EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(lmn_context_message(context), "no emitter \"lmp\""));
    o = good;
    o.has_max_depth = 1;
    o.max_depth = -2;
    EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
    o = good;
    o.follow_delta = 1; /* without buffers */
    EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(lmn_context_message(context), "buffers"));
    const double wrong[] = {NAN, INFINITY, 1.5, -1.5};
    for (size_t i = 0; i < 4; i++) {
        lmn_scene_default_values(scene, values);
        values[0] = wrong[i];
        EXPECT(context, trace(context, scene, values, &good), LMN_ERR_ARGUMENT);
        assert_non_null(strstr(lmn_context_message(context), "slide"));
    }
    lmn_scene_free(scene);
    lmn_context_free(context);
}

/* A picture says what it was traced with; the scene is left to choose by NULL. */
static void test_integrators(void **state)
{
    (void)state;
    static const char *const asked[] = {"path", "path+photons", "auto", NULL};
    lmn_context *context = new_context(1);
    lmn_scene *scene = load_scene(context);
    for (size_t i = 0; i < 4; i++) {
        lmn_image *image = NULL;
        const lmn_trace_options o = {
            .struct_size = sizeof o, .width = 8, .height = 8, .spp = 3, .integrator = asked[i]};
        EXPECT(context, lmn_scene_trace(context, scene, NULL, &o, &image, NULL), LMN_OK);
        const char *used = lmn_image_attribute(image, "integrator");
        const char *spp = lmn_image_attribute(image, "spp");
        assert_true(used && spp && !lmn_image_attribute(image, "nothing"));
        if (i < 2) assert_string_equal(used, asked[i]);
        assert_string_equal(spp, strcmp(used, "path") == 0 ? "3" : "4"); /* two equal halves */
        lmn_image_free(image);
    }
    lmn_scene_free(scene);
    lmn_context_free(context);
}

static lmn_image *picture(lmn_context *context, const lmn_scene *scene,
                          const lmn_trace_options *options)
{
    lmn_image *image = NULL;
    EXPECT(context, lmn_scene_trace(context, scene, NULL, options, &image, NULL), LMN_OK);
    return image;
}

/* Mean |a - b| over that of b. */
static double difference(lmn_image *a, lmn_image *b)
{
    const size_t n = (size_t)lmn_image_width(a) * lmn_image_height(a) * lmn_image_n_channels(a);
    double off = 0, level = 0;
    for (size_t i = 0; i < n; i++) {
        off += fabs((double)lmn_image_data(a)[i] - (double)lmn_image_data(b)[i]);
        level += fabs((double)lmn_image_data(b)[i]);
    }
    return off / level;
}

/* A camera of one's own: the scene's gives the scene's picture, others are refused or seen by. */
static void test_camera(void **state)
{
    (void)state;
    lmn_context *context = new_context(2);
    lmn_scene *scene = load_scene(context);
    lmn_camera camera;
    lmn_trace_options o = {.struct_size = sizeof o, .spp = 4, .integrator = "path"};
    double values[6];
    EXPECT(context, lmn_scene_get_camera(context, scene, NULL, &camera), LMN_OK);
    assert_true(camera.origin[2] == 5.0 && camera.fov == 45.0 && camera.target[2] < 3.0);
    lmn_image *own = picture(context, scene, &o);
    assert_null(lmn_image_attribute(own, "camera"));
    o.camera = &camera;
    lmn_image *same = picture(context, scene, &o);
    assert_true(difference(same, own) < 0.01);
    assert_non_null(strstr(lmn_image_attribute(same, "camera"), "origin 0,1.5,5 target "));
    camera.fov = 30;
    lmn_image *nearer = picture(context, scene, &o);
    assert_true(difference(nearer, own) > 0.1);
    camera.fov = 200;
    EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(lmn_context_message(context), "fov 200"));
    o.camera = NULL;
    lmn_image *back = picture(context, scene, &o);
    assert_true(difference(back, own) == 0);
    lmn_scene_default_values(scene, values);
    values[0] = NAN;
    EXPECT(context, lmn_scene_get_camera(context, scene, values, &camera), LMN_ERR_ARGUMENT);
    lmn_image *const all[] = {own, same, nearer, back};
    for (size_t i = 0; i < 4; i++) lmn_image_free(all[i]);
    lmn_scene_free(scene);
    lmn_context_free(context);
}

/* Parts of a picture are its samples; with photons they have those of later passes. */
static void test_first_sample(void **state)
{
    (void)state;
    static const char *const integrators[] = {"path", "path+photons"};
    lmn_context *context = new_context(2);
    lmn_scene *scene = load_scene(context);
    for (size_t k = 0; k < 2; k++) {
        const uint32_t spp = k == 0 ? 4 : 32; /* a pass of photons */
        lmn_trace_options o = {.struct_size = sizeof o, .integrator = integrators[k]};
        o.spp = 2 * spp;
        lmn_image *whole = picture(context, scene, &o);
        o.spp = spp;
        lmn_image *first = picture(context, scene, &o);
        o.first_sample = spp;
        lmn_image *second = picture(context, scene, &o);
        assert_true(difference(first, second) > 0.01);
        const size_t n = (size_t)lmn_image_width(whole) * lmn_image_height(whole) * 3;
        for (size_t i = 0; i < n; i++)
            lmn_image_data(first)[i] = 0.5f * lmn_image_data(first)[i] +
                                       0.5f * lmn_image_data(second)[i];
        const double off = difference(first, whole);
        if (!(off < (k == 0 ? 1e-6 : 0.01))) fail_msg("%s: off by %g", integrators[k], off);
        o.first_sample = 1;
        EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
        o.first_sample = UINT32_MAX - 1;
        EXPECT(context, trace(context, scene, NULL, &o), LMN_ERR_ARGUMENT);
        lmn_image_free(whole);
        lmn_image_free(first);
        lmn_image_free(second);
    }
    lmn_scene_free(scene);
    lmn_context_free(context);
}

/* A picture in two parts: names and sums. */
static void test_split(void **state)
{
    (void)state;
    static const char *const names[] = {"R",      "G",      "B",      "rest.R", "rest.G",
                                        "rest.B", "seen.R", "seen.G", "seen.B"};
    lmn_context *context = new_context(1);
    lmn_scene *scene = load_scene(context);
    lmn_image *image = NULL;
    const lmn_trace_options o = {
        .struct_size = sizeof o, .width = 24, .height = 16, .spp = 8, .split_delta = 1};
    EXPECT(context, lmn_scene_trace(context, scene, NULL, &o, &image, NULL), LMN_OK);
    assert_int_equal(lmn_image_n_channels(image), 9);
    double rest = 0, seen = 0;
    for (uint32_t c = 0; c < 9; c++)
        assert_string_equal(lmn_image_channel_name(image, c), names[c]);
    for (size_t i = 0; i < 24 * 16; i++)
        for (size_t c = 0; c < 3; c++) {
            const float *p = lmn_image_data(image) + 9 * i + c;
            assert_true(p[0] == p[3] + p[6]);
            rest += p[3];
            seen += p[6];
        }
    assert_true(rest > 0 && seen >= 0); /* the lamp is behind the camera */
    lmn_image_free(image);
    lmn_scene_free(scene);
    lmn_context_free(context);
}

static int stop_at_once(void *user, double done, double total)
{
    (void)done;
    (void)total;
    ++*(int *)user;
    return 1;
}

static void test_cancel(void **state)
{
    (void)state;
    int calls = 0;
    const lmn_context_options options = {.struct_size = sizeof options,
                                         .threads = 2,
                                         .progress = stop_at_once,
                                         .progress_user = &calls};
    lmn_context *context = NULL;
    assert_int_equal(lmn_context_new(&options, &context, NULL, 0), LMN_OK);
    lmn_scene *scene = load_scene(context);
    const lmn_trace_options o = {.struct_size = sizeof o, .width = 256, .height = 256, .spp = 4};
    assert_int_equal(trace(context, scene, NULL, &o), LMN_ERR_CANCELLED);
    assert_true(calls > 0);
    lmn_scene_free(scene);
    lmn_context_free(context);
}

static void test_free_null(void **state)
{
    (void)state;
    lmn_context_free(NULL);
    lmn_image_free(NULL);
    lmn_scene_free(NULL);
    lmn_trainer_free(NULL);
    lmn_model_free(NULL);
    lmn_model_info_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_context),      cmocka_unit_test(test_struct_size),
        cmocka_unit_test(test_image),        cmocka_unit_test(test_scene),
        cmocka_unit_test(test_trace_errors), cmocka_unit_test(test_integrators),
        cmocka_unit_test(test_camera),       cmocka_unit_test(test_first_sample),
        cmocka_unit_test(test_split),        cmocka_unit_test(test_cancel),
        cmocka_unit_test(test_free_null),
    };
    return cmocka_run_group_tests_name("api_handles", tests, NULL, NULL);
}
