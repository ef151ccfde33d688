/* SPDX-License-Identifier: Apache-2.0 */
/* Public measurements of the network, and of frames by it. */
#include "api/bench_private.h"
#include "base/clock.h"
#include "base/mem.h"
#include "nn/bench_nn.h"
#include "train/painter.h"

/* As many variables as the paper's richest scene has. */
enum { N_VARIABLES = 12, PATCH_SIZE = 32 };

static struct generator_config config_of(const struct bench_options *o, uint32_t n_variables)
{
    return (struct generator_config){
        .n_variables = n_variables, .width = o->width, .depth = o->depth, .patch_size = PATCH_SIZE};
}

static void put_result(struct json *j, const char *name, const struct nn_bench_result *r,
                       double peak)
{
    json_begin_object(j, NULL);
    json_put_string(j, "name", name);
    json_put_number(j, "seconds", r->seconds);
    json_put_number(j, "gflop", r->gflop);
    json_put_number(j, "gflops", r->gflops);
    json_put_number(j, "share_of_peak", r->gflops / peak);
    json_end(j);
}

lmn_status bench_train(lmn_context *context, const struct bench_options *o, struct json *j,
                       struct error *err)
{
    lmn_status status = LMN_OK;
    const struct generator_config config = config_of(o, N_VARIABLES);
    struct nn_bench_result r;
    const double peak = nn_bench_peak_gflops(context->cpu, context->pool);
    TRY(bench_progress(context, 1, 3, err));
    TRY(nn_bench_step(&config, context->pool, context->cpu, o->patches, o->runs, &r, err));
    /* The peak again, so that a machine whose clock or load changed meanwhile shows. */
    const double peak_after = nn_bench_peak_gflops(context->cpu, context->pool);
    const double best = peak > peak_after ? peak : peak_after;
    TRY(bench_progress(context, 3, 3, err));
    json_begin_array(j, "results");
    json_begin_object(j, NULL);
    json_put_string(j, "kernels", nn_bench_kernels(context->cpu));
    json_put_integer(j, "width", o->width);
    json_put_integer(j, "depth", o->depth);
    json_put_integer(j, "patches", o->patches);
    json_put_integer(j, "patch_size", PATCH_SIZE);
    json_put_integer(j, "weights", (int64_t)r.n_weights);
    json_put_integer(j, "memory_bytes", (int64_t)r.memory_size);
    json_put_number(j, "step_s", r.seconds);
    json_put_number(j, "gflop", r.gflop);
    json_put_number(j, "gflops", r.gflops);
    json_put_number(j, "peak_gflops", best);
    json_put_number(j, "share_of_peak", r.gflops / best);
    json_end(j);
    json_end(j);
done:
    return status;
}

lmn_status bench_kernels(lmn_context *context, const struct bench_options *o, struct json *j,
                         struct error *err)
{
    lmn_status status = LMN_OK;
    const struct generator_config config = config_of(o, N_VARIABLES);
    struct nn_bench_result r;
    const double peak = nn_bench_peak_gflops(context->cpu, context->pool);
    json_put_string(j, "kernels", nn_bench_kernels(context->cpu));
    json_put_integer(j, "width", o->width);
    json_put_integer(j, "depth", o->depth);
    json_put_number(j, "peak_gflops", peak);
    json_begin_array(j, "results");
    TRY(nn_bench_render(&config, context->pool, context->cpu, 65536, o->runs, &r, err));
    put_result(j, "render 65536 pixels", &r, peak);
    TRY(bench_progress(context, 1, 3, err));
    TRY(nn_bench_step(&config, context->pool, context->cpu, o->patches, o->runs, &r, err));
    put_result(j, "step", &r, peak);
    TRY(bench_progress(context, 2, 3, err));
    TRY(nn_bench_probe(&config, context->pool, context->cpu, o->patches, o->runs, &r, err));
    put_result(j, "probe", &r, peak);
    TRY(bench_progress(context, 3, 3, err));
    json_end(j);
done:
    return status;
}

/* ---- Frames ------------------------------------------------------------------------------- */

/* The index-th of a stream of configurations, or always the one that was asked for. */
static lmn_status choose_values(lmn_context *context, const lmn_scene *scene,
                                const struct bench_options *o, uint32_t index, struct error *err)
{
    if (o->n_sets > 0) return bench_values(context, scene, o, scene->cache->u, err);
    bench_configuration(scene->scene, index, scene->cache->u);
    return LMN_OK;
}

static lmn_status time_buffers(lmn_context *context, const lmn_scene *scene,
                               const struct bench_options *o, const struct model_render_options *r,
                               double *times, struct error *err)
{
    lmn_status status = LMN_OK;
    struct trace_settings t;
    struct trace_output output = {0};
    struct scene_cache *c = scene->cache;
    trace_settings_init(&t, scene->scene);
    t.spp = r->buffer_spp;
    output.buffers = mem_new((size_t)r->window.width * r->window.height * BUFFER_CHANNELS,
                             sizeof(float));
    if (!output.buffers) return fail_memory(err, "the buffers");
    TRY(scene_view(scene, err));
    for (uint32_t i = 0; i <= o->runs; i++) {
        TRY(choose_values(context, scene, o, i, err));
        const double start_s = clock_wall_s();
        view_set(c->view, c->u);
        TRY(view_trace_parallel(c->view, context->pool, &t, &r->window, &output, NULL, NULL, err));
        if (i > 0) times[i - 1] = clock_wall_s() - start_s;
    }
done:
    mem_free(output.buffers);
    return status;
}

static lmn_status time_frames(lmn_context *context, const lmn_scene *scene, struct painter *painter,
                              const struct bench_options *o, const struct model_render_options *r,
                              double *times, struct error *err)
{
    for (uint32_t i = 0; i <= o->runs; i++) {
        struct image image = {0};
        double seconds = 0.0;
        lmn_status status = choose_values(context, scene, o, i, err);
        if (status == LMN_OK)
            status = painter_render(painter, scene->cache->u, r, &image, &seconds, NULL, NULL, err);
        image_release(&image);
        if (status != LMN_OK) return status;
        if (i > 0) times[i - 1] = seconds;
    }
    return LMN_OK;
}

static lmn_status bench_frame_of(lmn_context *context, const struct bench_options *o,
                                 const char *path, double *times, struct json *j, struct error *err)
{
    lmn_status status = LMN_OK;
    lmn_scene *scene = NULL;
    struct workplace place;
    struct generator *generator = NULL;
    struct painter painter = {0};
    struct nn_bench_result network;
    struct model_render_options r = {.buffer_spp = o->spp ? o->spp : 1};
    const uint32_t size[2] = {o->size[0] ? o->size[0] : 900, o->size[1] ? o->size[1] : 900};
    TRY(lmn_scene_load(context, path, NULL, &scene));
    TRY(scene_workplace(context, scene, &place, err));
    TRY(scene_window(scene, size, (uint32_t[4]){0}, &r.window, err));
    const struct generator_config config = config_of(o, scene->scene->n_variables);
    TRY(generator_new(&config, context->pool, context->cpu, &generator, err));
    generator_init(generator, 1);
    const struct painter_network shown = {.generator = generator};
    TRY(painter_init(&painter, &place, &shown, err));
    TRY(time_frames(context, scene, &painter, o, &r, times, err));
    const double frame_s = bench_median(times, o->runs);
    TRY(time_buffers(context, scene, o, &r, times, err));
    const double buffers_s = bench_median(times, o->runs);
    TRY(nn_bench_render(&config, context->pool, context->cpu, (size_t)size[0] * size[1], o->runs,
                        &network, err));
    json_begin_object(j, NULL);
    json_put_string(j, "file", path);
    json_begin_array(j, "size");
    json_put_integer(j, NULL, size[0]);
    json_put_integer(j, NULL, size[1]);
    json_end(j);
    json_put_integer(j, "width", o->width);
    json_put_integer(j, "depth", o->depth);
    json_put_integer(j, "variables", scene->scene->n_variables);
    json_put_integer(j, "buffer_spp", r.buffer_spp);
    json_put_number(j, "frame_s", frame_s);
    json_put_number(j, "buffers_s", buffers_s);
    json_put_number(j, "network_s", network.seconds);
    json_put_number(j, "network_gflops", network.gflops);
    json_end(j);
done:
    painter_release(&painter);
    generator_free(generator);
    lmn_scene_free(scene);
    return status;
}

lmn_status bench_frame(lmn_context *context, const struct bench_options *o, struct json *j,
                       struct error *err)
{
    lmn_status status = LMN_OK;
    double *times = mem_new(o->runs, sizeof *times);
    if (!times) return fail_memory(err, "the times");
    json_begin_array(j, "results");
    for (uint32_t i = 0; i < o->n_files && status == LMN_OK; i++) {
        status = bench_frame_of(context, o, o->files[i], times, j, err);
        if (status == LMN_OK) status = bench_progress(context, i + 1, o->n_files, err);
    }
    json_end(j);
    mem_free(times);
    return status;
}
