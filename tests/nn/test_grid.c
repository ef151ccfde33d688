/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels of grids of every instruction set against the plain version, at odd sizes. */
#include "nn/grid_kernels.h"

#include <math.h>
#include <string.h>

#include "base/cpu.h"
#include "base/mem.h"
#include "base/rng.h"
#include "toy.h"

enum { N_MOST = 37, PITCH = 7, MOST_PANELS = 8, MOST_PANEL = 64, GUARD = 12345 };

static const struct {
    const struct grid_kernels *kernels;
    uint32_t needs;
} sets[] = {
    {&grid_kernels_ref, 0}, {&grid_kernels_avx2, CPU_AVX2}, {&grid_kernels_avx512, CPU_AVX512}};
enum { N_SETS = sizeof sets / sizeof *sets };

static const struct grid_config configs[] = {
    {.n_levels = 8, .log2_size = 9, .base = 4, .growth = 1.5f}, /* the last levels hashed */
    {.n_levels = 3, .log2_size = 5, .base = 3, .growth = 1.7f},
    {.n_levels = 11, .log2_size = 8, .base = 2, .growth = 1.4f},
    {.n_levels = 16, .log2_size = 10, .base = 16, .growth = 2.0f},
};
enum { N_CONFIGS = sizeof configs / sizeof *configs };

static bool has(size_t set)
{
    return (cpu_detect() & sets[set].needs) == sets[set].needs;
}

/* Some on the cube's faces, some beyond, some no numbers; half of them side by side, as pixels. */
static void fill_positions(float positions[N_MOST][PITCH])
{
    struct rng r = rng_keyed(1, 2, 3);
    for (int i = 0; i < N_MOST; i++)
        for (int k = 0; k < PITCH; k++)
            positions[i][k] = i < N_MOST / 2 ? 1.1f * rng_float(&r) - 0.05f
                                             : positions[i - 1][k] + 0.02f * rng_float(&r);
    const float odd[] = {0.0f, 1.0f, 0x1.fffffep-1f, -3.0f, 7.0f, INFINITY, -INFINITY, NAN};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) positions[i][i % 3] = odd[i];
}

static float *new_table(const struct grid *g, float scale, uint64_t key)
{
    const size_t n = g->at[g->n_levels];
    float *table = toy_take(n, sizeof *table);
    struct rng r = rng_keyed(4, key, 5);
    for (size_t i = 0; i < n; i++) table[i] = scale * (2.0f * rng_float(&r) - 1.0f);
    return table;
}

static void encodings_agree(void **state)
{
    static const uint32_t panels[] = {16, 32, 64}, firsts[] = {0, 6, 16, 30};
    float positions[N_MOST][PITCH];
    (void)state;
    fill_positions(positions);
    for (size_t c = 0; c < N_CONFIGS; c++)
        for (size_t i = 0; i < 12 * N_SETS; i++) {
            const uint32_t panel = panels[i % 3], first = firsts[i / 3 % 4];
            const size_t set = i / 12, stride = (size_t)(N_MOST + 1) * panel;
            static float want[MOST_PANELS * (N_MOST + 1) * MOST_PANEL];
            static float got[MOST_PANELS * (N_MOST + 1) * MOST_PANEL];
            struct grid g;
            if (!has(set)) continue;
            grid_init(&g, &configs[c]);
            float *table = new_table(&g, 1.0f, c);
            for (uint32_t n = 1; n <= N_MOST; n += 6) {
                struct grid_encode a = {.grid = &g,
                                        .table = table,
                                        .positions = positions[0],
                                        .pitch = PITCH,
                                        .n = n,
                                        .first = first,
                                        .tile = want,
                                        .stride = stride,
                                        .panel = panel};
                for (size_t k = 0; k < sizeof want / sizeof *want; k++) want[k] = got[k] = GUARD;
                grid_kernels_ref.encode(&a);
                a.tile = got;
                sets[set].kernels->encode(&a);
                for (size_t k = 0; k < sizeof want / sizeof *want; k++)
                    if (!(fabsf(want[k] - got[k]) < 2e-6f) ||
                        (want[k] == GUARD) != (got[k] == GUARD))
                        fail_msg("%s, %u levels, panel %u, first %u, %u rows: number %zu is %g, "
                                 "not %g",
                                 sets[set].kernels->name, g.n_levels, panel, first, n, k,
                                 (double)got[k], (double)want[k]);
            }
            mem_free(table);
        }
}

static void gradients_agree(void **state)
{
    float positions[N_MOST][PITCH], d[N_MOST][GRID_FEATURES];
    struct rng r = rng_keyed(7, 8, 9);
    (void)state;
    fill_positions(positions);
    for (int i = 0; i < N_MOST; i++)
        for (int k = 0; k < GRID_FEATURES; k++) d[i][k] = 2.0f * rng_float(&r) - 1.0f;
    for (size_t c = 0; c < N_CONFIGS; c++)
        for (size_t set = 0; set < N_SETS; set++) {
            struct grid g;
            if (!has(set)) continue;
            grid_init(&g, &configs[c]);
            const size_t size = g.at[g.n_levels];
            float *want = new_table(&g, 0.1f, c), *got = new_table(&g, 0.1f, c);
            for (uint32_t n = 1; n <= N_MOST; n += 9)
                for (uint32_t level = 0; level < g.n_levels; level++) {
                    struct grid_back a = {.grid = &g,
                                          .level = level,
                                          .positions = positions[0],
                                          .pitch = PITCH,
                                          .n = n,
                                          .d = d[0],
                                          .gradient = want + g.at[level]};
                    grid_kernels_ref.back(&a);
                    a.gradient = got + g.at[level];
                    sets[set].kernels->back(&a);
                }
            for (size_t k = 0; k < size; k++)
                if (!(fabsf(want[k] - got[k]) < 2e-5f))
                    fail_msg("%s, %u levels: number %zu is %g, not %g", sets[set].kernels->name,
                             g.n_levels, k, (double)got[k], (double)want[k]);
            mem_free(want);
            mem_free(got);
        }
}

/* The rows end with their memory: nothing past it may be read (AddressSanitizer looks). */
static void features_are_spread(void **state)
{
    enum { COUNT_MOST = 70, STRIDE = (N_MOST + 1) * MOST_PANEL, SIZE = 4 * STRIDE };
    static float want[SIZE], got[SIZE];
    (void)state;
    for (uint32_t count = 1; count <= COUNT_MOST; count += 3)
        for (size_t i = 0; i < 9 * N_SETS; i++) {
            const uint32_t panel = 16u << i % 3, first = (uint32_t)(i / 3 % 3) * 11;
            const size_t set = i / 9;
            if (!has(set)) continue;
            float *rows = toy_take((size_t)N_MOST * count, sizeof *rows);
            for (size_t k = 0; k < (size_t)N_MOST * count; k++) rows[k] = (float)k;
            for (size_t k = 0; k < SIZE; k++) want[k] = got[k] = -1.0f;
            struct grid_spread a = {.rows = rows,
                                    .n = N_MOST,
                                    .count = count,
                                    .first = first,
                                    .tile = want,
                                    .stride = (size_t)(N_MOST + 1) * panel,
                                    .panel = panel};
            if ((first + count + panel - 1) / panel * a.stride <= SIZE) {
                grid_kernels_ref.spread(&a);
                a.tile = got;
                sets[set].kernels->spread(&a);
                assert_memory_equal(want, got, sizeof want);
            }
            mem_free(rows);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(encodings_agree),
        cmocka_unit_test(gradients_agree),
        cmocka_unit_test(features_are_spread),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
