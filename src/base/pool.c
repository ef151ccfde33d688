/* SPDX-License-Identifier: Apache-2.0 */
#include "base/pool.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "base/mem.h"

enum { MAX_THREADS = 1024 };

struct worker {
    struct pool *pool;
    uint32_t index;
    pthread_t thread;
};

struct pool {
    uint32_t n_workers;
    struct worker *workers; /* workers[0] is the caller and has no thread of its own */

    pthread_mutex_t lock;
    pthread_cond_t wake, done;
    uint64_t generation; /* counts loops: a worker that sees a new one joins it */
    uint32_t n_busy;     /* threads that have not finished this loop */
    bool quit;

    pool_fn *fn;
    void *ctx;
    uint32_t n_items;
    atomic_uint next_item;
};

static void set_float_mode(void)
{
#if defined(__x86_64__)
    _mm_setcsr(_mm_getcsr() | 0x8040u); /* FTZ | DAZ: Embree wants it, denormals cost 100x */
#endif
}

static void work(struct pool *p, uint32_t worker)
{
    for (;;) {
        uint32_t item = atomic_fetch_add_explicit(&p->next_item, 1, memory_order_relaxed);
        if (item >= p->n_items) return;
        p->fn(p->ctx, item, worker);
    }
}

static void *thread_main(void *arg)
{
    struct worker *w = arg;
    struct pool *p = w->pool;
    uint64_t seen = 0;
    set_float_mode();
    pthread_mutex_lock(&p->lock);
    for (;;) {
        while (!p->quit && p->generation == seen) pthread_cond_wait(&p->wake, &p->lock);
        if (p->quit) break;
        seen = p->generation;
        pthread_mutex_unlock(&p->lock);
        work(p, w->index);
        pthread_mutex_lock(&p->lock);
        if (--p->n_busy == 0) pthread_cond_signal(&p->done);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

static uint32_t affinity_count(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0) return 1;
    int n = CPU_COUNT(&set);
    return n > 0 ? (uint32_t)n : 1;
}

struct pool *pool_new(uint32_t n_threads)
{
    if (n_threads == 0) n_threads = affinity_count();
    if (n_threads > MAX_THREADS) n_threads = MAX_THREADS;
    struct pool *p = mem_new(1, sizeof *p);
    struct worker *workers = mem_new(n_threads, sizeof *workers);
    if (!p || !workers) {
        mem_free(p);
        mem_free(workers);
        return NULL;
    }
    p->workers = workers;
    p->n_workers = 1;
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->wake, NULL);
    pthread_cond_init(&p->done, NULL);
    for (uint32_t i = 1; i < n_threads; i++) {
        workers[i] = (struct worker){.pool = p, .index = i};
        if (pthread_create(&workers[i].thread, NULL, thread_main, &workers[i]) != 0) {
            pool_free(p);
            return NULL;
        }
        p->n_workers++;
    }
    return p;
}

void pool_free(struct pool *p)
{
    if (!p) return;
    pthread_mutex_lock(&p->lock);
    p->quit = true;
    pthread_cond_broadcast(&p->wake);
    pthread_mutex_unlock(&p->lock);
    for (uint32_t i = 1; i < p->n_workers; i++) pthread_join(p->workers[i].thread, NULL);
    pthread_cond_destroy(&p->wake);
    pthread_cond_destroy(&p->done);
    pthread_mutex_destroy(&p->lock);
    mem_free(p->workers);
    mem_free(p);
}

uint32_t pool_n_workers(const struct pool *p)
{
    return p->n_workers;
}

void pool_run(struct pool *p, uint32_t n_items, pool_fn *fn, void *ctx)
{
    set_float_mode();
    pthread_mutex_lock(&p->lock);
    p->fn = fn;
    p->ctx = ctx;
    p->n_items = n_items;
    atomic_store_explicit(&p->next_item, 0, memory_order_relaxed);
    p->n_busy = p->n_workers - 1;
    p->generation++;
    pthread_cond_broadcast(&p->wake);
    pthread_mutex_unlock(&p->lock);

    work(p, 0);

    pthread_mutex_lock(&p->lock);
    while (p->n_busy > 0) pthread_cond_wait(&p->done, &p->lock);
    pthread_mutex_unlock(&p->lock);
}
