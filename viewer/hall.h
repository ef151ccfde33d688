/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VIEWER_HALL_H
#define VIEWER_HALL_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <lumenaut/lumenaut.h>

/*
 * What the server's thread and the studio's share: sessions, each with what its page wants and what
 * is ready for it. The server makes sessions and marks them gone; only the studio frees them, so
 * that it may work on one without holding the lock. Everything not said to be one thread's own is
 * read and written under hall.lock.
 */

enum layer { LAYER_NEURAL, LAYER_TRACED, LAYER_ERROR, LAYER_BUFFER, LAYERS };

/* The buffers that can be shown; names as in the protocol. */
enum shown_buffer {
    SHOWN_ALBEDO,
    SHOWN_NORMAL,
    SHOWN_POSITION,
    SHOWN_ROUGHNESS,
    SHOWN_DEPTH,
    SHOWN_EMISSION,
    SHOWN_BUFFERS
};
extern const char *const shown_buffer_names[SHOWN_BUFFERS];

/* The state of a page: message "state" of PROTOCOL.md. */
struct wish {
    uint32_t version;
    double *values; /* [n_variables], owned */
    bool has_camera;
    lmn_camera camera;
    enum layer layers[LAYERS]; /* [n_layers], in the order of importance */
    uint32_t n_layers;
    enum shown_buffer buffer; /* of LAYER_BUFFER */
    uint32_t width, height;
    double exposure;
    uint32_t tone; /* LMN_TONE_* */
    bool is_moving;
    double rate, least;
};

enum capture_format { CAPTURE_PNG, CAPTURE_EXR };

/* Bytes for the socket after `room` bytes that its library writes to. */
struct parcel {
    uint8_t *memory; /* owned; NULL: nothing */
    size_t size;
    uint32_t frame;
};

enum {
    HALL_SESSIONS = 64,
    HALL_TEXTS = 16,    /* waiting for a socket; more are dropped, the oldest first */
    HALL_UNDER_WAY = 2, /* frames that are not acknowledged yet */
    HALL_HEADER = 40,   /* of a picture */
    HALL_SIDE_MIN = 16, /* of a picture */
    HALL_SIDE_MAX = 4096
};

struct easel;

struct session {
    bool is_gone; /* its socket is closed */
    bool has_wish;
    struct wish wish;
    struct {
        bool is_wanted;
        uint32_t id, x, y;
    } pixel;
    struct {
        bool is_wanted;
        uint32_t id;
        enum layer layer;
        enum capture_format format;
    } capture;
    struct parcel frames[LAYERS]; /* made and not sent: the newest of each layer */
    struct parcel file;           /* a capture, after its text */
    char *texts[HALL_TEXTS];      /* [n_texts], owned, the oldest first */
    uint32_t n_texts;
    uint32_t n_under_way;
    uint32_t under_way[HALL_UNDER_WAY]; /* their numbers */
    double waits_since_s;               /* for an acknowledgement, when n_under_way > 0 */
    struct easel *easel;                /* the studio's own, as is: */
    double stats_sent_s;
    bool knows_training; /* has had the whole curve; under the lock again */
};

struct hall {
    pthread_mutex_t lock;
    pthread_cond_t news; /* for the studio */
    struct session *sessions[HALL_SESSIONS];
    uint32_t n_sessions; /* gone ones count until they are freed */
    uint32_t n_variables;
    atomic_uint n_wishes; /* counts states: work that is not needed at once stops when it moves */
    atomic_bool is_closing;
    /* Orders of pages: to a training, and for one. */
    bool is_paused, wants_save, wants_stop, wants_start;
    void (*wake_server)(void *user); /* from any thread */
    void *server;
};

bool hall_init(struct hall *h, uint32_t n_variables);
void hall_release(struct hall *h);

/* For the server, without the lock. NULL: full, or short of memory. */
struct session *hall_enter(struct hall *h);
void hall_leave(struct hall *h, struct session *s);
void hall_close(struct hall *h);

/* Takes over the wish's values. */
void hall_set_wish(struct hall *h, struct session *s, struct wish *wish);
void hall_acknowledge(struct hall *h, struct session *s, uint32_t frame);
void hall_ask_pixel(struct hall *h, struct session *s, uint32_t id, uint32_t x, uint32_t y);
void hall_ask_capture(struct hall *h, struct session *s, uint32_t id, enum layer layer,
                      enum capture_format format);

/* To a training: it goes on, unless it is paused; it is saved, or ends. */
enum train_action { TRAIN_START, TRAIN_PAUSE, TRAIN_SAVE, TRAIN_STOP };
void hall_order(struct hall *h, enum train_action action);
bool hall_wants_start(struct hall *h);

/* Seconds that a frame has been waiting to be acknowledged; 0: none does. */
double hall_waits_s(struct hall *h, const struct session *s);

/* For the studio, with the lock, which is let go meanwhile: until there is news, or so long. */
void hall_wait(struct hall *h, int ms);

/* For the studio, with the lock: frees the sessions that are gone; easel_free() for each easel. */
void hall_sweep(struct hall *h, void (*free_easel)(struct easel *e));

/* For the studio, without the lock; the text, or the parcel's memory, is taken over. */
void hall_send_text(struct hall *h, struct session *s, char *text);
void hall_send_frame(struct hall *h, struct session *s, enum layer layer, struct parcel parcel);
void hall_send_file(struct hall *h, struct session *s, char *text, struct parcel parcel);

/* The same text for every session that knows of the training already, or for those that do not and
 * then do. */
void hall_send_training(struct hall *h, const char *text, bool is_for_new);

/* How many sessions there are, and whether some do not know of the training. */
uint32_t hall_n_sessions(struct hall *h, bool *has_new);

/* What the socket sends next; the caller frees it. False: nothing. */
struct outgoing {
    char *text;           /* or: */
    struct parcel parcel; /* a picture or a file */
};
bool hall_next_outgoing(struct hall *h, struct session *s, struct outgoing *out);

double hall_clock_s(void);

#endif
