/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BASE_CPU_H
#define BASE_CPU_H

#include <stdint.h>

/* Instruction sets that kernels are compiled for; a higher one implies the lower ones. */
enum cpu_flag {
    CPU_AVX2 = 1u << 0,       /* AVX2 + FMA */
    CPU_AVX512 = 1u << 1,     /* F, BW, DQ, VL */
    CPU_AVX512BF16 = 1u << 2, /* + BF16 dot products */
    CPU_AMX = 1u << 3,        /* + AMX tiles of BF16 */
    CPU_ALL = 15u
};

/* What this machine (and its operating system) can run. Where there is AMX, the first call asks the
 * kernel for the permission to use tiles, which all threads started later have too. */
uint32_t cpu_detect(void);

/* "baseline", "avx2", "avx512", "avx512bf16" or "amx": the highest set in `flags`. */
const char *cpu_name(uint32_t flags);

/* The mask that a name stands for (it and everything below); UINT32_MAX when unknown. */
uint32_t cpu_mask_from_name(const char *name);

#endif
