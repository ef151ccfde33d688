/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_TRAIN_TINY_H
#define TESTS_TRAIN_TINY_H

#include "base/pool.h"
#include "train/trainer.h"

/*
 * A room with a ball under a lamp and three variables (the ball's roughness and place, and whether
 * it is there), written to a folder of its own and loaded; and options that train it in no time.
 */
struct tiny {
    char folder[64];
    char scene_path[96], variables_path[128];
    struct scene *scene;
    struct world *world;
    struct pool *pool;
    struct workplace place;
};

/* Aborts the test program when something fails. */
void tiny_init(struct tiny *t, uint32_t n_threads);
void tiny_release(struct tiny *t); /* removes the folder and what is in it */

/* One for all tests of a program, with two threads: setup and teardown of the group. */
extern struct tiny tiny;
int tiny_setup(void **state);
int tiny_teardown(void **state);

/* Replaces the first occurrence of a text in the scene and in its variables, and loads it again:
 * nothing made from the scene as it was may be in use any more. */
void tiny_edit(struct tiny *t, const char *old, const char *new);

void tiny_set_threads(struct tiny *t, uint32_t n_threads);

/* A path in the folder; valid until four more calls. */
const char *tiny_path(const struct tiny *t, const char *name);

lmn_train_options tiny_options(void);

/* The whole of a file; free with mem_free(). */
char *tiny_read(const char *path, size_t *size);

#endif
