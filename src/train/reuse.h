/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_REUSE_H
#define TRAIN_REUSE_H

#include <stdbool.h>
#include <stdint.h>

/*
 * Self-tuning sample reuse (Sec. 6.1): how probable it is that the next step trains on remembered
 * patches instead of new ones. The loss on new and on remembered samples is followed by two moving
 * averages, both of samples born from large steps only, as the chains seek high losses.
 */
struct reuse {
    double bias;     /* beta of Eq. 5 */
    double ema;      /* alpha: average = (1 - alpha) loss + alpha average */
    uint32_t warmup; /* that many first generations are always new */

    uint64_t n_events;           /* generations so far */
    double loss_new, loss_exist; /* the averages; meaningful from the last warm-up event on */
};

/* Eq. 5: p_s = sigmoid(loss_exist - loss_new + beta); 0 during warm-up. */
double reuse_probability(const struct reuse *r);

bool reuse_is_warm(const struct reuse *r);

/* A generation was trained on: its mean loss, and those of its new samples that came from large
 * steps. The last event of the warm-up starts both averages at its mean loss. */
void reuse_record_event(struct reuse *r, double mean_loss, const float *losses,
                        const bool *is_large, uint32_t n);

/* One remembered sample was trained on again. */
void reuse_record_replayed(struct reuse *r, double loss, bool is_large);

#endif
