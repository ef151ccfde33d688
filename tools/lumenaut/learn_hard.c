/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which configurations are hard. The rule, fixed before any comparison: the improved network is
 * trained for a short while on uniform draws; of n_candidates configurations those count as hard
 * where it is worst. Its error is measured without the bias that noisy pictures bring: for network
 * f and independent halves a, b of a traced picture,
 *
 *   E[(f - a)(f - b)] = (f - y)^2,   relative to lum(f)^2 + 0.01,
 *
 * mean over pixels and channels.
 */
#include "learn.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PROBE_SEED = 0x68617264, CANDIDATE_SIDE = 64, CANDIDATE_SPP = 64 };

struct candidate {
    uint32_t index;
    double error;
};

static int compare_candidates(const void *a, const void *b)
{
    const struct candidate *x = a, *y = b;
    if (x->error != y->error) return x->error < y->error ? 1 : -1;
    return x->index < y->index ? -1 : x->index > y->index;
}

/* Trains the probe unless it is there. */
static int train_probe(struct app *app, const struct learn_args *a, const lmn_scene *scene,
                       const char *path)
{
    lmn_train_options o;
    lmn_train_stats stats = {0};
    lmn_trainer *trainer = NULL;
    if (access(path, R_OK) == 0) return EXIT_OK;
    learn_uniform_options(&o);
    o.seed = PROBE_SEED;
    lmn_status status = lmn_trainer_new(app->context, scene, &o, &trainer);
    if (status != LMN_OK) return app_failed(app, status, BLAME_USER);
    app_begin(app, "probe", "steps", 1.0);
    double share = 0.0;
    while (share < 1.0 && status == LMN_OK && !app_signal()) {
        status = lmn_trainer_step(trainer, &stats);
        share = a->probe.steps ? (double)stats.step / (double)a->probe.steps
                               : stats.cpu_s / a->probe.seconds;
        progress_update(&app->progress, share, (double)stats.step, NULL, NULL);
    }
    if (status == LMN_OK && app_signal()) status = LMN_ERR_CANCELLED;
    if (status == LMN_OK) status = lmn_trainer_save(trainer, path);
    if (status == LMN_OK) {
        char state[LEARN_PATH];
        learn_path(state, "%s.state", path);
        unlink(state); /* it will not go on */
    }
    lmn_trainer_free(trainer);
    app_end(app);
    return status == LMN_OK ? EXIT_OK : app_failed(app, status, BLAME_WORK);
}

/* Mean of (f - a)(f - b) / (lum(f)^2 + 0.01); all [n_pixels][3]. */
static double unbiased_error(const float *f, const float *a, const float *b, size_t n_pixels)
{
    double sum = 0.0;
    for (size_t i = 0; i < n_pixels; i++) {
        const float *p = f + 3 * i;
        const double lum = 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
        double product = 0.0;
        for (size_t c = 0; c < 3; c++)
            product += ((double)p[c] - (double)a[3 * i + c]) *
                       ((double)p[c] - (double)b[3 * i + c]);
        sum += product / (lum * lum + 0.01);
    }
    return sum / (3.0 * (double)n_pixels);
}

static lmn_status measure_candidate(struct app *app, const lmn_scene *scene, const lmn_model *model,
                                    const double *values, const uint32_t size[2], float *scratch,
                                    struct candidate *out)
{
    const size_t n_pixels = (size_t)size[0] * size[1];
    float *f = scratch, *a = f + 3 * n_pixels, *b = a + 3 * n_pixels;
    lmn_image *picture = NULL;
    const lmn_render_options o = {
        .struct_size = sizeof o, .width = size[0], .height = size[1], .seed = out->index};
    lmn_status status = lmn_model_render(app->context, model, values, &o, &picture, NULL);
    if (status == LMN_OK) learn_read_channels(picture, "", f);
    lmn_image_free(picture);
    if (status != LMN_OK) return status;
    status = learn_trace(app, scene, values, size, CANDIDATE_SPP, LEARN_SEED_CANDIDATE + out->index,
                         "path", &picture);
    if (status != LMN_OK) return status;
    learn_read_channels(picture, "a.", a);
    learn_read_channels(picture, "b.", b);
    lmn_image_free(picture);
    out->error = unbiased_error(f, a, b, n_pixels);
    if (!isfinite(out->error)) out->error = HUGE_VAL; /* nothing is worse */
    return LMN_OK;
}

static int measure_all(struct app *app, const struct learn_args *a, const lmn_scene *scene,
                       const char *probe, struct candidate *candidates)
{
    uint32_t size[2];
    lmn_scene_info info;
    lmn_model *model = NULL;
    lmn_scene_get_info(scene, &info);
    learn_picture_size(scene, a->resolution < CANDIDATE_SIDE ? a->resolution : CANDIDATE_SIDE,
                       size);
    double *values = calloc(info.n_variables + 1u, sizeof *values);
    float *scratch = calloc((size_t)size[0] * size[1], 9 * sizeof *scratch);
    int code = EXIT_OK;
    lmn_status status = LMN_OK;
    if (!values || !scratch) code = app_error(app, EXIT_FAILED, "out of memory");
    if (code == EXIT_OK) {
        status = lmn_model_load(app->context, scene, probe, 0, &model);
        if (status != LMN_OK) code = app_failed(app, status, BLAME_WORK);
    }
    if (code == EXIT_OK) {
        app_begin(app, "candidates", "configurations", 1.0);
        app->is_silent = true;
        for (uint32_t i = 0; i < a->n_candidates && status == LMN_OK; i++) {
            candidates[i].index = i;
            lmn_scene_random_values(scene, LEARN_SEED_CANDIDATE, i, values);
            status = measure_candidate(app, scene, model, values, size, scratch, &candidates[i]);
            progress_update(&app->progress, (double)i / a->n_candidates, i, NULL, NULL);
        }
        app->is_silent = false;
        if (status != LMN_OK) code = app_failed(app, status, BLAME_WORK);
        app_end(app);
    }
    lmn_model_free(model);
    free(values);
    free(scratch);
    return code;
}

static int save_choice(struct app *app, const struct learn_args *a, const char *path,
                       const struct candidate *candidates)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f) return app_error(app, EXIT_FAILED, "out of memory");
    struct json_out j = {.f = f};
    jo_object(&j, NULL);
    jo_string(&j, "rule",
              "candidates where a network trained on uniform draws is worst, by the "
              "mean of (f-a)(f-b)/(lum(f)^2+0.01), worst first");
    jo_count(&j, "seed", LEARN_SEED_CANDIDATE);
    if (a->probe.steps)
        jo_count(&j, "probe_steps", a->probe.steps);
    else
        jo_number(&j, "probe_s", a->probe.seconds);
    jo_count(&j, "spp", CANDIDATE_SPP);
    jo_array(&j, "candidates");
    for (uint32_t i = 0; i < a->n_candidates; i++) jo_count(&j, NULL, candidates[i].index);
    jo_end(&j);
    jo_array(&j, "errors");
    for (uint32_t i = 0; i < a->n_candidates; i++) jo_number(&j, NULL, candidates[i].error);
    jo_end(&j);
    jo_end(&j);
    int code = fclose(f) == 0 ? EXIT_OK : app_error(app, EXIT_FAILED, "out of memory");
    if (code == EXIT_OK) code = learn_save_text(app, path, text, size);
    free(text);
    return code;
}

/* The first n of the list; false when the text is no such file. */
static bool read_choice(const char *text, uint32_t n_candidates, uint32_t *indices, uint32_t n)
{
    static const char key[] = "\"candidates\":[";
    const char *at = strstr(text, key);
    if (!at) return false;
    at += sizeof key - 1;
    for (uint32_t i = 0; i < n; i++) {
        char *end;
        const unsigned long index = strtoul(at, &end, 10);
        if (end == at || index >= n_candidates || (*end != ',' && *end != ']')) return false;
        indices[i] = (uint32_t)index;
        if (*end == ']' && i + 1 < n) return false;
        at = end + 1;
    }
    return true;
}

int learn_choose_hard(struct app *app, const struct learn_args *a, const lmn_scene *scene,
                      const char *folder, char rule[LEARN_RULE], uint32_t *indices, uint32_t n)
{
    char path[LEARN_PATH], probe[LEARN_PATH], how[32];
    if (a->probe.steps)
        snprintf(how, sizeof how, "%llui", (unsigned long long)a->probe.steps);
    else
        snprintf(how, sizeof how, "%gs", a->probe.seconds);
    const uint32_t side = a->resolution < CANDIDATE_SIDE ? a->resolution : CANDIDATE_SIDE;
    snprintf(rule, LEARN_RULE, "%s-%u-%u", how, a->n_candidates, side);
    learn_path(path, "%s/hard-%s.json", folder, rule);
    learn_path(probe, "%s/probe-%s.lmn", folder, how);
    char *text = learn_load_text(path);
    int code = EXIT_OK;
    if (!text) {
        struct candidate *candidates = calloc(a->n_candidates, sizeof *candidates);
        if (!candidates) code = app_error(app, EXIT_FAILED, "out of memory");
        if (code == EXIT_OK) code = train_probe(app, a, scene, probe);
        if (code == EXIT_OK) code = measure_all(app, a, scene, probe, candidates);
        if (code == EXIT_OK) {
            qsort(candidates, a->n_candidates, sizeof *candidates, compare_candidates);
            code = save_choice(app, a, path, candidates);
        }
        free(candidates);
        if (code != EXIT_OK) return code;
        text = learn_load_text(path);
    }
    if (!text || !read_choice(text, a->n_candidates, indices, n))
        code = app_error(app, EXIT_INPUT, "%s: no list of hard configurations; remove it", path);
    free(text);
    return code;
}
