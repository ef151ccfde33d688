/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut view: a page with a slider for each variable, shown by the network or path-traced. */
#include "model_scene.h"

#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <unistd.h>

#include "viewer.h"

struct view_args {
    struct common_args common;
    uint32_t port;
    const char *bind, *token;
    uint32_t open;
    struct model_args model;
    struct scene_args scene;
};

static const struct arg_option view_options[] = {
    {.name = "port",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "port of page and socket",
     .fallback = "the first free one from 8750 on",
     .min = 1,
     .max = 65535,
     .offset = offsetof(struct view_args, port)},
    {.name = "bind",
     .type = ARG_TEXT,
     .argument = "ADDRESS",
     .help = "listen at this address of the machine, with a token where others can reach it",
     .offset = offsetof(struct view_args, bind)},
    {.name = "token",
     .type = ARG_TEXT,
     .argument = "TEXT",
     .help = "who opens the page must know this; it is part of the address that is printed",
     .fallback = "none at 127.0.0.1, elsewhere a random one",
     .offset = offsetof(struct view_args, token)},
    {.name = "open",
     .type = ARG_FLAG,
     .help = "show the page in the browser",
     .offset = offsetof(struct view_args, open)},
};

static const struct arg_group groups[] = {
    {"Page", view_options, COUNT_OF(view_options), 0},
    {"Model", model_options, COUNT_OF(model_options), offsetof(struct view_args, model)},
    {"Scene", scene_options, COUNT_OF(scene_options), offsetof(struct view_args, scene)},
    COMMON_GROUP,
};

static void init(void *args)
{
    struct view_args *a = args;
    a->bind = "127.0.0.1";
}

/* What the callbacks of the viewer know. */
struct show {
    struct app *app;
    const struct view_args *args;
    struct viewer *viewer;
    bool is_local;
};

static bool is_local(const char *address)
{
    return strncmp(address, "127.", 4) == 0 || strcmp(address, "localhost") == 0;
}

static void open_browser(struct app *app, const char *url)
{
    char *const words[] = {"xdg-open", (char *)url, NULL};
    pid_t child;
    if (posix_spawnp(&child, words[0], NULL, NULL, words, environ) != 0)
        app_say(app, "note: --open: there is no xdg-open; open the address by hand");
}

static void on_open(void *user, const char *url, uint16_t port)
{
    const struct show *s = user;
    char host[256] = "HOST";
    app_say(s->app, "%s", url);
    if (s->is_local) {
        if (gethostname(host, sizeof host - 1) != 0 || !*host) snprintf(host, sizeof host, "HOST");
        app_say(s->app, "from another machine: ssh -L %u:127.0.0.1:%u %s", port, port, host);
    }
    if (s->args->open) open_browser(s->app, url);
}

static bool must_stop(void *user)
{
    (void)user;
    return app_signal() != 0;
}

static bool is_stale(void *user)
{
    const struct show *s = user;
    return viewer_is_stale(s->viewer);
}

/* Letters of a page's address, 128 random bits. */
static bool make_token(char token[33])
{
    unsigned char bits[16];
    if (getrandom(bits, sizeof bits, 0) != (ssize_t)sizeof bits) return false;
    for (size_t i = 0; i < sizeof bits; i++) snprintf(token + 2 * i, 3, "%02x", bits[i]);
    return true;
}

static bool is_token_plain(const char *token)
{
    return *token && strlen(token) < 200 &&
           strspn(token, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.") ==
               strlen(token);
}

/* The words of commands that make the page's pictures. */
struct words {
    const char *list[2 * ARG_LIST_MAX + 16];
    uint32_t n;
};

static void add_words(struct words *w, const char *option, const char *value)
{
    w->list[w->n++] = option;
    if (value) w->list[w->n++] = value;
}

static void describe_commands(const struct view_args *a, const lmn_scene_info *info,
                              struct words *render, struct words *trace)
{
    *render = *trace = (struct words){0};
    add_words(render, "lumenaut", "render");
    add_words(render, a->common.operands[0], NULL);
    if (a->model.scene) add_words(render, "--scene", a->model.scene);
    if (a->model.force) add_words(render, "--force", NULL);
    add_words(render, "-o", "picture.png");
    add_words(trace, "lumenaut", "trace");
    add_words(trace, info->path, NULL);
    for (uint32_t i = 0; i < a->scene.defines.n; i++)
        add_words(trace, "-D", a->scene.defines.items[i]);
    if (a->scene.variables) add_words(trace, "--variables", a->scene.variables);
    add_words(trace, "-o", "picture.exr");
}

static int serve(struct app *app, const struct view_args *a, const lmn_scene *scene,
                 const lmn_model *model)
{
    struct words render, trace;
    struct show show = {.app = app, .args = a, .is_local = is_local(a->bind)};
    char why[VIEWER_WHY], token[33];
    lmn_scene_info info;
    lmn_scene_get_info(scene, &info);
    describe_commands(a, &info, &render, &trace);
    const char *asked = a->token;
    if (!asked && !show.is_local) {
        if (!make_token(token)) return app_error(app, EXIT_FAILED, "no random numbers for a token");
        asked = token;
    }
    const struct viewer_options options = {.context = app->context,
                                           .scene = scene,
                                           .model = model,
                                           .scene_path = info.path,
                                           .model_path = model ? a->common.operands[0] : NULL,
                                           .render = model ? render.list : NULL,
                                           .trace = trace.list,
                                           .program = "lumenaut " LMN_TOOL_VERSION,
                                           .bind = a->bind,
                                           .token = asked,
                                           .port = (uint16_t)a->port,
                                           .on_open = on_open,
                                           .must_stop = must_stop,
                                           .user = &show};
    if (!viewer_new(&options, &show.viewer, why))
        return app_error(app, EXIT_FAILED, "view: %s", why);
    app->is_silent = true;
    app->is_stale = is_stale;
    app->stale_user = &show;
    const bool is_served = viewer_run(show.viewer);
    viewer_free(show.viewer);
    app->is_stale = NULL;
    return is_served ? EXIT_OK : app_error(app, EXIT_FAILED, "view: the server failed");
}

static int run(void *args)
{
    const struct view_args *a = args;
    const char *path = a->common.operands[0];
    struct app app;
    lmn_scene *scene = NULL;
    lmn_model *model = NULL;
    int code = app_open(&app, &a->common);
    if (code == EXIT_OK && a->token && !is_token_plain(a->token))
        code = app_error(&app, EXIT_USAGE, "--token: letters, digits and -_. only, at most 199");
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
    .args_size = sizeof(struct view_args),
    .init = init,
    .run = run,
    .min_operands = 1,
    .max_operands = 1,
};
