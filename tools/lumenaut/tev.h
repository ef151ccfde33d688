/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TEV_H
#define TEV_H

#include "app.h"

/*
 * Pictures shown by tev, the image viewer (https://github.com/Tom94/tev), where one runs: its
 * protocol over TCP, a picture's channels and then its pixels in parts.
 */
struct tev {
    int socket; /* -1: none */
    const char *address;
    uint32_t width, height, n_channels; /* of the picture that is there; 0: none is */
};

/* Connects to HOST:PORT or HOST; NULL: to none, which takes every picture and shows it nowhere.
 * Returns an exit code after saying why. */
int tev_open(struct tev *t, struct app *app, const char *address);
void tev_close(struct tev *t);

/* In the place of what was shown by the same name. When it is gone that is told, once. */
void tev_show(struct tev *t, struct app *app, const char *name, lmn_image *image);

#endif
