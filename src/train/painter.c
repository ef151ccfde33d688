/* SPDX-License-Identifier: Apache-2.0 */
#include "train/painter.h"

#include <stdatomic.h>
#include <string.h>

#include "base/clock.h"
#include "base/mem.h"
#include "base/pool.h"
#include "train/inputs.h"

/* Tiles of the picture, those of tracing. */
enum { TILE = 32, TILE_PIXELS = TILE * TILE };

/* Takes `count` zeroed floats and counts them. */
static bool take(struct painter *p, size_t count, float **out)
{
    *out = mem_new(count, sizeof **out);
    if (*out) p->memory_size += count * sizeof **out;
    return *out != NULL;
}

static bool take_strip(struct painter *p)
{
    const size_t n = PAINTER_PIXELS;
    return take(p, n * BUFFER_CHANNELS, &p->buffers) && take(p, n * GENERATOR_INPUTS, &p->inputs) &&
           take(p, n * 3, &p->color);
}

static bool take_desks(struct painter *p)
{
    const struct sight *sight = p->network.sight;
    const size_t n = TILE_PIXELS;
    const uint32_t n_workers = pool_n_workers(p->place->pool);
    bool is_whole = (p->desks = mem_new(n_workers, sizeof *p->desks)) != NULL;
    while (is_whole && p->n_desks < n_workers) {
        struct painter_desk *d = &p->desks[p->n_desks++];
        is_whole = take(p, n * BUFFER_CHANNELS, &d->buffers) &&
                   take(p, n * sight->n_positions * 3, &d->positions) &&
                   take(p, n * sight->n_features, &d->features) && take(p, n * 3, &d->scale) &&
                   take(p, n * CHAIN_CHANNELS, &d->chain) && take(p, n, &d->bounces) &&
                   take(p, n * 3, &d->color) && take(p, n * (3 + BUFFER_CHANNELS), &d->sums);
    }
    return is_whole;
}

lmn_status painter_init(struct painter *p, const struct workplace *place,
                        const struct painter_network *network, struct error *err)
{
    lmn_status status = LMN_OK;
    const uint32_t n_scene = place->scene->n_variables;
    const uint32_t n_network = network->field ? field_n_variables(network->field) : 0;
    *p = (struct painter){.place = place, .network = *network};
    p->v = mem_new((size_t)(n_scene > n_network ? n_scene : n_network) + 1, sizeof *p->v);
    if (p->v && (network->field ? take_desks(p) : take_strip(p)))
        status = view_new(place->world, &p->view, err);
    else
        status = fail_memory(err, "rendering by the network");
    if (status != LMN_OK) painter_release(p);
    return status;
}

void painter_release(struct painter *p)
{
    view_free(p->view);
    mem_free(p->v);
    mem_free(p->buffers);
    mem_free(p->inputs);
    mem_free(p->color);
    for (uint32_t i = 0; i < p->n_desks; i++) {
        struct painter_desk *d = &p->desks[i];
        float *const blocks[] = {d->buffers, d->positions, d->features, d->scale,
                                 d->chain,   d->bounces,   d->color,    d->sums};
        for (size_t k = 0; k < sizeof blocks / sizeof *blocks; k++) mem_free(blocks[k]);
    }
    mem_free(p->desks);
    *p = (struct painter){0};
}

static lmn_status new_image(const struct model_render_options *options, struct image *out,
                            struct error *err)
{
    const char *names[3 + BUFFER_CHANNELS] = {"R", "G", "B"};
    for (int i = 0; i < BUFFER_CHANNELS; i++) names[3 + i] = buffer_channel_names[i];
    const struct window *w = &options->window;
    return image_init(out, w->width, w->height, options->with_buffers ? 3 + BUFFER_CHANNELS : 3,
                      names, err);
}

/* Colours, and buffers if there is room for them, as rows of the image. */
static void put_pixels(float *to, uint32_t n_channels, const float *color, const float *buffers,
                       size_t n)
{
    if (n_channels == 3) {
        memcpy(to, color, n * sizeof(float[3]));
        return;
    }
    for (size_t i = 0; i < n; i++, to += n_channels) {
        memcpy(to, color + 3 * i, sizeof(float[3]));
        memcpy(to + 3, buffers + i * BUFFER_CHANNELS, sizeof(float[BUFFER_CHANNELS]));
    }
}

/* What all parts of a frame share. */
struct painting {
    struct painter *p;
    const struct trace_settings *settings;
    struct window window;
    struct image *image;
    lmn_progress_fn *progress;
    void *progress_user;
    uint32_t columns, n_tiles;
    atomic_uint n_done; /* tiles */
    atomic_bool is_stopped;
};

/* Whether to stop. */
static bool tell(struct painting *f, uint32_t n_done, uint32_t n)
{
    return f->progress && f->progress(f->progress_user, n_done, n) != 0;
}

/* ---- The compact network: tile by tile ---- */

/* What is left of the scene's bounces behind mirrors and glass. */
static void set_bounces(const struct sight *s, struct painter_desk *d, uint32_t n)
{
    for (size_t i = 0; i < n; i++) {
        const int32_t length = (int32_t)d->chain[i * CHAIN_CHANNELS + CHAIN_LENGTH];
        d->bounces[i] = sight_bounces(s, s->max_depth - length);
    }
    sight_set_bounces(s, d->bounces, n, d->features);
}

/* One sample of each of a tile's pixels: d->color, d->buffers. */
static void paint_sample(struct painter *p, uint32_t worker, const struct trace_settings *settings,
                         const struct window *tile)
{
    struct painter_desk *d = &p->desks[worker];
    const struct sight *sight = p->network.sight;
    const uint32_t n = tile->width * tile->height;
    const struct field_run run = {.n = n,
                                  .positions = d->positions,
                                  .features = d->features,
                                  .scale = d->scale,
                                  .lights = p->lights};
    struct trace_output output = {.buffers = d->buffers,
                                  .chain = sight->follows_delta ? d->chain : NULL};
    const uint64_t start = clock_ticks();
    view_trace(p->view, settings, tile, &output);
    const uint64_t traced = clock_ticks();
    sight_look(sight, view_state(p->view), d->buffers, n, d->positions, d->features, d->scale);
    if (sight->follows_delta) set_bounces(sight, d, n);
    const uint64_t looked = clock_ticks();
    field_render_part(p->network.field, worker, &run, d->color);
    const uint64_t rendered = clock_ticks();
    if (sight->follows_delta)
        sight_add_chain(d->chain, n, d->color);
    else
        sight_add_emission(d->buffers, n, d->color);
    d->buffer_ticks += traced - start;
    d->look_ticks += looked - traced;
    d->network_ticks += rendered - looked;
    d->other_ticks += clock_ticks() - rendered;
}

/* Sums of n numbers, those of the first sample being all of it. */
static void add_up(float *sums, const float *x, size_t n, bool is_first)
{
    for (size_t i = 0; i < n; i++) sums[i] = is_first ? x[i] : sums[i] + x[i];
}

/* The same of buffers, whose ids are those of the first sample. */
static void add_buffers(float *sums, const float *buffers, size_t n, bool is_first)
{
    for (size_t i = 0; i < n; i++, sums += BUFFER_CHANNELS, buffers += BUFFER_CHANNELS)
        add_up(sums, buffers, is_first ? BUFFER_CHANNELS : BUFFER_SHAPE_ID, is_first);
}

/* Told after each tile of the calling thread's: nobody waits for it, and a stop comes soon. */
static void count_tile(struct painting *f, uint32_t worker)
{
    const uint32_t n_done = atomic_fetch_add(&f->n_done, 1) + 1;
    if (worker == 0 && n_done < f->n_tiles && tell(f, n_done, f->n_tiles))
        atomic_store(&f->is_stopped, true);
}

static void paint_tile(void *ctx, uint32_t item, uint32_t worker)
{
    struct painting *f = ctx;
    if (atomic_load(&f->is_stopped)) return;
    struct painter *p = f->p;
    struct painter_desk *d = &p->desks[worker];
    const struct window *w = &f->window;
    const uint32_t n_channels = f->image->n_channels;
    const uint32_t x = item % f->columns * TILE, y = item / f->columns * TILE;
    const uint32_t spp = f->settings->spp;
    struct window tile = *w;
    tile.x += x;
    tile.y += y;
    tile.width = w->width - x < TILE ? w->width - x : TILE;
    tile.height = w->height - y < TILE ? w->height - y : TILE;
    const size_t n = (size_t)tile.width * tile.height;
    float *color = d->color, *buffers = d->buffers;
    if (spp > 1) {
        color = d->sums;
        buffers = d->sums + TILE_PIXELS * 3;
    }
    for (uint32_t i = 0; i < spp; i++) {
        struct trace_settings one = *f->settings;
        one.spp = 1;
        one.first_sample += i;
        paint_sample(p, worker, &one, &tile);
        if (spp == 1) break;
        add_up(color, d->color, n * 3, i == 0);
        if (n_channels > 3) add_buffers(buffers, d->buffers, n, i == 0);
    }
    const uint64_t start = clock_ticks();
    if (spp > 1) {
        const float share = 1.0f / (float)spp;
        for (size_t i = 0; i < n * 3; i++) color[i] *= share;
        for (size_t i = 0; n_channels > 3 && i < n; i++)
            for (size_t c = 0; c < BUFFER_CHANNELS; c++)
                buffers[i * BUFFER_CHANNELS + c] *= c < BUFFER_SHAPE_ID ? share : 1.0f;
    }
    for (size_t i = 0; i < tile.height; i++)
        put_pixels(f->image->data + ((y + i) * w->width + x) * n_channels, n_channels,
                   color + i * tile.width * 3, buffers + i * tile.width * BUFFER_CHANNELS,
                   tile.width);
    d->other_ticks += clock_ticks() - start;
    count_tile(f, worker);
}

static lmn_status paint_tiles(struct painting *f, struct error *err)
{
    struct painter *p = f->p;
    const struct window *w = &f->window;
    const uint32_t rows = (w->height + TILE - 1) / TILE;
    f->columns = (w->width + TILE - 1) / TILE;
    f->n_tiles = f->columns * rows;
    for (uint32_t i = 0; i < p->n_desks; i++) {
        struct painter_desk *d = &p->desks[i];
        d->buffer_ticks = d->look_ticks = d->network_ticks = d->other_ticks = 0;
    }
    field_begin(p->network.field, p->v, true);
    pool_run(p->place->pool, f->n_tiles, paint_tile, f);
    if (atomic_load(&f->is_stopped) || tell(f, f->n_tiles, f->n_tiles))
        return fail(err, LMN_ERR_CANCELLED, "rendering was stopped");
    return LMN_OK;
}

/* ---- The paper's network: strip by strip ---- */

static lmn_status paint_strips(struct painting *f, struct error *err)
{
    struct painter *p = f->p;
    const struct window *w = &f->window;
    const uint32_t most = PAINTER_PIXELS / w->width, n_channels = f->image->n_channels;
    for (uint32_t y = 0; y < w->height;) {
        struct window strip = *w;
        strip.y = w->y + y;
        strip.height = w->height - y < most ? w->height - y : most;
        const size_t n = (size_t)strip.width * strip.height;
        struct trace_output output = {.buffers = p->buffers};
        const lmn_status status = view_trace_parallel(p->view, p->place->pool, f->settings, &strip,
                                                      &output, NULL, NULL, err);
        if (status != LMN_OK) return status;
        inputs_from_buffers(p->place->scene, p->buffers, n, p->inputs);
        generator_render(p->network.generator, p->inputs, p->v, n, p->color);
        put_pixels(f->image->data + (size_t)y * w->width * n_channels, n_channels, p->color,
                   p->buffers, n);
        y += strip.height;
        if (tell(f, y, w->height)) return fail(err, LMN_ERR_CANCELLED, "rendering was stopped");
    }
    return LMN_OK;
}

lmn_status painter_render(struct painter *p, const float *u,
                          const struct model_render_options *options, struct image *out,
                          double *render_s, lmn_progress_fn *progress, void *progress_user,
                          struct error *err)
{
    lmn_status status = LMN_OK;
    struct image im = {0};
    const struct window *w = &options->window;
    const double start = clock_wall_s();
    const uint64_t start_ticks = clock_ticks();
    if (w->width == 0 || w->height == 0 || w->width > PAINTER_PIXELS || w->width > w->full_width ||
        w->x > w->full_width - w->width || w->height > w->full_height ||
        w->y > w->full_height - w->height) {
        status = fail(err, LMN_ERR_ARGUMENT,
                      "cannot render %ux%u pixels at (%u, %u) of a picture of %ux%u", w->width,
                      w->height, w->x, w->y, w->full_width, w->full_height);
        goto done;
    }
    TRY(new_image(options, &im, err));

    struct trace_settings settings;
    trace_settings_init(&settings, p->place->scene);
    settings.spp = options->buffer_spp > 0 ? options->buffer_spp : PAINTER_BUFFER_SPP;
    settings.seed = options->seed;
    settings.sampler = SAMPLER_SOBOL; /* smoother edges, calmer glass */
    if (p->network.field) {
        settings.follows_delta = p->network.sight->follows_delta;
        settings.max_depth = p->network.sight->max_depth;
    }
    settings.first_sample = options->first_sample;
    view_set(p->view, u);
    if (options->pose) view_look_from(p->view, options->pose);
    if (p->network.generator)
        inputs_variables(p->place->scene, u, p->v);
    else {
        sight_variables(p->network.sight, u, p->v);
        powers_at(&p->network.sight->powers, view_state(p->view), p->lights);
    }

    struct painting frame = {.p = p,
                             .settings = &settings,
                             .window = *w,
                             .image = &im,
                             .progress = progress,
                             .progress_user = progress_user};
    if (p->network.field)
        TRY(paint_tiles(&frame, err));
    else
        TRY(paint_strips(&frame, err));
    const double seconds = clock_wall_s() - start;
    const uint64_t ticks = clock_ticks() - start_ticks;
    if (render_s) *render_s = seconds;
    if (p->n_desks > 0 && ticks > 0) p->seconds_per_tick = seconds / (double)ticks / p->n_desks;
    *out = im;
    im = (struct image){0};
done:
    image_release(&im);
    return status;
}

void painter_times(const struct painter *p, double *buffers_s, double *network_s)
{
    uint64_t buffers = 0, network = 0;
    for (uint32_t i = 0; i < p->n_desks; i++) {
        buffers += p->desks[i].buffer_ticks;
        network += p->desks[i].look_ticks + p->desks[i].network_ticks;
    }
    *buffers_s = p->seconds_per_tick * (double)buffers;
    *network_s = p->seconds_per_tick * (double)network;
}
