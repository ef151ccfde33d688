/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MODEL_SCENE_H
#define MODEL_SCENE_H

#include "cli_options.h"

/* Models name their scene by path; these find it again. */

/* --scene, --force */
struct model_args {
    const char *scene;
    uint32_t force;
};
extern const struct arg_option model_options[2];

/* By name (.lmn) or by content; false for what cannot be read. */
bool is_model_file(const char *path);

/* The files of the scene that a model was trained on: `override` when not NULL; else the path in
 * the model, as it is, or from the model's folder. extra's defines come after the model's own;
 * extra may be NULL. Returns an exit code. */
struct model_scene {
    lmn_model_info info; /* owned, and what args points to */
    char path[4096], variables[4096];
    struct scene_args args;
};
int find_model_scene(struct app *app, const char *model, const char *override,
                     const struct scene_args *extra, struct model_scene *out);
void model_scene_release(struct model_scene *s);

/* The scene of them. */
int load_model_scene(struct app *app, const char *model, const char *override,
                     const struct scene_args *extra, lmn_scene **out);

/* The scene and the model on it. On failure both are NULL or the caller's to free. */
int load_model(struct app *app, const char *path, const struct model_args *args, lmn_scene **scene,
               lmn_model **model);

#endif
