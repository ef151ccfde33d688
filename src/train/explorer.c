/* SPDX-License-Identifier: Apache-2.0 */
#include "train/explorer.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"

enum { STREAM_EXPLORER = 0x6578706C }; /* keeps these numbers apart from others of the same seed */

lmn_status explorer_init(struct explorer *e, const struct explorer_options *options,
                         struct error *err)
{
    size_t n = options->n_chains;
    *e = (struct explorer){.options = *options};
    e->u = mem_new(n * options->dim, sizeof *e->u);
    e->proposals = mem_new(n * options->dim, sizeof *e->proposals);
    e->is_large = mem_new(n, sizeof *e->is_large);
    if (e->u && e->proposals && e->is_large) return LMN_OK;
    explorer_release(e);
    return fail_memory(err, "the Markov chains");
}

void explorer_release(struct explorer *e)
{
    mem_free(e->u);
    mem_free(e->proposals);
    mem_free(e->is_large);
    *e = (struct explorer){0};
}

/* x + d on the unit circle. */
static float wrap(double x)
{
    float y = (float)(x - floor(x));
    return y < 1.0f ? y : 0.0f; /* just below 1 rounds up to it */
}

void explorer_small_step(const float *u, uint32_t dim, double s1, double s2, struct rng *r,
                         float *out)
{
    double k = -log(s2 / s1);
    for (uint32_t i = 0; i < dim; i++) {
        double d = s2 * exp(k * rng_double(r));
        out[i] = wrap((double)u[i] + (rng_u32(r) & 1u ? d : -d));
    }
}

void explorer_propose(struct explorer *e)
{
    const struct explorer_options *o = &e->options;
    for (uint32_t chain = 0; chain < o->n_chains; chain++) {
        struct rng r = rng_keyed(o->seed ^ STREAM_EXPLORER, e->generation, chain);
        const float *u = e->u + (size_t)chain * o->dim;
        float *v = e->proposals + (size_t)chain * o->dim;
        bool is_large = rng_double(&r) < o->large_step || e->generation == 0;
        e->is_large[chain] = is_large;
        if (is_large)
            for (uint32_t i = 0; i < o->dim; i++) v[i] = rng_float(&r);
        else
            explorer_small_step(u, o->dim, o->step_min, o->step_max, &r, v);
    }
}

uint32_t explorer_decide(struct explorer *e, const float *p_states, const float *p_proposals,
                         bool *is_accepted)
{
    const struct explorer_options *o = &e->options;
    bool takes_all = o->accepts_all || e->generation == 0;
    uint32_t n_accepted = 0;
    for (uint32_t chain = 0; chain < o->n_chains; chain++) {
        /* Eq. 4, with >= as in the authors' code. Written so that a state whose p is not a number
         * cannot hold its chain for ever. */
        is_accepted[chain] = takes_all || !(p_proposals[chain] < p_states[chain]);
        if (!is_accepted[chain]) continue;
        size_t at = (size_t)chain * o->dim;
        memcpy(e->u + at, e->proposals + at, o->dim * sizeof *e->u);
        n_accepted++;
    }
    e->generation++;
    return n_accepted;
}
