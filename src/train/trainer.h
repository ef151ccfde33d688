/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_TRAINER_H
#define TRAIN_TRAINER_H

#include "nn/generator.h"
#include "render/view.h"
#include "train/history.h"

struct pool;
struct trainer;

/*
 * What training and rendering work on; everything is the caller's and must outlive what is made
 * from it. path, variables_path and defines only travel in the model file, so that it can be opened
 * by its own path alone.
 */
struct workplace {
    const struct scene *scene;
    const struct world *world;
    struct pool *pool;
    uint32_t cpu;               /* flags of base/cpu.h that kernels may use */
    const char *scene_path;     /* as the user gave it */
    const char *variables_path; /* NULL or "": the default */
    const char *const *defines; /* "name=value" */
    uint32_t n_defines;
};

/*
 * A training by one of two methods, options->method. The improved one is struct learner's
 * (learner.h). The faithful one: the paper's network trained by Markov chains (explorer.h), the
 * loss x would-be-Adam-step target function, reuse of samples (reuse.h, replay.h) and growing
 * resolution. All memory is taken here, but for what trainer_eval() keeps.
 */
lmn_status trainer_new(const struct workplace *place, const lmn_train_options *options,
                       struct trainer **out, struct error *err);

/* Continues the training of a model from the state beside it (state_path()), as if it had not
 * stopped; the model itself need not be there. Refuses a changed scene unless `force`, and a state
 * that is another training's than the model. The processor time used so far comes from the metrics
 * beside it (metrics_path()), 0 without them. */
lmn_status trainer_resume(const struct workplace *place, const char *path, bool force,
                          struct trainer **out, struct error *err);
void trainer_free(struct trainer *t);

/* Gives a training by the improved method that has not made a step yet the weights of a model of
 * that method, trained on another version of the scene, of the same width and depth. Weights are
 * taken over by what they stand for (meaning.h): the grids of what moves and the features by its
 * name, columns of variables by theirs. What is new stays as it is, what is gone is dropped.
 * *report (may be NULL) gets lines "taken over: variable door", "new: ...", "dropped: ...", without
 * a newline at the end; the trainer's. */
lmn_status trainer_start_from(struct trainer *t, const char *path, const char **report,
                              struct error *err);

/* One step of the optimiser. stats (may be NULL) as trainer_get_stats(). Fails only when the loss
 * is no longer a number; the weights are then as they were before the step. */
lmn_status trainer_step(struct trainer *t, lmn_train_stats *stats, struct error *err);
void trainer_get_stats(const struct trainer *t, lmn_train_stats *stats);
const lmn_train_options *trainer_options(const struct trainer *t);

/* The k-th configuration of those where training looks now, to u [n_variables]: a chain's state, or
 * the k-th last that was traced. False: there are no more. */
bool trainer_state(const struct trainer *t, uint32_t k, float *u);

/* The checkpoint (docs/checkpoint-format.md): first the state that training goes on from, at
 * state_path(path), then the model with what rendering needs, at `path`. Whenever it is stopped,
 * what is there can be resumed. Two trainings that made the same steps write the same bytes. */
lmn_status trainer_save(const struct trainer *t, const char *path, struct error *err);

/* Mean metrics of the network as it is now on the fixed test set that `options` names (evaluate.h).
 * The references are traced at the first call and kept as long as the options stay the same. The
 * time is not counted as training. Also goes into the next metrics line. */
lmn_status trainer_eval(struct trainer *t, const lmn_eval_options *options,
                        lmn_progress_fn *progress, void *progress_user, lmn_metrics *out,
                        struct error *err);

/* Renders the configuration u by the network as it is now; as model_render(). Not counted as
 * training. */
struct model_render_options;
struct image;
lmn_status trainer_render(struct trainer *t, const float *u,
                          const struct model_render_options *options, struct image *out,
                          double *render_s, lmn_progress_fn *progress, void *progress_user,
                          struct error *err);

/* One line of metrics.jsonl without the newline: before this object's first step the line that
 * describes the run, then the step just made. Valid until the next call; NULL when memory is short.
 * The format is in docs/checkpoint-format.md. */
const char *trainer_metrics_line(struct trainer *t);

#endif
