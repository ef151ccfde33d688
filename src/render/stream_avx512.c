/* SPDX-License-Identifier: Apache-2.0 */
#define STREAM_KERNELS stream_kernels_avx512
#define STREAM_NAME    "avx512"
#include "render/stream_kernels.h"
