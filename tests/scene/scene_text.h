/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_SCENE_SCENE_TEXT_H
#define TESTS_SCENE_SCENE_TEXT_H

#include "scene/scene.h" /* before cmocka.h, which has a macro fail() */

/* What cmocka.h wants before it, in its order. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Scenes written in the test, loaded through files in a folder of this process's own. */

static char text_folder[64];
static char text_note[2048]; /* the last note of a load */

static inline int text_setup(void **state)
{
    (void)state;
    snprintf(text_folder, sizeof text_folder, "/tmp/lmn-scene-XXXXXX");
    return mkdtemp(text_folder) ? 0 : -1;
}

static inline int text_teardown(void **state)
{
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", text_folder);
    return system(command);
}

static inline const char *text_path(const char *name)
{
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", text_folder, name);
    return path;
}

static inline void text_write(const char *name, const void *bytes, size_t size)
{
    FILE *f = fopen(text_path(name), "wb");
    if (!f || fwrite(bytes, 1, size, f) != size || fclose(f) != 0) abort();
}

static inline void text_write_string(const char *name, const char *text)
{
    text_write(name, text, strlen(text));
}

static inline void text_on_note(void *user, const char *text)
{
    (void)user;
    snprintf(text_note, sizeof text_note, "%s", text);
}

/* Loads the file `name` of the folder. */
static inline lmn_status text_load_file(const char *name, const char *define, struct scene **out,
                                        struct error *err)
{
    const char *const defines[] = {define};
    struct scene_load_options options = {
        .defines = defines, .n_defines = define != NULL, .note = text_on_note};
    text_note[0] = '\0';
    *out = NULL;
    memset(err, 0, sizeof *err);
    return scene_load(text_path(name), &options, out, err);
}

#define TEXT_SENSOR "<sensor type='perspective'/>"

/* Loads <scene> with `body`, which begins at line 2, column 1. */
static inline lmn_status text_load(const char *body, struct scene **out, struct error *err)
{
    size_t n = strlen(body) + 64;
    char *text = malloc(n);
    if (!text) abort();
    snprintf(text, n, "<scene version='3.0.0'>\n%s\n</scene>", body);
    text_write_string("scene.xml", text);
    free(text);
    return text_load_file("scene.xml", NULL, out, err);
}

/* A scene that must load. */
static inline struct scene *text_scene(const char *body)
{
    struct scene *s;
    struct error err;
    if (text_load(body, &s, &err) != LMN_OK) fail_msg("%s", err.text);
    return s;
}

#endif
