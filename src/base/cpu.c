/* SPDX-License-Identifier: Apache-2.0 */
#include "base/cpu.h"

#include <string.h>

uint32_t cpu_detect(void)
{
    uint32_t flags = 0;
    __builtin_cpu_init();
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return flags;
    flags |= CPU_AVX2;
    if (!__builtin_cpu_supports("avx512f") || !__builtin_cpu_supports("avx512bw") ||
        !__builtin_cpu_supports("avx512dq") || !__builtin_cpu_supports("avx512vl"))
        return flags;
    flags |= CPU_AVX512;
    if (__builtin_cpu_supports("avx512bf16")) flags |= CPU_AVX512BF16;
    return flags;
}

static const struct {
    const char *name;
    uint32_t mask;
} levels[] = {
    {"baseline", 0},
    {"avx2", CPU_AVX2},
    {"avx512", CPU_AVX2 | CPU_AVX512},
    {"avx512bf16", CPU_ALL},
};

const char *cpu_name(uint32_t flags)
{
    if (flags & CPU_AVX512BF16) return "avx512bf16";
    if (flags & CPU_AVX512) return "avx512";
    return flags & CPU_AVX2 ? "avx2" : "baseline";
}

uint32_t cpu_mask_from_name(const char *name)
{
    for (size_t i = 0; i < sizeof levels / sizeof *levels; i++)
        if (strcmp(levels[i].name, name) == 0) return levels[i].mask;
    return UINT32_MAX;
}
