/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VIEWER_VIEWER_H
#define VIEWER_VIEWER_H

#include <stdbool.h>
#include <stdint.h>

#include <lumenaut/lumenaut.h>

/*
 * A page that shows a scene, by its network where there is one: one process, one port, no file but
 * the program. See PROTOCOL.md.
 *
 *   main thread      server.c    HTTP and WebSockets; nothing here waits for a picture
 *   another          studio.c    makes pictures for all sessions (easel.c), the only user of the
 *                                library while the viewer runs
 *   between them     hall.c      what pages want, and what is ready for them
 *
 * While a network is being trained, it is the training's thread that makes the pictures, between
 * steps: viewer_work(); the server then has a thread of its own.
 */
struct viewer_options {
    lmn_context *context; /* its progress callback must ask viewer_is_stale() */
    const lmn_scene *scene;
    const lmn_model *model; /* whose network is shown, or: */
    lmn_trainer *trainer;   /* both NULL: path tracing only */
    const char *scene_path, *model_path;
    const char *const *render, *const *trace; /* words that begin commands; lists end with NULL */
    const char *const *train; /* without a trainer: the words of the training that pages may ask
                                 viewer_run() for, NULL: none */
    const char *notice;       /* told to each page when it comes; NULL: nothing */
    const char *program;                      /* "lumenaut 0.1.0" */
    const char *bind;                         /* an address of this machine */
    const char *token;                        /* NULL: none is asked for */
    uint16_t port;                            /* 0: the first free one from VIEWER_PORT on */
    /* Told once the port is open. */
    void (*on_open)(void *user, const char *url, uint16_t port);
    bool (*must_stop)(void *user); /* asked a few times a second */
    void *user;
};

enum { VIEWER_PORT = 8750, VIEWER_WHY = 300 };

struct viewer;

/* False with the reason in why. */
bool viewer_new(const struct viewer_options *options, struct viewer **out, char why[VIEWER_WHY]);
void viewer_free(struct viewer *v);

/* Serves until must_stop() says so, or a page asks for a training. */
enum viewer_end { VIEWER_FAILED, VIEWER_STOPPED, VIEWER_TRAIN };
enum viewer_end viewer_run(struct viewer *v);

/* With a trainer, in the place of viewer_run(): serves until viewer_free(). */
bool viewer_start(struct viewer *v);

/* What pages ask of the training. */
struct viewer_orders {
    bool is_paused, must_save, must_stop; /* the last two: once */
};

/* Between steps, on the training's thread: makes what pages wait for, within a share of the time,
 * and tells them how the training goes. While it is paused, returns after a while. */
void viewer_work(struct viewer *v, const lmn_train_stats *stats, struct viewer_orders *out);

/* Whether the work under way should end: for progress callbacks, any thread. v may be NULL. */
bool viewer_is_stale(const struct viewer *v);

#endif
