/* SPDX-License-Identifier: Apache-2.0 */
#include "train/plot_learning.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/mem.h"
#include "train/plot_data.h"
#include "train/plot_panel.h"
#include "train/svg.h"

enum { N_SETS = 2, N_METRICS = 3, N_PANELS = N_SETS * N_METRICS, MAX_METHODS = 256 };

static const char *const sets[N_SETS] = {"uniform", "hard"};
static const char *const metrics[N_METRICS] = {"mape", "relmse", "flip"};
static const char *const metric_titles[N_METRICS] = {"MAPE", "relMSE", "FLIP"};

/* A method over all its seeds; panel = set * N_METRICS + metric; owned but the label. */
struct method {
    const char *label;
    struct series median[N_PANELS], low[N_PANELS], high[N_PANELS]; /* over seconds */
};

static const size_t max_file_size = (size_t)1 << 30;

/* ---- Reading ------------------------------------------------------------------------------- */

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double *sorted, size_t n)
{
    return n % 2 ? sorted[n / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]);
}

static double number_of(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

static bool is_named(const json_t *object, const char *key, const char *name)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text && strcmp(text, name) == 0;
}

/* The k-th evaluations of a method's runs become one point of the panel. `values` has room for two
 * numbers per run. False: there is none, or memory is short (*is_short). */
static bool add_point(struct method *m, const json_t *runs, size_t k, int panel, double *values,
                      bool *is_short)
{
    const size_t n_runs = json_array_size(runs);
    double *times = values + n_runs;
    size_t n = 0;
    for (size_t i = 0; i < n_runs; i++) {
        const json_t *run = json_array_get(runs, i);
        if (!is_named(run, "method", m->label)) continue;
        const json_t *all = json_object_get(run, "evaluations"), *at = json_array_get(all, k);
        if (!at && json_array_size(all) > 0) return false; /* as far as all have come */
        const double error = number_of(json_object_get(at, sets[panel / N_METRICS]),
                                       metrics[panel % N_METRICS]);
        const double time = number_of(at, "cpu_s");
        if (!isfinite(error) || !(time > 0)) continue;
        values[n] = error;
        times[n++] = time;
    }
    if (n == 0) return false;
    qsort(values, n, sizeof *values, compare_doubles);
    qsort(times, n, sizeof *times, compare_doubles);
    double x = median(times, n);
    const struct series *before = &m->median[panel];
    if (before->n > 0) x = fmax(x, before->x[before->n - 1]);
    *is_short = !series_add(&m->median[panel], x, median(values, n)) ||
                !series_add(&m->low[panel], x, values[0]) ||
                !series_add(&m->high[panel], x, values[n - 1]);
    return !*is_short;
}

static lmn_status read_methods(const json_t *root, const json_t *scene, struct method *out,
                               size_t n, struct error *err)
{
    const json_t *runs = json_object_get(scene, "runs");
    const json_t *labels = json_object_get(root, "methods");
    double *values = mem_new(2 * json_array_size(runs) + 1, sizeof *values);
    bool is_short = !values;
    for (size_t i = 0; i < n && !is_short; i++) {
        const json_t *label = json_object_get(json_array_get(labels, i), "method");
        out[i].label = json_string_value(label) ? json_string_value(label) : "";
        for (int panel = 0; panel < N_PANELS && !is_short; panel++)
            for (size_t k = 0; add_point(&out[i], runs, k, panel, values, &is_short);) k++;
    }
    mem_free(values);
    return is_short ? fail_memory(err, "a plot") : LMN_OK;
}

static lmn_status read_file(const char *path, const char *name, json_t **root, const json_t **scene,
                            struct error *err)
{
    lmn_status status = LMN_OK;
    char *text = NULL;
    size_t size;
    json_error_t reason;
    TRY(file_read(path, max_file_size, &text, &size, err));
    *root = json_loadb(text, size, 0, &reason);
    if (!json_is_object(*root)) {
        status = fail(err, LMN_ERR_PARSE, "%s:%d:%d: %s", path, *root ? 1 : reason.line,
                      *root ? 1 : reason.column, *root ? "expected an object" : reason.text);
        goto done;
    }
    const json_t *scenes = json_object_get(*root, "scenes");
    *scene = NULL;
    for (size_t i = 0; i < json_array_size(scenes) && !*scene; i++)
        if (is_named(json_array_get(scenes, i), "name", name)) *scene = json_array_get(scenes, i);
    if (!*scene) status = fail(err, LMN_ERR_ARGUMENT, "%s: no scene \"%s\" in it", path, name);
done:
    mem_free(text);
    return status;
}

/* ---- Drawing ------------------------------------------------------------------------------- */

/* As in plot_compare.c. */
static struct curve style(size_t i)
{
    enum { N_STYLES = 6 };
    static const char *const colors[N_STYLES] = {"#0072b2", "#d55e00", "#009e73",
                                                 "#a64d85", "#495057", "#a67c00"};
    static const char *const dashes[N_STYLES] = {NULL,         "9 4",  "2 3",
                                                 "11 3 2.5 3", "16 4", "7 3 2 3 2 3"};
    return (struct curve){.color = colors[i % N_STYLES],
                          .dashes = dashes[i / N_STYLES % N_STYLES],
                          .has_marks = true};
}

/* The legend, with the errors at the end. */
static void add_table(struct str *s, const struct method *methods, size_t n, double *y)
{
    enum { SAMPLE = 60, ROW = 20, COLUMN = 74, NAME_LETTERS = 40 };
    for (int p = 0; p < N_PANELS; p++) {
        const double right = PANEL_RIGHT - COLUMN * (N_PANELS - 1 - p);
        if (p % N_METRICS == 0)
            svg_add_text(s, right - COLUMN + 18, *y - 16, "start", "tick", sets[p / N_METRICS]);
        svg_add_text(s, right, *y, "end", "tick", metric_titles[p % N_METRICS]);
    }
    svg_add_text(s, PANEL_LEFT, *y, "start", "tick", "method, and errors at its end");
    for (size_t i = 0; i < n; i++) {
        const struct curve look = style(i);
        *y += ROW;
        str_add(s, "<path fill=\"none\" stroke=\"%s\" stroke-width=\"2.2\"", look.color);
        if (look.dashes) str_add(s, " stroke-dasharray=\"%s\"", look.dashes);
        str_add(s, " d=\"M%d ", PANEL_LEFT);
        svg_add_fixed(s, *y - 4, 1);
        str_add(s, "h%d\"/>\n", SAMPLE - 12);
        panel_add_name(s, PANEL_LEFT + SAMPLE, *y, "start", methods[i].label, NAME_LETTERS);
        for (int p = 0; p < N_PANELS; p++) {
            const struct series *points = &methods[i].median[p];
            if (points->n == 0) continue;
            svg_begin_text(s, PANEL_RIGHT - COLUMN * (N_PANELS - 1 - p), *y, "end", "label");
            svg_add_fixed(s, fmin(points->y[points->n - 1], 1e6), 4);
            str_add(s, "</text>\n");
        }
    }
    *y += 26;
}

static struct axis time_axis(const struct method *methods, size_t n)
{
    struct axis x = {INFINITY, 0, PANEL_LEFT, PANEL_RIGHT, true, true};
    for (size_t i = 0; i < n; i++) {
        const struct series *c = methods[i].median;
        if (c->n == 0) continue;
        x.low = fmin(x.low, c->x[0]);
        x.high = fmax(x.high, c->x[c->n - 1]);
    }
    if (!(x.low <= x.high)) x.low = x.high = 1;
    x.low /= 1.05;
    x.high *= 1.05;
    return x;
}

static lmn_status add_panels(struct str *s, const json_t *scene, const struct method *methods,
                             size_t n, double *y, struct error *err)
{
    lmn_status status = LMN_OK;
    const struct axis x = time_axis(methods, n);
    struct series noise = {0};
    struct curve *curves = mem_new(n + 1, sizeof *curves);
    if (!curves) return fail_memory(err, "a plot");
    for (int p = 0; p < N_PANELS; p++) {
        char title[64];
        const json_t *floors = json_object_get(scene, "noise");
        const double level = number_of(json_object_get(floors, sets[p / N_METRICS]),
                                       metrics[p % N_METRICS]);
        for (size_t i = 0; i < n; i++) {
            curves[i] = style(i);
            curves[i].points = &methods[i].median[p];
            curves[i].low = &methods[i].low[p];
            curves[i].high = &methods[i].high[p];
            curves[i].name = methods[i].label;
        }
        noise.n = 0;
        if (level > 0 &&
            (!series_add(&noise, x.low, level) || !series_add(&noise, x.high, level))) {
            status = fail_memory(err, "a plot");
            goto done;
        }
        curves[n] = (struct curve){
            .points = &noise, .name = "noise", .color = "#868e96", .dashes = "3 4"};
        snprintf(title, sizeof title, "%s, %s configurations", metric_titles[p % N_METRICS],
                 sets[p / N_METRICS]);
        const struct panel panel = {.title = title,
                                    .height = 190,
                                    .is_log = true,
                                    .has_no_legend = true,
                                    .curves = curves,
                                    .n_curves = n + 1};
        TRY(panel_add(s, &panel, &x, NULL, y, err));
    }
done:
    series_release(&noise);
    mem_free(curves);
    return status;
}

lmn_status plot_learning_svg(const char *path, const char *scene, const char *svg_path,
                             struct error *err)
{
    lmn_status status = LMN_OK;
    struct str body = {0};
    struct method *methods = NULL;
    size_t n = 0;
    json_t *root = NULL;
    const json_t *found;
    double y = 96;
    TRY(read_file(path, scene, &root, &found, err));
    n = json_array_size(json_object_get(root, "methods"));
    if (n > MAX_METHODS) n = MAX_METHODS;
    methods = mem_new(n + 1, sizeof *methods);
    if (!methods) {
        status = fail_memory(err, "a plot");
        goto done;
    }
    TRY(read_methods(root, found, methods, n, err));
    svg_add_text(&body, PANEL_LEFT, 28, "start", "head", scene);
    svg_add_text(&body, PANEL_LEFT, 48, "start", "label",
                 "Errors over processor time per thread, tracing included: median and range over "
                 "seeds; dashed grey is the references' own noise");
    add_table(&body, methods, n, &y);
    TRY(add_panels(&body, found, methods, n, &y, err));
    TRY(svg_write_page(&body, PANEL_PAGE_WIDTH, (int)(y - PANEL_GAP + 34), svg_path, err));
done:
    for (size_t i = 0; methods && i < n; i++) {
        for (int p = 0; p < N_PANELS; p++) {
            series_release(&methods[i].median[p]);
            series_release(&methods[i].low[p]);
            series_release(&methods[i].high[p]);
        }
    }
    mem_free(methods);
    json_decref(root);
    str_release(&body);
    return status;
}
