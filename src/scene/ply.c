/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "scene/mesh.h"
#include "scene/text_number.h"

/* Stanford PLY: a header that describes records, then the records. */

enum { MAX_ELEMENTS = 16, MAX_PROPERTIES = 64, MAX_WORD = 48 };

enum scalar { I8, U8, I16, U16, I32, U32, F32, F64, N_SCALARS };
static const uint8_t scalar_size[N_SCALARS] = {1, 1, 2, 2, 4, 4, 4, 8};

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
    ROLE_FACE
};

struct property {
    enum scalar type;
    enum scalar count_type; /* of a list */
    bool is_list;
    enum role role;
};

struct ply_element {
    bool is_vertex, is_face;
    uint64_t count;
    struct property properties[MAX_PROPERTIES];
    uint32_t n_properties;
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
    bool has_vertices;
};

static lmn_status fail_ply(struct ply *p, const char *what)
{
    unsigned line = 1;
    const char *start = p->text;
    for (const char *c = p->text; c < p->at; c++) {
        if (*c != '\n') continue;
        line++;
        start = c + 1;
    }
    if (p->format == FORMAT_LITTLE || p->format == FORMAT_BIG)
        return fail(p->err, LMN_ERR_PARSE, "%s: byte %zu: %s", p->path, (size_t)(p->at - p->text),
                    what);
    return fail(p->err, LMN_ERR_PARSE, "%s:%u:%u: %s", p->path, line, (unsigned)(p->at - start) + 1,
                what);
}

/* ---- Header ------------------------------------------------------------------------------- */

static void skip_blanks(struct ply *p)
{
    while (*p->at == ' ' || *p->at == '\t' || *p->at == '\r') p->at++;
}

/* The next word of the line, "" at its end; words that are too long are cut. */
static void read_word(struct ply *p, char *word)
{
    size_t n = 0;
    skip_blanks(p);
    while (p->at < p->end && (unsigned char)*p->at > ' ') {
        if (n < MAX_WORD - 1) word[n++] = *p->at;
        p->at++;
    }
    word[n] = '\0';
}

static bool read_scalar_type(struct ply *p, enum scalar *out)
{
    static const char *const names[][2] = {
        {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
        {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
    char word[MAX_WORD];
    read_word(p, word);
    for (int i = 0; i < N_SCALARS; i++) {
        if (strcmp(word, names[i][0]) != 0 && strcmp(word, names[i][1]) != 0) continue;
        *out = (enum scalar)i;
        return true;
    }
    return false;
}

static enum role find_role(const struct ply_element *e, const char *name, bool is_list)
{
    static const struct {
        const char *name;
        enum role role;
    } roles[] = {{"x", ROLE_X},         {"y", ROLE_Y},         {"z", ROLE_Z},
                 {"nx", ROLE_NX},       {"ny", ROLE_NY},       {"nz", ROLE_NZ},
                 {"u", ROLE_U},         {"v", ROLE_V},         {"s", ROLE_U},
                 {"t", ROLE_V},         {"texture_u", ROLE_U}, {"texture_v", ROLE_V},
                 {"texture_s", ROLE_U}, {"texture_t", ROLE_V}};
    if (e->is_face && is_list &&
        (strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0))
        return ROLE_FACE;
    for (size_t i = 0; e->is_vertex && !is_list && i < sizeof roles / sizeof *roles; i++) {
        if (strcmp(name, roles[i].name) == 0) return roles[i].role;
    }
    return ROLE_NONE;
}

static lmn_status read_property(struct ply *p)
{
    char word[MAX_WORD];
    struct property property = {0};
    if (p->n_elements == 0) return fail_ply(p, "a property before any element");
    struct ply_element *e = &p->elements[p->n_elements - 1];
    if (e->n_properties == MAX_PROPERTIES) return fail_ply(p, "too many properties");
    const char *before = p->at;
    read_word(p, word);
    property.is_list = strcmp(word, "list") == 0;
    if (property.is_list) {
        if (!read_scalar_type(p, &property.count_type) || property.count_type >= F32)
            return fail_ply(p, "unknown type of a list's length");
    } else {
        p->at = before;
    }
    if (!read_scalar_type(p, &property.type)) return fail_ply(p, "unknown type of a property");
    read_word(p, word);
    property.role = find_role(e, word, property.is_list);
    if (property.role == ROLE_FACE && property.type >= F32)
        return fail_ply(p, "vertex indices must be integers");
    e->properties[e->n_properties++] = property;
    return LMN_OK;
}

static lmn_status read_element(struct ply *p)
{
    char name[MAX_WORD], number[MAX_WORD];
    if (p->n_elements == MAX_ELEMENTS) return fail_ply(p, "too many elements");
    read_word(p, name);
    read_word(p, number);
    uint64_t count = 0;
    size_t n = strspn(number, "0123456789");
    if (n == 0 || n > 18 || number[n]) return fail_ply(p, "an element needs a count");
    for (size_t i = 0; i < n; i++) count = 10 * count + (uint64_t)(number[i] - '0');
    p->elements[p->n_elements++] = (struct ply_element){.is_vertex = strcmp(name, "vertex") == 0,
                                                        .is_face = strcmp(name, "face") == 0,
                                                        .count = count};
    return LMN_OK;
}

static lmn_status read_format(struct ply *p)
{
    char word[MAX_WORD];
    read_word(p, word);
    /* Set after the header: until then, errors are told by line. */
    if (strcmp(word, "ascii") == 0) {
        p->format = FORMAT_ASCII;
    } else if (strcmp(word, "binary_little_endian") == 0) {
        p->format = FORMAT_LITTLE;
    } else if (strcmp(word, "binary_big_endian") == 0) {
        p->format = FORMAT_BIG;
    } else {
        return fail_ply(p, "unknown format; known are ascii, binary_little_endian and "
                           "binary_big_endian");
    }
    return LMN_OK;
}

static lmn_status read_header(struct ply *p)
{
    lmn_status status = LMN_OK;
    char word[MAX_WORD];
    enum format format = FORMAT_NONE;
    for (uint32_t line = 0;; line++) {
        read_word(p, word);
        if (line == 0 && strcmp(word, "ply") != 0) return fail_ply(p, "not a PLY file");
        if (strcmp(word, "format") == 0) {
            TRY(read_format(p));
            format = p->format;
            p->format = FORMAT_NONE;
        } else if (strcmp(word, "element") == 0) {
            TRY(read_element(p));
        } else if (strcmp(word, "property") == 0) {
            TRY(read_property(p));
        } else if (line > 0 && strcmp(word, "end_header") != 0 && strcmp(word, "comment") != 0 &&
                   strcmp(word, "obj_info") != 0 && word[0]) {
            return fail_ply(p, "unknown line in the header");
        }
        const char *newline = memchr(p->at, '\n', (size_t)(p->end - p->at));
        if (!newline) return fail_ply(p, "the header does not end");
        p->at = newline + 1;
        if (strcmp(word, "end_header") == 0) break;
    }
    if (format == FORMAT_NONE) return fail_ply(p, "the header names no format");
    p->format = format;
done:
    return status;
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
    if (!read_value(p, property->count_type, &n)) return fail_ply(p, "the file is cut off");
    if (n < 0 || (property->role == ROLE_FACE && n < 3))
        return fail_ply(p, "a face needs three corners or more");
    if (n > (double)(p->end - p->at)) return fail_ply(p, "a list is longer than the file");
    for (double i = 0; i < n; i++) {
        if (!read_value(p, property->type, &v))
            return fail_ply(p, "the file is cut off, or what should be a number is none");
        if (property->role != ROLE_FACE) continue;
        if (v < 0 || v >= p->m.n_vertices) return fail_ply(p, "a vertex index is out of range");
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

static lmn_status read_records(struct ply *p, const struct ply_element *e,
                               const struct mesh_options *options, struct arena *arena)
{
    lmn_status status = LMN_OK;
    if (e->n_properties == 0) return LMN_OK;
    /* + 1: in ascii the last number has no blank behind it. */
    if (e->count > ((uint64_t)(p->end - p->at) + 1) / least_size(p, e))
        return fail_ply(p, "the file is cut off: it holds fewer records than its header says");
    if (e->is_vertex) {
        if (p->has_vertices) return fail_ply(p, "vertices are given twice");
        if (!has_roles(e, ROLE_X, ROLE_Z)) return fail_ply(p, "vertices have no x, y, z");
        bool has_normals = has_roles(e, ROLE_NX, ROLE_NZ) && !options->has_face_normals;
        bool has_uvs = has_roles(e, ROLE_U, ROLE_V);
        TRY(mesh_alloc(arena, e->count, 0, has_normals, has_uvs, &p->m, p->err));
        p->has_vertices = true;
    }
    for (uint64_t i = 0; i < e->count; i++) {
        for (uint32_t k = 0; k < e->n_properties; k++) {
            const struct property *property = &e->properties[k];
            double v;
            if (property->is_list) {
                TRY(read_list(p, property));
                continue;
            }
            if (!read_value(p, property->type, &v))
                return fail_ply(p, "the file is cut off, or what should be a number is none");
            float *target = target_of(p, property->role, i);
            if (target) *target = (float)v;
        }
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
    TRY(read_header(&p));
    for (uint32_t i = 0; i < p.n_elements; i++)
        TRY(read_records(&p, &p.elements[i], options, arena));
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
    TRY(mesh_finish(path, options, arena, &p.m, err));
    *out = p.m;
done:
    mem_free(p.indices);
    return status;
}
