/* SPDX-License-Identifier: Apache-2.0 */
#include "train/plot.h"

#include <math.h>
#include <string.h>

#include "base/file.h"
#include "base/str.h"
#include "train/plot_data.h"
#include "train/svg.h"

/* All in pixels. Panels lie under each other and share the step axis. */
enum { MAX_CURVES = 5 }; /* of a panel */
enum {
    WIDTH = 960,
    LEFT = 150, /* room for the names of variables */
    RIGHT = 30,
    TOP = 64,
    PLOT_WIDTH = WIDTH - LEFT - RIGHT,
    PANEL_GAP = 54,
    N_BINS = 1000,
    STRIP_POINTS = 2000, /* of all chains, per dimension */
};

/* Dark enough on white, and apart for the colour-blind (after Okabe and Ito 2008). */
static const char blue[] = "#0072b2", orange[] = "#d55e00", green[] = "#009e73",
                  purple[] = "#a64d85", grey[] = "#495057";

/* ---- Axes --------------------------------------------------------------------------------- */

/* Maps values low..high to pixels at0..at1; logarithms when is_log. */
struct axis {
    double low, high, at0, at1;
    bool is_log;
};

static double place(const struct axis *a, double v)
{
    double t = a->is_log ? log(v / a->low) / log(a->high / a->low)
                         : (v - a->low) / (a->high - a->low);
    t = t > 0 ? t : 0;
    return a->at0 + (t < 1 ? t : 1) * (a->at1 - a->at0);
}

/* 1, 2 or 5 times a power of ten, so that about n_wanted steps cover the range. */
static double nice_step(double range, int n_wanted)
{
    double raw = range / n_wanted, power = pow(10, floor(log10(raw)));
    double m = raw / power;
    return power * (m < 1.5 ? 1 : m < 3.5 ? 2 : m < 7.5 ? 5 : 10);
}

/* The range of the curves' values, widened to something that can be drawn. */
static struct axis value_axis(const struct series *const *curves, int n, bool is_log, double top,
                              double bottom)
{
    double low = INFINITY, high = -INFINITY;
    for (int c = 0; c < n; c++) {
        for (size_t i = 0; i < curves[c]->n; i++) {
            double v = curves[c]->y[i];
            if (is_log && !(v > 0)) continue;
            low = fmin(low, v);
            high = fmax(high, v);
        }
    }
    if (!(low <= high)) low = high = 1;
    if (is_log) {
        low = fmax(low, high * 1e-12); /* a stray zero-like value must not flatten the rest */
        low /= 1.15;
        high *= 1.15;
    }
    return (struct axis){low, high, bottom, top, is_log};
}

static void add_grid_line(struct str *s, double y)
{
    svg_add_line(s, LEFT, y, LEFT + PLOT_WIDTH, y, "grid");
    svg_begin_text(s, LEFT - 8, y + 4, "end", "tick");
}

static void add_linear_grid(struct str *s, const struct axis *a, int n_wanted)
{
    double step = nice_step(a->high - a->low, n_wanted);
    int decimals = (int)fmin(fmax(ceil(-log10(step) - 1e-9), 0), 6);
    double first = ceil(a->low / step);
    for (int k = 0; k <= 4 * n_wanted && (first + k) * step <= a->high * (1 + 1e-9); k++) {
        double v = (first + k) * step;
        add_grid_line(s, place(a, v));
        svg_add_fixed(s, v, decimals);
        str_add(s, "</text>\n");
    }
}

/* Grid lines and labels of a logarithmic axis: at 1, 2, 5 when it spans few powers of ten, else at
 * the powers alone. An axis that spans less is as good as linear. */
static void add_log_grid(struct str *s, const struct axis *a)
{
    static const int mantissas[] = {1, 2, 5};
    double decades = log10(a->high / a->low);
    if (decades < 0.8 && a->high < 1e4 && a->low > 1e-4) {
        add_linear_grid(s, a, 5);
        return;
    }
    int every = decades > 8 ? (int)ceil(decades / 8) : 1;
    for (int e = (int)floor(log10(a->low)); e <= (int)ceil(log10(a->high)); e++) {
        if (e % every != 0) continue;
        for (int i = 0; i < (decades < 2.5 ? 3 : 1); i++) {
            double v = mantissas[i] * pow(10, e);
            if (v < a->low || v > a->high) continue;
            add_grid_line(s, place(a, v));
            if (e < -4 || e > 4)
                str_add(s, "%d&#183;10<tspan dy=\"-4\" font-size=\"8\">%d</tspan>", mantissas[i],
                        e);
            else
                svg_add_fixed(s, v, e < 0 ? -e : 0);
            str_add(s, "</text>\n");
        }
    }
}

/* Seconds of training at a step, between the recorded ones. */
static double seconds_at(const struct series *seconds, double step)
{
    size_t i = 0;
    while (i < seconds->n && seconds->x[i] < step) i++;
    if (i == 0) return seconds->y[0] * (seconds->x[0] > 0 ? step / seconds->x[0] : 1);
    if (i == seconds->n) return seconds->y[i - 1];
    double t = (step - seconds->x[i - 1]) / (seconds->x[i] - seconds->x[i - 1]);
    return seconds->y[i - 1] + t * (seconds->y[i] - seconds->y[i - 1]);
}

/* Vertical lines at steps over a panel; labels under it, and seconds above it when there are any.
 */
static void add_step_axis(struct str *s, const struct axis *x, double top, double bottom,
                          const struct series *seconds)
{
    double step = nice_step(x->high - x->low, 8);
    bool has_times = seconds && seconds->n > 0;
    if (step < 1) step = 1;
    svg_add_text(s, LEFT - 24, bottom + 16, "end", "tick", "step");
    if (has_times) svg_add_text(s, LEFT - 24, top - 6, "end", "tick", "time");
    for (double k = ceil(x->low / step); k * step <= x->high * (1 + 1e-9); k++) {
        double at = place(x, k * step);
        svg_add_line(s, at, top, at, bottom, "grid");
        svg_begin_text(s, at, bottom + 16, "middle", "tick");
        svg_add_count(s, k * step, x->high);
        str_add(s, "</text>\n");
        if (!has_times) continue;
        svg_begin_text(s, at, top - 6, "middle", "tick");
        svg_add_duration(s, seconds_at(seconds, k * step));
        str_add(s, "</text>\n");
    }
}

/* ---- Panels ------------------------------------------------------------------------------- */

struct curve {
    const struct series *points;
    const char *name, *color;
    bool is_faint; /* noise behind a clearer curve of the same name, when that has points */
    bool has_marks;
};

static void add_curve(struct str *s, const struct curve *c, const struct axis *x,
                      const struct axis *y)
{
    str_add(s, "<path fill=\"none\" stroke=\"%s\" stroke-linejoin=\"round\" %s d=\"", c->color,
            c->is_faint ? "stroke-width=\"1\" opacity=\"0.3\"" : "stroke-width=\"1.8\"");
    bool is_first = true;
    for (size_t i = 0; i < c->points->n; i++) {
        if (y->is_log && !(c->points->y[i] > 0)) continue;
        str_add(s, "%s", is_first ? "M" : "L");
        is_first = false;
        svg_add_fixed(s, place(x, c->points->x[i]), 1);
        str_add(s, " ");
        svg_add_fixed(s, place(y, c->points->y[i]), 1);
    }
    str_add(s, "\"/>\n");
    if (!c->has_marks && c->points->n > 1) return;
    for (size_t i = 0; i < c->points->n; i++) { /* few points, or one that no line shows */
        if (y->is_log && !(c->points->y[i] > 0)) continue;
        str_add(s, "<circle r=\"2.6\" fill=\"%s\" cx=\"", c->color);
        svg_add_fixed(s, place(x, c->points->x[i]), 1);
        str_add(s, "\" cy=\"");
        svg_add_fixed(s, place(y, c->points->y[i]), 1);
        str_add(s, "\"/>\n");
    }
}

struct panel {
    const char *title;
    double height;
    bool is_log, is_share; /* is_share: from 0 to 1 */
    struct curve curves[MAX_CURVES];
    int n_curves;
};

/* Draws a panel with its title and legend above it, from *y down, and moves *y below it. */
static lmn_status add_panel(struct str *s, const struct panel *panel, const struct axis *x,
                            const struct series *seconds, double *y, struct error *err)
{
    lmn_status status = LMN_OK;
    struct series thin[MAX_CURVES] = {0};
    const struct series *drawn[MAX_CURVES];
    struct curve curves[MAX_CURVES];
    bool has_points = false;
    for (int c = 0; c < panel->n_curves; c++) {
        curves[c] = panel->curves[c];
        TRY(series_thin(curves[c].points, N_BINS, &thin[c], err));
        drawn[c] = curves[c].points = &thin[c];
        has_points |= thin[c].n > 0;
    }
    for (int c = 0; c < panel->n_curves; c++) {
        bool has_clearer = false;
        for (int d = 0; d < panel->n_curves; d++)
            has_clearer |= d != c && strcmp(curves[d].name, curves[c].name) == 0 && thin[d].n > 0;
        curves[c].is_faint &= has_clearer;
    }
    if (!has_points) goto done;

    double top = *y + (seconds ? 40 : 24), bottom = top + panel->height;
    struct axis value = panel->is_share
                            ? (struct axis){0, 1, bottom, top, false}
                            : value_axis(drawn, panel->n_curves, panel->is_log, top, bottom);
    svg_add_text(s, LEFT, *y + 12, "start", "title", panel->title);
    double legend = LEFT + PLOT_WIDTH;
    for (int c = panel->n_curves - 1; c >= 0; c--) {
        const struct curve *curve = &curves[c];
        if (curve->is_faint || thin[c].n == 0) continue;
        legend -= 7.2 * (double)strlen(curve->name); /* about as wide as fonts make it */
        svg_add_text(s, legend, *y + 12, "start", "label", curve->name);
        str_add(s, "<path stroke=\"%s\" stroke-width=\"3\" d=\"M", curve->color);
        svg_add_fixed(s, legend - 24, 1);
        str_add(s, " ");
        svg_add_fixed(s, *y + 8, 1);
        str_add(s, "h18\"/>\n");
        legend -= 42;
    }
    add_step_axis(s, x, top, bottom, seconds);
    if (panel->is_log)
        add_log_grid(s, &value);
    else
        add_linear_grid(s, &value, 4);
    svg_add_line(s, LEFT, bottom, LEFT + PLOT_WIDTH, bottom, "axis");
    for (int c = 0; c < panel->n_curves; c++) add_curve(s, &curves[c], x, &value);
    *y = bottom + PANEL_GAP;
done:
    for (int c = 0; c < panel->n_curves; c++) series_release(&thin[c]);
    return status;
}

/* A name that is too long for the margin loses its middle. */
static void add_name(struct str *s, double x, double y, const char *name)
{
    enum { MAX_LETTERS = 21, TAIL = 9 };
    size_t n = strlen(name);
    char text[MAX_LETTERS + 1];
    if (n <= MAX_LETTERS) {
        svg_add_text(s, x, y, "end", "label", name);
        return;
    }
    memcpy(text, name, MAX_LETTERS - TAIL - 2);
    memcpy(text + MAX_LETTERS - TAIL - 2, "..", 2);
    memcpy(text + MAX_LETTERS - TAIL, name + n - TAIL, TAIL + 1);
    for (char *c = text; *c; c++)
        if ((unsigned char)*c >= 0x80) *c = '?'; /* cut letters would be no UTF-8 */
    svg_add_text(s, x, y, "end", "label", text);
}

/* The dots of one strip, between the pixels y0 and y1. */
static void add_dots(struct str *s, const struct series *c, const struct axis *x, double y0,
                     double y1)
{
    struct axis value = {0, 1, y1 - 2, y0 + 2, false};
    /* whole snapshots stay or go: their points share a step */
    size_t n_same = 1;
    while (n_same < c->n && c->x[n_same] == c->x[0]) n_same++;
    size_t n_snapshots = c->n / n_same + 1, room = STRIP_POINTS / n_same + 1;
    size_t every = (n_snapshots + room - 1) / room;
    str_add(s,
            "<path stroke=\"%s\" stroke-width=\"2\" stroke-linecap=\"round\" opacity=\"0.45\" d=\"",
            blue);
    for (size_t i = 0; i < c->n; i++) {
        if (i / n_same % every != 0) continue;
        str_add(s, "M");
        svg_add_fixed(s, place(x, c->x[i]), 1);
        str_add(s, " ");
        svg_add_fixed(s, place(&value, c->y[i]), 1);
        str_add(s, "h0");
    }
    str_add(s, "\"/>\n");
}

/* One strip per dimension: where the chains were, 0 at the bottom and 1 at the top. */
static void add_strips(struct str *s, const struct plot_run *run, const struct axis *x, double *y)
{
    size_t n_points = 0;
    for (size_t d = 0; d < run->n_names; d++) n_points += run->chains[d].n;
    if (n_points == 0) return;
    svg_add_text(s, LEFT, *y + 12, "start", "title", "Where the chains are");
    svg_add_text(s, LEFT + PLOT_WIDTH, *y + 12, "end", "label",
                 "each variable's range, low to high; a dot is a chain");
    double height = fmin(30, fmax(14, 480 / (double)run->n_names)), top = *y + 24;
    double step = height + 4, bottom = top + (double)run->n_names * step - 4;
    for (size_t d = 0; d < run->n_names; d++) {
        double y0 = top + (double)d * step;
        str_add(s, "<rect fill=\"#f1f3f5\" x=\"%d\" width=\"%d\" y=\"", LEFT, PLOT_WIDTH);
        svg_add_fixed(s, y0, 1);
        str_add(s, "\" height=\"");
        svg_add_fixed(s, height, 1);
        str_add(s, "\"/>\n");
        add_name(s, LEFT - 8, y0 + height / 2 + 4, run->names[d]);
    }
    add_step_axis(s, x, top, bottom, NULL);
    for (size_t d = 0; d < run->n_names; d++) {
        double y0 = top + (double)d * step;
        add_dots(s, &run->chains[d], x, y0, y0 + height);
    }
    *y = bottom + PANEL_GAP;
}

/* "12,000 steps in 15 min; MAPE 0.08, FLIP 0.09 at the end" */
static void add_summary(struct str *s, const struct plot_run *run)
{
    const struct series *seconds = &run->curves[PLOT_SECONDS];
    static const struct {
        enum plot_curve curve;
        const char *name;
    } errors[] = {{PLOT_MAPE, "MAPE"}, {PLOT_FLIP, "FLIP"}, {PLOT_DSSIM, "DSSIM"}};
    svg_begin_text(s, LEFT, 48, "start", "label");
    svg_add_fixed(s, run->last_step, 0);
    str_add(s, run->last_step == 1 ? " step" : " steps");
    if (seconds->n) {
        str_add(s, " in ");
        svg_add_duration(s, seconds->y[seconds->n - 1]);
        str_add(s, " of processor time per thread");
    }
    const char *separator = "; at the end: ";
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
        const struct series *c = &run->curves[errors[i].curve];
        if (c->n == 0) continue;
        str_add(s, "%s%s ", separator, errors[i].name);
        svg_add_fixed(s, fmin(c->y[c->n - 1], 1e6), 4);
        separator = ", ";
    }
    str_add(s, "</text>\n");
}

static lmn_status draw_run(struct str *s, const struct plot_run *run, double *y, struct error *err)
{
    const struct series *c = run->curves, *seconds = &c[PLOT_SECONDS];
    const struct panel panels[] = {
        {"Loss",
         230,
         true,
         false,
         {{&c[PLOT_LOSS_FRESH_BATCH], "fresh batches", blue, true, false},
          {&c[PLOT_LOSS_REPLAYED_BATCH], "replayed batches", orange, true, false},
          {&c[PLOT_LOSS_ALL], "all batches", grey, true, false},
          {&c[PLOT_LOSS_FRESH], "fresh batches", blue, false, false},
          {&c[PLOT_LOSS_REPLAYED], "replayed batches", orange, false, false}},
         5},
        {"Exploration and reuse",
         120,
         false,
         true,
         {{&c[PLOT_ACCEPTANCE], "proposals accepted", green, false, false},
          {&c[PLOT_REUSE], "probability of reuse", purple, false, false}},
         2},
        {"Error on the test set",
         160,
         true,
         false,
         {{&c[PLOT_MAPE], "MAPE", blue, false, true},
          {&c[PLOT_FLIP], "FLIP", orange, false, true},
          {&c[PLOT_DSSIM], "DSSIM", green, false, true}},
         3},
    };
    struct axis x = {fmin(run->first_step, 0), run->last_step, LEFT, LEFT + PLOT_WIDTH, false};
    if (run->first_step > 0.5 * run->last_step) x.low = run->first_step; /* a part of a run */
    if (!(x.high > x.low)) x.high = x.low + 1;
    for (size_t i = 0; i < sizeof panels / sizeof *panels; i++) {
        lmn_status status = add_panel(s, &panels[i], &x, i == 0 ? seconds : NULL, y, err);
        if (status != LMN_OK) return status;
    }
    add_strips(s, run, &x, y);
    return LMN_OK;
}

lmn_status plot_svg(const char *path, const char *svg_path, struct error *err)
{
    lmn_status status = LMN_OK;
    struct plot_run run = {0};
    struct str body = {0}, head = {0};
    struct file_writer w = {0};
    double height = TOP;
    TRY(plot_run_read(path, &run, err));
    TRY(draw_run(&body, &run, &height, err));
    height -= PANEL_GAP - 34; /* the last panel's labels stay */
    str_add(&head,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" "
            "height=\"%d\">\n"
            "<style>text{font-family:Helvetica,Arial,'DejaVu Sans',sans-serif;fill:#212529}"
            ".head{font-size:18px;font-weight:bold}.title{font-size:14px;font-weight:bold}"
            ".label{font-size:12px}.tick{font-size:11px;fill:#5c636a}"
            ".grid{stroke:#e3e6e8;fill:none}.axis{stroke:#868e96;fill:none}</style>\n"
            "<rect width=\"100%%\" height=\"100%%\" rx=\"8\" fill=\"#ffffff\"/>\n",
            WIDTH, (int)height, WIDTH, (int)height);
    svg_add_text(&head, LEFT, 28, "start", "head", run.title ? run.title : "Training run");
    add_summary(&head, &run);
    if (head.failed || body.failed) {
        status = fail_memory(err, "a plot");
        goto done;
    }
    TRY(file_writer_open(&w, svg_path, err));
    fwrite(head.text, 1, head.length, w.f); /* a short write shows at the commit */
    if (body.length) fwrite(body.text, 1, body.length, w.f);
    fputs("</svg>\n", w.f);
    TRY(file_writer_commit(&w, err));
done:
    file_writer_release(&w);
    str_release(&head);
    str_release(&body);
    plot_run_release(&run);
    return status;
}
