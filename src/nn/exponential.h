/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_EXPONENTIAL_H
#define NN_EXPONENTIAL_H

#include <stdint.h>
#include <string.h>

#include "nn/kernels.h"
#include "nn/unroll.h"

/* The inside of nn_kernels.exponentials(): one loop, compiled once per instruction set. It fuses
 * nothing, so that all give the same bytes. */

/* exp(x) to a relative 1e-7, for x whose result is no denormal: 2^n times a polynomial
 * within half a power of 2. Without calls, so that compilers vectorise loops of it. */
INLINE float exp_plain(float x)
{
    const float magic = 0x1.8p23f; /* adding it rounds to a whole number, left in the low bits */
    const float shifted = x * 0x1.715476p0f + magic, n = shifted - magic;
    const float r = (x - n * 0x1.62e4p-1f) - n * 0x1.7f7d1cp-20f; /* ln 2 in two parts */
    float p = 0x1.6d461ep-10f; /* Chebyshev fit of (exp(r) - 1 - r) / r^2, |r| < ln(2)/2 */
    p = p * r + 0x1.120deap-7f;
    p = p * r + 0x1.5554e6p-5f;
    p = p * r + 0x1.5554dap-3f;
    p = p * r + 0x1.000000p-1f;
    uint32_t bits;
    float power;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 127u) << 23;
    memcpy(&power, &bits, sizeof power);
    return (p * r * r + r + 1.0f) * power;
}

INLINE void exponentials_loop(const float *restrict x, uint32_t n, float *restrict y)
{
    for (uint32_t i = 0; i < n; i++) {
        /* What is no number stays so: training must notice. */
        const float most = x[i] > NN_MOST_EXPONENT ? NN_MOST_EXPONENT : x[i];
        y[i] = exp_plain(most < NN_LEAST_EXPONENT ? NN_LEAST_EXPONENT : most);
    }
}

#endif
