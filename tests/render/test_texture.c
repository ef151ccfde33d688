/* SPDX-License-Identifier: Apache-2.0 */
/* Textures against what they should be at places that can be worked out by hand. */
#include <math.h>

#include "base/rng.h"
#include "render/texture.h"
#include "scene/mesh.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

static float decode[2][256];

static int setup(void **state)
{
    (void)state;
    texture_decode_init(decode);
    return 0;
}

static struct texture plain(enum texture_kind kind)
{
    return (struct texture){
        .kind = kind, .value = {1, 1, 1}, .to_uv = {{1, 0, 0}, {0, 1, 0}}, .bitmap = 0};
}

static struct vec3 at(const struct texture_set *set, float u, float v)
{
    return texture_eval(set, 0, u, v);
}

static void assert_colour(struct vec3 c, float r, float g, float b)
{
    if (!(fabsf(c.x - r) < 1e-5f && fabsf(c.y - g) < 1e-5f && fabsf(c.z - b) < 1e-5f))
        fail_msg("%g %g %g instead of %g %g %g", (double)c.x, (double)c.y, (double)c.z, (double)r,
                 (double)g, (double)b);
}

/* Lines lie on whole numbers, to both sides. */
static void grid(void **state)
{
    (void)state;
    struct texture t = plain(TEXTURE_GRID);
    struct texture_set set = {.textures = &t, .decode = (const float(*)[256])decode};
    t.color0 = vec3(0.2f, 0.3f, 0.4f);
    t.color1 = vec3(1, 0, 0);
    t.value = vec3(1, 1, 0.5f);
    t.line_width = 0.1f;
    assert_colour(at(&set, 0.5f, 0.5f), 0.2f, 0.3f, 0.2f);
    assert_colour(at(&set, 0.05f, 0.5f), 1, 0, 0);
    assert_colour(at(&set, 0.95f, 0.5f), 1, 0, 0);
    assert_colour(at(&set, 0.5f, -3.05f), 1, 0, 0);
    assert_colour(at(&set, 0.15f, 7.85f), 0.2f, 0.3f, 0.2f);
    t.to_uv[0][0] = 2; /* twice as many */
    assert_colour(at(&set, 0.5f, 0.5f), 1, 0, 0);
    /* 64 % of a cell is free of lines. */
    float free_part = 0.64f * (0.2f + 0.3f + 0.2f) / 3, lines = 0.36f / 3;
    assert_true(fabsf(texture_mean(&set, 0) - free_part - lines) < 1e-5f);
}

/* The same picture as half floats and as floats; nearest and bilinear. */
static void half_floats(void **state)
{
    enum { W = 5, H = 3, N = W * H * 3 };
    uint16_t halves[N];
    float floats[N];
    (void)state;
    for (int i = 0; i < N; i++) {
        floats[i] = (float)(i * 37 % 64) * 0.125f;
        assert_true(half_from_float(floats[i], &halves[i]));
    }
    struct bitmap pictures[2] = {{.width = W, .height = H, .n_channels = 3, .f16 = halves},
                                 {.width = W, .height = H, .n_channels = 3, .f32 = floats}};
    struct texture t = plain(TEXTURE_BITMAP);
    struct texture_set a = {.textures = &t,
                            .bitmaps = &pictures[0],
                            .decode = (const float(*)[256])decode},
                       b = a;
    b.bitmaps = &pictures[1];
    for (int filter = 0; filter < 2; filter++) {
        t.filter = filter ? TEXTURE_NEAREST : TEXTURE_BILINEAR;
        for (int i = 0; i < 200; i++) {
            struct rng r = rng_keyed(1, (uint64_t)i, 0);
            float u = 4 * rng_float(&r) - 2, v = 4 * rng_float(&r) - 2;
            struct vec3 x = at(&a, u, v), y = at(&b, u, v);
            assert_true(x.x == y.x && x.y == y.y && x.z == y.z);
        }
    }
}

/* 16-bit pictures are decoded like 8-bit ones, unless they are raw. */
static void wide_pictures(void **state)
{
    float values[] = {0.02f, 0.5f, 1, 0.3f, 0.731f, 0};
    (void)state;
    struct bitmap picture = {
        .width = 2, .height = 1, .n_channels = 3, .f32 = values, .is_srgb = true};
    struct texture t = plain(TEXTURE_BITMAP);
    struct texture_set set = {
        .textures = &t, .bitmaps = &picture, .decode = (const float(*)[256])decode};
    t.filter = TEXTURE_NEAREST;
    for (int i = 0; i < 2; i++) {
        const float *p = values + 3 * i;
        float u = 0.25f + 0.5f * (float)i;
        t.is_raw = false;
        assert_colour(at(&set, u, 0.5f), srgb_decode(p[0]), srgb_decode(p[1]), srgb_decode(p[2]));
        t.is_raw = true;
        assert_colour(at(&set, u, 0.5f), p[0], p[1], p[2]);
    }
}

static void mesh_attributes(void **state)
{
    uint32_t indices[] = {0, 1, 2, 2, 1, 3};
    float colours[] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5f, 0.5f, 0.5f}, numbers[] = {2, 7};
    struct mesh_attribute list[] = {
        {"vertex_color", mesh_attribute_key("vertex_color"), colours, 3, false},
        {"face_n", mesh_attribute_key("face_n"), numbers, 1, true}};
    struct mesh mesh = {.indices = indices,
                        .n_vertices = 4,
                        .n_triangles = 2,
                        .attributes = list,
                        .n_attributes = 2};
    (void)state;
    struct texture t = plain(TEXTURE_MESH_ATTRIBUTE);
    struct texture_set set = {
        .textures = &t, .decode = (const float(*)[256])decode, .place = {&mesh, 0, 0.25f, 0.5f}};
    t.attribute = mesh_attribute_key("vertex_color");
    t.value = vec3_splat(2);
    assert_colour(at(&set, 9, 9), 0.5f, 0.5f, 1);
    set.place.triangle = 1; /* vertices 2, 1, 3 */
    assert_colour(at(&set, 9, 9), 0.5f, 1, 1);
    t.attribute = mesh_attribute_key("face_n");
    assert_colour(at(&set, 9, 9), 14, 14, 14);
    t.attribute = mesh_attribute_key("face_m");
    assert_colour(at(&set, 9, 9), 0, 0, 0);
    set.place.mesh = NULL;
    assert_colour(at(&set, 9, 9), 0, 0, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grid),
        cmocka_unit_test(half_floats),
        cmocka_unit_test(wide_pictures),
        cmocka_unit_test(mesh_attributes),
    };
    return cmocka_run_group_tests(tests, setup, NULL);
}
