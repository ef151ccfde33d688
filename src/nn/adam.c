/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/adam.h"

#include <math.h>

#include "base/mem.h"
#include "base/pool.h"

enum { CHUNK = 1 << 14 };

lmn_status adam_init(struct adam *a, size_t n, double learning_rate, struct error *err)
{
    *a = (struct adam){
        .n = n, .learning_rate = learning_rate, .beta1 = 0.9, .beta2 = 0.999, .eps = 1e-8};
    a->m = mem_new(n, sizeof *a->m);
    a->v = mem_new(n, sizeof *a->v);
    if (a->m && a->v) return LMN_OK;
    adam_release(a);
    return fail_memory(err, "Adam's moments");
}

void adam_release(struct adam *a)
{
    mem_free(a->m);
    mem_free(a->v);
    *a = (struct adam){0};
}

/* What step number t multiplies with, in the precision of the weights. */
struct factors {
    float beta1, beta2, rest1, rest2; /* rest = 1 - beta */
    float rate;                       /* lr / (1 - beta1^t) */
    float root;                       /* 1 / sqrt(1 - beta2^t) */
    float eps;
};

static struct factors factors_at(const struct adam *a, uint64_t t)
{
    return (struct factors){
        .beta1 = (float)a->beta1,
        .beta2 = (float)a->beta2,
        .rest1 = (float)(1.0 - a->beta1),
        .rest2 = (float)(1.0 - a->beta2),
        .rate = (float)(a->learning_rate / (1.0 - pow(a->beta1, (double)t))),
        .root = (float)(1.0 / sqrt(1.0 - pow(a->beta2, (double)t))),
        .eps = (float)a->eps,
    };
}

struct step {
    const struct adam *a;
    struct factors f;
    float *weights;
    const float *gradient;
};

static void step_chunk(void *ctx, uint32_t item, uint32_t worker)
{
    const struct step *s = ctx;
    const struct factors f = s->f;
    size_t first = (size_t)item * CHUNK, rest = s->a->n - first;
    uint32_t n = rest < CHUNK ? (uint32_t)rest : CHUNK;
    float *restrict w = s->weights + first, *restrict m = s->a->m + first;
    float *restrict v = s->a->v + first;
    const float *restrict g = s->gradient + first;
    (void)worker;
    for (uint32_t i = 0; i < n; i++) {
        m[i] = f.beta1 * m[i] + f.rest1 * g[i];
        v[i] = f.beta2 * v[i] + f.rest2 * g[i] * g[i];
        w[i] -= f.rate * m[i] / (sqrtf(v[i]) * f.root + f.eps);
    }
}

void adam_step(struct adam *a, struct pool *pool, float *weights, const float *gradient)
{
    struct step s = {.a = a, .f = factors_at(a, ++a->t), .weights = weights, .gradient = gradient};
    pool_run(pool, (uint32_t)((a->n + CHUNK - 1) / CHUNK), step_chunk, &s);
}

double adam_step_norm(const struct adam *a, const float *gradient)
{
    enum { LANES = 8, BLOCK = 1024 }; /* short float sums, then doubles: a fixed order */
    const struct factors f = factors_at(a, a->t + 1);
    double total = 0.0;
    for (size_t first = 0; first < a->n; first += BLOCK) {
        const float *m = a->m + first, *v = a->v + first, *g = gradient + first;
        size_t n = a->n - first < BLOCK ? a->n - first : BLOCK, i = 0;
        float sum[LANES] = {0};
        for (; i + LANES <= n; i += LANES) {
            for (size_t j = 0; j < LANES; j++) {
                float mj = f.beta1 * m[i + j] + f.rest1 * g[i + j];
                float vj = f.beta2 * v[i + j] + f.rest2 * g[i + j] * g[i + j];
                float step = mj / (sqrtf(vj) * f.root + f.eps);
                sum[j] += step * step;
            }
        }
        for (; i < n; i++) {
            float mi = f.beta1 * m[i] + f.rest1 * g[i];
            float vi = f.beta2 * v[i] + f.rest2 * g[i] * g[i];
            float step = mi / (sqrtf(vi) * f.root + f.eps);
            sum[0] += step * step;
        }
        for (size_t j = 0; j < LANES; j++) total += sum[j];
    }
    return f.rate * sqrt(total);
}
