/* SPDX-License-Identifier: Apache-2.0 */
/* The compact network against PyTorch, as scripts/references/field.py wrote it down: outputs,
 * losses, and the gradient of every level of every grid and every layer. */
#include <stdio.h>
#include <string.h>

#include "base/mem.h"
#include "nn/field.h"
#include "stored.h"
#include "toy.h"

enum { MAX_RUNS = 8 };
static const double tolerance = 1e-4;

static struct field_config config_of(const struct stored *r)
{
    const double growth = json_number_value(json_object_get(r->json, "growth"));
    return (struct field_config){.n_grids = stored_number(r, "n_grids"),
                                 .grid = {.n_levels = stored_number(r, "n_levels"),
                                          .log2_size = stored_number(r, "log2_size"),
                                          .base = stored_number(r, "base"),
                                          .growth = (float)growth},
                                 .n_features = stored_number(r, "n_features"),
                                 .n_variables = stored_number(r, "n_variables"),
                                 .n_lights = stored_number(r, "n_lights"),
                                 .width = stored_number(r, "width"),
                                 .depth = stored_number(r, "depth")};
}

/* Part by part, so that small gradients of one are not hidden by another's. */
static void check_parts(const struct field_config *c, const float *got, const float *want)
{
    struct grid grid;
    char name[64];
    size_t at = 0;
    grid_init(&grid, &c->grid);
    for (uint32_t g = 0; g < c->n_grids; g++)
        for (uint32_t l = 0; l < grid.n_levels; l++) {
            const size_t n = grid.at[l + 1] - grid.at[l];
            snprintf(name, sizeof name, "gradient, grid %u, level %u", g, l);
            check_close(name, got + at, want + at, n, tolerance);
            at += n;
        }
    const size_t n_first = c->n_grids * grid.n_levels * GRID_FEATURES + c->n_features +
                           c->n_variables;
    for (uint32_t l = 0; l <= c->depth; l++) {
        const size_t n_out = l < c->depth ? c->width : 3 * c->n_lights + 1;
        const size_t n_in = l == 0 ? n_first : c->width;
        const size_t parts[2] = {n_out * n_in, n_out};
        for (int part = 0; part < 2; part++) {
            snprintf(name, sizeof name, "gradient, layer %u, %s", l, part ? "biases" : "weights");
            check_close(name, got + at, want + at, parts[part], tolerance);
            at += parts[part];
        }
    }
}

/* The runs of the file, one after the other; returns how many pixels they have. */
static uint32_t set_runs(const struct stored *r, const struct field_config *c,
                         struct field_run *runs, uint32_t *n_runs)
{
    const json_t *list = json_object_get(r->json, "runs");
    uint32_t n = 0;
    *n_runs = (uint32_t)json_array_size(list);
    assert_in_range(*n_runs, 1, MAX_RUNS);
    memset(runs, 0, *n_runs * sizeof *runs);
    for (uint32_t i = 0; i < *n_runs; i++) {
        runs[i].n = (uint32_t)json_integer_value(json_array_get(list, i));
        n += runs[i].n;
    }
    const size_t n_p = (size_t)c->n_grids * 3, n_f = c->n_features, n_v = c->n_variables;
    const size_t n_l = (size_t)c->n_lights * 3;
    const float *positions = stored_values(r, "positions", n * n_p);
    const float *features = stored_values(r, "features", n * n_f);
    const float *scale = stored_values(r, "scale", n * (size_t)3);
    const float *targets = stored_values(r, "targets", n * (size_t)3);
    const float *halves = stored_values(r, "halves", n * (size_t)3);
    const float *weights = stored_values(r, "weights_of_pixels", n);
    const float *v = stored_values(r, "v", *n_runs * n_v);
    const float *lights = stored_values(r, "lights", *n_runs * n_l);
    size_t first = 0;
    for (uint32_t i = 0; i < *n_runs; i++) {
        runs[i].positions = positions + first * n_p;
        runs[i].features = features + first * n_f;
        runs[i].scale = scale + first * 3;
        runs[i].targets = targets + first * 3;
        runs[i].halves = halves + first * 3;
        runs[i].weights = weights + first;
        runs[i].v = v + i * n_v;
        runs[i].lights = lights + i * n_l;
        first += runs[i].n;
    }
    return n;
}

static void check(const struct stored *r, uint32_t cpu)
{
    struct field_config c = config_of(r);
    struct field_run runs[MAX_RUNS];
    struct error err = {{0}};
    struct field *f;
    float losses[MAX_RUNS], errors[MAX_RUNS];
    uint32_t n_runs;
    const uint32_t n_pixels = set_runs(r, &c, runs, &n_runs);
    struct pool *pool = pool_new(2);
    assert_non_null(pool);
    c.max_pixels = n_pixels;
    if (field_new(&c, pool, cpu, &f, &err) != LMN_OK) fail_msg("%s", err.text);
    const size_t n = field_n_weights(f);
    float *gradient = toy_take(n, sizeof *gradient);
    float *out = toy_take(n_pixels * (size_t)3, sizeof *out);
    memcpy(field_weights(f), stored_values(r, "weights", n), n * sizeof(float));
    field_weights_changed(f);

    size_t first = 0;
    for (uint32_t i = 0; i < n_runs; first += runs[i++].n)
        field_render(f, &runs[i], out + 3 * first);
    check_close("outputs", out, stored_values(r, "outputs", 3 * first), 3 * first, tolerance);
    field_gradient(f, runs, n_runs, losses, errors, gradient);
    for (uint32_t i = 0; i < n_runs; i++)
        check_close("losses", losses + i, stored_values(r, "losses", n_runs) + i, 1, tolerance);
    check_close("errors", errors, stored_values(r, "errors", n_runs), n_runs, tolerance);
    check_parts(&c, gradient, stored_values(r, "gradient", n));

    mem_free(gradient);
    mem_free(out);
    field_free(f);
    pool_free(pool);
}

static void every_instruction_set_agrees(void **state)
{
    struct stored r;
    (void)state;
    stored_load(&r, "field");
    for (size_t i = 0; i < toy_n_levels; i++)
        if (toy_level_runs(toy_levels[i])) check(&r, toy_levels[i]);
    stored_release(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_instruction_set_agrees)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
