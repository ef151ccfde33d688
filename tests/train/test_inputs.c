/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "train/inputs.h"

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

static void buffers_become_inputs(void **state)
{
    (void)state;
    const struct scene s = {.bounds = {.min = {-1, 0, 5}, .max = {3, 2, 5}}};
    float b[2 * BUFFER_CHANNELS] = {0}, x[2 * GENERATOR_INPUTS];
    float *hit = b + BUFFER_CHANNELS; /* the first pixel sees nothing */
    for (int c = 0; c < 3; c++) {
        hit[BUFFER_POSITION + c] = 1;
        hit[BUFFER_NORMAL + c] = c == 1 ? -1.0f : 0.5f;
        hit[BUFFER_ALBEDO + c] = 0.1f * (float)(c + 1);
        hit[BUFFER_WI + c] = 0.2f * (float)(c + 1);
        hit[BUFFER_EMISSION + c] = 40.0f + (float)c;
    }
    hit[BUFFER_ROUGHNESS] = 0.7f;
    inputs_from_buffers(&s, b, 2, x);
    const float nothing[GENERATOR_INPUTS] = {0, 0, 0, .5f, .5f, .5f, .25f};
    for (int i = 0; i < GENERATOR_INPUTS; i++) assert_true(x[i] == nothing[i]);
    /* emission 3 | normal 3 | position 3 | wi 3 | albedo 3 | alpha; a flat box gives 0. */
    const float wanted[GENERATOR_INPUTS] = {40, 41,   42,   .75f, 0,    .75f, .5f,  .5f,
                                            0,  0.2f, 0.4f, 0.6f, 0.1f, 0.2f, 0.3f, 0.7f};
    for (int i = 0; i < GENERATOR_INPUTS; i++)
        assert_float_equal(x[GENERATOR_INPUTS + i], wanted[i], 1e-6);
}

static void broken_values_do_not_pass(void **state)
{
    (void)state;
    const struct scene s = {.bounds = {.min = {0, 0, 0}, .max = {1, 1, 1}}};
    float b[BUFFER_CHANNELS], x[GENERATOR_INPUTS];
    const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < BUFFER_CHANNELS; i++) b[i] = bad[k];
        inputs_from_buffers(&s, b, 1, x);
        for (int i = 0; i < GENERATOR_INPUTS; i++) assert_true(isfinite(x[i]));
    }
    const float color[6] = {0, 1, NAN, INFINITY, -2, 1e6f};
    float t[6];
    inputs_targets(color, 2, t);
    const float wanted[6] = {0, logf(2), 0, 0, 0, logf(1e6f + 1)};
    for (int i = 0; i < 6; i++) assert_float_equal(t[i], wanted[i], 1e-5);
}

static void choices_are_quantised(void **state)
{
    (void)state;
    struct variable variables[3] = {{.n_choices = 0}, {.n_choices = 3}, {.n_choices = 1}};
    const struct scene s = {.variables = variables, .n_variables = 3};
    const float from[5] = {0, 0.33f, 0.34f, 0.67f, 0.99999994f}, to[5] = {0, 0, .5f, 1, 1};
    for (int i = 0; i < 5; i++) {
        const float u[3] = {from[i], from[i], from[i]};
        float v[3];
        inputs_variables(&s, u, v);
        assert_true(v[0] == from[i] && v[1] == to[i] && v[2] == 0);
    }
}

static void pictures_keep_their_proportions(void **state)
{
    (void)state;
    struct scene s = {.settings = {.width = 1280, .height = 720}};
    uint32_t w, h;
    inputs_picture_size(&s, 128, 32, &w, &h);
    assert_true(w == 128 && h == 72);
    s.settings.height = 128;
    inputs_picture_size(&s, 128, 32, &w, &h); /* 12.8 is less than a patch */
    assert_true(w == 128 && h == 32);
    s.settings = (struct render_settings){.width = 100, .height = 200};
    inputs_picture_size(&s, 601, 32, &w, &h);
    assert_true(w == 301 && h == 601);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(buffers_become_inputs),
        cmocka_unit_test(broken_values_do_not_pass),
        cmocka_unit_test(choices_are_quantised),
        cmocka_unit_test(pictures_keep_their_proportions),
    };
    return cmocka_run_group_tests_name("inputs", tests, NULL, NULL);
}
