/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_MEMORY_H
#define TRAIN_MEMORY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "train/safetensors.h"

/*
 * Pixels of traced configurations, in a ring: what learning draws its batches from. A slot is a
 * configuration; the oldest makes room for the newest.
 */
struct memory_shape {
    uint32_t n_variables; /* of the scene */
    uint32_t n_pixels;    /* of a slot */
    uint32_t n_lights;    /* groups of powers.h */
};

struct memory {
    struct memory_shape shape;
    uint64_t n_added;
    uint32_t capacity; /* slots */
    uint64_t size;     /* bytes */
    float *u;          /* [capacity][n_variables], with the lights' powers at the reference */
    float *kept;       /* [capacity][n_pixels][SIGHT_KEPT] */
    float *targets;    /* [capacity][n_pixels][n_lights][3], radiance by group of lights */
    float *halves;  /* the same shape: half the difference of two independent halves of samples */
    float *weights; /* [capacity][n_pixels], in the mean of the loss */
    float *errors;  /* [capacity], the slot's error without noise when it was last learnt */
};

/* As many slots as `mib` MiB hold; fails when that is less than `least`. */
lmn_status memory_init(struct memory *m, const struct memory_shape *shape, uint32_t mib,
                       uint32_t least, struct error *err);
void memory_release(struct memory *m);

static inline uint32_t memory_n_held(const struct memory *m)
{
    return m->n_added < m->capacity ? (uint32_t)m->n_added : m->capacity;
}

/* What a checkpoint keeps of it: the slots in use. */
enum { MEMORY_TENSORS = 6 };
void memory_tensors(struct memory *m, struct tensor *out);

#endif
