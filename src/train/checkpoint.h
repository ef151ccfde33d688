/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_CHECKPOINT_H
#define TRAIN_CHECKPOINT_H

#include "train/history.h"
#include "train/trainer.h"

/*
 * Model files seen from outside (docs/checkpoint-format.md); trainer_save(), trainer_resume() and
 * model_load() are built on them.
 */

/* What a file says of itself. Release with checkpoint_info_release(). cpu_s comes from the metrics
 * beside the file, 0 without them: times are no part of the model. */
lmn_status checkpoint_read_info(const char *path, lmn_model_info *out, struct error *err);
void checkpoint_info_release(lmn_model_info *info);

/* The history in a file, for plots. *names gets n_names = dim strings (the variables, "patch.x",
 * "patch.y"), in one block to be freed by mem_free(). */
lmn_status checkpoint_read_history(const char *path, struct history *out, char ***names,
                                   struct error *err);

/* Where the metrics of a model are: its path with .jsonl in place of its extension, prefixed
 * ".metrics": "box.lmn" -> "box.metrics.jsonl". Free with mem_free(); NULL when memory is short. */
char *metrics_path(const char *model_path);

/* Where a model's state is, which training goes on from: "box.lmn" -> "box.lmn.state". Free with
 * mem_free(); NULL when memory is short. */
char *state_path(const char *model_path);

/* "cpu_s", "trace_s" and "network_s" of the last line whose "step" is at most `step`; what is not
 * found is 0. Pointers may be NULL. */
void metrics_times(const char *metrics_path, uint64_t step, double *cpu_s, double *trace_s,
                   double *network_s);

#endif
