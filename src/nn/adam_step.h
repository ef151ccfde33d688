/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_ADAM_STEP_H
#define NN_ADAM_STEP_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

/* The inside of adam_step(): one loop, compiled once per instruction set. It fuses nothing, so that
 * all give the same bytes. */

/* What step number t multiplies with, in the precision of the weights. */
struct adam_factors {
    float beta1, beta2, rest1, rest2; /* rest = 1 - beta */
    float rate;                       /* lr / (1 - beta1^t) */
    float root;                       /* 1 / sqrt(1 - beta2^t) */
    float eps;
    float share; /* of the new weights in the average */
};

/* average: NULL, or [n]. */
typedef void adam_step_fn(const struct adam_factors *factors, uint32_t n, float *weights, float *m,
                          float *v, const float *gradient, float *average);

adam_step_fn adam_step_baseline, adam_step_avx2, adam_step_avx512;

static inline __attribute__((always_inline)) void
adam_step_loop(const struct adam_factors *factors, uint32_t n, float *restrict w, float *restrict m,
               float *restrict v, const float *restrict g, float *restrict average)
{
    const struct adam_factors f = *factors;
    for (uint32_t i = 0; i < n; i++) {
        m[i] = f.beta1 * m[i] + f.rest1 * g[i];
        v[i] = f.beta2 * v[i] + f.rest2 * g[i] * g[i];
        w[i] -= f.rate * m[i] / (sqrtf(v[i]) * f.root + f.eps);
    }
    if (!average) return;
    for (uint32_t i = 0; i < n; i++) average[i] += f.share * (w[i] - average[i]);
}

#endif
