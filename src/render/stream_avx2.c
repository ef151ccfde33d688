/* SPDX-License-Identifier: Apache-2.0 */
#define STREAM_KERNELS stream_kernels_avx2
#define STREAM_NAME    "avx2"
#include "render/stream_kernels.h"
