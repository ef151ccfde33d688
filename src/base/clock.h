/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BASE_CLOCK_H
#define BASE_CLOCK_H

/* Seconds on a clock that only goes forward. */
double clock_wall_s(void);

/* Seconds of processor time, all threads of the process together. */
double clock_cpu_s(void);

#endif
