/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_PLOT_PANEL_H
#define TRAIN_PLOT_PANEL_H

#include <stdbool.h>
#include <stddef.h>

#include "base/error.h"
#include "base/str.h"
#include "train/plot_data.h"

/* Panels of a plot: they lie under each other and share the horizontal axis. All in pixels. */
enum {
    PANEL_PAGE_WIDTH = 960,
    PANEL_LEFT = 150, /* room for the names of variables */
    PANEL_WIDTH = 780,
    PANEL_RIGHT = PANEL_LEFT + PANEL_WIDTH,
    PANEL_GAP = 54,
};

/* Maps values low..high to pixels at0..at1; logarithms when is_log. */
struct axis {
    double low, high, at0, at1;
    bool is_log;
    bool is_time; /* of a horizontal axis: seconds, not steps; only these may be logarithmic */
};

double axis_place(const struct axis *a, double v);

struct curve {
    const struct series *points;
    const char *name, *color;
    bool is_faint; /* noise behind a clearer curve of the same name, when that has points */
    bool has_marks;
    const char *dashes;              /* SVG's stroke-dasharray; NULL is a whole line */
    const struct series *low, *high; /* a band around it, over the same x; NULL: none */
};

struct panel {
    const char *title;
    double height;
    bool is_log, is_share; /* is_share: from 0 to 1 */
    bool has_no_legend;
    const struct curve *curves;
    size_t n_curves;
};

/* Draws a panel with its title and legend above it, from *y down, and moves *y below it; nothing
 * when no curve has points. Curves are thinned. seconds (may be NULL): of training by a step, shown
 * above the panel. */
lmn_status panel_add(struct str *s, const struct panel *panel, const struct axis *x,
                     const struct series *seconds, double *y, struct error *err);

/* Vertical lines over a panel from top to bottom, labels under it, and above it the seconds. */
void panel_add_x_axis(struct str *s, const struct axis *x, double top, double bottom,
                      const struct series *seconds);

/* A text of class "label" that loses its middle when it has more than max_letters, up to 64. */
void panel_add_name(struct str *s, double x, double y, const char *anchor, const char *name,
                    size_t max_letters);

#endif
