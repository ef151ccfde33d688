/* SPDX-License-Identifier: Apache-2.0 */
/* Layers and grids of BF16 factors: the plain ones against sums in doubles and grids of floats, the
 * fast ones against the same. */
#include "nn/rounded.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "base/rng.h"
#include "toy.h"

enum { ROWS = 36, MOST = 200, PANEL = NN_ROUNDED_PANEL, PANELS = (MOST + PANEL - 1) / PANEL };
#define STRIDE ((size_t)(ROWS + 1) * PANEL)

struct layer {
    uint32_t n_out, n_in;
    bool linear;
    float *x, *w, *b, *packed; /* tile of floats, [n_out][n_in + 2], [PANELS][PANEL] */
    float *pairs;              /* tile of what x rounds to, and of NAN where nobody may look */
};

static double feature_of(const float *pairs, uint32_t k)
{
    uint32_t bits;
    float x;
    memcpy(&bits, pairs + k / 2, sizeof bits);
    bits = k % 2 ? bits & 0xFFFF0000u : bits << 16;
    memcpy(&x, &bits, sizeof x);
    return (double)x;
}

static struct layer layer_new(uint32_t n_out, uint32_t n_in, bool linear)
{
    struct layer l = {.n_out = n_out, .n_in = n_in, .linear = linear};
    l.x = toy_take(PANELS * STRIDE, sizeof(float));
    l.w = toy_take((size_t)n_out * (n_in + 2), sizeof(float));
    l.b = toy_take(PANELS * PANEL, sizeof(float));
    l.packed = toy_take(PANELS * nn_rounded_count(n_in), sizeof(float));
    toy_fill(l.x, PANELS * STRIDE, n_in);
    toy_fill(l.w, (size_t)n_out * (n_in + 2), n_out);
    toy_fill(l.b, PANELS * PANEL, 3);
    l.pairs = toy_take(PANELS * STRIDE, sizeof(float));
    for (size_t k = 0; k < PANELS * STRIDE; k++) l.pairs[k] = NAN;
    for (uint32_t k = 0; k < n_in; k += PANEL)
        for (size_t r = 0; r < ROWS; r++) {
            const size_t at = k / PANEL * STRIDE + r * PANEL;
            const uint32_t n = n_in - k < PANEL ? n_in - k : PANEL;
            nn_rounded_pack_pairs(l.pairs + at, l.x + at, (n + 1) / 2);
        }
    for (uint32_t i = 0; i < (n_out + PANEL - 1) / PANEL; i++)
        nn_rounded_pack(l.packed + i * nn_rounded_count(n_in), l.w, n_in + 2, n_out, n_in, i);
    return l;
}

static void layer_free(struct layer *l)
{
    mem_free(l->x);
    mem_free(l->w);
    mem_free(l->b);
    mem_free(l->packed);
    mem_free(l->pairs);
}

static void run(const struct nn_rounded *kernels, const struct layer *l, float *y)
{
    const struct nn_forward a = {.n_rows = ROWS,
                                 .n_out = l->n_out,
                                 .n_in = l->n_in,
                                 .x = l->pairs,
                                 .w = l->packed,
                                 .b = l->b,
                                 .y = y,
                                 .stride = STRIDE,
                                 .linear = l->linear};
    kernels->forward(&a);
}

static double exact(const struct layer *l, size_t r, uint32_t o, double *size)
{
    double sum = (double)l->b[o];
    *size = fabs(sum);
    for (uint32_t k = 0; k < l->n_in; k++) {
        const float x = l->x[k / PANEL * STRIDE + r * PANEL + k % PANEL];
        const double term = (double)nn_round(x) *
                            (double)nn_round(l->w[(size_t)o * (l->n_in + 2) + k]);
        sum += term;
        *size += fabs(term);
    }
    return l->linear || sum > 0 ? sum : sum * (double)NN_SLOPE;
}

static void compare(const struct nn_rounded *kernels)
{
    static const uint32_t sizes[][2] = {{64, 64}, {64, 61},    {1, 1},     {7, 2},
                                        {16, 3},  {33, 64},    {48, 128},  {64, 97},
                                        {65, 63}, {MOST, 130}, {128, MOST}};
    for (size_t s = 0; s < 2 * (sizeof sizes / sizeof *sizes); s++) {
        const uint32_t *size = sizes[s / 2];
        struct layer l = layer_new(size[0], size[1], s % 2 != 0);
        float *y = toy_take(PANELS * STRIDE, sizeof *y);
        run(kernels, &l, y);
        for (size_t r = 0; r < ROWS; r++)
            for (uint32_t o = 0; o < l.n_out; o++) {
                double most;
                const double want = exact(&l, r, o, &most);
                const float *row = y + o / PANEL * STRIDE + r * PANEL;
                const double got = l.linear ? (double)row[o % PANEL] : feature_of(row, o % PANEL);
                const double off = 1e-6 * most + (l.linear ? 0 : 0x1p-8 * fabs(want));
                if (!(fabs(got - want) <= off))
                    fail_msg("%s, %u x %u: %g, not %g", kernels->name, l.n_out, l.n_in, got, want);
            }
        mem_free(y);
        layer_free(&l);
    }
}

static void plain_layers_are_right(void **state)
{
    (void)state;
    compare(&nn_rounded_ref);
}

static void fast_layers_are_right(void **state)
{
    (void)state;
    if (!(cpu_detect() & CPU_AVX512BF16)) skip();
    compare(&nn_rounded_avx512bf16);
}

/* ---- Grids ---- */

enum { POINTS = 37, PITCH = 4, GRID_TILE = 6 * (POINTS + 1) * PANEL, GUARD = 12345 };

/* Half of them side by side, as pixels; some outside. */
static void fill_positions(float positions[POINTS][PITCH])
{
    struct rng r = rng_keyed(1, 2, 3);
    for (int i = 0; i < POINTS; i++)
        for (int k = 0; k < PITCH; k++)
            positions[i][k] = i < POINTS / 2 ? 1.1f * rng_float(&r) - 0.05f
                                             : positions[i - 1][k] + 0.02f * rng_float(&r);
    positions[1][0] = NAN;
}

/* Row by row, `count` numbers from `first` on are within the rounding of want(), and nothing else
 * was written but what completes a pair. */
static void check_tile(const char *name, const float *tile, uint32_t n, uint32_t first,
                       uint32_t count, const float *want)
{
    static bool is_meant[GRID_TILE];
    memset(is_meant, 0, sizeof is_meant);
    for (uint32_t r = 0; r < n; r++)
        for (uint32_t k = 0; k < count; k++) {
            const size_t row = (first + k) / PANEL * (POINTS + 1) * PANEL + (size_t)r * PANEL;
            const uint32_t at = (first + k) % PANEL;
            const double x = (double)want[(size_t)r * count + k], got = feature_of(tile + row, at);
            if (!(fabs(got - x) <= 0x1p-8 * fabs(x) + 1e-6))
                fail_msg("%s, %u numbers from %u: row %u, number %u is %g, not %g", name, count,
                         first, r, k, got, x);
            is_meant[row + at / 2] = true;
        }
    for (size_t i = 0; i < GRID_TILE; i++)
        if (!is_meant[i] && tile[i] != GUARD)
            fail_msg("%s, %u numbers from %u: %zu was written", name, count, first, i);
}

static void compare_grids(const struct grid_kernels *kernels)
{
    static const struct grid_config configs[] = {
        {.n_levels = 8, .log2_size = 9, .base = 4, .growth = 1.5f}, /* the last levels hashed */
        {.n_levels = 3, .log2_size = 5, .base = 3, .growth = 1.7f},
        {.n_levels = 11, .log2_size = 8, .base = 2, .growth = 1.4f},
        {.n_levels = 16, .log2_size = 10, .base = 16, .growth = 2.0f},
    };
    static const uint32_t firsts[] = {0, 6, 16, 58, 64};
    static float tile[GRID_TILE];
    float positions[POINTS][PITCH];
    fill_positions(positions);
    for (size_t c = 0; c < sizeof configs / sizeof *configs; c++) {
        struct grid g;
        grid_init(&g, &configs[c]);
        const size_t size = g.at[g.n_levels];
        const uint32_t count = g.n_levels * GRID_FEATURES;
        float *table = toy_take(size, sizeof *table), *pairs = toy_take(size, sizeof *pairs);
        float *want = toy_take((size_t)POINTS * count, sizeof *want);
        toy_fill(table, size, c);
        for (size_t i = 0; i < size; i++) table[i] = nn_round(table[i]);
        nn_rounded_pack_pairs(pairs, table, size / GRID_FEATURES);
        for (size_t i = 0; i < POINTS; i++) grid_encode(&g, table, positions[i], want + i * count);
        for (uint32_t n = 1; n <= POINTS; n += 6)
            for (size_t i = 0; i < sizeof firsts / sizeof *firsts; i++) {
                const struct grid_encode a = {.grid = &g,
                                              .table = pairs,
                                              .positions = positions[0],
                                              .pitch = PITCH,
                                              .n = n,
                                              .first = firsts[i],
                                              .tile = tile,
                                              .stride = (size_t)(POINTS + 1) * PANEL,
                                              .panel = PANEL};
                for (size_t k = 0; k < GRID_TILE; k++) tile[k] = GUARD;
                kernels->encode(&a);
                check_tile(kernels->name, tile, n, firsts[i], count, want);
            }
        mem_free(table);
        mem_free(pairs);
        mem_free(want);
    }
}

static void compare_features(const struct grid_kernels *kernels)
{
    static float tile[GRID_TILE];
    for (uint32_t count = 1; count <= 3 * PANEL; count += 5)
        for (uint32_t first = 0; first <= PANEL + 6; first += 14) {
            float *rows = toy_take((size_t)POINTS * count, sizeof *rows);
            toy_fill(rows, (size_t)POINTS * count, count);
            const struct grid_spread a = {.rows = rows,
                                          .n = POINTS,
                                          .count = count,
                                          .first = first,
                                          .tile = tile,
                                          .stride = (size_t)(POINTS + 1) * PANEL,
                                          .panel = PANEL};
            for (size_t k = 0; k < GRID_TILE; k++) tile[k] = GUARD;
            kernels->spread(&a);
            check_tile(kernels->name, tile, POINTS, first, count, rows);
            mem_free(rows);
        }
}

static void plain_grids_are_right(void **state)
{
    (void)state;
    compare_grids(&grid_rounded_ref);
    compare_features(&grid_rounded_ref);
}

static void fast_grids_are_right(void **state)
{
    (void)state;
    if (!(cpu_detect() & CPU_AVX512BF16)) skip();
    compare_grids(&grid_rounded_avx512bf16);
    compare_features(&grid_rounded_avx512bf16);
}

static void numbers_are_rounded_to_the_nearest(void **state)
{
    (void)state;
    assert_true(nn_round(1.0f) == 1.0f && nn_round(-3.5f) == -3.5f);
    assert_true(nn_round(0x1.01p0f) == 1.0f);          /* a tie, down to even */
    assert_true(nn_round(0x1.03p0f) == 0x1.04p0f);     /* up to even */
    assert_true(nn_round(0x1.010002p0f) == 0x1.02p0f); /* more than a tie */
    assert_true(nn_round(-0x1.00fffep0f) == -1.0f);    /* less */
    assert_true(isinf(nn_round(3.4e38f)) && isnan(nn_round(NAN)));
}

static void sets_are_chosen_where_they_gain(void **state)
{
    (void)state;
    assert_null(nn_rounded_for(CPU_AVX2 | CPU_AVX512));
    assert_ptr_equal(nn_rounded_for(CPU_AVX2 | CPU_AVX512 | CPU_AVX512BF16),
                     &nn_rounded_avx512bf16);
    assert_null(nn_rounded_for(CPU_ALL));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_layers_are_right),
        cmocka_unit_test(fast_layers_are_right),
        cmocka_unit_test(plain_grids_are_right),
        cmocka_unit_test(fast_grids_are_right),
        cmocka_unit_test(numbers_are_rounded_to_the_nearest),
        cmocka_unit_test(sets_are_chosen_where_they_gain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
