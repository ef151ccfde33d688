/* SPDX-License-Identifier: Apache-2.0 */
#include "train/plot_panel.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "train/svg.h"

enum { N_BINS = 1000 };

/* ---- Axes --------------------------------------------------------------------------------- */

double axis_place(const struct axis *a, double v)
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
static struct axis value_axis(const struct series *curves, size_t n, bool is_log, double top,
                              double bottom)
{
    double low = INFINITY, high = -INFINITY;
    for (size_t c = 0; c < n; c++) {
        for (size_t i = 0; i < curves[c].n; i++) {
            double v = curves[c].y[i];
            if (is_log && !(v > 0)) continue;
            low = fmin(low, v);
            high = fmax(high, v);
        }
    }
    if (!(low <= high)) low = high = 1;
    if (is_log) {
        low = fmax(low, high * 1e-12); /* a stray zero-like value must not flatten the rest */
        low = fmax(low, 1e-300);
        high = fmin(fmax(high, low), 1e300);
        low /= 1.15;
        high *= 1.15;
    } else { /* from 0, and within what labels can say */
        low = fmax(fmin(low, 0), -1e12);
        high = fmax(fmin(high * 1.05, 1e12), low + 1e-6);
    }
    return (struct axis){low, high, bottom, top, is_log, false};
}

static void add_grid_line(struct str *s, double y)
{
    svg_add_line(s, PANEL_LEFT, y, PANEL_RIGHT, y, "grid");
    svg_begin_text(s, PANEL_LEFT - 8, y + 4, "end", "tick");
}

static void add_linear_grid(struct str *s, const struct axis *a, int n_wanted)
{
    double step = nice_step(a->high - a->low, n_wanted);
    int decimals = (int)fmin(fmax(ceil(-log10(step) - 1e-9), 0), 6);
    double first = ceil(a->low / step);
    for (int k = 0; k <= 4 * n_wanted && (first + k) * step <= a->high * (1 + 1e-9); k++) {
        double v = (first + k) * step;
        add_grid_line(s, axis_place(a, v));
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
            add_grid_line(s, axis_place(a, v));
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

/* A step that clocks like, so that about n_wanted of them cover the range of seconds. */
static double nice_time_step(double range, int n_wanted)
{
    static const double steps[] = {60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 21600, 43200};
    double raw = range / n_wanted;
    if (raw < 30) return nice_step(range, n_wanted);
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++)
        if (raw <= 1.3 * steps[i]) return steps[i];
    return 86400 * fmax(nice_step(range / 86400, n_wanted), 1);
}

/* Times that clocks like, on a logarithmic axis. */
static void add_log_times(struct str *s, const struct axis *x, double top, double bottom)
{
    static const double times[] = {0.1, 1,   2,    5,    10,   20,   30,    60,   120,
                                   300, 600, 1200, 1800, 3600, 7200, 18000, 86400};
    svg_add_text(s, PANEL_LEFT - 24, bottom + 16, "end", "tick", "time");
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        if (times[i] < x->low || times[i] > x->high * (1 + 1e-9)) continue;
        const double at = axis_place(x, times[i]);
        svg_add_line(s, at, top, at, bottom, "grid");
        svg_begin_text(s, at, bottom + 16, "middle", "tick");
        svg_add_duration(s, times[i]);
        str_add(s, "</text>\n");
    }
}

void panel_add_x_axis(struct str *s, const struct axis *x, double top, double bottom,
                      const struct series *seconds)
{
    if (x->is_log) {
        add_log_times(s, x, top, bottom);
        return;
    }
    double step = x->is_time ? nice_time_step(x->high - x->low, 8) : nice_step(x->high - x->low, 8);
    bool has_times = seconds && seconds->n > 0;
    if (step < 1 && !x->is_time) step = 1;
    svg_add_text(s, PANEL_LEFT - 24, bottom + 16, "end", "tick", x->is_time ? "time" : "step");
    if (has_times) svg_add_text(s, PANEL_LEFT - 24, top - 6, "end", "tick", "time");
    for (double k = ceil(x->low / step); k * step <= x->high * (1 + 1e-9); k++) {
        double at = axis_place(x, k * step);
        svg_add_line(s, at, top, at, bottom, "grid");
        svg_begin_text(s, at, bottom + 16, "middle", "tick");
        if (x->is_time)
            svg_add_duration(s, k * step);
        else
            svg_add_count(s, k * step, x->high);
        str_add(s, "</text>\n");
        if (!has_times) continue;
        svg_begin_text(s, at, top - 6, "middle", "tick");
        svg_add_duration(s, seconds_at(seconds, k * step));
        str_add(s, "</text>\n");
    }
}

/* ---- Panels ------------------------------------------------------------------------------- */

static void add_place(struct str *s, const char *command, double x, double y)
{
    str_add(s, "%s", command);
    svg_add_fixed(s, x, 1);
    str_add(s, " ");
    svg_add_fixed(s, y, 1);
}

/* The area between the curves low and high. */
static void add_band(struct str *s, const struct curve *c, const struct axis *x,
                     const struct axis *y)
{
    const size_t n = c->low->n < c->high->n ? c->low->n : c->high->n;
    if (n < 2) return;
    str_add(s, "<path stroke=\"none\" opacity=\"0.15\" fill=\"%s\" d=\"", c->color);
    for (size_t i = 0; i < n; i++)
        add_place(s, i ? "L" : "M", axis_place(x, c->high->x[i]), axis_place(y, c->high->y[i]));
    for (size_t i = n; i-- > 0;)
        add_place(s, "L", axis_place(x, c->low->x[i]), axis_place(y, c->low->y[i]));
    str_add(s, "Z\"/>\n");
}

static void add_curve(struct str *s, const struct curve *c, const struct axis *x,
                      const struct axis *y)
{
    if (c->points->n == 0) return;
    str_add(s, "<path fill=\"none\" stroke=\"%s\" stroke-linejoin=\"round\" %s", c->color,
            c->is_faint ? "stroke-width=\"1\" opacity=\"0.3\"" : "stroke-width=\"1.8\"");
    if (c->dashes) str_add(s, " stroke-dasharray=\"%s\"", c->dashes);
    str_add(s, " d=\"");
    bool is_first = true;
    for (size_t i = 0; i < c->points->n; i++) {
        if (y->is_log && !(c->points->y[i] > 0)) continue;
        add_place(s, is_first ? "M" : "L", axis_place(x, c->points->x[i]),
                  axis_place(y, c->points->y[i]));
        is_first = false;
    }
    str_add(s, "\"/>\n");
    if (!c->has_marks && c->points->n > 1) return;
    for (size_t i = 0; i < c->points->n; i++) { /* few points, or one that no line shows */
        if (y->is_log && !(c->points->y[i] > 0)) continue;
        str_add(s, "<circle r=\"2.6\" fill=\"%s\" cx=\"", c->color);
        svg_add_fixed(s, axis_place(x, c->points->x[i]), 1);
        str_add(s, "\" cy=\"");
        svg_add_fixed(s, axis_place(y, c->points->y[i]), 1);
        str_add(s, "\"/>\n");
    }
}

lmn_status panel_add(struct str *s, const struct panel *panel, const struct axis *x,
                     const struct series *seconds, double *y, struct error *err)
{
    lmn_status status = LMN_OK;
    size_t n = panel->n_curves;
    bool has_points = false;
    struct series *thin = mem_new(3 * n, sizeof *thin); /* the bands' edges after the curves */
    struct curve *curves = mem_new(n, sizeof *curves);
    if (!thin || !curves) {
        status = fail_memory(err, "a plot");
        goto done;
    }
    for (size_t c = 0; c < n; c++) {
        curves[c] = panel->curves[c];
        TRY(series_thin(curves[c].points, N_BINS, &thin[c], err));
        curves[c].points = &thin[c];
        has_points |= thin[c].n > 0;
        if (!curves[c].low || !curves[c].high) continue;
        thin[n + 2 * c] = *curves[c].low;
        thin[n + 2 * c + 1] = *curves[c].high;
    }
    for (size_t c = 0; c < n; c++) {
        bool has_clearer = false;
        for (size_t d = 0; d < n; d++)
            has_clearer |= d != c && strcmp(curves[d].name, curves[c].name) == 0 && thin[d].n > 0;
        curves[c].is_faint &= has_clearer;
    }
    if (!has_points) goto done;

    double top = *y + (seconds ? 40 : 24), bottom = top + panel->height;
    struct axis value = panel->is_share ? (struct axis){0, 1, bottom, top, false, false}
                                        : value_axis(thin, 3 * n, panel->is_log, top, bottom);
    svg_add_text(s, PANEL_LEFT, *y + 12, "start", "title", panel->title);
    double legend = PANEL_RIGHT;
    for (size_t c = panel->has_no_legend ? 0 : n; c-- > 0;) {
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
    panel_add_x_axis(s, x, top, bottom, seconds);
    if (panel->is_log)
        add_log_grid(s, &value);
    else
        add_linear_grid(s, &value, 4);
    svg_add_line(s, PANEL_LEFT, bottom, PANEL_RIGHT, bottom, "axis");
    for (size_t c = 0; c < n; c++)
        if (curves[c].low && curves[c].high) add_band(s, &curves[c], x, &value);
    for (size_t c = 0; c < n; c++) add_curve(s, &curves[c], x, &value);
    *y = bottom + PANEL_GAP;
done:
    for (size_t c = 0; thin && c < n; c++) series_release(&thin[c]);
    mem_free(thin);
    mem_free(curves);
    return status;
}

void panel_add_name(struct str *s, double x, double y, const char *anchor, const char *name,
                    size_t max_letters)
{
    enum { MOST_LETTERS = 64 };
    size_t n = strlen(name), max = max_letters < MOST_LETTERS ? max_letters : MOST_LETTERS;
    size_t tail = max * 3 / 7, head = max - tail - 2;
    char text[MOST_LETTERS + 1];
    if (n <= max) {
        svg_add_text(s, x, y, anchor, "label", name);
        return;
    }
    memcpy(text, name, head);
    memcpy(text + head, "..", 2);
    memcpy(text + head + 2, name + n - tail, tail + 1);
    for (char *c = text; *c; c++)
        if ((unsigned char)*c >= 0x80) *c = '?'; /* cut letters would be no UTF-8 */
    svg_add_text(s, x, y, anchor, "label", text);
}
