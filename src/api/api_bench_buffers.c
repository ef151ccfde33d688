/* SPDX-License-Identifier: Apache-2.0 */
/* Public measurements of the first-hit buffers: what a neural frame waits for before its network.
 */
#include "api/bench_private.h"

#include "base/clock.h"
#include "base/mem.h"
#include "render/view.h"

lmn_status bench_values(lmn_context *context, const lmn_scene *scene, const struct bench_options *o,
                        float *u, struct error *err)
{
    lmn_status status = LMN_OK;
    double *values = mem_new((size_t)scene->scene->n_variables + 1, sizeof *values);
    if (!values) return fail_memory(err, "the values");
    lmn_scene_default_values(scene, values);
    for (uint32_t i = 0; i < o->n_sets; i++)
        TRY(lmn_scene_parse_value(context, scene, o->sets[i], values));
    TRY(scene_units(scene, values, u, err));
done:
    mem_free(values);
    return status;
}

/* Seconds of view_set() and buffers, of the same configuration again and again. */
static lmn_status time_pictures(lmn_context *context, const lmn_scene *scene,
                                const struct trace_settings *t, const struct window *w,
                                uint32_t runs, double *times, struct error *err)
{
    lmn_status status = LMN_OK;
    struct scene_cache *c = scene->cache;
    struct trace_output output = {
        .buffers = mem_new((size_t)w->width * w->height * BUFFER_CHANNELS, sizeof(float))};
    struct trace_settings seeded = *t;
    if (!output.buffers) return fail_memory(err, "the buffers");
    for (uint32_t i = 0; i <= runs; i++) {
        const double start_s = clock_wall_s();
        seeded.seed = i;
        view_set(c->view, c->u);
        TRY(view_trace_parallel(c->view, context->pool, &seeded, w, &output, NULL, NULL, err));
        if (i > 0) times[i - 1] = clock_wall_s() - start_s; /* the first one warms up */
    }
done:
    mem_free(output.buffers);
    return status;
}

static lmn_status bench_buffers_of(lmn_context *context, const struct bench_options *o,
                                   const char *path, double *times, struct json *j,
                                   struct error *err)
{
    lmn_status status = LMN_OK;
    lmn_scene *scene = NULL;
    struct trace_settings t;
    struct window w;
    const uint32_t size[2] = {o->size[0] ? o->size[0] : 900, o->size[1] ? o->size[1] : 900};
    TRY(lmn_scene_load(context, path, NULL, &scene));
    TRY(scene_window(scene, size, (uint32_t[4]){0}, &w, err));
    TRY(bench_values(context, scene, o, scene->cache->u, err));
    TRY(scene_view(scene, err));
    trace_settings_init(&t, scene->scene);
    t.spp = o->spp ? o->spp : 1;
    TRY(time_pictures(context, scene, &t, &w, o->runs, times, err));
    const double buffers_s = bench_median(times, o->runs);
    json_begin_object(j, NULL);
    json_put_string(j, "file", path);
    json_begin_array(j, "size");
    json_put_integer(j, NULL, size[0]);
    json_put_integer(j, NULL, size[1]);
    json_end(j);
    json_put_integer(j, "buffer_spp", t.spp);
    json_put_number(j, "buffers_s", buffers_s);
    json_put_number(j, "buffers_min_s", times[0]);
    json_put_number(j, "buffers_max_s", times[o->runs - 1]);
    json_put_number(j, "frames_per_s", 1.0 / buffers_s);
    json_end(j);
done:
    lmn_scene_free(scene);
    return status;
}

lmn_status bench_buffers(lmn_context *context, const struct bench_options *o, struct json *j,
                         struct error *err)
{
    lmn_status status = LMN_OK;
    double *times = mem_new(o->runs, sizeof *times);
    if (!times) return fail_memory(err, "the times");
    json_begin_array(j, "results");
    for (uint32_t i = 0; i < o->n_files && status == LMN_OK; i++) {
        status = bench_buffers_of(context, o, o->files[i], times, j, err);
        if (status == LMN_OK) status = bench_progress(context, i + 1, o->n_files, err);
    }
    json_end(j);
    mem_free(times);
    return status;
}
