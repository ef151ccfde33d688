/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/adam_step.h"

void adam_step_avx2(const struct adam_factors *factors, uint32_t n, float *weights, float *m,
                    float *v, const float *gradient, float *average)
{
    adam_step_loop(factors, n, weights, m, v, gradient, average);
}
