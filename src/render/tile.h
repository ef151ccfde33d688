/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_TILE_H
#define RENDER_TILE_H

#include "render/buffers.h"
#include "render/film.h"
#include "render/view.h"

/*
 * What tracing windows (trace.c) and lists of pixels (trace_pixels.c) share: a tile is at most
 * FILM_TILE x FILM_TILE pixels, those of a part of the picture or of a list. Its samples fill
 * streams pixel after pixel, and the same samples of a pixel share a stream whatever the tile, so
 * that a pixel's bytes do not depend on it.
 */
enum { TILE_PIXELS = FILM_TILE * FILM_TILE };

/* What all pixels of a picture share. */
struct job {
    const struct view *view;
    struct trace_settings settings;
    struct window window; /* of a list of n pixels: n x 1 at (0, 0) */
    struct trace_output out;
    struct stream_film film;
    bool needs_light;
    const struct ray *rays; /* NULL; else those that samples start with, by place in the results */
};

/* What is asked for, in one job or in two: buffers are never splatted, and of few samples they have
 * packets of their own, unless asked not to. Returns how many. */
int jobs_init(struct job jobs[2], const struct view *v, const struct trace_settings *t,
              const struct window *w, const struct trace_output *out);

/* Some pixels of the picture, and where their samples go. */
struct tile {
    uint32_t x, y, width, height;  /* in the picture; pixels are counted row by row */
    const struct pixel_at *pixels; /* NULL; else the tile is [width] of a list, height is 1 */
    size_t first;                  /* place of its first pixel in the results */
    struct film_tile *splats;      /* NULL: samples count for their pixel */
    struct vec3 (*sums)[2];        /* else: of a pixel's even and odd samples */
};

/* Where a tile's pixel is in the picture. */
static inline struct pixel_at tile_pixel(const struct tile *tile, uint32_t pixel)
{
    if (tile->pixels) return tile->pixels[pixel];
    return (struct pixel_at){tile->x + pixel % tile->width, tile->y + pixel / tile->width};
}

/* Where its buffers go. */
struct buffers_tile tile_buffers(const struct job *j, const struct tile *tile);

/* Adds sample k of the weights, which splats want. One that is no number (broken normals in a file,
 * an overflow) is black. */
void tile_add(const struct job *j, struct tile *tile, uint32_t pixel, uint32_t sample,
              const struct film_weights *weights, uint32_t k, struct vec3 radiance);

/* Traces a tile into its sums or splats, and its buffers' sums to where these go. */
typedef void tile_fn(const struct job *j, struct tile *tile);
void tile_trace_streams(const struct job *j, struct tile *tile);

/* The whole way of a tile without splats, to the results. */
void tile_finish(const struct job *j, struct tile *tile, tile_fn *trace);

/* Readies this thread's floating point for tracing; returns what to hand to tile_end(). Embree
 * wants it, and results must not depend on what the caller had set. */
unsigned tile_begin(void);
void tile_end(unsigned before);

#endif
