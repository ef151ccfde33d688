/* SPDX-License-Identifier: Apache-2.0 */
/* Random numbers: uniform within a key, independent between keys. All tests are deterministic; a
 * chi square of k - 1 degrees of freedom has mean k - 1 and variance 2 (k - 1), and five standard
 * deviations are allowed. */
#include "base/rng.h"

#include <math.h>
#include <string.h>

#include "cmocka_all.h"

#include "base/hash.h"

static void check_uniform(const uint32_t *counts, uint32_t n_bins, const char *what)
{
    double n = 0, chi = 0;
    for (uint32_t i = 0; i < n_bins; i++) n += counts[i];
    for (uint32_t i = 0; i < n_bins; i++) {
        double d = counts[i] - n / n_bins;
        chi += d * d / (n / n_bins);
    }
    double freedom = n_bins - 1;
    if (fabs(chi - freedom) > 5 * sqrt(2 * freedom)) /* too even is wrong, too */
        fail_msg("%s: chi square %.1f with %.0f degrees of freedom", what, chi, freedom);
}

static void test_within(void **state)
{
    (void)state;
    enum { BINS = 256, N = 200000 };
    static uint32_t counts[BINS];
    for (uint64_t seed = 0; seed < 4; seed++) {
        struct rng r = rng_keyed(seed, 0, 0);
        memset(counts, 0, sizeof counts);
        for (int i = 0; i < N; i++) counts[(uint32_t)(rng_float(&r) * BINS)]++;
        check_uniform(counts, BINS, "floats");
        memset(counts, 0, sizeof counts);
        for (int i = 0; i < N; i++) counts[(uint32_t)(rng_double(&r) * BINS)]++;
        check_uniform(counts, BINS, "doubles");
        memset(counts, 0, sizeof counts);
        for (int i = 0; i < N; i++) counts[rng_below(&r, 200)]++;
        check_uniform(counts, 200, "rng_below");
        memset(counts, 0, sizeof counts);
        for (int i = 0; i < N; i++) counts[rng_u32(&r) % BINS]++; /* low bits */
        check_uniform(counts, BINS, "low bits");
    }
}

/* The first numbers of neighbouring keys: pairs fall uniformly into a 16 x 16 grid. */
static void test_between_keys(void **state)
{
    (void)state;
    enum { SIDE = 16, N = 100000 };
    static uint32_t pairs[3][SIDE * SIDE];
    static uint32_t first[SIDE * SIDE];
    memset(pairs, 0, sizeof pairs);
    for (uint64_t i = 0; i < N; i++) {
        struct rng r = rng_keyed(1, i, 0),
                   next[3] = {rng_keyed(1, i + 1, 0), rng_keyed(1, i, 1), rng_keyed(2, i, 0)};
        float u = rng_float(&r);
        first[(uint32_t)(u * SIDE * SIDE)]++;
        for (int k = 0; k < 3; k++) {
            float v = rng_float(&next[k]);
            pairs[k][(uint32_t)(u * SIDE) * SIDE + (uint32_t)(v * SIDE)]++;
        }
    }
    check_uniform(first, SIDE * SIDE, "first numbers");
    check_uniform(pairs[0], SIDE * SIDE, "keys a and a + 1");
    check_uniform(pairs[1], SIDE * SIDE, "keys b and b + 1");
    check_uniform(pairs[2], SIDE * SIDE, "seeds");
}

/* Streams of keys do not overlap or correlate: the sum of products of 1000 streams' numbers. */
static void test_streams(void **state)
{
    (void)state;
    enum { N = 1000, LENGTH = 500 };
    double worst = 0;
    for (uint64_t k = 0; k < N; k++) {
        struct rng a = rng_keyed(9, k, 3), b = rng_keyed(9, k + 1, 3);
        double sum = 0;
        for (int i = 0; i < LENGTH; i++)
            sum += ((double)rng_float(&a) - 0.5) * ((double)rng_float(&b) - 0.5);
        /* each product has variance 1/144 */
        worst = fmax(worst, fabs(sum) / sqrt(LENGTH / 144.0));
    }
    assert_true(worst < 5); /* of 1000 normal deviates the largest is about 3.3 */
    assert_true(worst > 2);
}

static void test_keys(void **state)
{
    (void)state;
    /* same key, same numbers; words of the key are not exchangeable */
    struct rng a = rng_keyed(1, 2, 3), b = rng_keyed(1, 2, 3), c = rng_keyed(1, 3, 2);
    struct rng d = rng_keyed(2, 1, 3);
    assert_true(a.state == b.state && a.stream == b.stream);
    assert_true(a.state != c.state && a.state != d.state && c.state != d.state);
    for (int i = 0; i < 100; i++) assert_int_equal(rng_u32(&a), rng_u32(&b));
    for (uint64_t i = 0; i < 1000; i++) assert_true(rng_keyed(i, i, i).stream & 1);
    /* kept for ever: models and images depend on it */
    struct rng kept = rng_keyed(42, 7, 1);
    static const uint32_t want[3] = {1510952866u, 3252294583u, 3408690306u};
    for (int i = 0; i < 3; i++) assert_int_equal(rng_u32(&kept), want[i]);
}

static void test_bounds(void **state)
{
    (void)state;
    struct rng r = rng_keyed(0, 0, 0);
    for (int i = 0; i < 300000; i++) {
        float f = rng_float(&r);
        double d = rng_double(&r);
        assert_true(f >= 0 && f < 1 && d >= 0 && d < 1);
        assert_true(rng_below(&r, 1) == 0 && rng_below(&r, 3) < 3);
        assert_true(rng_below(&r, UINT32_MAX) < UINT32_MAX);
    }
    /* the largest word still gives less than 1 */
    assert_true((float)(UINT32_MAX >> 8) * 0x1p-24f < 1);
}

static void test_hash(void **state)
{
    (void)state;
    /* FNV-1a's published values */
    assert_true(hash_bytes(HASH_START, "", 0) == 0xcbf29ce484222325u);
    assert_true(hash_bytes(HASH_START, "a", 1) == 0xaf63dc4c8601ec8cu);
    assert_true(hash_bytes(HASH_START, "foobar", 6) == 0x85944171f73967e8u);
    assert_true(hash_bytes(hash_bytes(HASH_START, "foo", 3), "bar", 3) == 0x85944171f73967e8u);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_within),  cmocka_unit_test(test_between_keys),
        cmocka_unit_test(test_streams), cmocka_unit_test(test_keys),
        cmocka_unit_test(test_bounds),  cmocka_unit_test(test_hash),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
