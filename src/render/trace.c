/* SPDX-License-Identifier: Apache-2.0 */
#include "base/mem.h"
#include "base/pool.h"
#include "render/tile.h"
#include "render/world.h"

enum { TILE = FILM_TILE };

const char *const buffer_channel_names[BUFFER_CHANNELS] = {
    "position.X", "position.Y",   "position.Z",   "normal.X",     "normal.Y",
    "normal.Z",   "geo_normal.X", "geo_normal.Y", "geo_normal.Z", "albedo.R",
    "albedo.G",   "albedo.B",     "roughness.Y",  "wo.X",         "wo.Y",
    "wo.Z",       "wi.X",         "wi.Y",         "wi.Z",         "emission.R",
    "emission.G", "emission.B",   "depth.Z",      "shape.ID",     "primitive.ID",
};

const char *const chain_channel_names[CHAIN_CHANNELS] = {
    "chain_throughput.R", "chain_throughput.G", "chain_throughput.B", "chain_emission.R",
    "chain_emission.G",   "chain_emission.B",   "chain_length.Y",
};

void trace_settings_init(struct trace_settings *t, const struct scene *s)
{
    const struct render_settings *r = &s->settings;
    *t = (struct trace_settings){
        .spp = r->spp,
        .max_depth = r->max_depth,
        .rr_depth = r->rr_depth,
        .hide_emitters = r->hide_emitters,
        .mis = MIS_POWER,
        .sampler = r->sampler,
        .filter = r->filter,
        .filter_radius = r->filter_radius,
        .filter_stddev = r->filter_stddev,
        .seed = r->seed,
    };
}

/* ---- Tiles of a window ----------------------------------------------------------------------- */

static uint32_t min_u32(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* Each sample for its own pixel: a tile of the window whose top left pixel there is (x, y). */
static void trace_pixels(const struct job *j, uint32_t x, uint32_t y, tile_fn *trace)
{
    const struct window *w = &j->window;
    struct tile tile = {.x = w->x + x, .y = w->y + y, .first = (size_t)y * w->width + x};
    tile.width = min_u32(w->width - x, TILE);
    tile.height = min_u32(w->height - y, TILE);
    tile_finish(j, &tile, trace);
}

/* The pixels whose samples reach the part: [x0, x1) x [y0, y1) of the picture. */
struct reach {
    uint32_t x0, y0, x1, y1;
};

static struct reach reach_of(const struct job *j, const struct window *part)
{
    const uint32_t m = j->film.margin;
    return (struct reach){part->x - min_u32(part->x, m), part->y - min_u32(part->y, m),
                          min_u32(part->x + part->width + m, part->full_width),
                          min_u32(part->y + part->height + m, part->full_height)};
}

/* Splats of the tile of the picture at (x, y), of the pixels within reach. */
static void trace_splats(const struct job *j, const struct reach *r, uint32_t x, uint32_t y,
                         struct film_tile *splats, tile_fn *trace)
{
    const unsigned before = tile_begin();
    struct tile tile = {.x = x > r->x0 ? x : r->x0, .y = y > r->y0 ? y : r->y0, .splats = splats};
    tile.width = min_u32(x + TILE, r->x1) - tile.x;
    tile.height = min_u32(y + TILE, r->y1) - tile.y;
    film_tile_start(splats, j->film.margin, x, y);
    trace(j, &tile);
    tile_end(before);
}

/* Splats of a part of the window, not larger than TILE. */
static void trace_part(const struct job *j, const struct window *part, tile_fn *trace)
{
    struct film_sum sums[TILE * TILE] = {0};
    struct film_tile splats;
    const struct reach r = reach_of(j, part);
    struct trace_output out = j->out;
    for (uint32_t y = r.y0 / TILE * TILE; y < r.y1; y += TILE) {
        for (uint32_t x = r.x0 / TILE * TILE; x < r.x1; x += TILE) {
            trace_splats(j, &r, x, y, &splats, trace);
            film_add(sums, part, &splats, j->film.margin);
        }
    }
    film_store(sums, part, &j->window, &out);
}

/* All of a window, tile by tile. */
static void trace_window(const struct job *j, tile_fn *trace)
{
    const struct window *w = &j->window;
    for (uint32_t y = 0; y < w->height; y += TILE) {
        for (uint32_t x = 0; x < w->width; x += TILE) {
            struct window part = *w;
            part.x += x;
            part.y += y;
            part.width = min_u32(w->width - x, TILE);
            part.height = min_u32(w->height - y, TILE);
            if (j->film.margin > 0)
                trace_part(j, &part, trace);
            else
                trace_pixels(j, x, y, trace);
        }
    }
}

void view_trace(const struct view *v, const struct trace_settings *t, const struct window *w,
                struct trace_output *out)
{
    struct job jobs[2];
    for (int k = 0, n = jobs_init(jobs, v, t, w, out); k < n; k++)
        trace_window(&jobs[k], tile_trace_streams);
}

/* ---- One path after another ------------------------------------------------------------------ */

/* The primary ray of a sample, through the point `at` of the picture, and its sampler. */
static struct ray start_path(const struct job *j, const struct tile *tile, uint32_t pixel,
                             uint32_t sample, struct sampler *sampler, struct vec2 *at,
                             float *offset)
{
    const struct stream_film *f = &j->film;
    const struct pixel_at p = tile_pixel(tile, pixel);
    const float cx = (float)p.x + 0.5f, cy = (float)p.y + 0.5f;
    *sampler = sampler_start(f->sampler, f->seed, (uint64_t)p.y * f->width + p.x,
                             j->settings.first_sample + sample);
    struct vec2 u = sampler_next_2d(sampler);
    if (f->margin > 0) {
        at->x = u.x + (cx - 0.5f);
        at->y = u.y + (cy - 0.5f);
    } else {
        at->x = cx + filter_sample(&f->filter, u.x, -cx, (float)f->width - cx);
        at->y = cy + filter_sample(&f->filter, u.y, -cy, (float)f->height - cy);
    }
    return path_start(&f->camera, at->x, at->y, sampler, offset);
}

static void trace_tile_plain(const struct job *j, struct tile *tile)
{
    for (uint32_t pixel = 0; pixel < tile->width * tile->height; pixel++) {
        for (uint32_t i = 0; i < j->settings.spp; i++) {
            struct sampler sampler;
            struct hit hit;
            struct vec2 at;
            float offset;
            struct ray ray = start_path(j, tile, pixel, i, &sampler, &at, &offset);
            accel_intersect(j->view->top, &ray, &hit);
            if (j->out.buffers) {
                const struct buffers_tile buffers = tile_buffers(j, tile);
                buffers_add_plain(j->view, &j->settings, &ray, offset, &hit, &sampler, i, pixel,
                                  &buffers);
            }
            if (!j->needs_light) continue;
            struct vec3 radiance = path_radiance(j->view, &j->settings, &ray, &hit,
                                                 j->settings.photons[i & 1], &sampler);
            struct film_weights weights;
            const struct pixel_at p = tile_pixel(tile, pixel);
            const float dx = at.x - ((float)p.x + 0.5f), dy = at.y - ((float)p.y + 0.5f);
            if (tile->splats) film_weigh(&weights, &j->film.filter, j->film.margin, 1, &dx, &dy);
            tile_add(j, tile, pixel, i, &weights, 0, radiance);
        }
    }
}

void view_trace_plain(const struct view *v, const struct trace_settings *t, const struct window *w,
                      struct trace_output *out)
{
    struct job jobs[2];
    for (int k = 0, n = jobs_init(jobs, v, t, w, out); k < n; k++)
        trace_window(&jobs[k], trace_tile_plain);
}

/* ---- In parallel ----------------------------------------------------------------------------- */

struct tiles {
    const struct job *job;
    struct reach reach;
    uint32_t x0, y0, columns,
        first;                /* of the first tile, in the window or with splats the picture */
    struct film_tile *splats; /* [run] */
};

static void trace_item(void *ctx, uint32_t item, uint32_t worker)
{
    const struct tiles *t = ctx;
    uint32_t index = t->first + item;
    uint32_t x = t->x0 + index % t->columns * TILE, y = t->y0 + index / t->columns * TILE;
    (void)worker;
    if (t->splats)
        trace_splats(t->job, &t->reach, x, y, &t->splats[item], tile_trace_streams);
    else
        trace_pixels(t->job, x, y, tile_trace_streams);
}

/* All tiles at once; where there is something to tell, or splats to add, in runs long enough to
 * keep all workers busy. */
static lmn_status trace_parallel(const struct job *j, struct pool *pool, lmn_progress_fn *progress,
                                 void *progress_user, struct error *err)
{
    const struct window *w = &j->window;
    struct tiles t = {.job = j};
    struct trace_output out = j->out;
    struct film_sum *sums = NULL;
    uint32_t run = progress ? 8 * pool_n_workers(pool) : UINT32_MAX;
    lmn_status status = LMN_OK;
    uint32_t width = w->width, height = w->height;
    if (j->film.margin > 0) {
        t.reach = reach_of(j, w);
        t.x0 = t.reach.x0 / TILE * TILE;
        t.y0 = t.reach.y0 / TILE * TILE;
        width = t.reach.x1 - t.x0;
        height = t.reach.y1 - t.y0;
        sums = mem_new((size_t)w->width * w->height, sizeof *sums);
        run = (progress ? 16 : 64) * pool_n_workers(pool);
        t.splats = mem_new(run, sizeof *t.splats);
        if (!sums || !t.splats) {
            status = fail_memory(err, "the picture");
            goto done;
        }
    }
    t.columns = (width + TILE - 1) / TILE;
    const uint32_t n = t.columns * ((height + TILE - 1) / TILE);
    for (uint32_t n_items; t.first < n; t.first += n_items) {
        n_items = min_u32(n - t.first, run);
        if (progress && progress(progress_user, t.first, n)) {
            status = fail(err, LMN_ERR_CANCELLED, "tracing was cancelled");
            goto done;
        }
        pool_run(pool, n_items, trace_item, &t);
        for (uint32_t i = 0; t.splats && i < n_items; i++)
            film_add(sums, w, &t.splats[i], j->film.margin);
    }
    if (progress && progress(progress_user, n, n))
        status = fail(err, LMN_ERR_CANCELLED, "tracing was cancelled");
    else if (t.splats)
        film_store(sums, w, w, &out);
done:
    mem_free(sums);
    mem_free(t.splats);
    return status;
}

lmn_status view_trace_parallel(const struct view *v, struct pool *pool,
                               const struct trace_settings *t, const struct window *w,
                               struct trace_output *out, lmn_progress_fn *progress,
                               void *progress_user, struct error *err)
{
    struct job jobs[2];
    const int n = jobs_init(jobs, v, t, w, out);
    lmn_status status = LMN_OK;
    for (int k = 0; k < n && !status; k++) /* buffers, which are quick, without telling */
        status = trace_parallel(&jobs[k], pool, k + 1 == n ? progress : NULL, progress_user, err);
    return status;
}
