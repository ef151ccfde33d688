/* SPDX-License-Identifier: Apache-2.0 */
#include "image/draw.h"

#include <math.h>
#include <string.h>

#include "cmocka_all.h"

static const float white[3] = {1, 1, 1};

static struct image blank(uint32_t w, uint32_t h)
{
    struct image im;
    assert_int_equal(image_init(&im, w, h, 3, NULL, NULL), LMN_OK);
    return im;
}

static uint32_t count_lit(const struct image *im)
{
    uint32_t n = 0;
    for (size_t i = 0; i < (size_t)im->width * im->height; i++) n += im->data[3 * i] > 0.5f;
    return n;
}

/* Every printable character has a shape of its own, inside its cell. */
static void test_font(void **state)
{
    (void)state;
    struct image cells[127];
    for (int c = 33; c < 127; c++) {
        cells[c] = blank(DRAW_GLYPH_WIDTH + 4, DRAW_GLYPH_HEIGHT + 4);
        draw_text(&cells[c], 2, 2, (char[]){(char)c, 0}, white);
        struct image *im = &cells[c];
        assert_in_range(count_lit(im), 3, 30);
        for (uint32_t y = 0; y < im->height; y++)
            for (uint32_t x = 0; x < im->width; x++)
                if (im->data[3 * (y * im->width + x)] > 0)
                    assert_true(x >= 2 && x < 2 + DRAW_GLYPH_WIDTH - 1 && y >= 2 &&
                                y < 2 + DRAW_GLYPH_HEIGHT);
        for (int d = 33; d < c; d++)
            assert_memory_not_equal(im->data, cells[d].data,
                                    3 * sizeof(float) * im->width * im->height);
    }
    for (int c = 33; c < 127; c++) image_release(&cells[c]);
}

static void test_clipping(void **state)
{
    (void)state;
    struct image im = blank(9, 7), whole = blank(60, 40), single;
    assert_int_equal(image_init(&single, 9, 7, 1, NULL, NULL), LMN_OK);
    for (int y = -20; y < 20; y += 3)
        for (int x = -30; x < 30; x += 3) {
            draw_text(&im, x, y, "Ag\xc3\xa9#", white);
            draw_text(&single, x, y, "Ag", white);
            draw_image(&im, x, y, &whole, 1);
        }
    draw_text(&im, 2147483647, -2147483647, "far away", white);
    draw_text(&whole, 0, 0, "\xc3\xa9", white); /* one mark, not two */
    uint32_t n = count_lit(&whole);
    draw_text(&whole, 0, 20, "?", white);
    assert_int_equal(count_lit(&whole), 2 * n);
    image_release(&im);
    image_release(&whole);
    image_release(&single);
}

static void test_tone(void **state)
{
    (void)state;
    struct image im = blank(4, 1), src = blank(3, 1);
    src.data[0] = 0.25f;
    src.data[3] = NAN;
    src.data[6] = -1;
    draw_image(&im, 1, 0, &src, 2);
    assert_true(im.data[3] == 0.5f && im.data[6] == 0 && im.data[9] == 0 && im.data[0] == 0);
    image_release(&im);
    image_release(&src);
}

static void test_sheet(void **state)
{
    (void)state;
    static const char *const headings[3] = {"neural", "path traced", "FLIP, a very long heading"};
    struct image a = blank(20, 30), b = blank(20, 30), e = blank(20, 30), wrong = blank(21, 30),
                 out;
    char long_caption[3000];
    struct error err = {0};
    memset(long_caption, 'x', sizeof long_caption);
    long_caption[sizeof long_caption - 1] = '\0';
    const struct image *columns[] = {&a, &b, &e}, *others[] = {&a, &b, &e};
    const struct draw_sheet_row rows[] = {
        {columns, 1, "MAPE 0.05\nroughness=0.1"}, {others, 2, ""}, {columns, 1, long_caption}};
    struct draw_sheet sheet = {rows, 3, 3, 2, headings};
    assert_int_equal(draw_sheet(&sheet, &out, &err), LMN_OK);
    assert_true(out.width > 60 && out.height > 90 && out.n_channels == 3);
    /* nothing is written in the margins */
    for (uint32_t y = 0; y < out.height; y++)
        assert_true(out.data[3 * (size_t)y * out.width] < 0.1f &&
                    out.data[3 * ((size_t)y * out.width + out.width - 2)] < 0.1f);
    image_release(&out);
    others[2] = &wrong;
    assert_int_equal(draw_sheet(&sheet, &out, &err), LMN_ERR_ARGUMENT);
    assert_null(out.data);
    sheet.n_rows = 1;
    sheet.n_columns = 1;
    assert_int_equal(draw_sheet(&sheet, &out, &err), LMN_OK); /* no map, no scale of errors */
    image_release(&out);
    sheet.n_columns = 1u << 31;
    sheet.n_rows = 0;
    assert_int_equal(draw_sheet(&sheet, &out, &err), LMN_ERR_ARGUMENT);
    image_release(&a);
    image_release(&b);
    image_release(&e);
    image_release(&wrong);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_font),
        cmocka_unit_test(test_clipping),
        cmocka_unit_test(test_tone),
        cmocka_unit_test(test_sheet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
