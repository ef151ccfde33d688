/* SPDX-License-Identifier: Apache-2.0 */
#include "train/history.h"

#include <string.h>

#include "base/mem.h"

const char *const history_column_names[HISTORY_COLUMNS] = {
    "step",       "loss",       "loss_fresh", "loss_replayed", "reuse_probability",
    "acceptance", "resolution", "fresh"};

lmn_status history_init(struct history *h, uint32_t n_chains, uint32_t dim, struct error *err)
{
    *h = (struct history){.stride = 1, .snapshot_stride = 1, .n_chains = n_chains, .dim = dim};
    size_t n_states = (size_t)n_chains * dim;
    h->rows = mem_new(HISTORY_ROWS, sizeof *h->rows);
    h->snapshot_steps = mem_new(HISTORY_SNAPSHOTS, sizeof *h->snapshot_steps);
    h->snapshots = mem_new(HISTORY_SNAPSHOTS * n_states, sizeof *h->snapshots);
    if (!h->rows || !h->snapshot_steps || !h->snapshots) {
        history_release(h);
        return fail_memory(err, "the history of training");
    }
    h->memory_size = HISTORY_ROWS * sizeof *h->rows +
                     HISTORY_SNAPSHOTS * (sizeof *h->snapshot_steps + n_states * sizeof(float));
    return LMN_OK;
}

void history_release(struct history *h)
{
    mem_free(h->rows);
    mem_free(h->snapshot_steps);
    mem_free(h->snapshots);
    *h = (struct history){0};
}

/* Halves the rows: neighbours become their mean, the step is that of the later one. */
static void merge_rows(struct history *h)
{
    for (uint32_t i = 0; i < HISTORY_ROWS / 2; i++) {
        const double *a = h->rows[2 * i], *b = h->rows[2 * i + 1];
        double row[HISTORY_COLUMNS];
        for (int c = 0; c < HISTORY_COLUMNS; c++) row[c] = 0.5 * (a[c] + b[c]);
        row[HISTORY_STEP] = b[HISTORY_STEP];
        memcpy(h->rows[i], row, sizeof row);
    }
    h->n_rows = HISTORY_ROWS / 2;
    h->stride *= 2;
}

void history_add(struct history *h, const double row[HISTORY_COLUMNS])
{
    for (int c = 0; c < HISTORY_COLUMNS; c++) h->pending[c] += row[c];
    if (++h->n_pending < h->stride) return;
    if (h->n_rows == HISTORY_ROWS) {
        merge_rows(h); /* the pending row is half of a row now */
        return;
    }
    double *out = h->rows[h->n_rows++];
    for (int c = 0; c < HISTORY_COLUMNS; c++) {
        out[c] = h->pending[c] / (double)h->n_pending;
        h->pending[c] = 0;
    }
    out[HISTORY_STEP] = row[HISTORY_STEP];
    h->n_pending = 0;
}

void history_add_chains(struct history *h, uint64_t generation, uint64_t step, const float *u)
{
    if (generation % h->snapshot_stride != 0) return;
    size_t n = (size_t)h->n_chains * h->dim;
    if (h->n_snapshots == HISTORY_SNAPSHOTS) {
        for (uint32_t i = 1; i < HISTORY_SNAPSHOTS / 2; i++) {
            memcpy(h->snapshots + i * n, h->snapshots + 2 * i * n, n * sizeof *h->snapshots);
            h->snapshot_steps[i] = h->snapshot_steps[2 * i];
        }
        h->n_snapshots = HISTORY_SNAPSHOTS / 2;
        h->snapshot_stride *= 2;
        if (generation % h->snapshot_stride != 0) return;
    }
    memcpy(h->snapshots + h->n_snapshots * n, u, n * sizeof *u);
    h->snapshot_steps[h->n_snapshots++] = (double)step;
}
