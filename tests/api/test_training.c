/* SPDX-License-Identifier: Apache-2.0 */
/* Training and models through the public header: a small run, its files, and every way to fail. */
#include "api_test.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static char folder[] = "/tmp/lumenaut-api-XXXXXX";
static char model_path[64], metrics_path[64], other_path[64], svg_path[64];
static char state_path[72], other_state_path[72];

static int make_folder(void **state)
{
    (void)state;
    if (!mkdtemp(folder)) return -1;
    snprintf(model_path, sizeof model_path, "%s/m.lmn", folder);
    snprintf(metrics_path, sizeof metrics_path, "%s/m.metrics.jsonl", folder);
    snprintf(other_path, sizeof other_path, "%s/other.lmn", folder);
    snprintf(state_path, sizeof state_path, "%s.state", model_path);
    snprintf(other_state_path, sizeof other_state_path, "%s.state", other_path);
    snprintf(svg_path, sizeof svg_path, "%s/m.svg", folder);
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    unlink(model_path);
    unlink(metrics_path);
    unlink(other_path);
    unlink(state_path);
    unlink(other_state_path);
    unlink(svg_path);
    return rmdir(folder);
}

static lmn_train_options small_options(void)
{
    lmn_train_options o;
    lmn_train_options_init(&o);
    o.width = 8;
    o.depth = 1;
    o.patch_size = 12;
    o.resolution_start = 24;
    o.n_chains = 2;
    o.memory_mib = 4;
    o.spp = 1;
    return o;
}

static void test_options(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    lmn_scene *scene = load_scene(context);
    lmn_trainer *trainer = (lmn_trainer *)1;
    lmn_train_options o = small_options(), used;
    lmn_train_stats stats;
    assert_true(o.learning_rate == 1e-4 && o.large_step == 0.3 && o.reuse_bias == 4.6);
    o.width = 0;
    EXPECT(context, lmn_trainer_new(context, scene, &o, &trainer), LMN_ERR_ARGUMENT);
    assert_null(trainer);
    o = small_options();
    o.step_min = 0.2;
    o.step_max = 0.1;
    EXPECT(context, lmn_trainer_new(context, scene, &o, &trainer), LMN_ERR_ARGUMENT);
    o = small_options();
    o.explore = 17;
    EXPECT(context, lmn_trainer_new(context, scene, &o, &trainer), LMN_ERR_ARGUMENT);
    o = small_options();
    o.struct_size = 0;
    EXPECT(context, lmn_trainer_new(context, scene, &o, &trainer), LMN_ERR_ARGUMENT);

    /* an older caller's shorter struct: the rest has defaults */
    o = small_options();
    o.struct_size = offsetof(lmn_train_options, spp);
    EXPECT(context, lmn_trainer_new(context, scene, &o, &trainer), LMN_OK);
    lmn_trainer_get_options(trainer, &used);
    assert_int_equal(used.width, 8);
    assert_int_equal(used.spp, 0);
    lmn_trainer_get_stats(trainer, &stats);
    assert_int_equal(stats.step, 0);
    lmn_trainer_free(trainer);
    lmn_scene_free(scene);
    lmn_context_free(context);
}

/* Options by name, and as JSON. */
static void test_named_options(void **state)
{
    static const char *const bad[] = {"spp",    "spp=",      "=4",
                                      "spp=x",  "spp=1.5",   "spp=4 ",
                                      "with=4", "explore=3", "learning_rate=nan",
                                      "seed=-1"};
    (void)state;
    lmn_context *context = new_context(1);
    lmn_train_options o, before;
    const char *json = NULL;
    lmn_train_options_init(&o);
    EXPECT(context, lmn_train_options_set(context, &o, "spp=4"), LMN_OK);
    EXPECT(context, lmn_train_options_set(context, &o, "learning_rate=2.5e-3"), LMN_OK);
    EXPECT(context, lmn_train_options_set(context, &o, "max_depth=-1"), LMN_OK);
    EXPECT(context, lmn_train_options_set(context, &o, "seed=12345678901"), LMN_OK);
    assert_int_equal(o.spp, 4);
    assert_int_equal(o.max_depth, -1);
    assert_true(o.learning_rate == 2.5e-3 && o.seed == 12345678901u);
    EXPECT(context, lmn_train_options_json(context, &o, &json), LMN_OK);
    assert_non_null(strstr(json, "\"seed\":12345678901,"));
    assert_non_null(strstr(json, "\"spp\":4,"));
    before = o;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        EXPECT(context, lmn_train_options_set(context, &o, bad[i]), LMN_ERR_ARGUMENT);
        assert_memory_equal(&o, &before, sizeof o);
    }
    EXPECT(context, lmn_train_options_set(context, &o, "with=4"), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(lmn_context_message(context), "did you mean \"width\"?"));
    o.width = 0;
    EXPECT(context, lmn_train_options_json(context, &o, &json), LMN_ERR_ARGUMENT);
    assert_null(json);
    lmn_context_free(context);
}

/* Trains the file that the next tests use. */
static void test_train(void **state)
{
    (void)state;
    lmn_context *context = new_context(2);
    lmn_scene *scene = load_scene(context);
    lmn_trainer *trainer = NULL, *resumed = NULL;
    lmn_train_stats stats;
    lmn_metrics metrics;
    const lmn_train_options o = small_options();
    EXPECT(context, lmn_trainer_new(context, scene, &o, &trainer), LMN_OK);
    FILE *f = fopen(metrics_path, "w");
    assert_non_null(f);
    fprintf(f, "%s\n", lmn_trainer_metrics_line(trainer));
    for (uint64_t step = 1; step <= 5; step++) {
        EXPECT(context, lmn_trainer_step(trainer, &stats), LMN_OK);
        assert_int_equal(stats.step, step);
        assert_true(stats.loss > 0.0 && stats.cpu_s > 0.0 && stats.memory_bytes > 0);
        fprintf(f, "%s\n", lmn_trainer_metrics_line(trainer));
    }
    fclose(f);
    EXPECT(context, lmn_trainer_eval(trainer, 2, 16, 2, 0, &metrics), LMN_OK);
    assert_true(metrics.mape > 0.0);
    const lmn_render_options render = {.struct_size = sizeof render, .width = 12, .height = 8};
    lmn_image *now = NULL, *saved = NULL;
    lmn_model *model = NULL;
    EXPECT(context, lmn_trainer_render(trainer, NULL, &render, &now, NULL), LMN_OK);
    EXPECT(context, lmn_trainer_save(trainer, "/nowhere/m.lmn"), LMN_ERR_IO);
    EXPECT(context, lmn_trainer_save(trainer, model_path), LMN_OK);
    EXPECT(context, lmn_model_load(context, scene, model_path, 0, &model), LMN_OK);
    EXPECT(context, lmn_model_render(context, model, NULL, &render, &saved, NULL), LMN_OK);
    assert_memory_equal(lmn_image_data(now), lmn_image_data(saved), sizeof(float[12 * 8 * 3]));
    const lmn_image *const pictures[] = {now, saved};
    lmn_sheet sheet = {.struct_size = sizeof sheet,
                       .n_rows = 1,
                       .n_columns = 2,
                       .n_pictures = 2,
                       .images = pictures,
                       .headings = (const char *const[]){"now", "saved"},
                       .captions = (const char *const[]){"the same"},
                       .exposures = &(const double){1.0}};
    lmn_image *drawn = NULL;
    EXPECT(context, lmn_image_sheet(context, &sheet, &drawn), LMN_OK);
    assert_true(lmn_image_width(drawn) > 24);
    lmn_image_free(drawn);
    sheet.n_pictures = 3;
    EXPECT(context, lmn_image_sheet(context, &sheet, &drawn), LMN_ERR_ARGUMENT);
    assert_null(drawn);
    lmn_image_free(now);
    lmn_image_free(saved);
    lmn_model_free(model);
    EXPECT(context, lmn_trainer_resume(context, scene, model_path, 0, &resumed), LMN_OK);
    lmn_trainer_get_stats(resumed, &stats);
    assert_int_equal(stats.step, 5);
    assert_true(stats.cpu_s > 0.0);
    EXPECT(context, lmn_trainer_step(resumed, NULL), LMN_OK);
    lmn_trainer_free(resumed);
    lmn_trainer_free(trainer);
    EXPECT(context, lmn_trainer_resume(context, scene, "/nowhere/m.lmn", 0, &resumed), LMN_ERR_IO);
    assert_null(resumed);
    lmn_scene_free(scene);
    lmn_context_free(context);
}

static void test_model(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    lmn_scene *scene = load_scene(context);
    lmn_model *model = NULL;
    lmn_model_info info;
    lmn_image *image = NULL, *sheet = NULL;
    lmn_eval_result result;
    lmn_metrics each[2];
    EXPECT(context, lmn_model_read_info(context, model_path, &info), LMN_OK);
    assert_string_equal(info.scene_path, SCENE);
    assert_int_equal(info.step, 5);
    assert_true(info.n_weights > 0 && info.n_defines == 0);
    lmn_model_info_free(&info);
    EXPECT(context, lmn_model_load(context, scene, model_path, 0, &model), LMN_OK);
    lmn_render_options o = {.struct_size = sizeof o, .width = 16, .height = 12, .buffers = 1};
    EXPECT(context, lmn_model_render(context, model, NULL, &o, &image, NULL), LMN_OK);
    assert_int_equal(lmn_image_width(image), 16);
    assert_true(lmn_image_n_channels(image) > 3);
    lmn_image_free(image);
    o.crop_width = 17;
    o.crop_height = 1;
    EXPECT(context, lmn_model_render(context, model, NULL, &o, &image, NULL), LMN_ERR_ARGUMENT);
    assert_null(image);
    const lmn_eval_options e = {.struct_size = sizeof e, .n = 2, .resolution = 16, .spp = 2};
    EXPECT(context, lmn_model_eval(context, model, &e, &result, each, &sheet), LMN_OK);
    assert_true(result.mean.mape > 0.0 && result.noise.mape > 0.0 && each[1].mape > 0.0);
    assert_true(lmn_image_width(sheet) >= 3 * 16);
    lmn_image_free(sheet);
    lmn_model_free(model);
    EXPECT(context, lmn_plot(context, (const char *[]){model_path, model_path}, 2, svg_path),
           LMN_OK);
    EXPECT(context, lmn_plot(context, NULL, 0, svg_path), LMN_ERR_ARGUMENT);
    lmn_scene_free(scene);
    lmn_context_free(context);
}

/* A training starts from a model of the improved method, and from no other. */
static void test_start_from(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    lmn_scene *scene = load_scene(context);
    lmn_trainer *trainer = NULL;
    lmn_model_info info;
    lmn_train_options o;
    const char *report = NULL;
    lmn_train_options_init_method(&o, LMN_METHOD_IMPROVED);
    o.width = 8;
    o.depth = 1;
    o.memory_mib = 2;
    o.resolution_max = 16;
    o.spp = 1;
    EXPECT(context, lmn_trainer_new(context, scene, &o, &trainer), LMN_OK);
    EXPECT(context, lmn_trainer_start_from(trainer, model_path, &report), LMN_ERR_ARGUMENT);
    EXPECT(context, lmn_trainer_start_from(trainer, "/nowhere/m.lmn", &report), LMN_ERR_IO);
    assert_null(report);
    EXPECT(context, lmn_trainer_step(trainer, NULL), LMN_OK);
    EXPECT(context, lmn_trainer_save(trainer, other_path), LMN_OK);
    EXPECT(context, lmn_trainer_start_from(trainer, other_path, &report), LMN_ERR_ARGUMENT);
    lmn_trainer_free(trainer);
    EXPECT(context, lmn_model_read_info(context, other_path, &info), LMN_OK);
    assert_int_equal(info.method, LMN_METHOD_IMPROVED);
    assert_true(info.width == 8 && info.depth == 1);
    lmn_model_info_free(&info);
    EXPECT(context, lmn_trainer_new(context, scene, &o, &trainer), LMN_OK);
    EXPECT(context, lmn_trainer_start_from(trainer, other_path, NULL), LMN_OK);
    EXPECT(context, lmn_trainer_start_from(trainer, other_path, &report), LMN_OK);
    assert_non_null(strstr(report, "taken over: grid of the scene\n"));
    lmn_trainer_free(trainer);
    lmn_scene_free(scene);
    lmn_context_free(context);
}

/* Another scene under the model: refused, unless forced; never with other variables. */
static void test_changed_scene(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    const char *defines[1] = {"spp=16"};
    const lmn_scene_options options = {
        .struct_size = sizeof options, .n_defines = 1, .defines = defines};
    lmn_scene *scene = NULL;
    lmn_model *model = NULL;
    lmn_trainer *trainer = NULL;
    EXPECT(context, lmn_scene_load(context, SCENE, &options, &scene), LMN_OK);
    lmn_scene_info info;
    lmn_scene_get_info(scene, &info);
    const lmn_status status = lmn_model_load(context, scene, model_path, 0, &model);
    if (status != LMN_OK) { /* samples per pixel are part of what makes an image */
        assert_null(model);
        assert_non_null(strstr(lmn_context_message(context), "changed"));
        assert_int_not_equal(lmn_trainer_resume(context, scene, model_path, 0, &trainer), LMN_OK);
        assert_null(trainer);
        EXPECT(context, lmn_model_load(context, scene, model_path, 1, &model), LMN_OK);
    }
    lmn_model_free(model);
    lmn_scene_free(scene);
    lmn_context_free(context);
}

/* Cut off, or a bit of the first bytes flipped, mostly the header's. */
static void copy_broken(const char *from, size_t i, const char *to)
{
    static unsigned char bytes[1 << 21];
    FILE *f = fopen(from, "rb");
    assert_non_null(f);
    size_t size = fread(bytes, 1, sizeof bytes, f);
    fclose(f);
    assert_true(size > 1000 && size < sizeof bytes);
    if (i < 40)
        size = i * size / 40;
    else
        bytes[(i - 40) * 37 % 4000] ^= (unsigned char)(1u << (i % 8));
    f = fopen(to, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    fclose(f);
}

static void test_broken_files(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    lmn_scene *scene = load_scene(context);
    lmn_model *model = NULL;
    lmn_trainer *trainer = NULL;
    lmn_model_info info;
    for (size_t i = 0; i < 200; i++) {
        copy_broken(model_path, i, other_path);
        copy_broken(state_path, i, other_state_path);
        /* Whatever comes of a flipped bit, nothing crashes, and a failure is told. */
        const lmn_status status = lmn_model_load(context, scene, other_path, 0, &model);
        assert_true((status == LMN_OK) == (model != NULL));
        assert_true((status == LMN_OK) == (lmn_context_message(context)[0] == '\0'));
        if (i < 40) assert_int_not_equal(status, LMN_OK);
        assert_null(strchr(lmn_context_message(context), '\n'));
        lmn_model_free(model);
        lmn_trainer_resume(context, scene, other_path, 0, &trainer);
        lmn_trainer_free(trainer);
        unlink(other_path); /* the broken state alone */
        lmn_trainer_resume(context, scene, other_path, 0, &trainer);
        if (i < 40) assert_null(trainer);
        lmn_trainer_free(trainer);
        copy_broken(model_path, i, other_path);
        if (lmn_model_read_info(context, other_path, &info) == LMN_OK) lmn_model_info_free(&info);
    }
    lmn_scene_free(scene);
    lmn_context_free(context);
}

static void test_bench(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    const char *json = NULL;
    EXPECT(context, lmn_bench(context, "nothing", NULL, &json), LMN_ERR_ARGUMENT);
    assert_null(json);
    EXPECT(context, lmn_bench(context, "train", "[1]", &json), LMN_ERR_ARGUMENT);
    EXPECT(context, lmn_bench(context, "train", "{\"width\":0}", &json), LMN_ERR_ARGUMENT);
    EXPECT(context, lmn_bench(context, "train", "{\"width\":\"a\"}", &json), LMN_ERR_ARGUMENT);
    EXPECT(context, lmn_bench(context, "trace", "{\"size\":[1]}", &json), LMN_ERR_ARGUMENT);
    EXPECT(context, lmn_bench(context, "trace", "{\"files\":[1]}", &json), LMN_ERR_ARGUMENT);
    EXPECT(context,
           lmn_bench(context, "train", "{\"width\":8,\"depth\":0,\"patches\":1,\"runs\":1}", &json),
           LMN_OK);
    assert_non_null(strstr(json, "\"step_s\":"));
    lmn_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_options),      cmocka_unit_test(test_named_options),
        cmocka_unit_test(test_train),        cmocka_unit_test(test_model),
        cmocka_unit_test(test_start_from),   cmocka_unit_test(test_changed_scene),
        cmocka_unit_test(test_broken_files), cmocka_unit_test(test_bench),
    };
    return cmocka_run_group_tests_name("api_training", tests, make_folder, remove_folder);
}
