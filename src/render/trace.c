/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>
#include <xmmintrin.h>

#include "base/pool.h"
#include "render/stream.h"
#include "render/view.h"
#include "render/world.h"

enum { TILE = 32 };

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

/* What a tile gathers before it is written out. */
struct tile {
    uint32_t x, y, width, height;     /* in the window */
    struct vec3 sums[TILE * TILE][2]; /* of even and odd samples */
    float buffers[TILE * TILE][BUFFER_CHANNELS];
};

/* Where a path belongs. */
struct origin {
    uint32_t pixel; /* of the tile */
    uint32_t sample;
};

static void add_buffers(const struct job *j, struct tile *tile, const struct origin *o,
                        const struct ray *ray, float offset, const struct hit *hit)
{
    const struct view *v = j->view;
    float *buffers = tile->buffers[o->pixel];
    path_add_buffers(v, &j->settings, ray, offset, hit, buffers);
    if (o->sample != 0 || hit->shape == SCENE_NONE) return;
    const struct view_instance *instance = &v->instances[hit->instance];
    buffers[BUFFER_SHAPE_ID] = (float)(instance->shapes[hit->shape].index + 1);
    buffers[BUFFER_PRIMITIVE_ID] = (float)hit->primitive;
}

/* A sample that is no number (broken normals in a file, an overflow) is black. */
static void add_radiance(struct tile *tile, const struct origin *o, struct vec3 radiance)
{
    struct vec3 *sum = &tile->sums[o->pixel][o->sample & 1];
    if (vec3_is_finite(radiance)) *sum = vec3_add(*sum, radiance);
}

/* Where a tile's pixel is in the window. */
static size_t pixel_of(const struct job *j, const struct tile *tile, uint32_t i)
{
    return (size_t)(tile->y + i / tile->width) * j->window.width + tile->x + i % tile->width;
}

/* Turns sums by emitter into means, and their sum into the pixel's colour. */
static void store_groups(const struct job *j, size_t pixel, float scale)
{
    uint32_t n_groups = j->view->world->scene->n_emitters;
    float *color = j->out.color ? j->out.color + 3 * pixel : NULL;
    for (int c = 0; color && c < 3; c++) color[c] = 0.0f;
    for (uint32_t g = 0; g < n_groups; g++) {
        float *group = j->out.groups + g * group_stride(j) + 3 * pixel;
        for (int c = 0; c < 3; c++) {
            group[c] *= scale;
            if (color) color[c] += group[c];
        }
    }
}

/* Traces what the stream holds and adds it to the tile. */
static void flush(const struct job *j, struct tile *tile, struct stream *s,
                  const struct origin *origins)
{
    uint32_t n = s->n; /* tracing leaves fewer lanes */
    stream_start(s, j->view, &j->film);
    stream_cast(s, j->view);
    for (uint32_t i = 0; j->out.buffers && i < n; i++) {
        struct ray ray = {lanes3_get(&s->o, i), 0.0f, lanes3_get(&s->d, i), s->t_max[i]};
        add_buffers(j, tile, &origins[i], &ray, s->offset[i], &s->hit[i]);
    }
    for (uint32_t i = 0; j->out.groups && i < n; i++)
        s->place[i] = 3 * pixel_of(j, tile, origins[i].pixel);
    if (j->needs_light) {
        stream_trace(s, j->view, &j->settings);
        for (uint32_t i = 0; i < n; i++)
            add_radiance(tile, &origins[i], lanes3_get(&s->radiance, i));
    }
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
        if (!j->out.buffers) continue;
        float *to = j->out.buffers + pixel * BUFFER_CHANNELS;
        memcpy(to, tile->buffers[i], sizeof tile->buffers[i]);
        for (int c = 0; c < BUFFER_SHAPE_ID; c++) to[c] *= scale;
    }
}

static void start_tile(const struct job *j, struct tile *tile, uint32_t x, uint32_t y)
{
    const struct window *w = &j->window;
    tile->x = x;
    tile->y = y;
    tile->width = w->width - x < TILE ? w->width - x : TILE;
    tile->height = w->height - y < TILE ? w->height - y : TILE;
    memset(tile->sums, 0, sizeof tile->sums);
    if (j->out.buffers) memset(tile->buffers, 0, sizeof tile->buffers);
}

static uint32_t min_u32(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* The tile whose top left pixel in the window is (x, y). */
static void trace_tile(const struct job *j, uint32_t x, uint32_t y)
{
    unsigned before = _mm_getcsr();
    _mm_setcsr(before | FAST_FLOATS);
    struct tile tile;
    struct stream stream;
    struct origin origins[STREAM_SIZE];
    start_tile(j, &tile, x, y);
    stream.n = 0;
    stream.groups = j->out.groups;
    stream.group_stride = group_stride(j);
    for (uint32_t pixel = 0; pixel < tile.width * tile.height; pixel++) {
        for (uint32_t i = 0; i < j->settings.spp; i++) {
            /* The same samples of a pixel share a stream wherever the pixel is. */
            uint32_t rest = j->settings.spp - i;
            if (i % STREAM_SIZE == 0 && stream.n + min_u32(rest, STREAM_SIZE) > STREAM_SIZE)
                flush(j, &tile, &stream, origins);
            origins[stream.n] = (struct origin){.pixel = pixel, .sample = i};
            stream_add(&stream, &j->film, j->window.x + x + pixel % tile.width,
                       j->window.y + y + pixel / tile.width, j->settings.first_sample + i);
        }
    }
    flush(j, &tile, &stream, origins);
    store_tile(j, &tile);
    _mm_setcsr(before);
}

void view_trace(const struct view *v, const struct trace_settings *t, const struct window *w,
                struct trace_output *out)
{
    struct job j;
    job_init(&j, v, t, w, out);
    for (uint32_t y = 0; y < w->height; y += TILE)
        for (uint32_t x = 0; x < w->width; x += TILE) trace_tile(&j, x, y);
}

/* ---- One path after another ------------------------------------------------------------------ */

/* The primary ray of sample o, and its sampler. */
static struct ray start_path(const struct job *j, const struct tile *tile, const struct origin *o,
                             struct sampler *sampler, float *offset)
{
    const struct stream_film *f = &j->film;
    uint32_t x = j->window.x + tile->x + o->pixel % tile->width;
    uint32_t y = j->window.y + tile->y + o->pixel / tile->width;
    float cx = (float)x + 0.5f, cy = (float)y + 0.5f;
    *sampler = sampler_start(f->sampler, f->seed, (uint64_t)y * f->width + x,
                             j->settings.first_sample + o->sample);
    struct vec2 u = sampler_next_2d(sampler);
    float px = cx + filter_sample(&f->filter, u.x, -cx, (float)f->width - cx);
    float py = cy + filter_sample(&f->filter, u.y, -cy, (float)f->height - cy);
    return path_start(&f->camera, px, py, sampler, offset);
}

static void trace_tile_plain(const struct job *j, uint32_t x, uint32_t y)
{
    unsigned before = _mm_getcsr();
    _mm_setcsr(before | FAST_FLOATS);
    struct tile tile;
    start_tile(j, &tile, x, y);
    for (uint32_t pixel = 0; pixel < tile.width * tile.height; pixel++) {
        for (uint32_t i = 0; i < j->settings.spp; i++) {
            struct origin o = {.pixel = pixel, .sample = i};
            struct sampler sampler;
            struct hit hit;
            float offset;
            struct ray ray = start_path(j, &tile, &o, &sampler, &offset);
            accel_intersect(j->view->top, &ray, &hit);
            if (j->out.buffers) add_buffers(j, &tile, &o, &ray, offset, &hit);
            if (!j->needs_light) continue;
            struct vec3 radiance = path_radiance(j->view, &j->settings, &ray, &hit,
                                                 j->settings.photons[i & 1], &sampler);
            add_radiance(&tile, &o, radiance);
        }
    }
    store_tile(j, &tile);
    _mm_setcsr(before);
}

void view_trace_plain(const struct view *v, const struct trace_settings *t, const struct window *w,
                      struct trace_output *out)
{
    struct job j;
    job_init(&j, v, t, w, out);
    for (uint32_t y = 0; y < w->height; y += TILE)
        for (uint32_t x = 0; x < w->width; x += TILE) trace_tile_plain(&j, x, y);
}

/* ---- In parallel ----------------------------------------------------------------------------- */

struct tiles {
    struct job job;
    uint32_t columns, first;
};

static void trace_item(void *ctx, uint32_t item, uint32_t worker)
{
    const struct tiles *t = ctx;
    uint32_t index = t->first + item;
    (void)worker;
    trace_tile(&t->job, index % t->columns * TILE, index / t->columns * TILE);
}

lmn_status view_trace_parallel(const struct view *v, struct pool *pool,
                               const struct trace_settings *t, const struct window *w,
                               struct trace_output *out, lmn_progress_fn *progress,
                               void *progress_user, struct error *err)
{
    struct tiles tiles;
    job_init(&tiles.job, v, t, w, out);
    tiles.columns = (w->width + TILE - 1) / TILE;
    uint32_t n = tiles.columns * ((w->height + TILE - 1) / TILE);
    /* Without someone to tell, all at once; else in runs long enough to keep all workers busy. */
    uint32_t run = progress ? 8 * pool_n_workers(pool) : n;
    for (tiles.first = 0; tiles.first < n; tiles.first += run) {
        if (progress && progress(progress_user, tiles.first, n))
            return fail(err, LMN_ERR_CANCELLED, "tracing was cancelled");
        pool_run(pool, n - tiles.first < run ? n - tiles.first : run, trace_item, &tiles);
    }
    if (progress && progress(progress_user, n, n))
        return fail(err, LMN_ERR_CANCELLED, "tracing was cancelled");
    return LMN_OK;
}
