/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut trace: path-traces one configuration of a scene. */
#include "cli_options.h"

#include <stdlib.h>

struct trace_args {
    struct common_args common;
    struct scene_args scene;
    struct picture_args picture;
    uint32_t half_buffers;
    const char *light_groups;
    uint32_t follow_delta, split_delta;
    uint32_t sampler, mis, integrator;
};

enum { ROUGH = 16 }; /* of so many samples one is looked at first */

static const char *const sampler_names[] = {"sobol", "independent"};
static const char *const mis_names[] = {"power", "balance"};
static const char *const integrator_names[] = {NULL, "auto", "path", "path+photons"};

static const struct arg_option trace_options[] = {
    {.name = "half-buffers",
     .type = ARG_FLAG,
     .help = "append two pictures of independent halves of the samples, a.R .. and b.R ..",
     .offset = offsetof(struct trace_args, half_buffers)},
    {.name = "light-groups",
     .type = ARG_MAYBE,
     .argument = "GROUPS",
     .help = "append the light of each emitter, or of each group, as "
             "\"ceiling=lamp_1,lamp_2;outside=sky\": NAME.R ..; their sum is the picture",
     .fallback = "the scene's groups, where it has some",
     .offset = offsetof(struct trace_args, light_groups)},
    {.name = "follow-delta",
     .type = ARG_FLAG,
     .help = "buffers show what is behind mirrors and glass, with throughput, emission and length "
             "of the way there, chain_throughput.R ..; implies --buffers",
     .offset = offsetof(struct trace_args, follow_delta)},
    {.name = "split-delta",
     .type = ARG_FLAG,
     .help = "append the picture in two: lights seen directly or by mirrors and glass alone, "
             "seen.R .., and the rest, rest.R ..",
     .offset = offsetof(struct trace_args, split_delta)},
    {.name = "sampler",
     .type = ARG_CHOICE,
     .argument = "NAME",
     .help = "where samples come from: scrambled points that keep apart, or random numbers",
     .choices = "sobol independent",
     .offset = offsetof(struct trace_args, sampler)},
    {.name = "mis",
     .type = ARG_CHOICE,
     .argument = "NAME",
     .help = "weights of multiple importance sampling",
     .choices = "power balance",
     .offset = offsetof(struct trace_args, mis)},
    {.name = "integrator",
     .type = ARG_CHOICE,
     .argument = "NAME",
     .help =
         "how light is found; photons bring caustics, biased a little at few samples; auto uses "
         "them where they help",
     .fallback = "scene: the scene's, else auto",
     .choices = "scene auto path path+photons",
     .offset = offsetof(struct trace_args, integrator)},
};

static const struct arg_group groups[] = {
    {"Picture", picture_options, COUNT_OF(picture_options), offsetof(struct trace_args, picture)},
    {"Tracing", trace_options, COUNT_OF(trace_options), 0},
    {"Scene", scene_options, COUNT_OF(scene_options), offsetof(struct trace_args, scene)},
    COMMON_GROUP,
};

static void init(void *args)
{
    struct trace_args *a = args;
    a->picture.exposure = 1.0;
}

static void print_json(const struct trace_args *a, const lmn_scene *scene, const double *values,
                       const lmn_camera *camera, const lmn_image *image, uint32_t spp,
                       double load_s, double render_s)
{
    struct json_out j = {.f = stdout};
    const uint32_t width = lmn_image_width(image), height = lmn_image_height(image);
    jo_object(&j, NULL);
    jo_string(&j, "command", "trace");
    jo_string(&j, "scene", a->common.operands[0]);
    jo_picture(&j, &a->picture, image, load_s, render_s);
    jo_count(&j, "spp", spp);
    jo_string(&j, "integrator", lmn_image_attribute(image, "integrator"));
    jo_number(&j, "paths_per_s", (double)width * height * spp / render_s);
    jo_values(&j, scene, values);
    jo_camera(&j, camera);
    jo_array(&j, "channels");
    for (uint32_t c = 0; c < lmn_image_n_channels(image); c++)
        jo_string(&j, NULL, lmn_image_channel_name(image, c));
    jo_end(&j);
    jo_end(&j);
}

/* What to look at while the picture is made: one of few of its samples. */
static lmn_status show_rough(struct app *app, const struct trace_args *a, struct tev *tev,
                             const lmn_scene *scene, const double *values,
                             const lmn_trace_options *options, uint32_t spp)
{
    lmn_trace_options rough = *options;
    lmn_image *image = NULL;
    rough.spp = spp / ROUGH;
    if (tev->socket < 0 || rough.spp == 0) return LMN_OK;
    app->is_silent = true;
    const lmn_status status = lmn_scene_trace(app->context, scene, values, &rough, &image, NULL);
    app->is_silent = false;
    if (status == LMN_OK)
        tev_show(tev, app, name_picture(&a->picture, a->common.operands[0]), image);
    lmn_image_free(image);
    return status;
}

static int run(void *args)
{
    const struct trace_args *a = args;
    const struct picture_args *p = &a->picture;
    struct app app;
    struct tev tev = {.socket = -1};
    lmn_scene *scene = NULL;
    lmn_image *image = NULL;
    lmn_scene_info info;
    double *values = NULL, render_s = 0.0;
    lmn_camera seen_from;
    const lmn_camera *camera = NULL;
    lmn_status status;
    int code = app_open(&app, &a->common);
    const double start_s = clock_s();

    if (code == EXIT_OK) code = check_picture(&app, p);
    if (code == EXIT_OK) code = tev_open(&tev, &app, p->tev);
    if (code == EXIT_OK) code = load_scene(&app, a->common.operands[0], &a->scene, &scene);
    if (code == EXIT_OK) values = make_values(&app, scene, &p->values, &code);
    if (code == EXIT_OK) camera = make_camera(&app, scene, values, p, &seen_from, &code);
    if (code != EXIT_OK) goto done;

    const lmn_trace_options options = {.struct_size = sizeof options,
                                       .width = p->size[0],
                                       .height = p->size[1],
                                       .crop_x = p->crop[0],
                                       .crop_y = p->crop[1],
                                       .crop_width = p->crop[2],
                                       .crop_height = p->crop[3],
                                       .spp = p->spp,
                                       .has_max_depth = p->has_max_depth,
                                       .has_rr_depth = p->has_rr_depth,
                                       .max_depth = p->max_depth,
                                       .rr_depth = p->rr_depth,
                                       .seed = p->seed,
                                       .buffers = p->buffers || a->follow_delta,
                                       .half_buffers = a->half_buffers,
                                       .light_groups = a->light_groups != NULL,
                                       .light_group_names = a->light_groups,
                                       .follow_delta = a->follow_delta,
                                       .split_delta = a->split_delta,
                                       .sampler = sampler_names[a->sampler],
                                       .mis = mis_names[a->mis],
                                       .integrator = integrator_names[a->integrator],
                                       .camera = camera};
    lmn_scene_get_info(scene, &info);
    const uint32_t width = p->has_crop ? p->crop[2] : p->has_size ? p->size[0] : info.width;
    const uint32_t height = p->has_crop ? p->crop[3] : p->has_size ? p->size[1] : info.height;
    uint32_t spp = p->spp ? p->spp : info.spp;
    app_detail(&app, "%s: %llu triangles, %u instances, %u variables", a->common.operands[0],
               (unsigned long long)info.n_triangles, info.n_instances, info.n_variables);
    app_begin(&app, "trace", "paths", (double)width * height * spp);
    const double rough_start_s = clock_s();
    status = show_rough(&app, a, &tev, scene, values, &options, spp);
    const double rough_s = clock_s() - rough_start_s;
    if (status == LMN_OK)
        status = lmn_scene_trace(app.context, scene, values, &options, &image, &render_s);
    const double load_s = clock_s() - start_s - rough_s - render_s;
    if (status != LMN_OK) {
        code = app_failed(&app, status, BLAME_USER);
        goto done;
    }
    app_end(&app);
    spp = (uint32_t)strtoul(lmn_image_attribute(image, "spp"), NULL, 10); /* halves round it up */
    code = put_picture(&app, p, &tev, a->common.operands[0], image);
    if (code != EXIT_OK) goto done;
    app_say(&app, "%s: %ux%u, %u spp, %.2f s (%.3g Mpaths/s)",
            name_picture(p, a->common.operands[0]), width, height, spp, render_s,
            1e-6 * width * height * spp / render_s);
    if (p->json) print_json(a, scene, values, camera, image, spp, load_s, render_s);
done:
    tev_close(&tev);
    free(values);
    lmn_image_free(image);
    lmn_scene_free(scene);
    app_close(&app);
    return app_flush(code);
}

const struct command command_trace = {
    .name = "trace",
    .operands = "SCENE",
    .summary = "Path-trace one configuration of a scene",
    .groups = groups,
    .n_groups = COUNT_OF(groups),
    .args_size = sizeof(struct trace_args),
    .init = init,
    .run = run,
    .min_operands = 1,
    .max_operands = 1,
};
