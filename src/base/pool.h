/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BASE_POOL_H
#define BASE_POOL_H

#include <stdint.h>

/*
 * A fixed set of threads that run one parallel loop at a time. The calling thread is worker 0.
 * Items are handed out one by one in order, so which worker runs which item is a matter of chance:
 * an item's result must depend on the item alone, and reductions run over items in order
 * afterwards. Workers run with flush-to-zero and denormals-are-zero set.
 */
struct pool;

/* Runs item `item` of the loop on worker `worker` (0 .. pool_n_workers()-1). */
typedef void pool_fn(void *ctx, uint32_t item, uint32_t worker);

/* n_threads 0: every CPU in the process's affinity mask. NULL when memory or threads are short. */
struct pool *pool_new(uint32_t n_threads);
void pool_free(struct pool *p);

uint32_t pool_n_workers(const struct pool *p);

/* Runs fn for items 0 .. n_items-1 and returns when all are done. Not reentrant. */
void pool_run(struct pool *p, uint32_t n_items, pool_fn *fn, void *ctx);

#endif
