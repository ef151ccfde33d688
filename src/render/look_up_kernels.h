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

static inline void look_up(void *to, const void *column, const int32_t *index, uint32_t n)
{
#ifdef __AVX512F__
    const __m512i low = _mm512_loadu_si512(column);
    const __m512i high = _mm512_loadu_si512((const char *)column + STREAM_ALIGNMENT);
    for (uint32_t i = 0; i < n; i += STREAM_VECTOR) {
        const __m512i at = _mm512_loadu_si512(index + i);
        _mm512_storeu_si512((char *)to + 4 * i, _mm512_permutex2var_epi32(low, at, high));
    }
#else
    for (uint32_t i = 0; i < n; i++)
        memcpy((char *)to + 4 * i, (const char *)column + 4 * (size_t)index[i], 4);
#endif
}

/* The same of a longer array. GCC goes through it one by one. */
static inline void gather(void *to, const void *from, const int32_t *index, uint32_t n)
{
#ifdef __AVX512F__
    for (uint32_t i = 0; i < n; i += STREAM_VECTOR) {
        const __m512i at = _mm512_loadu_si512(index + i);
        _mm512_storeu_si512((char *)to + 4 * i, _mm512_i32gather_epi32(at, from, 4));
    }
#elif defined(__AVX2__)
    for (uint32_t i = 0; i < n; i += STREAM_VECTOR / 2) {
        const __m256i at = _mm256_loadu_si256((const void *)(index + i));
        _mm256_storeu_si256((void *)((char *)to + 4 * i), _mm256_i32gather_epi32(from, at, 4));
    }
#else
    for (uint32_t i = 0; i < n; i++)
        memcpy((char *)to + 4 * i, (const char *)from + 4 * (size_t)index[i], 4);
#endif
}

/* Of two numbers that follow each other: half as many loads. */
static inline void gather2(void *first, void *second, const void *from, const int32_t *index,
                           uint32_t n)
{
#ifdef __AVX512F__
    const __m512i one = _mm512_set1_epi32(1);
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28,
                                           30);
    for (uint32_t i = 0; i < n; i += STREAM_VECTOR) {
        const __m256i at = _mm256_loadu_si256((const void *)(index + i));
        const __m256i later = _mm256_loadu_si256((const void *)(index + i + STREAM_VECTOR / 2));
        const __m512i low = _mm512_i32gather_epi64(at, from, 4);
        const __m512i high = _mm512_i32gather_epi64(later, from, 4);
        const __m512i odd = _mm512_add_epi32(even, one);
        _mm512_storeu_si512((char *)first + 4 * i, _mm512_permutex2var_epi32(low, even, high));
        _mm512_storeu_si512((char *)second + 4 * i, _mm512_permutex2var_epi32(low, odd, high));
    }
#else
    gather(first, from, index, n);
    gather(second, (const char *)from + 4, index, n);
#endif
}
