/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VIEWER_ASSETS_H
#define VIEWER_ASSETS_H

#include <stddef.h>

/* The files of viewer/web, put into the program when it is built (embed.cmake). */
struct asset {
    const char *path; /* as asked for: "/", "/view.css" */
    const char *type;
    const unsigned char *bytes;
    size_t size;
};
extern const struct asset assets[];
extern const size_t n_assets;

#endif
