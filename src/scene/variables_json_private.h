/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_VARIABLES_JSON_PRIVATE_H
#define SCENE_VARIABLES_JSON_PRIVATE_H

#include "scene/json_reader.h"
#include "scene/variable_set.h"

/* What the files of the JSON reader of variables share. */

/* One entry of "variables" while it is read. */
struct entry {
    struct json_reader *r; /* its path is at the entry */
    struct builder *b;
    const json_t *json;
    const char *kind, *name, *unit, *description; /* in the builder's arena */
    struct place place;
    uint32_t first;                /* its variables start here */
    const struct target **targets; /* [n_targets], set by entry_read_targets() */
    size_t n_targets;
};

/* The value under a key, or NULL. */
const json_t *entry_get(const struct entry *e, const char *key);

lmn_status entry_no_memory(const struct entry *e);

/* Adds a variable with what the entry says of it. suffix NULL: it has the entry's own name. */
lmn_status entry_add_variable(struct entry *e, const char *suffix, struct variable v,
                              uint32_t *index);

/* A continuous variable, and the drive that follows it from min to max. */
lmn_status entry_add_range(struct entry *e, const char *suffix, double min, double max,
                           double value, struct drive *drive);

/* A variable for each component of a box that has an extent. */
lmn_status entry_add_box(struct entry *e, const char *const suffixes[3], const double min[3],
                         const double max[3], const double value[3], struct drive drive[3]);

/* Refuses an entry that made no variable; `key` is what to blame. */
lmn_status entry_check_varies(struct entry *e, const char *key);

/* The default of a number: what the file says, else what the scene has (`now`) if that is within
 * the range, else the middle. */
lmn_status entry_read_default(struct entry *e, const double range[2], double now, double *out);

/* The same for three numbers under `json` (NULL: not given), which is `key` at the present path. */
lmn_status entry_read_default3(struct entry *e, const json_t *json, const char *key,
                               const double min[3], const double max[3], const double now[3],
                               double out[3]);

/* The target that `text`, or `text` and one of `suffixes`, names; of type `wanted`. */
lmn_status entry_find_target(struct entry *e, const char *text, enum param_type wanted,
                             const char *const *suffixes, size_t n_suffixes,
                             const struct target **out);

/* "targets": a string or a list of strings, at least one. */
lmn_status entry_read_targets(struct entry *e, enum param_type wanted, const char *const *suffixes,
                              size_t n_suffixes);

/* Adds a write to every target. The template has all but the target and the variables. */
lmn_status entry_write_targets(struct entry *e, struct write w);

/* "; did you mean" in three pieces for a format "%s%.200s%s"; empty ones when closest is NULL. */
#define DID_YOU_MEAN(closest) \
    (closest) ? "; did you mean \"" : "", (closest) ? (closest) : "", (closest) ? "\"?" : ""

/* The kinds; each reads its own keys and declares variables and writes. */
lmn_status entry_read_camera(struct entry *e);
lmn_status entry_read_translate(struct entry *e);
lmn_status entry_read_rotate(struct entry *e);
lmn_status entry_read_scale(struct entry *e);
lmn_status entry_read_color(struct entry *e);
lmn_status entry_read_float(struct entry *e);
lmn_status entry_read_choice(struct entry *e);
lmn_status entry_read_visible(struct entry *e);
lmn_status entry_read_envmap(struct entry *e);
lmn_status entry_read_intensity(struct entry *e);

#endif
