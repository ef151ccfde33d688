/* SPDX-License-Identifier: Apache-2.0 */
#include "train/evaluate.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/mem.h"
#include "base/rng.h"
#include "base/str.h"
#include "image/draw.h"
#include "image/metrics.h"
#include "scene/assign.h"
#include "train/inputs.h"

enum {
    DEFAULT_N = 16,
    DEFAULT_RESOLUTION = 128,
    DEFAULT_SPP = 1024,
    MAX_N = 4096,
    MAX_SIDE = 4096
};
enum { STREAM_REFERENCE = 0x72656665 };

/* ---- The set ------------------------------------------------------------------------------- */

lmn_status test_set_init(struct test_set *set, const struct scene *s,
                         const lmn_eval_options *options, const struct trace_settings *trace,
                         struct error *err)
{
    *set = (struct test_set){.options = *options, .trace = *trace};
    lmn_eval_options *o = &set->options;
    if (o->n == 0) o->n = DEFAULT_N;
    if (o->resolution == 0) o->resolution = DEFAULT_RESOLUTION;
    if (o->spp == 0) o->spp = DEFAULT_SPP;
    if (o->n > MAX_N || o->resolution > MAX_SIDE)
        return fail(err, LMN_ERR_ARGUMENT,
                    "a test set of %u pictures with %u pixels a side is above the limit of %d with "
                    "%d",
                    o->n, o->resolution, (int)MAX_N, (int)MAX_SIDE);
    set->trace.spp = o->spp;
    inputs_picture_size(s, o->resolution, 1, &set->width, &set->height);
    set->u = mem_new((size_t)o->n * s->n_variables, sizeof *set->u);
    set->references = mem_new(o->n, sizeof *set->references);
    set->trace_s = mem_new(o->n, sizeof *set->trace_s);
    if (!set->u || !set->references || !set->trace_s) {
        test_set_release(set);
        return fail_memory(err, "the test set");
    }
    for (uint32_t i = 0; i < o->n; i++)
        scene_random_units(s, o->seed, i, set->u + (size_t)i * s->n_variables);
    return LMN_OK;
}

void test_set_release(struct test_set *set)
{
    for (uint32_t i = 0; set->references && i < set->options.n; i++)
        image_release(&set->references[i]);
    mem_free(set->references);
    mem_free(set->u);
    mem_free(set->trace_s);
    *set = (struct test_set){0};
}

/* ---- Means --------------------------------------------------------------------------------- */

/* struct lmn_metrics as the row of doubles that it is. */
enum { N_METRICS = sizeof(lmn_metrics) / sizeof(double) };

static void add_metrics(lmn_metrics *sum, const lmn_metrics *m, double weight)
{
    double a[N_METRICS], b[N_METRICS];
    memcpy(a, sum, sizeof a);
    memcpy(b, m, sizeof b);
    for (int i = 0; i < N_METRICS; i++) a[i] += weight * b[i];
    memcpy(sum, a, sizeof a);
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts `values`. */
static double median(double *values, uint32_t n)
{
    qsort(values, n, sizeof *values, compare_doubles);
    return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

/* ---- References ---------------------------------------------------------------------------- */

struct sub_progress {
    lmn_progress_fn *progress;
    void *user;
    uint32_t done, n;
};

static int forward_progress(void *user, double done, double total)
{
    const struct sub_progress *p = user;
    if (!p->progress) return 0;
    return p->progress(p->user, p->done + (total > 0 ? done / total : 0), p->n);
}

static lmn_status trace_reference(struct test_set *set, uint32_t index,
                                  const struct workplace *place, struct view *view,
                                  struct sub_progress *p, struct error *err)
{
    lmn_status status = LMN_OK;
    struct image mean = {0}, half_a = {0}, half_b = {0};
    lmn_metrics noise;
    struct window w = {.full_width = set->width,
                       .full_height = set->height,
                       .width = set->width,
                       .height = set->height};
    TRY(image_init(&mean, w.width, w.height, 3, NULL, err));
    TRY(image_init(&half_a, w.width, w.height, 3, NULL, err));
    TRY(image_init(&half_b, w.width, w.height, 3, NULL, err));
    struct trace_settings settings = set->trace;
    settings.seed = rng_keyed(set->options.seed ^ STREAM_REFERENCE, index, 0).state;
    struct trace_output output = {.color = mean.data, .half_a = half_a.data, .half_b = half_b.data};

    double start = clock_wall_s();
    view_set(view, set->u + (size_t)index * place->scene->n_variables);
    TRY((set->has_photons ? view_trace_photons : view_trace_parallel)(
        view, place->pool, &settings, &w, &output, forward_progress, p, err));
    set->trace_s[index] = clock_wall_s() - start;
    TRY(metrics_compare(&half_a, &mean, &noise, NULL, err));
    add_metrics(&set->noise, &noise, 1.0 / set->options.n);
    set->references[index] = mean;
    mean = (struct image){0};
done:
    image_release(&mean);
    image_release(&half_a);
    image_release(&half_b);
    return status;
}

lmn_status test_set_trace(struct test_set *set, const struct workplace *place,
                          lmn_progress_fn *progress, void *progress_user, struct error *err)
{
    lmn_status status = LMN_OK;
    struct view *view = NULL;
    struct sub_progress p = {progress, progress_user, set->n_traced, set->options.n};
    if (set->n_traced == set->options.n) return LMN_OK;
    TRY(view_new(place->world, &view, err));
    while (set->n_traced < set->options.n) {
        p.done = set->n_traced;
        TRY(trace_reference(set, set->n_traced, place, view, &p, err));
        set->n_traced++;
    }
done:
    view_free(view);
    return status;
}

/* ---- The network against them -------------------------------------------------------------- */

/* "MAPE 0.050  relMSE 0.012  FLIP 0.070", then a line "door 12.5  ..."; NULL when memory is short.
 */
static char *caption(const struct scene *s, const lmn_metrics *m, const float *u)
{
    struct str text = {0};
    str_add(&text, "MAPE %.4f  relMSE %.4f  FLIP %.4f", m->mape, m->relmse, m->flip);
    for (uint32_t i = 0; i < s->n_variables; i++) {
        const struct variable *v = &s->variables[i];
        double value = variable_from_unit(v, u[i]);
        const char *gap = i == 0 ? "\n" : "  ";
        if (v->n_choices > 0 && v->choices && value >= 0 && value < v->n_choices)
            str_add(&text, "%s%s %s", gap, v->name, v->choices[(uint32_t)value]);
        else
            str_add(&text, "%s%s %.3g", gap, v->name, value);
    }
    return text.failed ? NULL : text.text;
}

/* What a sheet needs to be drawn at the end; owned. */
struct sheet_parts {
    struct image *neural, *error;
    struct draw_sheet_row *rows;
    const struct image *(*columns)[3]; /* of rows */
    char **captions;
    uint32_t n;
};

static lmn_status sheet_parts_init(struct sheet_parts *s, uint32_t n, struct error *err)
{
    *s = (struct sheet_parts){.n = n};
    s->neural = mem_new(n, sizeof *s->neural);
    s->error = mem_new(n, sizeof *s->error);
    s->rows = mem_new(n, sizeof *s->rows);
    s->columns = mem_new(n, sizeof *s->columns);
    s->captions = mem_new(n, sizeof *s->captions);
    if (s->neural && s->error && s->rows && s->columns && s->captions) return LMN_OK;
    return fail_memory(err, "the contact sheet");
}

static void sheet_parts_release(struct sheet_parts *s)
{
    for (uint32_t i = 0; i < s->n; i++) {
        if (s->neural) image_release(&s->neural[i]);
        if (s->error) image_release(&s->error[i]);
        if (s->captions) mem_free(s->captions[i]);
    }
    mem_free(s->neural);
    mem_free(s->error);
    mem_free(s->rows);
    mem_free(s->columns);
    mem_free(s->captions);
}

lmn_status test_set_evaluate(const struct test_set *set, struct painter *painter,
                             lmn_eval_result *out, lmn_metrics *each, struct image *sheet,
                             struct error *err)
{
    static const char *const headings[3] = {"neural", "path traced", "FLIP"};
    lmn_status status = LMN_OK;
    const struct scene *s = painter->place->scene;
    uint32_t n = set->n_traced;
    struct sheet_parts parts = {0};
    struct image frame = {0}, map = {0};
    double *times = mem_new(2 * (size_t)n, sizeof *times);
    struct model_render_options render = {.window = {.full_width = set->width,
                                                     .full_height = set->height,
                                                     .width = set->width,
                                                     .height = set->height},
                                          .seed = set->options.seed};
    lmn_eval_result result = {.noise = set->noise};
    if (!times) {
        status = fail_memory(err, "the evaluation");
        goto done;
    }
    if (sheet) TRY(sheet_parts_init(&parts, n, err));
    for (uint32_t i = 0; i < n; i++) {
        const float *u = set->u + (size_t)i * s->n_variables;
        lmn_metrics m;
        TRY(painter_render(painter, u, &render, &frame, &times[i], NULL, NULL, err));
        TRY(metrics_compare(&frame, &set->references[i], &m, sheet ? &map : NULL, err));
        add_metrics(&result.mean, &m, 1.0 / n);
        if (each) each[i] = m;
        if (sheet) {
            parts.neural[i] = frame;
            parts.error[i] = map;
            frame = map = (struct image){0};
            parts.captions[i] = caption(s, &m, u);
            parts.columns[i][0] = &parts.neural[i];
            parts.columns[i][1] = &set->references[i];
            parts.columns[i][2] = &parts.error[i];
            parts.rows[i] = (struct draw_sheet_row){
                .images = parts.columns[i], .exposure = m.exposure, .caption = parts.captions[i]};
            if (!parts.captions[i]) {
                status = fail_memory(err, "the contact sheet");
                goto done;
            }
        }
        image_release(&frame);
    }
    const struct draw_sheet contact = {
        .rows = parts.rows, .n_rows = n, .n_columns = 3, .n_pictures = 2, .headings = headings};
    if (sheet) TRY(draw_sheet(&contact, sheet, err));
    memcpy(times + n, set->trace_s, n * sizeof *times);
    result.frame_s = median(times, n);
    result.trace_s = median(times + n, n);
    *out = result;
done:
    image_release(&frame);
    image_release(&map);
    sheet_parts_release(&parts);
    mem_free(times);
    return status;
}
