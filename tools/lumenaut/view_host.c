/* SPDX-License-Identifier: Apache-2.0 */
#include "view_host.h"

#include <arpa/inet.h>
#include <malloc.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <unistd.h>

const struct arg_option view_options[4] = {
    {.name = "port",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "port of page and socket",
     .fallback = "the first free one from 8750 on",
     .min = 1,
     .max = 65535,
     .offset = offsetof(struct view_args, port)},
    {.name = "bind",
     .type = ARG_TEXT,
     .argument = "ADDRESS",
     .help = "listen at this address of the machine, with a token where others can reach it",
     .offset = offsetof(struct view_args, bind)},
    {.name = "token",
     .type = ARG_TEXT,
     .argument = "TEXT",
     .help = "who opens the page must know this; it is part of the address that is printed",
     .fallback = "none at 127.0.0.1, elsewhere a random one",
     .offset = offsetof(struct view_args, token)},
    {.name = "open",
     .type = ARG_FLAG,
     .help = "show the page in the browser",
     .offset = offsetof(struct view_args, open)},
};

void view_args_init(struct view_args *a)
{
    a->bind = "127.0.0.1";
}

static bool is_token_plain(const char *token)
{
    static const char letters[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.";
    return *token && strlen(token) < 200 && strspn(token, letters) == strlen(token);
}

/* The one name that is told from an address. */
static const char *address_of(const struct view_args *a)
{
    return strcmp(a->bind, "localhost") == 0 ? "127.0.0.1" : a->bind;
}

int view_args_check(struct app *app, const struct view_args *a)
{
    struct in_addr address;
    if (inet_pton(AF_INET, address_of(a), &address) != 1)
        return app_error(app, EXIT_USAGE, "--bind %s: expected an address, as 127.0.0.1 or 0.0.0.0",
                         a->bind);
    if (a->token && !is_token_plain(a->token))
        return app_error(app, EXIT_USAGE, "--token: letters, digits and -_. only, at most 199");
    return EXIT_OK;
}

static bool is_local(const char *address)
{
    return strncmp(address, "127.", 4) == 0;
}

static void open_browser(struct app *app, const char *url)
{
    char *const words[] = {"xdg-open", (char *)url, NULL};
    pid_t child;
    if (posix_spawnp(&child, words[0], NULL, NULL, words, environ) != 0)
        app_say(app, "note: --open: there is no xdg-open; open the address by hand");
}

static void on_open(void *user, const char *url, uint16_t port)
{
    struct view_host *h = user;
    char name[256] = "HOST";
    h->port = port;
    app_say(h->app, "%s", url);
    if (is_local(address_of(h->args))) {
        if (gethostname(name, sizeof name - 1) != 0 || !*name) snprintf(name, sizeof name, "HOST");
        app_say(h->app, "from another machine: ssh -L %u:127.0.0.1:%u %s", port, port, name);
    }
    if (h->args->open) open_browser(h->app, url);
}

static bool must_stop(void *user)
{
    (void)user;
    return app_signal() != 0;
}

static bool is_stale(void *user)
{
    const struct view_host *h = user;
    return viewer_is_stale(h->viewer);
}

/* Letters of a page's address, 128 random bits. */
static bool make_token(char token[33])
{
    unsigned char bits[16];
    if (getrandom(bits, sizeof bits, 0) != (ssize_t)sizeof bits) return false;
    for (size_t i = 0; i < sizeof bits; i++) snprintf(token + 2 * i, 3, "%02x", bits[i]);
    return true;
}

void view_words_add(struct view_words *w, const char *option, const char *value)
{
    w->list[w->n++] = option;
    if (value) w->list[w->n++] = value;
}

void view_words_render(struct view_words *w, const char *model, const char *scene, bool is_forced)
{
    *w = (struct view_words){0};
    view_words_add(w, "lumenaut", "render");
    view_words_add(w, model, NULL);
    if (scene) view_words_add(w, "--scene", scene);
    if (is_forced) view_words_add(w, "--force", NULL);
    view_words_add(w, "-o", "picture.png");
}

void view_words_trace(struct view_words *w, const char *scene, const struct scene_args *args)
{
    *w = (struct view_words){0};
    view_words_add(w, "lumenaut", "trace");
    view_words_add(w, scene, NULL);
    for (uint32_t i = 0; i < args->defines.n; i++) view_words_add(w, "-D", args->defines.items[i]);
    if (args->variables) view_words_add(w, "--variables", args->variables);
    view_words_add(w, "-o", "picture.exr");
}

/* Pictures of ever other sizes go straight back to the system: glibc would come to keep them in its
 * heaps, which holes between them let grow for an hour. */
static void give_pictures_back(void)
{
#ifdef __GLIBC__
    (void)mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

int view_host_open(struct view_host *h, struct app *app, const struct view_args *a,
                   struct viewer_options *options)
{
    char why[VIEWER_WHY];
    give_pictures_back();
    *h = (struct view_host){.app = app, .args = a};
    options->context = app->context;
    options->program = "lumenaut " LMN_TOOL_VERSION;
    options->bind = address_of(a);
    options->token = a->token;
    options->port = (uint16_t)a->port;
    options->on_open = on_open;
    options->must_stop = must_stop;
    options->user = h;
    if (!a->token && !is_local(options->bind)) {
        if (!make_token(h->token))
            return app_error(app, EXIT_FAILED, "no random numbers for a token");
        options->token = h->token;
    }
    if (!viewer_new(options, &h->viewer, why)) return app_error(app, EXIT_FAILED, "view: %s", why);
    app->is_stale = is_stale;
    app->stale_user = h;
    return EXIT_OK;
}

void view_host_close(struct view_host *h)
{
    viewer_free(h->viewer);
    h->viewer = NULL;
    if (h->app) h->app->is_stale = NULL;
}
