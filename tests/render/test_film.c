/* SPDX-License-Identifier: Apache-2.0 */
/* Splatting: tiles against a plain loop over all pairs of a sample and a pixel, and the noise that
 * it leaves. */
#include <math.h>
#include <stdlib.h>

#include "base/rng.h"
#include "render/film.h"

#include "../image/cmocka_all.h"

enum { WIDTH = 70, HEIGHT = 45, SPP = 4, N_SAMPLES = WIDTH * HEIGHT * SPP };

struct sample {
    uint32_t column, row, half;
    float x, y; /* in the picture */
    struct vec3 radiance;
};

static struct sample *make_samples(void)
{
    struct sample *samples = malloc(N_SAMPLES * sizeof *samples);
    struct rng r = rng_keyed(1, 2, 3);
    assert_non_null(samples);
    for (uint32_t i = 0; i < N_SAMPLES; i++) {
        struct sample *s = &samples[i];
        uint32_t pixel = i / SPP;
        s->column = pixel % WIDTH;
        s->row = pixel / WIDTH;
        s->half = i & 1;
        s->x = (float)s->column + rng_float(&r);
        s->y = (float)s->row + rng_float(&r);
        s->radiance.x = 1.0f;
        s->radiance.y = rng_float(&r);
        s->radiance.z = (float)s->column;
    }
    return samples;
}

/* The window's means by tiles. */
static void by_tiles(const struct sample *samples, const struct filter *f, const struct window *w,
                     struct trace_output *out)
{
    const uint32_t margin = film_margin(f);
    struct film_sum *sums = calloc((size_t)w->width * w->height, sizeof *sums);
    struct film_tile *tile = malloc(sizeof *tile);
    assert_true(sums && tile);
    for (uint32_t y = 0; y < HEIGHT; y += FILM_TILE) {
        for (uint32_t x = 0; x < WIDTH; x += FILM_TILE) {
            film_tile_start(tile, margin, x, y);
            for (uint32_t i = 0; i < N_SAMPLES; i++) {
                const struct sample *at = &samples[i];
                const float dx = at->x - ((float)at->column + 0.5f),
                            dy = at->y - ((float)at->row + 0.5f);
                struct film_weights weights;
                if (at->column - x >= FILM_TILE || at->row - y >= FILM_TILE) continue;
                film_weigh(&weights, f, margin, 1, &dx, &dy);
                film_tile_add(tile, margin, &weights, 0, at->column, at->row, at->half,
                              at->radiance);
            }
            film_add(sums, w, tile, margin);
        }
    }
    film_store(sums, w, w, out);
    free(sums);
    free(tile);
}

/* One pixel's mean over the samples of the halves in `halves`. */
static double by_hand(const struct sample *samples, const struct filter *f, uint32_t x, uint32_t y,
                      unsigned halves)
{
    double sum = 0, weights = 0;
    for (uint32_t i = 0; i < N_SAMPLES; i++) {
        const struct sample *at = &samples[i];
        if (!(halves >> at->half & 1)) continue;
        double weight = (double)filter_eval(f, at->x - ((float)x + 0.5f)) *
                        (double)filter_eval(f, at->y - ((float)y + 0.5f));
        sum += weight * (double)samples[i].radiance.y;
        weights += weight;
    }
    return sum / weights;
}

static const struct {
    enum filter_kind kind;
    float radius, stddev;
    uint32_t margin;
} cases[] = {
    {FILTER_BOX, 0.5f, 0, 0},      {FILTER_TENT, 1, 0, 1},     {FILTER_TENT, 2.2f, 0, 2},
    {FILTER_GAUSSIAN, 2, 0.5f, 2}, {FILTER_TENT, 4.5f, 0, 4},  {FILTER_TENT, 4.6f, 0, 0},
    {FILTER_TENT, 0.5f, 0, 0},     {FILTER_GAUSSIAN, 1, 1, 1},
};

static void weighted_means(void **state)
{
    (void)state;
    struct sample *samples = make_samples();
    const struct window w = {WIDTH, HEIGHT, 3, 20, 60, 25};
    float *rgb = malloc(3 * sizeof *rgb * 3 * 60 * 25);
    struct trace_output out = {
        .color = rgb, .half_a = rgb + 3 * 60 * 25, .half_b = rgb + 6 * 60 * 25};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct filter f;
        filter_init(&f, cases[k].kind, cases[k].radius, cases[k].stddev);
        assert_int_equal(film_margin(&f), cases[k].margin);
        if (cases[k].margin == 0) continue;
        by_tiles(samples, &f, &w, &out);
        for (uint32_t i = 0; i < 60 * 25; i += 7) {
            const float *parts[] = {out.half_a, out.half_b, out.color};
            for (unsigned halves = 1; halves <= 3; halves++) {
                const float *pixel = parts[halves - 1] + 3 * i;
                double want = by_hand(samples, &f, 3 + i % 60, 20 + i / 60, halves);
                if (fabs((double)pixel[1] - want) > 2e-4)
                    fail_msg("case %zu, pixel %u, half %u: %g, not %g", k, i, halves,
                             (double)pixel[1], want);
                assert_true(fabsf(pixel[0] - 1.0f) < 1e-5f);
            }
        }
    }
    free(rgb);
    free(samples);
}

/* Of a tent of radius 1: (integral of the square)^2 = 4/9 of what samples for one pixel leave. */
static void less_noise(void **state)
{
    (void)state;
    struct sample *samples = make_samples();
    const struct window w = {WIDTH, HEIGHT, 2, 2, WIDTH - 4, HEIGHT - 4};
    const size_t n = (size_t)w.width * w.height;
    float *rgb = malloc(3 * sizeof *rgb * n);
    struct trace_output out = {.color = rgb};
    struct filter f;
    filter_init(&f, FILTER_TENT, 1, 0);
    by_tiles(samples, &f, &w, &out);
    double sum = 0;
    for (size_t i = 0; i < n; i++) sum += pow((double)rgb[3 * i + 1] - 0.5, 2);
    double ratio = sum / (double)n / (1.0 / 12 / SPP);
    if (!(ratio > 0.4 && ratio < 0.56)) fail_msg("variance: %g of a pixel's own samples", ratio);
    free(rgb);
    free(samples);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weighted_means),
        cmocka_unit_test(less_noise),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
