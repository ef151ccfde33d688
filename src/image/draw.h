/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_DRAW_H
#define IMAGE_DRAW_H

#include "image/image.h"

/* Small drawing services for contact sheets: text with a built-in bitmap font, and copying with a
 * tone curve. Colours are linear; sheets are saved with exposure 1. */

enum { DRAW_GLYPH_WIDTH = 6, DRAW_GLYPH_HEIGHT = 12 };

/* Writes ASCII text with its top left corner at (x, y), clipped. */
void draw_text(struct image *im, int x, int y, const char *text, const float rgb[3]);

/* Copies the RGB of `src` times exposure, clamped to [0,1], to (x, y), clipped. */
void draw_image(struct image *im, int x, int y, const struct image *src, double exposure);

struct draw_sheet_row {
    const struct image *neural, *reference, *error; /* equal sizes */
    double exposure;                                /* for the first two */
    const char *caption;                            /* "MAPE 0.05  FLIP 0.07  roughness=0.1" */
};

/* The contact sheet: heading columns, one row per configuration. */
lmn_status draw_sheet(const struct draw_sheet_row *rows, uint32_t n_rows,
                      const char *const headings[3], struct image *out, struct error *err);

#endif
