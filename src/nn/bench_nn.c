/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/bench_nn.h"

#include <stdlib.h>

#include "base/clock.h"
#include "base/mem.h"
#include "base/pool.h"
#include "base/rng.h"
#include "nn/rounded.h"

struct spin {
    double (*peak)(uint64_t n);
    uint64_t n;
    double *flop; /* per item */
};

static void spin_item(void *ctx, uint32_t item, uint32_t worker)
{
    const struct spin *s = ctx;
    (void)worker;
    s->flop[item] = s->peak(s->n);
}

static double measure_peak(double (*peak)(uint64_t n), struct pool *pool)
{
    uint32_t n_items = pool_n_workers(pool);
    double *flop = mem_new(n_items, sizeof *flop), best = 0.0, seconds = 0.0;
    if (!flop) return 0.0;
    struct spin s = {.peak = peak, .n = 1 << 16, .flop = flop};
    while (seconds < 0.01) { /* how many steps take 0.1 s? */
        s.n *= 2;
        double start = clock_wall_s();
        peak(s.n);
        seconds = clock_wall_s() - start;
    }
    s.n = (uint64_t)((double)s.n * 0.1 / seconds);
    for (int run = 0; run < 3; run++) {
        double start = clock_wall_s(), total = 0.0;
        pool_run(pool, n_items, spin_item, &s);
        seconds = clock_wall_s() - start;
        for (uint32_t i = 0; i < n_items; i++) total += flop[i];
        if (total / seconds > best) best = total / seconds;
    }
    mem_free(flop);
    return best * 1e-9;
}

double nn_bench_peak_gflops(uint32_t cpu, struct pool *pool)
{
    struct nn_kernels kernels;
    nn_kernels_init(&kernels, cpu);
    return measure_peak(kernels.peak, pool);
}

double nn_bench_picture_peak_gflops(uint32_t cpu, struct pool *pool)
{
    const struct nn_rounded *rounded = nn_rounded_for(cpu);
    return rounded ? measure_peak(rounded->peak, pool) : nn_bench_peak_gflops(cpu, pool);
}

const char *nn_bench_picture_kernels(uint32_t cpu)
{
    const struct nn_rounded *rounded = nn_rounded_for(cpu);
    return rounded ? rounded->name : nn_bench_kernels(cpu);
}

const char *nn_bench_kernels(uint32_t cpu)
{
    struct nn_kernels kernels;
    nn_kernels_init(&kernels, cpu);
    return kernels.name;
}

/* ---- Something to work on ---- */

/* Everything a run needs. `v` belongs to all patches. */
struct job {
    struct generator *g;
    struct generator_batch batch;
    float *inputs, *targets, *v, *out;
    const float **pointers; /* of the batch */
    float *losses, *norms, *gradient;
    struct adam adam;
    size_t n_pixels;
};

static lmn_status take(size_t count, float **out, struct error *err)
{
    *out = mem_new(count, sizeof **out);
    return *out ? LMN_OK : fail_memory(err, "the benchmark's data");
}

static void fill(float *x, size_t n, uint64_t key)
{
    struct rng r = rng_keyed(1, key, 0);
    for (size_t i = 0; i < n; i++) x[i] = rng_float(&r);
}

static void job_release(struct job *j)
{
    float *blocks[] = {j->inputs, j->targets, j->v, j->out, j->losses, j->norms, j->gradient};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) mem_free(blocks[i]);
    mem_free(j->pointers);
    adam_release(&j->adam);
    generator_free(j->g);
    *j = (struct job){0};
}

static lmn_status job_init(struct job *j, const struct generator_config *config, struct pool *pool,
                           uint32_t cpu, size_t n_pixels, struct error *err)
{
    lmn_status status = LMN_OK;
    *j = (struct job){.n_pixels = n_pixels};
    TRY(generator_new(config, pool, cpu, &j->g, err));
    generator_init(j->g, 1);
    TRY(take(n_pixels * GENERATOR_INPUTS, &j->inputs, err));
    TRY(take(n_pixels * 3, &j->targets, err));
    TRY(take(n_pixels * 3, &j->out, err));
    TRY(take((size_t)config->n_variables + 1, &j->v, err));
    fill(j->inputs, n_pixels * GENERATOR_INPUTS, 0);
    fill(j->targets, n_pixels * 3, 1);
    fill(j->v, config->n_variables, 2);
    for (size_t i = 0; i < n_pixels; i++)
        for (int c = 0; c < 3; c++) j->inputs[i * GENERATOR_INPUTS + c] = 0.0f; /* no emission */
done:
    if (status != LMN_OK) job_release(j);
    return status;
}

static lmn_status job_init_training(struct job *j, const struct generator_config *config,
                                    struct pool *pool, uint32_t cpu, uint32_t n_patches,
                                    struct error *err)
{
    lmn_status status = LMN_OK;
    size_t area = (size_t)config->patch_size * config->patch_size;
    *j = (struct job){0};
    if (area == 0 || n_patches == 0)
        return fail(err, LMN_ERR_ARGUMENT, "benchmark of training: no patches");
    TRY(job_init(j, config, pool, cpu, n_patches * area, err));
    size_t n_weights = generator_n_weights(j->g);
    TRY(adam_init(&j->adam, n_weights, 1e-4, err));
    j->adam.cpu = cpu;
    TRY(take(n_patches, &j->losses, err));
    TRY(take(n_patches, &j->norms, err));
    TRY(take(n_weights, &j->gradient, err));
    j->pointers = mem_new((size_t)3 * n_patches, sizeof *j->pointers);
    if (!j->pointers) {
        status = fail_memory(err, "the benchmark's data");
        goto done;
    }
    for (uint32_t i = 0; i < n_patches; i++) {
        j->pointers[i] = j->inputs + i * area * GENERATOR_INPUTS;
        j->pointers[n_patches + i] = j->targets + i * area * 3;
        j->pointers[2 * n_patches + i] = j->v;
    }
    j->batch = (struct generator_batch){.n_patches = n_patches,
                                        .inputs = j->pointers,
                                        .targets = j->pointers + n_patches,
                                        .v = j->pointers + 2 * n_patches};
done:
    if (status != LMN_OK) job_release(j);
    return status;
}

/* ---- Runs ---- */

static void run_render(struct job *j, struct pool *pool)
{
    (void)pool;
    generator_render(j->g, j->inputs, j->v, j->n_pixels, j->out);
}

static void run_step(struct job *j, struct pool *pool)
{
    struct generator_loss loss = {.legacy_ssim = false};
    generator_gradient(j->g, &j->batch, &loss, j->losses, j->gradient);
    adam_step(&j->adam, pool, generator_weights(j->g), j->gradient);
    generator_weights_changed(j->g);
}

static void run_probe(struct job *j, struct pool *pool)
{
    struct generator_loss loss = {.legacy_ssim = false};
    (void)pool;
    j->adam.t = 1; /* as after a first step: norms are worked out */
    generator_probe(j->g, &j->adam, &j->batch, &loss, j->losses, j->norms);
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double forward_gflop(const struct generator_config *c, size_t n_pixels)
{
    double w = c->width, n_q = GENERATOR_INPUTS - 3;
    double products = 3.0 * w + (c->depth + 1.0) * (w + n_q) * w + 3.0 * (w + n_q);
    return 2e-9 * products * (double)n_pixels;
}

/* Times n_runs of `run`, fills *out and releases the job. */
static lmn_status measure(struct job *j, const struct generator_config *config, struct pool *pool,
                          void (*run)(struct job *, struct pool *), double passes, uint32_t n_runs,
                          struct nn_bench_result *out, struct error *err)
{
    if (n_runs == 0) n_runs = 1;
    double *seconds = mem_new(n_runs, sizeof *seconds);
    if (!seconds) {
        job_release(j);
        return fail_memory(err, "the benchmark's times");
    }
    run(j, pool);
    for (uint32_t i = 0; i < n_runs; i++) {
        double start = clock_wall_s();
        run(j, pool);
        seconds[i] = clock_wall_s() - start;
    }
    qsort(seconds, n_runs, sizeof *seconds, compare_doubles);
    *out = (struct nn_bench_result){
        .seconds = seconds[n_runs / 2],
        .gflop = passes * forward_gflop(config, j->n_pixels),
        .n_weights = generator_n_weights(j->g),
        .memory_size = generator_memory_size(j->g),
    };
    out->gflops = out->gflop / out->seconds;
    mem_free(seconds);
    job_release(j);
    return LMN_OK;
}

lmn_status nn_bench_render(const struct generator_config *config, struct pool *pool, uint32_t cpu,
                           size_t n_pixels, uint32_t n_runs, struct nn_bench_result *out,
                           struct error *err)
{
    struct generator_config for_render = *config;
    struct job j;
    for_render.patch_size = 0;
    lmn_status status = job_init(&j, &for_render, pool, cpu, n_pixels, err);
    if (status != LMN_OK) return status;
    return measure(&j, config, pool, run_render, 1.0, n_runs, out, err);
}

lmn_status nn_bench_step(const struct generator_config *config, struct pool *pool, uint32_t cpu,
                         uint32_t n_patches, uint32_t n_runs, struct nn_bench_result *out,
                         struct error *err)
{
    struct job j;
    lmn_status status = job_init_training(&j, config, pool, cpu, n_patches, err);
    if (status != LMN_OK) return status;
    return measure(&j, config, pool, run_step, 3.0, n_runs, out, err);
}

lmn_status nn_bench_probe(const struct generator_config *config, struct pool *pool, uint32_t cpu,
                          uint32_t n_patches, uint32_t n_runs, struct nn_bench_result *out,
                          struct error *err)
{
    struct job j;
    lmn_status status = job_init_training(&j, config, pool, cpu, n_patches, err);
    if (status != LMN_OK) return status;
    return measure(&j, config, pool, run_probe, 3.0, n_runs, out, err);
}
