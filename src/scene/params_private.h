/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_PARAMS_PRIVATE_H
#define SCENE_PARAMS_PRIVATE_H

#include "scene/params.h"

/* Walking the builder's objects, which makes their targets: for params*.c. */
struct walk {
    const struct builder *b;
    struct target_list *list;
    bool *is_bsdf_named, *is_emitter_named; /* has a path of its own already */
    bool failed;
};

/* A path in the builder's arena; NULL (and w->failed) when memory is short. */
__attribute__((format(printf, 2, 3))) const char *walk_path(struct walk *w, const char *format,
                                                            ...);

/* Adds prefix.name: a number, colour, ... at `offset` of an object. */
void walk_field(struct walk *w, const char *prefix, const char *name, enum builder_kind owner,
                uint32_t index, size_t offset, enum param_type type, double low, double high,
                bool is_alias);

/* Adds a property that holds a texture: the choice of one, and what is inside. */
void walk_slot(struct walk *w, const char *prefix, const char *name, enum builder_kind owner,
               uint32_t index, size_t offset, uint32_t texture, enum param_type type, double low,
               double high, bool is_alias);

/* Adds what is inside of a material. is_short: the wrappers on the way here are left out of
 * `prefix`. */
void walk_bsdf(struct walk *w, const char *prefix, uint32_t index, bool is_alias, bool is_short,
               int depth);

/* Its plugin's name. */
const char *bsdf_kind_name(enum bsdf_kind kind);

#endif
