/* SPDX-License-Identifier: Apache-2.0 */
#include "image/draw.h"

#include <string.h>

#include "image/metrics.h"

/* ---- Text --------------------------------------------------------------------------------- */

/* The font, drawn for this program: characters 32 to 126, 5 x 9 pixels each. Row r is the five bits
 * from 5 r on, its left pixel the highest of them; rows 0 to 6 stand on the base line, 7 and 8 hang
 * below. */
enum { GLYPH_COLUMNS = 5, GLYPH_ROWS = 9, GLYPH_TOP = 2, FIRST = 32, LAST = 126 };

/* clang-format off */
static const uint64_t font[LAST - FIRST + 1] = {
    0x000000000000, 0x000100421084, 0x00000000294a, 0x000295f57d4a, /* space ! " # */
    0x00013c5751e4, 0x0000e6820b38, 0x00036554524c, 0x000000002084, /* $ % & ' */
    0x000088842082, 0x000208210888, 0x000009575480, 0x0000084f9080, /* ( ) * + */
    0x082318000000, 0x000000070000, 0x000318000000, 0x000420820821, /* , - . / */
    0x0003a39ace2e, 0x0007c8425184, 0x0007d041062e, 0x0003a213062e, /* 0 1 2 3 */
    0x000085f928c2, 0x0003a210fa1f, 0x0003a31f4106, 0x00010841083f, /* 4 5 6 7 */
    0x0003a317462e, 0x00030417c62e, 0x000318063000, 0x082318063000, /* 8 9 : ; */
    0x000044441041, 0x000001f07c00, 0x000410411110, 0x00010041062e, /* < = > ? */
    0x0003e17ade2e, 0x000463f8c544, 0x0007a31f463e, 0x0003a308422e, /* @ A B C */
    0x0007a318c63e, 0x0007e10f421f, 0x0004210f421f, 0x0003a31bc22e, /* D E F G */
    0x0004631fc631, 0x00038842108e, 0x000324210847, 0x0004654c5251, /* H I J K */
    0x0007e1084210, 0x0004631ad771, 0x0004673ae731, 0x0003a318c62e, /* L M N O */
    0x0004210f463e, 0x00036558c62e, 0x0004654f463e, 0x00078217420f, /* P Q R S */
    0x00010842109f, 0x0003a318c631, 0x000114a8c631, 0x0004775ac631, /* T U V W */
    0x000462a22a31, 0x000108422a31, 0x0007e082083f, 0x00039084210e, /* X Y Z [ */
    0x000042222210, 0x00038421084e, 0x000000004544, 0x00f800000000, /* backslash ] ^ _ */
    0x000000000888, 0x0003e2f0b800, 0x0007a318fa10, 0x0003a308b800, /* ` a b c */
    0x0003e318bc21, 0x0003a1f8b800, 0x0002108f2126, 0x0e0be318bc00, /* d e f g */
    0x0004631cda10, 0x000388423004, 0x0c9084211802, 0x0004a98a4a10, /* h i j k */
    0x00038842108c, 0x00046b5ae800, 0x0004631cd800, 0x0003a318b800, /* l m n o */
    0x1087a318f800, 0x010be318bc00, 0x0004210cd800, 0x000782e83c00, /* p q r s */
    0x000192847908, 0x00036718c400, 0x00011518c400, 0x0002ab58c400, /* t u v w */
    0x000454454400, 0x0e0be318c400, 0x0007d0417c00, 0x0000c8441083, /* x y z { */
    0x002108421084, 0x000608411098, 0x0000002aa000, /* | } ~ */
};
/* clang-format on */

static uint64_t glyph_of(const char **text)
{
    unsigned char c = (unsigned char)*(*text)++;
    if (c < 0x80) return c >= FIRST && c <= LAST ? font[c - FIRST] : font['?' - FIRST];
    while (((unsigned char)**text & 0xC0) == 0x80)
        ++*text; /* one mark for a character, not a byte */
    return font['?' - FIRST];
}

/* Fills a rectangle, clipped. */
static void fill(struct image *im, int64_t x, int64_t y, int64_t w, int64_t h, const float rgb[3])
{
    int64_t x1 = x + w < im->width ? x + w : im->width, x0 = x > 0 ? x : 0;
    int64_t y1 = y + h < im->height ? y + h : im->height, y0 = y > 0 ? y : 0;
    uint32_t n = im->n_channels < 3 ? im->n_channels : 3;
    for (int64_t j = y0; j < y1; j++)
        for (int64_t i = x0; i < x1; i++)
            for (uint32_t c = 0; c < n; c++)
                im->data[((size_t)j * im->width + (size_t)i) * im->n_channels + c] = rgb[c];
}

static void draw_scaled_text(struct image *im, int64_t x, int64_t y, int scale, const char *text,
                             const float rgb[3])
{
    for (; *text; x += DRAW_GLYPH_WIDTH * scale) {
        uint64_t glyph = glyph_of(&text);
        for (int row = 0; row < GLYPH_ROWS; row++)
            for (int col = 0; col < GLYPH_COLUMNS; col++)
                if (glyph >> (GLYPH_COLUMNS * row + GLYPH_COLUMNS - 1 - col) & 1)
                    fill(im, x + col * scale, y + (row + GLYPH_TOP) * scale, scale, scale, rgb);
    }
}

void draw_text(struct image *im, int x, int y, const char *text, const float rgb[3])
{
    draw_scaled_text(im, x, y, 1, text, rgb);
}

/* ---- Images ------------------------------------------------------------------------------- */

static float clamp01(double v)
{
    return v > 0 ? (v < 1 ? (float)v : 1) : 0;
}

/* Each pixel of src becomes scale x scale pixels. */
static void draw_scaled_image(struct image *im, int64_t x, int64_t y, int scale,
                              const struct image *src, double exposure)
{
    int c[3] = {image_channel(src, "R"), image_channel(src, "G"), image_channel(src, "B")};
    if (c[0] < 0 || c[1] < 0 || c[2] < 0) c[0] = c[1] = c[2] = 0; /* grey */
    for (uint32_t j = 0; j < src->height; j++) {
        for (uint32_t i = 0; i < src->width; i++) {
            const float *from = src->data + ((size_t)j * src->width + i) * src->n_channels;
            float rgb[3];
            for (int k = 0; k < 3; k++) rgb[k] = clamp01((double)from[c[k]] * exposure);
            fill(im, x + (int64_t)i * scale, y + (int64_t)j * scale, scale, scale, rgb);
        }
    }
}

void draw_image(struct image *im, int x, int y, const struct image *src, double exposure)
{
    draw_scaled_image(im, x, y, 1, src, exposure);
}

/* ---- The contact sheet -------------------------------------------------------------------- */

enum {
    MARGIN = 20,       /* around everything */
    GAP = 8,           /* between columns */
    CAPTION_GAP = 5,   /* between pictures and their caption */
    ROW_GAP = 16,      /* between a caption and the next pictures */
    LINE_HEIGHT = 14,  /* of a caption */
    CAPTION_LINES = 4, /* at most */
    HEADING_SCALE = 2,
    HEADING_HEIGHT = DRAW_GLYPH_HEIGHT * HEADING_SCALE + 8,
    BAR_HEIGHT = 8,      /* the scale of the error's colours */
    SMALL_PICTURE = 256, /* narrower pictures are enlarged up to this */
};

/* Linear values of the sRGB greys 0x17, 0xF0 and 0xA8. */
static const float background[3] = {0.0086f, 0.0086f, 0.0091f};
static const float bright[3] = {0.8714f, 0.8714f, 0.8714f}, dim[3] = {0.3916f, 0.3916f, 0.3916f};

struct layout {
    int scale;             /* of the pictures */
    uint32_t column_width; /* pixels */
    uint32_t width;        /* of the sheet */
    uint32_t n_letters;    /* that fit in a line */
};

/* How many of the text's letters go on the line that starts there: up to a newline, or else up to
 * the last gap that fits. Two spaces are a better gap than one, which may part a name from its
 * value. */
static size_t line_length(const char *text, size_t n_letters)
{
    size_t n = strcspn(text, "\n"), gap = 0;
    if (n <= n_letters) return n;
    for (size_t i = n_letters; i > n_letters / 2; i--) {
        if (text[i] != ' ') continue;
        if (text[i - 1] == ' ' || text[i + 1] == ' ') return i;
        if (gap == 0) gap = i;
    }
    return gap ? gap : n_letters;
}

/* Draws the caption when im is not NULL. Returns how many lines it takes. */
static uint32_t draw_caption(struct image *im, int64_t y, const struct layout *l, const char *text)
{
    uint32_t n_lines = 0;
    char line[IMAGE_MAX_SIDE / DRAW_GLYPH_WIDTH + 1];
    while (*text == ' ') text++;
    while (*text && n_lines < CAPTION_LINES) {
        size_t n = line_length(text, l->n_letters);
        memcpy(line, text, n);
        line[n] = '\0';
        text += n + (text[n] == '\n');
        while (*text == ' ') text++;
        n_lines++;
        if (*text && n_lines == CAPTION_LINES && n >= 3) memcpy(line + n - 3, "...", 3);
        if (im)
            draw_scaled_text(im, MARGIN, y + (n_lines - 1) * LINE_HEIGHT, 1, line,
                             n_lines == 1 ? bright : dim);
    }
    return n_lines;
}

/* The colours of errors 0 to 1, under a column. */
static void draw_scale(struct image *im, int64_t y, uint32_t column, const struct layout *l)
{
    int64_t x0 = MARGIN + column * ((int64_t)l->column_width + GAP) + 2 * DRAW_GLYPH_WIDTH;
    int64_t w = (int64_t)l->column_width - 4 * DRAW_GLYPH_WIDTH;
    for (int64_t i = 0; i < w; i++) {
        float rgb[3];
        metrics_magma(((float)i + 0.5f) / (float)w, rgb);
        fill(im, x0 + i, y, 1, BAR_HEIGHT, rgb);
    }
    draw_scaled_text(im, x0 - 2 * DRAW_GLYPH_WIDTH, y - 2, 1, "0", dim);
    draw_scaled_text(im, x0 + w + DRAW_GLYPH_WIDTH, y - 2, 1, "1", dim);
}

static void draw_heading(struct image *im, const struct layout *l, uint32_t column,
                         const char *text)
{
    char line[IMAGE_MAX_SIDE / DRAW_GLYPH_WIDTH + 1];
    int scale = HEADING_SCALE;
    size_t n = strlen(text), room = l->column_width / DRAW_GLYPH_WIDTH;
    if (n * DRAW_GLYPH_WIDTH * (size_t)scale > l->column_width) scale = 1;
    if (n > room) n = room;
    memcpy(line, text, n);
    line[n] = '\0';
    int64_t x = MARGIN + column * ((int64_t)l->column_width + GAP);
    int64_t y = MARGIN + DRAW_GLYPH_HEIGHT * (HEADING_SCALE - scale);
    draw_scaled_text(im, x, y, scale, line, bright);
}

/* The widest picture; fails when those of a row differ in size. */
static lmn_status check_sizes(const struct draw_sheet *s, uint32_t *widest, struct error *err)
{
    *widest = 1;
    for (uint32_t r = 0; r < s->n_rows; r++) {
        const struct image *const *images = s->rows[r].images;
        for (uint32_t c = 0; c < s->n_columns; c++) {
            if (images[c]->width != images[0]->width || images[c]->height != images[0]->height)
                return fail(err, LMN_ERR_ARGUMENT,
                            "row %u of the sheet has images of different sizes", r);
            if (images[c]->width > *widest) *widest = images[c]->width;
        }
    }
    return LMN_OK;
}

lmn_status draw_sheet(const struct draw_sheet *s, struct image *out, struct error *err)
{
    struct layout l = {.scale = 1, .column_width = 32};
    uint32_t widest;
    *out = (struct image){0};
    lmn_status status = check_sizes(s, &widest, err);
    if (status != LMN_OK) return status;
    if (widest < SMALL_PICTURE) l.scale = (int)(SMALL_PICTURE / widest);
    if ((uint64_t)widest * (uint64_t)l.scale > l.column_width)
        l.column_width = widest * (uint32_t)l.scale;
    const uint64_t step = (uint64_t)l.column_width + GAP;
    const uint64_t width = 2 * MARGIN + s->n_columns * step - (s->n_columns > 0 ? GAP : 0);
    l.width = width <= IMAGE_MAX_SIDE ? (uint32_t)width : 0;
    l.n_letters = l.width > 2 * MARGIN ? (l.width - 2 * MARGIN) / DRAW_GLYPH_WIDTH : 0;

    uint64_t height = MARGIN + HEADING_HEIGHT + BAR_HEIGHT + MARGIN;
    for (uint32_t r = 0; r < s->n_rows && l.n_letters > 0; r++)
        height += (uint64_t)s->rows[r].images[0]->height * (uint64_t)l.scale + CAPTION_GAP +
                  draw_caption(NULL, 0, &l, s->rows[r].caption) * LINE_HEIGHT + ROW_GAP;
    if (l.n_letters == 0 || height > IMAGE_MAX_SIDE)
        return fail(err, LMN_ERR_ARGUMENT, "a contact sheet of %llux%llu pixels is too large",
                    (unsigned long long)width, (unsigned long long)height);
    status = image_init(out, l.width, (uint32_t)height, 3, NULL, err);
    if (status != LMN_OK) return status;

    fill(out, 0, 0, l.width, (int64_t)height, background);
    for (uint32_t c = 0; c < s->n_columns; c++) draw_heading(out, &l, c, s->headings[c]);
    int64_t y = MARGIN + HEADING_HEIGHT;
    for (uint32_t r = 0; r < s->n_rows; r++) {
        const struct draw_sheet_row *row = &s->rows[r];
        for (uint32_t c = 0; c < s->n_columns; c++)
            draw_scaled_image(out, MARGIN + (int64_t)(c * step), y, l.scale, row->images[c],
                              c < s->n_pictures ? row->exposure : 1);
        y += (int64_t)row->images[0]->height * l.scale + CAPTION_GAP;
        y += draw_caption(out, y, &l, row->caption) * LINE_HEIGHT + ROW_GAP;
    }
    if (s->n_pictures < s->n_columns) draw_scale(out, y, s->n_pictures, &l);
    return LMN_OK;
}
