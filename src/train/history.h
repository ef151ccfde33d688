/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_HISTORY_H
#define TRAIN_HISTORY_H

#include <stdint.h>

#include "base/error.h"

/*
 * How a training went, small enough to travel in the model file: at most HISTORY_ROWS rows, each
 * the mean over `stride` steps. When they are full, neighbours are merged and the stride doubles;
 * the result depends on the steps alone, not on where training was stopped and resumed. Beside it,
 * thinned the same way, the states of the chains.
 */
enum {
    HISTORY_ROWS = 2048,
    HISTORY_SNAPSHOTS = 128 /* of the chains */
};

enum history_column {
    HISTORY_STEP, /* the last one that the row covers */
    HISTORY_LOSS,
    HISTORY_LOSS_FRESH,
    HISTORY_LOSS_REPLAYED,
    HISTORY_REUSE_PROBABILITY,
    HISTORY_ACCEPTANCE,
    HISTORY_RESOLUTION,
    HISTORY_FRESH, /* share of steps on new patches */
    HISTORY_COLUMNS
};
extern const char *const history_column_names[HISTORY_COLUMNS];

struct history {
    uint64_t stride;                 /* steps per row, a power of two */
    uint32_t n_rows;                 /* full ones */
    uint32_t n_pending;              /* steps summed in rows[n_rows], < stride */
    double (*rows)[HISTORY_COLUMNS]; /* [HISTORY_ROWS]; owned */
    double pending[HISTORY_COLUMNS]; /* sums */

    uint32_t n_chains, dim;
    uint64_t snapshot_stride; /* generations per snapshot, a power of two */
    uint32_t n_snapshots;
    double *snapshot_steps; /* [HISTORY_SNAPSHOTS]; owned */
    float *snapshots;       /* [HISTORY_SNAPSHOTS][n_chains][dim]; owned */
    uint64_t memory_size;
};

lmn_status history_init(struct history *h, uint32_t n_chains, uint32_t dim, struct error *err);
void history_release(struct history *h);

/* One step, columns as above (HISTORY_FRESH 0 or 1). */
void history_add(struct history *h, const double row[HISTORY_COLUMNS]);

/* The chains' states [n_chains][dim] after generation number `generation` (from 0). */
void history_add_chains(struct history *h, uint64_t generation, uint64_t step, const float *u);

#endif
