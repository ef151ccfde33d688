/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut render: shows one configuration by a trained network. */
#include "model_scene.h"
#include "movie.h"

#include <stdlib.h>

struct render_args {
    struct common_args common;
    struct picture_args picture;
    struct model_args model;
    const char *path;
};

static const struct arg_option path_options[] = {
    {.name = "path",
     .type = ARG_FILE,
     .argument = "FILE",
     .help = "frames of a path of key frames, as the page of lumenaut view exports it; -o is then "
             "NAME_%04d.png, NAME.y4m, or - with --format y4m",
     .fallback = "none",
     .offset = offsetof(struct render_args, path)},
};

static const struct arg_group groups[] = {
    {"Picture", picture_options, COUNT_OF(picture_options), offsetof(struct render_args, picture)},
    {"Movie", path_options, COUNT_OF(path_options), 0},
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
    jo_picture(&j, &a->picture, image, load_s, render_s);
    jo_values(&j, scene, values);
    jo_camera(&j, camera);
    jo_end(&j);
}

static lmn_render_options options_of(const struct picture_args *p, const lmn_camera *camera)
{
    return (lmn_render_options){.struct_size = sizeof(lmn_render_options),
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
}

/* One picture. */
static int render_one(struct app *app, const struct render_args *a, const lmn_scene *scene,
                      const lmn_model *model, double *values, struct tev *tev, double start_s)
{
    const struct picture_args *p = &a->picture;
    lmn_image *image = NULL;
    double render_s = 0.0;
    int code;
    lmn_camera seen_from;
    const lmn_camera *camera = make_camera(app, scene, values, p, &seen_from, &code);
    if (code != EXIT_OK) return code;
    const lmn_render_options options = options_of(p, camera);
    app_begin(app, "render", NULL, 1.0);
    lmn_status status = lmn_model_render(app->context, model, values, &options, &image, &render_s);
    const double load_s = clock_s() - start_s - render_s;
    if (status != LMN_OK) {
        code = app_failed(app, status, BLAME_USER);
        goto done;
    }
    app_end(app);
    code = put_picture(app, p, tev, a->common.operands[0], image);
    if (code != EXIT_OK) goto done;
    app_say(app, "%s: %ux%u, %.3f s", name_picture(p, a->common.operands[0]),
            lmn_image_width(image), lmn_image_height(image), render_s);
    if (p->json) print_json(a, scene, values, camera, image, load_s, render_s);
done:
    lmn_image_free(image);
    return code;
}

/* Frames of a path: values and camera are its own. */
static int render_path(struct app *app, const struct render_args *a, const lmn_scene *scene,
                       const lmn_model *model, double *values, struct tev *tev)
{
    struct camera_path path;
    struct movie movie;
    lmn_camera camera;
    int code = movie_init(&movie, app, &a->picture);
    if (code == EXIT_OK) code = camera_path_load(&path, app, scene, a->path);
    if (code != EXIT_OK) return code;
    const uint32_t n = camera_path_n_frames(&path);
    const double start_s = clock_s();
    app_begin(app, "render", "frames", n);
    for (uint32_t i = 0; i < n && code == EXIT_OK; i++) {
        lmn_image *image = NULL;
        const lmn_render_options options = options_of(
            &a->picture, camera_path_at(&path, scene, i, values, &camera));
        app->part_start = (double)i / n;
        app->part_size = 1.0 / n;
        const lmn_status status = lmn_model_render(app->context, model, values, &options, &image,
                                                   NULL);
        code = status == LMN_OK ? movie_add(&movie, app, &path, i, image)
                                : app_failed(app, status, BLAME_USER);
        if (code == EXIT_OK) tev_show(tev, app, a->picture.output, image);
        lmn_image_free(image);
    }
    app_end(app);
    if (code == EXIT_OK)
        app_say(app, "%s: %u frames, %.3f s each", a->picture.output, n, (clock_s() - start_s) / n);
    const int ended = movie_end(&movie, app, &path);
    camera_path_release(&path);
    return code == EXIT_OK ? ended : code;
}

/* What a path decides cannot be asked for as well. */
static int check_path(struct app *app, const struct picture_args *p)
{
    const bool has_camera = p->has_origin || p->has_target || p->has_up || p->has_fov;
    if (p->values.n > 0 || has_camera)
        return app_error(app, EXIT_USAGE, "--path: values and camera are those of its keys: no %s",
                         has_camera ? "camera options" : "-P");
    if (p->json) return app_error(app, EXIT_USAGE, "--path: no --json of many frames");
    return EXIT_OK;
}

static int run(void *args)
{
    const struct render_args *a = args;
    const struct picture_args *p = &a->picture;
    struct app app;
    struct tev tev = {.socket = -1};
    lmn_scene *scene = NULL;
    lmn_model *model = NULL;
    double *values = NULL;
    int code = app_open(&app, &a->common);
    const double start_s = clock_s();
    if (code == EXIT_OK) code = a->path ? check_path(&app, p) : check_picture(&app, p);
    if (code == EXIT_OK) code = tev_open(&tev, &app, p->tev);
    if (code == EXIT_OK) code = load_model(&app, a->common.operands[0], &a->model, &scene, &model);
    if (code == EXIT_OK) values = make_values(&app, scene, &p->values, &code);
    if (code == EXIT_OK)
        code = a->path ? render_path(&app, a, scene, model, values, &tev)
                       : render_one(&app, a, scene, model, values, &tev, start_s);
    tev_close(&tev);
    free(values);
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
