/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_MATH_CHI2_H
#define TESTS_MATH_CHI2_H

#include <stdbool.h>
#include <stdint.h>

#include "math/warp.h"

/*
 * Pearson's chi-square test of a sampling routine: samples are counted in bins of its domain and
 * compared with the integral of its density over each bin. Bins that expect fewer than 5 samples
 * are pooled. Samples that were not drawn (`false`) are a bin of their own, which expects what the
 * density leaves of 1.
 */
struct chi2_domain {
    double x0, x1, y0, y1; /* sampled values (x, y) lie in this rectangle */
    int columns, rows;
    bool is_sphere;
};

/* Directions as (phi, z), whose areas are solid angles. Rows get narrower towards the poles, where
 * sharp lobes are. */
extern const struct chi2_domain chi2_sphere;

struct chi2_result {
    double p;        /* of a worse fit by chance */
    double integral; /* of the density over the domain */
    double lost;     /* the part of samples that were not drawn */
};

/* Draws from three random numbers in [0,1). */
typedef bool chi2_sample_fn(const void *ctx, const float u[3], double *x, double *y);
typedef double chi2_pdf_fn(const void *ctx, double x, double y);

struct chi2_result chi2_test(const struct chi2_domain *domain, chi2_sample_fn *sample,
                             chi2_pdf_fn *pdf, const void *ctx, uint32_t n_samples, uint64_t seed);

/* How likely chance makes a sum of squares of so many degrees of freedom that large or larger. */
double chi2_tail(double chi2, int freedom);

/* Between (phi, z) and unit vectors. */
struct vec3 chi2_direction(double phi, double z);
void chi2_from_direction(struct vec3 d, double *phi, double *z);

#endif
