/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VIEW_HOST_H
#define VIEW_HOST_H

#include "cli_options.h"
#include "viewer.h"

/* What commands with a page share: its options, its address, and whom it obeys. */
struct view_args {
    uint32_t port;
    const char *bind, *token;
    uint32_t open;
};
extern const struct arg_option view_options[4];

void view_args_init(struct view_args *a);

struct view_host {
    struct app *app;
    const struct view_args *args;
    struct viewer *viewer; /* NULL: not open */
    uint16_t port;         /* once it is open */
    char token[33];        /* a random one */
};

/* The words of commands that make a page's pictures, up to its values; ends with NULL. */
struct view_words {
    const char *list[2 * ARG_LIST_MAX + 16];
    uint32_t n;
};
void view_words_render(struct view_words *w, const char *model, const char *scene, bool is_forced);
void view_words_trace(struct view_words *w, const char *scene, const struct scene_args *args);
void view_words_add(struct view_words *w, const char *option, const char *value);

/* What --port and the others say is wrong with them; before anything takes long. */
int view_args_check(struct app *app, const struct view_args *a);

/* Opens the port; `options` are completed. Returns an exit code after saying why. */
int view_host_open(struct view_host *h, struct app *app, const struct view_args *a,
                   struct viewer_options *options);
void view_host_close(struct view_host *h);

#endif
