/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_UNROLL_H
#define NN_UNROLL_H

/* For vector code in loops over registers: such loops must vanish whole. */
#define INLINE static inline __attribute__((always_inline))
#ifdef __clang__
#define UNROLL     _Pragma("clang loop unroll(full)")
#define UNROLL_BY4 _Pragma("clang loop unroll_count(4)")
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define UNROLL /* of some loops nothing is left to unroll there, which is a warning */
#define UNROLL_BY4
#else
#define UNROLL     _Pragma("GCC unroll 32")
#define UNROLL_BY4 _Pragma("GCC unroll 4")
#endif

#endif
