/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut view: a page with a slider for each variable, shown by the network or path-traced. */
#include "view_training.h"

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

/* What is shown: what the command line names, later what a training of it has made. */
struct showing {
    const struct command_args *a;
    struct view_args page; /* once it is open, where it is */
    char path[4096], token[33];
    const char *notice; /* NULL, or what pages are told */
    struct view_training training;
    bool wants_training;
};

/* The page comes back where it was. */
static void keep_address(struct showing *s, const struct view_host *host)
{
    if (host->port) s->page.port = host->port;
    s->page.open = 0;
    if (!host->token[0]) return;
    snprintf(s->token, sizeof s->token, "%s", host->token);
    s->page.token = s->token;
}

static int serve(struct app *app, struct showing *s, const lmn_scene *scene, const lmn_model *model)
{
    struct view_words render, trace;
    struct view_host host;
    lmn_scene_info info;
    lmn_scene_get_info(scene, &info);
    view_words_render(&render, s->path, s->a->model.scene, s->a->model.force != 0);
    view_words_trace(&trace, info.path, &s->a->scene);
    struct viewer_options options = {.scene = scene,
                                     .model = model,
                                     .scene_path = info.path,
                                     .model_path = model ? s->path : NULL,
                                     .render = model ? render.list : NULL,
                                     .trace = trace.list,
                                     .train = s->training.words.list,
                                     .notice = s->notice};
    if (!model) app_say(app, "path tracing only, until a training is started in the page");
    app->is_silent = true;
    int code = view_host_open(&host, app, &s->page, &options);
    if (code == EXIT_OK) {
        const enum viewer_end end = viewer_run(host.viewer);
        if (end == VIEWER_FAILED) code = app_error(app, EXIT_FAILED, "view: the server failed");
        s->wants_training = end == VIEWER_TRAIN;
    }
    keep_address(s, &host);
    view_host_close(&host);
    return code;
}

/* Until pages want something else. */
static int show(struct showing *s)
{
    const struct command_args *a = s->a;
    struct app app;
    lmn_scene *scene = NULL;
    lmn_model *model = NULL;
    int code = app_open(&app, &a->common);
    if (code == EXIT_OK) code = view_args_check(&app, &s->page);
    if (code != EXIT_OK) goto done;
    const bool is_model = is_model_file(s->path);
    code = is_model ? load_model(&app, s->path, &a->model, &scene, &model)
                    : load_scene(&app, s->path, &a->scene, &scene);
    if (code == EXIT_OK)
        code = view_training_plan(&s->training, &app, s->path, is_model, &a->model, &a->scene);
    if (code == EXIT_OK) code = serve(&app, s, scene, model);
done:
    lmn_model_free(model);
    lmn_scene_free(scene);
    app_close(&app);
    return code;
}

/* What it made is what is shown then. A failure is told, and what was shown is shown again. */
static int train(struct showing *s)
{
    const int code = view_training_run(&s->training, &s->page);
    s->notice = code == EXIT_OK ? NULL : "The training failed; the terminal says why.";
    if (code == EXIT_OK) snprintf(s->path, sizeof s->path, "%s", s->training.output);
    return app_signal() ? code : EXIT_OK;
}

static int run(void *args)
{
    const struct command_args *a = args;
    struct showing s = {.a = a, .page = a->view};
    int code;
    snprintf(s.path, sizeof s.path, "%s", a->common.operands[0]);
    do {
        s.wants_training = false;
        code = show(&s);
        if (code == EXIT_OK && s.wants_training) code = train(&s);
        view_training_release(&s.training);
    } while (code == EXIT_OK && s.wants_training);
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
