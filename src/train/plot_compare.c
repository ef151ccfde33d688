/* SPDX-License-Identifier: Apache-2.0 */
#include "train/plot_compare.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "train/plot_data.h"
#include "train/plot_panel.h"
#include "train/svg.h"

/* What is drawn of a run; names index struct line.curves and the panels. */
enum { SHOW_MAPE, SHOW_RELMSE, SHOW_FLIP, SHOW_LOSS, SHOW_SHARE, SHOW_STEPS, N_SHOWN };

struct line {
    char *name;  /* in the legend; owned */
    char *title; /* of the run; may be NULL; owned */
    double last_step, last_second;
    struct series curves[N_SHOWN]; /* over seconds, or steps */
};

/* Every run has a colour and a dash pattern of its own while there are no more than six; then the
 * pairs differ, up to 36 runs. Colours as in plot.c. */
enum { N_STYLES = 6 };
static const char *const colors[N_STYLES] = {"#0072b2", "#d55e00", "#009e73",
                                             "#a64d85", "#495057", "#a67c00"};
static const char *const dash_patterns[N_STYLES] = {NULL,         "9 4",  "2 3",
                                                    "11 3 2.5 3", "16 4", "7 3 2 3 2 3"};

static struct curve style(size_t i)
{
    return (struct curve){.color = colors[i % N_STYLES],
                          .dashes = dash_patterns[(i + i / N_STYLES) % N_STYLES]};
}

/* ---- Runs --------------------------------------------------------------------------------- */

/* The name of the file without its folder and ".metrics.jsonl" or another extension. */
static char *short_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *name = mem_strdup(slash && slash[1] ? slash + 1 : path);
    if (!name) return NULL;
    char *dot = strrchr(name, '.');
    if (dot && dot != name) *dot = 0;
    size_t n = strlen(name), tail = strlen(".metrics");
    if (n > tail && str_ends(name, ".metrics")) name[n - tail] = 0;
    return name;
}

/* Runs of the same name from several folders are told apart by their paths. */
static lmn_status name_lines(struct line *lines, const char *const *paths, uint32_t n,
                             struct error *err)
{
    for (uint32_t i = 0; i < n; i++)
        if (!(lines[i].name = short_name(paths[i]))) return fail_memory(err, "a plot");
    for (uint32_t i = 0; i < n; i++) {
        bool is_twice = false;
        for (uint32_t j = i + 1; j < n; j++) {
            if (strcmp(lines[i].name, lines[j].name) != 0) continue;
            char *path = mem_strdup(paths[j]);
            if (!path) return fail_memory(err, "a plot");
            mem_free(lines[j].name);
            lines[j].name = path;
            is_twice = true;
        }
        if (!is_twice) continue;
        mem_free(lines[i].name);
        lines[i].name = mem_strdup(paths[i]);
        if (!lines[i].name) return fail_memory(err, "a plot");
    }
    return LMN_OK;
}

/* How many of the batches were replayed, in windows of equally many batches. */
static lmn_status get_share(const struct plot_run *run, struct series *out, struct error *err)
{
    enum { N_WINDOWS = 100, MIN_BATCHES = 20 };
    const struct series *fresh = &run->curves[PLOT_LOSS_FRESH_BATCH];
    const struct series *replayed = &run->curves[PLOT_LOSS_REPLAYED_BATCH];
    size_t n = fresh->n + replayed->n, window = n / N_WINDOWS + 1, n_now = 0, n_replayed = 0;
    if (window < MIN_BATCHES) window = MIN_BATCHES;
    for (size_t f = 0, r = 0; f + r < n;) {
        bool is_replayed = f == fresh->n || (r < replayed->n && replayed->x[r] < fresh->x[f]);
        double step = is_replayed ? replayed->x[r++] : fresh->x[f++];
        n_replayed += is_replayed;
        n_now++;
        if (n_now < window && (f + r < n || (out->n > 0 && n_now < window / 2))) continue;
        if (!series_add(out, step, (double)n_replayed / (double)n_now))
            return fail_memory(err, "a plot");
        n_now = n_replayed = 0;
    }
    return LMN_OK;
}

/* Replaces steps by seconds, between the recorded ones and from 0 at step 0. */
static void use_seconds(struct series *s, const struct series *seconds)
{
    size_t k = 0;
    for (size_t i = 0; i < s->n; i++) {
        double step = s->x[i];
        while (k < seconds->n && seconds->x[k] < step) k++;
        if (k == seconds->n) {
            s->x[i] = seconds->y[k - 1];
            continue;
        }
        double x0 = k ? seconds->x[k - 1] : 0, y0 = k ? seconds->y[k - 1] : 0;
        double t = seconds->x[k] > x0 ? (step - x0) / (seconds->x[k] - x0) : 1;
        s->x[i] = y0 + t * (seconds->y[k] - y0);
    }
    for (size_t i = 1; i < s->n; i++) s->x[i] = fmax(s->x[i], s->x[i - 1]); /* never back */
}

static lmn_status copy_series(const struct series *from, struct series *to, struct error *err)
{
    for (size_t i = 0; i < from->n; i++)
        if (!series_add(to, from->x[i], from->y[i])) return fail_memory(err, "a plot");
    return LMN_OK;
}

/* Keeps of a run what is drawn, so that the chains of many runs are not held at once. */
static lmn_status read_line(const char *path, struct line *line, struct series *seconds,
                            struct error *err)
{
    static const struct {
        enum plot_curve from;
        int to;
    } copied[] = {{PLOT_MAPE, SHOW_MAPE},
                  {PLOT_RELMSE, SHOW_RELMSE},
                  {PLOT_FLIP, SHOW_FLIP},
                  {PLOT_LOSS_FRESH, SHOW_LOSS}};
    lmn_status status = LMN_OK;
    struct plot_run run = {0};
    TRY(plot_run_read(path, &run, err));
    for (size_t i = 0; i < sizeof copied / sizeof *copied; i++)
        TRY(copy_series(&run.curves[copied[i].from], &line->curves[copied[i].to], err));
    TRY(get_share(&run, &line->curves[SHOW_SHARE], err));
    if (line->curves[SHOW_SHARE].n == 0) /* a model's history counts no batches */
        TRY(copy_series(&run.curves[PLOT_REUSE], &line->curves[SHOW_SHARE], err));
    *seconds = run.curves[PLOT_SECONDS];
    run.curves[PLOT_SECONDS] = (struct series){0};
    for (size_t i = 0; i < seconds->n; i++)
        if (!series_add(&line->curves[SHOW_STEPS], seconds->x[i], seconds->x[i])) {
            status = fail_memory(err, "a plot");
            goto done;
        }
    line->last_step = run.last_step;
    line->last_second = seconds->n ? seconds->y[seconds->n - 1] : 0;
    line->title = run.title;
    run.title = NULL;
done:
    plot_run_release(&run);
    return status;
}

static lmn_status read_lines(const char *const *paths, uint32_t n, struct line *lines,
                             bool *is_time, struct error *err)
{
    lmn_status status = LMN_OK;
    struct series *seconds = mem_new(n, sizeof *seconds);
    if (!seconds) return fail_memory(err, "a plot");
    *is_time = true;
    for (uint32_t i = 0; i < n; i++) {
        TRY(read_line(paths[i], &lines[i], &seconds[i], err));
        *is_time &= seconds[i].n > 0;
    }
    for (uint32_t i = 0; *is_time && i < n; i++)
        for (int c = 0; c < N_SHOWN; c++) use_seconds(&lines[i].curves[c], &seconds[i]);
    TRY(name_lines(lines, paths, n, err));
done:
    for (uint32_t i = 0; i < n; i++) series_release(&seconds[i]);
    mem_free(seconds);
    return status;
}

/* ---- Drawing ------------------------------------------------------------------------------ */

/* The scene when all runs are of one, else what this is. */
static const char *get_title(const struct line *lines, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++)
        if (!lines[i].title || strcmp(lines[i].title, lines[0].title) != 0)
            return "Training runs compared";
    return lines[0].title;
}

/* The legend: a row per run with its line, its name and where it ended. */
static void add_table(struct str *s, const struct line *lines, uint32_t n, double *y)
{
    enum { SAMPLE = 60, ROW = 20, NAME_LETTERS = 48 };
    static const struct {
        const char *name;
        double right;
        int curve;
    } columns[] = {{"MAPE", PANEL_RIGHT - 140, SHOW_MAPE},
                   {"relMSE", PANEL_RIGHT - 70, SHOW_RELMSE},
                   {"FLIP", PANEL_RIGHT, SHOW_FLIP}};
    enum { N_COLUMNS = sizeof columns / sizeof *columns };
    const double steps_right = PANEL_RIGHT - 285, time_right = PANEL_RIGHT - 210;
    svg_add_text(s, PANEL_LEFT, *y, "start", "tick", "run, and where it ended");
    svg_add_text(s, steps_right, *y, "end", "tick", "steps");
    svg_add_text(s, time_right, *y, "end", "tick", "time");
    for (int c = 0; c < N_COLUMNS; c++)
        svg_add_text(s, columns[c].right, *y, "end", "tick", columns[c].name);
    for (uint32_t i = 0; i < n; i++) {
        const struct line *line = &lines[i];
        const struct curve look = style(i);
        *y += ROW;
        str_add(s, "<path fill=\"none\" stroke=\"%s\" stroke-width=\"2.2\"", look.color);
        if (look.dashes) str_add(s, " stroke-dasharray=\"%s\"", look.dashes);
        str_add(s, " d=\"M%d ", PANEL_LEFT);
        svg_add_fixed(s, *y - 4, 1);
        str_add(s, "h%d\"/>\n", SAMPLE - 12);
        panel_add_name(s, PANEL_LEFT + SAMPLE, *y, "start", line->name, NAME_LETTERS);
        svg_begin_text(s, steps_right, *y, "end", "label");
        svg_add_fixed(s, line->last_step, 0);
        str_add(s, "</text>\n");
        if (line->last_second > 0) {
            svg_begin_text(s, time_right, *y, "end", "label");
            svg_add_duration(s, line->last_second);
            str_add(s, "</text>\n");
        }
        for (int c = 0; c < N_COLUMNS; c++) {
            const struct series *points = &line->curves[columns[c].curve];
            if (points->n == 0) continue;
            svg_begin_text(s, columns[c].right, *y, "end", "label");
            svg_add_fixed(s, fmin(points->y[points->n - 1], 1e6), 4);
            str_add(s, "</text>\n");
        }
    }
    *y += 26;
}

static lmn_status add_panels(struct str *s, const struct line *lines, uint32_t n, bool is_time,
                             double *y, struct error *err)
{
    static const struct panel panels[N_SHOWN] = {
        [SHOW_MAPE] = {"MAPE on the test set", 170, .is_log = true},
        [SHOW_RELMSE] = {"relMSE on the test set", 170, .is_log = true},
        [SHOW_FLIP] = {"FLIP on the test set", 150, .is_log = false},
        [SHOW_LOSS] = {"Loss of fresh batches", 170, .is_log = true},
        [SHOW_SHARE] = {"Share of replayed batches", 110, .is_share = true},
        [SHOW_STEPS] = {"Steps", 110, .is_log = false},
    };
    lmn_status status = LMN_OK;
    struct axis x = {0, 0, PANEL_LEFT, PANEL_RIGHT, false, is_time};
    struct curve *curves = mem_new(n, sizeof *curves);
    if (!curves) return fail_memory(err, "a plot");
    for (uint32_t i = 0; i < n; i++)
        x.high = fmax(x.high, is_time ? lines[i].last_second : lines[i].last_step);
    if (!(x.high > 1e-6)) x.high = 1;
    for (int c = 0; c < N_SHOWN; c++) {
        if (c == SHOW_STEPS && !is_time) continue;
        struct panel panel = panels[c];
        for (uint32_t i = 0; i < n; i++) {
            curves[i] = style(i);
            curves[i].points = &lines[i].curves[c];
            curves[i].name = lines[i].name;
            curves[i].has_marks = c <= SHOW_FLIP; /* evaluated now and then */
        }
        panel.has_no_legend = true;
        panel.curves = curves;
        panel.n_curves = n;
        TRY(panel_add(s, &panel, &x, NULL, y, err));
    }
done:
    mem_free(curves);
    return status;
}

lmn_status plot_compare(const char *const *paths, uint32_t n_paths, struct str *s, double *y,
                        struct error *err)
{
    lmn_status status = LMN_OK;
    bool is_time = false;
    struct line *lines = mem_new(n_paths, sizeof *lines);
    if (!lines) return fail_memory(err, "a plot");
    TRY(read_lines(paths, n_paths, lines, &is_time, err));
    svg_add_text(s, PANEL_LEFT, 28, "start", "head", get_title(lines, n_paths));
    svg_add_text(s, PANEL_LEFT, 48, "start", "label",
                 is_time ? "Training runs over processor time per thread, tracing included"
                         : "Training runs over steps, as not all know their times");
    *y = 74;
    add_table(s, lines, n_paths, y);
    TRY(add_panels(s, lines, n_paths, is_time, y, err));
done:
    for (uint32_t i = 0; i < n_paths; i++) {
        mem_free(lines[i].name);
        mem_free(lines[i].title);
        for (int c = 0; c < N_SHOWN; c++) series_release(&lines[i].curves[c]);
    }
    mem_free(lines);
    return status;
}
