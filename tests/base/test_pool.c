/* SPDX-License-Identifier: Apache-2.0 */
/* The thread pool: every item once, whatever the number of threads. */
#include "base/pool.h"

#include <stdatomic.h>
#include <string.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "cmocka_all.h"

#include "base/clock.h"
#include "base/cpu.h"
#include "base/mem.h"

enum { MAX_ITEMS = 5000, MAX_WORKERS = 8 };

struct loop {
    atomic_uint runs[MAX_ITEMS];   /* of each item */
    atomic_uint busy[MAX_WORKERS]; /* items that a worker is in now */
    atomic_uint n_faults;
    uint32_t n_items, n_workers;
    uint64_t results[MAX_ITEMS];
};

static void run_item(void *ctx, uint32_t item, uint32_t worker)
{
    struct loop *l = ctx;
    if (item >= l->n_items || worker >= l->n_workers) {
        atomic_fetch_add(&l->n_faults, 1);
        return;
    }
    if (atomic_fetch_add(&l->busy[worker], 1) != 0) atomic_fetch_add(&l->n_faults, 1);
    atomic_fetch_add(&l->runs[item], 1);
    uint64_t h = item; /* some work, that depends on the item alone */
    for (uint32_t i = 0; i < 20 + item % 300; i++)
        h = h * 6364136223846793005u + 1442695040888963407u;
    l->results[item] = h;
    atomic_fetch_sub(&l->busy[worker], 1);
}

static void check_loop(struct pool *p, struct loop *l, uint32_t n_items)
{
    memset(l, 0, sizeof *l);
    l->n_items = n_items;
    l->n_workers = pool_n_workers(p);
    pool_run(p, n_items, run_item, l);
    assert_int_equal(l->n_faults, 0);
    for (uint32_t i = 0; i < MAX_ITEMS; i++)
        if (l->runs[i] != (i < n_items))
            fail_msg("item %u of %u ran %u times", i, n_items, l->runs[i]);
}

static void test_all_once(void **state)
{
    (void)state;
    static struct loop l;
    static uint64_t expected[MAX_ITEMS];
    for (uint32_t n_threads = 1; n_threads <= MAX_WORKERS; n_threads++) {
        struct pool *p = pool_new(n_threads);
        assert_non_null(p);
        assert_int_equal(pool_n_workers(p), n_threads);
        static const uint32_t counts[] = {0, 1, 2, 7, 8, 9, 100, MAX_ITEMS};
        for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) check_loop(p, &l, counts[i]);
        if (n_threads == 1) memcpy(expected, l.results, sizeof expected);
        assert_memory_equal(l.results, expected, sizeof expected);
        pool_free(p);
    }
}

/* Many short loops in a row: no worker may join a loop late or twice. */
static void test_repeated(void **state)
{
    (void)state;
    static struct loop l;
    for (uint32_t n_threads = 2; n_threads <= MAX_WORKERS; n_threads *= 2) {
        struct pool *p = pool_new(n_threads);
        assert_non_null(p);
        for (uint32_t round = 0; round < 400; round++) check_loop(p, &l, round % 17);
        pool_free(p);
    }
}

static void test_life(void **state)
{
    (void)state;
    struct pool *p = pool_new(0);
    assert_non_null(p);
    assert_true(pool_n_workers(p) >= 1);
    pool_free(p);
    pool_free(NULL);
    for (int i = 0; i < 50; i++) pool_free(pool_new(4)); /* ends without ever running */
    for (uint64_t n = 1; n <= 2; n++) {
        mem_fail_after(n);
        assert_null(pool_new(3));
        mem_fail_after(0);
    }
}

#if defined(__x86_64__)
static void read_mode(void *ctx, uint32_t item, uint32_t worker)
{
    (void)worker;
    ((unsigned *)ctx)[item] = _mm_getcsr() & 0x8040u;
}

static void test_float_mode(void **state)
{
    (void)state;
    unsigned modes[64] = {0};
    struct pool *p = pool_new(3);
    pool_run(p, 64, read_mode, modes);
    for (int i = 0; i < 64; i++) assert_int_equal(modes[i], 0x8040u);
    pool_free(p);
}
#endif

static void test_clock_and_cpu(void **state)
{
    (void)state;
    double wall = clock_wall_s(), cpu = clock_cpu_s();
    volatile double sum = 0;
    for (int i = 0; i < 3000000; i++) sum += i;
    assert_true(sum > 0 && clock_wall_s() > wall && clock_cpu_s() > cpu);

    uint32_t found = cpu_detect();
    assert_int_equal(found & ~(uint32_t)CPU_ALL, 0);
    assert_int_equal(cpu_mask_from_name(cpu_name(found)), found);
    assert_int_equal(cpu_mask_from_name("baseline"), 0);
    assert_int_equal(cpu_mask_from_name("avx1024"), UINT32_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_once),
        cmocka_unit_test(test_repeated),
        cmocka_unit_test(test_life),
#if defined(__x86_64__)
        cmocka_unit_test(test_float_mode),
#endif
        cmocka_unit_test(test_clock_and_cpu),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
