/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_MODEL_H
#define TRAIN_MODEL_H

#include "image/image.h"
#include "train/trainer.h"

/*
 * A trained network with its scene, ready to show any configuration: buffers by tracing the first
 * hit, radiance by the network. One model serves one thread at a time (it uses the pool).
 */
struct model;

/* Refuses a file whose scene has changed unless `force`, and always one whose variables do not
 * match the scene's. */
lmn_status model_load(const struct workplace *place, const char *path, bool force,
                      struct model **out, struct error *err);
void model_free(struct model *m);

const struct scene *model_scene(const struct model *m);

struct model_render_options {
    struct window window; /* full size and what to show of it */
    uint32_t buffer_spp;  /* 0: 16 */
    uint64_t seed;
    uint32_t first_sample;   /* of the buffers */
    bool with_buffers;       /* append buffer_channel_names */
    const struct pose *pose; /* NULL: the configuration's camera */
};

/* The configuration u [n_variables]. *out gets R, G, B (and the buffers). Works through the window
 * in strips, in memory taken at loading; only the image is allocated. render_s (may be NULL):
 * seconds.
 */
lmn_status model_render(struct model *m, const float *u, const struct model_render_options *options,
                        struct image *out, double *render_s, lmn_progress_fn *progress,
                        void *progress_user, struct error *err);

/* Seconds of the last picture: painter_times(). */
void model_times(const struct model *m, double *buffers_s, double *network_s);

/* Mean metrics, noise floor, times and (not NULL) the contact sheet and each configuration's
 * metrics [n]; evaluate.h. options' zeros stand for defaults. */
lmn_status model_eval(struct model *m, const lmn_eval_options *options, lmn_progress_fn *progress,
                      void *progress_user, lmn_eval_result *out, lmn_metrics *each,
                      struct image *sheet, struct error *err);

#endif
