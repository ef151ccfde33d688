/* SPDX-License-Identifier: Apache-2.0 */
#include "studio.h"

#include <stdlib.h>
#include <string.h>

#include "easel.h"

/* Between messages of statistics, and between looks at what has waited too long. */
#define STATS_EVERY_S 0.25
enum { IDLE_MS = 500 };

/* What is done for a session, the most urgent first. */
enum task { TASK_PIXEL, TASK_CAPTURE, TASK_NEW, TASK_REFINE, TASKS };

/* Work that was chosen: copies of what the session wanted. */
struct work {
    struct session *session;
    enum task task;
    uint32_t id, x, y;
    enum layer layer;
    enum capture_format format;
    uint32_t n_sessions;
};

/* A page that has not taken the last pictures gets no new ones. */
static bool has_room(const struct session *s)
{
    uint32_t n = s->n_under_way;
    for (int k = 0; k < LAYERS; k++) n += s->frames[k].memory != NULL;
    return n < HALL_UNDER_WAY;
}

static bool wants(const struct session *s, enum task task)
{
    if (s->is_gone || !s->easel) return false;
    switch (task) {
    case TASK_PIXEL:
        return s->pixel.is_wanted;
    case TASK_CAPTURE:
        return s->capture.is_wanted && !s->file.memory;
    case TASK_NEW:
        return s->has_wish && has_room(s) &&
               (easel_version(s->easel) != s->wish.version || easel_is_new(s->easel));
    case TASK_REFINE:
        return s->has_wish && has_room(s) && !easel_is_done(s->easel);
    case TASKS:
        break;
    }
    return false;
}

/* With the lock. Sessions take turns at each task. */
static bool find_work(struct studio *s, bool is_patient, struct work *out)
{
    struct hall *h = s->hall;
    for (int task = 0; task < (is_patient ? TASKS : TASK_REFINE); task++)
        for (uint32_t i = 0; i < h->n_sessions; i++) {
            const uint32_t at = (s->last + 1 + i) % h->n_sessions;
            struct session *session = h->sessions[at];
            if (!wants(session, (enum task)task)) continue;
            *out = (struct work){
                .session = session, .task = (enum task)task, .n_sessions = h->n_sessions};
            s->last = at;
            if (task == TASK_PIXEL) {
                out->id = session->pixel.id;
                out->x = session->pixel.x;
                out->y = session->pixel.y;
                session->pixel.is_wanted = false;
            }
            if (task == TASK_CAPTURE) {
                out->id = session->capture.id;
                out->layer = session->capture.layer;
                out->format = session->capture.format;
                session->capture.is_wanted = false;
            }
            if (session->has_wish && easel_version(session->easel) != session->wish.version)
                easel_set(session->easel, &session->wish);
            return true;
        }
    return false;
}

/* Sessions that are new get an easel. */
static void furnish(struct studio *s)
{
    for (uint32_t i = 0; i < s->hall->n_sessions; i++) {
        struct session *session = s->hall->sessions[i];
        if (!session->easel && !session->is_gone) session->easel = easel_new(&s->options);
    }
}

static void draw(struct studio *s, const struct work *w)
{
    struct easel_result result;
    struct easel *e = w->session->easel;
    struct view_stats stats;
    easel_draw(e, ++s->n_frames, &result);
    if (result.error) hall_send_text(s->hall, w->session, result.error);
    if (result.metrics) hall_send_text(s->hall, w->session, result.metrics);
    if (!result.has_frame) return;
    hall_send_frame(s->hall, w->session, result.layer, result.parcel);
    const double now = hall_clock_s();
    if (now - w->session->stats_sent_s < STATS_EVERY_S) return;
    w->session->stats_sent_s = now;
    easel_get_stats(e, &stats);
    stats.n_sessions = w->n_sessions;
    hall_send_text(s->hall, w->session, message_stats(&stats));
}

static void do_work(struct studio *s, const struct work *w)
{
    struct easel *e = w->session->easel;
    struct parcel file = {0};
    char *text;
    /* Small pictures of moving pages are finished, or a busy hand would never see one. */
    atomic_store(&s->may_stop, w->task == TASK_REFINE);
    switch (w->task) {
    case TASK_PIXEL:
        hall_send_text(s->hall, w->session, easel_read_pixel(e, w->id, w->x, w->y));
        break;
    case TASK_CAPTURE:
        text = easel_capture(e, w->id, w->layer, w->format, &file);
        hall_send_file(s->hall, w->session, text, file);
        break;
    case TASK_NEW:
    case TASK_REFINE:
        draw(s, w);
        break;
    case TASKS:
        break;
    }
    atomic_store(&s->may_stop, false);
}

/* Looks for something to do, and does it. With the lock, which is let go meanwhile. */
static bool work_once(struct studio *s, bool is_patient)
{
    struct work work;
    hall_sweep(s->hall, easel_free);
    furnish(s);
    atomic_store(&s->started_at, atomic_load(&s->hall->n_wishes));
    if (!find_work(s, is_patient, &work)) return false;
    pthread_mutex_unlock(&s->hall->lock);
    do_work(s, &work);
    pthread_mutex_lock(&s->hall->lock);
    return true;
}

static void *run(void *user)
{
    struct studio *s = user;
    struct hall *h = s->hall;
    pthread_mutex_lock(&h->lock);
    while (!atomic_load(&h->is_closing)) {
        if (!work_once(s, true)) hall_wait(h, IDLE_MS);
    }
    pthread_mutex_unlock(&h->lock);
    return NULL;
}

void studio_init(struct studio *s, const struct studio_options *options, struct hall *hall)
{
    *s = (struct studio){.options = *options, .hall = hall};
}

bool studio_work(struct studio *s, bool is_patient)
{
    pthread_mutex_lock(&s->hall->lock);
    const bool has_worked = work_once(s, is_patient);
    pthread_mutex_unlock(&s->hall->lock);
    return has_worked;
}

bool studio_start(struct studio *s, const struct studio_options *options, struct hall *hall)
{
    studio_init(s, options, hall);
    s->is_running = pthread_create(&s->thread, NULL, run, s) == 0;
    return s->is_running;
}

void studio_stop(struct studio *s)
{
    if (s->is_running) pthread_join(s->thread, NULL);
    s->is_running = false;
    for (uint32_t i = 0; s->hall && i < s->hall->n_sessions; i++) {
        easel_free(s->hall->sessions[i]->easel);
        s->hall->sessions[i]->easel = NULL;
    }
}

bool studio_is_stale(const struct studio *s)
{
    if (!s->hall) return false;
    return atomic_load(&s->hall->is_closing) ||
           (atomic_load(&s->may_stop) &&
            atomic_load(&s->hall->n_wishes) != atomic_load(&s->started_at));
}
