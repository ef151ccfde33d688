/* SPDX-License-Identifier: Apache-2.0 */
/* Pixels that go to caustics: under a ball of glass. */
#include "train/guide.h"

#include <math.h>
#include <string.h>

#include "tiny.h"

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

enum { WIDTH = 640, HEIGHT = 427, N = 4000, PHOTONS = 64 };

/* N pixels of the picture with a smooth ball or none, before and after guiding with a seed. */
static struct guide guide(bool has_ball, uint64_t seed, struct pixel_at before[N],
                          struct pixel_at after[N])
{
    const float u[3] = {0.0f, 0.5f, has_ball ? 0.75f : 0.25f};
    struct trace_settings t;
    struct error err = {{0}};
    struct view *view;
    struct guide g;
    struct rng r = rng_keyed(1, seed, 0);
    for (uint32_t i = 0; i < N; i++)
        before[i] = (struct pixel_at){rng_below(&r, WIDTH), rng_below(&r, HEIGHT)};
    memcpy(after, before, N * sizeof *after);
    assert_int_equal(view_new(tiny.place.world, &view, &err), LMN_OK);
    assert_int_equal(guide_init(&g, PHOTONS, &err), LMN_OK);
    view_set(view, u);
    trace_settings_init(&t, tiny.scene);
    t.seed = seed;
    t.max_depth = 8;
    guide_pixels(&g, view, &t, WIDTH, HEIGHT, &r, after, N);
    view_free(view);
    return g;
}

static bool is_moved(const struct pixel_at *a, const struct pixel_at *b)
{
    return a->x != b->x || a->y != b->y;
}

/* Is one of a guide's first n photons near? */
static bool is_near(const struct guide *g, uint32_t n, const struct pixel_at *p)
{
    for (uint32_t k = 0; k < n; k++)
        if (fabsf(g->x[k] - (float)p->x) < 10 && fabsf(g->y[k] - (float)p->y) < 10) return true;
    return false;
}

static void pixels_go_to_caustics(void **state)
{
    static struct pixel_at before[N], after[N], other_before[N], other_after[N];
    enum { SOME = 8 }; /* photons that have surely been found */
    (void)state;
    struct guide g = guide(true, 1, before, after),
                 other = guide(true, 2, other_before, other_after);
    uint32_t n_moved = 0, n_near = 0, n_before = 0;
    for (uint32_t i = 0; i < N; i++) {
        assert_true(after[i].x < WIDTH && after[i].y < HEIGHT);
        n_before += is_near(&other, SOME, &before[i]);
        if (!is_moved(&before[i], &after[i])) continue;
        n_moved++;
        n_near += is_near(&other, SOME, &after[i]); /* other photons know the place too */
    }
    if (!(n_moved > N / 50 && (double)n_moved < 1.1 * (double)GUIDE_SHARE * N))
        fail_msg("%u of %d moved", n_moved, N);
    const double now = (double)n_near / n_moved, was = (double)n_before / N;
    if (!(now > 3 * was)) fail_msg("%.3f of the moved near other photons, of all %.3f", now, was);

    /* No place is much denser than it may be. */
    double most = 0;
    for (uint32_t k = 0; k < N; k++) {
        uint32_t n = 0;
        if (!is_moved(&before[k], &after[k])) continue;
        for (uint32_t i = 0; i < N; i++)
            n += is_moved(&before[i], &after[i]) &&
                 fabsf((float)after[i].x - (float)after[k].x) < 10 &&
                 fabsf((float)after[i].y - (float)after[k].y) < 10;
        most = fmax(most, n / (N * 400.0 / (WIDTH * HEIGHT)));
    }
    if (!(most > 1 && most < 2 * (double)GUIDE_MOST)) fail_msg("%.1f times as dense", most);
    guide_release(&g);
    guide_release(&other);
}

static void nothing_moves_without_caustics(void **state)
{
    static struct pixel_at before[N], after[N];
    (void)state;
    struct guide g = guide(false, 1, before, after);
    assert_memory_equal(before, after, sizeof before);
    guide_release(&g);
}

static void seeds_decide(void **state)
{
    static struct pixel_at before[N], after[3][N];
    (void)state;
    for (uint32_t k = 0; k < 3; k++) {
        struct guide g = guide(true, 1 + k / 2, before, after[k]);
        guide_release(&g);
    }
    assert_memory_equal(after[0], after[1], sizeof before);
    assert_memory_not_equal(after[0], after[2], sizeof before);
}

static int setup(void **state)
{
    const int status = tiny_setup(state);
    tiny_edit(&tiny, "roughconductor", "roughdielectric");
    return status;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_go_to_caustics),
        cmocka_unit_test(nothing_moves_without_caustics),
        cmocka_unit_test(seeds_decide),
    };
    return cmocka_run_group_tests(tests, setup, tiny_teardown);
}
