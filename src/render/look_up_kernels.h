/* SPDX-License-Identifier: Apache-2.0 */
/* Values from tables by index, for one instruction set: a part of stream_kernels.h. GCC would read
 * them one by one. Whole vectors are looked up: indices beyond n, up to the vector's end, must be
 * of the table too. */
#ifdef __AVX2__
#include <immintrin.h>
#endif

/* to[i] = column[index[i]] of at most LOOK_UP_FEW, but that many are read. Two registers hold a
 * column: that is many times quicker than going to memory lane by lane. */
enum { LOOK_UP_FEW = 2 * STREAM_VECTOR };

static inline void look_up(float *to, const float *column, const int32_t *index, uint32_t n)
{
#ifdef __AVX512F__
    const __m512 low = _mm512_loadu_ps(column), high = _mm512_loadu_ps(column + STREAM_VECTOR);
    for (uint32_t i = 0; i < n; i += STREAM_VECTOR) {
        const __m512i at = _mm512_loadu_si512(index + i);
        _mm512_storeu_ps(to + i, _mm512_permutex2var_ps(low, at, high));
    }
#else
#pragma omp simd
    for (uint32_t i = 0; i < n; i++) to[i] = column[index[i]];
#endif
}

/* The same of a longer array. */
static inline void gather(float *to, const float *from, const int32_t *index, uint32_t n)
{
#ifdef __AVX512F__
    for (uint32_t i = 0; i < n; i += STREAM_VECTOR)
        _mm512_storeu_ps(to + i, _mm512_i32gather_ps(_mm512_loadu_si512(index + i), from, 4));
#elif defined(__AVX2__)
    for (uint32_t i = 0; i < n; i += STREAM_VECTOR / 2)
        _mm256_storeu_ps(
            to + i, _mm256_i32gather_ps(from, _mm256_loadu_si256((const void *)(index + i)), 4));
#else
    for (uint32_t i = 0; i < n; i++) to[i] = from[index[i]];
#endif
}
