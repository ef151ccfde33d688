/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_text.h"

#include <sys/resource.h>

#include "base/clock.h"
#include "base/rng.h"
#include "scene/mesh.h"

/* Seconds that a load may take. ThreadSanitizer makes memory ten times slower. */
#ifdef __SANITIZE_THREAD__
#define TIME_LIMIT 60.0
#else
#define TIME_LIMIT 5.0
#endif

/* Files that want to hurt: damaged bytes, absurd counts, deep nesting, short memory. What matters
 * is that nothing crashes, leaks or takes for ever (run it under ASan and UBSan), and that a
 * failure has a message. */

enum { N_MUTATIONS = 700 };

static const char seed_scene[] =
    "<scene version='3.0.0'><default name='r' value='0.5'/>\n"
    "<integrator type='path'><integer name='max_depth' value='6'/></integrator>"
    "<sensor type='perspective' id='var_cam'><float name='fov' value='40'/>"
    "<transform name='to_world'><lookat origin='0,1,5' target='0,0,0' up='0,1,0'/></transform>"
    "<film type='hdrfilm'><integer name='width' value='64'/><rfilter type='tent'/></film>"
    "<sampler type='independent'><integer name='sample_count' value='16'/></sampler>"
    "<vector name='min_bounds' value='1 2 3'/><vector name='range_bounds' value='1 2 3'/>"
    "<integer name='num_parameters' value='5'/></sensor>"
    "<bsdf type='twosided' id='m'><bsdf type='roughconductor'><float name='alpha' value='$r'/>"
    "<string name='material' value='Au'/></bsdf></bsdf>"
    "<texture type='checkerboard' id='t'><transform name='to_uv'><scale value='4'/></transform>"
    "</texture><bsdf type='diffuse' id='var_d'><ref name='reflectance' id='t'/></bsdf>"
    "<shape type='obj' id='o'><string name='filename' value='m.obj'/><ref id='m'/></shape>"
    "<shape type='ply'><string name='filename' value='m.ply'/><ref id='var_d'/></shape>"
    "<shape type='shapegroup' id='g'><shape type='sphere'><float name='radius' value='2'/>"
    "<emitter type='area'><rgb name='radiance' value='1 2 3'/></emitter></shape></shape>"
    "<shape type='instance' id='var_i'><ref id='g'/><vector name='min_bounds' value='0 0 0'/>"
    "<vector name='range_bounds' value='1 0 0'/><integer name='num_parameters' value='1'/></shape>"
    "<emitter type='point'><point name='position' value='1 2 3'/></emitter></scene>";

static const char seed_obj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1e-3\nvt 0 0\nvt 1 1\nvn 0 0 1\n"
                               "f 1/1/1 2/2/1 3//1\nf -1 -2 -3\nf 1 2 4 3\n";

static const char seed_ply[] =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/* Words of 0.6, spectra, and textures that refer to each other. */
static const char seed_old[] =
    "<scene version='0.6.0'><default name='k' value='5000'/>\n"
    "<integrator type='sppm'><integer name='maxDepth' value='6'/></integrator>"
    "<sensor type='perspective'><film type='ldrfilm'><float name='gamma' value='2.2'/>"
    "<rfilter type='lanczos'/></film></sensor>"
    "<texture type='bitmap' id='b'><string name='filename' value='p.hdr'/>"
    "<float name='uscale' value='3'/><string name='wrapMode' value='clamp'/></texture>"
    "<texture type='scale' id='s'><float name='scale' value='0.5'/><ref id='b'/></texture>"
    "<bsdf type='diffuse' id='m'><ref name='reflectance' id='s'/></bsdf>"
    "<bsdf type='diffuse' id='g'><texture type='gridtexture' name='reflectance'>"
    "<float name='lineWidth' value='0.1'/></texture></bsdf>"
    "<bsdf type='diffuse' id='c'><texture type='vertexcolors' name='reflectance'/></bsdf>"
    "<shape type='cylinder'><point name='p1' x='1' y='2' z='3'/><float name='radius' value='0.5'/>"
    "<ref id='m'/></shape>"
    "<shape type='ply'><string name='filename' value='a.ply'/><ref id='c'/></shape>"
    "<shape type='sphere'><ref id='g'/></shape>"
    "<shape type='disk'><emitter type='area'>"
    "<spectrum name='radiance' value='400:1, 500:2, 700:1.5'/></emitter></shape>"
    "<emitter type='point'><blackbody name='intensity' temperature='$k'/></emitter></scene>";

/* Attributes of vertices and of faces, lists in between. */
static const char seed_attributes[] =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "property list uchar int tags\nproperty float w_0\nelement face 2\nproperty float c_0\n"
    "property list uchar int vertex_indices\nproperty float c_1\nproperty float c_2\n"
    "property float r\nproperty float g\nproperty float b\nend_header\n"
    "0 0 0 255 0 0 2 7 8 1\n1 0 0 0 255 0 0 2\n1 1 0 0 0 255 0 3\n0 1 0 9 9 9 0 4\n"
    "1 4 0 1 2 3 2 3 0.1 0.2 0.3\n1 3 0 1 2 2 3 0.4 0.5 0.6\n";

static const char seed_hdr[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n"
                               "abc\x80zyx\x81klm\x7fpqr\x82";

static void write_seeds(void)
{
    text_write_string("old.xml", seed_old);
    text_write_string("a.ply", seed_attributes);
    text_write_string("p.hdr", seed_hdr);
    text_write_string("m.obj", seed_obj);
    text_write_string("m.ply", seed_ply);
    text_write_string("s.xml", seed_scene);
}

/* One to four changes: a byte set, a piece cut out, a piece doubled, or the end cut off. */
static size_t mutate(char *bytes, size_t size, size_t capacity, struct rng *r)
{
    static const char interesting[] = "\0\xff<>\"'/$-+.e9 \n0,#";
    uint32_t n = 1 + rng_below(r, 4);
    for (uint32_t i = 0; i < n && size > 0; i++) {
        size_t at = rng_below(r, (uint32_t)size), length = 1 + rng_below(r, 24);
        if (length > size - at) length = size - at;
        switch (rng_below(r, 5)) {
        case 0:
            bytes[at] = (char)rng_u32(r);
            break;
        case 1:
            bytes[at] = interesting[rng_below(r, sizeof interesting - 1)];
            break;
        case 2:
            memmove(bytes + at, bytes + at + length, size - at - length);
            size -= length;
            break;
        case 3:
            if (size + length > capacity) break;
            memmove(bytes + at + length, bytes + at, size - at);
            size += length;
            break;
        default:
            if (rng_below(r, 8) == 0) size = at;
        }
    }
    return size;
}

static void mutations_in(const char *scene, const char *name, const char *seed, uint64_t key)
{
    size_t n_loaded = 0;
    write_seeds();
    for (uint32_t i = 0; i < N_MUTATIONS; i++) {
        struct rng r = rng_keyed(key, i, 0);
        struct scene *s;
        struct error err;
        char bytes[8192];
        size_t size = strlen(seed);
        memcpy(bytes, seed, size);
        size = mutate(bytes, size, sizeof bytes, &r);
        text_write(name, bytes, size);
        lmn_status status = text_load_file(scene, NULL, &s, &err);
        if (status == LMN_OK) {
            n_loaded++;
        } else if (!err.text[0] || strchr(err.text, '\n') || s) {
            fail_msg("mutation %u of %s: status %d, \"%s\"", i, name, (int)status, err.text);
        }
        scene_free(s);
    }
    /* Else the seed itself is broken and nothing was tested. */
    assert_true(n_loaded > 0);
    assert_true(n_loaded < N_MUTATIONS);
}

static void mutations(const char *name, const char *seed, uint64_t key)
{
    mutations_in("s.xml", name, seed, key);
}

static void damaged_xml(void **state)
{
    (void)state;
    mutations("s.xml", seed_scene, 1);
}

static void damaged_obj(void **state)
{
    (void)state;
    mutations("m.obj", seed_obj, 2);
}

static void damaged_ply(void **state)
{
    (void)state;
    mutations("m.ply", seed_ply, 3);
}

static void damaged_old_xml(void **state)
{
    (void)state;
    mutations_in("old.xml", "old.xml", seed_old, 4);
}

static void damaged_attributes(void **state)
{
    (void)state;
    mutations_in("old.xml", "a.ply", seed_attributes, 5);
}

static void damaged_picture(void **state)
{
    (void)state;
    mutations_in("old.xml", "p.hdr", seed_hdr, 6);
}

/* Every allocation of a load fails once. */
static void short_memory_in(const char *name)
{
    write_seeds();
    for (uint64_t n = 1;; n++) {
        struct scene *s;
        struct error err;
        mem_fail_after(n);
        lmn_status status = text_load_file(name, NULL, &s, &err);
        mem_fail_after(0);
        if (status == LMN_OK) {
            scene_free(s);
            assert_true(n > 20);
            break;
        }
        if (status != LMN_ERR_MEMORY) fail_msg("allocation %d: %s", (int)n, err.text);
        assert_null(s);
    }
}

static void short_memory(void **state)
{
    (void)state;
    short_memory_in("s.xml");
    short_memory_in("old.xml");
}

/* Must fail with that in the message. */
static void assert_refused(const char *text, const char *message)
{
    struct scene *s;
    struct error err;
    text_write_string("r.xml", text);
    assert_int_not_equal(text_load_file("r.xml", NULL, &s, &err), LMN_OK);
    if (!strstr(err.text, message)) fail_msg("\"%s\" instead of \"%s\"", err.text, message);
}

#define SCENE(body) "<scene version='3.0.0'>" body "</scene>"

static void cycles_and_absurd_numbers(void **state)
{
    (void)state;
    assert_refused(SCENE("<texture type='scale' id='a'><ref id='b'/></texture>"
                         "<texture type='scale' id='b'><ref id='a'/></texture>"),
                   "refers to itself");
    assert_refused(SCENE("<bsdf type='mask' id='a'><ref id='a'/></bsdf>"), "refers to itself");
    assert_refused(SCENE("<shape type='cylinder'><float name='radius' value='1e30'/></shape>"),
                   "the cylinder is out of range");
    assert_refused(SCENE("<shape type='cylinder'><float name='radius' value='nan'/></shape>"),
                   "is not a number");
    assert_refused(SCENE("<shape type='cylinder'><float name='radius' value='-1'/></shape>"),
                   "must be above 0");
    assert_refused(SCENE("<shape type='cylinder'><point name='p1' value='0 0 0'/></shape>"),
                   "are equal");
    assert_refused(SCENE("<shape type='cylinder'><transform name='to_world'>"
                         "<scale x='2'/></transform></shape>"),
                   "no longer round");
    assert_refused(
        SCENE("<bsdf type='diffuse' id='d'><texture type='mesh_attribute' "
              "name='reflectance'><string name='name' value='vertex_x'/></texture></bsdf>"
              "<shape type='sphere'><ref id='d'/></shape>"),
        "the shape has no mesh attribute");
    assert_refused(
        SCENE("<shape type='cube'><emitter type='area'><texture type='mesh_attribute' "
              "name='radiance'><string name='name' value='vertex_x'/></texture></emitter>"
              "</shape>"),
        "light from a mesh attribute is not supported");
    assert_refused(SCENE("<integrator type='aov'><integrator type='aov'><integrator type='aov'>"
                         "<integrator type='aov'><integrator type='aov'><integrator type='aov'>"
                         "<integrator type='aov'><integrator type='aov'><integrator type='aov'>"
                         "<integrator type='path'/></integrator></integrator></integrator>"
                         "</integrator></integrator></integrator></integrator></integrator>"
                         "</integrator>"),
                   "integrators are nested too deep");
}

/* Small files that claim to be huge are refused, and take no memory. */
static void huge_claims(void **state)
{
    static const char tga[] = "\0\0\012\0\0\0\0\0\0\0\0\0\0\x20\0\x20\030\0xyz";
    static const char hdr[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 12000 +X 12000\nabcd";
    static const char bmp[] = "BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\0\x20\0\0\0\x20\0\0\1\0"
                              "\x18\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";
    static const char ply[] = "ply\nformat binary_little_endian 1.0\nelement vertex 268435455\n"
                              "property float x\nproperty float y\nproperty float z\n"
                              "property float r\nproperty float g\nproperty float b\n"
                              "element face 268435455\nproperty list uchar int vertex_indices\n"
                              "end_header\n0123456789";
    static const struct {
        const char *name, *bytes, *message;
        size_t size;
    } files[] = {{"h.tga", tga, "too short for 8192x8192 pixels", sizeof tga - 1},
                 {"h.hdr", hdr, "too short for 12000x12000 pixels", sizeof hdr - 1},
                 {"h.bmp", bmp, "too short for 8192x8192 pixels", sizeof bmp - 1},
                 {"h.ply", ply, "it holds fewer records than its header says", sizeof ply - 1}};
    struct rusage before, after;
    (void)state;
    getrusage(RUSAGE_SELF, &before);
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char text[256];
        bool is_mesh = strcmp(files[i].name, "h.ply") == 0;
        text_write(files[i].name, files[i].bytes, files[i].size);
        snprintf(text, sizeof text,
                 SCENE("<%s type='%s'><string name='filename' value='%s'/></%s>"),
                 is_mesh ? "shape" : "texture", is_mesh ? "ply" : "bitmap", files[i].name,
                 is_mesh ? "shape" : "texture");
        assert_refused(text, files[i].message);
    }
    getrusage(RUSAGE_SELF, &after);
    assert_true(after.ru_maxrss - before.ru_maxrss < 32 * 1024); /* KiB */
}

static void append(char **at, const char *text, int n)
{
    for (int i = 0; i < n; i++) {
        memcpy(*at, text, strlen(text));
        *at += strlen(text);
    }
}

/* Deep and wide documents end in an error or a scene, soon. */
static void depth_and_width(void **state)
{
    enum { SIZE = 8 << 20 };
    struct scene *s;
    struct error err;
    char *text = malloc(SIZE), *at = text;
    (void)state;
    assert_non_null(text);

    append(&at, "<scene version='3.0.0'>", 1);
    append(&at, "<bsdf type='twosided'>", 100000);
    text_write("s.xml", text, (size_t)(at - text));
    assert_int_equal(text_load_file("s.xml", NULL, &s, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "elements are nested deeper than 64"));

    /* Fans of references: 2^30 paths through 30 materials. */
    at = text;
    append(&at, "<scene version='3.0.0'><sensor type='perspective'/><bsdf type='diffuse' id='b0'/>",
           1);
    for (int i = 1; i < 30; i++)
        at += sprintf(at, "<bsdf type='twosided' id='b%d'><ref id='b%d'/><ref id='b%d'/></bsdf>", i,
                      i - 1, i - 1);
    append(&at, "</scene>", 1);
    text_write("s.xml", text, (size_t)(at - text));
    assert_int_equal(text_load_file("s.xml", NULL, &s, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "materials are nested deeper than 12"));

    /* A long chain of references in the wrong order. */
    at = text;
    append(&at, "<scene version='3.0.0'>", 1);
    for (int i = 0; i < 20000; i++)
        at += sprintf(at, "<bsdf type='twosided' id='b%d'><ref id='b%d'/></bsdf>", i, i + 1);
    append(&at, "<bsdf type='diffuse' id='b20000'/></scene>", 1);
    text_write("s.xml", text, (size_t)(at - text));
    assert_int_equal(text_load_file("s.xml", NULL, &s, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "objects are nested deeper than 64"));

    /* Values that double with every default. */
    at = text;
    append(&at, "<scene version='3.0.0'><default name='a0' value='xxxxxxxxxxxxxxxx'/>", 1);
    for (int i = 1; i < 64; i++)
        at += sprintf(at, "<default name='a%d' value='$a%d$a%d'/>", i, i - 1, i - 1);
    append(&at, "</scene>", 1);
    text_write("s.xml", text, (size_t)(at - text));
    assert_int_equal(text_load_file("s.xml", NULL, &s, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "a value is longer than"));

    at = text;
    append(&at, "<scene version='3.0.0'>", 1);
    for (int i = 0; i < 5000; i++) at += sprintf(at, "<default name='a%d' value='1'/>", i);
    append(&at, "</scene>", 1);
    text_write("s.xml", text, (size_t)(at - text));
    assert_int_equal(text_load_file("s.xml", NULL, &s, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "more than 4096 defaults"));

    /* Many shapes and instances, all of them made-up names. */
    at = text;
    append(&at,
           "<scene version='3.0.0'><sensor type='perspective'/>"
           "<shape type='shapegroup' id='g'><shape type='disk'/></shape>",
           1);
    append(&at, "<shape type='sphere'/>", 20000);
    append(&at, "<shape type='instance'><ref id='g'/></shape>", 20000);
    append(&at, "</scene>", 1);
    text_write("s.xml", text, (size_t)(at - text));
    double start = clock_cpu_s();
    assert_int_equal(text_load_file("s.xml", NULL, &s, &err), LMN_OK);
    assert_int_equal(s->n_shapes, 20001);
    assert_int_equal(s->n_instances, 20001);
    assert_true(clock_cpu_s() - start < TIME_LIMIT);
    scene_free(s);
    free(text);
}

/* Includes that include twice, again and again: 2^15 copies. */
static void include_bomb(void **state)
{
    struct scene *s;
    struct error err;
    char name[32], text[160];
    (void)state;
    for (int i = 0; i < 15; i++) {
        snprintf(name, sizeof name, "i%d.xml", i);
        snprintf(text, sizeof text,
                 "<scene version='3.0.0'><include filename='i%d.xml'/><include filename='i%d.xml'/>"
                 "</scene>",
                 i + 1, i + 1);
        text_write_string(name, text);
    }
    text_write_string("i15.xml", "<scene version='3.0.0'/>");
    assert_int_equal(text_load_file("i0.xml", NULL, &s, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "more than 4096 includes"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_xml),     cmocka_unit_test(damaged_obj),
        cmocka_unit_test(damaged_ply),     cmocka_unit_test(short_memory),
        cmocka_unit_test(damaged_old_xml), cmocka_unit_test(damaged_attributes),
        cmocka_unit_test(damaged_picture), cmocka_unit_test(cycles_and_absurd_numbers),
        cmocka_unit_test(huge_claims),     cmocka_unit_test(depth_and_width),
        cmocka_unit_test(include_bomb),
    };
    return cmocka_run_group_tests_name("hostile scenes", tests, text_setup, text_teardown);
}
