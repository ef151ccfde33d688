/* SPDX-License-Identifier: Apache-2.0 */
#include "image/tone.h"

#include <math.h>

#include "base/pool.h"
#include "image/image.h"

enum { CHUNK = 1 << 14 }; /* pixels */

static float from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

void tone_init(struct tone *t)
{
    const uint32_t one = 127u << 23, start = (127u - TONE_OCTAVES) << 23;
    for (uint32_t k = 1; k < 256; k++) { /* positive floats stand in the order of their bits */
        uint32_t below = 0, at = one;
        while (at - below > 1) {
            const uint32_t middle = below + (at - below) / 2;
            *(tone_byte(srgb_encode(from_bits(middle))) >= k ? &at : &below) = middle;
        }
        t->least[k] = from_bits(at);
    }
    t->least[0] = 0.0f;
    t->least[256] = INFINITY;
    for (uint32_t i = 0; i < TONE_OCTAVES * TONE_PIECES; i++)
        t->first[i] = tone_byte(srgb_encode(from_bits(start + i * (1u << 15))));
}

struct job {
    const struct tone *tone;
    const float *linear;
    size_t n_pixels, stride;
    float exposure;
    enum tone_curve curve;
    uint8_t *out;
};

static float film(float x)
{
    x = x > 0.0f ? fminf(x, 1e4f) : 0.0f;
    return x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f);
}

static void apply_chunk(void *ctx, uint32_t item, uint32_t worker)
{
    const struct job *j = ctx;
    const size_t first = (size_t)item * CHUNK;
    const size_t end = j->n_pixels - first < CHUNK ? j->n_pixels : first + CHUNK;
    (void)worker;
    for (size_t i = first; i < end; i++)
        for (size_t c = 0; c < 3; c++) {
            const float x = j->exposure * j->linear[i * j->stride + c];
            j->out[3 * i + c] = tone_of(j->tone, j->curve == TONE_ACES ? film(x) : x);
        }
}

void tone_apply(const struct tone *t, struct pool *pool, const float *linear, size_t n_pixels,
                size_t stride, float exposure, enum tone_curve curve, uint8_t *out)
{
    struct job j = {t, linear, n_pixels, stride, exposure, curve, out};
    pool_run(pool, (uint32_t)((n_pixels + CHUNK - 1) / CHUNK), apply_chunk, &j);
}
