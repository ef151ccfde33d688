/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_AUTHORS_PRIVATE_H
#define SCENE_AUTHORS_PRIVATE_H

#include "scene/variable_set.h"

/*
 * What the files authors_*.c share.
 *
 * authors_variables.c  finds the var_ objects and their order
 * authors_declare.c    reads their ranges, makes variables
 * authors_objects.c    sensor, shapes, instances, emitters, shapegroups
 * authors_materials.c  materials
 */

/* What the children of a var_ object say: value = min + u * range. */
struct ranges {
    uint32_t n_parameters;
    double min[4], range[4];
    uint32_t n_bounds; /* components given; 0: no bounds */
    bool has_rotation;
    struct vec3 axis;
    double min_angle, range_angle;
};

/* The object that variables are declared for. */
struct declaring {
    struct builder *b;
    const struct builder_object *object;
    const char *kind;
    const char *group; /* name without "var_" */
    uint32_t first;    /* variables of this object start here */
    struct error *err;
};

lmn_status authors_read_ranges(const struct builder_object *o, struct ranges *out,
                               struct error *err);

/* Bounds of a colour that are not given are 0 to 1, as those of sphere-caustic's walls. */
void authors_default_to_unit(struct ranges *r);

/* "group.suffix", in the arena; NULL when memory is short, which variable_set_write() tells. */
const char *authors_path(struct builder *b, const char *group, const char *suffix);

/* A continuous variable over min + u * range, and the drive that follows it. suffix NULL: the
 * group's own name. A default that is not inside the range becomes its middle. */
lmn_status authors_add_range(struct declaring *d, const char *suffix, const char *unit, double min,
                             double range, double value, struct drive *drive);

/* Three channels, or what is left of them where a range is 0. */
lmn_status authors_add_channels(struct declaring *d, const struct ranges *r, struct vec3 declared,
                                struct drive drive[3]);

/* A discrete variable. The names of choices live in the arena. */
lmn_status authors_add_choice(struct declaring *d, const char *suffix, const char *const *choices,
                              uint32_t n, uint32_t *index);

struct drive authors_constant(double value);

/* A write of this object's variables; the caller fills the rest. */
struct write authors_new_write(const struct declaring *d, struct target target);

/* A member of an object's struct; `id` and `property` make its path. */
struct target authors_field(struct builder *b, const char *id, const char *property,
                            enum builder_kind owner, uint32_t index, size_t offset,
                            enum param_type type);

/* Gives a slot (SCENE_NONE: 1) a texture of its own, which a variable may scale without touching
 * other users of it. */
lmn_status authors_own_texture(struct builder *b, uint32_t *slot, struct error *err);

/* Each declares what one object says. */
lmn_status authors_declare_sensor(struct declaring *d);
lmn_status authors_declare_placement(struct declaring *d, enum builder_kind owner, uint32_t index,
                                     const struct transform *declared);
lmn_status authors_declare_emitter(struct declaring *d, uint32_t index);
lmn_status authors_declare_bsdf(struct declaring *d, uint32_t index);
lmn_status authors_declare_group(struct declaring *d, uint32_t index);

#endif
