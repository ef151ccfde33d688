/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_SELECT_H
#define IMAGE_SELECT_H

#include <stddef.h>

/* The k-th smallest of v[0..n), k from 0, n > 0, no NaN. Reorders v so that v[0..k) are not larger
 * and v(k..n) not smaller. Hoare's FIND; the middle as pivot keeps sorted input fast. */
static inline float select_kth(float *v, size_t n, size_t k)
{
    size_t lo = 0, hi = n - 1;
    while (lo < hi) {
        float pivot = v[lo + (hi - lo) / 2];
        size_t i = lo - 1, j = hi + 1; /* lo - 1 may wrap; i is raised before it is used */
        for (;;) {
            do i++;
            while (v[i] < pivot);
            do j--;
            while (v[j] > pivot);
            if (i >= j) break;
            float t = v[i];
            v[i] = v[j];
            v[j] = t;
        }
        if (k <= j) /* v[lo..j] <= pivot <= v[j+1..hi] */
            hi = j;
        else
            lo = j + 1;
    }
    return v[k];
}

#endif
