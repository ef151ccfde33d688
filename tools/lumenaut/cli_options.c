/* SPDX-License-Identifier: Apache-2.0 */
#include "cli_options.h"

#include <stdlib.h>
#include <string.h>

const struct arg_option common_options[6] = {
    {.name = "threads",
     .letter = 't',
     .type = ARG_COUNT,
     .argument = "N",
     .help = "worker threads; results do not depend on it",
     .fallback = "0: every CPU",
     .max = 1024,
     .offset = offsetof(struct common_args, threads)},
    {.name = "cpu-mask",
     .type = ARG_TEXT,
     .argument = "SET",
     .help = "use at most this instruction set: baseline, avx2, avx512, avx512bf16 or amx",
     .fallback = "LMN_CPU_MASK, else the best",
     .offset = offsetof(struct common_args, cpu_mask)},
    {.name = "progress",
     .type = ARG_CHOICE,
     .argument = "HOW",
     .help = "how to show progress on stderr",
     .choices = "auto none bar plain json",
     .offset = offsetof(struct common_args, progress)},
    {.name = "quiet",
     .letter = 'q',
     .type = ARG_FLAG,
     .help = "no progress and no notes, only errors",
     .offset = offsetof(struct common_args, quiet)},
    {.name = "verbose",
     .letter = 'v',
     .type = ARG_FLAG,
     .help = "say more about what is done",
     .offset = offsetof(struct common_args, verbose)},
    {.name = "help",
     .type = ARG_FLAG,
     .help = "show this text",
     .offset = offsetof(struct common_args, help)},
};

const struct arg_option scene_options[2] = {
    {.name = "define",
     .letter = 'D',
     .type = ARG_LIST,
     .argument = "NAME=VALUE",
     .help = "fill $NAME in the scene file, over its <default>; may be repeated",
     .offset = offsetof(struct scene_args, defines)},
    {.name = "variables",
     .type = ARG_FILE,
     .argument = "FILE",
     .help = "read the variables from FILE",
     .fallback = "SCENE.variables.json, where there is one",
     .offset = offsetof(struct scene_args, variables)},
};

const struct arg_option picture_options[17] = {
    {.name = "output",
     .letter = 'o',
     .type = ARG_FILE,
     .argument = "FILE",
     .help = "the image to write: .exr, .png or .pfm; - is standard output",
     .offset = offsetof(struct picture_args, output)},
    {.name = "format",
     .type = ARG_TEXT,
     .argument = "NAME",
     .help = "exr, png or pfm, whatever FILE is called",
     .offset = offsetof(struct picture_args, format)},
    {.name = "tev",
     .type = ARG_TEXT,
     .argument = "HOST:PORT",
     .help = "show it in the image viewer tev, which listens there; needs no FILE",
     .fallback = "not shown; the port is 14158",
     .offset = offsetof(struct picture_args, tev)},
    {.name = "set",
     .letter = 'P',
     .type = ARG_LIST,
     .argument = "NAME=VALUE",
     .help = "set a variable: scene units, a share of its range (50%), a choice's name, or for a "
             "group a,b,c; may be repeated",
     .offset = offsetof(struct picture_args, values)},
    {.name = "origin",
     .type = ARG_VECTOR,
     .argument = "X,Y,Z",
     .help = "where the camera stands, in scene units",
     .fallback = "the scene's, as for the next three",
     .offset = offsetof(struct picture_args, camera.origin),
     .given = offsetof(struct picture_args, has_origin)},
    {.name = "target",
     .type = ARG_VECTOR,
     .argument = "X,Y,Z",
     .help = "what it looks at",
     .fallback = "",
     .offset = offsetof(struct picture_args, camera.target),
     .given = offsetof(struct picture_args, has_target)},
    {.name = "up",
     .type = ARG_VECTOR,
     .argument = "X,Y,Z",
     .help = "what is up in the picture",
     .fallback = "",
     .offset = offsetof(struct picture_args, camera.up),
     .given = offsetof(struct picture_args, has_up)},
    {.name = "fov",
     .type = ARG_NUMBER,
     .argument = "DEGREES",
     .help = "its field of view; the width of an orthographic one, in scene units",
     .fallback = "",
     .min = 1e-9,
     .max = 1e12,
     .offset = offsetof(struct picture_args, camera.fov),
     .given = offsetof(struct picture_args, has_fov)},
    {.name = "size",
     .type = ARG_SIZE,
     .argument = "WxH",
     .help = "size of the whole picture in pixels",
     .fallback = "the scene's",
     .offset = offsetof(struct picture_args, size),
     .given = offsetof(struct picture_args, has_size)},
    {.name = "crop",
     .type = ARG_CROP,
     .argument = "X,Y,W,H",
     .help = "only this window of it",
     .fallback = "all",
     .offset = offsetof(struct picture_args, crop),
     .given = offsetof(struct picture_args, has_crop)},
    {.name = "spp",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "samples per pixel",
     .fallback = "trace: the scene's; render: 16, for the buffers",
     .min = 1,
     .max = 1 << 24,
     .offset = offsetof(struct picture_args, spp)},
    {.name = "max-depth",
     .type = ARG_INTEGER,
     .argument = "N",
     .help = "longest path; 1 shows light sources only, -1 is no limit; of no effect on a network",
     .fallback = "the scene's",
     .min = -1,
     .max = 1 << 20,
     .offset = offsetof(struct picture_args, max_depth),
     .given = offsetof(struct picture_args, has_max_depth)},
    {.name = "rr-depth",
     .type = ARG_INTEGER,
     .argument = "N",
     .help = "path length from which Russian roulette plays; of no effect on a network",
     .fallback = "the scene's",
     .min = 1,
     .max = 1 << 20,
     .offset = offsetof(struct picture_args, rr_depth),
     .given = offsetof(struct picture_args, has_rr_depth)},
    {.name = "seed",
     .type = ARG_WHOLE,
     .argument = "N",
     .help = "seed of all random numbers",
     .offset = offsetof(struct picture_args, seed)},
    {.name = "buffers",
     .type = ARG_FLAG,
     .help = "append position, normal, albedo, roughness and other channels",
     .offset = offsetof(struct picture_args, buffers)},
    {.name = "exposure",
     .type = ARG_NUMBER,
     .argument = "X",
     .help = "factor on radiance before the sRGB curve of PNG",
     .min = 0,
     .max = 1e9,
     .offset = offsetof(struct picture_args, exposure)},
    {.name = "json",
     .type = ARG_FLAG,
     .help = "print one JSON document about the run on stdout",
     .offset = offsetof(struct picture_args, json)},
};

int load_scene(struct app *app, const char *path, const struct scene_args *args, lmn_scene **out)
{
    const lmn_scene_options options = {.struct_size = sizeof options,
                                       .n_defines = args->defines.n,
                                       .defines = args->defines.items,
                                       .variables_path = args->variables};
    const lmn_status status = lmn_scene_load(app->context, path, &options, out);
    return status == LMN_OK ? EXIT_OK : app_failed(app, status, BLAME_INPUT);
}

double *make_values(struct app *app, const lmn_scene *scene, const struct arg_list *assignments,
                    int *code)
{
    lmn_scene_info info;
    lmn_scene_get_info(scene, &info);
    double *values = calloc(info.n_variables + 1u, sizeof *values);
    if (!values) {
        *code = app_error(app, EXIT_FAILED, "out of memory");
        return NULL;
    }
    lmn_scene_default_values(scene, values);
    for (uint32_t i = 0; i < assignments->n; i++) {
        const lmn_status status = lmn_scene_parse_value(app->context, scene, assignments->items[i],
                                                        values);
        if (status != LMN_OK) {
            *code = app_failed(app, status, BLAME_USER);
            free(values);
            return NULL;
        }
    }
    *code = EXIT_OK;
    return values;
}

const lmn_camera *make_camera(struct app *app, const lmn_scene *scene, const double *values,
                              const struct picture_args *p, lmn_camera *out, int *code)
{
    *code = EXIT_OK;
    if (!p->has_origin && !p->has_target && !p->has_up && !p->has_fov) return NULL;
    const lmn_status status = lmn_scene_get_camera(app->context, scene, values, out);
    if (status != LMN_OK) {
        *code = app_failed(app, status, BLAME_USER);
        return NULL;
    }
    if (p->has_origin) memcpy(out->origin, p->camera.origin, sizeof out->origin);
    if (p->has_target) memcpy(out->target, p->camera.target, sizeof out->target);
    if (p->has_up) memcpy(out->up, p->camera.up, sizeof out->up);
    if (p->has_fov) out->fov = p->camera.fov;
    return out;
}

int check_picture(struct app *app, const struct picture_args *p)
{
    if (!p->output && p->tev) return EXIT_OK;
    if (!p->output) return app_error(app, EXIT_USAGE, "no output: give -o FILE");
    if (p->json && strcmp(p->output, "-") == 0)
        return app_error(app, EXIT_USAGE, "--json and -o - both want standard output");
    return app_check_image(app, p->output, p->format);
}

const char *name_picture(const struct picture_args *p, const char *operand)
{
    return p->output ? p->output : operand;
}

int put_picture(struct app *app, const struct picture_args *p, struct tev *tev, const char *operand,
                lmn_image *image)
{
    const lmn_status status =
        p->output ? lmn_image_save(app->context, image, p->output, p->format, p->exposure) : LMN_OK;
    if (status != LMN_OK) return app_failed(app, status, BLAME_WORK);
    tev_show(tev, app, name_picture(p, operand), image);
    return EXIT_OK;
}

void jo_values(struct json_out *j, const lmn_scene *scene, const double *values)
{
    lmn_scene_info info;
    lmn_variable_info v;
    lmn_scene_get_info(scene, &info);
    jo_object(j, "values");
    for (uint32_t i = 0; i < info.n_variables; i++)
        if (lmn_scene_get_variable(scene, i, &v) == LMN_OK) jo_number(j, v.name, values[i]);
    jo_end(j);
}

static void jo_vector(struct json_out *j, const char *key, const double v[3])
{
    jo_array(j, key);
    for (int i = 0; i < 3; i++) jo_number(j, NULL, v[i]);
    jo_end(j);
}

void scene_name(const char *path, char *out, size_t size)
{
    const char *slash = strrchr(path, '/'), *start = slash ? slash + 1 : path;
    const char *end = path + strlen(path);
    if (slash && strcmp(start, "scene.xml") == 0) { /* the folder says what it is */
        end = start = slash;
        while (start > path && start[-1] != '/') start--;
    }
    size_t n = (size_t)(end - start);
    if (n > 4 && strncmp(start + n - 4, ".xml", 4) == 0) n -= 4;
    snprintf(out, size, "%.*s", (int)n, start);
    for (char *c = out; *c; c++)
        if (strchr(" :,*?\"'\\", *c)) *c = '_';
    if (out[0] == '\0' || out[0] == '.') snprintf(out, size, "scene");
}

void jo_picture(struct json_out *j, const struct picture_args *p, const lmn_image *image,
                double load_s, double render_s)
{
    jo_string(j, "output", p->output);
    jo_array(j, "size");
    jo_count(j, NULL, lmn_image_width(image));
    jo_count(j, NULL, lmn_image_height(image));
    jo_end(j);
    jo_count(j, "seed", p->seed);
    jo_number(j, "render_s", render_s);
    jo_number(j, "load_s", load_s);
    jo_count(j, "peak_memory_bytes", app_peak_memory());
}

void jo_camera(struct json_out *j, const lmn_camera *camera)
{
    if (!camera) return;
    jo_object(j, "camera");
    jo_vector(j, "origin", camera->origin);
    jo_vector(j, "target", camera->target);
    jo_vector(j, "up", camera->up);
    jo_number(j, "fov", camera->fov);
    jo_end(j);
}

void jo_metrics(struct json_out *j, const char *key, const lmn_metrics *m)
{
    jo_object(j, key);
    jo_number(j, "mae", m->mae);
    jo_number(j, "mape", m->mape);
    jo_number(j, "relmse", m->relmse);
    jo_number(j, "mse", m->mse);
    jo_number(j, "psnr", m->psnr);
    jo_number(j, "dssim", m->dssim);
    jo_number(j, "dssim_log", m->dssim_log);
    jo_number(j, "dssim_legacy", m->dssim_legacy);
    jo_number(j, "flip", m->flip);
    jo_number(j, "flip_hdr", m->flip_hdr);
    jo_number(j, "exposure", m->exposure);
    jo_end(j);
}

void format_bytes(uint64_t n, char text[32])
{
    const char *unit = "MiB";
    double x = (double)n / (1024.0 * 1024.0);
    if (x >= 1000.0) {
        x /= 1024.0;
        unit = "GiB";
    }
    snprintf(text, 32, "%.*f %s", x < 10.0 ? 2 : 0, x, unit);
}
