/* SPDX-License-Identifier: Apache-2.0 */
#include "viewer.h"

#include <stdio.h>
#include <stdlib.h>

#include "server.h"
#include "studio.h"
#include "training.h"

struct viewer {
    struct viewer_options options;
    struct hall hall;
    struct studio studio;
    struct server *server;
    bool has_hall;
    /* While a network is being trained: */
    struct training training;
    pthread_t server_thread;
    bool has_server_thread;
    atomic_bool must_close;
};

/* Viewing gets no more of the time than this: while something moves, and for refinement. */
#define SHARE_MOVING  0.7
#define SHARE_RESTING 0.25

/* A call of viewer_work() while training, and while it is paused. */
#define WORK_S 0.25
enum { PAUSED_MS = 50 };

static struct message_rules rules_of(const struct viewer_options *o)
{
    lmn_scene_info info;
    lmn_scene_get_info(o->scene, &info);
    return (struct message_rules){.n_variables = info.n_variables,
                                  .has_network = o->model || o->trainer,
                                  .can_train = o->trainer || o->train,
                                  .is_training = o->trainer != NULL,
                                  .is_orthographic = info.orthographic != 0};
}

bool viewer_new(const struct viewer_options *options, struct viewer **out, char why[VIEWER_WHY])
{
    struct viewer *v = calloc(1, sizeof *v);
    const struct message_rules rules = rules_of(options);
    char *text = NULL;
    bool is_made = false;
    *out = NULL;
    snprintf(why, VIEWER_WHY, "out of memory");
    if (!v) return false;
    v->options = *options;
    v->has_hall = hall_init(&v->hall, rules.n_variables);
    const struct hello hello = {.context = options->context,
                                .scene = options->scene,
                                .scene_path = options->scene_path,
                                .model_path = options->model_path,
                                .render = options->render,
                                .trace = options->trace,
                                .train = options->train,
                                .notice = options->notice,
                                .program = options->program};
    const struct studio_options studio = {.context = options->context,
                                          .scene = options->scene,
                                          .model = options->model,
                                          .trainer = options->trainer,
                                          .rules = rules};
    studio_init(&v->studio, &studio, &v->hall);
    is_made = v->has_hall && (!options->trainer ||
                              training_init(&v->training, options->trainer, rules.n_variables));
    if (is_made) text = message_hello(&hello, &rules);
    is_made = text && server_new(&v->options, &rules, text, &v->hall, &v->server, why);
    if (is_made && !options->trainer) {
        is_made = studio_start(&v->studio, &studio, &v->hall);
        if (!is_made) snprintf(why, VIEWER_WHY, "cannot start a thread");
    }
    free(text);
    if (is_made)
        *out = v;
    else
        viewer_free(v);
    return is_made;
}

void viewer_free(struct viewer *v)
{
    if (!v) return;
    if (v->has_hall) hall_close(&v->hall);
    atomic_store(&v->must_close, true);
    if (v->has_server_thread) pthread_join(v->server_thread, NULL);
    if (v->has_hall) studio_stop(&v->studio);
    training_release(&v->training);
    server_free(v->server);
    if (v->has_hall) hall_release(&v->hall);
    free(v);
}

static void tell_address(const struct viewer *v)
{
    const struct viewer_options *o = &v->options;
    const uint16_t port = server_port(v->server);
    char url[400];
    snprintf(url, sizeof url, "http://%s:%u/%s%s", o->bind, port, o->token ? "?token=" : "",
             o->token ? o->token : "");
    if (o->on_open) o->on_open(o->user, url, port);
}

static bool is_over(void *user)
{
    struct viewer *v = user;
    return v->options.must_stop(v->options.user) || hall_wants_start(&v->hall);
}

enum viewer_end viewer_run(struct viewer *v)
{
    tell_address(v);
    if (!server_run(v->server, is_over, v)) return VIEWER_FAILED;
    return v->options.must_stop(v->options.user) ? VIEWER_STOPPED : VIEWER_TRAIN;
}

/* ---- Beside a training ----------------------------------------------------------------------- */

static bool is_closed(void *user)
{
    const struct viewer *v = user;
    return atomic_load(&v->must_close);
}

static void *serve(void *user)
{
    struct viewer *v = user;
    server_run(v->server, is_closed, v);
    return NULL;
}

bool viewer_start(struct viewer *v)
{
    v->has_server_thread = pthread_create(&v->server_thread, NULL, serve, v) == 0;
    if (v->has_server_thread) tell_address(v);
    return v->has_server_thread;
}

static void take_orders(struct hall *h, bool waits, struct viewer_orders *out)
{
    pthread_mutex_lock(&h->lock);
    if (waits && h->is_paused && !h->wants_save && !h->wants_stop) hall_wait(h, PAUSED_MS);
    *out = (struct viewer_orders){h->is_paused, h->wants_save, h->wants_stop};
    h->wants_save = h->wants_stop = false;
    pthread_mutex_unlock(&h->lock);
}

static void tell_training(struct viewer *v, const lmn_train_stats *stats, bool is_running,
                          bool has_new)
{
    char *text;
    if (has_new) {
        text = training_text(&v->training, stats, is_running, true);
        hall_send_training(&v->hall, text, true);
        free(text);
    }
    if (!training_is_due(&v->training)) return;
    text = training_text(&v->training, stats, is_running, false);
    hall_send_training(&v->hall, text, false);
    free(text);
}

void viewer_work(struct viewer *v, const lmn_train_stats *stats, struct viewer_orders *out)
{
    const double start = hall_clock_s();
    const double share = training_view_share(&v->training);
    bool has_new, has_worked = false;
    const bool is_watched = hall_n_sessions(&v->hall, &has_new) > 0;
    take_orders(&v->hall, false, out);
    while (is_watched && (out->is_paused || share < SHARE_MOVING) &&
           hall_clock_s() - start < WORK_S &&
           studio_work(&v->studio, out->is_paused || share < SHARE_RESTING)) {
        has_worked = true;
        if (!out->is_paused) break; /* one thing, then a step */
    }
    training_note(&v->training, stats, has_worked ? hall_clock_s() - start : 0.0);
    if (is_watched) tell_training(v, stats, !out->is_paused, has_new);
    if (out->is_paused && !has_worked && !out->must_save && !out->must_stop)
        take_orders(&v->hall, true, out);
}

bool viewer_is_stale(const struct viewer *v)
{
    return v && studio_is_stale(&v->studio);
}
