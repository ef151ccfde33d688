/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_READER_MITSUBA_PRIVATE_H
#define SCENE_READER_MITSUBA_PRIVATE_H

#include "base/str.h"
#include "scene/builder.h"
#include "scene/xml.h"

/*
 * What the files reader_mitsuba*.c share.
 *
 * reader_mitsuba.c            walks the top level and loads objects once
 * reader_mitsuba_document.c   files, <default> and $name, <include>, <alias>, ids
 * reader_mitsuba_elements.c   the elements of the format
 * reader_mitsuba_props.c      properties of an object
 * reader_mitsuba_values.c     numbers, transforms
 * reader_mitsuba_colour.c     colours and spectra
 * reader_mitsuba_integrator.c  the integrator, as far as it matters
 * reader_mitsuba_bsdf.c, _texture.c, _emitter.c, _shape.c, _sensor.c   one function per plugin
 */

enum element {
    EL_NONE,
    /* properties */
    EL_FLOAT,
    EL_INTEGER,
    EL_BOOLEAN,
    EL_STRING,
    EL_POINT,
    EL_VECTOR,
    EL_VECTOR4F,
    EL_RGB,
    EL_SPECTRUM,
    EL_SRGB,
    EL_BLACKBODY,
    EL_TRANSFORM,
    EL_REF,
    /* objects */
    EL_SCENE,
    EL_BSDF,
    EL_TEXTURE,
    EL_EMITTER,
    EL_SHAPE,
    EL_SENSOR,
    EL_FILM,
    EL_RFILTER,
    EL_SAMPLER,
    EL_INTEGRATOR,
    EL_MEDIUM,
    EL_PHASE,
    EL_VOLUME,
    /* steps of a transform */
    EL_TRANSLATE,
    EL_ROTATE,
    EL_SCALE,
    EL_LOOKAT,
    EL_MATRIX,
    /* directives */
    EL_DEFAULT,
    EL_INCLUDE,
    EL_ALIAS,
    EL_PATH,
    /* refused by name */
    EL_ANIMATION,
    /* settings of other programs that change no image here */
    EL_IGNORED,
    EL_COUNT
};

enum load_state { LOAD_NOT_YET, LOAD_NOW, LOAD_DONE };

struct id_entry {
    const char *id; /* NULL: a free slot */
    struct xml_node *node;
};

struct reader {
    struct builder *b;
    struct error *err;
    const struct scene_load_options *options;
    struct arena arena; /* trees and everything that is gone after reading */
    struct xml_budget budget;

    struct define *defines; /* -D and <default> */
    size_t n_defines, cap_defines;

    const char **folders; /* where files are looked for besides the including file's */
    size_t n_folders, cap_folders;

    struct id_entry *ids; /* hash table with open addressing */
    size_t n_ids, cap_ids;

    /* The mesh file read last: one file can hold many shapes. */
    const char *mesh_path;
    char *mesh_text;
    size_t mesh_size;

    struct str ignored; /* "name (line n), ..." */
    uint32_t n_ignored;
    uint32_t n_includes;
    bool has_mesh_attributes; /* some texture asks for one */
    uint32_t depth;           /* of nested objects being loaded */
};

/* Reads the properties of one object. Every getter marks what it took; props_finish() complains
 * about the rest. A getter of something absent leaves the default in *out. */
enum { MAX_ASKED = 48 };

struct props {
    struct reader *r;
    struct xml_node *node;
    const char *type;
    const char *asked[MAX_ASKED]; /* names that getters asked for: the known properties */
    uint32_t n_asked;
};

struct props props_of(struct reader *r, struct xml_node *node);

/* fail_at() a node, with the reader's error. */
__attribute__((format(printf, 3, 4))) lmn_status
fail_node(struct reader *r, const struct xml_node *node, const char *format, ...);

/* fail_node() for a name that is not among `candidates`: adds `; did you mean "x"?`. */
lmn_status fail_unknown(struct reader *r, const struct xml_node *node, const char *what,
                        const char *name, const char *const *candidates, size_t n);

/* fail_node() for a plugin that is known but not supported. */
lmn_status fail_unsupported(struct reader *r, const struct xml_node *node);

bool props_has(struct props *p, const char *name);
struct xml_node *props_child(struct props *p, const char *name); /* NULL when absent */
bool props_is_string(struct props *p, const char *name);         /* given, and as a <string> */
lmn_status props_float(struct props *p, const char *name, float *out);
lmn_status props_positive(struct props *p, const char *name, float *out); /* > 0 */
lmn_status props_integer(struct props *p, const char *name, int32_t min, int32_t max, int32_t *out);
lmn_status props_boolean(struct props *p, const char *name, bool *out);
lmn_status props_string(struct props *p, const char *name, const char **out);
lmn_status props_point(struct props *p, const char *name, struct vec3 *out);
lmn_status props_transform(struct props *p, const char *name, struct transform *out);

/* A word out of a list; *out is its index. */
lmn_status props_choice(struct props *p, const char *name, const char *const *words, size_t n,
                        uint32_t *out);

/* A colour that cannot be a texture. */
lmn_status props_colour(struct props *p, const char *name, struct vec3 *out);

/* A colour or number written directly or a texture. Absent: a constant of *fallback, or SCENE_NONE
 * when fallback is NULL. */
lmn_status props_texture(struct props *p, const char *name, const struct vec3 *fallback,
                         uint32_t *out);

/* The same for light sources, where a <spectrum> is light of equal energy at all wavelengths.
 * Absent: 1. */
lmn_status props_radiance(struct props *p, const char *name, uint32_t *out);

/* The next child that is an object of that element (or a <ref> to one), resolved; NULL when there
 * is none left. Asks for no name. */
lmn_status props_object(struct props *p, enum element element, struct xml_node **out);

/* Takes properties that change no image here; they are told in the note. */
void props_ignore(struct props *p, const char *name);

/* Takes all that nobody asked for so, where a whole plugin stands in for another one. */
void props_ignore_rest(struct props *p);

/* `sunsky`, `sun` and `sky`. */
lmn_status read_sky(struct props *p, struct emitter *e);

/* The field of view in degrees: `fov` along `fov_axis`, or the focal length of a 35 mm camera
 * ("50mm"), which goes with the diagonal of its 36 x 24 mm film. */
lmn_status read_fov(struct props *p, float *fov, enum fov_axis *fov_axis);

/* All properties must have been asked for by now. Fills id, place and extras. */
lmn_status props_finish(struct props *p, struct builder_object *object);

/* The attribute `value`; "" when it is missing. */
const char *read_value(const struct xml_node *node);

/* Values of an attribute: numbers separated by blanks or commas. */
lmn_status read_numbers(struct reader *r, const struct xml_node *node, const char *attribute,
                        double *out, uint32_t max, uint32_t *n);
lmn_status read_number(struct reader *r, const struct xml_node *node, const char *attribute,
                       double *out);

/* x, y and z from attributes of that name (absent: *out as it was), or from `value`, where one
 * number stands for all three when `is_splat`. */
lmn_status read_xyz(struct reader *r, const struct xml_node *node, bool is_splat, struct vec3 *out);
lmn_status read_colour(struct reader *r, const struct xml_node *node, struct vec3 *out,
                       bool is_light);
lmn_status read_transform(struct reader *r, struct xml_node *node, struct transform *out);

/* Reads the scene file with all that it includes into one checked tree without directives. */
lmn_status read_document(struct reader *r, struct xml_node **root);

/* Loads an object (bsdf, texture, emitter, shape) once; its kind and index are then in the node. */
lmn_status load_object(struct reader *r, struct xml_node *node);

/* What load_object() calls; never called for a node twice. */
lmn_status load_bsdf(struct reader *r, struct xml_node *node, uint32_t *index);
lmn_status load_texture(struct reader *r, struct xml_node *node, uint32_t *index);
lmn_status load_emitter(struct reader *r, struct xml_node *node, uint32_t *index);
/* A shape of builder group `group` (SCENE_NONE: top level), a shapegroup, or an instance. */
lmn_status load_shape(struct reader *r, struct xml_node *node, uint32_t group, uint32_t *index);

lmn_status load_sensor(struct reader *r, struct xml_node *node);
lmn_status load_integrator(struct reader *r, struct xml_node *node);

/* The file that `name` (an attribute of `node`) means: beside the file that names it, else in the
 * scene's other folders. *out is in the reader's arena. */
lmn_status find_file(struct reader *r, const struct xml_node *node, const char *name,
                     const char **out);

struct xml_node *find_id(const struct reader *r, const char *id);

/* The node that a <ref> means, or the node itself. */
lmn_status resolve(struct reader *r, struct xml_node *node, struct xml_node **out);

void note_ignored(struct reader *r, const struct xml_node *node, const char *what);

const char *element_name(enum element element);

/* Finds out which element a node is and checks its attributes. */
lmn_status check_element(struct reader *r, struct xml_node *node);

/* A copy in the scene's arena: for what outlives reading. */
lmn_status keep_string(struct reader *r, const char *text, const char **out);

#endif
