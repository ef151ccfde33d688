/* SPDX-License-Identifier: Apache-2.0 */
#include "nn/adam.h"

#include <math.h>

#include "base/cpu.h"
#include "base/mem.h"
#include "base/pool.h"
#include "nn/adam_step.h"

enum { CHUNK = 1 << 12 }; /* w, m, v and the gradient stay in the second-level cache */

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

/* Averages over many steps are brought up to date every fourth: they are a fifth of the memory that
 * a step goes through. */
enum { AVERAGE_EVERY = 4 };
#define LONG_SHARE 0.05f

static struct adam_factors factors_at(const struct adam *a, uint64_t t)
{
    return (struct adam_factors){
        .beta1 = (float)a->beta1,
        .beta2 = (float)a->beta2,
        .rest1 = (float)(1.0 - a->beta1),
        .rest2 = (float)(1.0 - a->beta2),
        .rate = (float)(a->learning_rate / (1.0 - pow(a->beta1, (double)t))),
        .root = (float)(1.0 / sqrt(1.0 - pow(a->beta2, (double)t))),
        .eps = (float)a->eps,
    };
}

void adam_step_baseline(const struct adam_factors *factors, uint32_t n, float *weights, float *m,
                        float *v, const float *gradient, float *average)
{
    adam_step_loop(factors, n, weights, m, v, gradient, average);
}

struct step {
    const struct adam *a;
    struct adam_factors f;
    adam_step_fn *run;
    float *average; /* NULL: not now */
    float *weights;
    const float *gradient;
};

static void step_chunk(void *ctx, uint32_t item, uint32_t worker)
{
    const struct step *s = ctx;
    const struct adam *a = s->a;
    const size_t first = (size_t)item * CHUNK, rest = a->n - first;
    (void)worker;
    s->run(&s->f, rest < CHUNK ? (uint32_t)rest : CHUNK, s->weights + first, a->m + first,
           a->v + first, s->gradient + first, s->average ? s->average + first : NULL);
}

void adam_step(struct adam *a, struct pool *pool, float *weights, const float *gradient)
{
    struct step s = {.a = a,
                     .f = factors_at(a, ++a->t),
                     .average = a->average,
                     .run = a->cpu & CPU_AVX512 ? adam_step_avx512
                            : a->cpu & CPU_AVX2 ? adam_step_avx2
                                                : adam_step_baseline,
                     .weights = weights,
                     .gradient = gradient};
    s.f.share = a->share;
    if (a->share < LONG_SHARE) {
        s.f.share = 1.0f - powf(1.0f - a->share, AVERAGE_EVERY);
        if (a->t % AVERAGE_EVERY != 0) s.average = NULL;
    }
    pool_run(pool, (uint32_t)((a->n + CHUNK - 1) / CHUNK), step_chunk, &s);
}

double adam_step_norm(const struct adam *a, const float *gradient)
{
    enum { LANES = 8, BLOCK = 1024 }; /* short float sums, then doubles: a fixed order */
    const struct adam_factors f = factors_at(a, a->t + 1);
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
