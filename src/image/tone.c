/* SPDX-License-Identifier: Apache-2.0 */
#include "image/tone.h"

#include <math.h>

#include "base/pool.h"
#include "image/image.h"

enum { CHUNK = 1 << 16 };

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
    size_t n;
    float exposure;
    uint8_t *out;
};

static void apply_chunk(void *ctx, uint32_t item, uint32_t worker)
{
    const struct job *j = ctx;
    const size_t first = (size_t)item * CHUNK, n = j->n - first < CHUNK ? j->n - first : CHUNK;
    const float *from = j->linear + first;
    uint8_t *to = j->out + first;
    (void)worker;
    for (size_t i = 0; i < n; i++) to[i] = tone_of(j->tone, j->exposure * from[i]);
}

void tone_apply(const struct tone *t, struct pool *pool, const float *linear, size_t n,
                float exposure, uint8_t *out)
{
    struct job j = {t, linear, n, exposure, out};
    pool_run(pool, (uint32_t)((n + CHUNK - 1) / CHUNK), apply_chunk, &j);
}
