/* SPDX-License-Identifier: Apache-2.0 */
/* Public measurements: options, and the path tracer's figures. */
#include "api/bench_private.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "base/mem.h"
#include "base/rng.h"
#include "render/view.h"

static int compare_times(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double bench_median(double *times, uint32_t n)
{
    qsort(times, n, sizeof *times, compare_times);
    return n % 2 ? times[n / 2] : 0.5 * (times[n / 2 - 1] + times[n / 2]);
}

void bench_configuration(const struct scene *s, uint64_t index, float *u)
{
    struct rng r = rng_keyed(0x62656E6368u, index, 0);
    for (uint32_t i = 0; i < s->n_variables; i++) u[i] = rng_float(&r);
}

lmn_status bench_progress(lmn_context *context, double done, double total, struct error *err)
{
    if (context->progress && context->progress(context->progress_user, done, total))
        return fail(err, LMN_ERR_CANCELLED, "interrupted");
    return LMN_OK;
}

/* ---- Path tracing ------------------------------------------------------------------------- */

/* Seconds from setting a configuration to being ready to trace: what changing a variable costs. */
static lmn_status time_changes(const lmn_scene *scene, double *out, struct error *err)
{
    enum { N = 64 };
    double times[N];
    struct scene_cache *c = scene->cache;
    const lmn_status status = scene_view(scene, err);
    if (status != LMN_OK) return status;
    for (uint32_t i = 0; i < N; i++) {
        bench_configuration(scene->scene, i, c->u);
        const double start_s = clock_wall_s();
        view_set(c->view, c->u);
        times[i] = clock_wall_s() - start_s;
    }
    *out = bench_median(times, N);
    return LMN_OK;
}

static lmn_status time_pictures(lmn_context *context, const lmn_scene *scene,
                                const lmn_trace_options *t, uint32_t runs, double *times,
                                double done, double total, struct error *err)
{
    lmn_status status = LMN_OK;
    lmn_progress_fn *progress = context->progress;
    context->progress = NULL; /* a picture is a part of ours */
    for (uint32_t i = 0; i <= runs && status == LMN_OK; i++) {
        lmn_image *image = NULL;
        double render_s = 0.0;
        lmn_trace_options one = *t;
        one.seed = i;
        status = lmn_scene_trace(context, scene, NULL, &one, &image, &render_s);
        lmn_image_free(image);
        if (i > 0) times[i - 1] = render_s; /* the first one warms up */
        context->progress = progress;
        if (status == LMN_OK) status = bench_progress(context, done + i + 1, total, err);
        context->progress = NULL;
    }
    context->progress = progress;
    return status;
}

/* The share of time that finding what rays meet takes, in a picture of its own. */
static lmn_status time_rays(lmn_context *context, const lmn_scene *scene,
                            const lmn_trace_options *o, double *share, struct error *err)
{
    const struct window w = {o->width, o->height, 0, 0, o->width, o->height};
    struct trace_clock clock = {0};
    struct trace_output out = {.clock = &clock};
    struct trace_settings t;
    trace_settings_init(&t, scene->scene);
    t.splats = true;
    t.sampler = SAMPLER_SOBOL;
    t.spp = o->spp;
    if (o->has_max_depth) t.max_depth = o->max_depth;
    if (o->has_rr_depth) t.rr_depth = o->rr_depth;
    out.color = mem_new((size_t)o->width * o->height, 3 * sizeof *out.color);
    if (!out.color) return fail_memory(err, "the picture");
    lmn_status status = view_trace_parallel(scene->cache->view, context->pool, &t, &w, &out, NULL,
                                            NULL, err);
    mem_free(out.color);
    *share = clock.all ? (double)clock.rays / (double)clock.all : 0.0;
    return status;
}

static lmn_status bench_scene(lmn_context *context, const struct bench_options *o, uint32_t index,
                              double *times, struct json *j, struct error *err)
{
    lmn_status status = LMN_OK;
    lmn_scene *scene = NULL;
    lmn_scene_info info;
    double change_s = 0.0, ray_share = 0.0;
    const double start_s = clock_wall_s();
    TRY(lmn_scene_load(context, o->files[index], NULL, &scene));
    const double load_s = clock_wall_s() - start_s;
    TRY(scene_view(scene, err));
    const double build_s = clock_wall_s() - start_s - load_s;
    TRY(time_changes(scene, &change_s, err));
    lmn_scene_get_info(scene, &info);
    const lmn_trace_options t = {.struct_size = sizeof t,
                                 .width = o->size[0] ? o->size[0] : 256,
                                 .height = o->size[1] ? o->size[1] : 256,
                                 .spp = o->spp ? o->spp : 32,
                                 .has_max_depth = o->max_depth != SCENE_NONE,
                                 .has_rr_depth = o->rr_depth != SCENE_NONE,
                                 .max_depth = o->max_depth,
                                 .rr_depth = o->rr_depth,
                                 .integrator = "path"};
    TRY(time_pictures(context, scene, &t, o->runs, times, index * (o->runs + 1.0),
                      o->n_files * (o->runs + 1.0), err));
    TRY(time_rays(context, scene, &t, &ray_share, err));
    const double render_s = bench_median(times, o->runs);
    json_begin_object(j, NULL);
    json_put_string(j, "file", o->files[index]);
    json_begin_array(j, "size");
    json_put_integer(j, NULL, t.width);
    json_put_integer(j, NULL, t.height);
    json_end(j);
    json_put_integer(j, "spp", t.spp);
    json_put_integer(j, "max_depth", t.has_max_depth ? t.max_depth : info.max_depth);
    json_put_integer(j, "rr_depth", t.has_rr_depth ? t.rr_depth : info.rr_depth);
    json_put_integer(j, "triangles", (int64_t)info.n_triangles);
    json_put_number(j, "load_s", load_s);
    json_put_number(j, "build_s", build_s);
    json_put_number(j, "change_s", change_s);
    json_put_number(j, "render_s", render_s);
    json_put_number(j, "render_min_s", times[0]);
    json_put_number(j, "render_max_s", times[o->runs - 1]);
    json_put_number(j, "paths_per_s", (double)t.width * t.height * t.spp / render_s);
    json_put_number(j, "ray_share", ray_share);
    json_end(j);
done:
    lmn_scene_free(scene);
    return status;
}

lmn_status bench_trace(lmn_context *context, const struct bench_options *o, struct json *j,
                       struct error *err)
{
    lmn_status status = LMN_OK;
    double *times = mem_new(o->runs, sizeof *times);
    if (!times) return fail_memory(err, "the times");
    json_begin_array(j, "results");
    for (uint32_t i = 0; i < o->n_files && status == LMN_OK; i++)
        status = bench_scene(context, o, i, times, j, err);
    json_end(j);
    mem_free(times);
    return status;
}

/* ---- Options ------------------------------------------------------------------------------ */

static lmn_status read_count(const json_t *root, const char *key, uint32_t max, uint32_t *out,
                             struct error *err)
{
    const json_t *v = json_object_get(root, key);
    if (!v) return LMN_OK;
    if (!json_is_integer(v) || json_integer_value(v) < 0 || json_integer_value(v) > max)
        return fail(err, LMN_ERR_ARGUMENT, "bench: %s: not a whole number up to %u", key, max);
    *out = (uint32_t)json_integer_value(v);
    return LMN_OK;
}

static lmn_status read_depth(const json_t *root, const char *key, int32_t *out, struct error *err)
{
    const json_t *v = json_object_get(root, key);
    *out = SCENE_NONE;
    if (!v) return LMN_OK;
    if (!json_is_integer(v) || json_integer_value(v) < -1 || json_integer_value(v) > 1 << 20)
        return fail(err, LMN_ERR_ARGUMENT, "bench: %s: not a path length", key);
    *out = (int32_t)json_integer_value(v);
    return LMN_OK;
}

static lmn_status read_method(const json_t *root, bool *is_faithful, struct error *err)
{
    const json_t *v = json_object_get(root, "method");
    const char *name = v ? json_string_value(v) : "improved";
    *is_faithful = name && strcmp(name, "faithful") == 0;
    if (!*is_faithful && (!name || strcmp(name, "improved") != 0))
        return fail(err, LMN_ERR_ARGUMENT, "bench: method: neither improved nor faithful");
    return LMN_OK;
}

/* An array of texts. They stay those of `root`; *out is the caller's to free. */
static lmn_status read_texts(const json_t *root, const char *key, const char ***out, uint32_t *n,
                             struct error *err)
{
    const json_t *list = json_object_get(root, key);
    *n = (uint32_t)json_array_size(list);
    *out = mem_new((size_t)*n + 1, sizeof **out);
    if (!*out) return fail_memory(err, "the options");
    for (uint32_t i = 0; i < *n; i++) {
        (*out)[i] = json_string_value(json_array_get(list, i));
        if (!(*out)[i])
            return fail(err, LMN_ERR_ARGUMENT, "bench: %s: element %u is no text", key, i);
    }
    return LMN_OK;
}

static lmn_status read_options(const json_t *root, struct bench_options *o, const char ***files,
                               const char ***sets, struct error *err)
{
    lmn_status status = LMN_OK;
    const json_t *size = json_object_get(root, "size");
    *o = (struct bench_options){.runs = 5, .depth = BENCH_ANY, .patches = 32};
    TRY(read_count(root, "runs", 100000, &o->runs, err));
    TRY(read_count(root, "width", 1024, &o->width, err));
    TRY(read_count(root, "depth", 32, &o->depth, err));
    TRY(read_count(root, "patches", 4096, &o->patches, err));
    TRY(read_count(root, "spp", 1 << 20, &o->spp, err));
    TRY(read_depth(root, "max_depth", &o->max_depth, err));
    TRY(read_depth(root, "rr_depth", &o->rr_depth, err));
    TRY(read_method(root, &o->is_faithful, err));
    if (o->runs == 0 || o->patches == 0 || (json_object_get(root, "width") && o->width == 0))
        return fail(err, LMN_ERR_ARGUMENT, "bench: runs, width and patches are at least 1");
    if (size) {
        o->size[0] = (uint32_t)json_integer_value(json_array_get(size, 0));
        o->size[1] = (uint32_t)json_integer_value(json_array_get(size, 1));
        if (o->size[0] < 1 || o->size[1] < 1 || o->size[0] > IMAGE_MAX_SIDE ||
            o->size[1] > IMAGE_MAX_SIDE)
            return fail(err, LMN_ERR_ARGUMENT, "bench: size: a side has 1 to %d pixels",
                        IMAGE_MAX_SIDE);
    }
    TRY(read_texts(root, "files", files, &o->n_files, err));
    TRY(read_texts(root, "set", sets, &o->n_sets, err));
    o->files = *files;
    o->sets = *sets;
done:
    return status;
}

lmn_status lmn_bench(lmn_context *context, const char *what, const char *options_json,
                     const char **json)
{
    static const struct {
        const char *name;
        lmn_status (*run)(lmn_context *, const struct bench_options *, struct json *,
                          struct error *);
    } kinds[] = {{"kernels", bench_kernels},
                 {"trace", bench_trace},
                 {"train", bench_train},
                 {"buffers", bench_buffers},
                 {"frame", bench_frame}};
    enum { N_KINDS = sizeof kinds / sizeof kinds[0] };
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    struct bench_options o;
    const char **files = NULL, **sets = NULL;
    json_error_t problem;
    struct json j = {.out = &context->json};
    *json = NULL;
    json_t *root = json_loads(options_json ? options_json : "{}", 0, &problem);
    if (!json_is_object(root)) {
        status = fail(err, LMN_ERR_ARGUMENT, "bench: the options are no JSON object");
        goto done;
    }
    TRY(read_options(root, &o, &files, &sets, err));
    str_release(&context->json);
    json_begin_object(&j, NULL);
    json_put_string(&j, "bench", what);
    json_put_string(&j, "cpu", cpu_name(context->cpu));
    json_put_integer(&j, "threads", pool_n_workers(context->pool));
    json_put_integer(&j, "runs", o.runs);
    size_t kind = 0;
    while (kind < N_KINDS && strcmp(kinds[kind].name, what) != 0) kind++;
    if (kind == N_KINDS)
        status = fail(err, LMN_ERR_ARGUMENT,
                      "bench \"%s\": kernels, trace, train, buffers or frame", what);
    else
        status = kinds[kind].run(context, &o, &j, err);
    if (status != LMN_OK) goto done;
    json_end(&j);
    if (context->json.failed)
        status = fail_memory(err, "the report");
    else
        *json = context->json.text;
done:
    json_decref(root);
    mem_free(files);
    mem_free(sets);
    return status;
}
