/* SPDX-License-Identifier: Apache-2.0 */
#include "hall.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

const char *const shown_buffer_names[SHOWN_BUFFERS] = {"albedo",    "normal", "position",
                                                       "roughness", "depth",  "emission"};

double hall_clock_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

bool hall_init(struct hall *h, uint32_t n_variables)
{
    pthread_condattr_t attributes;
    *h = (struct hall){.n_variables = n_variables};
    if (pthread_mutex_init(&h->lock, NULL) != 0) return false;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    const bool is_made = pthread_cond_init(&h->news, &attributes) == 0;
    pthread_condattr_destroy(&attributes);
    if (!is_made) pthread_mutex_destroy(&h->lock);
    return is_made;
}

static void session_free(struct session *s)
{
    free(s->wish.values);
    for (int k = 0; k < LAYERS; k++) free(s->frames[k].memory);
    free(s->file.memory);
    for (uint32_t i = 0; i < s->n_texts; i++) free(s->texts[i]);
    free(s);
}

void hall_release(struct hall *h)
{
    for (uint32_t i = 0; i < h->n_sessions; i++) session_free(h->sessions[i]);
    pthread_cond_destroy(&h->news);
    pthread_mutex_destroy(&h->lock);
}

static void wake_server(struct hall *h)
{
    if (h->wake_server) h->wake_server(h->server);
}

struct session *hall_enter(struct hall *h)
{
    struct session *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    s->wish.values = calloc(h->n_variables + 1u, sizeof *s->wish.values);
    pthread_mutex_lock(&h->lock);
    if (s->wish.values && h->n_sessions < HALL_SESSIONS) {
        h->sessions[h->n_sessions++] = s;
        pthread_mutex_unlock(&h->lock);
        return s;
    }
    pthread_mutex_unlock(&h->lock);
    session_free(s);
    return NULL;
}

void hall_leave(struct hall *h, struct session *s)
{
    pthread_mutex_lock(&h->lock);
    s->is_gone = true;
    atomic_fetch_add(&h->n_wishes, 1); /* what was under way for it need not be finished */
    pthread_cond_signal(&h->news);
    pthread_mutex_unlock(&h->lock);
}

void hall_close(struct hall *h)
{
    pthread_mutex_lock(&h->lock);
    atomic_store(&h->is_closing, true);
    atomic_fetch_add(&h->n_wishes, 1);
    pthread_cond_signal(&h->news);
    pthread_mutex_unlock(&h->lock);
}

void hall_set_wish(struct hall *h, struct session *s, struct wish *wish)
{
    pthread_mutex_lock(&h->lock);
    free(s->wish.values);
    s->wish = *wish;
    s->has_wish = true;
    wish->values = NULL;
    atomic_fetch_add(&h->n_wishes, 1);
    pthread_cond_signal(&h->news);
    pthread_mutex_unlock(&h->lock);
}

void hall_acknowledge(struct hall *h, struct session *s, uint32_t frame)
{
    pthread_mutex_lock(&h->lock);
    for (uint32_t i = 0; i < s->n_under_way; i++)
        if (s->under_way[i] == frame) {
            s->under_way[i] = s->under_way[--s->n_under_way];
            s->waits_since_s = hall_clock_s();
            pthread_cond_signal(&h->news);
            break;
        }
    pthread_mutex_unlock(&h->lock);
}

void hall_ask_pixel(struct hall *h, struct session *s, uint32_t id, uint32_t x, uint32_t y)
{
    pthread_mutex_lock(&h->lock);
    s->pixel.is_wanted = true;
    s->pixel.id = id;
    s->pixel.x = x;
    s->pixel.y = y;
    pthread_cond_signal(&h->news);
    pthread_mutex_unlock(&h->lock);
}

void hall_ask_capture(struct hall *h, struct session *s, uint32_t id, enum layer layer,
                      enum capture_format format)
{
    pthread_mutex_lock(&h->lock);
    s->capture.is_wanted = true;
    s->capture.id = id;
    s->capture.layer = layer;
    s->capture.format = format;
    pthread_cond_signal(&h->news);
    pthread_mutex_unlock(&h->lock);
}

void hall_order(struct hall *h, enum train_action action)
{
    pthread_mutex_lock(&h->lock);
    if (action != TRAIN_SAVE) h->is_paused = action == TRAIN_PAUSE;
    h->wants_save |= action == TRAIN_SAVE;
    h->wants_stop |= action == TRAIN_STOP;
    h->wants_start |= action == TRAIN_START;
    pthread_cond_signal(&h->news);
    pthread_mutex_unlock(&h->lock);
}

bool hall_wants_start(struct hall *h)
{
    pthread_mutex_lock(&h->lock);
    const bool wants = h->wants_start;
    pthread_mutex_unlock(&h->lock);
    return wants;
}

double hall_waits_s(struct hall *h, const struct session *s)
{
    pthread_mutex_lock(&h->lock);
    const double waits = s->n_under_way > 0 ? hall_clock_s() - s->waits_since_s : 0.0;
    pthread_mutex_unlock(&h->lock);
    return waits;
}

void hall_wait(struct hall *h, int ms)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += ms * 1000000L;
    until.tv_sec += until.tv_nsec / 1000000000L;
    until.tv_nsec %= 1000000000L;
    pthread_cond_timedwait(&h->news, &h->lock, &until);
}

void hall_sweep(struct hall *h, void (*free_easel)(struct easel *e))
{
    for (uint32_t i = 0; i < h->n_sessions;) {
        struct session *s = h->sessions[i];
        if (!s->is_gone) {
            i++;
            continue;
        }
        h->sessions[i] = h->sessions[--h->n_sessions];
        free_easel(s->easel);
        session_free(s);
    }
}

static void add_text(struct session *s, char *text)
{
    if (s->n_texts == HALL_TEXTS) {
        free(s->texts[0]);
        memmove(s->texts, s->texts + 1, --s->n_texts * sizeof *s->texts);
    }
    s->texts[s->n_texts++] = text;
}

void hall_send_text(struct hall *h, struct session *s, char *text)
{
    if (!text) return; /* no memory: the page asks again, or sees it later */
    pthread_mutex_lock(&h->lock);
    add_text(s, text);
    pthread_mutex_unlock(&h->lock);
    wake_server(h);
}

void hall_send_training(struct hall *h, const char *text, bool is_for_new)
{
    if (!text) return;
    pthread_mutex_lock(&h->lock);
    for (uint32_t i = 0; i < h->n_sessions; i++) {
        struct session *s = h->sessions[i];
        char *copy = s->is_gone || s->knows_training == is_for_new ? NULL : strdup(text);
        if (!copy) continue;
        add_text(s, copy);
        s->knows_training = true;
    }
    pthread_mutex_unlock(&h->lock);
    wake_server(h);
}

uint32_t hall_n_sessions(struct hall *h, bool *has_new)
{
    pthread_mutex_lock(&h->lock);
    const uint32_t n = h->n_sessions;
    *has_new = false;
    for (uint32_t i = 0; i < n; i++) *has_new |= !h->sessions[i]->knows_training;
    pthread_mutex_unlock(&h->lock);
    return n;
}

void hall_send_frame(struct hall *h, struct session *s, enum layer layer, struct parcel parcel)
{
    pthread_mutex_lock(&h->lock);
    free(s->frames[layer].memory); /* nobody has seen it, and nobody needs to */
    s->frames[layer] = parcel;
    pthread_mutex_unlock(&h->lock);
    wake_server(h);
}

void hall_send_file(struct hall *h, struct session *s, char *text, struct parcel parcel)
{
    pthread_mutex_lock(&h->lock);
    if (text) {
        add_text(s, text);
        free(s->file.memory);
        s->file = parcel;
    } else {
        free(parcel.memory);
    }
    pthread_mutex_unlock(&h->lock);
    wake_server(h);
}

bool hall_next_outgoing(struct hall *h, struct session *s, struct outgoing *out)
{
    bool is_found = false;
    *out = (struct outgoing){0};
    pthread_mutex_lock(&h->lock);
    if (s->n_texts > 0) {
        out->text = s->texts[0];
        memmove(s->texts, s->texts + 1, --s->n_texts * sizeof *s->texts);
        is_found = true;
    } else if (s->file.memory) {
        out->parcel = s->file;
        s->file = (struct parcel){0};
        is_found = true;
    }
    /* The frame that was made first. */
    int next = -1;
    for (int k = 0; k < LAYERS && s->n_under_way < HALL_UNDER_WAY; k++)
        if (s->frames[k].memory && (next < 0 || s->frames[k].frame < s->frames[next].frame))
            next = k;
    if (!is_found && next >= 0) {
        out->parcel = s->frames[next];
        s->frames[next] = (struct parcel){0};
        if (s->n_under_way == 0) s->waits_since_s = hall_clock_s();
        s->under_way[s->n_under_way++] = out->parcel.frame;
        is_found = true;
    }
    pthread_mutex_unlock(&h->lock);
    return is_found;
}
