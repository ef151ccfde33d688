/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_PLY_PRIVATE_H
#define SCENE_PLY_PRIVATE_H

#include "scene/mesh.h"

/* What ply_header.c and ply.c share: a header that describes records, then the records. */

enum { MAX_ELEMENTS = 16, MAX_PROPERTIES = 64, MAX_WORD = 48, MAX_ATTRIBUTES = 8 };

enum scalar { I8, U8, I16, U16, I32, U32, F32, F64, N_SCALARS };

/* What a property means to us. */
enum role {
    ROLE_NONE,
    ROLE_X,
    ROLE_Y,
    ROLE_Z,
    ROLE_NX,
    ROLE_NY,
    ROLE_NZ,
    ROLE_U,
    ROLE_V,
    ROLE_FACE,
    ROLE_ATTRIBUTE
};

struct property {
    char name[MAX_WORD];
    uint32_t slot; /* ROLE_ATTRIBUTE: among the element's values */
    enum scalar type;
    enum scalar count_type; /* of a list */
    bool is_list;
    enum role role;
};

struct attribute {
    char name[MAX_WORD + 8]; /* "vertex_color" */
    uint32_t n_channels, slot;
};

struct ply_element {
    bool is_vertex, is_face;
    uint64_t count;
    struct property properties[MAX_PROPERTIES];
    uint32_t n_properties;
    struct attribute attributes[MAX_ATTRIBUTES];
    uint32_t n_attributes, n_slots; /* slots: channels of all attributes */
};

enum format { FORMAT_NONE, FORMAT_ASCII, FORMAT_LITTLE, FORMAT_BIG };

struct ply {
    const char *path;
    const char *text, *at, *end;
    struct error *err;
    enum format format;
    struct ply_element elements[MAX_ELEMENTS];
    uint32_t n_elements;

    struct mesh m;
    uint32_t *indices; /* of triangles, until their number is known */
    size_t n_indices, cap_indices;
    float *face_values; /* [n_indices / 3][n_slots], when faces have attributes */
    size_t cap_face_values;
    bool has_vertices;
};

lmn_status ply_fail(struct ply *p, const char *what);

/* The header, up to the first record. */
lmn_status ply_read_header(struct ply *p);

/* Which properties of an element are attributes of the mesh. */
void ply_find_attributes(struct ply_element *e);

#endif
