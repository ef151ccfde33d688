/* SPDX-License-Identifier: Apache-2.0 */
/* Public measurements of whole frames by the network. */
#include "api/bench_private.h"
#include "base/clock.h"
#include "base/mem.h"
#include "image/tone.h"
#include "nn/bench_nn.h"
#include "train/learner.h"
#include "train/painter.h"

/* What a frame's time is cut into, medians of all runs. */
enum part {
    PART_FRAME, /* everything, to bytes for a screen */
    PART_BUFFERS,
    PART_LOOK,    /* buffers to the network's inputs */
    PART_ENCODE,  /* grids and features to tiles */
    PART_LAYERS,  /* to colours */
    PART_NETWORK, /* both */
    PART_TONE,
    PART_CPU, /* everything: processor time over threads, which tells on a busy machine */
    N_PARTS
};

struct bench {
    lmn_context *context;
    const struct bench_options *o;
    lmn_scene *scene;
    struct workplace place;
    struct model_render_options render;
    struct tone tone;
    uint8_t *bytes; /* [height][width][3] */
    double *times;  /* [N_PARTS][runs] */
};

/* The index-th of a stream of configurations, or always the one that was asked for. */
static lmn_status choose_values(const struct bench *b, uint32_t index, struct error *err)
{
    const struct scene_cache *cache = b->scene->cache;
    if (b->o->n_sets > 0) return bench_values(b->context, b->scene, b->o, cache->u, err);
    bench_configuration(b->scene->scene, index, cache->u);
    return LMN_OK;
}

/* Where the workers' time went, in seconds of all of them together. */
static void cut(const struct painter *p, double seconds_per_tick, double *parts)
{
    uint64_t encode = 0, layers = 0, buffers = 0, look = 0, network = 0;
    for (uint32_t i = 0; i < p->n_desks; i++) {
        const struct painter_desk *d = &p->desks[i];
        buffers += d->buffer_ticks;
        look += d->look_ticks;
        network += d->network_ticks;
    }
    if (p->network.field) field_ticks(p->network.field, &encode, &layers);
    const double scale = p->n_desks > 0 ? seconds_per_tick / p->n_desks : 0.0;
    parts[PART_BUFFERS] = scale * (double)buffers;
    parts[PART_LOOK] = scale * (double)look;
    parts[PART_ENCODE] = scale * (double)encode;
    parts[PART_LAYERS] = scale * (double)layers;
    parts[PART_NETWORK] = scale * (double)network;
}

/* medians [N_PARTS] of o->runs frames, after one that does not count. */
static lmn_status time_frames(struct bench *b, struct painter *painter, double *medians,
                              struct error *err)
{
    lmn_status status = LMN_OK;
    const uint32_t runs = b->o->runs;
    for (uint32_t i = 0; i <= runs; i++) {
        struct image image = {0};
        double parts[N_PARTS] = {0}, painted_s;
        TRY(choose_values(b, i, err));
        const double start_s = clock_wall_s(), start_cpu_s = clock_cpu_s();
        const uint64_t start = clock_ticks();
        status = painter_render(painter, b->scene->cache->u, &b->render, &image, NULL, NULL, NULL,
                                err);
        painted_s = clock_wall_s() - start_s;
        const uint64_t ticks = clock_ticks() - start;
        if (status == LMN_OK)
            tone_apply(&b->tone, b->context->pool, image.data, (size_t)image.width * image.height,
                       image.n_channels, 1.0f, TONE_SRGB, b->bytes);
        parts[PART_FRAME] = clock_wall_s() - start_s;
        parts[PART_TONE] = parts[PART_FRAME] - painted_s;
        parts[PART_CPU] = (clock_cpu_s() - start_cpu_s) / pool_n_workers(b->context->pool);
        cut(painter, painted_s / (double)(ticks > 0 ? ticks : 1), parts);
        image_release(&image);
        if (status != LMN_OK) goto done;
        for (size_t k = 0; k < N_PARTS && i > 0; k++) b->times[k * runs + i - 1] = parts[k];
    }
    for (size_t k = 0; k < N_PARTS; k++) medians[k] = bench_median(b->times + k * runs, runs);
done:
    return status;
}

static void put_shape(struct json *j, const struct bench *b, const char *path, const char *method,
                      const char *kernels, uint32_t width, uint32_t depth, uint32_t n_variables)
{
    json_put_string(j, "file", path);
    json_begin_array(j, "size");
    json_put_integer(j, NULL, b->render.window.width);
    json_put_integer(j, NULL, b->render.window.height);
    json_end(j);
    json_put_string(j, "method", method);
    json_put_string(j, "kernels", kernels);
    json_put_integer(j, "width", width);
    json_put_integer(j, "depth", depth);
    json_put_integer(j, "variables", n_variables);
    json_put_integer(j, "buffer_spp", b->render.buffer_spp);
}

/* ---- The paper's network ------------------------------------------------------------------ */

static lmn_status time_buffers(struct bench *b, double *median, struct error *err)
{
    lmn_status status = LMN_OK;
    struct trace_settings t;
    struct trace_output output = {0};
    const struct scene_cache *c = b->scene->cache;
    const struct window *w = &b->render.window;
    trace_settings_init(&t, b->scene->scene);
    t.spp = b->render.buffer_spp;
    output.buffers = mem_new((size_t)w->width * w->height * BUFFER_CHANNELS, sizeof(float));
    if (!output.buffers) return fail_memory(err, "the buffers");
    TRY(scene_view(b->scene, err));
    for (uint32_t i = 0; i <= b->o->runs; i++) {
        TRY(choose_values(b, i, err));
        const double start_s = clock_wall_s();
        view_set(c->view, c->u);
        TRY(view_trace_parallel(c->view, b->context->pool, &t, w, &output, NULL, NULL, err));
        if (i > 0) b->times[i - 1] = clock_wall_s() - start_s;
    }
    *median = bench_median(b->times, b->o->runs);
done:
    mem_free(output.buffers);
    return status;
}

static lmn_status bench_faithful(struct bench *b, const char *path, struct json *j,
                                 struct error *err)
{
    lmn_status status = LMN_OK;
    struct generator *generator = NULL;
    struct painter painter = {0};
    struct nn_bench_result network;
    double medians[N_PARTS], buffers_s = 0.0;
    const struct window *w = &b->render.window;
    const struct generator_config config = {.n_variables = b->scene->scene->n_variables,
                                            .width = b->o->width ? b->o->width : BENCH_WIDTH,
                                            .depth = b->o->depth != BENCH_ANY ? b->o->depth
                                                                              : BENCH_DEPTH};
    TRY(generator_new(&config, b->context->pool, b->context->cpu, &generator, err));
    generator_init(generator, 1);
    const struct painter_network shown = {.generator = generator};
    TRY(painter_init(&painter, &b->place, &shown, err));
    TRY(time_frames(b, &painter, medians, err));
    TRY(time_buffers(b, &buffers_s, err));
    TRY(nn_bench_render(&config, b->context->pool, b->context->cpu, (size_t)w->width * w->height,
                        b->o->runs, &network, err));
    json_begin_object(j, NULL);
    put_shape(j, b, path, "faithful", nn_bench_kernels(b->context->cpu), config.width, config.depth,
              config.n_variables);
    json_put_number(j, "frame_s", medians[PART_FRAME]);
    json_put_number(j, "frame_cpu_s", medians[PART_CPU]);
    json_put_number(j, "buffers_s", buffers_s);
    json_put_number(j, "network_s", network.seconds);
    json_put_number(j, "tone_s", medians[PART_TONE]);
    json_put_number(j, "network_gflops", network.gflops);
    json_end(j);
done:
    painter_release(&painter);
    generator_free(generator);
    return status;
}

/* ---- The compact network ------------------------------------------------------------------ */

/* Frames by a fresh network: the time does not depend on the weights. n_variables 0: the scene's.
 */
static lmn_status time_field(struct bench *b, const struct sight *sight, uint32_t n_variables,
                             struct field_config *config, double *flop, double *medians,
                             struct error *err)
{
    lmn_status status = LMN_OK;
    struct field *field = NULL;
    struct painter painter = {0};
    *config = sight_field(sight);
    config->grid = learner_grid();
    config->width = b->o->width ? b->o->width : 64;
    config->depth = b->o->depth != BENCH_ANY ? b->o->depth : 3;
    if (n_variables > 0) config->n_variables = n_variables;
    TRY(field_new(config, b->context->pool, b->context->cpu, &field, err));
    field_init(field, 1);
    *flop = field_flop(field);
    const struct painter_network shown = {.field = field, .sight = sight};
    TRY(painter_init(&painter, &b->place, &shown, err));
    TRY(time_frames(b, &painter, medians, err));
done:
    painter_release(&painter);
    field_free(field);
    return status;
}

static lmn_status bench_improved(struct bench *b, const char *path, struct json *j,
                                 struct error *err)
{
    static const uint32_t counts[] = {5, 16, 64, 128};
    enum { N_COUNTS = sizeof counts / sizeof *counts };
    lmn_status status = LMN_OK;
    struct sight sight = {0};
    struct field_config config, other;
    double medians[N_PARTS], more[N_COUNTS][N_PARTS], flop;
    const struct window *w = &b->render.window;
    lmn_context *context = b->context;
    TRY(sight_init(&sight, b->scene->scene, 0, err));
    sight.cpu = context->cpu;
    double peak = nn_bench_picture_peak_gflops(context->cpu, context->pool);
    TRY(time_field(b, &sight, 0, &config, &flop, medians, err));
    /* The peak again, so that a machine whose clock or load changed meanwhile shows. */
    const double after = nn_bench_picture_peak_gflops(context->cpu, context->pool);
    if (after > peak) peak = after;
    for (uint32_t i = 0; i < N_COUNTS; i++) {
        double unused;
        /* Never fewer than the scene's, which all are set. */
        if (counts[i] >= config.n_variables)
            TRY(time_field(b, &sight, counts[i], &other, &unused, more[i], err));
    }
    const double gflop = 1e-9 * flop * w->width * w->height;
    json_begin_object(j, NULL);
    put_shape(j, b, path, "improved", nn_bench_picture_kernels(context->cpu), config.width,
              config.depth, config.n_variables);
    json_put_integer(j, "grids", config.n_grids);
    json_put_integer(j, "features", config.n_features);
    json_put_number(j, "frame_s", medians[PART_FRAME]);
    json_put_number(j, "frame_cpu_s", medians[PART_CPU]);
    json_put_number(j, "buffers_s", medians[PART_BUFFERS]);
    json_put_number(j, "look_s", medians[PART_LOOK]);
    json_put_number(j, "encode_s", medians[PART_ENCODE]);
    json_put_number(j, "layers_s", medians[PART_LAYERS]);
    json_put_number(j, "network_s", medians[PART_NETWORK]);
    json_put_number(j, "tone_s", medians[PART_TONE]);
    json_put_number(j, "network_gflops", gflop / medians[PART_NETWORK]);
    json_put_number(j, "layers_gflops", gflop / medians[PART_LAYERS]);
    json_put_number(j, "peak_gflops", peak);
    json_put_number(j, "share_of_peak", gflop / medians[PART_NETWORK] / peak);
    json_begin_array(j, "by_variables");
    for (uint32_t i = 0; i < N_COUNTS; i++) {
        if (counts[i] < config.n_variables) continue;
        json_begin_object(j, NULL);
        json_put_integer(j, "variables", counts[i]);
        json_put_number(j, "frame_s", more[i][PART_FRAME]);
        json_put_number(j, "network_s", more[i][PART_NETWORK]);
        json_end(j);
    }
    json_end(j);
    json_end(j);
done:
    sight_release(&sight);
    return status;
}

static lmn_status bench_file(lmn_context *context, const struct bench_options *o, const char *path,
                             struct json *j, struct error *err)
{
    lmn_status status = LMN_OK;
    struct bench b = {.context = context, .o = o, .render = {.buffer_spp = o->spp ? o->spp : 1}};
    const uint32_t size[2] = {o->size[0] ? o->size[0] : 900, o->size[1] ? o->size[1] : 900};
    TRY(lmn_scene_load(context, path, NULL, &b.scene));
    TRY(scene_workplace(context, b.scene, &b.place, err));
    TRY(scene_window(b.scene, size, (uint32_t[4]){0}, &b.render.window, err));
    tone_init(&b.tone);
    b.bytes = mem_new((size_t)size[0] * size[1], 3);
    b.times = mem_new((size_t)o->runs * N_PARTS, sizeof *b.times);
    if (!b.bytes || !b.times) {
        status = fail_memory(err, "the times");
        goto done;
    }
    if (o->is_faithful)
        TRY(bench_faithful(&b, path, j, err));
    else
        TRY(bench_improved(&b, path, j, err));
done:
    mem_free(b.bytes);
    mem_free(b.times);
    lmn_scene_free(b.scene);
    return status;
}

lmn_status bench_frame(lmn_context *context, const struct bench_options *o, struct json *j,
                       struct error *err)
{
    lmn_status status = LMN_OK;
    json_begin_array(j, "results");
    for (uint32_t i = 0; i < o->n_files && status == LMN_OK; i++) {
        status = bench_file(context, o, o->files[i], j, err);
        if (status == LMN_OK) status = bench_progress(context, i + 1, o->n_files, err);
    }
    json_end(j);
    return status;
}
