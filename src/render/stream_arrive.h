/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_STREAM_ARRIVE_H
#define RENDER_STREAM_ARRIVE_H

#include "render/stream.h"

/* The ends of a stream's rays: what shines there, and the surfaces and materials that paths go on
 * from. */

/* Adds what shines at the ends of the rays and works out the points there. False when no path goes
 * on. */
bool stream_arrive(struct stream *s, const struct view *v, const struct trace_settings *t,
                   int32_t depth);

/* With photons: adds caustics at the points that paths go on from. */
void stream_gather(struct stream *s, const struct trace_settings *t, int32_t depth);

/* Adds light that comes from `emitter`; is_seen: the path itself has met it. */
void stream_add_radiance(struct stream *s, uint32_t i, uint32_t emitter, bool is_seen,
                         struct vec3 value);

#endif
