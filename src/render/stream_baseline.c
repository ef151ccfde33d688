/* SPDX-License-Identifier: Apache-2.0 */
#define STREAM_KERNELS stream_kernels_baseline
#define STREAM_NAME    "baseline"
#include "render/stream_kernels.h"
