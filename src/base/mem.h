/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BASE_MEM_H
#define BASE_MEM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 * The only place that calls the heap. Every function returns NULL when memory is short or
 * count * size overflows; mem_free(NULL) is allowed. All blocks are aligned to 64 bytes, so that
 * they can hold tensors. Blocks come zeroed.
 */
void *mem_new(size_t count, size_t size);
void mem_free(void *block);

/*
 * Grows *block (NULL, or from mem_new) so that it holds at least `need` elements of `size` bytes,
 * doubling *capacity. Returns false, with *block as it was, when memory is short.
 */
bool mem_grow(void **block, size_t *capacity, size_t need, size_t size);

/* Copies a string; NULL when memory is short. */
char *mem_strdup(const char *text);

/* Test hook: the n-th allocation from now (1 = the next one) and all later ones fail; 0 switches it
 * off. Not thread safe. */
void mem_fail_after(uint64_t n);

/*
 * An arena: many small blocks with one lifetime, freed whole.
 *
 *   struct arena a = {0};  ... arena_new(&a, n, size) ...  arena_release(&a);
 */
struct arena {
    struct arena_block *head;
    size_t total_size; /* bytes handed out, for memory reports */
};

void *arena_new(struct arena *a, size_t count, size_t size);
char *arena_strdup(struct arena *a, const char *text);
void arena_release(struct arena *a);

#endif
