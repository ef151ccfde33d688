/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/loss.h"

#include <math.h>
#include <string.h>

enum { RADIUS = 5, TAPS = 2 * RADIUS + 1, COLOURS = 3 };

/* exp(-(i-5)^2 / (2 * 1.5^2)), scaled to sum to 1. */
static const float gauss[TAPS] = {
    0.00102838008f, 0.00759875814f, 0.0360007721f, 0.10936069f,    0.213005538f,   0.266011725f,
    0.213005538f,   0.10936069f,    0.0360007721f, 0.00759875814f, 0.00102838008f,
};

static const float C1 = 1e-4f, C2 = 9e-4f;

/* Planes of side * side * 3 floats: blurs of f, t, f f, t t, f t and one that blur() works in, then
 * a padded row. */
enum { MU_F, MU_T, E_FF, E_TT, E_FT, WORK, N_PLANES };

size_t loss_scratch_count(uint32_t side)
{
    return (size_t)N_PLANES * COLOURS * side * side + side + 2 * RADIUS;
}

/* out[x] = sum of gauss over in[x-5 .. x+5], zero outside; `row` holds side + 10 floats. */
static void blur_row(uint32_t side, const float *in, float *out, float *row)
{
    memset(row, 0, RADIUS * sizeof *row);
    memcpy(row + RADIUS, in, side * sizeof *row);
    memset(row + RADIUS + side, 0, RADIUS * sizeof *row);
    for (uint32_t x = 0; x < side; x++) {
        float sum = gauss[0] * (row[x] + row[x + 10]);
        sum += gauss[1] * (row[x + 1] + row[x + 9]);
        sum += gauss[2] * (row[x + 2] + row[x + 8]);
        sum += gauss[3] * (row[x + 3] + row[x + 7]);
        sum += gauss[4] * (row[x + 4] + row[x + 6]);
        out[x] = sum + gauss[5] * row[x + 5];
    }
}

/* out[i] += sum over j of gauss[j - i + 5] in[j], for n vectors of `length` floats, `in` and `out`
 * being `pitch` floats from vector to vector. */
static void blur_across(uint32_t n, size_t pitch, size_t length, const float *in, float *out)
{
    for (uint32_t i = 0; i < n; i++) {
        float *o = out + i * pitch;
        uint32_t j0 = i < RADIUS ? 0 : i - RADIUS, j1 = i + RADIUS < n ? i + RADIUS : n - 1;
        memset(o, 0, length * sizeof *o);
        for (uint32_t j = j0; j <= j1; j++) {
            const float *v = in + j * pitch;
            float weight = gauss[j + RADIUS - i];
            for (size_t x = 0; x < length; x++) o[x] += weight * v[x];
        }
    }
}

/* The zero-padded window is symmetric, so that blur is its own adjoint. In place. */
static void blur(uint32_t side, bool legacy, float *planes, float *work, float *row)
{
    size_t area = (size_t)side * side;
    for (uint32_t y = 0; y < COLOURS * side; y++)
        blur_row(side, planes + (size_t)y * side, work + (size_t)y * side, row);
    if (legacy) {
        blur_across(COLOURS, area, area, work, planes);
        return;
    }
    for (uint32_t c = 0; c < COLOURS; c++)
        blur_across(side, side, side, work + c * area, planes + c * area);
}

double loss_patch(uint32_t side, bool legacy, const float *f, const float *t, float *df,
                  float *scratch)
{
    size_t n = (size_t)COLOURS * side * side;
    float *plane[N_PLANES];
    for (int i = 0; i < N_PLANES; i++) plane[i] = scratch + (size_t)i * n;
    float *row = scratch + N_PLANES * n, *work = plane[WORK];

    for (size_t i = 0; i < n; i++) {
        plane[MU_F][i] = f[i];
        plane[MU_T][i] = t[i];
        plane[E_FF][i] = f[i] * f[i];
        plane[E_TT][i] = t[i] * t[i];
        plane[E_FT][i] = f[i] * t[i];
    }
    for (int i = MU_F; i <= E_FT; i++) blur(side, legacy, plane[i], work, row);

    /* S = A1 A2 / (B1 B2). The derivatives with respect to the blurs of f, f f and f t replace
     * those blurs; that of t t is a constant. */
    double l1 = 0.0, ssim = 0.0;
    float scale = 1.0f / (float)n;
    for (size_t i = 0; i < n; i++) {
        float mf = plane[MU_F][i], mt = plane[MU_T][i];
        float a1 = 2.0f * mf * mt + C1, a2 = 2.0f * (plane[E_FT][i] - mf * mt) + C2;
        float b1 = mf * mf + mt * mt + C1;
        float b2 = (plane[E_FF][i] - mf * mf) + (plane[E_TT][i] - mt * mt) + C2;
        float inverse = 1.0f / (b1 * b2), s = a1 * a2 * inverse;
        float d_ft = 2.0f * a1 * inverse, d_ff = -s / b2;
        l1 += fabsf(f[i] - t[i]);
        ssim += s;
        plane[MU_F][i] = scale * (2.0f * mt * a2 * inverse - 2.0f * mf * s / b1 - mt * d_ft -
                                  2.0f * mf * d_ff);
        plane[E_FF][i] = scale * d_ff;
        plane[E_FT][i] = scale * d_ft;
    }
    if (df) {
        blur(side, legacy, plane[MU_F], work, row);
        blur(side, legacy, plane[E_FF], work, row);
        blur(side, legacy, plane[E_FT], work, row);
        for (size_t i = 0; i < n; i++) {
            float d = f[i] - t[i], sign = d > 0.0f ? 2.0f : d < 0.0f ? -2.0f : 0.0f;
            df[i] = scale * sign -
                    (plane[MU_F][i] + 2.0f * f[i] * plane[E_FF][i] + t[i] * plane[E_FT][i]);
        }
    }
    return 2.0 * l1 / (double)n + 1.0 - ssim / (double)n;
}
