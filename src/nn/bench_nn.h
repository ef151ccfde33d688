/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_BENCH_NN_H
#define NN_BENCH_NN_H

#include "nn/generator.h"

/* Measures the network on this machine; nothing is printed. FLOP counts multiply-adds of the
 * products as two, without v (folded into the bias); a training step counts three times a forward
 * pass. Inputs are random but the same each time. */

/* The most floating-point operations per second (in 1e9) that all workers of the pool reach with
 * the best instruction set of `cpu` on numbers in registers: best of three runs of 0.1 s. */
double nn_bench_peak_gflops(uint32_t cpu, struct pool *pool);

/* The name of the kernels that `cpu` selects: "baseline", "avx2", "avx512". Static. */
const char *nn_bench_kernels(uint32_t cpu);

/* The same for the compact network's pictures, which may be of rounded numbers (rounded.h). */
double nn_bench_picture_peak_gflops(uint32_t cpu, struct pool *pool);
const char *nn_bench_picture_kernels(uint32_t cpu);

struct nn_bench_result {
    double seconds; /* median over the runs, after one that does not count */
    double gflop;   /* work of one run */
    double gflops;  /* gflop / seconds */
    uint64_t n_weights, memory_size;
};

/* One frame of n_pixels. */
lmn_status nn_bench_render(const struct generator_config *config, struct pool *pool, uint32_t cpu,
                           size_t n_pixels, uint32_t n_runs, struct nn_bench_result *out,
                           struct error *err);

/* One training step: gradient of the batch, Adam, and making the weights ready for the next. */
lmn_status nn_bench_step(const struct generator_config *config, struct pool *pool, uint32_t cpu,
                         uint32_t n_patches, uint32_t n_runs, struct nn_bench_result *out,
                         struct error *err);

/* One generator_probe() of n_patches. */
lmn_status nn_bench_probe(const struct generator_config *config, struct pool *pool, uint32_t cpu,
                          uint32_t n_patches, uint32_t n_runs, struct nn_bench_result *out,
                          struct error *err);

#endif
