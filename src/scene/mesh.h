/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_MESH_H
#define SCENE_MESH_H

#include "scene/scene.h"

/* Making triangle meshes. All arrays live in the given arena, padded for Embree. */

enum { MESH_MAX_VERTICES = 1 << 28, MESH_MAX_TRIANGLES = 1 << 28 };

/* What the file formats of meshes have in common. */
struct mesh_options {
    struct transform to_world;
    bool has_face_normals; /* drop vertex normals */
    bool has_flipped_v;    /* v becomes 1 - v */
    uint32_t shape_index;  /* serialized: which one of the file */
};

lmn_status mesh_alloc(struct arena *arena, size_t n_vertices, size_t n_triangles, bool has_normals,
                      bool has_uvs, struct mesh *out, struct error *err);

/*
 * Last step of a loader, given a mesh as the file has it: moves it by to_world; drops or makes
 * normals as Mitsuba 3 does (a mesh without normals gets them unless face normals are asked for:
 * averages of the adjacent faces' normals, weighted by their angles; Thuermer and Wuethrich 1998).
 * Coordinates that are not finite are an error that names `path`.
 */
lmn_status mesh_finish(const char *path, const struct mesh_options *options, struct arena *arena,
                       struct mesh *m, struct error *err);

/* The square [-1,1]^2 in z = 0 with normal +z; uv (0,0) at (-1,-1). */
lmn_status mesh_rectangle(const struct transform *to_world, struct arena *arena, struct mesh *out,
                          struct error *err);

/* The cube [-1,1]^3, 24 vertices, each side with uv as Mitsuba 3. */
lmn_status mesh_cube(const struct transform *to_world, struct arena *arena, struct mesh *out,
                     struct error *err);

/* Wavefront OBJ: v, vt, vn and f lines (polygons become fans, negative indices count from the end);
 * other lines are skipped. */
lmn_status obj_load(const char *path, const char *text, size_t size,
                    const struct mesh_options *options, struct arena *arena, struct mesh *out,
                    struct error *err);

/* Stanford PLY: ascii and binary of either byte order; vertex x y z, nx ny nz, u v | s t; faces of
 * three or four corners; other elements and properties are skipped. */
lmn_status ply_load(const char *path, const char *text, size_t size,
                    const struct mesh_options *options, struct arena *arena, struct mesh *out,
                    struct error *err);

/* What textures know an attribute by. */
uint64_t mesh_attribute_key(const char *name);

/* Adds room for an attribute, zeroed; NULL when memory is short. `name` is copied. */
struct mesh_attribute *mesh_add_attribute(struct arena *arena, struct mesh *m, const char *name,
                                          uint32_t n_channels, bool is_of_faces);

/* Mitsuba's own format, versions 3 and 4: meshes compressed one by one, and where they begin at the
 * end of the file. Vertex colours become the attribute "vertex_color". */
lmn_status serialized_load(const char *path, const char *text, size_t size,
                           const struct mesh_options *options, struct arena *arena,
                           struct mesh *out, struct error *err);

#endif
