/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut render: shows one configuration by a trained network. */
#include "model_scene.h"

#include <stdlib.h>

struct render_args {
    struct common_args common;
    struct picture_args picture;
    struct model_args model;
};

static const struct arg_group groups[] = {
    {"Picture", picture_options, COUNT_OF(picture_options), offsetof(struct render_args, picture)},
    {"Model", model_options, COUNT_OF(model_options), offsetof(struct render_args, model)},
    COMMON_GROUP,
};

static void init(void *args)
{
    struct render_args *a = args;
    a->picture.exposure = 1.0;
}

static void print_json(const struct render_args *a, const lmn_scene *scene, const double *values,
                       const lmn_camera *camera, const lmn_image *image, double load_s,
                       double render_s)
{
    struct json_out j = {.f = stdout};
    jo_object(&j, NULL);
    jo_string(&j, "command", "render");
    jo_string(&j, "model", a->common.operands[0]);
    jo_string(&j, "output", a->picture.output);
    jo_array(&j, "size");
    jo_count(&j, NULL, lmn_image_width(image));
    jo_count(&j, NULL, lmn_image_height(image));
    jo_end(&j);
    jo_count(&j, "seed", a->picture.seed);
    jo_number(&j, "render_s", render_s);
    jo_number(&j, "load_s", load_s);
    jo_count(&j, "peak_memory_bytes", app_peak_memory());
    jo_values(&j, scene, values);
    jo_camera(&j, camera);
    jo_end(&j);
}

static int run(void *args)
{
    const struct render_args *a = args;
    const struct picture_args *p = &a->picture;
    struct app app;
    lmn_scene *scene = NULL;
    lmn_model *model = NULL;
    lmn_image *image = NULL;
    double *values = NULL, render_s = 0.0;
    lmn_camera seen_from;
    const lmn_camera *camera = NULL;
    lmn_status status;
    int code = app_open(&app, &a->common);
    const double start_s = clock_s();

    if (code == EXIT_OK) code = check_picture(&app, p);
    if (code == EXIT_OK) code = load_model(&app, a->common.operands[0], &a->model, &scene, &model);
    if (code == EXIT_OK) values = make_values(&app, scene, &p->values, &code);
    if (code == EXIT_OK) camera = make_camera(&app, scene, values, p, &seen_from, &code);
    if (code != EXIT_OK) goto done;

    const lmn_render_options options = {.struct_size = sizeof options,
                                        .width = p->size[0],
                                        .height = p->size[1],
                                        .crop_x = p->crop[0],
                                        .crop_y = p->crop[1],
                                        .crop_width = p->crop[2],
                                        .crop_height = p->crop[3],
                                        .buffer_spp = p->spp,
                                        .buffers = p->buffers,
                                        .seed = p->seed,
                                        .camera = camera};
    app_begin(&app, "render", NULL, 1.0);
    status = lmn_model_render(app.context, model, values, &options, &image, &render_s);
    const double load_s = clock_s() - start_s - render_s;
    if (status != LMN_OK) {
        code = app_failed(&app, status, BLAME_USER);
        goto done;
    }
    app_end(&app);
    status = lmn_image_save(app.context, image, p->output, p->format, p->exposure);
    if (status != LMN_OK) {
        code = app_failed(&app, status, BLAME_WORK);
        goto done;
    }
    app_say(&app, "%s: %ux%u, %.3f s", p->output, lmn_image_width(image), lmn_image_height(image),
            render_s);
    if (p->json) print_json(a, scene, values, camera, image, load_s, render_s);
done:
    free(values);
    lmn_image_free(image);
    lmn_model_free(model);
    lmn_scene_free(scene);
    app_close(&app);
    return app_flush(code);
}

const struct command command_render = {
    .name = "render",
    .operands = "MODEL",
    .summary = "Show one configuration by a trained network",
    .groups = groups,
    .n_groups = COUNT_OF(groups),
    .args_size = sizeof(struct render_args),
    .init = init,
    .run = run,
    .min_operands = 1,
    .max_operands = 1,
};
