/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NN_GRID_H
#define NN_GRID_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 * A multiresolution hash grid (Mueller et al. 2022, "Instant Neural Graphics Primitives", Sec. 3):
 * per level two learnt numbers at every vertex of a cubic lattice over [0,1]^3, interpolated
 * linearly. Fine levels hash the vertices into a table of limited size; collisions are left to
 * learning.
 *
 * The table of a grid is one block of floats: level after level, [entries][GRID_FEATURES].
 */
enum { GRID_FEATURES = 2, GRID_MAX_LEVELS = 16, GRID_MAX_LOG2_SIZE = 24 };

/* Coordinates go up to here, the largest float below 1: times any number of cells it stays below
 * that number, so that its cell is the last. */
#define GRID_MOST 0x1.fffffep-1f

/* The multipliers of the paper's Eq. 4; that of x is 1. */
#define GRID_HASH_Y 2654435761u
#define GRID_HASH_Z 805459861u

struct grid_config {
    uint32_t n_levels;  /* 1 .. GRID_MAX_LEVELS */
    uint32_t log2_size; /* of a level's table, in entries: 1 .. GRID_MAX_LOG2_SIZE */
    uint32_t base;      /* cells along an edge at the first level, 1 or more */
    float growth;       /* from level to level, at least 1 */
};

struct grid {
    uint32_t n_levels;
    uint32_t n_cells[GRID_MAX_LEVELS];   /* along an edge */
    uint32_t n_entries[GRID_MAX_LEVELS]; /* of the table */
    size_t at[GRID_MAX_LEVELS + 1];      /* floats into the block; the last: its length */
};

void grid_init(struct grid *g, const struct grid_config *config);

/* A level's lattice has more vertices than its table entries. */
static inline bool grid_is_hashed(const struct grid *g, uint32_t level)
{
    const uint64_t edge = (uint64_t)g->n_cells[level] + 1;
    return edge * edge * edge > g->n_entries[level];
}

/* The eight vertices around a point: their entries, and their weights in the interpolation. */
struct grid_cell {
    uint32_t entry[8];
    float weight[8];
};

void grid_find(const struct grid *g, uint32_t level, const float p[3], struct grid_cell *c);

/* out [n_levels * GRID_FEATURES] at p, which is clamped to [0,GRID_MOST]^3. */
void grid_encode(const struct grid *g, const float *table, const float p[3], float *out);

/* Adds to `gradient` [n_entries[level]][GRID_FEATURES] of one level what `d` [GRID_FEATURES], the
 * gradient of grid_encode()'s output there, brings. */
void grid_encode_back(const struct grid *g, uint32_t level, const float p[3], const float *d,
                      float *gradient);

#endif
