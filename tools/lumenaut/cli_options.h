/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H

#include "app.h"
#include "json_out.h"
#include "tev.h"

/* Options that several commands share, and what they stand for. */

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/* -t, --cpu-mask, --progress, -q, -v, --help: at offset 0 of every arguments struct. */
extern const struct arg_option common_options[6];
#define COMMON_GROUP                                           \
    {                                                          \
        "General", common_options, COUNT_OF(common_options), 0 \
    }

/* -D, --variables: how a scene file is read. */
struct scene_args {
    struct arg_list defines;
    const char *variables;
};
extern const struct arg_option scene_options[2];

/* What trace and render share: which configuration, which part of the picture, where it goes. */
struct picture_args {
    const char *output, *format;
    uint32_t size[2], has_size;
    uint32_t crop[4], has_crop;
    uint32_t spp;
    int32_t max_depth, rr_depth;
    uint32_t has_max_depth, has_rr_depth;
    uint64_t seed;
    uint32_t buffers;
    double exposure;
    struct arg_list values; /* -P */
    lmn_camera camera;
    uint32_t has_origin, has_target, has_up, has_fov;
    uint32_t json;
    const char *tev; /* NULL: none */
};
extern const struct arg_option picture_options[17];

/* Loads a scene as the arguments say. Returns an exit code; *out is the caller's to free. */
int load_scene(struct app *app, const char *path, const struct scene_args *args, lmn_scene **out);

/* What to call a scene: "scenes/demo/scene.xml" demo, "scenes/box.xml" box. */
void scene_name(const char *path, char *out, size_t size);

/* An array of the scene's variables with every -P applied; free() it. NULL after saying why, with
 * the exit code in *code. */
double *make_values(struct app *app, const lmn_scene *scene, const struct arg_list *assignments,
                    int *code);

/* The camera that options ask for, in *out, what they leave out being the configuration's. Returns
 * it; NULL when they ask for none, or after saying why, with the exit code in *code. */
const lmn_camera *make_camera(struct app *app, const lmn_scene *scene, const double *values,
                              const struct picture_args *p, lmn_camera *out, int *code);

/* Members for JSON documents. */
void jo_picture(struct json_out *j, const struct picture_args *p, const lmn_image *image,
                double load_s, double render_s);
void jo_values(struct json_out *j, const lmn_scene *scene, const double *values);
void jo_camera(struct json_out *j, const lmn_camera *camera); /* NULL: nothing */
void jo_metrics(struct json_out *j, const char *key, const lmn_metrics *m);

/* "1.5 GiB" */
void format_bytes(uint64_t n, char text[32]);

/* Checks the output before work is done on it. Returns an exit code after saying why. */
int check_picture(struct app *app, const struct picture_args *p);

/* Saves the picture of an operand where it is wanted, and shows it. Returns an exit code. */
int put_picture(struct app *app, const struct picture_args *p, struct tev *tev, const char *operand,
                lmn_image *image);

/* How pictures are called: by their file, else by what they are of. */
const char *name_picture(const struct picture_args *p, const char *operand);

extern const struct command command_trace, command_train, command_render, command_eval,
    command_compare, command_params, command_plot, command_view, command_bench, command_info;

#endif
