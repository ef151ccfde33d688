/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VIEWER_EASEL_H
#define VIEWER_EASEL_H

#include "studio.h"

/*
 * A session's pictures in the making. One call draws one thing: the next layer of a new state, or a
 * few more samples of a picture at rest.
 */
struct easel;

struct easel *easel_new(const struct studio_options *options);
void easel_free(struct easel *e); /* takes NULL */

/* A state that the page has set. */
void easel_set(struct easel *e, const struct wish *wish);
uint32_t easel_version(const struct easel *e);

/* Whether a layer of the present state has not been shown yet. */
bool easel_is_new(const struct easel *e);

/* Whether nothing is left to do. */
bool easel_is_done(const struct easel *e);

/* What came of a call. */
struct easel_result {
    bool has_frame;
    enum layer layer;
    struct parcel parcel;  /* the picture with its header, after the socket's room */
    char *metrics, *error; /* messages, or NULL */
};

/* Draws. A stopped call (LMN_ERR_CANCELLED) leaves everything as it was. */
void easel_draw(struct easel *e, uint32_t frame, struct easel_result *out);

void easel_get_stats(const struct easel *e, struct view_stats *out);

/* Messages about a pixel, and a file with its message; what is there of the picture is used. */
char *easel_read_pixel(struct easel *e, uint32_t id, uint32_t x, uint32_t y);
char *easel_capture(struct easel *e, uint32_t id, enum layer layer, enum capture_format format,
                    struct parcel *file);

#endif
