/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MATH_APPROX_H
#define MATH_APPROX_H

#include <stdint.h>
#include <string.h>

#include "math/vec.h"

/*
 * Elementary functions without branches or calls, for vector code; the same operations everywhere,
 * so that results do not depend on the instruction set. Relative error of exp and log below 2e-7,
 * absolute error of erf below 7e-7. Polynomials: exp and log of Cephes (Moshier), erf of Abramowitz
 * & Stegun 7.1.26, inverse of erf of Giles 2010, "Approximating the erfinv function".
 */

MATH_INLINE float approx_from_bits(int32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

MATH_INLINE int32_t approx_to_bits(float x)
{
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* 1 / sqrt(x) of x in [1e-30, 1e30], relative error below 2e-3: a line through the bits, and a step
 * of Newton's (Blinn 1997, "Floating-point tricks"). */
MATH_INLINE float approx_inverse_root(float x)
{
    float y = approx_from_bits(0x5F3759DF - (approx_to_bits(x) >> 1));
    return y * (1.5f - 0.5f * x * y * y);
}

/* As of -87 below (1.6e-38), and as of 88 above. */
MATH_INLINE float approx_exp(float x)
{
    float a = min_float(max_float(x, -87.0f), 88.0f);
    /* Rounded to a whole number by a sum that has no room for less. */
    float sum = a * 1.44269504f + 12582912.0f, n = sum - 12582912.0f;
    float r = a - n * 0.693359375f + n * 2.12194440e-4f, p = 1.9875691500e-4f;
    p = p * r + 1.3981999507e-3f;
    p = p * r + 8.3334519073e-3f;
    p = p * r + 4.1665795894e-2f;
    p = p * r + 1.6666665459e-1f;
    p = p * r + 5.0000001201e-1f;
    return (p * r * r + r + 1.0f) *
           approx_from_bits((approx_to_bits(sum) - 0x4B400000 + 127) * (1 << 23));
}

/* Of x in [1e-37, INFINITY). */
MATH_INLINE float approx_log(float x)
{
    /* x = 2^e m with m in [sqrt(1/2), sqrt(2)) */
    int32_t bits = approx_to_bits(x) - 0x3F3504F3;
    float e = (float)(bits >> 23), m = approx_from_bits((bits & 0x7FFFFF) + 0x3F3504F3) - 1.0f;
    float z = m * m, p = 7.0376836292e-2f;
    p = p * m - 1.1514610310e-1f;
    p = p * m + 1.1676998740e-1f;
    p = p * m - 1.2420140846e-1f;
    p = p * m + 1.4249322787e-1f;
    p = p * m - 1.6668057665e-1f;
    p = p * m + 2.0000714765e-1f;
    p = p * m - 2.4999993993e-1f;
    p = p * m + 3.3333331174e-1f;
    return m + (p * m * z - e * 2.12194440e-4f - 0.5f * z) + e * 0.693359375f;
}

MATH_INLINE float approx_erf(float x)
{
    float a = fabsf(x), t = 1.0f / (1.0f + 0.3275911f * a), p = 1.061405429f;
    p = p * t - 1.453152027f;
    p = p * t + 1.421413741f;
    p = p * t - 0.284496736f;
    p = p * t + 0.254829592f;
    return copysignf(1.0f - p * t * approx_exp(-(a * a)), x);
}

/* Of x in [-1, 1]; finite at the ends. */
MATH_INLINE float approx_erf_inverse(float x)
{
    float w = -approx_log(max_float((1.0f - x) * (1.0f + x), 1e-30f));
    float a = w - 2.5f, p = 2.81022636e-08f;
    p = 3.43273939e-07f + p * a;
    p = -3.5233877e-06f + p * a;
    p = -4.39150654e-06f + p * a;
    p = 0.00021858087f + p * a;
    p = -0.00125372503f + p * a;
    p = -0.00417768164f + p * a;
    p = 0.246640727f + p * a;
    p = 1.50140941f + p * a;
    float b = sqrtf(max_float(w, 0.0f)) - 3.0f, q = -0.000200214257f;
    q = 0.000100950558f + q * b;
    q = 0.00134934322f + q * b;
    q = -0.00367342844f + q * b;
    q = 0.00573950773f + q * b;
    q = -0.0076224613f + q * b;
    q = 0.00943887047f + q * b;
    q = 1.00167406f + q * b;
    q = 2.83297682f + q * b;
    return (w < 5.0f ? p : q) * x;
}

#endif
