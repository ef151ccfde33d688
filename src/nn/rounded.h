/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_ROUNDED_H
#define NN_ROUNDED_H

#include "nn/kernels.h"

/*
 * Layers whose factors are rounded to BF16 (8 bits of a float's 24) and whose sums are floats, for
 * pictures: never in training. A number per thousand is what each product is off by, and nothing
 * that can be measured is left of it in a picture (docs/algorithm.md). AVX-512-BF16 multiplies two
 * such pairs where it multiplies one of floats.
 *
 * Weights are packed as pairs of rows, w [(n_in + 1) / 2][64] of two BF16 each, the earlier one in
 * the lower half. Tiles are those of nn_kernels, panels of 64 features: the network's inputs and
 * outputs in floats; between its layers such pairs, in the first half of each row of a panel.
 */
struct nn_rounded {
    const char *name;
    /* As nn_kernels.forward(), of a->w by nn_rounded_pack(); n_q is 0. a->x are floats if is_first,
     * a->y if a->linear, else pairs. */
    void (*forward)(const struct nn_forward *a, bool is_first);
    double (*peak)(uint64_t n); /* as nn_kernels.peak(), of pairs */
};

/* What to use among `cpu` (flags of base/cpu.h); NULL: floats are as good. Processors with AMX are
 * said to have two units for floats and one for pairs (uops.info; not measured here). */
const struct nn_rounded *nn_rounded_for(uint32_t cpu);

/* For tests, which check that the machine has the set. */
extern const struct nn_rounded nn_rounded_ref, nn_rounded_avx512bf16;

enum { NN_ROUNDED_PANEL = 64 };
size_t nn_rounded_count(uint32_t n_in); /* of floats that hold a packed panel */
void nn_rounded_pack(float *packed, const float *w, size_t ld, uint32_t n_out, uint32_t n_in,
                     uint32_t index);

/* To the nearest, even ones at ties. */
float nn_round(float x);

#endif
