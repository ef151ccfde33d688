/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/grid_kernels.h"

#include "nn/grid_vectors_avx512.h"

#include "nn/grid_lanes.h"

const struct grid_kernels grid_kernels_avx512 = {
    .name = "avx512", .encode = encode, .back = back, .spread = spread};
