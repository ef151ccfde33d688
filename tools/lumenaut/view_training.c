/* SPDX-License-Identifier: Apache-2.0 */
#include "view_training.h"

#include <string.h>
#include <unistd.h>

/* How long a training goes on: what `train` does when nothing is said. */
static const double more_s = 900.0;

/* Those that say what is learnt; threads and the like change nothing of it. */
static void make_words(struct view_training *t)
{
    struct view_words *w = &t->words;
    const struct train_args *a = &t->args;
    *w = (struct view_words){0};
    view_words_add(w, "lumenaut", "train");
    view_words_add(w, t->operands[0], NULL);
    for (uint32_t i = 0; i < a->scene.defines.n; i++)
        view_words_add(w, "-D", a->scene.defines.items[i]);
    if (a->scene.variables) view_words_add(w, "--variables", a->scene.variables);
    view_words_add(w, "-o", a->output);
    if (a->resume) view_words_add(w, "--resume", NULL);
    if (a->from) view_words_add(w, "--from", a->from);
    if (a->force) view_words_add(w, "--force", NULL);
    if (a->time_s > 0.0) {
        snprintf(t->seconds, sizeof t->seconds, "%.0fs", a->time_s);
        view_words_add(w, "--time", t->seconds);
    }
    view_words_add(w, "--view", NULL);
}

/* A model with its state goes on; one alone is where a new one begins. */
static int go_on(struct view_training *t, struct app *app, const char *path,
                 const struct model_args *model)
{
    char state[4200];
    struct train_args *a = &t->args;
    const int code = find_model_scene(app, path, model->scene, NULL, &t->origin);
    if (code != EXIT_OK) return code;
    snprintf(t->output, sizeof t->output, "%s", path);
    snprintf(state, sizeof state, "%s.state", path);
    t->operands[0] = t->origin.path;
    a->scene = t->origin.args;
    a->force = model->force;
    a->resume = access(state, R_OK) == 0;
    if (a->resume)
        a->time_s = t->origin.info.cpu_s + more_s;
    else
        a->from = t->output;
    return EXIT_OK;
}

int view_training_plan(struct view_training *t, struct app *app, const char *path, bool is_model,
                       const struct model_args *model, const struct scene_args *scene)
{
    int code = EXIT_OK;
    memset(t, 0, sizeof *t);
    train_args_init(&t->args);
    if (is_model) {
        code = go_on(t, app, path, model);
    } else {
        scene_name(path, t->output, sizeof t->output - 4);
        strcat(t->output, ".lmn");
        t->operands[0] = (char *)path;
        t->args.scene = *scene;
    }
    t->args.common = *app->common;
    t->args.common.operands = t->operands;
    t->args.common.n_operands = 1;
    t->args.output = t->output;
    t->args.view = 1;
    if (code == EXIT_OK) make_words(t);
    return code;
}

int view_training_run(struct view_training *t, const struct view_args *page)
{
    t->args.page = *page;
    return command_train.run(&t->args);
}

void view_training_release(struct view_training *t)
{
    model_scene_release(&t->origin);
}
