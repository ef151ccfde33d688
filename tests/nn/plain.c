/* SPDX-License-Identifier: Apache-2.0 */
#include "plain.h"

#include <math.h>

enum { MAX_FEATURES = 2048, MAX_SIDE = 32, WINDOW = 11 };

/* y = W x + b, then the activation; returns where the next layer's weights start. */
static const double *layer(const double *w, uint32_t n_in, uint32_t n_out, const double *x,
                           bool activate, double *y)
{
    const double *b = w + (size_t)n_in * n_out;
    for (uint32_t o = 0; o < n_out; o++) {
        double sum = b[o];
        for (uint32_t k = 0; k < n_in; k++) sum += w[(size_t)o * n_in + k] * x[k];
        y[o] = activate && sum < 0 ? 0.01 * sum : sum;
    }
    return b + n_out;
}

void plain_pixel(const struct generator_config *config, const double *weights, const double *inputs,
                 const double *v, double *f)
{
    double x[MAX_FEATURES], y[MAX_FEATURES], out[3];
    uint32_t width = config->width, n_in = width + 13 + config->n_variables;
    const double *w = layer(weights, 3, width, inputs + 6, true, y);
    for (uint32_t l = 0; l < config->depth + 2; l++) {
        bool last = l == config->depth + 1;
        for (uint32_t k = 0; k < n_in; k++)
            x[k] = k < width ? y[k] : k < width + 13 ? inputs[3 + k - width] : v[k - width - 13];
        w = layer(w, n_in, last ? 3 : width, x, !last, last ? out : y);
    }
    for (int c = 0; c < 3; c++) {
        double e = log1p(inputs[c]);
        f[c] = e > 1.0 ? e : out[c] + e;
    }
}

/* A value of an image whose axes are (a, b, channel), zero outside. Correct axes: rows, columns,
 * colours. Legacy: columns, colours, rows. */
static double at(uint32_t side, bool legacy, const double *image, int a, int b, uint32_t channel)
{
    int n_b = legacy ? 3 : (int)side;
    if (a < 0 || b < 0 || a >= (int)side || b >= n_b) return 0.0;
    uint32_t row = legacy ? channel : (uint32_t)a, column = legacy ? (uint32_t)a : (uint32_t)b;
    uint32_t colour = legacy ? (uint32_t)b : channel;
    return image[((size_t)row * side + column) * 3 + colour];
}

double plain_loss(uint32_t side, bool legacy, const double *f, const double *t)
{
    double g[WINDOW], sum = 0.0, l1 = 0.0, ssim = 0.0;
    uint32_t n_b = legacy ? 3 : side, n_channels = legacy ? side : 3;
    for (int i = 0; i < WINDOW; i++) sum += g[i] = exp(-(i - 5) * (i - 5) / (2 * 1.5 * 1.5));
    for (uint32_t channel = 0; channel < n_channels; channel++) {
        for (int a = 0; a < (int)side; a++) {
            for (int b = 0; b < (int)n_b; b++) {
                double mf = 0, mt = 0, ff = 0, tt = 0, ft = 0;
                for (int i = 0; i < WINDOW; i++) {
                    for (int j = 0; j < WINDOW; j++) {
                        double weight = g[i] * g[j] / (sum * sum);
                        double x = at(side, legacy, f, a + i - 5, b + j - 5, channel);
                        double y = at(side, legacy, t, a + i - 5, b + j - 5, channel);
                        mf += weight * x;
                        mt += weight * y;
                        ff += weight * x * x;
                        tt += weight * y * y;
                        ft += weight * x * y;
                    }
                }
                ssim += (2 * mf * mt + 1e-4) * (2 * (ft - mf * mt) + 9e-4) /
                        ((mf * mf + mt * mt + 1e-4) * (ff - mf * mf + tt - mt * mt + 9e-4));
            }
        }
    }
    for (size_t i = 0; i < (size_t)side * side * 3; i++) l1 += fabs(f[i] - t[i]);
    double n = 3.0 * side * side;
    return 2 * l1 / n + 1 - ssim / n;
}

double plain_batch_loss(const struct generator_config *config, const double *weights,
                        const struct generator_batch *batch, bool legacy)
{
    static double f[MAX_SIDE * MAX_SIDE * 3], t[MAX_SIDE * MAX_SIDE * 3], v[MAX_FEATURES];
    uint32_t side = config->patch_size;
    double total = 0.0;
    for (uint32_t p = 0; p < batch->n_patches; p++) {
        for (uint32_t i = 0; i < config->n_variables; i++) v[i] = (double)batch->v[p][i];
        for (uint32_t pixel = 0; pixel < side * side; pixel++) {
            double inputs[GENERATOR_INPUTS];
            for (int i = 0; i < GENERATOR_INPUTS; i++)
                inputs[i] = (double)batch->inputs[p][pixel * GENERATOR_INPUTS + (uint32_t)i];
            plain_pixel(config, weights, inputs, v, f + pixel * 3);
            for (uint32_t c = 0; c < 3; c++)
                t[pixel * 3 + c] = (double)batch->targets[p][pixel * 3 + c];
        }
        total += plain_loss(side, legacy, f, t);
    }
    return total / batch->n_patches;
}
