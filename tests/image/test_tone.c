/* SPDX-License-Identifier: Apache-2.0 */
/* The look-ups of the tone curve against the curve itself. */
#include "image/tone.h"

#include <math.h>

#include "base/mem.h"
#include "base/pool.h"
#include "image/image.h"

#include "cmocka_all.h"

static struct tone tone;

static void check(float x)
{
    const uint8_t want = tone_byte(srgb_encode(x)), got = tone_of(&tone, x);
    if (want != got) fail_msg("%.9g (%a): byte %d, not %d", (double)x, (double)x, got, want);
}

static void look_ups_are_the_curve(void **state)
{
    (void)state;
    /* Every 61st float up to 2, and those around each place where the byte goes up. */
    for (uint32_t bits = 0; bits < 0x40000000u; bits += 61) {
        float x;
        memcpy(&x, &bits, sizeof x);
        if (bits < 0x38000000u && bits % 16) continue; /* small ones: all 0 */
        check(x);
    }
    for (int k = 1; k < 256; k++) {
        check(tone.least[k]);
        check(nextafterf(tone.least[k], 0.0f));
        assert_int_equal(tone_of(&tone, tone.least[k]), k);
        assert_int_equal(tone_of(&tone, nextafterf(tone.least[k], 0.0f)), k - 1);
    }
    const float odd[] = {0.0f, -0.0f, -1.0f, 1.0f, 7.0f, INFINITY, -INFINITY, NAN, 1e-40f};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) check(odd[i]);
}

static void pieces_hold_one_step(void **state)
{
    (void)state;
    for (int i = 0; i + 1 < TONE_OCTAVES * TONE_PIECES; i++)
        assert_in_range(tone.first[i + 1] - tone.first[i], 0, 1);
}

/* Pixels of more channels; the film's curve rolls off, keeps the order and ends at white. */
static void pixels_are_done_alike(void **state)
{
    enum { N = 70001, STRIDE = 5 };
    float *linear = mem_new((size_t)N * STRIDE, sizeof *linear);
    uint8_t *out = mem_new((size_t)N * 3, 1), last = 0;
    struct pool *pool = pool_new(3);
    (void)state;
    assert_true(linear && out && pool);
    for (size_t i = 0; i < N; i++)
        for (size_t c = 0; c < STRIDE; c++) linear[i * STRIDE + c] = (float)(i + c) * (2.0f / N);
    tone_apply(&tone, pool, linear, N, STRIDE, 0.75f, TONE_SRGB, out);
    for (size_t i = 0; i < N * 3; i++)
        assert_int_equal(out[i], tone_of(&tone, 0.75f * linear[i / 3 * STRIDE + i % 3]));
    tone_apply(&tone, pool, linear, N, STRIDE, 8.0f, TONE_ACES, out);
    for (size_t i = 0; i < N; i++) {
        assert_true(out[3 * i] >= last);
        last = out[3 * i];
    }
    assert_in_range(out[3 * (N / 16)], 200, 235); /* 1, which sRGB would show white */
    assert_true(last == 255);
    linear[0] = NAN;
    linear[1] = INFINITY;
    linear[2] = -3;
    tone_apply(&tone, pool, linear, 1, STRIDE, 1.0f, TONE_ACES, out);
    assert_true(out[0] == 0 && out[1] == 255 && out[2] == 0);
    pool_free(pool);
    mem_free(linear);
    mem_free(out);
}

static void pictures_are_done_whole(void **state)
{
    enum { N_PIXELS = 66667, N = 3 * N_PIXELS };
    float *linear = mem_new(N, sizeof *linear);
    uint8_t *out = mem_new(N, 1);
    struct pool *pool = pool_new(3);
    (void)state;
    assert_true(linear && out && pool);
    for (int i = 0; i < N; i++) linear[i] = (float)i * (1.0f / N);
    tone_apply(&tone, pool, linear, N_PIXELS, 3, 1.5f, TONE_SRGB, out);
    for (int i = 0; i < N; i++) assert_int_equal(out[i], tone_byte(srgb_encode(1.5f * linear[i])));
    pool_free(pool);
    mem_free(linear);
    mem_free(out);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(look_ups_are_the_curve),
        cmocka_unit_test(pieces_hold_one_step),
        cmocka_unit_test(pixels_are_done_alike),
        cmocka_unit_test(pictures_are_done_whole),
    };
    tone_init(&tone);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
