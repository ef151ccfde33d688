/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_BUFFERS_H
#define RENDER_BUFFERS_H

#include "render/chain.h"
#include "render/stream.h"

/*
 * The buffers of first hits (enum buffer_channel), many lanes in step. The reference is
 * path_add_buffers(), one sample at a time; lanes with bump or normal maps go through it.
 *
 * Of a few samples per pixel, a packet of rays holds one sample of a block of 4x4 pixels. Blocks
 * have their place in the full picture and are traced whole, also where a window cuts them: what
 * Embree finds can depend on a packet's other rays in the last bit. Of more samples, a packet holds
 * samples of one pixel, as in streams, whose hits then serve for buffers too.
 */
enum {
    BUFFERS_BLOCK = 4,
    BUFFERS_BLOCK_SPP = 8, /* blocks below so many samples */
    BUFFERS_CACHED = 8192  /* pixels whose buffers stay in a cache of the second level */
};

/* What the buffers show of a material. */
struct look {
    enum {
        LOOK_CONSTANT, /* this, everywhere and from both sides */
        LOOK_TEXTURE,  /* this, but the albedo is that of a texture */
        LOOK_VARIES,   /* ask bsdf_point_init() */
        LOOK_TURNED    /* the normal, too */
    } kind;
    uint32_t texture;
    struct vec3 albedo;
    float roughness;
    bool is_diffuse; /* BUFFER_WI stays zero */
};

/* Fills looks [n_bsdfs]. */
void buffers_init_looks(struct look *looks, const struct material *materials, uint32_t n_bsdfs,
                        const struct texture_set *textures);

/* What they show at a point. */
struct look buffers_look(const struct bsdf_point *p);

/* One sample of a pixel per lane. */
struct first_hits {
    uint32_t n;

    /* What is looked at: the sample of a pixel of the full picture, its centre. */
    _Alignas(STREAM_ALIGNMENT) uint32_t x[STREAM_SIZE];
    uint32_t y[STREAM_SIZE], sample[STREAM_SIZE];
    uint64_t pixel[STREAM_SIZE];
    size_t place[STREAM_SIZE]; /* counted from the tile's first pixel; SIZE_MAX: not in the tile */
    float center_x[STREAM_SIZE], center_y[STREAM_SIZE];
    uint32_t is_inside[STREAM_SIZE]; /* the picture: others are not traced */

    /* Rays from t = 0, and what they hit. */
    struct lanes3 o, d;
    float t_max[STREAM_SIZE], offset[STREAM_SIZE];
    struct hit hit[STREAM_SIZE];

    /* Surfaces: normals at any length. */
    uint32_t is_hit[STREAM_SIZE], has_wi[STREAM_SIZE];
    float t[STREAM_SIZE];
    struct lanes3 normal, shading;
    struct chain chain[STREAM_SIZE]; /* when deltas are followed */

    float values[BUFFER_CHANNELS][STREAM_SIZE + 16]; /* the result; spread over the cache's sets */
};

/* A part of the picture, of at most STREAM_SIZE / 4 pixels a side, and where its buffers go; or
 * pixels anywhere, in a row of any length. */
struct buffers_tile {
    uint32_t x, y, width, height;  /* in the full picture */
    const struct pixel_at *pixels; /* NULL; else [width], height is 1, and x and y do not count */
    float *to, *chain;             /* of its first pixel; chain: NULL where that is not wanted */
    size_t stride;                 /* pixels from row to row */
    bool is_large;                 /* the whole picture's buffers do not fit in a cache */
};

/* Traces a tile's buffers: sums of settings->spp samples, for buffers_scale(). */
void buffers_trace(const struct view *v, const struct trace_settings *t,
                   const struct stream_film *film, const struct buffers_tile *tile);

/* The same from a stream whose primary rays are cast; lane i has sample number samples[i] of the
 * tile's pixel pixels[i], of which number 0 comes first. */
void buffers_add_stream(const struct view *v, const struct trace_settings *t,
                        const struct stream_film *film, struct stream *s,
                        const struct buffers_tile *tile, const uint32_t *samples,
                        const uint32_t *pixels);

/* As view_follow_pixels(). */
void buffers_follow(const struct view *v, const struct trace_settings *t,
                    const struct stream_film *film, const struct pixel_at *pixels, uint32_t n,
                    struct chain_end *ends);

/* Cuts the paths of a stream that have arrived, after so many bounces, at a rough surface: to
 * s->ends. False when no path is left. */
bool buffers_cut_paths(const struct view *v, const struct trace_settings *t, struct stream *s,
                       int32_t depth);

/* From sums to means. */
void buffers_scale(const struct trace_settings *t, const struct buffers_tile *tile);

/* One sample of the tile's pixel by the reference. `sampler`: where the film left it. */
void buffers_add_plain(const struct view *v, const struct trace_settings *t, const struct ray *ray,
                       float offset, const struct hit *hit, const struct sampler *sampler,
                       uint32_t sample, uint32_t pixel, const struct buffers_tile *tile);

#endif
