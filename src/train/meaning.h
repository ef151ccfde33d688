/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_MEANING_H
#define TRAIN_MEANING_H

#include <stdbool.h>

#include "base/json.h"
#include "base/mem.h"
#include "math/vec.h"
#include "nn/field.h"

/*
 * What the inputs and outputs of a compact network stand for, in words: so that a network which
 * learnt one scene can be the start for another, whose inputs are others in part. The parts are in
 * the order of the first layer's columns (nn/field.h): grids, features, variables; then come the
 * outputs.
 */
enum meaning_kind {
    MEANING_GRID, /* positions in the frame of what moves, by its name; the first: "the scene" */
    MEANING_FEATURES, /* some that belong together: "the surface", "light from lamp" */
    MEANING_VARIABLE, /* by its name */
    MEANING_LIGHT     /* outputs: a group of lights (powers.h), by its first one */
};

struct meaning_part {
    enum meaning_kind kind;
    const char *name;
    uint32_t n; /* numbers: 3 of a position, those of the features, 1, 3 of a light */
};

struct meaning {
    struct arena arena; /* owns the names */
    struct meaning_part *parts;
    size_t n_parts, capacity;
    struct vec3 box_min, box_max; /* the scene's, which positions in it are relative to */
    bool failed;                  /* memory was short: what was added is not whole */
};

/* A part more, after the others. */
__attribute__((format(printf, 4, 5))) void meaning_add(struct meaning *m, enum meaning_kind kind,
                                                       uint32_t n, const char *format, ...);
void meaning_release(struct meaning *m);

/* "grid of ball", "features of the surface", "variable alpha", "light of lamp". */
void meaning_tell(const struct meaning_part *part, struct str *to);

/* The part of the same kind, name and size as a part of another, or NULL. The first of all, the
 * grid of the scene, needs the same box. Where both have one group of lights, that is the same. */
const struct meaning_part *meaning_find(const struct meaning *m, const struct meaning *other,
                                        const struct meaning_part *part);

/* Grids, features, variables and lights; the rest is 0. */
struct field_config meaning_field(const struct meaning *m);

/* The JSON object in model files: {"grids": ["the scene", "ball"], "features": [["the surface",
 * 14],
 * ["ball", 4]], "variables": ["alpha"], "lights": ["lamp"], "box": [[0, 0, 0], [1, 1, 1]]}. Errors
 * of reading begin with `where`. */
void meaning_write(const struct meaning *m, struct json *j);
lmn_status meaning_read(struct meaning *m, const char *text, const char *where, struct error *err);

#endif
