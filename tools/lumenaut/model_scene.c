/* SPDX-License-Identifier: Apache-2.0 */
#include "model_scene.h"

#include <string.h>
#include <unistd.h>

const struct arg_option model_options[2] = {
    {.name = "scene",
     .type = ARG_FILE,
     .argument = "FILE",
     .help = "where the scene is now",
     .fallback = "the path in the model, from here or from the model's folder",
     .offset = offsetof(struct model_args, scene)},
    {.name = "force",
     .type = ARG_FLAG,
     .help = "go on although the scene has changed since training",
     .offset = offsetof(struct model_args, force)},
};

bool is_model_file(const char *path)
{
    unsigned char head[9] = {0};
    const size_t n = strlen(path);
    if (n > 4 && strcmp(path + n - 4, ".lmn") == 0) return true;
    FILE *f = fopen(path, "rb");
    if (!f) return false;
    /* safetensors: eight bytes of length, then a JSON object. No XML starts that way. */
    const bool is_model = fread(head, 1, sizeof head, f) == sizeof head && head[0] != '<' &&
                          head[7] == 0 && head[8] == '{';
    fclose(f);
    return is_model;
}

/* path as it is when there is such a file, else from the folder of `beside`. */
static bool locate(const char *path, const char *beside, char *out, size_t size)
{
    const char *slash = strrchr(beside, '/');
    snprintf(out, size, "%s", path);
    if (access(out, R_OK) == 0 || path[0] == '/' || !slash) return access(out, R_OK) == 0;
    snprintf(out, size, "%.*s/%s", (int)(slash - beside), beside, path);
    return access(out, R_OK) == 0;
}

static void add_defines(struct scene_args *args, const char *const *defines, uint32_t n)
{
    for (uint32_t i = 0; i < n && args->defines.n < ARG_LIST_MAX; i++)
        args->defines.items[args->defines.n++] = defines[i];
}

/* The rest of *out, whose info is there. */
static int use_info(struct app *app, const char *model, const char *override,
                    const struct scene_args *extra, struct model_scene *out)
{
    const lmn_model_info *info = &out->info;
    if (override)
        snprintf(out->path, sizeof out->path, "%s", override);
    else if (!locate(info->scene_path, model, out->path, sizeof out->path))
        return app_error(app, EXIT_INPUT, "%s: its scene %s is not there; give --scene FILE", model,
                         info->scene_path);
    if (extra && extra->variables) {
        out->args.variables = extra->variables;
    } else if (info->variables_path[0]) {
        if (!locate(info->variables_path, model, out->variables, sizeof out->variables))
            return app_error(app, EXIT_INPUT, "%s: its variables file %s is not there", model,
                             info->variables_path);
        out->args.variables = out->variables;
    }
    add_defines(&out->args, (const char *const *)info->defines, info->n_defines);
    if (extra) add_defines(&out->args, extra->defines.items, extra->defines.n);
    return EXIT_OK;
}

int find_model_scene(struct app *app, const char *model, const char *override,
                     const struct scene_args *extra, struct model_scene *out)
{
    memset(out, 0, sizeof *out);
    const lmn_status status = lmn_model_read_info(app->context, model, &out->info);
    if (status != LMN_OK) return app_failed(app, status, BLAME_INPUT);
    const int code = use_info(app, model, override, extra, out);
    if (code != EXIT_OK) model_scene_release(out);
    return code;
}

void model_scene_release(struct model_scene *s)
{
    lmn_model_info_free(&s->info);
    memset(s, 0, sizeof *s);
}

int load_model_scene(struct app *app, const char *model, const char *override,
                     const struct scene_args *extra, lmn_scene **out)
{
    struct model_scene found;
    int code = find_model_scene(app, model, override, extra, &found);
    if (code != EXIT_OK) return code;
    code = load_scene(app, found.path, &found.args, out);
    model_scene_release(&found);
    return code;
}

int load_model(struct app *app, const char *path, const struct model_args *args, lmn_scene **scene,
               lmn_model **model)
{
    const int code = load_model_scene(app, path, args->scene, NULL, scene);
    if (code != EXIT_OK) return code;
    const lmn_status status = lmn_model_load(app->context, *scene, path, args->force != 0, model);
    return status == LMN_OK ? EXIT_OK : app_failed(app, status, BLAME_INPUT);
}
