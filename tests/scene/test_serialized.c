/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_text.h"

#include <zlib.h>

#include "base/rng.h"
#include "scene/mesh.h"

/* Mitsuba's serialized meshes, written here as the format's description says; then damaged. */

enum { NORMALS = 1, UVS = 2, COLOURS = 8, FACE_NORMALS = 16, SINGLE = 0x1000, DOUBLE = 0x2000 };

struct bytes {
    unsigned char at[8192];
    size_t n;
};

static void put(struct bytes *b, const void *from, size_t n)
{
    if (b->n + n > sizeof b->at) abort();
    memcpy(b->at + b->n, from, n);
    b->n += n;
}

static void put_le(struct bytes *b, uint64_t v, int n_bytes)
{
    for (int i = 0; i < n_bytes; i++) {
        unsigned char c = (unsigned char)(v >> (8 * i));
        put(b, &c, 1);
    }
}

static void put_floats(struct bytes *b, uint32_t flags, const float *v, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        double wide = (double)v[i];
        if (flags & DOUBLE) {
            put(b, &wide, sizeof wide);
        } else {
            put(b, &v[i], sizeof *v);
        }
    }
}

static const float positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static const float normals[] = {0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2};
static const float uvs[] = {0, 0, 1, 0, 1, 1, 0, 1};
static const float colours[] = {1, 0, 0, 0, 1, 0, 0, 0, 1, .5f, .5f, .5f};

/* A square lifted by z, with its header. */
static void put_square(struct bytes *b, unsigned version, uint32_t flags, float z, uint64_t n,
                       const uint32_t *indices)
{
    struct bytes plain = {.n = 0};
    float p[12];
    put_le(&plain, flags, 4);
    if (version == 4) put(&plain, "square", 7);
    put_le(&plain, n, 8);
    put_le(&plain, 2, 8);
    for (int i = 0; i < 12; i++) p[i] = positions[i] + (i % 3 == 2 ? z : 0);
    put_floats(&plain, flags, p, 12);
    if (flags & NORMALS) put_floats(&plain, flags, normals, 12);
    if (flags & UVS) put_floats(&plain, flags, uvs, 8);
    if (flags & COLOURS) put_floats(&plain, flags, colours, 12);
    for (int i = 0; i < 6; i++) put_le(&plain, indices[i], 4);
    put_le(b, 0x041C, 2);
    put_le(b, version, 2);
    uLongf size = sizeof b->at - b->n;
    if (compress(b->at + b->n, &size, plain.at, plain.n) != Z_OK) abort();
    b->n += size;
}

/* Two squares, the second with other flags. */
static struct bytes two_squares(unsigned version, uint32_t first_flags, uint32_t second_flags)
{
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    struct bytes b = {.n = 0};
    put_square(&b, version, first_flags, 0, 4, indices);
    size_t second = b.n;
    put_square(&b, version, second_flags, 5, 4, indices);
    put_le(&b, 0, version == 4 ? 8 : 4);
    put_le(&b, second, version == 4 ? 8 : 4);
    put_le(&b, 2, 4);
    return b;
}

static lmn_status load(const struct bytes *b, uint32_t index, bool has_face_normals,
                       struct arena *arena, struct mesh *m, struct error *err)
{
    struct mesh_options options = {.to_world = transform_identity(),
                                   .shape_index = index,
                                   .has_face_normals = has_face_normals};
    memset(err, 0, sizeof *err);
    return serialized_load("a.serialized", (const char *)b->at, b->n, &options, arena, m, err);
}

static void versions_and_widths(void **state)
{
    (void)state;
    for (unsigned version = 3; version <= 4; version++) {
        for (int k = 0; k < 2; k++) {
            struct arena arena = {0};
            struct mesh m;
            struct error err;
            uint32_t width = k ? DOUBLE : SINGLE;
            struct bytes b = two_squares(version, width | NORMALS | UVS | COLOURS, width);
            if (load(&b, 0, false, &arena, &m, &err) != LMN_OK) fail_msg("%s", err.text);
            assert_int_equal(m.n_vertices, 4);
            assert_int_equal(m.n_triangles, 2);
            assert_memory_equal(m.positions, positions, sizeof positions);
            assert_memory_equal(m.uvs, uvs, sizeof uvs);
            assert_true(m.normals[2] == 1.0f); /* made unit */
            assert_int_equal(m.indices[5], 3);
            assert_int_equal(m.n_attributes, 1);
            assert_string_equal(m.attributes[0].name, "vertex_color");
            assert_int_equal(m.attributes[0].n_channels, 3);
            assert_false(m.attributes[0].is_of_faces);
            assert_memory_equal(m.attributes[0].values, colours, sizeof colours);

            if (load(&b, 1, false, &arena, &m, &err) != LMN_OK) fail_msg("%s", err.text);
            assert_true(m.positions[2] == 5.0f);
            assert_non_null(m.normals); /* made */
            assert_null(m.uvs);
            if (load(&b, 0, true, &arena, &m, &err) != LMN_OK) fail_msg("%s", err.text);
            assert_null(m.normals);
            arena_release(&arena);
        }
    }
}

/* In a scene, by shapeIndex; the name comes from the file. */
static void in_a_scene(void **state)
{
    (void)state;
    struct bytes b = two_squares(4, SINGLE, SINGLE | FACE_NORMALS);
    struct scene *s;
    struct error err;
    text_write("two.serialized", b.at, b.n);
    text_write_string("s.xml", "<scene version='0.6.0'><sensor type='perspective'/>"
                               "<shape type='serialized'><string name='filename' "
                               "value='two.serialized'/></shape>"
                               "<shape type='serialized'><string name='filename' "
                               "value='two.serialized'/><integer name='shapeIndex' value='1'/>"
                               "<float name='maxSmoothAngle' value='30'/></shape></scene>");
    if (text_load_file("s.xml", NULL, &s, &err) != LMN_OK) fail_msg("%s", err.text);
    assert_int_equal(s->n_meshes, 2);
    assert_true(s->meshes[0].positions[2] == 0.0f);
    assert_true(s->meshes[1].positions[2] == 5.0f);
    assert_non_null(s->meshes[0].normals);
    assert_null(s->meshes[1].normals);
    assert_string_equal(s->shapes[0].name, "two");
    scene_free(s);
}

static void assert_refused(const struct bytes *b, uint32_t index, const char *message)
{
    struct arena arena = {0};
    struct mesh m;
    struct error err;
    assert_int_equal(load(b, index, false, &arena, &m, &err), LMN_ERR_PARSE);
    if (!strstr(err.text, message)) fail_msg("\"%s\" instead of \"%s\"", err.text, message);
    assert_true(arena.total_size < 1 << 20);
    arena_release(&arena);
}

static void messages(void **state)
{
    static const uint32_t wild[] = {0, 1, 2, 0, 2, 4}, tame[] = {0, 1, 2, 0, 2, 3};
    (void)state;
    struct bytes b = two_squares(4, SINGLE, SINGLE);
    assert_refused(&b, 2, "no mesh 2; it has 2");
    b.at[0] = 0;
    assert_refused(&b, 0, "not a serialized mesh");
    b = two_squares(4, SINGLE, SINGLE);
    b.at[2] = 5;
    assert_refused(&b, 0, "version 5 is not known");
    b = two_squares(4, SINGLE, SINGLE);
    memset(b.at + b.n - 12, 0xFF, 8);
    assert_refused(&b, 1, "begins outside of the file");
    b.n = 0;
    put_square(&b, 4, SINGLE, 0, 4, wild);
    put_le(&b, 0, 8);
    put_le(&b, 1, 4);
    assert_refused(&b, 0, "a vertex index is out of range");
    /* More vertices than any file of this size could hold, and more than there are. */
    for (int i = 0; i < 3; i++) {
        static const uint64_t counts[] = {1u << 28, UINT64_MAX / 12, 400};
        b.n = 0;
        put_square(&b, 4, SINGLE, 0, counts[i], tame);
        put_le(&b, 0, 8);
        put_le(&b, 1, 4);
        assert_refused(&b, 0, "damaged or cut off");
    }
}

/* Cut off anywhere, and with bytes changed: an error or a mesh, and little memory. */
static void damaged(void **state)
{
    struct bytes whole = two_squares(4, SINGLE | NORMALS | UVS | COLOURS, DOUBLE | COLOURS);
    struct mesh m;
    struct error err;
    (void)state;
    for (size_t n = 0; n < whole.n; n++) {
        struct arena arena = {0};
        struct bytes b = whole;
        b.n = n;
        /* A shorter file can end in what passes for a list: only crashes and messages count. */
        lmn_status status = load(&b, 1, false, &arena, &m, &err);
        if (status != LMN_OK && !err.text[0]) fail_msg("cut at %zu: no message", n);
        assert_true(arena.total_size < 1 << 20);
        arena_release(&arena);
    }
    for (uint32_t i = 0; i < 3000; i++) {
        struct arena arena = {0};
        struct bytes b = whole;
        struct rng r = rng_keyed(11, i, 0);
        for (uint32_t k = 0; k <= i % 3; k++)
            b.at[rng_below(&r, (uint32_t)b.n)] = (unsigned char)rng_u32(&r);
        lmn_status status = load(&b, i % 2, false, &arena, &m, &err);
        if (status != LMN_OK && !err.text[0]) fail_msg("change %u: no message", i);
        assert_true(arena.total_size < 1 << 22);
        arena_release(&arena);
    }
}

/* A square whose compressed bytes stand for gigabytes: only what the header says is inflated. */
static void bomb(void **state)
{
    enum { SIZE = 4 << 20 };
    struct bytes b = {.n = 0};
    (void)state;
    unsigned char *zeros = calloc(SIZE, 1);
    assert_non_null(zeros);
    memcpy(zeros, "\x00\x10\x00\x00x", 6);
    zeros[6] = 0x04; /* vertices */
    zeros[14] = 0x02;
    put_le(&b, 0x041C, 2);
    put_le(&b, 4, 2);
    uLongf size = sizeof b.at - b.n;
    assert_int_equal(compress(b.at + b.n, &size, zeros, SIZE), Z_OK);
    b.n += size;
    free(zeros);
    put_le(&b, 0, 8);
    put_le(&b, 1, 4);
    struct arena arena = {0};
    struct mesh m;
    struct error err;
    if (load(&b, 0, false, &arena, &m, &err) != LMN_OK) fail_msg("%s", err.text);
    assert_int_equal(m.n_vertices, 4);
    assert_true(arena.total_size < 1 << 20);
    arena_release(&arena);
}

static void short_memory(void **state)
{
    struct bytes b = two_squares(4, SINGLE | NORMALS | UVS | COLOURS, DOUBLE);
    (void)state;
    for (uint64_t n = 1;; n++) {
        struct arena arena = {0};
        struct mesh m;
        struct error err;
        mem_fail_after(n);
        lmn_status status = load(&b, 0, false, &arena, &m, &err);
        mem_fail_after(0);
        arena_release(&arena);
        if (status == LMN_OK) break;
        assert_int_equal(status, LMN_ERR_MEMORY);
        assert_true(n < 100);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(versions_and_widths),
        cmocka_unit_test(in_a_scene),
        cmocka_unit_test(messages),
        cmocka_unit_test(damaged),
        cmocka_unit_test(bomb),
        cmocka_unit_test(short_memory),
    };
    return cmocka_run_group_tests_name("serialized meshes", tests, text_setup, text_teardown);
}
