/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MOVIE_H
#define MOVIE_H

#include "camera_path.h"
#include "cli_options.h"

/* Frames of a path: numbered files, or one YUV4MPEG2 stream. */
struct movie {
    const struct picture_args *picture;
    bool is_stream;    /* Y4M, to a file or standard output */
    FILE *stream;      /* NULL: not open */
    char pattern[600]; /* files: with one %d */
};

/* Checks the output: NAME_%04d.png, or NAME.y4m, or - with --format y4m. Returns an exit code. */
int movie_init(struct movie *m, struct app *app, const struct picture_args *picture);

/* Writes frame number `frame`. */
int movie_add(struct movie *m, struct app *app, const struct camera_path *path, uint32_t frame,
              const lmn_image *image);

/* Closes what is open; says on stderr how to make a film of the frames. */
int movie_end(struct movie *m, struct app *app, const struct camera_path *path);

#endif
