/* SPDX-License-Identifier: Apache-2.0 */
/* Every kernel of every instruction set against the plain ones, at odd sizes, with guards around
 * everything that a kernel may write; and the plain ones against sums in doubles. */
#include "nn/kernels.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "toy.h"

static const struct nn_kernels *const fast[] = {&nn_kernels_avx2, &nn_kernels_avx512};
static const uint32_t fast_cpu[] = {CPU_AVX2, CPU_AVX2 | CPU_AVX512};

enum { GUARD = 64, N_Q = 13 };
static const float guard_value = -12345.5f;

/* Floats between two guards. */
struct guarded {
    float *block, *data;
    size_t n;
};

static struct guarded guarded_new(size_t n)
{
    struct guarded g = {.block = toy_take(n + 2 * GUARD, sizeof(float)), .n = n};
    g.data = g.block + GUARD;
    for (size_t i = 0; i < n + 2 * GUARD; i++) g.block[i] = guard_value;
    return g;
}

static void guarded_free(struct guarded *g)
{
    for (size_t i = 0; i < GUARD; i++) {
        if (g->block[i] != guard_value) fail_msg("written %zu before the start", GUARD - i);
        if (g->data[g->n + i] != guard_value) fail_msg("written %zu past the end", i + 1);
    }
    mem_free(g->block);
}

/* A tile of n_rows in use, one spare row that must stay as it is, and all n features random. */
struct tile {
    struct guarded memory;
    uint32_t panel, n_rows, n;
    size_t stride;
};

static float *cell(const struct tile *t, uint32_t row, uint32_t feature)
{
    return t->memory.data + feature / t->panel * t->stride + row * t->panel + feature % t->panel;
}

/* `matrix` [n_rows][n]; NULL leaves the guard's value. Lanes past n become zero. */
static struct tile tile_new(const struct nn_kernels *k, uint32_t n_rows, uint32_t n,
                            const float *matrix)
{
    struct tile t = {.panel = k->panel, .n_rows = n_rows, .n = n};
    uint32_t n_panels = nn_n_panels(k, n);
    t.stride = (size_t)(n_rows + 1) * k->panel;
    t.memory = guarded_new(n_panels * t.stride);
    for (uint32_t r = 0; matrix && r < n_rows; r++)
        for (uint32_t f = 0; f < n_panels * k->panel; f++)
            *cell(&t, r, f) = f < n ? matrix[(size_t)r * n + f] : 0.0f;
    return t;
}

/* Copies the features out, looks at the guards, frees. `out` may be NULL. */
static void tile_take(struct tile *t, float *out)
{
    for (uint32_t r = 0; out && r < t->n_rows; r++)
        for (uint32_t f = 0; f < t->n; f++) out[(size_t)r * t->n + f] = *cell(t, r, f);
    for (uint32_t f = 0; f < t->n; f++)
        if (*cell(t, t->n_rows, f) != guard_value) fail_msg("written past the last row");
    guarded_free(&t->memory);
}

/* One size, with its matrices row-major. */
struct size {
    uint32_t n_rows, n_out, n_in, n_q;
    bool linear;
    float *x, *q, *w, *b, *dy, *h, *dw; /* w [n_out][ld] */
    size_t ld;
};

static float *random_matrix(size_t n, uint64_t seed)
{
    float *m = toy_take(n + 1, sizeof *m);
    toy_fill(m, n, seed);
    return m;
}

static void size_init(struct size *s)
{
    s->ld = s->n_in + s->n_q + 3; /* as with v's columns */
    s->x = random_matrix((size_t)s->n_rows * s->n_in, 1);
    s->q = random_matrix((size_t)s->n_rows * s->n_q, 2);
    s->w = random_matrix(s->n_out * s->ld, 3);
    s->b = random_matrix(s->n_out, 4);
    s->dy = random_matrix((size_t)s->n_rows * s->n_out, 5);
    s->h = random_matrix((size_t)s->n_rows * s->n_in, 6);
    s->dw = random_matrix(s->n_out * s->ld, 7);
    if (s->n_in > 0) s->h[0] = 0.0f; /* lrelu'(0) is the slope */
}

static void size_release(struct size *s)
{
    float *blocks[] = {s->x, s->q, s->w, s->b, s->dy, s->h, s->dw};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) mem_free(blocks[i]);
}

static void run_forward(const struct nn_kernels *k, const struct size *s, float *y)
{
    uint32_t n_columns = s->n_in + s->n_q, n_panels = nn_n_panels(k, s->n_out);
    size_t panel_size = (size_t)n_columns * k->panel;
    struct tile x = tile_new(k, s->n_rows, s->n_in, s->x), q = tile_new(k, s->n_rows, s->n_q, s->q);
    struct tile out = tile_new(k, s->n_rows, s->n_out, NULL);
    struct guarded w = guarded_new(n_panels * panel_size), b = guarded_new(n_panels * k->panel);
    for (uint32_t i = 0; i < n_panels; i++)
        nn_pack_forward(k, w.data + i * panel_size, s->w, s->ld, s->n_out, n_columns, i);
    memset(b.data, 0, b.n * sizeof(float));
    memcpy(b.data, s->b, s->n_out * sizeof(float));
    struct nn_forward a = {
        .n_rows = s->n_rows,
        .n_out = s->n_out,
        .n_in = s->n_in,
        .n_q = s->n_q,
        .x = x.memory.data,
        .q = q.memory.data,
        .w = w.data,
        .b = b.data,
        .y = out.memory.data,
        .stride = out.stride,
        .linear = s->linear,
    };
    k->forward(&a);
    tile_take(&out, y);
    tile_take(&x, NULL);
    tile_take(&q, NULL);
    guarded_free(&w);
    guarded_free(&b);
}

static void run_backward(const struct nn_kernels *k, const struct size *s, float *dh)
{
    uint32_t n_panels = nn_n_panels(k, s->n_in);
    size_t panel_size = (size_t)s->n_out * k->panel;
    struct tile dy = tile_new(k, s->n_rows, s->n_out, s->dy);
    struct tile h = tile_new(k, s->n_rows, s->n_in, s->h);
    struct tile out = tile_new(k, s->n_rows, s->n_in, NULL);
    struct guarded w = guarded_new(n_panels * panel_size);
    for (uint32_t i = 0; i < n_panels; i++)
        nn_pack_backward(k, w.data + i * panel_size, s->w, s->ld, s->n_out, s->n_in, i);
    struct nn_backward a = {
        .n_rows = s->n_rows,
        .n_out = s->n_out,
        .n_in = s->n_in,
        .dy = dy.memory.data,
        .w = w.data,
        .h = h.memory.data,
        .dh = out.memory.data,
        .stride = out.stride,
    };
    k->backward(&a);
    tile_take(&out, dh);
    tile_take(&dy, NULL);
    tile_take(&h, NULL);
    guarded_free(&w);
}

/* dw has n_out * ld floats; columns from n_in on must stay what they are. */
static void run_outer(const struct nn_kernels *k, const struct size *s, bool accumulate, float *dw)
{
    struct tile dy = tile_new(k, s->n_rows, s->n_out, s->dy);
    struct tile x = tile_new(k, s->n_rows, s->n_in, s->x);
    struct guarded out = guarded_new(s->n_out * s->ld);
    memcpy(out.data, s->dw, out.n * sizeof(float));
    struct nn_outer a = {
        .n_rows = s->n_rows,
        .n_out = s->n_out,
        .n_in = s->n_in,
        .dy = dy.memory.data,
        .x = x.memory.data,
        .dw = out.data,
        .ld = s->ld,
        .stride = x.stride,
        .accumulate = accumulate,
    };
    k->outer(&a);
    memcpy(dw, out.data, out.n * sizeof(float));
    guarded_free(&out);
    tile_take(&dy, NULL);
    tile_take(&x, NULL);
}

/* Sums of n products of numbers up to 1 differ by rounding alone. */
static void check_close(const char *what, const struct size *s, const float *got, const float *want,
                        size_t n, uint32_t n_summed)
{
    double tolerance = 3e-7 * (n_summed + 4.0);
    for (size_t i = 0; i < n; i++)
        if (!(fabs((double)got[i] - (double)want[i]) <= tolerance))
            fail_msg("%s, %u rows, %u out, %u in, %u q: value %zu is %.9g, not %.9g", what,
                     s->n_rows, s->n_out, s->n_in, s->n_q, i, (double)got[i], (double)want[i]);
}

static void plain_forward(const struct size *s, float *y)
{
    for (uint32_t r = 0; r < s->n_rows; r++)
        for (uint32_t o = 0; o < s->n_out; o++) {
            const float *w = s->w + o * s->ld;
            double sum = (double)s->b[o];
            for (uint32_t k = 0; k < s->n_in; k++)
                sum += (double)w[k] * (double)s->x[r * s->n_in + k];
            for (uint32_t k = 0; k < s->n_q; k++)
                sum += (double)w[s->n_in + k] * (double)s->q[r * s->n_q + k];
            y[r * s->n_out + o] = (float)(sum < 0 && !s->linear ? 0.01 * sum : sum);
        }
}

static void plain_backward(const struct size *s, float *dh)
{
    for (uint32_t r = 0; r < s->n_rows; r++)
        for (uint32_t k = 0; k < s->n_in; k++) {
            double sum = 0.0;
            for (uint32_t o = 0; o < s->n_out; o++)
                sum += (double)s->dy[r * s->n_out + o] * (double)s->w[o * s->ld + k];
            dh[r * s->n_in + k] = (float)(s->h[r * s->n_in + k] > 0 ? sum : 0.01 * sum);
        }
}

static void plain_outer(const struct size *s, bool accumulate, float *dw)
{
    memcpy(dw, s->dw, s->n_out * s->ld * sizeof *dw);
    for (uint32_t o = 0; o < s->n_out; o++)
        for (uint32_t k = 0; k < s->n_in; k++) {
            double sum = accumulate ? (double)s->dw[o * s->ld + k] : 0.0;
            for (uint32_t r = 0; r < s->n_rows; r++)
                sum += (double)s->dy[r * s->n_out + o] * (double)s->x[r * s->n_in + k];
            dw[o * s->ld + k] = (float)sum;
        }
}

/* want == NULL: against doubles. */
static void check_size(const struct nn_kernels *k, const struct nn_kernels *want, struct size s)
{
    size_init(&s);
    size_t n_y = (size_t)s.n_rows * s.n_out, n_h = (size_t)s.n_rows * s.n_in, n_w = s.n_out * s.ld;
    size_t n = n_y + n_h + n_w;
    float *got = toy_take(n, sizeof *got), *expected = toy_take(n, sizeof *expected);

    run_forward(k, &s, got);
    want ? run_forward(want, &s, expected) : plain_forward(&s, expected);
    check_close("forward", &s, got, expected, n_y, s.n_in + s.n_q);
    if (s.n_in > 0) {
        run_backward(k, &s, got);
        want ? run_backward(want, &s, expected) : plain_backward(&s, expected);
        check_close("backward", &s, got, expected, n_h, s.n_out);
        for (int accumulate = 0; accumulate < 2; accumulate++) {
            run_outer(k, &s, accumulate, got);
            want ? run_outer(want, &s, accumulate, expected)
                 : plain_outer(&s, accumulate, expected);
            check_close("outer", &s, got, expected, n_w, s.n_rows);
        }
    }
    mem_free(got);
    mem_free(expected);
    size_release(&s);
}

static const uint32_t widths[] = {1, 3, 8, 13, 15, 16, 17, 31, 33, 47, 49, 63, 64, 65, 100, 129};

static void check_sizes(const struct nn_kernels *k, const struct nn_kernels *want)
{
    size_t n = sizeof widths / sizeof *widths;
    for (size_t o = 0; o < n; o++)
        for (size_t i = 0; i < n; i++) {
            uint32_t blocks = 1 + (uint32_t)(o + i) % 3; /* 12 rows suit all sets */
            check_size(k, want,
                       (struct size){.n_rows = 12 * blocks,
                                     .n_out = widths[o],
                                     .n_in = widths[i],
                                     .n_q = (o + i) % 2 ? N_Q : 0,
                                     .linear = o % 2});
        }
    /* The position layer: nothing but q. */
    check_size(k, want, (struct size){.n_rows = 12, .n_out = 70, .n_in = 0, .n_q = 3});
}

static void test_ref(void **state)
{
    (void)state;
    check_sizes(&nn_kernels_ref, NULL);
}

static void test_fast(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof fast / sizeof *fast; i++)
        if (toy_level_runs(fast_cpu[i])) check_sizes(fast[i], &nn_kernels_ref);
}

/* The table takes the best set that it may. */
static void test_dispatch(void **state)
{
    struct nn_kernels k;
    (void)state;
    nn_kernels_init(&k, 0);
    assert_string_equal(k.name, "baseline");
    nn_kernels_init(&k, CPU_AVX2);
    assert_string_equal(k.name, "avx2");
    nn_kernels_init(&k, CPU_AVX2 | CPU_AVX512);
    assert_string_equal(k.name, "avx512");
    nn_kernels_init(&k, CPU_AVX512); /* without what it builds on */
    assert_string_equal(k.name, "baseline");
}

/* What a block of rows must divide, and that peak() says what it did. */
static void test_table(void **state)
{
    (void)state;
    assert_int_equal(12 % nn_kernels_ref.rows, 0);
    assert_true(nn_kernels_ref.peak(10) > 0);
    for (size_t i = 0; i < sizeof fast / sizeof *fast; i++) {
        assert_int_equal(12 % fast[i]->rows, 0);
        assert_int_equal(fast[i]->panel % 16, 0);
        if (!toy_level_runs(fast_cpu[i])) continue;
        assert_true(fabs(fast[i]->peak(1000) - 100 * fast[i]->peak(10)) < 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ref),
        cmocka_unit_test(test_fast),
        cmocka_unit_test(test_dispatch),
        cmocka_unit_test(test_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
