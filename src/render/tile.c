/* SPDX-License-Identifier: Apache-2.0 */
#include "render/tile.h"

#include <string.h>
#include <xmmintrin.h>

#include "base/clock.h"
#include "render/world.h"

/* Flush-to-zero and denormals-are-zero. */
enum { FAST_FLOATS = 0x8040 };

_Static_assert((int)FILM_SAMPLES >= (int)STREAM_SIZE, "a stream is weighed at once");

unsigned tile_begin(void)
{
    const unsigned before = _mm_getcsr();
    _mm_setcsr(before | FAST_FLOATS);
    return before;
}

void tile_end(unsigned before)
{
    _mm_setcsr(before);
}

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

int jobs_init(struct job jobs[2], const struct view *v, const struct trace_settings *t,
              const struct window *w, const struct trace_output *out)
{
    const struct trace_output buffers = {.buffers = out->buffers, .chain = out->chain};
    struct trace_output light = *out;
    light.buffers = light.chain = NULL;
    job_init(&jobs[0], v, t, w, out);
    if (!out->buffers || !jobs[0].needs_light) return 1;
    const bool shares_rays = t->shares_rays || jobs[0].settings.spp >= BUFFERS_BLOCK_SPP;
    if (jobs[0].film.margin == 0 && shares_rays) return 1;
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

/* Where the paths of a stream belong. */
struct origins {
    uint32_t pixel[STREAM_SIZE]; /* of the tile */
    uint32_t sample[STREAM_SIZE];
};

void tile_add(const struct job *j, struct tile *tile, uint32_t pixel, uint32_t sample,
              const struct film_weights *weights, uint32_t k, struct vec3 radiance)
{
    if (!vec3_is_finite(radiance)) radiance = vec3_splat(0.0f);
    if (tile->splats) {
        const struct pixel_at at = tile_pixel(tile, pixel);
        film_tile_add(tile->splats, j->film.margin, weights, k, at.x, at.y, sample & 1, radiance);
    } else {
        struct vec3 *sum = &tile->sums[pixel][sample & 1];
        *sum = vec3_add(*sum, radiance);
    }
}

/* Where a tile's pixel is in the results. */
static size_t place_of(const struct job *j, const struct tile *tile, uint32_t i)
{
    return tile->first + (size_t)(i / tile->width) * j->window.width + i % tile->width;
}

struct buffers_tile tile_buffers(const struct job *j, const struct tile *tile)
{
    return (struct buffers_tile){
        .x = tile->x,
        .y = tile->y,
        .width = tile->width,
        .height = tile->height,
        .pixels = tile->pixels,
        .to = j->out.buffers + tile->first * BUFFER_CHANNELS,
        .chain = j->out.chain ? j->out.chain + tile->first * CHAIN_CHANNELS : NULL,
        .stride = j->window.width,
        .is_large = (size_t)j->window.width * j->window.height > BUFFERS_CACHED,
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
    for (uint32_t i = 0; j->rays && i < n; i++) {
        const struct ray *ray = &j->rays[tile->first + origins->pixel[i]];
        lanes3_set(&s->o, i, ray->o);
        lanes3_set(&s->d, i, ray->d);
        s->t_max[i] = ray->t_max;
        s->offset[i] = 0.0f;
    }
    if (tile->splats) {
        float dx[STREAM_SIZE], dy[STREAM_SIZE];
        for (uint32_t i = 0; i < n; i++) dx[i] = s->u[0][i] - s->center_x[i];
        for (uint32_t i = 0; i < n; i++) dy[i] = s->u[1][i] - s->center_y[i];
        film_weigh(&weights, &j->film.filter, j->film.margin, n, dx, dy);
    }
    stream_cast(s, j->view, true);
    if (j->out.buffers) {
        const struct buffers_tile buffers = tile_buffers(j, tile);
        buffers_add_stream(j->view, &j->settings, &j->film, s, &buffers, origins->sample,
                           origins->pixel);
    }
    for (uint32_t i = 0; (j->out.groups || j->out.ends) && i < n; i++)
        s->place[i] = 3 * place_of(j, tile, origins->pixel[i]);
    stream_trace(s, j->view, &j->settings);
    for (uint32_t i = 0; i < n; i++)
        tile_add(j, tile, origins->pixel[i], origins->sample[i], &weights, i,
                 lanes3_get(&s->radiance, i));
    s->n = 0;
}

static void store_tile(const struct job *j, const struct tile *tile)
{
    float scale = 1.0f / (float)j->settings.spp;
    for (uint32_t i = 0; i < tile->width * tile->height; i++) {
        size_t pixel = place_of(j, tile, i);
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

void tile_trace_streams(const struct job *j, struct tile *tile)
{
    struct stream stream;
    struct origins origins;
    if (!j->needs_light) {
        const struct buffers_tile buffers = tile_buffers(j, tile);
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
    stream.ends = j->out.ends;
    stream.lengths = j->out.lengths;
    stream.first_sample = j->settings.first_sample;
    for (uint32_t pixel = 0; pixel < tile->width * tile->height; pixel++) {
        const struct pixel_at at = tile_pixel(tile, pixel);
        for (uint32_t i = 0; i < j->settings.spp; i++) {
            /* The same samples of a pixel share a stream wherever the pixel is. */
            uint32_t rest = j->settings.spp - i;
            if (i % STREAM_SIZE == 0 && stream.n + min_u32(rest, STREAM_SIZE) > STREAM_SIZE)
                flush(j, tile, &stream, &origins);
            origins.pixel[stream.n] = pixel;
            origins.sample[stream.n] = i;
            stream_add(&stream, &j->film, at.x, at.y, j->settings.first_sample + i);
        }
    }
    flush(j, tile, &stream, &origins);
    if (!j->out.clock) return;
    j->out.clock->rays += stream.ray_ticks;
    j->out.clock->all += clock_ticks() - start;
}

void tile_finish(const struct job *j, struct tile *tile, tile_fn *trace)
{
    struct vec3 sums[TILE_PIXELS][2];
    const unsigned before = tile_begin();
    tile->sums = sums;
    if (j->needs_light) memset(sums, 0, (size_t)tile->width * tile->height * sizeof *sums);
    trace(j, tile);
    if (j->needs_light) store_tile(j, tile);
    if (j->out.buffers) {
        const struct buffers_tile buffers = tile_buffers(j, tile);
        buffers_scale(&j->settings, &buffers);
    }
    tile_end(before);
}
