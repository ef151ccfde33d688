/* SPDX-License-Identifier: Apache-2.0 */
#include "train_log.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

void train_log_path(const char *model, char *path, size_t size)
{
    const char *slash = strrchr(model, '/'), *name = slash ? slash + 1 : model;
    const char *dot = strrchr(name, '.');
    const int n = dot && dot != name ? (int)(dot - model) : (int)strlen(model);
    snprintf(path, size, "%.*s.metrics.jsonl", n, model);
}

/* The length of the part of the file that tells of steps up to `step`: whole lines only. */
static off_t keep_length(FILE *f, uint64_t step, bool *has_lines)
{
    char *line = NULL;
    size_t capacity = 0;
    off_t kept = 0;
    ssize_t n;
    *has_lines = false;
    while ((n = getline(&line, &capacity, f)) > 0) {
        if (line[n - 1] != '\n') break; /* cut off when the process was killed */
        const char *at = strstr(line, "\"step\":");
        if (at && strtoull(at + 7, NULL, 10) > step) break;
        kept += n;
        *has_lines = true;
    }
    free(line);
    return kept;
}

int train_log_open(struct train_log *log, struct app *app, const char *model, uint64_t step,
                   bool is_new, bool *is_empty)
{
    bool has_lines = false;
    *log = (struct train_log){.flushed_s = clock_s()};
    train_log_path(model, log->path, sizeof log->path);
    if (!is_new) {
        FILE *f = fopen(log->path, "r");
        if (f) {
            const off_t length = keep_length(f, step, &has_lines);
            fclose(f);
            if (truncate(log->path, length) != 0)
                return app_error(app, EXIT_FAILED, "%s: %s", log->path, strerror(errno));
        }
    }
    log->f = fopen(log->path, is_new ? "w" : "a");
    if (!log->f)
        return app_error(app, EXIT_FAILED, "%s: cannot write: %s", log->path, strerror(errno));
    *is_empty = !has_lines;
    return EXIT_OK;
}

void train_log_add(struct train_log *log, const char *line)
{
    fputs(line, log->f);
    fputc('\n', log->f);
    if (clock_s() - log->flushed_s > 2.0) train_log_flush(log);
}

bool train_log_flush(struct train_log *log)
{
    log->flushed_s = clock_s();
    return fflush(log->f) == 0 && !ferror(log->f);
}

void train_log_close(struct train_log *log)
{
    if (log->f) fclose(log->f);
    log->f = NULL;
}
