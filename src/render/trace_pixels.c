/* SPDX-License-Identifier: Apache-2.0 */
#include "render/tile.h"

static void trace_list(const struct job *j, const struct pixel_at *pixels, uint32_t n)
{
    for (size_t first = 0; first < n; first += TILE_PIXELS) {
        struct tile tile = {.pixels = pixels + first, .first = first, .height = 1};
        tile.width = n - first < TILE_PIXELS ? (uint32_t)(n - first) : TILE_PIXELS;
        tile_finish(j, &tile, tile_trace_streams);
    }
}

void view_trace_pixels(const struct view *v, const struct trace_settings *t, uint32_t full_width,
                       uint32_t full_height, const struct pixel_at *pixels, uint32_t n,
                       struct trace_output *out)
{
    const struct window list = {full_width, full_height, 0, 0, n, 1};
    struct trace_settings settings = *t;
    struct job jobs[2];
    settings.splats = false;
    for (int k = 0, n_jobs = jobs_init(jobs, v, &settings, &list, out); k < n_jobs; k++)
        trace_list(&jobs[k], pixels, n);
}

void view_follow_pixels(const struct view *v, const struct trace_settings *t, uint32_t full_width,
                        uint32_t full_height, const struct pixel_at *pixels, uint32_t n,
                        struct chain_end *ends)
{
    const struct window list = {full_width, full_height, 0, 0, n, 1};
    const struct trace_output nothing = {0};
    struct job jobs[2];
    const unsigned before = tile_begin();
    jobs_init(jobs, v, t, &list, &nothing);
    buffers_follow(v, t, &jobs[0].film, pixels, n, ends);
    tile_end(before);
}

void view_trace_rays(const struct view *v, const struct trace_settings *t, const struct ray *rays,
                     uint32_t n, struct trace_output *out)
{
    const struct window list = {n, 1, 0, 0, n, 1};
    struct trace_settings settings = *t;
    struct job jobs[2];
    settings.splats = false;
    settings.shares_rays = true; /* so that there is one job */
    jobs_init(jobs, v, &settings, &list, out);
    jobs[0].rays = rays;
    for (uint32_t first = 0; first < n; first += TILE_PIXELS) {
        struct tile tile = {.x = first, .first = first, .height = 1};
        tile.width = n - first < TILE_PIXELS ? n - first : TILE_PIXELS;
        tile_finish(&jobs[0], &tile, tile_trace_streams);
    }
}
