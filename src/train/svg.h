/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_SVG_H
#define TRAIN_SVG_H

#include "base/error.h"
#include "base/str.h"

/* Pieces of SVG and the numbers in them, appended to a text. Numbers do not depend on the locale.
 */

/* v with so many decimals; beyond 1e12 it stays there. */
void svg_add_fixed(struct str *s, double v, int decimals);

/* A step of an axis that ends at `high`: 2500, 20k, 1.5M. */
void svg_add_count(struct str *s, double v, double high);

/* 1.5 s, 12 s, 4.5 min, 23 h. */
void svg_add_duration(struct str *s, double seconds);

/* Text as XML wants it. */
void svg_add_escaped(struct str *s, const char *text);

/* A <text> element at (x, y). anchor: "start", "middle" or "end"; css: its class. The first leaves
 * it open for what follows. */
void svg_begin_text(struct str *s, double x, double y, const char *anchor, const char *css);
void svg_add_text(struct str *s, double x, double y, const char *anchor, const char *css,
                  const char *text);

void svg_add_line(struct str *s, double x0, double y0, double x1, double y1, const char *css);

/* The page: a head with the classes above ("head", "title", "label", "tick", "grid", "axis") and
 * the body, written to path, "-" for standard output. */
lmn_status svg_write_page(const struct str *body, int width, int height, const char *path,
                          struct error *err);

#endif
