/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/mesh.h"
#include "scene/text_number.h"
#include "scene_text.h"

#include <math.h>

/* OBJ, PLY and the meshed primitives. Expected normals and texture coordinates are those that
 * Mitsuba 3.9.1 has after loading the same files. */

static void assert_floats(const float *got, const float *wanted, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (!(fabsf(got[i] - wanted[i]) <= 2e-6f))
            fail_msg("value %zu: %.8g is not %.8g", i, (double)got[i], (double)wanted[i]);
    }
}

static void assert_indices(const struct mesh *m, const uint32_t *wanted, size_t n)
{
    assert_int_equal(3 * m->n_triangles, n);
    assert_memory_equal(m->indices, wanted, n * sizeof *wanted);
}

typedef lmn_status load_fn(const char *path, const char *text, size_t size,
                           const struct mesh_options *options, struct arena *arena,
                           struct mesh *out, struct error *err);

static struct arena arena;

static int release_arena(void **state)
{
    (void)state;
    arena_release(&arena);
    return 0;
}

static struct mesh load(load_fn *fn, const char *text, struct mesh_options options)
{
    struct mesh m = {0};
    struct error err;
    if (fn("m", text, strlen(text), &options, &arena, &m, &err) != LMN_OK) fail_msg("%s", err.text);
    return m;
}

static struct mesh_options plain(void)
{
    return (struct mesh_options){.to_world = transform_identity()};
}

static const char bent_quad[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\n"
                                "vt 0 0\nvt 1 0\nvt 1 0.75\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";

static void obj_normals_and_uvs(void **state)
{
    static const float normals[] = {0.370483f, -0.370483f, 0.851754f, 0,
                                    0,         1,          0.370483f, -0.370483f,
                                    0.851754f, 0.57735f,   -0.57735f, 0.57735f};
    static const float uvs[] = {0, 1, 1, 1, 1, 0.25f, 0, 0};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    struct mesh_options options = plain();
    (void)state;
    options.has_flipped_v = true;
    struct mesh m = load(obj_load, bent_quad, options);
    assert_int_equal(m.n_vertices, 4);
    assert_indices(&m, indices, 6);
    assert_floats(m.normals, normals, 12);
    assert_floats(m.uvs, uvs, 8);

    options.has_face_normals = true;
    m = load(obj_load, bent_quad, options);
    assert_null(m.normals);
}

static void obj_mirrored(void **state)
{
    /* Mitsuba computes normals after the transform. */
    static const float normals[] = {0.377233f,   0.754467f,  -0.537099f, 0,
                                    0,           -1,         0.2603427f, 0.5206854f,
                                    -0.8130858f, 0.4285714f, 0.8571429f, -0.2857143f};
    struct mesh_options options = plain();
    (void)state;
    options.to_world = transform_scale(vec3(-2, 1, 3));
    struct mesh m = load(obj_load, bent_quad, options);
    assert_floats(m.normals, normals, 12);
}

static void obj_lines(void **state)
{
    static const uint32_t fan[] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 1, 2};
    (void)state;
    struct mesh m = load(obj_load,
                         "# comment\r\nmtllib x.mtl\r\no thing\r\ng a b\r\nusemtl m\r\ns off\r\n"
                         "v 0 0 0 1.0\r\nv 1 0 0\r\n\tv\t2 1 0\r\nv 1 2 0\r\nv .0e0 2 0\r\n"
                         "vn 0 0 1\r\nl 1 2\r\n"
                         "f 1//1 2//1 3//1 4//1 \\\r\n 5//1 # five corners\r\n"
                         "f -5//-1 -4//-1 -3//-1",
                         plain());
    assert_indices(&m, fan, 12);
    assert_int_equal(m.n_vertices, 5);
    assert_null(m.uvs);
    for (int i = 0; i < 5; i++) assert_float_equal(m.normals[3 * i + 2], 1.0f, 0.0f);

    /* The same position with two texture coordinates is two vertices. */
    m = load(obj_load, "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1\nf 1/1 2/1 3/1\nf 1/2 2/1 3/1\n",
             plain());
    assert_int_equal(m.n_vertices, 4);
    assert_float_equal(m.uvs[2 * 3], 1.0f, 0.0f);

    /* Slashes with nothing behind them. */
    m = load(obj_load, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/ 2/ 3/\n", plain());
    assert_int_equal(m.n_vertices, 3);
    assert_null(m.uvs);
}

struct bad_mesh {
    const char *text, *message;
};

static void assert_bad(load_fn *fn, const struct bad_mesh *bad, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        struct mesh m;
        struct error err = {{0}};
        struct mesh_options options = plain();
        lmn_status status = fn("m", bad[i].text, strlen(bad[i].text), &options, &arena, &m, &err);
        assert_int_equal(status, LMN_ERR_PARSE);
        assert_string_equal(err.text, bad[i].message);
    }
}

static void obj_errors(void **state)
{
    static const struct bad_mesh bad[] = {
        {"", "m: the mesh has no faces"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "m: the mesh has no faces"},
        {"v 0 0\n", "m:1:6: expected a finite number"},
        {"v 0 0 x\n", "m:1:7: expected a finite number"},
        {"v 0 0 nan\n", "m:1:7: expected a finite number"},
        {"v 0 0 1e39\n", "m:1:7: expected a finite number"},
        {"v 0 0 0\nf 1 2 3\n", "m:2:6: expected the index of a vertex (v) that comes before"},
        {"v 0 0 0\nf 0 0 0\n", "m:2:4: expected the index of a vertex (v) that comes before"},
        {"v 0 0 0\nf -2 1 1\n", "m:2:5: expected the index of a vertex (v) that comes before"},
        {"v 0 0 0\nf 1 1\n", "m:2:6: a face needs three corners or more"},
        {"v 0 0 0\nf 1/1 1 1\n", "m:2:6: expected the index of a texture coordinate (vt)"},
        {"v 0 0 0\nf 1//1 1 1\n", "m:2:7: expected the index of a normal (vn)"},
        {"v 0 0 0\nf 99999999999999999999 1 1\n",
         "m:2:3: expected the index of a vertex (v) that comes before"},
        {"v 0 0 0\nv 1 0 0\nv 1e30 1 0\nf 1 2 3\n", "m: a coordinate is not finite or above 1e18"},
    };
    (void)state;
    assert_bad(obj_load, bad, sizeof bad / sizeof *bad);
}

#define PLY_HEADER(format, n_faces)                                                          \
    "ply\nformat " format " 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\n" \
    "property double y\nproperty float z\nproperty uchar quality\nproperty float u\n"        \
    "property float v\nelement face " n_faces "\nproperty list uchar int vertex_indices\n"   \
    "element edge 0\nproperty int a\nend_header\n"

static void check_ply(const struct mesh *m)
{
    static const float positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 1};
    static const float normals[] = {0.370483f, -0.370483f, 0.851754f, 0,
                                    0,         1,          0.370483f, -0.370483f,
                                    0.851754f, 0.57735f,   -0.57735f, 0.57735f};
    static const float uvs[] = {0, 0, 1, 0, 1, 0.75f, 0, 1};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    assert_int_equal(m->n_vertices, 4);
    assert_indices(m, indices, 6);
    assert_floats(m->positions, positions, 12);
    assert_floats(m->normals, normals, 12);
    assert_floats(m->uvs, uvs, 8);
}

static void ply_ascii(void **state)
{
    (void)state;
    struct mesh m = load(ply_load,
                         PLY_HEADER("ascii", "1") "0 0 0 7 0 0\n1 0 0 7 1 0\n1 1 0 7 1 .75\n"
                                                  "0 1 1 7 0 1\n4 0 1 2 3",
                         plain());
    check_ply(&m);
}

/* Appends a number of `size` bytes in the byte order asked for. */
static void put(char **at, const void *value, size_t size, bool is_big)
{
    const char *bytes = value;
    for (size_t i = 0; i < size; i++) *(*at)++ = bytes[is_big ? size - 1 - i : i];
}

static size_t write_binary(char *out, bool is_big)
{
    static const float vertices[4][5] = {
        {0, 0, 0, 0, 0}, {1, 0, 0, 1, 0}, {1, 1, 0, 1, 0.75f}, {0, 1, 1, 0, 1}};
    static const char *const headers[] = {PLY_HEADER("binary_little_endian", "2"),
                                          PLY_HEADER("binary_big_endian", "2")};
    static const int32_t faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
    char *at = out;
    memcpy(at, headers[is_big], strlen(headers[is_big]));
    at += strlen(headers[is_big]);
    for (int i = 0; i < 4; i++) {
        double y = (double)vertices[i][1];
        put(&at, &vertices[i][0], 4, is_big);
        put(&at, &y, 8, is_big);
        put(&at, &vertices[i][2], 4, is_big);
        *at++ = 7;
        put(&at, &vertices[i][3], 4, is_big);
        put(&at, &vertices[i][4], 4, is_big);
    }
    for (int i = 0; i < 2; i++) {
        *at++ = 3;
        for (int k = 0; k < 3; k++) put(&at, &faces[i][k], 4, is_big);
    }
    return (size_t)(at - out);
}

static void ply_binary(void **state)
{
    (void)state;
    for (int is_big = 0; is_big < 2; is_big++) {
        char bytes[1024] = {0};
        struct mesh m;
        struct error err;
        struct mesh_options options = plain();
        size_t size = write_binary(bytes, is_big != 0);
        if (ply_load("m", bytes, size, &options, &arena, &m, &err) != LMN_OK)
            fail_msg("%s", err.text);
        check_ply(&m);
        /* Cut off anywhere, it is an error. */
        for (size_t cut = 0; cut < size; cut++) {
            char *part = malloc(cut + 1);
            assert_non_null(part);
            memcpy(part, bytes, cut);
            part[cut] = '\0';
            assert_int_equal(ply_load("m", part, cut, &options, &arena, &m, &err), LMN_ERR_PARSE);
            free(part);
        }
    }
}

static void check_attribute(const struct mesh *m, uint32_t i, const char *name, uint32_t n_channels,
                            bool is_of_faces, const float *values, size_t n)
{
    const struct mesh_attribute *a = &m->attributes[i];
    assert_string_equal(a->name, name);
    assert_int_equal(a->n_channels, n_channels);
    assert_int_equal(a->is_of_faces, is_of_faces);
    assert_floats(a->values, values, n);
}

/* Names as Mitsuba 3 makes them; a quad's values are those of both its triangles. */
static void ply_attributes(void **state)
{
    static const float colours[] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0.2f, 0.4f, 0.6f};
    static const float weights[] = {1, 2, 3, 4};
    static const float vectors[] = {.1f, .2f, .3f, .1f, .2f, .3f, .4f, .5f, .6f};
    static const float face_colours[] = {1, 0, 0, 1, 0, 0, 0, 1, 0};
    (void)state;
    struct mesh m = load(
        ply_load,
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "property list uchar int tags\nproperty float w_0\nproperty float pair_0\n"
        "property float pair_1\nelement face 2\nproperty float c_x\nproperty float c_y\n"
        "property float c_z\nproperty list uchar int vertex_indices\n"
        "property float r\nproperty float g\nproperty float b\nend_header\n"
        "0 0 0 255 0 0 2 7 8 1 5 5\n1 0 0 0 255 0 0 2 5 5\n1 1 0 0 0 255 0 3 5 5\n"
        "0 1 0 51 102 153 0 4 5 5\n.1 .2 .3 4 0 1 2 3 1 0 0\n.4 .5 .6 3 0 1 2 0 1 0\n",
        plain());
    assert_int_equal(m.n_triangles, 3);
    assert_int_equal(m.n_attributes, 4);
    check_attribute(&m, 0, "vertex_color", 3, false, colours, 12);
    check_attribute(&m, 1, "vertex_w", 1, false, weights, 4);
    check_attribute(&m, 2, "face_color", 3, true, face_colours, 9);
    check_attribute(&m, 3, "face_c", 3, true, vectors, 9);
}

static void ply_errors(void **state)
{
    static const struct bad_mesh bad[] = {
        {"plx\n", "m:1:4: not a PLY file"},
        {"ply\n", "m:2:1: the header does not end"},
        {"ply\nend_header\n", "m:3:1: the header names no format"},
        {"ply\nformat text 1.0\n",
         "m:2:12: unknown format; known are ascii, binary_little_endian and binary_big_endian"},
        {"ply\nfoo\n", "m:2:4: unknown line in the header"},
        {"ply\nproperty int x\n", "m:2:9: a property before any element"},
        {"ply\nelement vertex many\n", "m:2:20: an element needs a count"},
        {"ply\nelement vertex 1\nproperty half x\n", "m:3:14: unknown type of a property"},
        {"ply\nelement face 1\nproperty list float int vertex_indices\n",
         "m:3:20: unknown type of a list's length"},
        {"ply\nformat ascii 1.0\nelement vertex 999999999999999999\nproperty float x\n"
         "property float y\nproperty float z\nend_header\n0 0 0\n",
         "m:8:1: the file is cut off: it holds fewer records than its header says"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
         "m:6:1: vertices have no x, y, z"},
        {PLY_HEADER("ascii", "1") "0 0 0 7 0 0\n1 0 0 7 1 0\n1 1 0 7 1 1\n0 1 1 7 0 1\n3 0 1 4\n",
         "m:20:8: a vertex index is out of range"},
        {PLY_HEADER("ascii", "1") "0 0 0 7 0 0\n1 0 0 7 1 0\n1 1 0 7 1 1\n0 1 1 7 0 1\n3 0 1 -1\n",
         "m:20:9: a vertex index is out of range"},
        {PLY_HEADER("ascii", "1") "0 0 0 7 0 0\n1 0 0 7 1 0\n1 1 0 7 1 1\n0 1 1 7 0 1\n2 0 1\n",
         "m:20:2: a face needs three corners or more"},
        {PLY_HEADER("ascii", "0") "0 0 0 7 0 0\n1 0 0 7 1 0\n1 1 0 7 1 1\n0 1 1 7 0 1\n",
         "m: the mesh has no faces"},
        {PLY_HEADER("ascii",
                    "1") "0 0 0 7 0 0\n1 0 0 7 1 0\n1 1 zero 7 1 1\n0 1 1 7 0 1\n3 0 1 2\n",
         "m:18:5: the file is cut off, or what should be a number is none"},
    };
    (void)state;
    assert_bad(ply_load, bad, sizeof bad / sizeof *bad);
}

static void primitives(void **state)
{
    struct mesh m;
    struct error err;
    struct transform t = transform_identity(), mirror = transform_scale(vec3(-1, 1, 1));
    (void)state;
    assert_int_equal(mesh_rectangle(&t, &arena, &m, &err), LMN_OK);
    assert_int_equal(m.n_triangles, 2);
    assert_null(m.normals);
    assert_int_equal(mesh_rectangle(&mirror, &arena, &m, &err), LMN_OK);
    assert_float_equal(m.normals[2], 1.0f, 0.0f);

    /* Cube: every side's winding agrees with its normal and its texture covers [0,1]^2. */
    assert_int_equal(mesh_cube(&t, &arena, &m, &err), LMN_OK);
    assert_int_equal(m.n_triangles, 12);
    float area = 0;
    for (uint32_t i = 0; i < 12; i++) {
        struct vec3 p[3], n = {0};
        for (int k = 0; k < 3; k++) {
            const float *at = m.positions + 3 * m.indices[3 * i + (uint32_t)k];
            p[k] = vec3(at[0], at[1], at[2]);
            at = m.normals + 3 * m.indices[3 * i + (uint32_t)k];
            n = vec3(at[0], at[1], at[2]);
        }
        struct vec3 cross = vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));
        assert_float_equal(vec3_dot(cross, n), 4.0f, 0.0f);
        assert_float_equal(vec3_dot(p[0], n), 1.0f, 0.0f);
        area += 0.5f * vec3_length(cross);
    }
    assert_float_equal(area, 24.0f, 0.0f);
}

static void numbers(void **state)
{
    static const char *const texts[] = {"0",
                                        "-0.0",
                                        "1",
                                        "-12.5",
                                        ".5",
                                        "5.",
                                        "9.6e-008",
                                        "1E+5",
                                        "3.4028e38",
                                        "1.17549e-38",
                                        "1e-45",
                                        "0.1",
                                        "16777217",
                                        "123456.789",
                                        "1e22",
                                        "1e-22",
                                        "1.5e-30",
                                        "7.0064923216e-46",
                                        "0.30000001192092895507812500000000000000000",
                                        "12345678901234567890123",
                                        "1e-400"};
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        const char *at = texts[i];
        float f;
        assert_true(text_to_float(&at, &f));
        assert_int_equal(*at, '\0');
        float wanted = strtof(texts[i], NULL);
        if (memcmp(&f, &wanted, sizeof f) != 0)
            fail_msg("%s: %.9g is not %.9g", texts[i], (double)f, (double)wanted);
    }
    static const char *const bad[] = {"", "x", "-", ".", "e5", "nan", "inf", "1e39", "-1e400"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const char *at = bad[i];
        float f;
        assert_false(text_to_float(&at, &f));
        assert_ptr_equal(at, bad[i]);
    }
    const char *at = "-123/4";
    int n;
    assert_true(text_to_int(&at, &n));
    assert_int_equal(n, -123);
    assert_string_equal(at, "/4");
    at = "1234567890";
    assert_false(text_to_int(&at, &n));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(obj_normals_and_uvs, release_arena),
        cmocka_unit_test_teardown(obj_mirrored, release_arena),
        cmocka_unit_test_teardown(obj_lines, release_arena),
        cmocka_unit_test_teardown(obj_errors, release_arena),
        cmocka_unit_test_teardown(ply_ascii, release_arena),
        cmocka_unit_test_teardown(ply_binary, release_arena),
        cmocka_unit_test_teardown(ply_attributes, release_arena),
        cmocka_unit_test_teardown(ply_errors, release_arena),
        cmocka_unit_test_teardown(primitives, release_arena),
        cmocka_unit_test_teardown(numbers, release_arena),
    };
    return cmocka_run_group_tests_name("meshes", tests, NULL, NULL);
}
