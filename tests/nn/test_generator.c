/* SPDX-License-Identifier: Apache-2.0 */
/* The whole network: values and gradients against doubles and their differences, for every
 * instruction set; equal bytes for any number of threads; refusals. */
#include "nn/generator.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "plain.h"
#include "toy.h"

static double *doubled(const float *x, size_t n)
{
    double *d = toy_take(n, sizeof *d);
    for (size_t i = 0; i < n; i++) d[i] = (double)x[i];
    return d;
}

/* ---- Gradients ---- */

/* What one instruction set makes of loss and gradient, against `slopes` and `want`. Errors are held
 * against the largest derivative of the same layer's weights or biases. */
static void check_level(const struct generator_config *config, uint32_t cpu, bool legacy,
                        const double *slopes, double want)
{
    struct toy toy;
    toy_init(&toy, config, 2, 1, cpu);
    size_t n = generator_n_weights(toy.g), at = 0;
    float *gradient = toy_take(n, sizeof *gradient), losses[2];
    struct generator_loss loss = {.legacy_ssim = legacy};
    generator_gradient(toy.g, &toy.batch, &loss, losses, gradient);
    double got = ((double)losses[0] + (double)losses[1]) / 2;
    if (!(fabs(got - want) < 5e-6 * want)) fail_msg("loss %.9g, not %.9g", got, want);

    for (uint32_t l = 0; l < config->depth + 3; l++) {
        uint32_t n_out = l < config->depth + 2 ? config->width : 3;
        size_t n_in = l == 0 ? 3 : (size_t)config->width + 13 + config->n_variables;
        size_t parts[] = {n_in * n_out, n_out};
        for (int part = 0; part < 2; part++) {
            double largest = 0.0, worst = 0.0;
            for (size_t i = at; i < at + parts[part]; i++) {
                double error = fabs(slopes[i] - (double)gradient[i]);
                if (fabs(slopes[i]) > largest) largest = fabs(slopes[i]);
                if (!(error <= worst)) worst = error;
            }
            if (!(worst < 1e-4 * largest + 1e-9)) /* what doubles leave of a difference */
                fail_msg("%s, layer %u, %s: off by %.3g of %.3g", cpu_name(cpu), l,
                         part ? "biases" : "weights", worst, largest);
            at += parts[part];
        }
    }
    assert_int_equal(at, n);
    mem_free(gradient);
    toy_release(&toy);
}

/* Central differences of the double-precision loss, for each weight. */
static void check_gradient(const struct generator_config *config, bool legacy)
{
    struct toy toy;
    toy_init(&toy, config, 2, 1, 0);
    size_t n = generator_n_weights(toy.g);
    double *w = doubled(generator_weights(toy.g), n), *slopes = toy_take(n, sizeof *slopes);
    for (size_t i = 0; i < n; i++) {
        double h = 1e-6, before = w[i];
        w[i] = before + h;
        double up = plain_batch_loss(config, w, &toy.batch, legacy);
        w[i] = before - h;
        slopes[i] = (up - plain_batch_loss(config, w, &toy.batch, legacy)) / (2 * h);
        w[i] = before;
    }
    double want = plain_batch_loss(config, w, &toy.batch, legacy);
    for (size_t i = 0; i < toy_n_levels; i++)
        if (toy_level_runs(toy_levels[i])) check_level(config, toy_levels[i], legacy, slopes, want);
    mem_free(w);
    mem_free(slopes);
    toy_release(&toy);
}

static void test_gradient(void **state)
{
    static const struct generator_config configs[] = {
        {.n_variables = 2, .width = 5, .depth = 1, .patch_size = 4},
        {.n_variables = 0, .width = 18, .depth = 0, .patch_size = 3},
        {.n_variables = 3, .width = 1, .depth = 2, .patch_size = 5},
    };
    (void)state;
    for (size_t c = 0; c < sizeof configs / sizeof *configs; c++)
        for (int legacy = 0; legacy < 2; legacy++) check_gradient(&configs[c], legacy);
}

/* No gradient reaches the network from channels where emission stands in for it. */
static void test_emission_blocks(void **state)
{
    struct generator_config config = {.n_variables = 2, .width = 8, .depth = 1, .patch_size = 4};
    struct generator_loss loss = {0};
    struct toy toy;
    float losses[1];
    (void)state;
    toy_init(&toy, &config, 1, 1, CPU_ALL & cpu_detect());
    for (size_t i = 0; i < 16; i++)
        for (size_t c = 0; c < 3; c++) toy.inputs[i * GENERATOR_INPUTS + c] = 1.75f + (float)c;
    size_t n = generator_n_weights(toy.g);
    float *gradient = toy_take(n, sizeof *gradient);
    generator_gradient(toy.g, &toy.batch, &loss, losses, gradient);
    for (size_t i = 0; i < n; i++) assert_true(gradient[i] == 0.0f);
    for (size_t i = 0; i < 16; i++) toy.inputs[i * GENERATOR_INPUTS] = 1.7f; /* log1p is < 1 */
    generator_gradient(toy.g, &toy.batch, &loss, losses, gradient);
    assert_true(gradient[n - 3] != 0.0f); /* the output's red bias alone */
    assert_true(gradient[n - 2] == 0.0f && gradient[n - 1] == 0.0f);
    mem_free(gradient);
    toy_release(&toy);
}

/* ---- Rendering ---- */

static void check_render(uint32_t width, uint32_t depth, size_t n_pixels, uint32_t cpu)
{
    struct generator_config config = {.n_variables = 3, .width = width, .depth = depth};
    struct error err = {{0}};
    struct pool *pool = pool_new(2);
    struct generator *g;
    float v[3] = {0.25f, 0.5f, 0.75f};
    double pv[3] = {0.25, 0.5, 0.75};
    if (generator_new(&config, pool, cpu, &g, &err) != LMN_OK) fail_msg("%s", err.text);
    generator_init(g, width);
    float *inputs = toy_take(n_pixels * GENERATOR_INPUTS, sizeof *inputs);
    float *out = toy_take(n_pixels * 3 + 1, sizeof *out);
    double *w = doubled(generator_weights(g), generator_n_weights(g));
    toy_fill(inputs, n_pixels * GENERATOR_INPUTS, n_pixels);
    for (size_t i = 0; i < n_pixels; i++)
        for (size_t c = 0; c < 3; c++) {
            float *e = &inputs[i * GENERATOR_INPUTS + c];
            *e = *e > 0.5f ? 6.0f * *e - 3.0f : 0.0f;
        }
    out[n_pixels * 3] = 42.0f;
    generator_render(g, inputs, v, n_pixels, out);
    assert_true(out[n_pixels * 3] == 42.0f);
    size_t step = n_pixels > 100 ? 13 : 1;
    for (size_t i = 0; i < n_pixels; i += step) {
        double in[GENERATOR_INPUTS], f[3];
        for (size_t k = 0; k < GENERATOR_INPUTS; k++)
            in[k] = (double)inputs[i * GENERATOR_INPUTS + k];
        plain_pixel(&config, w, in, pv, f);
        for (size_t c = 0; c < 3; c++)
            if (!(fabs((double)out[i * 3 + c] - expm1(f[c])) < 2e-5))
                fail_msg("%s, width %u, pixel %zu of %zu: %.9g, not %.9g", cpu_name(cpu), width, i,
                         n_pixels, (double)out[i * 3 + c], expm1(f[c]));
    }
    mem_free(inputs);
    mem_free(out);
    mem_free(w);
    generator_free(g);
    pool_free(pool);
}

static void test_render(void **state)
{
    static const size_t n_pixels[] = {1, 5, 343, 344, 345, 1000};
    static const uint32_t widths[] = {1, 17, 64, 100};
    (void)state;
    for (size_t i = 0; i < toy_n_levels; i++) {
        if (!toy_level_runs(toy_levels[i])) continue;
        for (size_t n = 0; n < sizeof n_pixels / sizeof *n_pixels; n++)
            check_render(widths[n % 4], (uint32_t)n % 3, n_pixels[n], toy_levels[i]);
        check_render(1024, 1, 7, toy_levels[i]);
    }
}

/* Nothing to do, nothing touched. */
static void test_empty(void **state)
{
    struct generator_config config = {.width = 4, .patch_size = 2};
    struct generator_loss loss = {0};
    struct generator_batch empty = {0};
    struct toy toy;
    (void)state;
    toy_init(&toy, &config, 1, 2, 0);
    size_t n = generator_n_weights(toy.g);
    float *gradient = toy_take(n, sizeof *gradient);
    gradient[0] = 1.0f;
    generator_render(toy.g, NULL, toy.v, 0, NULL);
    generator_gradient(toy.g, &empty, &loss, NULL, gradient);
    for (size_t i = 0; i < n; i++) assert_true(gradient[i] == 0.0f);
    generator_probe(toy.g, NULL, &empty, &loss, NULL, NULL);
    mem_free(gradient);
    toy_release(&toy);
}

/* ---- Threads ---- */

enum { N_PATCHES = 37, FRAME = 1500 };

struct results {
    float *gradient, *weights, frame[FRAME * 3];
    float losses[N_PATCHES], probe_losses[N_PATCHES], norms[N_PATCHES], plain_norms[N_PATCHES];
    size_t n;
};

/* Two steps, a probe and a frame. */
static void run_all(struct results *r, const struct generator_config *config, uint32_t n_threads,
                    uint32_t cpu)
{
    static float inputs[FRAME * GENERATOR_INPUTS];
    struct generator_loss loss = {0};
    struct adam adam;
    struct toy toy;
    toy_fill(inputs, FRAME * GENERATOR_INPUTS, 5);
    for (size_t i = 0; i < FRAME * GENERATOR_INPUTS; i++) inputs[i] = fabsf(inputs[i]);
    toy_init(&toy, config, N_PATCHES, n_threads, cpu);
    r->n = generator_n_weights(toy.g);
    r->gradient = toy_take(r->n, sizeof *r->gradient);
    r->weights = toy_take(r->n, sizeof *r->weights);
    assert_int_equal(adam_init(&adam, r->n, 1e-3, NULL), LMN_OK);
    for (int step = 0; step < 2; step++) {
        generator_gradient(toy.g, &toy.batch, &loss, r->losses, r->gradient);
        adam_step(&adam, toy.pool, generator_weights(toy.g), r->gradient);
        generator_weights_changed(toy.g);
    }
    generator_probe(toy.g, &adam, &toy.batch, &loss, r->probe_losses, r->norms);
    generator_probe(toy.g, NULL, &toy.batch, &loss, r->probe_losses, r->plain_norms);
    generator_render(toy.g, inputs, toy.v, FRAME, r->frame);
    memcpy(r->weights, generator_weights(toy.g), r->n * sizeof *r->weights);
    adam_release(&adam);
    toy_release(&toy);
}

static void test_threads(void **state)
{
    static struct results want, got;
    struct generator_config config = {.n_variables = 3, .width = 37, .depth = 2, .patch_size = 20};
    (void)state;
    for (size_t i = 0; i < toy_n_levels; i++) {
        if (!toy_level_runs(toy_levels[i])) continue;
        run_all(&want, &config, 1, toy_levels[i]);
        for (uint32_t n_threads = 2; n_threads <= 3; n_threads++) {
            run_all(&got, &config, n_threads, toy_levels[i]);
            assert_memory_equal(got.gradient, want.gradient, want.n * sizeof(float));
            assert_memory_equal(got.weights, want.weights, want.n * sizeof(float));
            assert_memory_equal(got.losses, want.losses, sizeof want.losses);
            assert_memory_equal(got.probe_losses, want.probe_losses, sizeof want.probe_losses);
            assert_memory_equal(got.norms, want.norms, sizeof want.norms);
            assert_memory_equal(got.plain_norms, want.plain_norms, sizeof want.plain_norms);
            assert_memory_equal(got.frame, want.frame, sizeof want.frame);
            mem_free(got.gradient);
            mem_free(got.weights);
        }
        mem_free(want.gradient);
        mem_free(want.weights);
    }
}

/* ---- Probing ---- */

static double norm(const float *x, size_t n)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++) sum += (double)x[i] * (double)x[i];
    return sqrt(sum);
}

/* Norms are those of the patch's own gradient, and of the change that Adam then makes. */
static void test_probe(void **state)
{
    enum { N = 3 };
    struct generator_config config = {.n_variables = 2, .width = 20, .depth = 1, .patch_size = 9};
    struct generator_loss loss = {0};
    struct adam adam;
    struct toy toy;
    float losses[N], norms[N], one[1];
    (void)state;
    toy_init(&toy, &config, N, 2, CPU_ALL & cpu_detect());
    size_t n = generator_n_weights(toy.g);
    float *gradient = toy_take(n, sizeof *gradient), *w = generator_weights(toy.g);
    float *change = toy_take(n, sizeof *change);
    assert_int_equal(adam_init(&adam, n, 1e-3, NULL), LMN_OK);

    generator_probe(toy.g, &adam, &toy.batch, &loss, losses, norms);
    for (int i = 0; i < N; i++) assert_true(norms[i] == 1.0f && losses[i] > 0.0f);

    for (int step = 0; step < 2; step++) {
        generator_gradient(toy.g, &toy.batch, &loss, losses, gradient);
        adam_step(&adam, toy.pool, w, gradient);
        generator_weights_changed(toy.g);
    }
    for (int i = 0; i < N; i++) {
        struct generator_batch single = {1, toy.batch.inputs + i, toy.batch.targets + i,
                                         toy.batch.v + i};
        generator_gradient(toy.g, &single, &loss, one, gradient);
        generator_probe(toy.g, NULL, &toy.batch, &loss, losses, norms);
        assert_true(one[0] == losses[i]);
        assert_true(fabs(norm(gradient, n) - (double)norms[i]) < 1e-6 * (double)norms[i]);

        struct adam copy;
        assert_int_equal(adam_init(&copy, n, adam.learning_rate, NULL), LMN_OK);
        memcpy(copy.m, adam.m, n * sizeof *copy.m);
        memcpy(copy.v, adam.v, n * sizeof *copy.v);
        copy.t = adam.t;
        memset(change, 0, n * sizeof *change);
        adam_step(&copy, toy.pool, change, gradient);
        generator_probe(toy.g, &adam, &toy.batch, &loss, losses, norms);
        assert_true(fabs(norm(change, n) - (double)norms[i]) < 1e-5 * (double)norms[i]);
        adam_release(&copy);
    }
    adam_release(&adam);
    mem_free(gradient);
    mem_free(change);
    toy_release(&toy);
}

/* ---- Making one ---- */

static void test_init(void **state)
{
    struct generator_config config = {.n_variables = 4, .width = 60, .depth = 1, .patch_size = 4};
    struct toy toy;
    (void)state;
    toy_init(&toy, &config, 1, 1, 0);
    const float *w = generator_weights(toy.g);
    size_t n_in = 60 + 13 + 4, first = 3 * 60 + 60;
    assert_int_equal(generator_n_weights(toy.g), first + 2 * (n_in + 1) * 60 + (n_in + 1) * 3);
    double bound = 1 / sqrt(3.0), largest = 0.0, squares = 0.0;
    for (size_t i = 0; i < first; i++) assert_true(fabs((double)w[i]) <= bound);
    bound = 1 / sqrt((double)n_in);
    for (size_t i = first; i < first + n_in * 60; i++) {
        double size = fabs((double)w[i]);
        if (size > largest) largest = size;
        squares += size * size;
    }
    assert_true(largest <= bound && largest > 0.99 * bound);
    assert_true(fabs(squares / (double)(n_in * 60) - bound * bound / 3) < 0.02 * bound * bound);
    assert_true(generator_memory_size(toy.g) > 4 * generator_n_weights(toy.g));
    toy_release(&toy);
}

static void test_refusals(void **state)
{
    static const struct generator_config bad[] = {
        {.width = 0},
        {.width = 1025},
        {.width = 8, .depth = 33},
        {.width = 8, .n_variables = 65537},
        {.width = 8, .patch_size = 257},
    };
    struct pool *pool = pool_new(2);
    struct generator *g;
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct error err = {{0}};
        assert_int_equal(generator_new(&bad[i], pool, 0, &g, &err), LMN_ERR_ARGUMENT);
        assert_null(g);
        assert_true(strlen(err.text) > 0 && !strchr(err.text, '\n'));
    }
    struct generator_config config = {.n_variables = 2, .width = 8, .depth = 1, .patch_size = 4};
    for (uint64_t n = 1;; n++) {
        struct error err = {{0}};
        mem_fail_after(n);
        lmn_status status = generator_new(&config, pool, 0, &g, &err);
        mem_fail_after(0);
        if (status == LMN_OK) break;
        assert_int_equal(status, LMN_ERR_MEMORY);
        assert_null(g);
        assert_true(n < 100);
    }
    generator_free(g);
    generator_free(NULL);
    pool_free(pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gradient), cmocka_unit_test(test_emission_blocks),
        cmocka_unit_test(test_render),   cmocka_unit_test(test_empty),
        cmocka_unit_test(test_threads),  cmocka_unit_test(test_probe),
        cmocka_unit_test(test_init),     cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
