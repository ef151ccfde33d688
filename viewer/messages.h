/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VIEWER_MESSAGES_H
#define VIEWER_MESSAGES_H

#include "hall.h"

/* The texts of PROTOCOL.md: those of the page are read, those of the server written. */

enum message_kind { MESSAGE_STATE, MESSAGE_ACK, MESSAGE_PIXEL, MESSAGE_CAPTURE, MESSAGE_TRAIN };

struct message {
    enum message_kind kind;
    struct wish wish; /* STATE; its values are the caller's to free */
    uint32_t frame;   /* ACK */
    uint32_t id;      /* PIXEL, CAPTURE */
    uint32_t x, y;    /* PIXEL */
    enum layer layer; /* CAPTURE: neural or traced */
    enum capture_format format;
    enum train_action action; /* TRAIN */
};

/* What can be asked for. */
struct message_rules {
    uint32_t n_variables;
    bool has_network, is_orthographic;
    bool can_train, is_training; /* one can be started, or is under way */
};

enum { MESSAGE_MAX = 65536, MESSAGE_WHY = 200 };

/* False with the reason in why. Allocates only a state's values. */
bool message_read(const char *text, size_t size, const struct message_rules *rules,
                  struct message *out, char why[MESSAGE_WHY]);

/* Texts for the socket, owned by the caller; NULL: no memory. */
char *message_error(const char *why);

/* What the page learns at the start. */
struct hello {
    lmn_context *context;
    const lmn_scene *scene;
    const char *scene_path, *model_path;      /* model_path NULL: none */
    const char *const *render, *const *trace, *const *train; /* words of commands, each list ends
                                                                with NULL; NULL: none */
    const char *program;
    const char *notice; /* NULL: nothing */
};
char *message_hello(const struct hello *h, const struct message_rules *rules);

struct view_stats {
    uint32_t version;
    double fps;
    uint32_t width, height, neural_spp, traced_spp, n_sessions;
    double render_ms, buffers_ms, network_ms, encode_ms;
    bool has_camera; /* of the values */
    lmn_camera camera;
};
char *message_stats(const struct view_stats *s);
char *message_metrics(uint32_t version, uint32_t neural_spp, uint32_t traced_spp,
                      const lmn_metrics *m);

/* How a training goes. */
struct training_state {
    bool is_running;
    uint64_t step, n_configurations;
    double loss, seconds, steps_per_s, view_share;
    double acceptance, reuse;  /* shares; NAN: not of this method */
    uint32_t n_points;         /* of the curve: all at the start, then the newest */
    const double (*points)[2]; /* seconds, loss */
    uint32_t n_states, n_variables;
    const double *states; /* [n_states][n_variables] */
};

/* With the whole curve, as hello has it, or with its newest point. */
char *message_training(const struct training_state *t, bool is_whole);

/* Numbers that were found at a pixel: lists by name. */
struct readout {
    const char *name;
    float values[3];
    uint32_t n;
};
char *message_pixel(uint32_t id, uint32_t version, uint32_t x, uint32_t y,
                    const struct readout *list, uint32_t n);

/* size 0: `why` there is none. */
char *message_capture(uint32_t id, size_t size, const char *name, const char *why);

/* The header of a picture, to[HALL_HEADER]. */
struct picture_header {
    uint8_t layer, encoding;
    bool is_final;
    uint32_t frame, version, width, height, full_width, full_height, spp;
    double render_ms, encode_ms;
};
enum { ENCODING_JPEG, ENCODING_PNG, ENCODING_EXR };
enum { LAYER_FILE = 255 };
void picture_header_write(const struct picture_header *h, uint8_t *to);

#endif
