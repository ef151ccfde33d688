/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_MODEL_FILE_H
#define TRAIN_MODEL_FILE_H

#include "train/layout.h"
#include "train/meaning.h"
#include "train/safetensors.h"
#include "train/trainer.h"

/* 1 had model and state in one file. */
enum { MODEL_VERSION = 3 };

/*
 * A model file or the state beside it, opened and understood but for its tensors
 * (docs/checkpoint-format.md).
 */
struct model_file {
    struct safetensors st;
    lmn_train_options options;
    uint64_t scene_hash, step;
    uint64_t training;                                /* which one: model and state must agree */
    bool has_training;                                /* a state: not only weights */
    const char *scene_path, *variables_path, *config; /* texts in the file */
    struct field_config field; /* improved method: the network, max_pixels 0 */
    struct meaning meaning;    /* and what its inputs stand for */
    uint32_t n_defines, n_names;
    char **defines; /* [n_defines]; owned, in one block */
    char **names;   /* [n_names], the scene's variables; owned, in one block */
};

lmn_status model_file_open(struct model_file *m, const char *path, struct error *err);
void model_file_release(struct model_file *m);

/* The improved method's: whether its network is the one that the scene asks for. */
lmn_status model_file_check_field(const struct model_file *m, const struct field_config *want,
                                  struct error *err);

size_t model_file_n_weights(const struct model_file *m);

/* The faithful method's network that the file's weights are for. */
struct generator_config model_file_network(const struct model_file *m);

/* Fails when the file was made from another scene (with `force`: only when the variables do not
 * match in number). */
lmn_status model_file_check_scene(const struct model_file *m, const struct scene *s, bool force,
                                  struct error *err);

/* Whether all tensors of the network are there in the right shapes: to be asked before memory is
 * taken on the word of the file. */
lmn_status model_file_check_weights(const struct model_file *m, struct error *err);

/* weights [model_file_n_weights()] */
lmn_status model_file_read_weights(const struct model_file *m, float *weights, struct error *err);

/* Steps and history of the training: counters and averages as in docs/checkpoint-format.md. */
enum model_counter {
    COUNTER_STEP,
    COUNTER_TRACED,
    COUNTER_ADAM,
    COUNTER_GENERATION,
    COUNTER_REUSE_EVENTS,
    COUNTER_REPLAY_ADDED,
    COUNTER_HISTORY_STRIDE,
    COUNTER_HISTORY_PENDING,
    COUNTER_SNAPSHOT_STRIDE,
    N_COUNTERS
};
enum model_average { AVERAGE_LOSS_NEW, AVERAGE_LOSS_EXIST, AVERAGE_ACCEPTANCE, N_AVERAGES };

lmn_status model_file_read_counters(const struct model_file *m, int64_t counters[N_COUNTERS],
                                    double averages[N_AVERAGES], struct error *err);

/* *out is initialised here. */
lmn_status model_file_read_history(const struct model_file *m, struct history *out,
                                   struct error *err);

#endif
