/* SPDX-License-Identifier: Apache-2.0 */
#include "train/inputs.h"

#include <math.h>
#include <string.h>

static float finite_or_zero(float x)
{
    return isfinite(x) ? x : 0.0f;
}

/* Order of nn/generator.h: emission 3 | normal 3 | position 3 | wi 3 | albedo 3 | alpha 1. */
void inputs_from_buffers(const struct scene *s, const float *buffers, size_t n_pixels,
                         float *inputs)
{
    const float lo[3] = {s->bounds.min.x, s->bounds.min.y, s->bounds.min.z};
    const float hi[3] = {s->bounds.max.x, s->bounds.max.y, s->bounds.max.z};
    float scale[3];
    for (int c = 0; c < 3; c++) scale[c] = hi[c] > lo[c] ? 1.0f / (hi[c] - lo[c]) : 0.0f;

    for (size_t i = 0; i < n_pixels; i++) {
        const float *b = buffers + i * BUFFER_CHANNELS;
        float *x = inputs + i * GENERATOR_INPUTS;
        for (int c = 0; c < 3; c++) {
            x[c] = fmaxf(finite_or_zero(b[BUFFER_EMISSION + c]), 0.0f);
            x[3 + c] = 0.5f * finite_or_zero(b[BUFFER_NORMAL + c]) + 0.5f;
            x[6 + c] = finite_or_zero((b[BUFFER_POSITION + c] - lo[c]) * scale[c]);
            x[9 + c] = finite_or_zero(b[BUFFER_WI + c]);
            x[12 + c] = finite_or_zero(b[BUFFER_ALBEDO + c]);
        }
        x[15] = finite_or_zero(b[BUFFER_ROUGHNESS]);
    }
}

void inputs_targets(const float *color, size_t n_pixels, float *targets)
{
    for (size_t i = 0; i < 3 * n_pixels; i++) {
        float x = color[i];
        targets[i] = x > 0.0f && isfinite(x) ? log1pf(x) : 0.0f;
    }
}

float inputs_variable(const struct scene *s, uint32_t variable, float u)
{
    uint32_t n = s->variables[variable].n_choices;
    if (n == 0) return u;
    /* As scene_apply() chooses. */
    float choice = fminf(floorf(u * (float)n), (float)(n - 1));
    return n > 1 ? choice / (float)(n - 1) : 0.0f;
}

void inputs_variables(const struct scene *s, const float *u, float *v)
{
    for (uint32_t i = 0; i < s->n_variables; i++) v[i] = inputs_variable(s, i, u[i]);
}

static uint32_t side(uint32_t resolution, uint32_t mine, uint32_t longer, uint32_t least)
{
    uint64_t size = ((uint64_t)resolution * mine + longer / 2) / longer;
    return size < least ? least : (uint32_t)size;
}

void inputs_picture_size(const struct scene *s, uint32_t resolution, uint32_t least,
                         uint32_t *width, uint32_t *height)
{
    uint32_t w = s->settings.width, h = s->settings.height;
    if (w == 0 || h == 0) w = h = 1;
    uint32_t longer = w > h ? w : h;
    *width = side(resolution, w, longer, least);
    *height = side(resolution, h, longer, least);
}
