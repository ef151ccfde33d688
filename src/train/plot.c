/* SPDX-License-Identifier: Apache-2.0 */
#include "train/plot.h"

#include <math.h>
#include <string.h>

#include "base/str.h"
#include "train/plot_compare.h"
#include "train/plot_data.h"
#include "train/plot_panel.h"
#include "train/svg.h"

enum {
    TOP = 64,            /* where the first panel starts, in pixels */
    STRIP_POINTS = 2000, /* of all chains, per dimension */
    NAME_LETTERS = 21,   /* in the left margin */
};

/* Dark enough on white, and apart for the colour-blind (after Okabe and Ito 2008). */
static const char blue[] = "#0072b2", orange[] = "#d55e00", green[] = "#009e73",
                  purple[] = "#a64d85", grey[] = "#495057";

/* The dots of one strip, between the pixels y0 and y1. */
static void add_dots(struct str *s, const struct series *c, const struct axis *x, double y0,
                     double y1)
{
    struct axis value = {0, 1, y1 - 2, y0 + 2, false, false};
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
        svg_add_fixed(s, axis_place(x, c->x[i]), 1);
        str_add(s, " ");
        svg_add_fixed(s, axis_place(&value, c->y[i]), 1);
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
    svg_add_text(s, PANEL_LEFT, *y + 12, "start", "title", "Where the chains are");
    svg_add_text(s, PANEL_RIGHT, *y + 12, "end", "label",
                 "each variable's range, low to high; a dot is a chain");
    double height = fmin(30, fmax(14, 480 / (double)run->n_names)), top = *y + 24;
    double step = height + 4, bottom = top + (double)run->n_names * step - 4;
    for (size_t d = 0; d < run->n_names; d++) {
        double y0 = top + (double)d * step;
        str_add(s, "<rect fill=\"#f1f3f5\" x=\"%d\" width=\"%d\" y=\"", PANEL_LEFT, PANEL_WIDTH);
        svg_add_fixed(s, y0, 1);
        str_add(s, "\" height=\"");
        svg_add_fixed(s, height, 1);
        str_add(s, "\"/>\n");
        panel_add_name(s, PANEL_LEFT - 8, y0 + height / 2 + 4, "end", run->names[d], NAME_LETTERS);
    }
    panel_add_x_axis(s, x, top, bottom, NULL);
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
    svg_begin_text(s, PANEL_LEFT, 48, "start", "label");
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

static bool is_all_zero(const struct series *c)
{
    for (size_t i = 0; i < c->n; i++)
        if (c->y[i] != 0) return false;
    return true;
}

static lmn_status draw_run(struct str *s, const struct plot_run *run, double *y, struct error *err)
{
    const struct series *c = run->curves, *seconds = &c[PLOT_SECONDS];
    const struct curve losses[] = {
        {&c[PLOT_LOSS_FRESH_BATCH], "fresh batches", blue, .is_faint = true},
        {&c[PLOT_LOSS_REPLAYED_BATCH], "replayed batches", orange, .is_faint = true},
        {&c[PLOT_LOSS_ALL], "all batches", grey, .is_faint = true},
        {&c[PLOT_LOSS_FRESH], "fresh batches", blue, .is_faint = false},
        {&c[PLOT_LOSS_REPLAYED], "replayed batches", orange, .is_faint = false},
    };
    const struct curve shares[] = {
        {&c[PLOT_ACCEPTANCE], "proposals accepted", green, .is_faint = false},
        {&c[PLOT_REUSE], "probability of reuse", purple, .is_faint = false},
    };
    const struct curve errors[] = {
        {&c[PLOT_MAPE], "MAPE", blue, .has_marks = true},
        {&c[PLOT_FLIP], "FLIP", orange, .has_marks = true},
        {&c[PLOT_DSSIM], "DSSIM", green, .has_marks = true},
    };
    const struct panel panels[] = {
        {"Loss", 230, .is_log = true, .curves = losses, .n_curves = 5},
        {"Exploration and reuse", 120, .is_share = true, .curves = shares, .n_curves = 2},
        {"Error on the test set", 160, .is_log = true, .curves = errors, .n_curves = 3},
    };
    struct axis x = {
        fmin(run->first_step, 0), run->last_step, PANEL_LEFT, PANEL_RIGHT, false, false};
    if (run->first_step > 0.5 * run->last_step) x.low = run->first_step; /* a part of a run */
    if (!(x.high > x.low)) x.high = x.low + 1;
    /* A method without chains and reuse has nothing to show of them. */
    const bool explores = !is_all_zero(&c[PLOT_ACCEPTANCE]) || !is_all_zero(&c[PLOT_REUSE]);
    for (size_t i = 0; i < sizeof panels / sizeof *panels; i++) {
        if (panels[i].curves == shares && !explores) continue;
        lmn_status status = panel_add(s, &panels[i], &x, i == 0 ? seconds : NULL, y, err);
        if (status != LMN_OK) return status;
    }
    add_strips(s, run, &x, y);
    return LMN_OK;
}

/* A single run, with its head; s and *y as of plot_compare(). */
static lmn_status plot_one(const char *path, struct str *s, double *y, struct error *err)
{
    lmn_status status = LMN_OK;
    struct plot_run run = {0};
    TRY(plot_run_read(path, &run, err));
    svg_add_text(s, PANEL_LEFT, 28, "start", "head", run.title ? run.title : "Training run");
    add_summary(s, &run);
    *y = TOP;
    TRY(draw_run(s, &run, y, err));
done:
    plot_run_release(&run);
    return status;
}

lmn_status plot_svg(const char *const *paths, uint32_t n_paths, const char *svg_path,
                    struct error *err)
{
    lmn_status status = LMN_OK;
    struct str body = {0};
    double height = 0;
    if (n_paths == 0) return fail(err, LMN_ERR_ARGUMENT, "plot: no runs");
    TRY(n_paths == 1 ? plot_one(paths[0], &body, &height, err)
                     : plot_compare(paths, n_paths, &body, &height, err));
    height -= PANEL_GAP - 34; /* the last panel's labels stay */
    TRY(svg_write_page(&body, PANEL_PAGE_WIDTH, (int)height, svg_path, err));
done:
    str_release(&body);
    return status;
}
