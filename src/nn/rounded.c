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

void nn_rounded_pack_pairs(float *pairs, const float *x, size_t n_pairs)
{
    for (size_t i = 0; i < n_pairs; i++, x += 2) {
        const uint32_t pair = bits_of(nn_round(x[0])) >> 16 | bits_of(nn_round(x[1]));
        memcpy(pairs + i, &pair, sizeof pair);
    }
}

/* ---- What the fast ones are held against ---- */

/* One of a row's numbers. */
static float read_number(const float *pairs, uint32_t k)
{
    const uint32_t pair = bits_of(pairs[k / 2]);
    return float_of(k % 2 ? pair & ~CUT : pair << 16);
}

/* Numbers are written in order; the one after an odd number of them is 0. */
static void write_number(float *pairs, uint32_t k, float x)
{
    const uint32_t bits = bits_of(nn_round(x)), before = k % 2 ? bits_of(pairs[k / 2]) : 0;
    const uint32_t pair = k % 2 ? before | bits : bits >> 16;
    memcpy(pairs + k / 2, &pair, sizeof pair);
}

static void forward(const struct nn_forward *a)
{
    enum { PANEL = NN_ROUNDED_PANEL };
    for (size_t r = 0; r < a->n_rows; r++) {
        const float *x = a->x + r * PANEL;
        float *y = a->y + r * PANEL;
        for (uint32_t o = 0; o < a->n_out; o++) {
            const float *w = a->w + o / PANEL * nn_rounded_count(a->n_in) + o % PANEL;
            float sum = a->b[o], *to = y + o / PANEL * a->stride;
            for (uint32_t k = 0; k < a->n_in; k++)
                sum += read_number(x + k / PANEL * a->stride, k % PANEL) *
                       read_number(w + k / 2 * PANEL, k % 2);
            if (!a->linear && sum < 0.0f) sum *= NN_SLOPE;
            if (a->linear)
                to[o % PANEL] = sum;
            else
                write_number(to, o % PANEL, sum);
        }
    }
}

static void encode(const struct grid_encode *a)
{
    const struct grid *g = a->grid;
    for (uint32_t r = 0; r < a->n; r++)
        for (uint32_t k = 0; k < g->n_levels * GRID_FEATURES; k++) {
            const uint32_t level = k / GRID_FEATURES, at = a->first + k;
            const float *pairs = a->table + g->at[level] / GRID_FEATURES;
            struct grid_cell c;
            float sum = 0.0f;
            grid_find(g, level, a->positions + r * a->pitch, &c);
            for (uint32_t i = 0; i < 8; i++)
                sum += c.weight[i] * read_number(pairs + c.entry[i], k % GRID_FEATURES);
            write_number(a->tile + at / a->panel * a->stride + (size_t)r * a->panel, at % a->panel,
                         sum);
        }
}

static void spread(const struct grid_spread *a)
{
    for (uint32_t r = 0; r < a->n; r++)
        for (uint32_t k = 0; k < a->count; k++) {
            const uint32_t at = a->first + k;
            write_number(a->tile + at / a->panel * a->stride + (size_t)r * a->panel, at % a->panel,
                         a->rows[(size_t)r * a->count + k]);
        }
}

const struct grid_kernels grid_rounded_ref = {.name = "ref", .encode = encode, .spread = spread};

const struct nn_rounded nn_rounded_ref = {
    .name = "ref", .forward = forward, .grids = &grid_rounded_ref};

const struct nn_rounded *nn_rounded_for(uint32_t cpu)
{
    return cpu & CPU_AVX512BF16 && !(cpu & CPU_AMX) ? &nn_rounded_avx512bf16 : NULL;
}
