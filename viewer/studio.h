/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VIEWER_STUDIO_H
#define VIEWER_STUDIO_H

#include "hall.h"
#include "messages.h"

/*
 * The thread that makes pictures for all sessions, the only one that uses the library while the
 * viewer runs. What pages wait for comes first: pixels and files they asked for, and pictures of
 * new states, session by session. Then pictures at rest are refined, sample by sample; that work
 * stops when any page moves.
 */
struct studio_options {
    lmn_context *context; /* its progress callback must ask studio_is_stale() */
    const lmn_scene *scene;
    const lmn_model *model; /* whose network is shown, or: */
    lmn_trainer *trainer;   /* both NULL: path tracing only */
    struct message_rules rules;
};

struct studio {
    struct studio_options options;
    struct hall *hall;
    pthread_t thread;
    bool is_running;
    uint32_t n_frames, last; /* numbers of frames; the session that was served last */
    /* Of the work under way, for studio_is_stale(): */
    atomic_bool may_stop;
    atomic_uint started_at; /* hall.n_wishes then */
};

/* Without a thread: does what is most urgent on the caller's, and what is left when is_patient.
 * False: there is nothing to do. */
void studio_init(struct studio *s, const struct studio_options *options, struct hall *hall);
bool studio_work(struct studio *s, bool is_patient);

/* With one. */
bool studio_start(struct studio *s, const struct studio_options *options, struct hall *hall);

/* After hall_close(): waits for the thread, where there is one; lets go of what it made. */
void studio_stop(struct studio *s);

/* Whether what is being rendered is no longer wanted. Any thread. */
bool studio_is_stale(const struct studio *s);

#endif
