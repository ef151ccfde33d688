/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_LOG_H
#define TRAIN_LOG_H

#include "app.h"

/*
 * metrics.jsonl beside a model: a line that describes the run, then one line per step. It must tell
 * of the model's own steps only, so resuming cuts it back to the step of the checkpoint.
 */
struct train_log {
    char path[4096];
    FILE *f;
    double flushed_s; /* clock */
};

/* "box.lmn" -> "box.metrics.jsonl" */
void train_log_path(const char *model, char *path, size_t size);

/* Opens the log of a model for appending. `step`: lines of later steps are cut off, 0: all. With
 * is_new the file starts empty. *is_empty tells whether the describing line is needed. Returns an
 * exit code. */
int train_log_open(struct train_log *log, struct app *app, const char *model, uint64_t step,
                   bool is_new, bool *is_empty);

/* Adds a line; flushes now and then, so that others can watch. */
void train_log_add(struct train_log *log, const char *line);

/* To be called before the model is saved: what is in the model must be in the log. Returns false
 * when writing failed. */
bool train_log_flush(struct train_log *log);
void train_log_close(struct train_log *log);

#endif
