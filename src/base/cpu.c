/* SPDX-License-Identifier: Apache-2.0 */
#include "base/cpu.h"

#include <cpuid.h>
#include <stdbool.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

/* AMX needs the processor's word (CPUID 7: bits 22 and 24 of EDX), and the kernel's: it saves the
 * tiles' 8 KiB only for processes that asked (arch_prctl(2)). */
static bool has_amx(void)
{
    enum { BF16_AND_TILE = 1 << 22 | 1 << 24, ARCH_REQ_XCOMP_PERM = 0x1023, XTILEDATA = 18 };
    unsigned a, b, c, d;
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d)) return false;
    if ((d & BF16_AND_TILE) != BF16_AND_TILE) return false;
    return syscall(SYS_arch_prctl, ARCH_REQ_XCOMP_PERM, XTILEDATA) == 0;
}

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
    if (!__builtin_cpu_supports("avx512bf16")) return flags;
    flags |= CPU_AVX512BF16;
    if (has_amx()) flags |= CPU_AMX;
    return flags;
}

static const struct {
    const char *name;
    uint32_t mask;
} levels[] = {
    {"baseline", 0},
    {"avx2", CPU_AVX2},
    {"avx512", CPU_AVX2 | CPU_AVX512},
    {"avx512bf16", CPU_AVX2 | CPU_AVX512 | CPU_AVX512BF16},
    {"amx", CPU_ALL},
};

const char *cpu_name(uint32_t flags)
{
    if (flags & CPU_AMX) return "amx";
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
