/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/kernels.h"

#include <string.h>

#include "base/cpu.h"

void nn_kernels_init(struct nn_kernels *t, uint32_t cpu)
{
    *t = nn_kernels_ref;
    if (!(cpu & CPU_AVX2)) return;
    *t = nn_kernels_avx2;
    if (!(cpu & CPU_AVX512)) return;
    *t = nn_kernels_avx512;
    if (!(cpu & CPU_AMX)) return;
    *t = nn_kernels_amx;
}

void nn_pack_forward(uint32_t panel, float *packed, const float *w, size_t ld, uint32_t n_out,
                     uint32_t n_columns, uint32_t index)
{
    enum { BLOCK = 16 }; /* columns of a cache line: each line of w is read once */
    uint32_t first = index * panel;
    uint32_t n_lanes = n_out - first < panel ? n_out - first : panel;
    if (n_lanes < panel) memset(packed, 0, (size_t)n_columns * panel * sizeof *packed);
    for (uint32_t k0 = 0; k0 < n_columns; k0 += BLOCK) {
        uint32_t k1 = n_columns - k0 < BLOCK ? n_columns : k0 + BLOCK;
        for (uint32_t lane = 0; lane < n_lanes; lane++) {
            const float *row = w + (first + lane) * ld;
            for (uint32_t k = k0; k < k1; k++) packed[(size_t)k * panel + lane] = row[k];
        }
    }
}

void nn_pack_backward(uint32_t panel, float *packed, const float *w, size_t ld, uint32_t n_out,
                      uint32_t n_in, uint32_t index)
{
    uint32_t first = index * panel;
    uint32_t n_lanes = n_in - first < panel ? n_in - first : panel;
    for (uint32_t o = 0; o < n_out; o++, packed += panel) {
        memcpy(packed, w + o * ld + first, n_lanes * sizeof *packed);
        for (uint32_t lane = n_lanes; lane < panel; lane++) packed[lane] = 0.0f;
    }
}
