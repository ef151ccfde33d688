/* SPDX-License-Identifier: Apache-2.0 */
/* Every kernel of every instruction set against the plain ones, at odd sizes, with guards around
 * everything that a kernel may write; and the plain ones against sums in doubles. */
#include "nn/kernels.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "toy.h"

static const struct nn_kernels *const fast[] = {&nn_kernels_avx2, &nn_kernels_avx512,
                                                &nn_kernels_amx};
static const uint32_t fast_cpu[] = {CPU_AVX2, CPU_AVX2 | CPU_AVX512, CPU_ALL};

/* 96 rows suit all sets: 4, 6 and 32 divide it. */
enum { GUARD = 64, N_Q = 13, BLOCK_ROWS = 96 };
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
    float *x, *q, *w, *b, *dy, *h, *dw, *dq; /* w, dw [n_out][ld], dq [n_out][ld_q] */
    size_t ld, ld_q;
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
    s->ld_q = s->n_q + 3;
    s->dw = random_matrix(s->n_out * s->ld, 7);
    s->dq = random_matrix(s->n_out * s->ld_q, 8);
    if (s->n_in > 0) s->h[0] = 0.0f; /* lrelu'(0) is the slope */
}

static void size_release(struct size *s)
{
    float *blocks[] = {s->x, s->q, s->w, s->b, s->dy, s->h, s->dw, s->dq};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) mem_free(blocks[i]);
}

static struct guarded scratch_new(const struct nn_kernels *k, const struct size *s)
{
    uint32_t n = s->n_out > s->n_in ? s->n_out : s->n_in;
    return guarded_new(k->scratch_count(s->n_rows, n));
}

static void run_forward(const struct nn_kernels *k, const struct size *s, float *y)
{
    uint32_t n_panels = nn_n_panels(k, s->n_out);
    size_t panel_size = k->forward_count(s->n_in, s->n_q);
    struct tile x = tile_new(k, s->n_rows, s->n_in, s->x), q = tile_new(k, s->n_rows, s->n_q, s->q);
    struct tile out = tile_new(k, s->n_rows, s->n_out, NULL);
    struct guarded w = guarded_new(n_panels * panel_size), b = guarded_new(n_panels * k->panel);
    struct guarded scratch = scratch_new(k, s);
    for (uint32_t i = 0; i < n_panels; i++)
        k->pack_forward(w.data + i * panel_size, s->w, s->ld, s->n_out, s->n_in, s->n_q, i);
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
        .scratch = scratch.data,
    };
    k->forward(&a);
    tile_take(&out, y);
    tile_take(&x, NULL);
    tile_take(&q, NULL);
    guarded_free(&w);
    guarded_free(&b);
    guarded_free(&scratch);
}

static void run_backward(const struct nn_kernels *k, const struct size *s, float *dh)
{
    uint32_t n_panels = nn_n_panels(k, s->n_in);
    size_t panel_size = k->backward_count(s->n_out);
    struct tile dy = tile_new(k, s->n_rows, s->n_out, s->dy);
    struct tile h = tile_new(k, s->n_rows, s->n_in, s->h);
    struct tile out = tile_new(k, s->n_rows, s->n_in, NULL);
    struct guarded w = guarded_new(n_panels * panel_size), scratch = scratch_new(k, s);
    for (uint32_t i = 0; i < n_panels; i++)
        k->pack_backward(w.data + i * panel_size, s->w, s->ld, s->n_out, s->n_in, i);
    struct nn_backward a = {
        .n_rows = s->n_rows,
        .n_out = s->n_out,
        .n_in = s->n_in,
        .dy = dy.memory.data,
        .w = w.data,
        .h = h.memory.data,
        .dh = out.memory.data,
        .stride = out.stride,
        .scratch = scratch.data,
    };
    k->backward(&a);
    tile_take(&out, dh);
    tile_take(&dy, NULL);
    tile_take(&h, NULL);
    guarded_free(&w);
    guarded_free(&scratch);
}

/* dw has n_out * ld floats, dq n_out * ld_q; columns past n_in and n_q must stay what they are. */
static void run_outer(const struct nn_kernels *k, const struct size *s, bool add_w, bool add_q,
                      float *dw, float *dq)
{
    struct tile dy = tile_new(k, s->n_rows, s->n_out, s->dy);
    struct tile x = tile_new(k, s->n_rows, s->n_in, s->x), q = tile_new(k, s->n_rows, s->n_q, s->q);
    struct guarded w = guarded_new(s->n_out * s->ld), of_q = guarded_new(s->n_out * s->ld_q);
    struct guarded scratch = scratch_new(k, s);
    memcpy(w.data, s->dw, w.n * sizeof(float));
    memcpy(of_q.data, s->dq, of_q.n * sizeof(float));
    struct nn_outer a = {
        .n_rows = s->n_rows,
        .n_out = s->n_out,
        .n_in = s->n_in,
        .n_q = s->n_q,
        .dy = dy.memory.data,
        .x = x.memory.data,
        .q = q.memory.data,
        .dw = w.data,
        .dq = of_q.data,
        .ld_w = s->ld,
        .ld_q = s->ld_q,
        .stride = dy.stride,
        .add_w = add_w,
        .add_q = add_q,
        .scratch = scratch.data,
    };
    k->outer(&a);
    memcpy(dw, w.data, w.n * sizeof(float));
    memcpy(dq, of_q.data, of_q.n * sizeof(float));
    guarded_free(&w);
    guarded_free(&of_q);
    guarded_free(&scratch);
    tile_take(&dy, NULL);
    tile_take(&x, NULL);
    tile_take(&q, NULL);
}

/* Sums of n_summed products of numbers up to 1: they differ by rounding, and by what `k` loses of
 * each product, which has either sign. */
static void check_close(const struct nn_kernels *k, const char *what, const struct size *s,
                        const float *got, const float *want, size_t n, uint32_t n_summed)
{
    double tolerance = 3e-7 * (n_summed + 4.0) + (double)k->error * sqrt(n_summed);
    for (size_t i = 0; i < n; i++)
        if (!(fabs((double)got[i] - (double)want[i]) <= tolerance))
            fail_msg("%s %s, %u rows, %u out, %u in, %u q: value %zu is %.9g, not %.9g", k->name,
                     what, s->n_rows, s->n_out, s->n_in, s->n_q, i, (double)got[i],
                     (double)want[i]);
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

/* dw [n_out][ld] (+)= dy^T x */
static void plain_outer(const struct size *s, const float *x, uint32_t n_in, const float *before,
                        size_t ld, bool add, float *dw)
{
    memcpy(dw, before, s->n_out * ld * sizeof *dw);
    for (uint32_t o = 0; o < s->n_out; o++)
        for (uint32_t k = 0; k < n_in; k++) {
            double sum = add ? (double)before[o * ld + k] : 0.0;
            for (uint32_t r = 0; r < s->n_rows; r++)
                sum += (double)s->dy[r * s->n_out + o] * (double)x[r * n_in + k];
            dw[o * ld + k] = (float)sum;
        }
}

static void check_outer(const struct nn_kernels *k, const struct nn_kernels *want,
                        const struct size *s, bool add_w, bool add_q)
{
    size_t n_w = s->n_out * s->ld, n_q = s->n_out * s->ld_q;
    float *got = toy_take(n_w + n_q, sizeof *got), *expected = toy_take(n_w + n_q, sizeof *got);
    run_outer(k, s, add_w, add_q, got, got + n_w);
    if (want) {
        run_outer(want, s, add_w, add_q, expected, expected + n_w);
    } else {
        plain_outer(s, s->x, s->n_in, s->dw, s->ld, add_w, expected);
        plain_outer(s, s->q, s->n_q, s->dq, s->ld_q, add_q, expected + n_w);
    }
    check_close(k, "outer", s, got, expected, n_w, s->n_rows);
    check_close(k, "outer of q", s, got + n_w, expected + n_w, n_q, s->n_rows);
    mem_free(got);
    mem_free(expected);
}

/* want == NULL: against doubles. */
static void check_size(const struct nn_kernels *k, const struct nn_kernels *want, struct size s)
{
    size_init(&s);
    size_t n_y = (size_t)s.n_rows * s.n_out, n_h = (size_t)s.n_rows * s.n_in;
    float *got = toy_take(n_y + n_h, sizeof *got), *expected = toy_take(n_y + n_h, sizeof *got);

    run_forward(k, &s, got);
    want ? run_forward(want, &s, expected) : plain_forward(&s, expected);
    check_close(k, "forward", &s, got, expected, n_y, s.n_in + s.n_q);
    if (s.n_in > 0) {
        run_backward(k, &s, got);
        want ? run_backward(want, &s, expected) : plain_backward(&s, expected);
        check_close(k, "backward", &s, got, expected, n_h, s.n_out);
    }
    check_outer(k, want, &s, false, true);
    check_outer(k, want, &s, true, false);
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
            uint32_t n_blocks = 1 + (uint32_t)(o + i) % 2;
            check_size(k, want,
                       (struct size){.n_rows = BLOCK_ROWS * n_blocks,
                                     .n_out = widths[o],
                                     .n_in = widths[i],
                                     .n_q = (o + i) % 2 ? N_Q : 0,
                                     .linear = o % 2});
        }
    /* The position layer: nothing but q. */
    check_size(k, want, (struct size){.n_rows = BLOCK_ROWS, .n_out = 70, .n_q = 3});
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
    nn_kernels_init(&k, CPU_ALL);
    assert_string_equal(k.name, "amx");
    nn_kernels_init(&k, CPU_AVX512); /* without what it builds on */
    assert_string_equal(k.name, "baseline");
}

/* Against exp() in doubles, beyond both bounds and for what is no number; all sets alike. */
static void test_exponentials(void **state)
{
    enum { N = 1003 };
    static float x[N];
    (void)state;
    for (uint32_t i = 0; i < N; i++) x[i] = -14.0f + 30.0f * (float)i / N;
    x[500] = NAN;
    struct guarded expected = guarded_new(N);
    nn_kernels_ref.exponentials(x, N, expected.data);
    for (uint32_t i = 0; i < N; i++) {
        const double clipped = fmin(fmax(x[i], NN_LEAST_EXPONENT), NN_MOST_EXPONENT);
        const double y = exp(clipped);
        if (i == 500)
            assert_true(isnan(expected.data[i]));
        else
            assert_true(fabs(expected.data[i] - y) <= 3e-7 * y);
    }
    for (size_t k = 0; k < sizeof fast / sizeof *fast; k++) {
        if (!toy_level_runs(fast_cpu[k])) continue;
        struct guarded y = guarded_new(N);
        fast[k]->exponentials(x, N, y.data);
        assert_memory_equal(y.data, expected.data, N * sizeof *y.data);
        guarded_free(&y);
    }
    guarded_free(&expected);
}

/* What a block of rows must divide, and that peak() says what it did. */
static void test_table(void **state)
{
    (void)state;
    assert_int_equal(BLOCK_ROWS % nn_kernels_ref.rows, 0);
    assert_true(nn_kernels_ref.peak(10) > 0);
    for (size_t i = 0; i < sizeof fast / sizeof *fast; i++) {
        assert_int_equal(BLOCK_ROWS % fast[i]->rows, 0);
        assert_int_equal(fast[i]->panel % 16, 0);
        if (!toy_level_runs(fast_cpu[i])) continue;
        assert_true(fabs(fast[i]->peak(1000) - 100 * fast[i]->peak(10)) < 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ref),          cmocka_unit_test(test_fast),
        cmocka_unit_test(test_exponentials), cmocka_unit_test(test_dispatch),
        cmocka_unit_test(test_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
