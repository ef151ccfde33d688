/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_IMAGE_TEMP_H
#define TESTS_IMAGE_TEMP_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A folder of this process's own, for files that tests write. */
static char temp_folder[64];

static inline int temp_setup(void **state)
{
    (void)state;
    snprintf(temp_folder, sizeof temp_folder, "/tmp/lmn-test-XXXXXX");
    return mkdtemp(temp_folder) ? 0 : -1;
}

static inline int temp_teardown(void **state)
{
    (void)state;
    return rmdir(temp_folder); /* fails when a test left a file */
}

/* The path of a file in it; valid until the next call. */
static inline const char *temp_path(const char *name)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", temp_folder, name);
    return path;
}

static inline const char *temp_write(const char *name, const void *bytes, size_t size)
{
    const char *path = temp_path(name);
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, size, f) != size || fclose(f) != 0) abort();
    return path;
}

#endif
