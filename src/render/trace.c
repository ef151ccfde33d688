/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>
#include <xmmintrin.h>

#include "base/pool.h"
#include "render/camera.h"
#include "render/filter.h"
#include "render/path.h"
#include "render/view.h"

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
    struct camera camera;
    struct filter filter;
    bool needs_light;
};

static void job_init(struct job *j, const struct view *v, const struct trace_settings *t,
                     const struct window *w, const struct trace_output *out)
{
    *j = (struct job){.view = v, .settings = *t, .window = *w, .out = *out};
    if (j->settings.spp == 0) j->settings.spp = 1;
    if ((out->half_a || out->half_b) && j->settings.spp % 2) j->settings.spp++;
    j->needs_light = out->color || out->half_a || out->half_b;
    camera_init(&j->camera, &view_state(v)->sensor, w->full_width, w->full_height);
    filter_init(&j->filter, t->filter, t->filter_radius, t->filter_stddev);
}

static void store(float *to, size_t pixel, struct vec3 sum, float scale)
{
    if (!to) return;
    to[3 * pixel + 0] = sum.x * scale;
    to[3 * pixel + 1] = sum.y * scale;
    to[3 * pixel + 2] = sum.z * scale;
}

/* Pixel (x, y) of the full picture, which is number `pixel` of the window. */
static void trace_pixel(const struct job *j, uint32_t x, uint32_t y, size_t pixel)
{
    const struct trace_settings *t = &j->settings;
    const struct window *w = &j->window;
    struct vec3 sums[2] = {0};
    float buffers[BUFFER_CHANNELS] = {0};
    float cx = (float)x + 0.5f, cy = (float)y + 0.5f;
    float right = (float)w->full_width - cx, bottom = (float)w->full_height - cy;
    for (uint32_t i = 0; i < t->spp; i++) {
        struct sampler sampler = sampler_start(t->sampler, t->seed, (uint64_t)y * w->full_width + x,
                                               i);
        struct vec2 u = sampler_next_2d(&sampler);
        float px = cx + filter_sample(&j->filter, u.x, -cx, right);
        float py = cy + filter_sample(&j->filter, u.y, -cy, bottom);
        float offset;
        struct ray ray = camera_ray(&j->camera, px, py, &offset);
        struct hit hit;
        accel_intersect(j->view->top, &ray, true, &hit);
        if (j->out.buffers) {
            path_add_buffers(j->view, t, &ray, offset, &hit, buffers);
            if (i == 0 && hit.shape != SCENE_NONE) {
                const struct view_instance *instance = &j->view->instances[hit.instance];
                buffers[BUFFER_SHAPE_ID] = (float)(instance->shapes[hit.shape].index + 1);
                buffers[BUFFER_PRIMITIVE_ID] = (float)hit.primitive;
            }
        }
        if (!j->needs_light) continue;
        struct vec3 radiance = path_radiance(j->view, t, &ray, &hit, &sampler);
        /* A sample that is no number (a file's broken normals, an overflow) counts as black. */
        if (vec3_is_finite(radiance)) sums[i & 1] = vec3_add(sums[i & 1], radiance);
    }
    float scale = 1.0f / (float)t->spp;
    store(j->out.color, pixel, vec3_add(sums[0], sums[1]), scale);
    store(j->out.half_a, pixel, sums[0], 2.0f * scale);
    store(j->out.half_b, pixel, sums[1], 2.0f * scale);
    if (!j->out.buffers) return;
    for (int c = 0; c < BUFFER_SHAPE_ID; c++) buffers[c] *= scale;
    memcpy(j->out.buffers + pixel * BUFFER_CHANNELS, buffers, sizeof buffers);
}

/* Columns [x0, x1) and rows [y0, y1) of the window. */
static void trace_rectangle(const struct job *j, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
{
    unsigned before = _mm_getcsr();
    _mm_setcsr(before | FAST_FLOATS);
    for (uint32_t y = y0; y < y1; y++)
        for (uint32_t x = x0; x < x1; x++)
            trace_pixel(j, j->window.x + x, j->window.y + y, (size_t)y * j->window.width + x);
    _mm_setcsr(before);
}

void view_trace(const struct view *v, const struct trace_settings *t, const struct window *w,
                struct trace_output *out)
{
    struct job j;
    job_init(&j, v, t, w, out);
    trace_rectangle(&j, 0, 0, w->width, w->height);
}

/* ---- In parallel ----------------------------------------------------------------------------- */

struct tiles {
    struct job job;
    uint32_t columns, first;
};

static void trace_tile(void *ctx, uint32_t item, uint32_t worker)
{
    const struct tiles *t = ctx;
    const struct window *w = &t->job.window;
    uint32_t index = t->first + item;
    uint32_t x = index % t->columns * TILE, y = index / t->columns * TILE;
    (void)worker;
    trace_rectangle(&t->job, x, y, x + TILE < w->width ? x + TILE : w->width,
                    y + TILE < w->height ? y + TILE : w->height);
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
        pool_run(pool, n - tiles.first < run ? n - tiles.first : run, trace_tile, &tiles);
    }
    if (progress && progress(progress_user, n, n))
        return fail(err, LMN_ERR_CANCELLED, "tracing was cancelled");
    return LMN_OK;
}
