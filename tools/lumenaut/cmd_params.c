/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut params: the variables and parameters of a scene, or of the scene of a model. */
#include "model_scene.h"
#include "cli_options.h"

#include <string.h>

struct params_args {
    struct common_args common;
    struct scene_args scene;
    const char *model_scene;
    uint32_t all, json;
};

static const struct arg_option params_options[] = {
    {.name = "all",
     .letter = 'a',
     .type = ARG_FLAG,
     .help = "list every parameter of the scene too, not only its variables",
     .offset = offsetof(struct params_args, all)},
    {.name = "scene",
     .type = ARG_FILE,
     .argument = "FILE",
     .help = "where the scene of a model is now",
     .fallback = "the path in the model",
     .offset = offsetof(struct params_args, model_scene)},
    {.name = "json",
     .type = ARG_FLAG,
     .help = "print one JSON document on stdout, parameters included",
     .offset = offsetof(struct params_args, json)},
};

static const struct arg_group groups[] = {
    {"Output", params_options, COUNT_OF(params_options), 0},
    {"Scene", scene_options, COUNT_OF(scene_options), offsetof(struct params_args, scene)},
    COMMON_GROUP,
};

static void print_json(const char *path, const lmn_scene *scene)
{
    struct json_out j = {.f = stdout};
    lmn_scene_info info;
    lmn_variable_info v;
    lmn_parameter_info p;
    lmn_scene_get_info(scene, &info);
    jo_object(&j, NULL);
    jo_string(&j, "command", "params");
    jo_string(&j, "file", path);
    jo_string(&j, "scene", info.path);
    jo_array(&j, "size");
    jo_count(&j, NULL, info.width);
    jo_count(&j, NULL, info.height);
    jo_end(&j);
    jo_count(&j, "spp", info.spp);
    jo_number(&j, "max_depth", info.max_depth);
    jo_number(&j, "rr_depth", info.rr_depth);
    jo_count(&j, "triangles", info.n_triangles);
    jo_count(&j, "shapes", info.n_shapes);
    jo_count(&j, "instances", info.n_instances);
    jo_count(&j, "bsdfs", info.n_bsdfs);
    jo_count(&j, "textures", info.n_textures);
    jo_count(&j, "emitters", info.n_emitters);
    jo_array(&j, "variables");
    for (uint32_t i = 0; i < info.n_variables; i++) {
        if (lmn_scene_get_variable(scene, i, &v) != LMN_OK) break;
        jo_object(&j, NULL);
        jo_string(&j, "name", v.name);
        jo_string(&j, "kind", v.kind);
        jo_string(&j, "group", v.group);
        jo_string(&j, "unit", v.unit);
        jo_string(&j, "description", v.description);
        jo_number(&j, "min", v.min);
        jo_number(&j, "max", v.max);
        jo_number(&j, "default", v.value);
        jo_array(&j, "choices");
        for (uint32_t c = 0; c < v.n_choices; c++) jo_string(&j, NULL, v.choices[c]);
        jo_end(&j);
        jo_array(&j, "targets");
        for (const char *t = v.targets; *t;) {
            char path_text[512];
            const size_t n = strcspn(t, " ");
            snprintf(path_text, sizeof path_text, "%.*s", (int)n, t);
            jo_string(&j, NULL, path_text);
            t += n;
            t += strspn(t, " ");
        }
        jo_end(&j);
        jo_end(&j);
    }
    jo_end(&j);
    jo_array(&j, "parameters");
    for (uint32_t i = 0; i < info.n_parameters; i++) {
        if (lmn_scene_get_parameter(scene, i, &p) != LMN_OK) break;
        jo_object(&j, NULL);
        jo_string(&j, "path", p.path);
        jo_string(&j, "type", p.type);
        jo_string(&j, "value", p.value);
        jo_end(&j);
    }
    jo_end(&j);
    jo_end(&j);
}

static void print_text(const struct params_args *a, const lmn_scene *scene)
{
    lmn_scene_info info;
    lmn_variable_info v;
    lmn_parameter_info p;
    int width = 8;
    lmn_scene_get_info(scene, &info);
    for (uint32_t i = 0; i < info.n_variables; i++)
        if (lmn_scene_get_variable(scene, i, &v) == LMN_OK && (int)strlen(v.name) > width)
            width = (int)strlen(v.name);
    if (info.n_variables > 0)
        printf("%-*s  %-9s  %10s  %10s  %10s  %-4s  %s\n", width, "variable", "kind", "min", "max",
               "default", "unit", "targets");
    else
        printf("no variables\n");
    for (uint32_t i = 0; i < info.n_variables; i++) {
        if (lmn_scene_get_variable(scene, i, &v) != LMN_OK) break;
        printf("%-*s  %-9s  %10g  %10g  %10g  %-4s  %s\n", width, v.name, v.kind, v.min, v.max,
               v.value, v.unit, v.targets);
        for (uint32_t c = 0; c < v.n_choices; c++)
            printf("%-*s  %u: %s\n", width + 2, "", c, v.choices[c]);
    }
    if (!a->all) return;
    printf("\n");
    for (uint32_t i = 0; i < info.n_parameters; i++)
        if (lmn_scene_get_parameter(scene, i, &p) == LMN_OK)
            printf("%s  %s  %s\n", p.path, p.type, p.value);
}

static int run(void *args)
{
    const struct params_args *a = args;
    const char *path = a->common.operands[0];
    struct app app;
    lmn_scene *scene = NULL;
    int code = app_open(&app, &a->common);
    if (code != EXIT_OK) goto done;
    if (is_model_file(path))
        code = load_model_scene(&app, path, a->model_scene, &a->scene, &scene);
    else
        code = load_scene(&app, path, &a->scene, &scene);
    if (code != EXIT_OK) goto done;
    if (a->json)
        print_json(path, scene);
    else
        print_text(a, scene);
done:
    lmn_scene_free(scene);
    app_close(&app);
    return app_flush(code);
}

const struct command command_params = {
    .name = "params",
    .operands = "SCENE|MODEL",
    .summary = "List the variables and parameters of a scene",
    .groups = groups,
    .n_groups = COUNT_OF(groups),
    .args_size = sizeof(struct params_args),
    .run = run,
    .min_operands = 1,
    .max_operands = 1,
};
