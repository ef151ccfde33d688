/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_EXPLORER_H
#define TRAIN_EXPLORER_H

#include <stdbool.h>
#include <stdint.h>

#include "base/error.h"
#include "base/rng.h"

/*
 * The Markov chains of active exploration (Sec. 5.1). A chain's state u lives in [0,1)^dim: the
 * scene's variables, then where the patch lies in the picture. All chains advance together, one
 * generation at a time:
 *
 *   explorer_propose()   v from T(u -> v), Eq. 2: uniform with probability p_LS, else a small step
 *   (the caller renders v and evaluates p(u) and p(v) with the network as it is now)
 *   explorer_decide()    Eq. 4: v replaces u where p(v) >= p(u)
 *
 * Random numbers are keyed by (seed, generation, chain): a generation can be proposed again.
 */

struct explorer_options {
    uint32_t n_chains, dim;
    uint64_t seed;
    double large_step;         /* p_LS; 1: every step is large (the uniform baseline) */
    double step_min, step_max; /* s1 <= s2: lengths of a small step, in every dimension */
    bool accepts_all;          /* the uniform baseline */
};

struct explorer {
    struct explorer_options options;
    uint64_t generation; /* decided so far; 0: chains have no state yet */
    float *u;            /* [n_chains][dim], the states; owned */
    float *proposals;    /* [n_chains][dim], of the generation under way; owned */
    bool *is_large;      /* [n_chains], how each proposal was born; owned */
};

lmn_status explorer_init(struct explorer *e, const struct explorer_options *options,
                         struct error *err);
void explorer_release(struct explorer *e);

/* Fills proposals and is_large. In the first generation all are uniform draws. */
void explorer_propose(struct explorer *e);

/*
 * p_states, p_proposals  [n_chains], the target function; not read in the first generation nor when
 *                        all are accepted, and may then be NULL
 * is_accepted            [n_chains], out; the first proposals are always accepted
 * Returns how many were accepted. Proposals stay readable until the next explorer_propose().
 */
uint32_t explorer_decide(struct explorer *e, const float *p_states, const float *p_proposals,
                         bool *is_accepted);

/*
 * Kelemen et al. 2002's mutation: every component moves by s2 exp(-ln(s2/s1) xi), xi ~ U[0,1), up
 * or down with equal chance, and wraps around the unit torus. |du| has density 1 / (d ln(s2/s1)) on
 * (s1, s2].
 */
void explorer_small_step(const float *u, uint32_t dim, double s1, double s2, struct rng *r,
                         float *out);

#endif
