/* SPDX-License-Identifier: Apache-2.0 */
/* Layers of BF16 factors: the plain one against sums in doubles, the fast one against the plain. */
#include "nn/rounded.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "toy.h"

enum { ROWS = 36, MOST = 200, PANEL = NN_ROUNDED_PANEL, PANELS = (MOST + PANEL - 1) / PANEL };
#define STRIDE ((size_t)(ROWS + 1) * PANEL)

struct layer {
    uint32_t n_out, n_in;
    bool is_first, linear;
    float *x, *w, *b, *packed; /* tile of floats, [n_out][n_in + 2], [PANELS][PANEL] */
    float *pairs;              /* tile of what x rounds to */
};

/* Features 2i and 2i + 1 of a row. */
static float new_pair(const float *row, uint32_t i)
{
    uint32_t bits[2];
    float pair;
    for (uint32_t k = 0; k < 2; k++) {
        const float x = nn_round(row[2 * i + k]);
        memcpy(&bits[k], &x, sizeof x);
    }
    const uint32_t both = bits[0] >> 16 | bits[1];
    memcpy(&pair, &both, sizeof pair);
    return pair;
}

static double feature_of(const float *pairs, uint32_t k)
{
    uint32_t bits;
    float x;
    memcpy(&bits, pairs + k / 2, sizeof bits);
    bits = k % 2 ? bits & 0xFFFF0000u : bits << 16;
    memcpy(&x, &bits, sizeof x);
    return (double)x;
}

static struct layer layer_new(uint32_t n_out, uint32_t n_in, bool is_first, bool linear)
{
    struct layer l = {.n_out = n_out, .n_in = n_in, .is_first = is_first, .linear = linear};
    l.x = toy_take(PANELS * STRIDE, sizeof(float));
    l.w = toy_take((size_t)n_out * (n_in + 2), sizeof(float));
    l.b = toy_take(PANELS * PANEL, sizeof(float));
    l.packed = toy_take(PANELS * nn_rounded_count(n_in), sizeof(float));
    toy_fill(l.x, PANELS * STRIDE, n_in);
    toy_fill(l.w, (size_t)n_out * (n_in + 2), n_out);
    toy_fill(l.b, PANELS * PANEL, 3);
    l.pairs = toy_take(PANELS * STRIDE, sizeof(float));
    for (size_t at = 0; at < PANELS * STRIDE; at += PANEL)
        for (uint32_t i = 0; i < PANEL / 2; i++) l.pairs[at + i] = new_pair(l.x + at, i);
    for (uint32_t k = n_in; k < (n_in + PANEL - 1) / PANEL * PANEL; k++) /* nobody's lanes */
        for (size_t r = 0; r < ROWS; r++) l.x[k / PANEL * STRIDE + r * PANEL + k % PANEL] = NAN;
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
                                 .x = l->is_first ? l->x : l->pairs,
                                 .w = l->packed,
                                 .b = l->b,
                                 .y = y,
                                 .stride = STRIDE,
                                 .linear = l->linear};
    kernels->forward(&a, l->is_first);
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
    for (size_t s = 0; s < 4 * (sizeof sizes / sizeof *sizes); s++) {
        const uint32_t *size = sizes[s / 4];
        struct layer l = layer_new(size[0], size[1], s % 2 != 0, s % 4 >= 2);
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
        cmocka_unit_test(numbers_are_rounded_to_the_nearest),
        cmocka_unit_test(sets_are_chosen_where_they_gain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
