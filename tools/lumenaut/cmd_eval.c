/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut eval: the errors of a network on configurations that training never saw. */
#include "model_scene.h"

#include <stdlib.h>

struct eval_args {
    struct common_args common;
    struct model_args model;
    uint32_t n, size, spp;
    uint64_t seed;
    const char *sheet;
    uint32_t json;
};

static const struct arg_option eval_options[] = {
    {.name = "n",
     .letter = 'n',
     .type = ARG_COUNT,
     .argument = "N",
     .help = "configurations, drawn uniformly; the same for the same seed",
     .min = 1,
     .max = 4096,
     .offset = offsetof(struct eval_args, n)},
    {.name = "size",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "pixels of the longer side",
     .min = 11,
     .max = 4096,
     .offset = offsetof(struct eval_args, size)},
    {.name = "spp",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "samples per pixel of the path-traced references",
     .min = 2,
     .max = 1 << 20,
     .offset = offsetof(struct eval_args, spp)},
    {.name = "seed",
     .type = ARG_WHOLE,
     .argument = "N",
     .help = "seed of the test set",
     .offset = offsetof(struct eval_args, seed)},
    {.name = "sheet",
     .type = ARG_FILE,
     .argument = "FILE",
     .help = "write the contact sheet neural | path traced | FLIP, a row per configuration",
     .offset = offsetof(struct eval_args, sheet)},
    {.name = "json",
     .type = ARG_FLAG,
     .help = "print one JSON document on stdout",
     .offset = offsetof(struct eval_args, json)},
};

static const struct arg_group groups[] = {
    {"Test set", eval_options, COUNT_OF(eval_options), 0},
    {"Model", model_options, COUNT_OF(model_options), offsetof(struct eval_args, model)},
    COMMON_GROUP,
};

static void init(void *args)
{
    struct eval_args *a = args;
    a->n = 16;
    a->size = 128;
    a->spp = 1024;
}

static void print_text(const lmn_eval_result *r)
{
    const lmn_metrics *m = &r->mean, *n = &r->noise;
    printf("            network  noise floor\n");
    printf("MAE       %9.5f    %9.5f\n", m->mae, n->mae);
    printf("MAPE      %9.5f    %9.5f\n", m->mape, n->mape);
    printf("relMSE    %9.5f    %9.5f\n", m->relmse, n->relmse);
    printf("PSNR      %9.2f    %9.2f\n", m->psnr, n->psnr);
    printf("DSSIM     %9.5f    %9.5f\n", m->dssim, n->dssim);
    printf("FLIP      %9.5f    %9.5f\n", m->flip, n->flip);
    printf("HDR-FLIP  %9.5f    %9.5f\n", m->flip_hdr, n->flip_hdr);
    printf("seconds   %9.4f    %9.4f  (a frame, a reference)\n", r->frame_s, r->trace_s);
}

static void print_json(const struct eval_args *a, const lmn_scene *scene,
                       const lmn_eval_result *result, const lmn_metrics *each, double *values)
{
    struct json_out j = {.f = stdout};
    jo_object(&j, NULL);
    jo_string(&j, "command", "eval");
    jo_string(&j, "model", a->common.operands[0]);
    jo_count(&j, "n", a->n);
    jo_count(&j, "size", a->size);
    jo_count(&j, "spp", a->spp);
    jo_count(&j, "seed", a->seed);
    jo_metrics(&j, "mean", &result->mean);
    jo_metrics(&j, "noise", &result->noise);
    jo_number(&j, "frame_s", result->frame_s);
    jo_number(&j, "trace_s", result->trace_s);
    jo_count(&j, "peak_memory_bytes", app_peak_memory());
    jo_array(&j, "configurations");
    for (uint32_t i = 0; i < a->n; i++) {
        lmn_scene_random_values(scene, a->seed, i, values);
        jo_object(&j, NULL);
        jo_values(&j, scene, values);
        jo_metrics(&j, "metrics", &each[i]);
        jo_end(&j);
    }
    jo_end(&j);
    jo_end(&j);
}

static int run(void *args)
{
    const struct eval_args *a = args;
    struct app app;
    lmn_scene *scene = NULL;
    lmn_model *model = NULL;
    lmn_image *sheet = NULL;
    lmn_eval_result result;
    lmn_status status;
    double *values = NULL;
    lmn_metrics *each = calloc(a->n, sizeof *each);
    const struct arg_list none = {.n = 0};
    int code = app_open(&app, &a->common);
    if (code == EXIT_OK && !each) code = app_error(&app, EXIT_FAILED, "out of memory");
    if (code == EXIT_OK && a->sheet) code = app_check_image(&app, a->sheet, NULL);
    if (code == EXIT_OK) code = load_model(&app, a->common.operands[0], &a->model, &scene, &model);
    if (code == EXIT_OK) values = make_values(&app, scene, &none, &code);
    if (code != EXIT_OK) goto done;

    const lmn_eval_options options = {.struct_size = sizeof options,
                                      .n = a->n,
                                      .resolution = a->size,
                                      .spp = a->spp,
                                      .seed = a->seed};
    app_begin(&app, "eval", NULL, 1.0);
    status = lmn_model_eval(app.context, model, &options, &result, each, a->sheet ? &sheet : NULL);
    if (status != LMN_OK) {
        code = app_failed(&app, status, BLAME_USER);
        goto done;
    }
    app_end(&app);
    if (a->sheet) {
        status = lmn_image_save(app.context, sheet, a->sheet, NULL, 1.0);
        if (status != LMN_OK) {
            code = app_failed(&app, status, BLAME_WORK);
            goto done;
        }
        app_say(&app, "%s: neural | path traced | FLIP, %u configurations", a->sheet, a->n);
    }
    if (a->json)
        print_json(a, scene, &result, each, values);
    else
        print_text(&result);
done:
    free(each);
    free(values);
    lmn_image_free(sheet);
    lmn_model_free(model);
    lmn_scene_free(scene);
    app_close(&app);
    return app_flush(code);
}

const struct command command_eval = {
    .name = "eval",
    .operands = "MODEL",
    .summary = "Measure a network against path tracing on unseen configurations",
    .groups = groups,
    .n_groups = COUNT_OF(groups),
    .args_size = sizeof(struct eval_args),
    .init = init,
    .run = run,
    .min_operands = 1,
    .max_operands = 1,
};
