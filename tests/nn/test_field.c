/* SPDX-License-Identifier: Apache-2.0 */
/* The compact network against a plain version in doubles: outputs, losses, and gradients by finite
 * differences. */
#include "nn/field.h"

#include <math.h>
#include <string.h>

#include "base/cpu.h"
#include "base/mem.h"
#include "base/pool.h"
#include "base/rng.h"
#include "toy.h"

enum { N_RUNS = 3, GRIDS = 2, FEATURES = 5, VARIABLES = 4, LIGHTS = 2, MOST_PIXELS = 300 };
static const uint32_t n_pixels[N_RUNS] = {7, 1, 150}; /* the last in more than one tile */

static const struct field_config config = {
    .n_grids = GRIDS,
    .grid = {.n_levels = 4, .log2_size = 7, .base = 3, .growth = 1.6f}, /* two levels hashed */
    .n_features = FEATURES,
    .n_variables = VARIABLES,
    .n_lights = LIGHTS,
    .width = 20,
    .depth = 2,
    .max_pixels = MOST_PIXELS};

static size_t n_weights; /* of a field of that shape */

struct data {
    float positions[MOST_PIXELS][GRIDS][3], features[MOST_PIXELS][FEATURES];
    float scale[MOST_PIXELS][3], targets[MOST_PIXELS][3], v[N_RUNS][VARIABLES];
    float lights[N_RUNS][LIGHTS][3], weights[MOST_PIXELS], halves[MOST_PIXELS][3];
    float cautions[MOST_PIXELS];
    struct field_run runs[N_RUNS];
};

static void fill(struct data *d)
{
    struct rng r = rng_keyed(1, 2, 3);
    size_t at = 0;
    for (size_t i = 0; i < MOST_PIXELS; i++) {
        for (int g = 0; g < GRIDS; g++) /* some beyond the cube */
            for (int a = 0; a < 3; a++) d->positions[i][g][a] = 1.2f * rng_float(&r) - 0.1f;
        for (int k = 0; k < FEATURES; k++) d->features[i][k] = 2.0f * rng_float(&r) - 1.0f;
        for (int c = 0; c < 3; c++) {
            d->scale[i][c] = 0.2f + rng_float(&r);
            d->targets[i][c] = 0.5f + 2.0f * rng_float(&r);
            d->halves[i][c] = 0.4f * (rng_float(&r) - 0.5f);
        }
        d->weights[i] = 0.2f + 2.0f * rng_float(&r);
        d->cautions[i] = 0.1f + 0.6f * rng_float(&r);
    }
    for (int i = 0; i < N_RUNS; i++) {
        for (int k = 0; k < VARIABLES; k++) d->v[i][k] = rng_float(&r);
        for (int l = 0; l < LIGHTS; l++)
            for (int c = 0; c < 3; c++) d->lights[i][l][c] = 0.2f + rng_float(&r);
        d->runs[i] = (struct field_run){.n = n_pixels[i],
                                        .positions = d->positions[at][0],
                                        .features = d->features[at],
                                        .scale = d->scale[at],
                                        .targets = d->targets[at],
                                        .v = d->v[i],
                                        .lights = i == 1 ? NULL : d->lights[i][0],
                                        .weights = i == 1 ? NULL : d->weights + at,
                                        .halves = i == 1 ? NULL : d->halves[at],
                                        .cautions = i == 1 ? NULL : d->cautions + at};

        at += n_pixels[i];
    }
}

/* ---- The plain version ---------------------------------------------------------------------- */

/* One level of a grid as the paper has it: the lattice's vertices around p. */
static void plain_level(uint32_t n, uint32_t n_entries, const float *p, const double *table,
                        double out[2])
{
    const uint64_t edge = (uint64_t)n + 1;
    uint64_t low[3];
    double f[3];
    for (int a = 0; a < 3; a++) {
        double x = fmin(fmax((double)p[a], 0.0), 1.0) * n;
        low[a] = x >= n ? n - 1 : (uint64_t)x;
        f[a] = x - (double)low[a];
    }
    out[0] = out[1] = 0;
    for (uint64_t z = 0; z < 2; z++)
        for (uint64_t y = 0; y < 2; y++)
            for (uint64_t x = 0; x < 2; x++) {
                uint64_t i = low[0] + x, j = low[1] + y, k = low[2] + z;
                uint64_t entry = i + edge * (j + edge * k);
                if (edge * edge * edge > n_entries)
                    entry = ((i ^ (j * 2654435761u) ^ (k * 805459861u)) & UINT32_MAX) % n_entries;
                double w = (x ? f[0] : 1 - f[0]) * (y ? f[1] : 1 - f[1]) * (z ? f[2] : 1 - f[2]);
                out[0] += w * table[2 * entry];
                out[1] += w * table[2 * entry + 1];
            }
}

/* Radiance of pixel i of a run, and the loss that is expected there. What is expected reads the
 * layers below with the weights `held`. */
static void plain_pixel(const double *weights, const double *held, const struct field_run *run,
                        uint32_t i, double out[3], double *expected)
{
    const struct field_config *c = &config;
    double x[2][64], y[64];
    for (int pass = 0; pass < 2; pass++) {
        const double *at = pass == 0 ? weights : held;
        uint32_t n = 0;
        for (uint32_t g = 0; g < c->n_grids; g++) {
            double cells = c->grid.base;
            for (uint32_t l = 0; l < c->grid.n_levels;
                 l++, cells *= (double)c->grid.growth, n += 2) {
                uint32_t edge = (uint32_t)cells + 1, most = 1u << c->grid.log2_size;
                uint32_t n_entries = edge * edge * edge < most ? edge * edge * edge : most;
                plain_level((uint32_t)cells, n_entries, run->positions + (i * c->n_grids + g) * 3,
                            at, x[pass] + n);
                at += 2 * (size_t)n_entries;
            }
        }
        for (uint32_t k = 0; k < c->n_features; k++)
            x[pass][n++] = (double)run->features[i * c->n_features + k];
        for (uint32_t k = 0; k < c->n_variables; k++) x[pass][n++] = (double)run->v[k];
        for (uint32_t l = 0; l < c->depth; l++) {
            for (uint32_t o = 0; o < c->width; o++) {
                y[o] = at[c->width * n + o];
                for (uint32_t k = 0; k < n; k++) y[o] += at[o * n + k] * x[pass][k];
                if (y[o] < 0) y[o] *= 0.01;
            }
            at += c->width * (n + 1);
            n = c->width;
            memcpy(x[pass], y, sizeof y);
        }
    }
    const uint32_t n_out = 3 * LIGHTS + 1, n = c->width;
    const double *last = weights + n_weights - n_out * (n + 1);
    for (uint32_t o = 0; o < n_out; o++) {
        y[o] = last[n_out * n + o];
        for (uint32_t k = 0; k < n; k++) y[o] += last[o * n + k] * x[o == n_out - 1][k];
        y[o] = fmin(fmax(y[o], -10), 12);
    }
    for (uint32_t k = 0; k < 3; k++) {
        out[k] = 0;
        for (uint32_t l = 0; l < LIGHTS; l++) {
            const double light = run->lights ? (double)run->lights[3 * l + k] : 1.0;
            out[k] += (double)run->scale[3 * i + k] * light * exp(y[3 * l + k]);
        }
    }
    *expected = y[n_out - 1];
}

static double luminance(const double *c)
{
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

/* What training minimises: the mean loss of all runs, whose denominators are those of the weights
 * `held`, and what is expected of it. */
static double plain_loss(const double *weights, const double *held, const struct data *d,
                         double *losses, double *errors)
{
    double sum = 0, n = 0;
    for (int i = 0; i < N_RUNS; i++) {
        const struct field_run *run = &d->runs[i];
        double of_run = 0, error = 0;
        for (uint32_t k = 0; k < n_pixels[i]; k++) {
            double f[3], h[3], s, s_held, loss = 0, loss_held = 0;
            plain_pixel(weights, held, run, k, f, &s);
            plain_pixel(held, held, run, k, h, &s_held);
            const double weight = run->weights ? (double)run->weights[k] : 1;
            const double caution = run->cautions ? (double)run->cautions[k] : 0.75;
            double y[2][3], per[2]; /* of both halves */
            for (int half = 0; half < 2; half++) {
                for (uint32_t c = 0; c < 3; c++) {
                    const double off = run->halves ? (double)run->halves[3 * k + c] : 0;
                    y[half][c] = (double)run->targets[3 * k + c] + (half == 0 ? off : -off);
                }
                const double l = luminance(h);
                per[half] = 1 / (l * ((1 - caution) * l + caution * luminance(y[half])) + 0.01);
            }
            for (uint32_t c = 0; c < 3; c++) {
                loss += 0.5 * (f[c] - y[0][c]) * (f[c] - y[0][c]) * per[1] +
                        0.5 * (f[c] - y[1][c]) * (f[c] - y[1][c]) * per[0];
                loss_held += 0.5 * (h[c] - y[0][c]) * (h[c] - y[0][c]) * per[1] +
                             0.5 * (h[c] - y[1][c]) * (h[c] - y[1][c]) * per[0];
                error += weight * (f[c] - y[0][c]) * (f[c] - y[1][c]) /
                         (luminance(h) * luminance(h) + 0.01);
            }
            of_run += weight * loss;
            sum += weight * loss + s + loss_held / 3 * exp(-s);
        }
        if (losses) losses[i] = of_run / (3.0 * n_pixels[i]);
        if (errors) errors[i] = error / (3.0 * n_pixels[i]);
        n += 3.0 * n_pixels[i];
    }
    return sum / n;
}

/* ---- Tests ---------------------------------------------------------------------------------- */

static struct field *make(struct pool *pool, uint32_t cpu)
{
    struct field *f;
    struct error err = {{0}};
    if (field_new(&config, pool, cpu, &f, &err) != LMN_OK) fail_msg("%s", err.text);
    field_init(f, 5);
    /* Larger numbers than at the start: all of them should matter. */
    struct rng r = rng_keyed(7, 8, 9);
    float *w = field_weights(f);
    for (size_t i = 0; i < field_n_table_weights(f); i++) w[i] = 2.0f * rng_float(&r) - 1.0f;
    for (size_t i = field_n_table_weights(f); i < field_n_weights(f); i++)
        w[i] += 0.2f * (rng_float(&r) - 0.5f);
    field_weights_changed(f);
    n_weights = field_n_weights(f);
    return f;
}

static double *doubles(const float *from, size_t n)
{
    double *to = toy_take(n, sizeof *to);
    for (size_t i = 0; i < n; i++) to[i] = (double)from[i];
    return to;
}

static const uint32_t sets[] = {0, CPU_AVX2, CPU_AVX2 | CPU_AVX512,
                                CPU_AVX2 | CPU_AVX512 | CPU_AMX};

static void gradients_are_differences(void **state)
{
    static struct data d;
    (void)state;
    fill(&d);
    for (size_t s = 0; s < sizeof sets / sizeof *sets; s++) {
        if ((cpu_detect() & sets[s]) != sets[s]) continue;
        struct pool *pool = pool_new(2);
        struct field *f = make(pool, sets[s]);
        const size_t n = field_n_weights(f);
        float losses[N_RUNS], errors[N_RUNS], *gradient = toy_take(n, sizeof *gradient);
        double *w = doubles(field_weights(f), n), *held = doubles(field_weights(f), n);
        double want[N_RUNS], want_errors[N_RUNS];
        field_gradient(f, d.runs, N_RUNS, losses, errors, gradient);
        plain_loss(w, held, &d, want, want_errors);
        for (int i = 0; i < N_RUNS; i++)
            if (!(fabs((double)losses[i] - want[i]) < 2e-5 * want[i]))
                fail_msg("run %d: loss %.8g, not %.8g", i, (double)losses[i], want[i]);
        for (int i = 0; i < N_RUNS; i++)
            if (!(fabs((double)errors[i] - want_errors[i]) < 2e-5 * want[i]))
                fail_msg("run %d: error %.8g, not %.8g", i, (double)errors[i], want_errors[i]);
        double largest = 0, worst = 0;
        size_t worst_at = 0, n_seen = 0;
        for (size_t i = 0; i < n; i++) largest = fmax(largest, fabs((double)gradient[i]));
        for (size_t i = 0; i < n; i += i < field_n_table_weights(f) ? 13 : 5, n_seen++) {
            const double h = 1e-5;
            w[i] = held[i] + h;
            double above = plain_loss(w, held, &d, NULL, NULL);
            w[i] = held[i] - h;
            double below = plain_loss(w, held, &d, NULL, NULL);
            w[i] = held[i];
            double off = fabs((above - below) / (2 * h) - (double)gradient[i]);
            if (off > worst) {
                worst = off;
                worst_at = i;
            }
        }
        if (!(worst < 1e-4 * largest))
            fail_msg("set %zu: of %zu derivatives number %zu is off by %.3g; the largest is %.3g",
                     s, n_seen, worst_at, worst, largest);
        mem_free(w);
        mem_free(held);
        mem_free(gradient);
        field_free(f);
        pool_free(pool);
    }
}

static void threads_do_not_matter(void **state)
{
    static struct data d;
    float losses[2][N_RUNS], *gradients[2];
    (void)state;
    fill(&d);
    for (uint32_t k = 0; k < 2; k++) {
        struct pool *pool = pool_new(1 + 2 * k);
        struct field *f = make(pool, cpu_detect());
        gradients[k] = toy_take(field_n_weights(f), sizeof *gradients[k]);
        field_gradient(f, d.runs, N_RUNS, losses[k], NULL, gradients[k]);
        if (k == 1)
            assert_memory_equal(gradients[0], gradients[1],
                                field_n_weights(f) * sizeof *gradients[0]);
        field_free(f);
        pool_free(pool);
    }
    assert_memory_equal(losses[0], losses[1], sizeof losses[0]);
    mem_free(gradients[0]);
    mem_free(gradients[1]);
}

static void compare(const struct field_run *run, const double *w, const float *out, size_t set)
{
    for (uint32_t k = 0; k < run->n; k++) {
        double want[3], expected;
        plain_pixel(w, w, run, k, want, &expected);
        for (uint32_t c = 0; c < 3; c++)
            if (!(fabs((double)out[3 * k + c] - want[c]) < 1e-4 * want[c]))
                fail_msg("set %zu pixel %u: %.8g, not %.8g", set, k, (double)out[3 * k + c],
                         want[c]);
    }
}

static void compare_expected(const struct field_run *run, const double *w, const float *out,
                             size_t set)
{
    for (uint32_t k = 0; k < run->n; k++) {
        double f[3], want;
        plain_pixel(w, w, run, k, f, &want);
        if (!(fabs((double)out[k] - exp(want)) < 1e-4 * exp(want)))
            fail_msg("set %zu pixel %u: expected %.8g, not %.8g", set, k, (double)out[k],
                     exp(want));
    }
}

/* What is rendered is what is trained, in parts as at once, in every instruction set. */
static void rendering_is_plain(void **state)
{
    static struct data d;
    float out[2][3 * MOST_PIXELS];
    (void)state;
    fill(&d);
    for (size_t s = 0; s < sizeof sets / sizeof *sets; s++) {
        if ((cpu_detect() & sets[s]) != sets[s]) continue;
        struct pool *pool = pool_new(2);
        struct field *f = make(pool, sets[s]);
        double *w = doubles(field_weights(f), field_n_weights(f));
        float expected[MOST_PIXELS], *at = expected;
        field_expect(f, d.runs, N_RUNS, expected);
        for (int i = 0; i < N_RUNS; at += d.runs[i++].n) {
            compare_expected(&d.runs[i], w, at, s);
            field_render(f, &d.runs[i], out[0]);
            compare(&d.runs[i], w, out[0], s);
            field_begin(f, d.runs[i].v, false);
            field_render_part(f, 1, &d.runs[i], out[1]);
            assert_memory_equal(out[0], out[1], 3 * d.runs[i].n * sizeof *out[0]);
        }
        mem_free(w);
        field_free(f);
        pool_free(pool);
    }
}

/* Rounded parts are near exact ones, and are rounded only when that is asked for. */
static void rounded_parts_are_near(void **state)
{
    const uint32_t set = CPU_AVX2 | CPU_AVX512 | CPU_AVX512BF16;
    static struct data d;
    float exact[3 * MOST_PIXELS], rounded[3 * MOST_PIXELS];
    uint32_t n_other = 0;
    (void)state;
    if ((cpu_detect() & set) != set) {
        print_message("skipped: this processor has no BF16 products\n");
        skip();
    }
    fill(&d);
    struct pool *pool = pool_new(2);
    struct field *f = make(pool, set);
    for (int i = 0; i < N_RUNS; i++) {
        const struct field_run *run = &d.runs[i];
        field_begin(f, run->v, true);
        field_render_part(f, 1, run, rounded);
        field_begin(f, run->v, false);
        field_render_part(f, 1, run, exact);
        for (uint32_t k = 0; k < 3 * run->n; k++) {
            n_other += rounded[k] != exact[k];
            if (!(fabsf(rounded[k] - exact[k]) < 0.01f * exact[k]))
                fail_msg("run %d value %u: %.8g, not %.8g", i, k, (double)rounded[k],
                         (double)exact[k]);
        }
    }
    assert_int_not_equal(n_other, 0);
    field_free(f);
    pool_free(pool);
}

/* A bright sphere whose place depends on v, seen through noise whose median is 0: the network finds
 * its mean. */
static void noise_is_averaged(void **state)
{
    enum { RUNS = 64, PIXELS = 32, STEPS = 600, N = RUNS * PIXELS };
    static float positions[N][3], targets[N][3], halves[N][3], scale[N][3], v[RUNS][1],
        out[PIXELS][3];
    const struct field_config small = {
        .n_grids = 1,
        .grid = {.n_levels = 4, .log2_size = 12, .base = 4, .growth = 1.5f},
        .n_variables = 1,
        .n_lights = 1,
        .width = 32,
        .depth = 2,
        .max_pixels = N};
    struct field_run runs[RUNS];
    float losses[RUNS], *gradient;
    struct pool *pool = pool_new(2);
    struct field *f;
    struct adam adam;
    (void)state;
    assert_int_equal(field_new(&small, pool, cpu_detect(), &f, NULL), LMN_OK);
    field_init(f, 1);
    assert_int_equal(adam_init(&adam, field_n_weights(f), 5e-3, NULL), LMN_OK);
    gradient = toy_take(field_n_weights(f), sizeof *gradient);
    for (size_t i = 0; i < N; i++) scale[i][0] = scale[i][1] = scale[i][2] = 0.5f;
    double error = 0;
    for (uint32_t step = 0; step <= STEPS; step++) {
        struct rng r = rng_keyed(3, step, 0);
        for (uint32_t i = 0; i < RUNS; i++) {
            v[i][0] = rng_float(&r);
            for (uint32_t k = i * PIXELS; k < (i + 1) * PIXELS; k++) {
                float d2 = 0;
                for (int c = 0; c < 3; c++) positions[k][c] = rng_float(&r);
                for (int c = 0; c < 3; c++) {
                    float off = positions[k][c] - (c == 0 ? v[i][0] : 0.5f);
                    d2 += off * off;
                }
                float mean = 0.2f + expf(-10.0f * d2);
                const float a = rng_float(&r) < 0.25f ? 4.0f * mean : 0.0f;
                const float b = rng_float(&r) < 0.25f ? 4.0f * mean : 0.0f;
                for (int c = 0; c < 3; c++) {
                    targets[k][c] = step == STEPS ? mean : 0.5f * (a + b);
                    halves[k][c] = 0.5f * (a - b);
                }
            }
            runs[i] = (struct field_run){.n = PIXELS,
                                         .positions = positions[i * PIXELS],
                                         .scale = scale[i * PIXELS],
                                         .targets = targets[i * PIXELS],
                                         .halves = halves[i * PIXELS],
                                         .v = v[i]};
        }
        if (step == STEPS) break;
        adam.learning_rate = 5e-3 * (1.0 - (double)step / STEPS);
        field_gradient(f, runs, RUNS, losses, NULL, gradient);
        adam_step(&adam, pool, field_weights(f), gradient);
        field_weights_changed(f);
    }
    for (uint32_t i = 0; i < RUNS; i++) {
        field_render(f, &runs[i], out[0]);
        for (uint32_t k = 0; k < PIXELS; k++) {
            double want = (double)targets[i * PIXELS + k][1];
            error += fabs((double)out[k][1] - want) / want / N;
        }
    }
    if (!(error < 0.12)) fail_msg("mean relative error %.3f", error);
    mem_free(gradient);
    adam_release(&adam);
    field_free(f);
    pool_free(pool);
}

static void bad_shapes_are_refused(void **state)
{
    (void)state;
    struct pool *pool = pool_new(1);
    for (int k = 0; k < 4; k++) {
        struct field_config c = config;
        struct error err = {{0}};
        struct field *f = NULL;
        if (k == 0) c.width = 0;
        if (k == 1) c.grid.n_levels = GRID_MAX_LEVELS + 1;
        if (k == 2) c.grid.growth = NAN;
        if (k == 3) c.n_grids = c.n_features = 0;
        assert_int_equal(field_new(&c, pool, 0, &f, &err), LMN_ERR_ARGUMENT);
        assert_null(f);
        assert_non_null(strstr(err.text, "network"));
    }
    pool_free(pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gradients_are_differences), cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(rendering_is_plain),        cmocka_unit_test(rounded_parts_are_near),
        cmocka_unit_test(noise_is_averaged),         cmocka_unit_test(bad_shapes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
