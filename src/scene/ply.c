/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "scene/ply_private.h"
#include "scene/text_number.h"

/* Stanford PLY: the records. */

static const uint8_t scalar_size[N_SCALARS] = {1, 1, 2, 2, 4, 4, 4, 8};

/* Colours as bytes mean 0 to 1. */
static float attribute_value(const struct property *property, double v)
{
    return (float)(property->type == U8 ? v / 255.0 : v);
}

/* Gives the faces' values, which were kept by triangle, to the mesh. */
static lmn_status store_face_attributes(struct ply *p, const struct ply_element *e,
                                        struct arena *arena)
{
    for (uint32_t i = 0; i < e->n_attributes; i++) {
        const struct attribute *from = &e->attributes[i];
        struct mesh_attribute *a = mesh_add_attribute(arena, &p->m, from->name, from->n_channels,
                                                      true);
        if (!a) return fail_memory(p->err, p->path);
        for (size_t t = 0; t < p->m.n_triangles; t++)
            memcpy(a->values + t * from->n_channels, p->face_values + t * e->n_slots + from->slot,
                   from->n_channels * sizeof *a->values);
    }
    return LMN_OK;
}

/* ---- Records ------------------------------------------------------------------------------ */

/* Reads one value; every integer type fits a double. */
static bool read_value(struct ply *p, enum scalar type, double *out)
{
    if (p->format == FORMAT_ASCII) {
        float f;
        int i;
        while (p->at < p->end && (unsigned char)*p->at <= ' ') p->at++;
        if (type < F32) {
            if (!text_to_int(&p->at, &i)) return false;
            *out = i;
        } else {
            if (!text_to_float(&p->at, &f)) return false;
            *out = (double)f;
        }
        return p->at == p->end || (unsigned char)*p->at <= ' ';
    }
    size_t size = scalar_size[type];
    if ((size_t)(p->end - p->at) < size) return false;
    unsigned char raw[8];
    for (size_t i = 0; i < size; i++)
        raw[i] = (unsigned char)p->at[p->format == FORMAT_BIG ? size - 1 - i : i];
    p->at += size;
    uint64_t bits = 0;
    for (size_t i = 0; i < size; i++) bits |= (uint64_t)raw[i] << (8 * i);
    uint32_t low = (uint32_t)bits;
    float f;
    switch (type) {
    case I8:
        *out = (int8_t)low;
        break;
    case I16:
        *out = (int16_t)low;
        break;
    case I32:
        *out = (int32_t)low;
        break;
    case F32:
        memcpy(&f, &low, 4);
        *out = (double)f;
        break;
    case F64:
        memcpy(out, &bits, 8);
        break;
    default:
        *out = low;
    }
    return true;
}

static lmn_status add_triangle(struct ply *p, uint32_t a, uint32_t b, uint32_t c)
{
    void *block = p->indices;
    bool ok = mem_grow(&block, &p->cap_indices, p->n_indices + 3, sizeof *p->indices);
    p->indices = block;
    if (!ok) return fail_memory(p->err, p->path);
    p->indices[p->n_indices++] = a;
    p->indices[p->n_indices++] = b;
    p->indices[p->n_indices++] = c;
    return LMN_OK;
}

/* A list: of a face, whose corners become a fan, or of anything else, which is skipped. */
static lmn_status read_list(struct ply *p, const struct property *property)
{
    lmn_status status = LMN_OK;
    double n, v;
    uint32_t corners[2] = {0, 0}; /* the first and the last one */
    if (!read_value(p, property->count_type, &n)) return ply_fail(p, "the file is cut off");
    if (n < 0 || (property->role == ROLE_FACE && n < 3))
        return ply_fail(p, "a face needs three corners or more");
    if (n > (double)(p->end - p->at)) return ply_fail(p, "a list is longer than the file");
    for (double i = 0; i < n; i++) {
        if (!read_value(p, property->type, &v))
            return ply_fail(p, "the file is cut off, or what should be a number is none");
        if (property->role != ROLE_FACE) continue;
        if (v < 0 || v >= p->m.n_vertices) return ply_fail(p, "a vertex index is out of range");
        if (i >= 2) TRY(add_triangle(p, corners[0], corners[1], (uint32_t)v));
        if (i == 0) corners[0] = (uint32_t)v;
        corners[1] = (uint32_t)v;
    }
done:
    return status;
}

/* Where a vertex property goes; NULL: nowhere. */
static float *target_of(struct ply *p, enum role role, size_t i)
{
    switch (role) {
    case ROLE_X:
    case ROLE_Y:
    case ROLE_Z:
        return p->m.positions + 3 * i + (role - ROLE_X);
    case ROLE_NX:
    case ROLE_NY:
    case ROLE_NZ:
        return p->m.normals ? p->m.normals + 3 * i + (role - ROLE_NX) : NULL;
    case ROLE_U:
    case ROLE_V:
        return p->m.uvs ? p->m.uvs + 2 * i + (role - ROLE_U) : NULL;
    default:
        return NULL;
    }
}

static bool has_roles(const struct ply_element *e, enum role first, enum role last)
{
    for (enum role r = first; r <= last; r++) {
        bool found = false;
        for (uint32_t i = 0; i < e->n_properties; i++) found |= e->properties[i].role == r;
        if (!found) return false;
    }
    return true;
}

/* Bytes that a record takes at least: bounds counts by the file's size before memory is taken. */
static uint64_t least_size(const struct ply *p, const struct ply_element *e)
{
    uint64_t size = 0;
    for (uint32_t i = 0; i < e->n_properties; i++) {
        const struct property *property = &e->properties[i];
        enum scalar type = property->is_list ? property->count_type : property->type;
        size += p->format == FORMAT_ASCII ? 2 : scalar_size[type];
    }
    return size;
}

/* Room for what a vertex record says. */
static lmn_status make_vertices(struct ply *p, const struct ply_element *e,
                                const struct mesh_options *options, struct arena *arena)
{
    if (p->has_vertices) return ply_fail(p, "vertices are given twice");
    if (!has_roles(e, ROLE_X, ROLE_Z)) return ply_fail(p, "vertices have no x, y, z");
    bool has_normals = has_roles(e, ROLE_NX, ROLE_NZ) && !options->has_face_normals;
    bool has_uvs = has_roles(e, ROLE_U, ROLE_V);
    lmn_status status = mesh_alloc(arena, e->count, 0, has_normals, has_uvs, &p->m, p->err);
    for (uint32_t i = 0; i < e->n_attributes && status == LMN_OK; i++) {
        const struct attribute *a = &e->attributes[i];
        if (!mesh_add_attribute(arena, &p->m, a->name, a->n_channels, false))
            status = fail_memory(p->err, p->path);
    }
    p->has_vertices = true;
    return status;
}

/* Where the value of a slot goes for vertex i. */
static float *vertex_slot(struct ply *p, const struct ply_element *e, uint32_t slot, size_t i)
{
    uint32_t k = e->n_attributes - 1;
    while (slot < e->attributes[k].slot) k--;
    const struct mesh_attribute *a = &p->m.attributes[k];
    return a->values + i * a->n_channels + (slot - e->attributes[k].slot);
}

/* The same values for every triangle that the face became, from `first` on. */
static lmn_status push_face_values(struct ply *p, const struct ply_element *e, size_t first,
                                   const float *values)
{
    size_t n = p->n_indices / 3;
    void *block = p->face_values;
    bool ok = mem_grow(&block, &p->cap_face_values, n * e->n_slots, sizeof *p->face_values);
    p->face_values = block;
    if (!ok) return fail_memory(p->err, p->path);
    for (size_t t = first; t < n; t++)
        memcpy(p->face_values + t * e->n_slots, values, e->n_slots * sizeof *values);
    return LMN_OK;
}

static lmn_status read_records(struct ply *p, const struct ply_element *e,
                               const struct mesh_options *options, struct arena *arena)
{
    lmn_status status = LMN_OK;
    float values[3 * MAX_ATTRIBUTES];
    if (e->n_properties == 0) return LMN_OK;
    /* + 1: in ascii the last number has no blank behind it. */
    if (e->count > ((uint64_t)(p->end - p->at) + 1) / least_size(p, e))
        return ply_fail(p, "the file is cut off: it holds fewer records than its header says");
    if (e->is_vertex) TRY(make_vertices(p, e, options, arena));
    for (uint64_t i = 0; i < e->count; i++) {
        size_t first = p->n_indices / 3;
        for (uint32_t k = 0; k < e->n_properties; k++) {
            const struct property *property = &e->properties[k];
            double v;
            if (property->is_list) {
                TRY(read_list(p, property));
                continue;
            }
            if (!read_value(p, property->type, &v))
                return ply_fail(p, "the file is cut off, or what should be a number is none");
            if (property->role == ROLE_ATTRIBUTE) {
                float x = attribute_value(property, v);
                if (!isfinite(x)) return ply_fail(p, "an attribute is not finite");
                *(e->is_vertex ? vertex_slot(p, e, property->slot, i)
                               : values + property->slot) = x;
                continue;
            }
            float *target = target_of(p, property->role, i);
            if (target) *target = (float)v;
        }
        if (e->is_face && e->n_slots) TRY(push_face_values(p, e, first, values));
    }
done:
    return status;
}

lmn_status ply_load(const char *path, const char *text, size_t size,
                    const struct mesh_options *options, struct arena *arena, struct mesh *out,
                    struct error *err)
{
    lmn_status status = LMN_OK;
    struct mesh m;
    struct ply p = {.path = path, .text = text, .at = text, .end = text + size, .err = err};
    const struct ply_element *faces = NULL;
    TRY(ply_read_header(&p));
    for (uint32_t i = 0; i < p.n_elements; i++) {
        struct ply_element *e = &p.elements[i];
        if (e->is_vertex || e->is_face) ply_find_attributes(e);
        if (e->is_face && e->n_slots) {
            /* Several lists of faces could not be told apart by triangle. */
            if (faces || p.n_indices) {
                status = ply_fail(&p, "faces with attributes are given twice");
                goto done;
            }
            faces = e;
        } else if (e->is_face && faces) {
            status = ply_fail(&p, "faces with attributes are given twice");
            goto done;
        }
        TRY(read_records(&p, e, options, arena));
    }
    if (p.n_indices == 0) {
        status = fail(err, LMN_ERR_PARSE, "%s: the mesh has no faces", path);
        goto done;
    }
    if (p.n_indices / 3 > MESH_MAX_TRIANGLES) {
        status = fail(err, LMN_ERR_PARSE, "%s: more than %d triangles", path, MESH_MAX_TRIANGLES);
        goto done;
    }
    TRY(mesh_alloc(arena, 0, p.n_indices / 3, false, false, &m, err));
    memcpy(m.indices, p.indices, p.n_indices * sizeof *p.indices);
    p.m.indices = m.indices;
    p.m.n_triangles = m.n_triangles;
    if (faces) TRY(store_face_attributes(&p, faces, arena));
    TRY(mesh_finish(path, options, arena, &p.m, err));
    *out = p.m;
done:
    mem_free(p.indices);
    mem_free(p.face_values);
    return status;
}
