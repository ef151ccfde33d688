/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>
#include <zlib.h>

#include "scene/mesh.h"

/*
 * Mitsuba's `serialized` (documentation of 0.6, "Serialized mesh loader"); little endian:
 *
 *   for each mesh   u16 0x041C, u16 version, then deflated (zlib):
 *                   u32 flags; version 4: name, ends with 0; u64 vertices, u64 triangles;
 *                   positions, normals, texture coordinates, colours: 3, 3, 2, 3 floats or doubles
 *                   for each vertex, as flags say; triangles: 3 u32 each
 *   at the end      where each mesh begins, u64 (version 3: u32) each; u32 number of meshes
 */

enum { MAGIC = 0x041C, MAX_MESHES = 1 << 24 };
enum {
    HAS_NORMALS = 0x0001,
    HAS_UVS = 0x0002,
    HAS_COLOURS = 0x0008,
    HAS_FACE_NORMALS = 0x0010,
    IS_SINGLE = 0x1000,
    IS_DOUBLE = 0x2000
};

struct serialized {
    const char *path;
    const unsigned char *bytes;
    size_t size;
    struct error *err;
    z_stream z;
    bool has_stream;
    bool is_double;
};

static lmn_status fail_file(struct serialized *s, const char *what)
{
    return fail(s->err, LMN_ERR_PARSE, "%s: %s", s->path, what);
}

static uint64_t read_le(const unsigned char *p, int n_bytes)
{
    uint64_t v = 0;
    for (int i = 0; i < n_bytes; i++) v |= (uint64_t)p[i] << (8 * i);
    return v;
}

/* zlib's memory comes from where all of ours does. */
static voidpf allocate(voidpf user, uInt count, uInt size)
{
    (void)user;
    return mem_new(count, size);
}

static void release(voidpf user, voidpf block)
{
    (void)user;
    mem_free(block);
}

/* The next n bytes of the mesh. */
static lmn_status inflate_bytes(struct serialized *s, void *to, size_t n)
{
    unsigned char *at = to;
    while (n > 0) {
        uInt step = n < (1u << 30) ? (uInt)n : 1u << 30;
        s->z.next_out = at;
        s->z.avail_out = step;
        int code = inflate(&s->z, Z_SYNC_FLUSH);
        uInt done = step - s->z.avail_out;
        at += done;
        n -= done;
        if (code == Z_MEM_ERROR) return fail_memory(s->err, s->path);
        if (code != Z_OK && code != Z_STREAM_END) return fail_file(s, "damaged or cut off");
        if (n > 0 && (code == Z_STREAM_END || done == 0))
            return fail_file(s, "damaged or cut off: a mesh ends too early");
    }
    return LMN_OK;
}

/* Finds the mesh and starts to inflate it. */
static lmn_status open_mesh(struct serialized *s, uint32_t index, unsigned *version)
{
    if (s->size < 8 || read_le(s->bytes, 2) != MAGIC)
        return fail_file(s, "not a serialized mesh of Mitsuba");
    *version = (unsigned)read_le(s->bytes + 2, 2);
    if (*version != 3 && *version != 4)
        return fail(s->err, LMN_ERR_PARSE, "%s: version %u is not known; 3 and 4 are", s->path,
                    *version);
    uint64_t n = read_le(s->bytes + s->size - 4, 4), width = *version == 4 ? 8 : 4;
    if (n < 1 || n > MAX_MESHES || 4 + n * width > s->size)
        return fail_file(s, "damaged or cut off: no list of meshes at its end");
    if (index >= n)
        return fail(s->err, LMN_ERR_PARSE, "%s: no mesh %u; it has %u", s->path, (unsigned)index,
                    (unsigned)n);
    size_t list = s->size - 4 - (size_t)(n * width);
    uint64_t begin = read_le(s->bytes + list + index * width, (int)width);
    if (begin > list || list - begin < 5) return fail_file(s, "a mesh begins outside of the file");
    if (read_le(s->bytes + begin, 2) != MAGIC) return fail_file(s, "a mesh begins with no header");
    *version = (unsigned)read_le(s->bytes + begin + 2, 2);
    if (*version != 3 && *version != 4) return fail_file(s, "a mesh of unknown version");

    size_t length = list - begin - 4; /* with the meshes after it; file sizes are below 2^32 */
    s->z.zalloc = allocate;
    s->z.zfree = release;
    s->z.next_in = (z_const Bytef *)(s->bytes + begin + 4);
    s->z.avail_in = length < UINT32_MAX ? (uInt)length : UINT32_MAX;
    if (inflateInit(&s->z) != Z_OK) return fail_memory(s->err, s->path);
    s->has_stream = true;
    return LMN_OK;
}

/* n values into `to`, or nowhere. */
static lmn_status read_values(struct serialized *s, float *to, size_t n)
{
    enum { CHUNK = 512 };
    lmn_status status = LMN_OK;
    double doubles[CHUNK];
    float floats[CHUNK];
    if (!s->is_double && to) return inflate_bytes(s, to, n * sizeof *to);
    for (size_t i = 0; i < n; i += CHUNK) {
        size_t k = n - i < CHUNK ? n - i : CHUNK;
        void *from = s->is_double ? (void *)doubles : (void *)floats;
        TRY(inflate_bytes(s, from, k * (s->is_double ? sizeof *doubles : sizeof *floats)));
        for (size_t j = 0; to && j < k; j++) to[i + j] = (float)doubles[j];
    }
done:
    return status;
}

static lmn_status read_name(struct serialized *s)
{
    enum { MAX_NAME = 4096 };
    char c = 1;
    for (int i = 0; c; i++) {
        if (i == MAX_NAME) return fail_file(s, "the name of a mesh is too long");
        lmn_status status = inflate_bytes(s, &c, 1);
        if (status != LMN_OK) return status;
    }
    return LMN_OK;
}

static bool is_finite(const float *a, size_t n)
{
    bool ok = true;
    for (size_t i = 0; i < n; i++) ok &= isfinite(a[i]) != 0;
    return ok;
}

static lmn_status read_mesh(struct serialized *s, unsigned version,
                            const struct mesh_options *options, struct arena *arena, struct mesh *m)
{
    lmn_status status = LMN_OK;
    unsigned char head[20];
    TRY(inflate_bytes(s, head, 4));
    uint32_t flags = (uint32_t)read_le(head, 4);
    if (version == 4) TRY(read_name(s));
    TRY(inflate_bytes(s, head, 16));
    uint64_t n_vertices = read_le(head, 8), n_triangles = read_le(head + 8, 8);
    s->is_double = (flags & IS_DOUBLE) != 0;
    if (n_vertices == 0 || n_triangles == 0) return fail_file(s, "the mesh has no faces");
    /* Nothing deflates better than 1032 to 1: find out before memory is taken. */
    uint64_t most = ((uint64_t)s->z.avail_in + 64) * 1032;
    if (n_vertices > MESH_MAX_VERTICES || n_triangles > MESH_MAX_TRIANGLES ||
        n_vertices * 3 * (s->is_double ? 8 : 4) + n_triangles * 12 > most)
        return fail_file(s, "damaged or cut off: it holds less than its header says");

    bool has_normals = (flags & HAS_NORMALS) != 0;
    bool wants_normals = has_normals && !options->has_face_normals;
    TRY(mesh_alloc(arena, n_vertices, n_triangles, wants_normals, (flags & HAS_UVS) != 0, m,
                   s->err));
    TRY(read_values(s, m->positions, 3 * n_vertices));
    if (has_normals) TRY(read_values(s, m->normals, 3 * n_vertices));
    if (flags & HAS_UVS) TRY(read_values(s, m->uvs, 2 * n_vertices));
    if (flags & HAS_COLOURS) {
        struct mesh_attribute *a = mesh_add_attribute(arena, m, "vertex_color", 3, false);
        if (!a) return fail_memory(s->err, s->path);
        TRY(read_values(s, a->values, 3 * n_vertices));
        if (!is_finite(a->values, 3 * n_vertices)) return fail_file(s, "a colour is not finite");
    }
    TRY(inflate_bytes(s, m->indices, 3 * n_triangles * sizeof *m->indices));
    for (size_t i = 0; i < 3 * n_triangles; i++) {
        m->indices[i] = (uint32_t)read_le((const unsigned char *)&m->indices[i], 4);
        if (m->indices[i] >= n_vertices) return fail_file(s, "a vertex index is out of range");
    }
    struct mesh_options how = *options;
    how.has_face_normals |= !has_normals && (flags & HAS_FACE_NORMALS);
    TRY(mesh_finish(s->path, &how, arena, m, s->err));
done:
    return status;
}

lmn_status serialized_load(const char *path, const char *text, size_t size,
                           const struct mesh_options *options, struct arena *arena,
                           struct mesh *out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct mesh m = {0};
    unsigned version = 0;
    struct serialized s = {
        .path = path, .bytes = (const unsigned char *)text, .size = size, .err = err};
    TRY(open_mesh(&s, options->shape_index, &version));
    TRY(read_mesh(&s, version, options, arena, &m));
    *out = m;
done:
    if (s.has_stream) inflateEnd(&s.z);
    return status;
}
