/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut view: a page with a slider for each variable, shown by the network or path-traced. */
#include "model_scene.h"
#include "view_host.h"

struct command_args {
    struct common_args common;
    struct view_args view;
    struct model_args model;
    struct scene_args scene;
};

static const struct arg_group groups[] = {
    {"Page", view_options, COUNT_OF(view_options), offsetof(struct command_args, view)},
    {"Model", model_options, COUNT_OF(model_options), offsetof(struct command_args, model)},
    {"Scene", scene_options, COUNT_OF(scene_options), offsetof(struct command_args, scene)},
    COMMON_GROUP,
};

static void init(void *args)
{
    struct command_args *a = args;
    view_args_init(&a->view);
}

static int serve(struct app *app, const struct command_args *a, const lmn_scene *scene,
                 const lmn_model *model)
{
    struct view_words render, trace;
    struct view_host host;
    lmn_scene_info info;
    lmn_scene_get_info(scene, &info);
    view_words_render(&render, a->common.operands[0], a->model.scene, a->model.force != 0);
    view_words_trace(&trace, info.path, &a->scene);
    struct viewer_options options = {.scene = scene,
                                     .model = model,
                                     .scene_path = info.path,
                                     .model_path = model ? a->common.operands[0] : NULL,
                                     .render = model ? render.list : NULL,
                                     .trace = trace.list};
    if (!model)
        app_say(app,
                "path tracing only; lumenaut train %s -o NAME.lmn --view shows a network as it "
                "learns",
                info.path);
    app->is_silent = true;
    int code = view_host_open(&host, app, &a->view, &options);
    if (code == EXIT_OK && !viewer_run(host.viewer))
        code = app_error(app, EXIT_FAILED, "view: the server failed");
    view_host_close(&host);
    return code;
}

static int run(void *args)
{
    const struct command_args *a = args;
    const char *path = a->common.operands[0];
    struct app app;
    lmn_scene *scene = NULL;
    lmn_model *model = NULL;
    int code = app_open(&app, &a->common);
    if (code == EXIT_OK) code = view_args_check(&app, &a->view);
    if (code != EXIT_OK) goto done;
    code = is_model_file(path) ? load_model(&app, path, &a->model, &scene, &model)
                               : load_scene(&app, path, &a->scene, &scene);
    if (code == EXIT_OK) code = serve(&app, a, scene, model);
done:
    lmn_model_free(model);
    lmn_scene_free(scene);
    app_close(&app);
    return app_flush(code);
}

const struct command command_view = {
    .name = "view",
    .operands = "MODEL|SCENE",
    .summary = "Show a page with a slider for each variable",
    .groups = groups,
    .n_groups = COUNT_OF(groups),
    .args_size = sizeof(struct command_args),
    .init = init,
    .run = run,
    .min_operands = 1,
    .max_operands = 1,
};
