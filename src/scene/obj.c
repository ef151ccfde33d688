/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "scene/mesh.h"
#include "scene/text_number.h"

/* Wavefront OBJ, in one pass over the text. */

struct corner {
    int32_t v, t, n; /* from 0; -1: absent */
};

/* A growing array of groups of floats. */
struct floats {
    float *data;
    size_t n, capacity; /* floats */
};

struct obj {
    const char *path;
    const char *at, *end, *line_start;
    unsigned line;
    struct error *err;

    struct floats v, t, n;
    struct corner *corners; /* of all triangles, three each */
    size_t n_corners, cap_corners;
    bool has_t, has_n, lacks_n;
};

static lmn_status fail_line(struct obj *o, const char *what)
{
    return fail(o->err, LMN_ERR_PARSE, "%s:%u:%u: %s", o->path, o->line,
                (unsigned)(o->at - o->line_start) + 1, what);
}

/* Blanks, and a backslash that continues the line. */
static void skip_blanks(struct obj *o)
{
    for (;;) {
        char c = *o->at;
        if (c == ' ' || c == '\t' || c == '\r') {
            o->at++;
        } else if (c == '\\' && (o->at[1] == '\n' || (o->at[1] == '\r' && o->at[2] == '\n'))) {
            o->at += o->at[1] == '\n' ? 2 : 3;
            o->line++;
            o->line_start = o->at;
        } else {
            return;
        }
    }
}

static bool at_line_end(const struct obj *o)
{
    return *o->at == '\n' || *o->at == '#' || o->at == o->end;
}

static lmn_status push(struct obj *o, struct floats *f, const float *values, size_t width)
{
    void *block = f->data;
    bool ok = mem_grow(&block, &f->capacity, f->n + width, sizeof *f->data);
    f->data = block;
    if (!ok) return fail_memory(o->err, o->path);
    for (size_t i = 0; i < width; i++) f->data[f->n + i] = values[i];
    f->n += width;
    return LMN_OK;
}

/* `width` numbers, of which `needed` must be there (others: 0); what follows is skipped. */
static lmn_status read_floats(struct obj *o, struct floats *f, size_t width, size_t needed)
{
    float values[3] = {0, 0, 0};
    for (size_t i = 0; i < width; i++) {
        skip_blanks(o);
        if (i >= needed && at_line_end(o)) break;
        if (!text_to_float(&o->at, &values[i])) return fail_line(o, "expected a finite number");
    }
    return push(o, f, values, width);
}

/* An index from 1, or from the end when negative, of `n` things. */
static bool read_index(struct obj *o, size_t n, int32_t *out)
{
    int i;
    if (!text_to_int(&o->at, &i) || i == 0) return false;
    int64_t index = i > 0 ? (int64_t)i - 1 : (int64_t)n + i;
    if (index < 0 || index >= (int64_t)n) return false;
    *out = (int32_t)index;
    return true;
}

static lmn_status read_corner(struct obj *o, struct corner *c)
{
    *c = (struct corner){-1, -1, -1};
    if (!read_index(o, o->v.n / 3, &c->v))
        return fail_line(o, "expected the index of a vertex (v) that comes before");
    if (*o->at == '/') {
        o->at++;
        bool is_empty = *o->at == '/' || *o->at == ' ' || *o->at == '\t' || at_line_end(o);
        if (!is_empty && !read_index(o, o->t.n / 2, &c->t))
            return fail_line(o, "expected the index of a texture coordinate (vt)");
        if (*o->at == '/') {
            o->at++;
            if (!read_index(o, o->n.n / 3, &c->n))
                return fail_line(o, "expected the index of a normal (vn)");
        }
    }
    o->has_t |= c->t >= 0;
    o->has_n |= c->n >= 0;
    o->lacks_n |= c->n < 0;
    return LMN_OK;
}

/* A polygon becomes a fan around its first corner. */
static lmn_status read_face(struct obj *o)
{
    lmn_status status = LMN_OK;
    struct corner first = {0}, last = {0}, c;
    size_t n = 0;
    for (skip_blanks(o); !at_line_end(o); skip_blanks(o), n++) {
        TRY(read_corner(o, &c));
        if (n == 0) first = c;
        if (n >= 2) {
            void *block = o->corners;
            bool ok = mem_grow(&block, &o->cap_corners, o->n_corners + 3, sizeof *o->corners);
            o->corners = block;
            if (!ok) return fail_memory(o->err, o->path);
            o->corners[o->n_corners++] = first;
            o->corners[o->n_corners++] = last;
            o->corners[o->n_corners++] = c;
        }
        last = c;
    }
    if (n < 3) return fail_line(o, "a face needs three corners or more");
done:
    return status;
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

static lmn_status read_lines(struct obj *o)
{
    lmn_status status = LMN_OK;
    while (o->at < o->end) {
        skip_blanks(o);
        const char *p = o->at;
        if (p[0] == 'v' && is_blank(p[1])) {
            o->at += 2;
            TRY(read_floats(o, &o->v, 3, 3));
        } else if (p[0] == 'v' && p[1] == 'n' && is_blank(p[2])) {
            o->at += 3;
            TRY(read_floats(o, &o->n, 3, 3));
        } else if (p[0] == 'v' && p[1] == 't' && is_blank(p[2])) {
            o->at += 3;
            TRY(read_floats(o, &o->t, 2, 1));
        } else if (p[0] == 'f' && is_blank(p[1])) {
            o->at += 2;
            TRY(read_face(o));
        }
        const char *newline = memchr(o->at, '\n', (size_t)(o->end - o->at));
        o->at = newline ? newline + 1 : o->end;
        o->line++;
        o->line_start = o->at;
    }
done:
    return status;
}

/* Gives each distinct (v, t, n) a vertex; `vertices` gets its corner. Vertices that share v are in
 * a list from first[v], which is short: so this is linear without a hash table. */
static uint32_t weld(const struct obj *o, uint32_t *first, uint32_t *next, struct corner *vertices,
                     uint32_t *indices)
{
    uint32_t n = 0;
    memset(first, 0xFF, o->v.n / 3 * sizeof *first);
    for (size_t i = 0; i < o->n_corners; i++) {
        struct corner c = o->corners[i];
        uint32_t k = first[c.v];
        while (k != UINT32_MAX && (vertices[k].t != c.t || vertices[k].n != c.n)) k = next[k];
        if (k == UINT32_MAX) {
            k = n++;
            vertices[k] = c;
            next[k] = first[c.v];
            first[c.v] = k;
        }
        indices[i] = k;
    }
    return n;
}

static lmn_status build(struct obj *o, const struct mesh_options *options, struct arena *arena,
                        struct mesh *out)
{
    lmn_status status = LMN_OK;
    struct mesh m;
    uint32_t *first = mem_new(o->v.n / 3, sizeof *first);
    uint32_t *next = mem_new(o->n_corners, sizeof *next);
    uint32_t *indices = mem_new(o->n_corners, sizeof *indices);
    struct corner *vertices = mem_new(o->n_corners, sizeof *vertices);
    if (!first || !next || !indices || !vertices) {
        status = fail_memory(o->err, o->path);
        goto done;
    }
    bool has_normals = o->has_n && !o->lacks_n && !options->has_face_normals;
    for (size_t i = 0; !has_normals && i < o->n_corners; i++) o->corners[i].n = -1;
    uint32_t n = weld(o, first, next, vertices, indices);
    TRY(mesh_alloc(arena, n, o->n_corners / 3, has_normals, o->has_t, &m, o->err));
    for (size_t i = 0; i < n; i++) {
        const struct corner *c = &vertices[i];
        memcpy(m.positions + 3 * i, o->v.data + 3 * (size_t)c->v, 3 * sizeof(float));
        if (has_normals) memcpy(m.normals + 3 * i, o->n.data + 3 * (size_t)c->n, 3 * sizeof(float));
        if (c->t >= 0) memcpy(m.uvs + 2 * i, o->t.data + 2 * (size_t)c->t, 2 * sizeof(float));
    }
    memcpy(m.indices, indices, o->n_corners * sizeof *indices);
    TRY(mesh_finish(o->path, options, arena, &m, o->err));
    *out = m;
done:
    mem_free(first);
    mem_free(next);
    mem_free(indices);
    mem_free(vertices);
    return status;
}

lmn_status obj_load(const char *path, const char *text, size_t size,
                    const struct mesh_options *options, struct arena *arena, struct mesh *out,
                    struct error *err)
{
    lmn_status status = LMN_OK;
    struct obj o = {
        .path = path, .at = text, .end = text + size, .line_start = text, .line = 1, .err = err};
    TRY(read_lines(&o));
    if (o.n_corners == 0) {
        status = fail(err, LMN_ERR_PARSE, "%s: the mesh has no faces", path);
        goto done;
    }
    if (o.n_corners / 3 > MESH_MAX_TRIANGLES) {
        status = fail(err, LMN_ERR_PARSE, "%s: more than %d triangles", path, MESH_MAX_TRIANGLES);
        goto done;
    }
    TRY(build(&o, options, arena, out));
done:
    mem_free(o.v.data);
    mem_free(o.t.data);
    mem_free(o.n.data);
    mem_free(o.corners);
    return status;
}
