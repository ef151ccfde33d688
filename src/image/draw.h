/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_DRAW_H
#define IMAGE_DRAW_H

#include "image/image.h"

/*
 * Small drawing services for contact sheets: text with a built-in bitmap font, and copying with a
 * tone curve. Colours are linear; sheets are saved with exposure 1. Everything is clipped to the
 * image.
 */

enum { DRAW_GLYPH_WIDTH = 6, DRAW_GLYPH_HEIGHT = 12 };

/* Writes a line of ASCII with its top left corner at (x, y); other characters become question
 * marks. */
void draw_text(struct image *im, int x, int y, const char *text, const float rgb[3]);

/* Copies the RGB (or the first channel as grey) of `src` times exposure, clamped to [0,1], to (x,
 * y). */
void draw_image(struct image *im, int x, int y, const struct image *src, double exposure);

struct draw_sheet_row {
    const struct image *const *images; /* [n_columns], of equal sizes */
    double exposure;                   /* of the pictures */
    const char *caption; /* "MAPE 0.05  FLIP 0.07\nroughness=0.1": wrapped, four lines at most */
};

struct draw_sheet {
    const struct draw_sheet_row *rows; /* [n_rows] */
    uint32_t n_rows, n_columns;
    uint32_t n_pictures;         /* the first columns; the others are maps of errors in colour */
    const char *const *headings; /* [n_columns]; cut where a column ends */
};

/* The contact sheet: columns under headings, a row and its caption per configuration, the scale of
 * the errors' colours at the bottom. Small pictures are enlarged. *out is initialised here. */
lmn_status draw_sheet(const struct draw_sheet *sheet, struct image *out, struct error *err);

#endif
