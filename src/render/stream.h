/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_STREAM_H
#define RENDER_STREAM_H

#include "render/path.h"

/*
 * Many light paths in step: all arrive, all connect to lights, all scatter, so that the processor
 * works on one path's arithmetic while it waits for another's. Primary rays, and the first shadow
 * rays, go to Embree in packets.
 *
 * A packet holds samples of one pixel only. What Embree finds can depend on a packet's other rays
 * in the last bit, so this keeps a pixel's bytes the same in whatever window it is traced.
 */
enum { STREAM_SIZE = 64, STREAM_PACKET = 16 };

struct stream {
    uint32_t n, packet_start;
    uint32_t packet_end[STREAM_SIZE]; /* for the first path of a packet: the first one after it */
    struct path paths[STREAM_SIZE];
};

/* Adds a path, whose sampler and primary ray are set by the caller through the pointer it gets.
 * `is_new_pixel` starts a new packet. */
struct path *stream_add(struct stream *s, bool is_new_pixel);

/* Casts the primary rays: fills in all hits. */
void stream_cast(struct stream *s, const struct view *v);

/* Follows all paths to their ends; paths[i].radiance is the result. */
void stream_trace(struct stream *s, const struct view *v, const struct trace_settings *t);

#endif
