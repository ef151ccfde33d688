/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_NN_TOY_H
#define TESTS_NN_TOY_H

#include "base/cpu.h"
#include "base/pool.h"
#include "nn/generator.h"

/* After all headers of ours, as cmocka's macro fail() hides the function of base/error.h. First
 * what it wants before it, in its order. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* The instruction sets that tests go through, lowest first. */
extern const uint32_t toy_levels[];
extern const size_t toy_n_levels;

/* Whether this machine has it; says on the terminal when not. */
bool toy_level_runs(uint32_t cpu);

/* A network and a batch of random patches. Some pixels emit, some of them above the 1 where
 * emission replaces the network. */
struct toy {
    struct generator_config config;
    struct pool *pool;
    struct generator *g;
    struct generator_batch batch;
    float *inputs, *targets, *v; /* of all patches, one after the other */
    const float **pointers;
};

void toy_init(struct toy *toy, const struct generator_config *config, uint32_t n_patches,
              uint32_t n_threads, uint32_t cpu);
void toy_release(struct toy *toy);

/* Uniform in [-1, 1). */
void toy_fill(float *x, size_t n, uint64_t seed);

/* Zeroed; fails the test when there is no memory. Free with mem_free(). */
void *toy_take(size_t count, size_t size);

#endif
