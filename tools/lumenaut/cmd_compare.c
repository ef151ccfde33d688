/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut compare: the errors of an image against a reference. */
#include "cli_options.h"

struct compare_args {
    struct common_args common;
    const char *map;
    uint32_t json;
};

static const struct arg_option compare_options[] = {
    {.name = "map",
     .type = ARG_FILE,
     .argument = "FILE",
     .help = "write the FLIP error map in false colours: .png, .exr or .pfm",
     .offset = offsetof(struct compare_args, map)},
    {.name = "json",
     .type = ARG_FLAG,
     .help = "print one JSON document on stdout",
     .offset = offsetof(struct compare_args, json)},
};

static const struct arg_group groups[] = {
    {"Output", compare_options, COUNT_OF(compare_options), 0},
    COMMON_GROUP,
};

static void print_text(const lmn_metrics *m)
{
    printf("MAE       %.6g\n", m->mae);
    printf("MAPE      %.6g\n", m->mape);
    printf("relMSE    %.6g\n", m->relmse);
    printf("MSE       %.6g\n", m->mse);
    printf("PSNR      %.2f dB\n", m->psnr);
    printf("DSSIM     %.6g\n", m->dssim);
    printf("FLIP      %.6g\n", m->flip);
    printf("HDR-FLIP  %.6g\n", m->flip_hdr);
}

static int run(void *args)
{
    const struct compare_args *a = args;
    struct app app;
    lmn_image *test = NULL, *reference = NULL, *map = NULL;
    lmn_metrics metrics;
    lmn_status status;
    int code = app_open(&app, &a->common);
    if (code == EXIT_OK && a->map) code = app_check_image(&app, a->map, NULL);
    if (code != EXIT_OK) goto done;
    enum blame blame = BLAME_INPUT;
    status = lmn_image_load(app.context, a->common.operands[0], &test);
    if (status == LMN_OK) status = lmn_image_load(app.context, a->common.operands[1], &reference);
    if (status == LMN_OK)
        status = lmn_image_compare(app.context, test, reference, &metrics, a->map ? &map : NULL);
    if (status == LMN_OK && a->map) {
        blame = BLAME_WORK;
        status = lmn_image_save(app.context, map, a->map, NULL, 1.0);
    }
    if (status != LMN_OK) {
        code = app_failed(&app, status, blame);
        goto done;
    }
    if (a->json) {
        struct json_out j = {.f = stdout};
        jo_object(&j, NULL);
        jo_string(&j, "command", "compare");
        jo_string(&j, "test", a->common.operands[0]);
        jo_string(&j, "reference", a->common.operands[1]);
        jo_array(&j, "size");
        jo_count(&j, NULL, lmn_image_width(test));
        jo_count(&j, NULL, lmn_image_height(test));
        jo_end(&j);
        jo_metrics(&j, "metrics", &metrics);
        jo_end(&j);
    } else {
        print_text(&metrics);
    }
done:
    lmn_image_free(test);
    lmn_image_free(reference);
    lmn_image_free(map);
    app_close(&app);
    return app_flush(code);
}

const struct command command_compare = {
    .name = "compare",
    .operands = "IMAGE REFERENCE",
    .summary = "Compare an image with a reference",
    .groups = groups,
    .n_groups = COUNT_OF(groups),
    .args_size = sizeof(struct compare_args),
    .run = run,
    .min_operands = 2,
    .max_operands = 2,
};
