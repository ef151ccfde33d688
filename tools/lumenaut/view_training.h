/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VIEW_TRAINING_H
#define VIEW_TRAINING_H

#include "model_scene.h"
#include "train_args.h"

/*
 * The training that a page of `lumenaut view` can start: `lumenaut train --view` with all that is
 * left open, on the scene shown, or going on with the model shown, for a quarter of an hour more.
 */
struct view_training {
    struct train_args args;
    struct view_words words; /* the same as a command line */
    char *operands[1];       /* of args */
    char output[4096], seconds[32];
    struct model_scene origin; /* of a model */
};

/* path: what is shown, a model when is_model. Returns an exit code after saying why. */
int view_training_plan(struct view_training *t, struct app *app, const char *path, bool is_model,
                       const struct model_args *model, const struct scene_args *scene);

/* Runs it at the address of the page, which is closed. Returns the exit code of `train`. */
int view_training_run(struct view_training *t, const struct view_args *page);
void view_training_release(struct view_training *t);

#endif
