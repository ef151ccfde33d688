/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BASE_FILE_H
#define BASE_FILE_H

#include <stddef.h>
#include <stdio.h>

#include "base/error.h"

/* Reads a whole regular file. *out gets one extra NUL byte after *size bytes; free with mem_free().
 * Refuses files above `max_size` bytes. The message names the path and the reason. */
lmn_status file_read(const char *path, size_t max_size, char **out, size_t *size,
                     struct error *err);

/*
 * Writes a file so that a reader sees the old or the new one, never a part: the bytes go to a
 * temporary name beside it, which file_writer_commit() syncs and renames.
 *
 *   struct file_writer w;
 *   TRY(file_writer_open(&w, path, err));   fwrite(..., w.f);
 *   TRY(file_writer_commit(&w, err));
 *   done: file_writer_release(&w);          // removes the temporary file unless committed
 *
 * "-" as path stands for standard output, unbuffered by any temporary.
 */
struct file_writer {
    FILE *f;
    char *path, *temporary; /* owned */
};

lmn_status file_writer_open(struct file_writer *w, const char *path, struct error *err);
lmn_status file_writer_commit(struct file_writer *w, struct error *err);
void file_writer_release(struct file_writer *w);

/* Removes the temporary files beside `path` that processes left which were killed while they wrote
 * it. What cannot be removed stays. */
void file_remove_leftovers(const char *path);

#endif
