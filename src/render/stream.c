/* SPDX-License-Identifier: Apache-2.0 */
#include "render/stream.h"

struct path *stream_add(struct stream *s, bool is_new_pixel)
{
    uint32_t i = s->n++;
    if (is_new_pixel || i == 0 || i - s->packet_start == STREAM_PACKET) s->packet_start = i;
    s->packet_end[s->packet_start] = i + 1;
    return &s->paths[i];
}

void stream_cast(struct stream *s, const struct view *v)
{
    for (uint32_t first = 0; first < s->n; first = s->packet_end[first]) {
        uint32_t n = s->packet_end[first] - first;
        const struct ray *rays[STREAM_PACKET];
        struct hit *hits[STREAM_PACKET];
        for (uint32_t i = 0; i < n; i++) {
            rays[i] = &s->paths[first + i].ray;
            hits[i] = &s->paths[first + i].hit;
        }
        accel_intersect_packet(v->top, n, rays, hits);
    }
}

/* The shadow rays of paths `connected`, of which those of one packet stand together. */
static void connect_packets(struct stream *s, const struct view *v, const uint8_t *connected,
                            uint32_t n_connected)
{
    uint32_t i = 0, first = 0;
    while (i < n_connected) { /* so there is a packet at `first` still */
        uint32_t end = s->packet_end[first];
        const struct ray *rays[STREAM_PACKET];
        bool is_occluded[STREAM_PACKET];
        uint32_t n = 0;
        while (i + n < n_connected && connected[i + n] < end) {
            rays[n] = &s->paths[connected[i + n]].shadow;
            n++;
        }
        if (n > 0) accel_occluded_packet(v->top, n, rays, is_occluded);
        for (uint32_t k = 0; k < n; k++) {
            struct path *p = &s->paths[connected[i + k]];
            if (!is_occluded[k]) p->radiance = vec3_add(p->radiance, p->light);
        }
        i += n;
        first = end;
    }
}

void stream_trace(struct stream *s, const struct view *v, const struct trace_settings *t)
{
    uint8_t alive[STREAM_SIZE], connected[STREAM_SIZE];
    uint32_t n_alive = s->n;
    for (uint32_t i = 0; i < n_alive; i++) alive[i] = (uint8_t)i;
    for (int32_t depth = 0;; depth++) {
        uint32_t n = 0, n_connected = 0;
        for (uint32_t i = 0; i < n_alive; i++) {
            uint8_t k = alive[i];
            if (path_arrive(&s->paths[k], v, t, depth)) alive[n++] = k;
        }
        n_alive = n;
        if (n_alive == 0) break;
        for (uint32_t i = 0; i < n_alive; i++) {
            uint8_t k = alive[i];
            if (path_connect(&s->paths[k], v, t, depth)) connected[n_connected++] = k;
        }
        if (depth == 0) {
            connect_packets(s, v, connected, n_connected);
        } else {
            for (uint32_t i = 0; i < n_connected; i++) {
                struct path *p = &s->paths[connected[i]];
                if (!accel_occluded(v->top, &p->shadow))
                    p->radiance = vec3_add(p->radiance, p->light);
            }
        }
        n = 0;
        for (uint32_t i = 0; i < n_alive; i++) {
            uint8_t k = alive[i];
            if (path_scatter(&s->paths[k], t, depth)) alive[n++] = k;
        }
        n_alive = n;
        for (uint32_t i = 0; i < n_alive; i++) {
            struct path *p = &s->paths[alive[i]];
            accel_intersect(v->top, &p->ray, false, &p->hit);
        }
    }
}
