/* SPDX-License-Identifier: Apache-2.0 */
#include "base/mem.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { ALIGNMENT = 64, ARENA_BLOCK_SIZE = 64 * 1024 };

/* Blocks from here on ask for huge pages before they are first touched: products over tensors miss
 * the TLB less, and 512 page faults become one. */
enum { HUGE_PAGE = 2 << 20, HUGE_BLOCK = 2 * HUGE_PAGE };

static uint64_t fail_countdown; /* 0: off */

void mem_fail_after(uint64_t n)
{
    fail_countdown = n;
}

static bool should_fail(void)
{
    if (fail_countdown == 0) return false;
    if (fail_countdown == 1) return true;
    fail_countdown--;
    return false;
}

static bool padded_size(size_t count, size_t size, size_t *out)
{
    size_t total;
    if (__builtin_mul_overflow(count, size, &total)) return false;
    if (total > SIZE_MAX - ALIGNMENT) return false;
    *out = (total + ALIGNMENT - 1) & ~(size_t)(ALIGNMENT - 1);
    if (*out == 0) *out = ALIGNMENT;
    return true;
}

void *mem_new(size_t count, size_t size)
{
    size_t total;
    if (!padded_size(count, size, &total) || should_fail()) return NULL;
    bool huge = total >= HUGE_BLOCK;
    /* Not aligned_alloc(), which wants sizes that are multiples of the alignment. */
    void *block = NULL;
    if (posix_memalign(&block, huge ? HUGE_PAGE : ALIGNMENT, total) != 0) return NULL;
    if (huge) madvise(block, total & ~(size_t)4095, MADV_HUGEPAGE); /* a hint: may fail */
    memset(block, 0, total);
    return block;
}

void mem_free(void *block)
{
    free(block);
}

bool mem_grow(void **block, size_t *capacity, size_t need, size_t size)
{
    if (need <= *capacity) return true;
    size_t wanted = *capacity < 8 ? 8 : *capacity;
    while (wanted < need) {
        if (wanted > SIZE_MAX / 2) return false;
        wanted *= 2;
    }
    void *bigger = mem_new(wanted, size);
    if (!bigger) return false;
    if (*block) memcpy(bigger, *block, *capacity * size);
    mem_free(*block);
    *block = bigger;
    *capacity = wanted;
    return true;
}

char *mem_strdup(const char *text)
{
    size_t n = strlen(text) + 1;
    char *copy = mem_new(n, 1);
    if (copy) memcpy(copy, text, n);
    return copy;
}

struct arena_block {
    struct arena_block *next;
    size_t used, size; /* bytes, after the header */
};

/* The header takes one alignment unit, so that the payload stays aligned. */
static char *payload(struct arena_block *b)
{
    return (char *)b + ALIGNMENT;
}

void *arena_new(struct arena *a, size_t count, size_t size)
{
    size_t total;
    if (!padded_size(count, size, &total)) return NULL;
    if (!a->head || a->head->size - a->head->used < total) {
        size_t block_size = total > ARENA_BLOCK_SIZE ? total : ARENA_BLOCK_SIZE;
        if (block_size > SIZE_MAX - ALIGNMENT) return NULL;
        struct arena_block *b = mem_new(block_size + ALIGNMENT, 1);
        if (!b) return NULL;
        *b = (struct arena_block){.next = a->head, .size = block_size};
        a->head = b;
    }
    void *out = payload(a->head) + a->head->used;
    a->head->used += total;
    a->total_size += total;
    return out;
}

char *arena_strdup(struct arena *a, const char *text)
{
    size_t n = strlen(text) + 1;
    char *copy = arena_new(a, n, 1);
    if (copy) memcpy(copy, text, n);
    return copy;
}

void arena_release(struct arena *a)
{
    while (a->head) {
        struct arena_block *next = a->head->next;
        mem_free(a->head);
        a->head = next;
    }
    *a = (struct arena){0};
}
