/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_JSON_READER_H
#define SCENE_JSON_READER_H

#include <jansson.h>

#include "math/vec.h"
#include "scene/builder.h"

/*
 * Reads a JSON document value by value and knows where it is, so that messages say both the path
 * and the place: "scene.variables.json:7:14: variables[2].range: ...". jansson parses; it keeps no
 * positions, so the text is scanned again for the one that is in error.
 *
 * The path is a stack: json_reader_enter() before what is inside, json_reader_leave() after. Who
 * fails leaves it as it is.
 */
struct json_step {
    const char *key; /* NULL: an index */
    size_t index;
};

enum { JSON_READER_DEPTH = 16 };

struct json_reader {
    const char *file;
    char *text; /* owned */
    json_t *root;
    struct json_step path[JSON_READER_DEPTH];
    size_t depth;
    struct error *err;
};

/* Reads and parses a file; duplicate keys are errors. */
lmn_status json_reader_init(struct json_reader *r, const char *file, struct error *err);
void json_reader_release(struct json_reader *r);

/* key NULL: the element `index`. */
void json_reader_enter(struct json_reader *r, const char *key, size_t index);
void json_reader_leave(struct json_reader *r);

/* Where the value at the present path stands; of the innermost that exists. */
struct place json_reader_place(const struct json_reader *r);

/* Fails with LMN_ERR_PARSE at the present path. */
__attribute__((format(printf, 2, 3))) lmn_status json_reader_fail(const struct json_reader *r,
                                                                  const char *format, ...);

/* Each wants `value` (which may be NULL: missing) to be of that type, and finite. */
lmn_status json_read_number(struct json_reader *r, const json_t *value, double *out);
lmn_status json_read_string(struct json_reader *r, const json_t *value, const char **out);
lmn_status json_read_numbers(struct json_reader *r, const json_t *value, size_t n, double *out);

/* [min, max] with min < max. */
lmn_status json_read_range(struct json_reader *r, const json_t *value, double out[2]);

/* {"min": [x,y,z], "max": [x,y,z]} with min <= max. */
lmn_status json_read_box(struct json_reader *r, const json_t *value, double min[3], double max[3]);

/* Refuses keys that are not in the list. */
lmn_status json_check_keys(struct json_reader *r, const json_t *object, const char *const *keys,
                           size_t n);

#endif
