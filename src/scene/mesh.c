/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/mesh.h"

#include <string.h>

#include "base/hash.h"

/* Embree reads whole vectors, up to 16 bytes past the last element. */
enum { PADDING = 16 };

static float *alloc_floats(struct arena *arena, size_t n, size_t width)
{
    return arena_new(arena, n * width * sizeof(float) + PADDING, 1); /* n is bounded: no overflow */
}

lmn_status mesh_alloc(struct arena *arena, size_t n_vertices, size_t n_triangles, bool has_normals,
                      bool has_uvs, struct mesh *out, struct error *err)
{
    struct mesh m = {.n_vertices = (uint32_t)n_vertices, .n_triangles = (uint32_t)n_triangles};
    if (n_vertices > MESH_MAX_VERTICES || n_triangles > MESH_MAX_TRIANGLES)
        return fail_memory(err, "a mesh of that size");
    m.positions = alloc_floats(arena, n_vertices, 3);
    m.indices = arena_new(arena, n_triangles * 3 * sizeof(uint32_t) + PADDING, 1);
    if (has_normals) m.normals = alloc_floats(arena, n_vertices, 3);
    if (has_uvs) m.uvs = alloc_floats(arena, n_vertices, 2);
    if (!m.positions || !m.indices || (has_normals && !m.normals) || (has_uvs && !m.uvs))
        return fail_memory(err, "a mesh");
    *out = m;
    return LMN_OK;
}

uint64_t mesh_attribute_key(const char *name)
{
    return hash_bytes(HASH_START, name, strlen(name));
}

struct mesh_attribute *mesh_add_attribute(struct arena *arena, struct mesh *m, const char *name,
                                          uint32_t n_channels, bool is_of_faces)
{
    size_t n = is_of_faces ? m->n_triangles : m->n_vertices;
    /* Few: a new list each time. */
    struct mesh_attribute *list = arena_new(arena, (size_t)m->n_attributes + 1, sizeof *list);
    struct mesh_attribute a = {.name = arena_strdup(arena, name),
                               .key = mesh_attribute_key(name),
                               .values = alloc_floats(arena, n, n_channels),
                               .n_channels = n_channels,
                               .is_of_faces = is_of_faces};
    if (!list || !a.name || !a.values) return NULL;
    if (m->n_attributes) memcpy(list, m->attributes, m->n_attributes * sizeof *list);
    list[m->n_attributes] = a;
    m->attributes = list;
    return &list[m->n_attributes++];
}

static struct vec3 load3(const float *a, size_t i)
{
    return vec3(a[3 * i], a[3 * i + 1], a[3 * i + 2]);
}

static void store3(float *a, size_t i, struct vec3 v)
{
    a[3 * i] = v.x;
    a[3 * i + 1] = v.y;
    a[3 * i + 2] = v.z;
}

static bool is_identity(const struct transform *t)
{
    struct transform one = transform_identity();
    return memcmp(t->m, one.m, sizeof one.m) == 0;
}

/* The angle between two unit vectors, exact also for small ones. */
static float angle_between(struct vec3 a, struct vec3 b)
{
    if (vec3_dot(a, b) < 0.0f)
        return 3.14159265f - 2.0f * asinf(fminf(0.5f * vec3_length(vec3_add(a, b)), 1.0f));
    return 2.0f * asinf(fminf(0.5f * vec3_length(vec3_sub(a, b)), 1.0f));
}

static void add3(float *a, size_t i, struct vec3 v)
{
    store3(a, i, vec3_add(load3(a, i), v));
}

static void make_normals(struct mesh *m)
{
    for (size_t t = 0; t < m->n_triangles; t++) {
        const uint32_t *f = m->indices + 3 * t;
        struct vec3 p[3] = {load3(m->positions, f[0]), load3(m->positions, f[1]),
                            load3(m->positions, f[2])};
        struct vec3 n = vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));
        float length = vec3_length(n);
        if (!(length > 0.0f) || !isfinite(length)) continue;
        n = vec3_scale(n, 1.0f / length);
        for (int i = 0; i < 3; i++) {
            struct vec3 a = vec3_sub(p[(i + 1) % 3], p[i]), b = vec3_sub(p[(i + 2) % 3], p[i]);
            float w = angle_between(vec3_normalize(a), vec3_normalize(b));
            add3(m->normals, f[i], vec3_scale(n, w));
        }
    }
    for (size_t i = 0; i < m->n_vertices; i++) {
        struct vec3 n = load3(m->normals, i);
        float length = vec3_length(n);
        /* Vertices of degenerate triangles alone: any direction will do; Mitsuba takes +x. */
        store3(m->normals, i, length > 0.0f ? vec3_scale(n, 1.0f / length) : vec3(1, 0, 0));
    }
}

static void move_normals(struct mesh *m, const struct transform *t)
{
    for (size_t i = 0; i < m->n_vertices; i++) {
        struct vec3 n = transform_normal(t, load3(m->normals, i));
        float length = vec3_length(n);
        store3(m->normals, i,
               length > 0.0f && isfinite(length) ? vec3_scale(n, 1.0f / length) : vec3(1, 0, 0));
    }
}

/* Embree gives up on coordinates beyond that. */
static bool is_in_range(const float *a, size_t n)
{
    bool ok = true; /* one flag instead of a branch: the loop vectorises */
    for (size_t i = 0; i < n; i++) ok &= fabsf(a[i]) < 1e18f;
    return ok;
}

lmn_status mesh_finish(const char *path, const struct mesh_options *options, struct arena *arena,
                       struct mesh *m, struct error *err)
{
    if (!is_identity(&options->to_world)) {
        for (size_t i = 0; i < m->n_vertices; i++)
            store3(m->positions, i, transform_point(&options->to_world, load3(m->positions, i)));
    }
    if (!is_in_range(m->positions, 3 * (size_t)m->n_vertices) ||
        (m->uvs && !is_in_range(m->uvs, 2 * (size_t)m->n_vertices)))
        return fail(err, LMN_ERR_PARSE, "%s: a coordinate is not finite or above 1e18", path);

    if (options->has_flipped_v && m->uvs) {
        for (size_t i = 0; i < m->n_vertices; i++) m->uvs[2 * i + 1] = 1.0f - m->uvs[2 * i + 1];
    }
    if (options->has_face_normals) {
        m->normals = NULL;
    } else if (m->normals) {
        move_normals(m, &options->to_world);
    } else {
        m->normals = alloc_floats(arena, m->n_vertices, 3);
        if (!m->normals) return fail_memory(err, path);
        make_normals(m);
    }
    return LMN_OK;
}

/* ---- Primitives --------------------------------------------------------------------------- */

lmn_status mesh_rectangle(const struct transform *to_world, struct arena *arena, struct mesh *out,
                          struct error *err)
{
    static const float corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    /* Under a mirror the shading normal stays that of +z, while the winding turns over. */
    bool is_mirrored = transform_flips(to_world);
    struct mesh_options options = {.to_world = *to_world, .has_face_normals = !is_mirrored};
    lmn_status status = mesh_alloc(arena, 4, 2, is_mirrored, true, out, err);
    if (status != LMN_OK) return status;
    for (size_t i = 0; i < 4; i++) {
        store3(out->positions, i, vec3(corners[i][0], corners[i][1], 0.0f));
        if (is_mirrored) store3(out->normals, i, vec3(0, 0, 1));
        out->uvs[2 * i] = 0.5f * corners[i][0] + 0.5f;
        out->uvs[2 * i + 1] = 0.5f * corners[i][1] + 0.5f;
    }
    memcpy(out->indices, indices, sizeof indices);
    return mesh_finish("rectangle", &options, arena, out, err);
}

lmn_status mesh_cube(const struct transform *to_world, struct arena *arena, struct mesh *out,
                     struct error *err)
{
    static const signed char normals[6][3] = {{0, -1, 0}, {0, 1, 0},  {1, 0, 0},
                                              {0, 0, 1},  {-1, 0, 0}, {0, 0, -1}};
    static const signed char corners[24][3] = {
        {1, -1, -1}, {1, -1, 1},   {-1, -1, 1}, {-1, -1, -1}, {1, 1, -1},   {-1, 1, -1},
        {-1, 1, 1},  {1, 1, 1},    {1, -1, -1}, {1, 1, -1},   {1, 1, 1},    {1, -1, 1},
        {1, -1, 1},  {1, 1, 1},    {-1, 1, 1},  {-1, -1, 1},  {-1, -1, 1},  {-1, 1, 1},
        {-1, 1, -1}, {-1, -1, -1}, {1, 1, -1},  {1, -1, -1},  {-1, -1, -1}, {-1, 1, -1}};
    static const float uvs[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    static const uint32_t indices[6] = {0, 1, 2, 3, 0, 2};
    struct mesh_options options = {.to_world = *to_world};
    lmn_status status = mesh_alloc(arena, 24, 12, true, true, out, err);
    if (status != LMN_OK) return status;
    for (size_t i = 0; i < 24; i++) {
        const signed char *p = corners[i], *n = normals[i / 4];
        store3(out->positions, i, vec3(p[0], p[1], p[2]));
        store3(out->normals, i, vec3(n[0], n[1], n[2]));
        memcpy(out->uvs + 2 * i, uvs[i % 4], sizeof uvs[0]);
    }
    for (uint32_t i = 0; i < 36; i++) out->indices[i] = indices[i % 6] + 4 * (i / 6);
    return mesh_finish("cube", &options, arena, out, err);
}
