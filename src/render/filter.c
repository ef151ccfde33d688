/* SPDX-License-Identifier: Apache-2.0 */
#include "render/filter.h"

/* Integral of exp(-x^2 / 2 s^2) - exp(-r^2 / 2 s^2) from 0 to x. */
static double gaussian_integral(const struct filter *f, double x)
{
    double s = f->stddev, r = f->radius;
    return s * sqrt(0.5 * 3.14159265358979323846) * erf(x / (s * sqrt(2.0))) -
           x * exp(-0.5 * r * r / (s * s));
}

/* The x in [low, radius] where the integral from 0 reaches `goal`: Newton's steps, halving where
 * they leave the bracket (the density vanishes at the radius). */
static double gaussian_quantile(const struct filter *f, double goal, double low)
{
    double s2 = 2.0 * (double)f->stddev * f->stddev, high = f->radius, x = low;
    double bias = exp(-high * high / s2);
    for (int i = 0; i < 60 && high - low > 1e-9 * (double)f->radius; i++) {
        double excess = gaussian_integral(f, x) - goal;
        if (excess < 0)
            low = x;
        else
            high = x;
        double step = excess / (exp(-x * x / s2) - bias);
        double next = x - step;
        if (fabs(step) < 1e-9 * (double)f->radius) return x;
        x = next > low && next < high ? next : 0.5 * (low + high);
    }
    return x;
}

/* The table's steps: probability of a smaller |x| at step i. What is left falls with the square of
 * the steps to the end, so that they follow the gaussian's tail. */
static double below_step(double i)
{
    double rest = 1.0 - i / 256.0;
    return 1.0 - rest * rest;
}

void filter_init(struct filter *f, enum filter_kind kind, float radius, float stddev)
{
    *f = (struct filter){.kind = kind, .radius = radius, .stddev = stddev};
    f->steps = (float)FILTER_STEPS / radius;
    for (int i = 0; i < FILTER_STEPS; i++)
        f->profile[i] = filter_eval(f, radius * (float)i / (float)FILTER_STEPS);
    if (kind != FILTER_GAUSSIAN) return;
    double total = gaussian_integral(f, radius);
    for (int i = 1; i < 256; i++)
        f->table[i] = (float)gaussian_quantile(f, total * below_step(i), f->table[i - 1]);
    f->table[256] = radius;
}

float filter_eval(const struct filter *f, float x)
{
    float a = fabsf(x), r = f->radius;
    switch (f->kind) {
    case FILTER_BOX:
        return a <= r ? 0.5f / r : 0.0f;
    case FILTER_TENT:
        return a < r ? (1.0f - a / r) / r : 0.0f;
    case FILTER_GAUSSIAN: {
        if (a >= r) return 0.0f;
        double s2 = 2.0 * (double)f->stddev * f->stddev;
        double value = exp(-(double)a * a / s2) - exp(-(double)r * r / s2);
        return (float)(value / (2.0 * gaussian_integral(f, r)));
    }
    }
    return 0.0f;
}

/* Probability of a distance below x. */
static float cumulative(const struct filter *f, float x)
{
    float r = f->radius, a = min_float(fabsf(x), r), half = 0.0f;
    switch (f->kind) {
    case FILTER_BOX:
        half = 0.5f * a / r;
        break;
    case FILTER_TENT:
        half = a / r * (1.0f - 0.5f * a / r);
        break;
    case FILTER_GAUSSIAN: /* consistent with the table, which is what is sampled */
        for (int step = 128, i = 0; step; step /= 2) {
            if (f->table[i + step] <= a) i += step;
            if (step == 1) {
                float low = f->table[i], high = f->table[i + 1];
                float at = (float)i + (high > low ? (a - low) / (high - low) : 0.0f);
                half = 0.5f * (float)below_step(min_float(at, 256.0f));
            }
        }
        break;
    }
    return x < 0.0f ? 0.5f - half : 0.5f + half;
}

float filter_sample(const struct filter *f, float u, float low, float high)
{
    if (low > -f->radius || high < f->radius) {
        float a = low > -f->radius ? cumulative(f, low) : 0.0f;
        float b = high < f->radius ? cumulative(f, high) : 1.0f;
        float x = filter_quantile(f, f->kind, a + (b - a) * u);
        return min_float(max_float(x, low), high);
    }
    return filter_quantile(f, f->kind, u);
}
