/* SPDX-License-Identifier: Apache-2.0 */
/* Test sets of bench learn: made once, kept as EXR files, loaded again. */
#include "learn.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const char *const learn_set_names[N_LEARN_SETS] = {"uniform", "hard"};

#define MIX 0x9e3779b97f4a7c15u /* parts the seeds of configurations */

/* The reference as the mean of its halves, and what that is worth: the error of one half against
 * the mean has exactly the variance of the mean's own noise (train/evaluate.h). */
static lmn_status split_reference(struct app *app, lmn_image *halves, lmn_image **out,
                                  lmn_metrics *noise)
{
    const uint32_t width = lmn_image_width(halves), height = lmn_image_height(halves);
    const size_t n = 3 * (size_t)width * height;
    static const char *const names[3] = {"R", "G", "B"};
    lmn_image *half = NULL, *mean = NULL;
    lmn_status status = lmn_image_new(app->context, width, height, 3, names, &half);
    if (status == LMN_OK) status = lmn_image_new(app->context, width, height, 3, names, &mean);
    if (status == LMN_OK) {
        float *a = lmn_image_data(half), *m = lmn_image_data(mean);
        learn_read_channels(halves, "a.", a);
        learn_read_channels(halves, "b.", m);
        for (size_t i = 0; i < n; i++) m[i] = 0.5f * (a[i] + m[i]);
        status = lmn_image_compare(app->context, half, mean, noise, NULL);
    }
    lmn_image_free(half);
    if (status == LMN_OK)
        *out = mean;
    else
        lmn_image_free(mean);
    return status;
}

/* Loads a reference file; *out stays NULL when it is missing or of something else. */
static void load_halves(struct app *app, const char *path, const uint32_t size[2], lmn_image **out)
{
    *out = NULL;
    if (access(path, R_OK) != 0 || lmn_image_load(app->context, path, out) != LMN_OK) return;
    float *scratch = calloc((size_t)size[0] * size[1], sizeof(float[3]));
    if (scratch && lmn_image_width(*out) == size[0] && lmn_image_height(*out) == size[1] &&
        learn_read_channels(*out, "a.", scratch) && learn_read_channels(*out, "b.", scratch)) {
        free(scratch);
        return;
    }
    free(scratch);
    lmn_image_free(*out);
    *out = NULL;
}

static void add_noise(lmn_metrics *sum, const lmn_metrics *m, uint32_t n)
{
    double *to = (double *)sum;
    const double *from = (const double *)m;
    for (size_t i = 0; i < sizeof *m / sizeof *to; i++) to[i] += from[i] / n;
}

/* Takes references from files, traces the others. indices: of configurations of the seed. */
static int open_set(struct learn_tests *t, enum learn_set_kind kind, struct app *app,
                    const struct learn_args *a, const lmn_scene *scene, uint64_t seed,
                    const uint32_t *indices)
{
    static const char *const integrators[] = {"path", "path+photons", "auto"};
    struct learn_set *set = &t->sets[kind];
    const uint32_t size[2] = {t->width, t->height};
    char path[LEARN_PATH], text[64];
    lmn_status status = LMN_OK;
    set->values = calloc((size_t)a->n * t->n_variables + 1, sizeof *set->values);
    set->references = calloc(a->n, sizeof *set->references);
    if (!set->values || !set->references) return app_error(app, EXIT_FAILED, "out of memory");
    app_begin(app, kind == LEARN_UNIFORM ? "uniform references" : "hard references", NULL, 1.0);
    app->part_size = 1.0 / a->n;
    set->n = a->n;
    for (uint32_t i = 0; i < a->n && status == LMN_OK; i++) {
        double *values = set->values + (size_t)i * t->n_variables;
        lmn_metrics noise;
        lmn_image *halves = NULL;
        lmn_scene_random_values(scene, seed, indices[i], values);
        learn_path(path, "%s/%s-%04u.exr", t->folder,
                   kind == LEARN_UNIFORM ? "uniform" : "candidate", indices[i]);
        app->part_start = (double)i / a->n;
        snprintf(text, sizeof text, "%u of %u", i, a->n);
        progress_update(&app->progress, app->part_start, i, text, NULL);
        load_halves(app, path, size, &halves);
        if (!halves) {
            status = learn_trace(app, scene, values, size, a->reference_spp,
                                 seed ^ ((indices[i] + 1) * MIX), integrators[a->integrator],
                                 &halves);
            if (status == LMN_OK) status = lmn_image_save(app->context, halves, path, "exr", 1.0);
        }
        if (status == LMN_OK) status = split_reference(app, halves, &set->references[i], &noise);
        if (status == LMN_OK) add_noise(&set->noise, &noise, a->n);
        lmn_image_free(halves);
    }
    app->part_start = app->part_size = 0.0;
    if (status != LMN_OK) return app_failed(app, status, BLAME_WORK);
    app_end(app);
    return EXIT_OK;
}

int learn_tests_open(struct learn_tests *t, struct app *app, const struct learn_args *a,
                     const lmn_scene *scene, const char *scene_name)
{
    static const char *const integrators[] = {"path", "photons", "auto"};
    char folder[LEARN_PATH / 2];
    uint32_t size[2];
    lmn_scene_info info;
    lmn_scene_get_info(scene, &info);
    learn_picture_size(scene, a->resolution, size);
    *t = (struct learn_tests){.width = size[0], .height = size[1], .n_variables = info.n_variables};
    snprintf(folder, sizeof folder, "%s%s/%s-%016llx", a->tests ? a->tests : a->out,
             a->tests ? "" : "/tests", scene_name, (unsigned long long)info.hash);
    learn_path(t->folder, "%s/%u-%u-%s", folder, a->resolution, a->reference_spp,
               integrators[a->integrator]);
    int code = learn_make_folder(app, t->folder);
    uint32_t *indices = calloc(a->n, sizeof *indices);
    if (code == EXIT_OK && !indices) code = app_error(app, EXIT_FAILED, "out of memory");
    for (uint32_t i = 0; code == EXIT_OK && i < a->n; i++) indices[i] = i;
    if (code == EXIT_OK)
        code = open_set(t, LEARN_UNIFORM, app, a, scene, LEARN_SEED_UNIFORM, indices);
    if (code == EXIT_OK) code = learn_choose_hard(app, a, scene, folder, t->rule, indices, a->n);
    if (code == EXIT_OK)
        code = open_set(t, LEARN_HARD, app, a, scene, LEARN_SEED_CANDIDATE, indices);
    free(indices);
    return code;
}

void learn_tests_release(struct learn_tests *t)
{
    for (int k = 0; k < N_LEARN_SETS; k++) {
        struct learn_set *set = &t->sets[k];
        for (uint32_t i = 0; set->references && i < set->n; i++) lmn_image_free(set->references[i]);
        free(set->references);
        free(set->values);
    }
    *t = (struct learn_tests){0};
}
