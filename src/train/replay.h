/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_REPLAY_H
#define TRAIN_REPLAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/rng.h"

/*
 * The memory of rendered patches that training draws from again (Sec. 6.1), each with the
 * probability of its last recorded loss. A ring: a new patch takes the place of the oldest, with
 * everything that was known of it. All memory is taken by replay_init().
 *
 * The n-th patch ever added has serial number n (from 0) and lies in slot n % capacity as long as
 * it is remembered. A binary tree of sums over the slots' losses makes drawing and updating
 * O(log capacity); each inner node is always exactly the sum of its two children, so the tree is a
 * function of the losses alone and need not be saved.
 */
struct replay {
    uint32_t capacity, n; /* patches: room for, held now */
    uint32_t n_pixels;    /* of a patch */
    uint32_t n_variables;
    uint64_t n_added; /* ever; the next serial number */

    /* By slot; owned. */
    float *inputs;  /* [capacity][n_pixels][GENERATOR_INPUTS] */
    float *targets; /* [capacity][n_pixels][3] */
    float *v;       /* [capacity][n_variables] */
    float *losses;  /* [capacity], last recorded */
    bool *is_large; /* [capacity], born from a large step */

    uint32_t n_leaves; /* a power of two >= capacity */
    double *sums;      /* [2 * n_leaves], root at 1, leaf of slot s at n_leaves + s; owned */
    uint64_t memory_size;
};

/* How much one remembered patch takes, in bytes. */
size_t replay_patch_size(uint32_t n_pixels, uint32_t n_variables);

/* capacity may be 0: nothing is remembered. */
lmn_status replay_init(struct replay *m, uint32_t capacity, uint32_t n_pixels, uint32_t n_variables,
                       struct error *err);
void replay_release(struct replay *m);

/* Copies a patch in; returns its serial number. */
uint64_t replay_add(struct replay *m, const float *inputs, const float *targets, const float *v,
                    float loss, bool is_large);

/* The slot of a serial number, or UINT32_MAX when it is forgotten. */
uint32_t replay_slot(const struct replay *m, uint64_t serial);

/* Records a new loss; what is negative or not finite counts as 0. */
void replay_set_loss(struct replay *m, uint32_t slot, float loss);

/* A slot with probability loss / sum of losses (uniform when all are 0); m->n > 0. */
uint32_t replay_draw(const struct replay *m, struct rng *r);

/* After the slots were filled from a checkpoint: rebuilds the sums. */
void replay_rebuild(struct replay *m);

#endif
