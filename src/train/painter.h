/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_PAINTER_H
#define TRAIN_PAINTER_H

#include "image/image.h"
#include "train/sight.h"
#include "train/model.h"

/* One of the two networks; not owned. */
struct painter_network {
    struct generator *generator; /* NULL: */
    struct field *field;
    const struct sight *sight; /* of the field */
};

/* What one worker paints a tile of the compact network in; owned. */
struct painter_desk {
    float *buffers;                      /* [TILE_PIXELS][BUFFER_CHANNELS] */
    float *positions, *features, *scale; /* sight_look() */
    float *chain, *bounces; /* [TILE_PIXELS][CHAIN_CHANNELS], [TILE_PIXELS]: if sight follows */
    float *color;           /* [TILE_PIXELS][3]: of one sample */
    float *sums;            /* of all samples: colours, then buffers */
    /* clock_ticks() since the frame began: tracing, sight_look(), the network, the rest */
    uint64_t buffer_ticks, look_ticks, network_ticks, other_ticks;
};

/*
 * Frames by the network: what model_render() and evaluation share.
 *
 * The compact network works tile by tile, each by one worker from tracing to colours, so that what
 * a tile needs stays in its cache. It knows points, not pixels: of several samples each is rendered
 * for itself, and their mean is the pixel. The paper's network works through the window in strips
 * of rows: buffers of the strip (all workers), network inputs, network. Memory does not grow with
 * the picture.
 */
struct painter {
    const struct workplace *place;
    struct painter_network network;
    struct view *view; /* owned */
    float *v; /* the scene's variables, zeros after them if the network takes more; owned, as all
                 below */
    /* Of the paper's network: */
    float *buffers; /* [PAINTER_PIXELS][BUFFER_CHANNELS] */
    float *inputs;  /* [PAINTER_PIXELS][GENERATOR_INPUTS] */
    float *color;   /* [PAINTER_PIXELS][3] */
    /* Of the compact network: */
    struct painter_desk *desks; /* [n_desks] */
    uint32_t n_desks;
    float lights[FIELD_MAX_LIGHTS * 3]; /* powers_at() */
    double seconds_per_tick;            /* of the last picture's desks, which work side by side */
    uint64_t memory_size;
};

/* A strip is at least a row: no picture is wider than this. */
enum { PAINTER_PIXELS = 65536, PAINTER_BUFFER_SPP = 16 };

lmn_status painter_init(struct painter *p, const struct workplace *place,
                        const struct painter_network *network, struct error *err);
void painter_release(struct painter *p);

/* As model_render(). */
lmn_status painter_render(struct painter *p, const float *u,
                          const struct model_render_options *options, struct image *out,
                          double *render_s, lmn_progress_fn *progress, void *progress_user,
                          struct error *err);

/* Seconds of the last picture, by the compact network: tracing buffers; looking and the network. */
void painter_times(const struct painter *p, double *buffers_s, double *network_s);

#endif
