/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_ADAM_H
#define NN_ADAM_H

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

struct pool;

/* Adam (Kingma & Ba 2015) as torch.optim.Adam computes it. */
struct adam {
    float *m, *v; /* [n], owned, released by adam_release() */
    size_t n;
    uint64_t t; /* steps made */
    double learning_rate, beta1, beta2, eps;
    uint32_t cpu; /* flags of base/cpu.h that a step may use: 0 until the owner sets them; results
                     have the same bytes for any */
    /* NULL, or [n], the caller's: each step moves it towards the new weights by `share`; below 0.05
     * every fourth does, by as much as four. */
    float *average;
    float share;
};

/* Zero moments, beta1 = 0.9, beta2 = 0.999, eps = 1e-8. */
lmn_status adam_init(struct adam *a, size_t n, double learning_rate, struct error *err);
void adam_release(struct adam *a);

/* w -= lr * m^ / (sqrt(v^) + eps). */
void adam_step(struct adam *a, struct pool *pool, float *weights, const float *gradient);

/* The Euclidean norm of the change that adam_step() would make now; nothing is changed. Runs on the
 * calling thread. */
double adam_step_norm(const struct adam *a, const float *gradient);

#endif
