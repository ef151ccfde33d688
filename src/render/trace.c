/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>
#include <xmmintrin.h>

#include "base/clock.h"
#include "base/mem.h"
#include "base/pool.h"
#include "render/buffers.h"
#include "render/film.h"
#include "render/view.h"
#include "render/world.h"

enum { TILE = FILM_TILE };

/* Flush-to-zero and denormals-are-zero: Embree wants them, and results must not depend on what the
 * calling thread had set. */
enum { FAST_FLOATS = 0x8040 };

const char *const buffer_channel_names[BUFFER_CHANNELS] = {
    "position.X", "position.Y",   "position.Z",   "normal.X",     "normal.Y",
    "normal.Z",   "geo_normal.X", "geo_normal.Y", "geo_normal.Z", "albedo.R",
    "albedo.G",   "albedo.B",     "roughness.Y",  "wo.X",         "wo.Y",
    "wo.Z",       "wi.X",         "wi.Y",         "wi.Z",         "emission.R",
    "emission.G", "emission.B",   "depth.Z",      "shape.ID",     "primitive.ID",
};

const char *const chain_channel_names[CHAIN_CHANNELS] = {
    "chain_throughput.R", "chain_throughput.G", "chain_throughput.B",
    "chain_emission.R",   "chain_emission.G",   "chain_emission.B",
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

/* What all pixels of a picture share. */
struct job {
    const struct view *view;
    struct trace_settings settings;
    struct window window;
    struct trace_output out;
    struct stream_film film;
    bool needs_light;
};

static void job_init(struct job *j, const struct view *v, const struct trace_settings *t,
                     const struct window *w, const struct trace_output *out)
{
    *j = (struct job){.view = v, .settings = *t, .window = *w, .out = *out};
    if (j->settings.spp == 0) j->settings.spp = 1;
    if ((out->half_a || out->half_b) && j->settings.spp % 2) j->settings.spp++;
    j->needs_light = out->color || out->half_a || out->half_b || out->groups;
    j->film = (struct stream_film){
        .width = w->full_width, .height = w->full_height, .sampler = t->sampler, .seed = t->seed};
    camera_init(&j->film.camera, &view_state(v)->sensor, w->full_width, w->full_height);
    filter_init(&j->film.filter, t->filter, t->filter_radius, t->filter_stddev);
    if (t->splats && j->needs_light && !out->groups) j->film.margin = film_margin(&j->film.filter);
}

/* What is asked for, in one job or in two: buffers are never splatted, and of few samples they have
 * packets of their own. Returns how many. */
static int jobs_init(struct job jobs[2], const struct view *v, const struct trace_settings *t,
                     const struct window *w, const struct trace_output *out)
{
    const struct trace_output buffers = {.buffers = out->buffers, .chain = out->chain};
    struct trace_output light = *out;
    light.buffers = light.chain = NULL;
    job_init(&jobs[0], v, t, w, out);
    if (!out->buffers || !jobs[0].needs_light) return 1;
    if (jobs[0].film.margin == 0 && jobs[0].settings.spp >= BUFFERS_BLOCK_SPP) return 1;
    job_init(&jobs[0], v, t, w, &buffers);
    job_init(&jobs[1], v, t, w, &light);
    return 2;
}

static size_t group_stride(const struct job *j)
{
    return (size_t)j->window.width * j->window.height * 3;
}

static void store(float *to, size_t pixel, struct vec3 sum, float scale)
{
    if (!to) return;
    to[3 * pixel + 0] = sum.x * scale;
    to[3 * pixel + 1] = sum.y * scale;
    to[3 * pixel + 2] = sum.z * scale;
}

/* A part of the picture, and where its samples go. */
struct tile {
    uint32_t x, y, width, height; /* in the picture; pixels are counted row by row */
    struct film_tile *splats;     /* NULL: samples count for their pixel */
    struct vec3 (*sums)[2];       /* else: of a pixel's even and odd samples */
};

/* Where the paths of a stream belong. */
struct origins {
    uint32_t pixel[STREAM_SIZE]; /* of the tile */
    uint32_t sample[STREAM_SIZE];
};

/* Sample k of the weights, which splats want. One that is no number (broken normals in a file, an
 * overflow) is black. */
static void add_radiance(const struct job *j, struct tile *tile, uint32_t pixel, uint32_t sample,
                         const struct film_weights *weights, uint32_t k, struct vec3 radiance)
{
    if (!vec3_is_finite(radiance)) radiance = vec3_splat(0.0f);
    if (tile->splats) {
        film_tile_add(tile->splats, j->film.margin, weights, k, tile->x + pixel % tile->width,
                      tile->y + pixel / tile->width, sample & 1, radiance);
    } else {
        struct vec3 *sum = &tile->sums[pixel][sample & 1];
        *sum = vec3_add(*sum, radiance);
    }
}

/* Where a tile's pixel is in the window. */
static size_t pixel_of(const struct job *j, const struct tile *tile, uint32_t i)
{
    uint32_t x = tile->x - j->window.x, y = tile->y - j->window.y;
    return (size_t)(y + i / tile->width) * j->window.width + x + i % tile->width;
}

static struct buffers_tile buffers_of(const struct job *j, const struct tile *tile)
{
    const size_t first = pixel_of(j, tile, 0);
    return (struct buffers_tile){
        .x = tile->x,
        .y = tile->y,
        .width = tile->width,
        .height = tile->height,
        .to = j->out.buffers + first * BUFFER_CHANNELS,
        .chain = j->out.chain ? j->out.chain + first * CHAIN_CHANNELS : NULL,
        .stride = j->window.width,
    };
}

/* Turns sums by group into means, and their sum into the pixel's colour. */
static void store_groups(const struct job *j, size_t pixel, float scale)
{
    float *color = j->out.color ? j->out.color + 3 * pixel : NULL;
    for (int c = 0; color && c < 3; c++) color[c] = 0.0f;
    for (uint32_t g = 0; g < j->out.n_groups; g++) {
        float *group = j->out.groups + g * group_stride(j) + 3 * pixel;
        for (int c = 0; c < 3; c++) {
            group[c] *= scale;
            if (color) color[c] += group[c];
        }
    }
}

/* Traces what the stream holds and adds it to the tile. */
static void flush(const struct job *j, struct tile *tile, struct stream *s,
                  const struct origins *origins)
{
    uint32_t n = s->n; /* tracing leaves fewer lanes */
    struct film_weights weights;
    stream_start(s, j->view, &j->film);
    if (tile->splats) {
        float dx[STREAM_SIZE], dy[STREAM_SIZE];
        for (uint32_t i = 0; i < n; i++) dx[i] = s->u[0][i] - s->center_x[i];
        for (uint32_t i = 0; i < n; i++) dy[i] = s->u[1][i] - s->center_y[i];
        film_weigh(&weights, &j->film.filter, j->film.margin, n, dx, dy);
    }
    stream_cast(s, j->view, true);
    if (j->out.buffers) {
        const struct buffers_tile buffers = buffers_of(j, tile);
        buffers_add_stream(j->view, &j->settings, &j->film, s, &buffers, origins->sample,
                           origins->pixel);
    }
    for (uint32_t i = 0; j->out.groups && i < n; i++)
        s->place[i] = 3 * pixel_of(j, tile, origins->pixel[i]);
    stream_trace(s, j->view, &j->settings);
    for (uint32_t i = 0; i < n; i++)
        add_radiance(j, tile, origins->pixel[i], origins->sample[i], &weights, i,
                     lanes3_get(&s->radiance, i));
    s->n = 0;
}

static void store_tile(const struct job *j, const struct tile *tile)
{
    float scale = 1.0f / (float)j->settings.spp;
    for (uint32_t i = 0; i < tile->width * tile->height; i++) {
        size_t pixel = pixel_of(j, tile, i);
        const struct vec3 *sums = tile->sums[i];
        store(j->out.color, pixel, vec3_add(sums[0], sums[1]), scale);
        store(j->out.half_a, pixel, sums[0], 2.0f * scale);
        store(j->out.half_b, pixel, sums[1], 2.0f * scale);
        if (j->out.groups) store_groups(j, pixel, scale);
    }
}

static uint32_t min_u32(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* Traces a tile, not larger than TILE, whose place and `splats` are set. */
typedef void tile_fn(const struct job *j, struct tile *tile);

static void trace_tile(const struct job *j, struct tile *tile)
{
    struct stream stream;
    struct origins origins;
    if (!j->needs_light) {
        const struct buffers_tile buffers = buffers_of(j, tile);
        buffers_trace(j->view, &j->settings, &j->film, &buffers);
        return;
    }
    const uint64_t start = clock_ticks();
    stream.n = 0;
    stream.ray_ticks = 0;
    stream.groups = j->out.groups;
    stream.group_of = j->out.group_of;
    stream.chain_group = j->out.groups ? j->out.chain_group : 0;
    stream.group_stride = group_stride(j);
    for (uint32_t pixel = 0; pixel < tile->width * tile->height; pixel++) {
        for (uint32_t i = 0; i < j->settings.spp; i++) {
            /* The same samples of a pixel share a stream wherever the pixel is. */
            uint32_t rest = j->settings.spp - i;
            if (i % STREAM_SIZE == 0 && stream.n + min_u32(rest, STREAM_SIZE) > STREAM_SIZE)
                flush(j, tile, &stream, &origins);
            origins.pixel[stream.n] = pixel;
            origins.sample[stream.n] = i;
            stream_add(&stream, &j->film, tile->x + pixel % tile->width,
                       tile->y + pixel / tile->width, j->settings.first_sample + i);
        }
    }
    flush(j, tile, &stream, &origins);
    if (!j->out.clock) return;
    j->out.clock->rays += stream.ray_ticks;
    j->out.clock->all += clock_ticks() - start;
}

/* ---- Tiles of a window ----------------------------------------------------------------------- */

/* Each sample for its own pixel: a tile of the window whose top left pixel there is (x, y). */
static void trace_pixels(const struct job *j, uint32_t x, uint32_t y, tile_fn *trace)
{
    const struct window *w = &j->window;
    unsigned before = _mm_getcsr();
    _mm_setcsr(before | FAST_FLOATS);
    struct vec3 sums[TILE * TILE][2];
    struct tile tile = {.x = w->x + x, .y = w->y + y, .sums = sums};
    tile.width = min_u32(w->width - x, TILE);
    tile.height = min_u32(w->height - y, TILE);
    if (j->needs_light) memset(sums, 0, sizeof sums);
    trace(j, &tile);
    if (j->needs_light) store_tile(j, &tile);
    if (j->out.buffers) {
        const struct buffers_tile buffers = buffers_of(j, &tile);
        buffers_scale(&j->settings, &buffers);
    }
    _mm_setcsr(before);
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
    unsigned before = _mm_getcsr();
    _mm_setcsr(before | FAST_FLOATS);
    struct tile tile = {.x = x > r->x0 ? x : r->x0, .y = y > r->y0 ? y : r->y0, .splats = splats};
    tile.width = min_u32(x + TILE, r->x1) - tile.x;
    tile.height = min_u32(y + TILE, r->y1) - tile.y;
    film_tile_start(splats, j->film.margin, x, y);
    trace(j, &tile);
    _mm_setcsr(before);
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
        trace_window(&jobs[k], trace_tile);
}

/* ---- One path after another ------------------------------------------------------------------ */

/* The primary ray of a sample, through the point `at` of the picture, and its sampler. */
static struct ray start_path(const struct job *j, const struct tile *tile, uint32_t pixel,
                             uint32_t sample, struct sampler *sampler, struct vec2 *at,
                             float *offset)
{
    const struct stream_film *f = &j->film;
    uint32_t x = tile->x + pixel % tile->width, y = tile->y + pixel / tile->width;
    float cx = (float)x + 0.5f, cy = (float)y + 0.5f;
    *sampler = sampler_start(f->sampler, f->seed, (uint64_t)y * f->width + x,
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
                const struct buffers_tile buffers = buffers_of(j, tile);
                buffers_add_plain(j->view, &j->settings, &ray, offset, &hit, &sampler, i, pixel,
                                  &buffers);
            }
            if (!j->needs_light) continue;
            struct vec3 radiance = path_radiance(j->view, &j->settings, &ray, &hit,
                                                 j->settings.photons[i & 1], &sampler);
            struct film_weights weights;
            const float dx = at.x - ((float)(tile->x + pixel % tile->width) + 0.5f);
            const float dy = at.y - ((float)(tile->y + pixel / tile->width) + 0.5f);
            if (tile->splats) film_weigh(&weights, &j->film.filter, j->film.margin, 1, &dx, &dy);
            add_radiance(j, tile, pixel, i, &weights, 0, radiance);
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
        trace_splats(t->job, &t->reach, x, y, &t->splats[item], trace_tile);
    else
        trace_pixels(t->job, x, y, trace_tile);
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
