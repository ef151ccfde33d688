/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_ROUNDED_H
#define NN_ROUNDED_H

#include "nn/grid_kernels.h"
#include "nn/kernels.h"

/*
 * Layers and grids whose factors are rounded to BF16 (8 bits of a float's 24) and whose sums are
 * floats, for pictures: never in training. A number per thousand is what each product is off by,
 * and nothing that can be measured is left of it in a picture (docs/algorithm.md). AVX-512-BF16
 * multiplies two such pairs where it multiplies one of floats.
 *
 * Pairs lie where a float would: two numbers, the earlier one in the lower half. Weights are packed
 * as pairs of rows, w [(n_in + 1) / 2][64]; an entry of a grid is a pair. Tiles are those of
 * nn_kernels, panels of 64 features, of pairs in the first half of each row of a panel; what the
 * last layer gives is floats.
 */
struct nn_rounded {
    const char *name;
    /* As nn_kernels.forward(), of a->w by nn_rounded_pack(); n_q is 0. a->y are floats if
     * a->linear. */
    void (*forward)(const struct nn_forward *a);
    const struct grid_kernels *grids; /* of tables of pairs, into tiles of pairs; no back() */
    double (*peak)(uint64_t n);       /* as nn_kernels.peak(), of pairs */
};

/* What to use among `cpu` (flags of base/cpu.h); NULL: floats are as good. Processors with AMX are
 * said to have two units for floats and one for pairs (uops.info; not measured here). */
const struct nn_rounded *nn_rounded_for(uint32_t cpu);

/* For tests, which check that the machine has the set. */
extern const struct nn_rounded nn_rounded_ref, nn_rounded_avx512bf16;
extern const struct grid_kernels grid_rounded_ref, grid_rounded_avx512bf16;

enum { NN_ROUNDED_PANEL = 64 };
size_t nn_rounded_count(uint32_t n_in); /* of floats that hold a packed panel */
void nn_rounded_pack(float *packed, const float *w, size_t ld, uint32_t n_out, uint32_t n_in,
                     uint32_t index);

/* x [n_pairs][2] as pairs. */
void nn_rounded_pack_pairs(float *pairs, const float *x, size_t n_pairs);

/* To the nearest, even ones at ties. */
float nn_round(float x);

#endif
