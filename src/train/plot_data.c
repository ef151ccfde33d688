/* SPDX-License-Identifier: Apache-2.0 */
#include "train/plot_data.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <jansson.h>

#include "base/file.h"
#include "base/mem.h"
#include "train/checkpoint.h"

static const size_t max_file_size = (size_t)1 << 30;
enum { MAX_NAMES = 4096 };

/* ---- Series ------------------------------------------------------------------------------- */

bool series_add(struct series *s, double x, double y)
{
    void *xs = s->x, *ys = s->y;
    bool ok = mem_grow(&xs, &s->x_capacity, s->n + 1, sizeof *s->x) &&
              mem_grow(&ys, &s->y_capacity, s->n + 1, sizeof *s->y);
    s->x = xs;
    s->y = ys;
    if (!ok) return false;
    s->x[s->n] = x;
    s->y[s->n++] = y;
    return true;
}

void series_release(struct series *s)
{
    mem_free(s->x);
    mem_free(s->y);
    *s = (struct series){0};
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

lmn_status series_thin(const struct series *s, size_t n_bins, struct series *out, struct error *err)
{
    *out = (struct series){0};
    double *sorted = mem_new(s->n, sizeof *sorted);
    if (!sorted) return fail_memory(err, "a plot");
    bool ok = true;
    double low = s->n ? s->x[0] : 0, range = s->n ? s->x[s->n - 1] - low : 0;
    for (size_t i = 0, j; i < s->n && ok; i = j) {
        j = i + 1;
        if (s->n > n_bins) {
            double bin = floor((s->x[i] - low) / range * (double)n_bins);
            /* the last point of all falls on the end of the last bin */
            while (j < s->n && floor((s->x[j] - low) / range * (double)n_bins) <= bin) j++;
            if (bin + 1 >= (double)n_bins || !(range > 0)) j = s->n;
        }
        memcpy(sorted, s->y + i, (j - i) * sizeof *sorted);
        qsort(sorted, j - i, sizeof *sorted, compare_doubles);
        ok = series_add(out, s->x[i + (j - i) / 2], sorted[(j - i) / 2]);
    }
    mem_free(sorted);
    if (ok) return LMN_OK;
    series_release(out);
    return fail_memory(err, "a plot");
}

/* ---- Reading ------------------------------------------------------------------------------ */

/* Where in the file we are, for messages. */
struct place {
    const char *path;
    size_t line;
};

/* A number of the object, NAN when it is missing or null. */
static lmn_status get_number(const json_t *object, const char *key, const struct place *at,
                             double *out, struct error *err)
{
    const json_t *v = json_object_get(object, key);
    *out = NAN;
    if (!v || json_is_null(v)) return LMN_OK;
    if (!json_is_number(v))
        return fail(err, LMN_ERR_PARSE, "%s:%zu: \"%s\" is not a number", at->path, at->line, key);
    *out = json_number_value(v);
    return LMN_OK;
}

static lmn_status add_point(struct series *s, double x, double y, struct error *err)
{
    if (!isfinite(y) || series_add(s, x, y)) return LMN_OK;
    return fail_memory(err, "the curves of a run");
}

/* {"run": {"variables": [...], "scene": "..."}}: at the start, and again where it was resumed. */
static lmn_status read_run(const json_t *run, const struct place *at, struct plot_run *out,
                           struct error *err)
{
    const json_t *names = json_object_get(run, "variables");
    const json_t *scene = json_object_get(run, "scene");
    if (!json_is_object(run) || !json_is_array(names) || json_array_size(names) > MAX_NAMES)
        return fail(err, LMN_ERR_PARSE,
                    "%s:%zu: \"run\" has no array \"variables\" of up to %d names", at->path,
                    at->line, MAX_NAMES);
    size_t n = json_array_size(names);
    for (size_t i = 0; i < n; i++)
        if (!json_is_string(json_array_get(names, i)))
            return fail(err, LMN_ERR_PARSE, "%s:%zu: variable %zu has no name", at->path, at->line,
                        i);
    if (out->names && n != out->n_names)
        return fail(err, LMN_ERR_PARSE, "%s:%zu: the run had %zu variables so far and has %zu now",
                    at->path, at->line, out->n_names, n);
    if (out->names) return LMN_OK;
    out->names = mem_new(n, sizeof *out->names);
    out->chains = mem_new(n, sizeof *out->chains);
    bool ok = out->names && out->chains;
    for (; ok && out->n_names < n; out->n_names++) {
        char *name = mem_strdup(json_string_value(json_array_get(names, out->n_names)));
        if (!name) break;
        out->names[out->n_names] = name;
    }
    if (json_is_string(scene)) {
        out->title = mem_strdup(json_string_value(scene));
        ok = ok && out->title;
    }
    return ok && out->n_names == n ? LMN_OK : fail_memory(err, "the names of variables");
}

static lmn_status read_chains(const json_t *chains, double step, const struct place *at,
                              struct plot_run *out, struct error *err)
{
    size_t i;
    const json_t *chain;
    if (!chains || json_is_null(chains)) return LMN_OK;
    if (!json_is_array(chains))
        return fail(err, LMN_ERR_PARSE, "%s:%zu: \"chains\" is not an array", at->path, at->line);
    json_array_foreach(chains, i, chain)
    {
        if (!json_is_array(chain) || json_array_size(chain) != out->n_names)
            return fail(err, LMN_ERR_PARSE, "%s:%zu: chain %zu is not an array of %zu numbers",
                        at->path, at->line, i, out->n_names);
        for (size_t d = 0; d < out->n_names; d++) {
            const json_t *u = json_array_get(chain, d);
            double value = json_number_value(u);
            if (!json_is_number(u) || value < 0 || value > 1)
                return fail(err, LMN_ERR_PARSE, "%s:%zu: \"%s\" of chain %zu is not in [0,1]",
                            at->path, at->line, out->names[d], i);
            lmn_status status = add_point(&out->chains[d], step, value, err);
            if (status != LMN_OK) return status;
        }
    }
    return LMN_OK;
}

/* Forgets what came at `step` or later: a resumed run makes those steps again. */
static void rewind_to(struct plot_run *run, double step)
{
    for (int c = 0; c < PLOT_N_CURVES; c++)
        while (run->curves[c].n && run->curves[c].x[run->curves[c].n - 1] >= step)
            run->curves[c].n--;
    for (size_t d = 0; d < run->n_names; d++)
        while (run->chains[d].n && run->chains[d].x[run->chains[d].n - 1] >= step)
            run->chains[d].n--;
}

static lmn_status read_step(const json_t *line, const struct place *at, struct plot_run *out,
                            struct error *err)
{
    static const struct {
        const char *key;
        enum plot_curve curve;
    } numbers[] = {{"loss_fresh", PLOT_LOSS_FRESH},
                   {"loss_replayed", PLOT_LOSS_REPLAYED},
                   {"acceptance", PLOT_ACCEPTANCE},
                   {"reuse_probability", PLOT_REUSE},
                   {"cpu_s", PLOT_SECONDS}},
      errors[] = {
          {"mape", PLOT_MAPE}, {"relmse", PLOT_RELMSE}, {"flip", PLOT_FLIP}, {"dssim", PLOT_DSSIM}};
    lmn_status status;
    double step, value;
    TRY(get_number(line, "step", at, &step, err));
    if (!isfinite(step) || step < 0 || step > 1e15) {
        status = fail(err, LMN_ERR_PARSE, "%s:%zu: line has no \"step\"", at->path, at->line);
        goto done;
    }
    if (out->first_step < 0) out->first_step = step;
    if (step <= out->last_step) rewind_to(out, step);
    if (step < out->first_step) out->first_step = step;
    out->last_step = step;

    const json_t *fresh = json_object_get(line, "fresh");
    TRY(get_number(line, "loss", at, &value, err));
    TRY(add_point(
        &out->curves[json_is_false(fresh) ? PLOT_LOSS_REPLAYED_BATCH : PLOT_LOSS_FRESH_BATCH], step,
        value, err));
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        TRY(get_number(line, numbers[i].key, at, &value, err));
        TRY(add_point(&out->curves[numbers[i].curve], step, value, err));
    }
    const json_t *eval = json_object_get(line, "eval");
    for (size_t i = 0; eval && i < sizeof errors / sizeof *errors; i++) {
        TRY(get_number(eval, errors[i].key, at, &value, err));
        TRY(add_point(&out->curves[errors[i].curve], step, value, err));
    }
    TRY(read_chains(json_object_get(line, "chains"), step, at, out, err));
done:
    return status;
}

static lmn_status read_metrics(const char *path, struct plot_run *out, struct error *err)
{
    lmn_status status = LMN_OK;
    char *text = NULL;
    size_t size = 0;
    json_t *line = NULL;
    TRY(file_read(path, max_file_size, &text, &size, err));
    struct place at = {path, 0};
    for (char *start = text, *end; start < text + size; start = end + 1) {
        at.line++;
        end = memchr(start, '\n', (size_t)(text + size - start));
        bool is_cut_off = !end;
        if (!end) end = text + size;
        if (strspn(start, " \t\r") >= (size_t)(end - start)) continue;
        json_error_t why;
        line = json_loadb(start, (size_t)(end - start), JSON_REJECT_DUPLICATES, &why);
        if (!line && is_cut_off && at.line > 1) break;
        if (!json_is_object(line)) {
            status = fail(err, LMN_ERR_PARSE, "%s:%zu:%d: %s", path, at.line, line ? 1 : why.column,
                          line ? "not an object" : why.text);
            goto done;
        }
        const json_t *run = json_object_get(line, "run");
        TRY(run ? read_run(run, &at, out, err) : read_step(line, &at, out, err));
        json_decref(line);
        line = NULL;
    }
    if (out->last_step < 0)
        status = fail(err, LMN_ERR_PARSE, "%s: no training steps in this file", path);
done:
    json_decref(line);
    mem_free(text);
    return status;
}

/* ---- Models ------------------------------------------------------------------------------- */

static lmn_status copy_history(const struct history *h, struct plot_run *out, struct error *err)
{
    static const struct {
        enum history_column column;
        enum plot_curve curve;
    } columns[] = {{HISTORY_LOSS, PLOT_LOSS_ALL},
                   {HISTORY_LOSS_FRESH, PLOT_LOSS_FRESH},
                   {HISTORY_LOSS_REPLAYED, PLOT_LOSS_REPLAYED},
                   {HISTORY_REUSE_PROBABILITY, PLOT_REUSE},
                   {HISTORY_ACCEPTANCE, PLOT_ACCEPTANCE}};
    lmn_status status = LMN_OK;
    for (uint32_t r = 0; r < h->n_rows; r++) {
        const double *row = h->rows[r];
        if (out->first_step < 0) out->first_step = row[HISTORY_STEP];
        out->last_step = fmax(out->last_step, row[HISTORY_STEP]);
        for (size_t i = 0; i < sizeof columns / sizeof *columns; i++)
            TRY(add_point(&out->curves[columns[i].curve], row[HISTORY_STEP], row[columns[i].column],
                          err));
    }
    for (uint32_t k = 0; k < h->n_snapshots; k++) {
        double step = h->snapshot_steps[k];
        if (out->first_step < 0) out->first_step = step;
        out->last_step = fmax(out->last_step, step);
        const float *u = h->snapshots + (size_t)k * h->n_chains * h->dim;
        for (uint32_t i = 0; i < h->n_chains * h->dim; i++)
            TRY(add_point(&out->chains[i % h->dim], step, (double)u[i], err));
    }
done:
    return status;
}

lmn_status plot_run_from_history(const struct history *h, char *const *names, const char *title,
                                 struct plot_run *out, struct error *err)
{
    *out = (struct plot_run){.first_step = -1, .last_step = -1};
    out->names = mem_new(h->dim, sizeof *out->names);
    out->chains = mem_new(h->dim, sizeof *out->chains);
    out->title = mem_strdup(title);
    if (!out->names || !out->chains || !out->title) return fail_memory(err, "a plot");
    for (; out->n_names < h->dim; out->n_names++) {
        char *name = mem_strdup(names[out->n_names]);
        if (!name) return fail_memory(err, "a plot");
        out->names[out->n_names] = name;
    }
    lmn_status status = copy_history(h, out, err);
    if (status == LMN_OK && out->last_step < 0)
        status = fail(err, LMN_ERR_PARSE, "%s: no training steps in this model", title);
    return status;
}

static lmn_status read_history(const char *path, struct plot_run *out, struct error *err)
{
    struct history h = {0};
    char **names = NULL;
    lmn_status status = checkpoint_read_history(path, &h, &names, err);
    if (status == LMN_OK) status = plot_run_from_history(&h, names, path, out, err);
    mem_free(names);
    history_release(&h);
    return status;
}

/* safetensors: eight bytes of length, then a JSON object. Metrics start with the object itself. */
static bool is_model(const char *path)
{
    char head[9] = {0};
    FILE *f = fopen(path, "rb");
    if (!f) return false;
    size_t n = fread(head, 1, sizeof head, f);
    fclose(f);
    return n == sizeof head && head[0] != '{' && head[7] == 0 && head[8] == '{';
}

lmn_status plot_run_read(const char *path, struct plot_run *out, struct error *err)
{
    *out = (struct plot_run){.first_step = -1, .last_step = -1};
    if (!is_model(path)) return read_metrics(path, out, err);
    char *beside = metrics_path(path);
    if (!beside) return fail_memory(err, path);
    lmn_status status = access(beside, F_OK) == 0 ? read_metrics(beside, out, err)
                                                  : read_history(path, out, err);
    mem_free(beside);
    return status;
}

void plot_run_release(struct plot_run *run)
{
    for (int c = 0; c < PLOT_N_CURVES; c++) series_release(&run->curves[c]);
    for (size_t d = 0; d < run->n_names; d++) {
        mem_free(run->names[d]);
        series_release(&run->chains[d]);
    }
    mem_free(run->names);
    mem_free(run->chains);
    mem_free(run->title);
    *run = (struct plot_run){0};
}
