/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/rounded.h"

#include <string.h>

#include "base/cpu.h"
#include "math/approx.h"

/* The bits that BF16 has no room for. */
#define CUT 0xFFFFu

static uint32_t bits_of(float x)
{
    return (uint32_t)approx_to_bits(x);
}

static float float_of(uint32_t bits)
{
    return approx_from_bits((int32_t)bits);
}

float nn_round(float x)
{
    const uint32_t bits = bits_of(x);
    if (x != x) return x;
    return float_of((bits + CUT / 2 + (bits >> 16 & 1)) & ~CUT);
}

size_t nn_rounded_count(uint32_t n_in)
{
    return (size_t)(n_in + 1) / 2 * NN_ROUNDED_PANEL;
}

void nn_rounded_pack(float *packed, const float *w, size_t ld, uint32_t n_out, uint32_t n_in,
                     uint32_t index)
{
    const uint32_t first = index * NN_ROUNDED_PANEL;
    for (uint32_t k = 0; k < n_in; k += 2, packed += NN_ROUNDED_PANEL)
        for (uint32_t lane = 0; lane < NN_ROUNDED_PANEL; lane++) {
            uint32_t pair = 0;
            if (first + lane < n_out) {
                const float *row = w + (first + lane) * ld;
                pair = bits_of(nn_round(row[k])) >> 16;
                if (k + 1 < n_in) pair |= bits_of(nn_round(row[k + 1]));
            }
            memcpy(packed + lane, &pair, sizeof pair);
        }
}

/* One of a row's features, [PANEL] floats or pairs. */
static float read_feature(const float *row, uint32_t k, bool is_pair)
{
    if (!is_pair) return nn_round(row[k]);
    const uint32_t pair = bits_of(row[k / 2]);
    return float_of(k % 2 ? pair & ~CUT : pair << 16);
}

static void write_feature(float *row, uint32_t k, bool is_pair, float x)
{
    if (!is_pair) {
        row[k] = x;
        return;
    }
    const uint32_t bits = bits_of(nn_round(x)), before = k % 2 ? bits_of(row[k / 2]) : 0;
    const uint32_t pair = k % 2 ? before | bits : bits >> 16;
    memcpy(row + k / 2, &pair, sizeof pair);
}

/* What the fast one is held against. */
static void forward(const struct nn_forward *a, bool is_first)
{
    enum { PANEL = NN_ROUNDED_PANEL };
    for (size_t r = 0; r < a->n_rows; r++) {
        const float *x = a->x + r * PANEL;
        float *y = a->y + r * PANEL;
        for (uint32_t o = 0; o < a->n_out; o++) {
            const float *w = a->w + o / PANEL * nn_rounded_count(a->n_in) + o % PANEL;
            float sum = a->b[o];
            for (uint32_t k = 0; k < a->n_in; k++)
                sum += read_feature(x + k / PANEL * a->stride, k % PANEL, !is_first) *
                       read_feature(w + k / 2 * PANEL, k % 2, true);
            if (!a->linear && sum < 0.0f) sum *= NN_SLOPE;
            write_feature(y + o / PANEL * a->stride, o % PANEL, !a->linear, sum);
        }
    }
}

const struct nn_rounded nn_rounded_ref = {.name = "ref", .forward = forward};

const struct nn_rounded *nn_rounded_for(uint32_t cpu)
{
    return cpu & CPU_AVX512BF16 && !(cpu & CPU_AMX) ? &nn_rounded_avx512bf16 : NULL;
}
