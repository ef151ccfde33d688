/* SPDX-License-Identifier: Apache-2.0 */
/* The heap, growing blocks, arenas, and allocations that fail on demand. */
#include "base/mem.h"

#include <string.h>

#include "cmocka_all.h"

static bool is_aligned(const void *p)
{
    return (uintptr_t)p % 64 == 0;
}

static bool is_zero(const void *p, size_t size)
{
    const unsigned char *b = p;
    for (size_t i = 0; i < size; i++)
        if (b[i]) return false;
    return true;
}

static void test_new(void **state)
{
    (void)state;
    static const size_t sizes[] = {0, 1, 63, 64, 65, 4097, 1000000};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        char *p = mem_new(sizes[i], 1);
        assert_non_null(p);
        assert_true(is_aligned(p) && is_zero(p, sizes[i]));
        memset(p, 0xA5, sizes[i]);
        mem_free(p);
    }
    mem_free(NULL);
    assert_null(mem_new(SIZE_MAX, 1));
    assert_null(mem_new(SIZE_MAX - 10, 1)); /* room for padding is part of the size */
    assert_null(mem_new(SIZE_MAX / 2 + 1, 2));
    assert_null(mem_new((size_t)1 << 33, (size_t)1 << 33));
}

static void test_grow(void **state)
{
    (void)state;
    void *block = NULL;
    size_t capacity = 0, n_moves = 0;
    for (size_t n = 1; n <= 10000; n++) {
        void *before = block;
        assert_true(mem_grow(&block, &capacity, n, sizeof(uint32_t)));
        assert_true(capacity >= n && is_aligned(block));
        n_moves += block != before;
        uint32_t *v = block;
        v[n - 1] = (uint32_t)n;
        assert_true(v[n / 2] == n / 2 + 1 && v[0] == 1);
    }
    assert_true(n_moves < 16); /* it doubles */
    assert_true(is_zero((uint32_t *)block + 10000, (capacity - 10000) * sizeof(uint32_t)));
    /* a failure leaves all as it was */
    void *before = block;
    size_t capacity_before = capacity;
    assert_false(mem_grow(&block, &capacity, SIZE_MAX / 2, sizeof(uint32_t)));
    assert_false(mem_grow(&block, &capacity, SIZE_MAX, sizeof(uint32_t)));
    mem_fail_after(1);
    assert_false(mem_grow(&block, &capacity, 100000, sizeof(uint32_t)));
    mem_fail_after(0);
    assert_true(block == before && capacity == capacity_before &&
                ((uint32_t *)block)[9999] == 10000);
    mem_free(block);
}

static void test_fail_after(void **state)
{
    (void)state;
    mem_fail_after(3);
    void *a = mem_new(1, 1), *b = mem_new(1, 1);
    assert_true(a && b);
    assert_null(mem_new(1, 1)); /* the third, and all later ones */
    assert_null(mem_new(1, 1));
    assert_null(mem_strdup("x"));
    mem_fail_after(0);
    char *c = mem_strdup("x");
    assert_string_equal(c, "x");
    mem_free(a);
    mem_free(b);
    mem_free(c);
}

static void test_arena(void **state)
{
    (void)state;
    struct arena a = {0};
    enum { N = 3000 };
    static unsigned char *blocks[N];
    size_t total = 0;
    for (size_t i = 0; i < N; i++) {
        size_t size = i % 100 == 0 ? 200000 : i % 97; /* some larger than a block of the arena */
        blocks[i] = arena_new(&a, size, 1);
        assert_non_null(blocks[i]);
        assert_true(is_aligned(blocks[i]) && is_zero(blocks[i], size));
        memset(blocks[i], (int)(i % 251), size);
        total += size;
    }
    for (size_t i = 0; i < N; i++) { /* none overlaps another */
        size_t size = i % 100 == 0 ? 200000 : i % 97;
        for (size_t k = 0; k < size; k++) assert_true(blocks[i][k] == i % 251);
    }
    assert_true(a.total_size >= total && a.total_size < total + N * 64);
    assert_string_equal(arena_strdup(&a, "a name"), "a name");
    assert_null(arena_new(&a, SIZE_MAX, 2));
    assert_null(arena_new(&a, SIZE_MAX - 100, 1));
    arena_release(&a);
    assert_true(!a.head && a.total_size == 0);
    arena_release(&a);

    mem_fail_after(1);
    assert_null(arena_new(&a, 10, 1));
    assert_null(arena_strdup(&a, "x"));
    mem_fail_after(0);
    assert_non_null(arena_new(&a, 10, 1)); /* usable again */
    arena_release(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_new),
        cmocka_unit_test(test_grow),
        cmocka_unit_test(test_fail_after),
        cmocka_unit_test(test_arena),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
