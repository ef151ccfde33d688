/* SPDX-License-Identifier: Apache-2.0 */
#include "train/reuse.h"

#include <math.h>

bool reuse_is_warm(const struct reuse *r)
{
    return r->n_events >= r->warmup;
}

double reuse_probability(const struct reuse *r)
{
    if (!reuse_is_warm(r)) return 0;
    return 1.0 / (1.0 + exp(-(r->loss_exist - r->loss_new + r->bias)));
}

static double average(const struct reuse *r, double old, double loss)
{
    return (1.0 - r->ema) * loss + r->ema * old;
}

void reuse_record_event(struct reuse *r, double mean_loss, const float *losses,
                        const bool *is_large, uint32_t n)
{
    r->n_events++;
    if (r->n_events == r->warmup) {
        r->loss_new = r->loss_exist = mean_loss;
        return;
    }
    if (r->n_events < r->warmup) return;
    for (uint32_t i = 0; i < n; i++)
        if (is_large[i]) r->loss_new = average(r, r->loss_new, (double)losses[i]);
}

void reuse_record_replayed(struct reuse *r, double loss, bool is_large)
{
    if (is_large) r->loss_exist = average(r, r->loss_exist, loss);
}
