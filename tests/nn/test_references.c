/* SPDX-License-Identifier: Apache-2.0 */
/* Network, loss, gradients and Adam against PyTorch, as scripts/references/nn.py wrote them
 * down. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/mem.h"
#include "stored.h"
#include "toy.h"

enum { MAX_PATCHES = 8 };
static const double tolerance = 1e-4;

/* Layer by layer, so that small gradients of one are not hidden by another's. */
static void check_layers(const struct generator_config *c, const char *what, const float *got,
                         const float *want, double relative)
{
    size_t at = 0;
    for (uint32_t l = 0; l < c->depth + 3; l++) {
        size_t n_out = l < c->depth + 2 ? c->width : 3;
        size_t n_in = l == 0 ? 3 : (size_t)c->width + 13 + c->n_variables;
        size_t parts[] = {n_in * n_out, n_out};
        for (int part = 0; part < 2; part++) {
            char name[96];
            snprintf(name, sizeof name, "%s, layer %u, %s", what, l, part ? "biases" : "weights");
            check_close(name, got + at, want + at, parts[part], relative);
            at += parts[part];
        }
    }
}

static void set_batch(const struct stored *r, struct toy *toy)
{
    const struct generator_config *c = &toy->config;
    size_t area = (size_t)c->patch_size * c->patch_size, n = toy->batch.n_patches;
    memcpy(toy->inputs, stored_values(r, "inputs", n * area * GENERATOR_INPUTS),
           n * area * GENERATOR_INPUTS * sizeof(float));
    memcpy(toy->targets, stored_values(r, "targets", n * area * 3), n * area * 3 * sizeof(float));
    memcpy(toy->v, stored_values(r, "v", n * c->n_variables), n * c->n_variables * sizeof(float));
}

static void check(const struct stored *r, uint32_t cpu, bool legacy)
{
    struct generator_config c = {.n_variables = stored_number(r, "n_variables"),
                                 .width = stored_number(r, "width"),
                                 .depth = stored_number(r, "depth"),
                                 .patch_size = stored_number(r, "patch_size")};
    uint32_t n_patches = stored_number(r, "n_patches"), n_steps = stored_number(r, "n_steps");
    size_t area = (size_t)c.patch_size * c.patch_size;
    struct generator_loss loss = {.legacy_ssim = legacy};
    float losses[MAX_PATCHES], norms[MAX_PATCHES];
    struct toy toy;
    struct adam adam;
    char name[64];
    assert_true(n_patches > 0 && n_patches <= MAX_PATCHES);
    toy_init(&toy, &c, n_patches, 2, cpu);
    set_batch(r, &toy);
    size_t n = generator_n_weights(toy.g);
    float *w = generator_weights(toy.g), *gradient = toy_take(n, sizeof *gradient);
    float *out = toy_take(area * 3, sizeof *out);
    const float *start = stored_values(r, "weights", n);
    memcpy(w, start, n * sizeof *w);
    generator_weights_changed(toy.g);

    const float *outputs = stored_values(r, "outputs", n_patches * area * 3);
    for (uint32_t p = 0; p < n_patches; p++) {
        generator_render(toy.g, toy.batch.inputs[p], toy.batch.v[p], area, out);
        for (size_t i = 0; i < area * 3; i++) out[i] = log1pf(out[i]);
        check_close("outputs", out, outputs + p * area * 3, area * 3, tolerance);
    }

    const char *axes = legacy ? "legacy" : "correct";
    double rate = json_number_value(json_object_get(r->json, "learning_rate"));
    assert_int_equal(adam_init(&adam, n, rate, NULL), LMN_OK);
    for (uint32_t step = 0; step < n_steps; step++) {
        generator_gradient(toy.g, &toy.batch, &loss, losses, gradient);
        if (step == 0) {
            snprintf(name, sizeof name, "%s.losses", axes);
            check_close(name, losses, stored_values(r, name, n_patches), n_patches, tolerance);
            snprintf(name, sizeof name, "%s.gradient", axes);
            check_layers(&c, name, gradient, stored_values(r, name, n), tolerance);
            snprintf(name, sizeof name, "%s.gradient_norms", axes);
            generator_probe(toy.g, NULL, &toy.batch, &loss, losses, norms);
            check_close(name, norms, stored_values(r, name, n_patches), n_patches, tolerance);
        }
        adam_step(&adam, toy.pool, w, gradient);
        generator_weights_changed(toy.g);
    }
    snprintf(name, sizeof name, "%s.weights_after", axes);
    const float *after = stored_values(r, name, n);
    check_layers(&c, name, w, after, tolerance);

    /* The change itself, in norm: single weights of vanishing gradient may go either way. */
    double error = 0.0, size = 0.0;
    for (size_t i = 0; i < n; i++) {
        double d = (double)after[i] - (double)start[i], e = (double)w[i] - (double)after[i];
        error += e * e;
        size += d * d;
    }
    if (!(sqrt(error) <= 1e-3 * sqrt(size)))
        fail_msg("%s: change off by %.3g of %.3g", name, sqrt(error), sqrt(size));

    snprintf(name, sizeof name, "%s.step_norms", axes);
    generator_probe(toy.g, &adam, &toy.batch, &loss, losses, norms);
    check_close(name, norms, stored_values(r, name, n_patches), n_patches, tolerance);

    adam_release(&adam);
    mem_free(gradient);
    mem_free(out);
    toy_release(&toy);
}

static void check_levels(bool legacy)
{
    struct stored r;
    stored_load(&r, "nn");
    for (size_t i = 0; i < toy_n_levels; i++)
        if (toy_level_runs(toy_levels[i])) check(&r, toy_levels[i], legacy);
    stored_release(&r);
}

static void test_correct_axes(void **state)
{
    (void)state;
    check_levels(false);
}

static void test_legacy_axes(void **state)
{
    (void)state;
    check_levels(true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_correct_axes),
        cmocka_unit_test(test_legacy_axes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
