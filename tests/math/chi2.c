/* SPDX-License-Identifier: Apache-2.0 */
#include "chi2.h"

#include <math.h>

#include "base/mem.h"
#include "base/rng.h"

const struct chi2_domain chi2_sphere = {
    -3.14159265358979323846, 3.14159265358979323846, -1, 1, 32, 24, true};

struct vec3 chi2_direction(double phi, double z)
{
    double r = sqrt(fmax(0, 1 - z * z));
    return vec3((float)(r * cos(phi)), (float)(r * sin(phi)), (float)z);
}

void chi2_from_direction(struct vec3 d, double *phi, double *z)
{
    *phi = atan2(d.y, d.x);
    *z = fmin(fmax(d.z, -1), 1);
}

/* Rows of the sphere: z = (3 t - t^3) / 2, t in [-1, 1]. With t = 2 sin a, z is sin 3a. */
static double z_of_row(double t)
{
    return 0.5 * t * (3 - t * t);
}

static double row_of_z(double z)
{
    return 2 * sin(asin(z) / 3);
}

static double value(const struct chi2_domain *d, chi2_pdf_fn *pdf, const void *ctx, double x,
                    double y)
{
    if (!d->is_sphere) return pdf(ctx, x, y);
    return pdf(ctx, x, z_of_row(y)) * 1.5 * (1 - y * y);
}

/* Integral over a rectangle: SUB x SUB cells of 2 x 2 Gauss points. */
static double integrate(const struct chi2_domain *d, chi2_pdf_fn *pdf, const void *ctx, double x0,
                        double x1, double y0, double y1)
{
    enum { SUB = 10 };
    const double at[2] = {0.5 - 0.5 / sqrt(3.0), 0.5 + 0.5 / sqrt(3.0)};
    double sum = 0, dx = (x1 - x0) / SUB, dy = (y1 - y0) / SUB;
    for (int i = 0; i < 2 * SUB; i++)
        for (int j = 0; j < 2 * SUB; j++)
            sum += value(d, pdf, ctx, x0 + (i / 2 + at[i % 2]) * dx, y0 + (j / 2 + at[j % 2]) * dy);
    return sum * dx * dy / 4;
}

/* Upper tail of the chi-square distribution, by Wilson and Hilferty's cube root (good to a few
 * per cent of p for the hundreds of degrees of freedom here). */
double chi2_tail(double chi2, int freedom)
{
    double k = freedom;
    double z = (cbrt(chi2 / k) - (1 - 2 / (9 * k))) / sqrt(2 / (9 * k));
    return 0.5 * erfc(z / sqrt(2.0));
}

struct chi2_result chi2_test(const struct chi2_domain *domain, chi2_sample_fn *sample,
                             chi2_pdf_fn *pdf, const void *ctx, uint32_t n_samples, uint64_t seed)
{
    const struct chi2_domain *d = domain;
    int n = d->columns * d->rows;
    double dx = (d->x1 - d->x0) / d->columns, dy = (d->y1 - d->y0) / d->rows;
    double *counts = mem_new((size_t)n + 1, sizeof *counts);
    struct chi2_result r = {0};
    struct rng rng = rng_keyed(seed, 0, 0);
    for (uint32_t i = 0; i < n_samples; i++) {
        const float u[3] = {rng_float(&rng), rng_float(&rng), rng_float(&rng)};
        double x, y;
        if (!sample(ctx, u, &x, &y)) {
            counts[n]++;
            continue;
        }
        if (d->is_sphere) y = row_of_z(y);
        int column = (int)((x - d->x0) / dx), row = (int)((y - d->y0) / dy);
        column = column < 0 ? 0 : column >= d->columns ? d->columns - 1 : column;
        row = row < 0 ? 0 : row >= d->rows ? d->rows - 1 : row;
        counts[row * d->columns + column]++;
    }
    r.lost = counts[n] / n_samples;
    double chi2 = 0, pooled_expected = 0, pooled_count = 0;
    int freedom = -1;
    for (int i = 0; i <= n; i++) {
        double expected, x = d->x0 + i % d->columns * dx, y = d->y0 + i / d->columns * dy;
        if (i < n) {
            double part = integrate(d, pdf, ctx, x, x + dx, y, y + dy);
            r.integral += part;
            expected = part * n_samples;
        } else {
            expected = fmax(0, 1 - r.integral) * n_samples;
        }
        if (expected < 5) {
            pooled_expected += expected;
            pooled_count += counts[i];
            continue;
        }
        double difference = counts[i] - expected;
        chi2 += difference * difference / expected;
        freedom++;
    }
    if (pooled_expected > 0.5 || pooled_count > 5) {
        double difference = pooled_count - pooled_expected;
        chi2 += difference * difference / fmax(pooled_expected, 0.5);
        freedom++;
    }
    r.p = freedom > 0 ? chi2_tail(chi2, freedom) : 1;
    mem_free(counts);
    return r;
}
