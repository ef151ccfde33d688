/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Traced pictures against Mitsuba's: tests/render/data/NAME.json (scripts/references/trace.py)
 * holds the mean and standard error of 16 x 16 tiles and of the whole picture. Here the same is
 * traced from SEEDS independent seeds, whose spread gives our own standard error. A tile may be off
 * by LIMIT standard errors of the difference; with 16 seeds (Student's t, 15 degrees of freedom or
 * more) a tile goes beyond it by chance once in 40,000 times. Seeds are fixed, so the outcome is,
 * too.
 */
#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>
#include <lumenaut/lumenaut.h>

enum { SEEDS = 16, SPP = 16, MAX_TILES = 65 };
static const double LIMIT = 6.0;

struct tally {
    int n_compared, n_failed, n_skipped;
};

static const char *data_folder(void)
{
    static char path[1024];
    const char *root = getenv("LMN_REFERENCES");
    if (root)
        snprintf(path, sizeof path, "%s/render", root);
    else
        snprintf(path, sizeof path, "%s/tests/render/data", LMN_SOURCE_DIR);
    return path;
}

/* False when it is an outside scene that is not there. */
static int find_scene(const json_t *reference, char *path, size_t size)
{
    const char *own = json_string_value(json_object_get(reference, "scene"));
    const char *outside = json_string_value(json_object_get(reference, "outside"));
    const char *root = getenv("LUMENAUT_SCENES");
    if (own)
        snprintf(path, size, "%s/%s", LMN_SOURCE_DIR, own);
    else if (root)
        snprintf(path, size, "%s/%s", root, outside);
    else
        snprintf(path, size, "%s/../shared/scenes/%s", LMN_SOURCE_DIR, outside);
    return access(path, R_OK) == 0;
}

static uint32_t integer_of(const json_t *reference, const char *key)
{
    const json_t *value = json_object_get(reference, key);
    assert_true(json_is_integer(value));
    return (uint32_t)json_integer_value(value);
}

/* means[n_tiles][3] of row-major tiles; the last is the whole picture. */
static void tile_means(lmn_image *image, uint32_t tile, double (*means)[3])
{
    uint32_t n_channels = lmn_image_n_channels(image), width = lmn_image_width(image);
    uint32_t columns = width / tile, n_tiles = columns * columns;
    const float *data = lmn_image_data(image);
    memset(means, 0, (n_tiles + 1) * sizeof *means);
    for (uint32_t y = 0; y < width; y++)
        for (uint32_t x = 0; x < width; x++)
            for (uint32_t c = 0; c < 3; c++) {
                double value = (double)data[((size_t)y * width + x) * n_channels + c];
                means[y / tile * columns + x / tile][c] += value / (tile * tile);
                means[n_tiles][c] += value / ((double)width * width);
            }
}

/* Values from u in [0,1], as scripts/peers/freeze.py takes them; the defaults where there are none.
 */
static double *configuration(const lmn_scene *scene, const json_t *u)
{
    lmn_scene_info info;
    lmn_scene_get_info(scene, &info);
    double *values = calloc(info.n_variables + 1, sizeof *values);
    assert_non_null(values);
    lmn_scene_default_values(scene, values);
    if (json_array_size(u) == 0) return values;
    assert_int_equal(json_array_size(u), info.n_variables);
    for (uint32_t i = 0; i < info.n_variables; i++) {
        lmn_variable_info v;
        assert_int_equal(lmn_scene_get_variable(scene, i, &v), LMN_OK);
        values[i] = v.min + json_number_value(json_array_get(u, i)) * (v.max - v.min);
    }
    return values;
}

/* Compares the tiles of one reference; prints the worst. */
static int compare(lmn_context *context, const char *name, const char *path,
                   const json_t *reference)
{
    lmn_scene *scene = NULL;
    if (lmn_scene_load(context, path, NULL, &scene) != LMN_OK) {
        print_error("%s: %s\n", name, lmn_context_message(context));
        return 0;
    }
    uint32_t size = integer_of(reference, "size"), tile = integer_of(reference, "tile");
    uint32_t n_tiles = (size / tile) * (size / tile) + 1;
    assert_in_range(n_tiles, 1, MAX_TILES);
    lmn_trace_options options = {.struct_size = sizeof options,
                                 .integrator = "path",
                                 .width = size,
                                 .height = size,
                                 .spp = SPP,
                                 .has_max_depth = 1,
                                 .has_rr_depth = 1,
                                 .max_depth = (int32_t)integer_of(reference, "max_depth"),
                                 .rr_depth = (int32_t)integer_of(reference, "rr_depth"),
                                 .sampler = "independent"};
    double *values = configuration(scene, json_object_get(reference, "u"));
    static double means[SEEDS][MAX_TILES][3];
    for (uint32_t s = 0; s < SEEDS; s++) {
        lmn_image *image = NULL;
        options.seed = s + 1;
        if (lmn_scene_trace(context, scene, values, &options, &image, NULL) != LMN_OK)
            fail_msg("%s: %s", name, lmn_context_message(context));
        tile_means(image, tile, means[s]);
        lmn_image_free(image);
    }
    free(values);
    lmn_scene_free(scene);

    double worst = 0, worst_mean = 0, worst_reference = 0;
    uint32_t worst_tile = 0;
    for (uint32_t t = 0; t < n_tiles; t++)
        for (uint32_t c = 0; c < 3; c++) {
            const json_t *row = json_array_get(json_object_get(reference, "mean"), t);
            double want = json_number_value(json_array_get(row, c)), mean = 0, variance = 0;
            row = json_array_get(json_object_get(reference, "error"), t);
            double error = json_number_value(json_array_get(row, c));
            for (int s = 0; s < SEEDS; s++) mean += means[s][t][c] / SEEDS;
            for (int s = 0; s < SEEDS; s++)
                variance += (means[s][t][c] - mean) * (means[s][t][c] - mean) / (SEEDS - 1);
            /* Half floats and five digits: equal constants need not be equal to the last bit. */
            double rounding = 1e-4 * want;
            double z = fabs(mean - want) /
                       (sqrt(variance / SEEDS + error * error + rounding * rounding) + 1e-12);
            if (!(z <= worst)) {
                worst = z;
                worst_tile = t;
                worst_mean = mean;
                worst_reference = want;
            }
        }
    int ok = worst <= LIMIT;
    print_message("%-24s %s: tile %u of %u is off by %.2f standard errors (%.5g, Mitsuba %.5g)\n",
                  name, ok ? "ok" : "FAILS", worst_tile, n_tiles, worst, worst_mean,
                  worst_reference);
    return ok;
}

static void test_pictures(void **state)
{
    struct tally *tally = *state;
    lmn_context *context = NULL;
    char message[256];
    if (lmn_context_new(NULL, &context, message, sizeof message) != LMN_OK) fail_msg("%s", message);
    struct dirent **entries = NULL;
    int n = scandir(data_folder(), &entries, NULL, alphasort);
    for (int i = 0; i < n; i++) {
        const char *name = entries[i]->d_name;
        char file[2048], scene[2048];
        size_t length = strlen(name);
        if (length > 5 && strcmp(name + length - 5, ".json") == 0) {
            snprintf(file, sizeof file, "%s/%s", data_folder(), name);
            json_error_t error;
            json_t *reference = json_load_file(file, 0, &error);
            if (!reference) fail_msg("%s: %s", file, error.text);
            if (!find_scene(reference, scene, sizeof scene)) {
                print_message("%-24s skipped: no %s (LUMENAUT_SCENES)\n", name, scene);
                tally->n_skipped++;
            } else {
                tally->n_compared++;
                tally->n_failed += !compare(context, name, scene, reference);
            }
            json_decref(reference);
        }
        free(entries[i]);
    }
    free(entries);
    lmn_context_free(context);
    assert_int_equal(tally->n_failed, 0);
}

int main(void)
{
    struct tally tally = {0};
    const struct CMUnitTest tests[] = {cmocka_unit_test_prestate(test_pictures, &tally)};
    int status = cmocka_run_group_tests(tests, NULL, NULL);
    if (status != 0) return status;
    if (tally.n_compared == 0) {
        printf("skipped: no reference in %s whose scene is there\n", data_folder());
        return 77;
    }
    return 0;
}
