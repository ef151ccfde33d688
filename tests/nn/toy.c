/* SPDX-License-Identifier: Apache-2.0 */
#include "toy.h"

#include "base/mem.h"
#include "base/rng.h"

const uint32_t toy_levels[] = {0, CPU_AVX2, CPU_AVX2 | CPU_AVX512, CPU_ALL};
const size_t toy_n_levels = sizeof toy_levels / sizeof *toy_levels;

bool toy_level_runs(uint32_t cpu)
{
    if ((cpu_detect() & cpu) == cpu) return true;
    print_message("skipped: this machine has no %s\n", cpu_name(cpu));
    return false;
}

void *toy_take(size_t count, size_t size)
{
    void *block = mem_new(count, size);
    assert_non_null(block);
    return block;
}

void toy_fill(float *x, size_t n, uint64_t seed)
{
    struct rng r = rng_keyed(seed, 0, 0);
    for (size_t i = 0; i < n; i++) x[i] = 2.0f * rng_float(&r) - 1.0f;
}

void toy_init(struct toy *toy, const struct generator_config *config, uint32_t n_patches,
              uint32_t n_threads, uint32_t cpu)
{
    struct error err = {{0}};
    size_t area = (size_t)config->patch_size * config->patch_size, d = config->n_variables;
    size_t n_inputs = area * GENERATOR_INPUTS, n_targets = area * 3;
    *toy = (struct toy){.config = *config, .pool = pool_new(n_threads)};
    assert_non_null(toy->pool);
    if (generator_new(config, toy->pool, cpu, &toy->g, &err) != LMN_OK) fail_msg("%s", err.text);
    generator_init(toy->g, 7);

    toy->inputs = toy_take(n_patches * n_inputs, sizeof(float));
    toy->targets = toy_take(n_patches * n_targets, sizeof(float));
    toy->v = toy_take(n_patches * d + 1, sizeof(float));
    toy->pointers = toy_take((size_t)3 * n_patches, sizeof *toy->pointers);
    for (uint32_t p = 0; p < n_patches; p++) {
        struct rng r = rng_keyed(3, p, 0);
        float *inputs = toy->inputs + p * n_inputs, *targets = toy->targets + p * n_targets;
        float *v = toy->v + p * d;
        for (size_t i = 0; i < n_inputs; i++) {
            inputs[i] = rng_float(&r);
            if (i % GENERATOR_INPUTS < 3 && rng_float(&r) > 0.2f) inputs[i] = 0.0f;
            if (i % GENERATOR_INPUTS < 3 && rng_float(&r) > 0.7f) inputs[i] *= 5.0f;
        }
        for (size_t i = 0; i < n_targets; i++) targets[i] = 1.5f * rng_float(&r);
        for (size_t i = 0; i < d; i++) v[i] = rng_float(&r);
        toy->pointers[p] = inputs;
        toy->pointers[n_patches + p] = targets;
        toy->pointers[2 * n_patches + p] = v;
    }
    toy->batch = (struct generator_batch){.n_patches = n_patches,
                                          .inputs = toy->pointers,
                                          .targets = toy->pointers + n_patches,
                                          .v = toy->pointers + 2 * n_patches};
}

void toy_release(struct toy *toy)
{
    generator_free(toy->g);
    pool_free(toy->pool);
    mem_free(toy->inputs);
    mem_free(toy->targets);
    mem_free(toy->v);
    mem_free(toy->pointers);
    *toy = (struct toy){0};
}
