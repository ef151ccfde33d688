/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_BUILDER_PRIVATE_H
#define SCENE_BUILDER_PRIVATE_H

#include "scene/builder.h"

/* What only builder*.c look into. */

struct name_entry {
    const char *name; /* NULL: a free slot */
    enum builder_kind kind;
    uint32_t index;
    bool is_made_up;
    struct place place;
};

struct builder_private {
    bool owns_scene; /* until builder_finish() */
    bool has_sensor;

    struct name_entry *names; /* hash table with open addressing; capacity a power of two */
    size_t n_names, names_capacity;
    size_t n_made_up;

    const char **bitmap_paths; /* [n_bitmaps], in the arena */

    size_t cap_textures, cap_bsdfs, cap_emitters, cap_shapes, cap_groups, cap_instances, cap_meshes,
        cap_bitmaps, cap_bitmap_paths;
};

#endif
