/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BASE_CLOCK_H
#define BASE_CLOCK_H

#include <stdint.h>
#include <x86intrin.h>

/* Seconds on a clock that only goes forward. */
double clock_wall_s(void);

/* Seconds of processor time, all threads of the process together. */
double clock_cpu_s(void);

/* A count that grows steadily, quick to ask: for shares of time. */
static inline uint64_t clock_ticks(void)
{
    return __rdtsc();
}

#endif
