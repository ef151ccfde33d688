/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_text.h"

#include <math.h>

/* What the generations of the format write differently: one scene said in the words of each, and
 * what only some of them have. */

static struct scene *load_file(const char *text)
{
    struct scene *s;
    struct error err;
    text_write_string("g.xml", text);
    if (text_load_file("g.xml", NULL, &s, &err) != LMN_OK) fail_msg("%s", err.text);
    return s;
}

static void assert_fails(const char *text, const char *message)
{
    struct scene *s;
    struct error err;
    text_write_string("g.xml", text);
    assert_int_not_equal(text_load_file("g.xml", NULL, &s, &err), LMN_OK);
    if (!strstr(err.text, message)) fail_msg("\"%s\" instead of \"%s\"", err.text, message);
}

static void assert_near(float a, double b)
{
    if (!(fabs((double)a - b) <= 1e-5 + 1e-4 * fabs(b))) fail_msg("%g instead of %g", (double)a, b);
}

static void assert_colour(struct vec3 c, double r, double g, double b)
{
    assert_near(c.x, r);
    assert_near(c.y, g);
    assert_near(c.z, b);
}

static const struct bsdf *bsdf_of(const struct scene *s, uint32_t shape)
{
    return &s->defaults.bsdfs[s->defaults.shape_bsdfs[shape]];
}

static struct vec3 value_of(const struct scene *s, uint32_t texture)
{
    return s->defaults.textures[texture].value;
}

/* ---- One scene, four ways -------------------------------------------------------------------- */

static const char *const generations[] = {
    /* 0.5 */
    "<scene version='0.5.0'><integrator type='path'><integer name='maxDepth' value='7'/>"
    "<boolean name='strictNormals' value='true'/></integrator>"
    "<sensor type='perspective'><string name='fovAxis' value='smaller'/>"
    "<float name='fov' value='35'/><float name='nearClip' value='0.5'/>"
    "<transform name='toWorld'><lookAt origin='0, 1, 5' target='0, 0, 0' up='0, 1, 0'/></transform>"
    "<sampler type='ldsampler'><integer name='sampleCount' value='32'/></sampler>"
    "<film type='ldrfilm'><integer name='width' value='40'/><integer name='height' value='30'/>"
    "<boolean name='banner' value='false'/><string name='tonemapMethod' value='reinhard'/>"
    "<rfilter type='box'/></film></sensor>"
    "<bsdf type='diffuse' id='m'><rgb name='diffuseReflectance' value='0.1, 0.2, 0.3'/></bsdf>"
    "<shape type='sphere'><point name='center' x='1' y='2' z='3'/>"
    "<float name='radius' value='0.5'/><boolean name='flipNormals' value='true'/>"
    "<transform name='toWorld'><scale value='2'/></transform><ref id='m'/></shape></scene>",
    /* 0.6 */
    "<scene version='0.6.0'><default name='n' value='32'/>"
    "<integrator type='bdpt'><integer name='maxDepth' value='7'/>"
    "<boolean name='lightImage' value='true'/></integrator>"
    "<sensor type='perspective'><string name='fovAxis' value='smaller'/>"
    "<float name='fov' value='35'/><float name='nearClip' value='0.5'/>"
    "<transform name='toWorld'><lookat origin='0, 1, 5' target='0, 0, 0' up='0, 1, 0'/></transform>"
    "<sampler type='halton'><integer name='sampleCount' value='$n'/></sampler>"
    "<film type='hdrfilm'><integer name='width' value='40'/><integer name='height' value='30'/>"
    "<float name='gamma' value='2.2'/><string name='label[10, 10]' value='x'/>"
    "<rfilter type='box'/></film></sensor>"
    "<bsdf type='diffuse' id='m'><spectrum name='reflectance' value='0.1, 0.2, 0.3'/></bsdf>"
    "<shape type='sphere'><point name='center' x='1' y='2' z='3'/>"
    "<float name='radius' value='0.5'/><boolean name='flipNormals' value='true'/>"
    "<transform name='toWorld'><matrix value='2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1'/></transform>"
    "<ref id='m'/></shape></scene>",
    /* 2.x */
    "<scene version='2.2.1'><integrator type='path'><integer name='max_depth' value='7'/>"
    "</integrator><sensor type='perspective'><string name='fov_axis' value='smaller'/>"
    "<float name='fov' value='35'/><float name='near_clip' value='0.5'/>"
    "<transform name='to_world'><lookat origin='0, 1, 5' target='0, 0, 0' up='0, 1, 0'/>"
    "</transform><sampler type='independent'><integer name='sample_count' value='32'/></sampler>"
    "<film type='hdrfilm'><integer name='width' value='40'/><integer name='height' value='30'/>"
    "<rfilter type='box'/></film></sensor>"
    "<bsdf type='diffuse' id='m'><rgb name='reflectance' value='0.1 0.2 0.3'/></bsdf>"
    "<shape type='sphere'><point name='center' value='1 2 3'/>"
    "<float name='radius' value='0.5'/><boolean name='flip_normals' value='true'/>"
    "<transform name='to_world'><scale x='2' y='2' z='2'/></transform><ref "
    "id='m'/></shape></scene>",
    /* 3.x */
    "<scene version='3.5.0'><default name='n' value='32'/><integrator type='volpath'>"
    "<integer name='max_depth' value='7'/></integrator><sensor type='perspective'>"
    "<string name='fov_axis' value='smaller'/><float name='fov' value='35'/>"
    "<float name='near_clip' value='0.5'/>"
    "<transform name='to_world'><lookat origin='0, 1, 5' target='0, 0, 0' up='0, 1, 0'/>"
    "</transform><sampler type='multijitter'><integer name='sample_count' value='$n'/></sampler>"
    "<film type='hdrfilm'><integer name='width' value='40'/><integer name='height' value='30'/>"
    "<rfilter type='box'/></film></sensor>"
    "<bsdf type='diffuse' id='m'><rgb name='reflectance' value='0.1, 0.2, 0.3'/></bsdf>"
    "<shape type='sphere'><point name='center' x='1' y='2' z='3'/>"
    "<float name='radius' value='0.5'/><boolean name='flip_normals' value='true'/>"
    "<transform name='to_world'><matrix value='2 0 0 0 2 0 0 0 2'/></transform>"
    "<ref id='m'/></shape></scene>"};

static void one_scene_four_ways(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof generations / sizeof *generations; i++) {
        struct scene *s = load_file(generations[i]);
        assert_int_equal(s->settings.max_depth, 7);
        assert_int_equal(s->settings.spp, 32);
        assert_int_equal(s->settings.width, 40);
        assert_int_equal(s->settings.height, 30);
        assert_int_equal(s->settings.filter, FILTER_BOX);
        assert_int_equal(s->defaults.sensor.fov_axis, FOV_SMALLER);
        assert_near(s->defaults.sensor.fov, 35);
        assert_near(s->defaults.sensor.near_clip, 0.5);
        assert_near(s->defaults.sensor.to_world.m[1][3], 1);
        assert_near(s->defaults.sensor.to_world.m[2][3], 5);
        assert_colour(value_of(s, bsdf_of(s, 0)->reflectance), 0.1, 0.2, 0.3);
        assert_near(s->bounds.min.x, 1);
        assert_near(s->bounds.max.z, 7);
        assert_true(s->shapes[0].flip_normals);
        scene_free(s);
    }
}

/* Old names in new files and the other way round. */
static void names_of_another_version(void **state)
{
    (void)state;
    struct scene *s = load_file(
        "<scene version='3.0.0'><sensor type='perspective'><transform name='toWorld'>"
        "<translate x='2'/></transform></sensor><shape type='sphere'>"
        "<boolean name='flipNormals' value='true'/><bsdf type='dielectric'>"
        "<float name='intIOR' value='1.5'/><float name='extIOR' "
        "value='1'/></bsdf></shape></scene>");
    assert_near(s->defaults.sensor.to_world.m[0][3], 2);
    assert_near(bsdf_of(s, 0)->eta, 1.5);
    assert_true(s->shapes[0].flip_normals);
    scene_free(s);
    s = load_file("<scene version='0.5.0'><sensor type='perspective'><transform name='to_world'>"
                  "<translate x='2'/></transform></sensor></scene>");
    assert_near(s->defaults.sensor.to_world.m[0][3], 2);
    scene_free(s);
    /* A version of two numbers. */
    s = load_file("<scene version='0.6'><sensor type='perspective'/></scene>");
    scene_free(s);
}

/* ---- Notes ----------------------------------------------------------------------------------- */

/* One note, with all that was ignored. */
static void ignored_things_are_told(void **state)
{
    static const char *const wanted[] = {"integrator \"sppm\": taken as path+photons (line 2)",
                                         "photon_count (line 3)",
                                         "k_nn (line 4)",
                                         "ldrfilm: taken as hdrfilm",
                                         "tonemap_method",
                                         "rfilter \"lanczos\": taken as gaussian",
                                         "mode (line 6)",
                                         "hide (line 7)"};
    (void)state;
    struct scene *s = load_file(
        "<scene version='0.6.0'>\n<integrator type='sppm'>\n"
        "<integer name='photonCount' value='5'/>\n"
        "<integer name='kNN' value='5'/></integrator>\n"
        "<sensor type='perspective'><film type='ldrfilm'>"
        "<string name='tonemapMethod' value='gamma'/>"
        "<rfilter type='lanczos'><integer name='lobes' value='3'/></rfilter>"
        "</film></sensor>\n<mode type='x'/>\n<hide/></scene>");
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++)
        if (!strstr(text_note, wanted[i])) fail_msg("\"%s\" is not in %s", wanted[i], text_note);
    assert_int_equal(s->settings.filter, FILTER_GAUSSIAN);
    scene_free(s);
}

static void wrapped_integrators(void **state)
{
    (void)state;
    struct scene *s = load_file(
        "<scene version='0.6.0'><sensor type='perspective'/><integrator type='adaptive'>"
        "<float name='maxError' value='5'/><integrator type='multichannel'>"
        "<integrator type='field'><string name='field' value='position'/></integrator>"
        "<integrator type='path'><integer name='maxDepth' value='3'/></integrator></integrator>"
        "</integrator></scene>");
    assert_int_equal(s->settings.max_depth, 3);
    assert_non_null(strstr(text_note, "max_error"));
    scene_free(s);
    assert_fails("<scene version='3.0.0'><integrator type='depth'/></scene>",
                 "<integrator type=\"depth\"> is not supported yet");
}

/* ---- Colours --------------------------------------------------------------------------------- */

/* As Mitsuba 3.9's scalar_rgb has them. */
static void colours(void **state)
{
    (void)state;
#define DIFFUSE(colour) "<shape type='sphere'><bsdf type='diffuse'>" colour "</bsdf></shape>"
    struct scene *s = load_file(
        "<scene version='3.0.0'><sensor type='perspective'/>" DIFFUSE(
            "<spectrum name='reflectance' value='400:.1, 500:.2, 600:.3, 700:.15'/>")
            DIFFUSE("<spectrum name='reflectance' value='500:1, 550:1'/>") DIFFUSE(
                "<spectrum name='reflectance' value='400:1 700:1'/>")
                DIFFUSE("<srgb name='reflectance' value='#8040ff'/>") DIFFUSE(
                    "<rgb name='reflectance' value='#8040ff'/>") "<shape type='sphere'><bsdf "
                                                                 "type='conductor'><spectrum "
                                                                 "name='eta' value='360:2, 830:2'/>"
                                                                 "<spectrum name='k' value='400:3, "
                                                                 "700:4'/></bsdf></shape>"
                                                                 "<shape type='sphere'><emitter "
                                                                 "type='area'>"
                                                                 "<spectrum name='radiance' "
                                                                 "value='400:2, "
                                                                 "700:3'/></emitter></shape></"
                                                                 "scene>");
    assert_colour(value_of(s, bsdf_of(s, 0)->reflectance), 0.28835, 0.246867, 0.140872);
    assert_colour(value_of(s, bsdf_of(s, 1)->reflectance), 0, 0.622833, 0);
    assert_colour(value_of(s, bsdf_of(s, 2)->reflectance), 0.995342, 0.999756, 0.994909);
    assert_colour(value_of(s, bsdf_of(s, 3)->reflectance), 0.215861, 0.0512695, 1);
    assert_colour(value_of(s, bsdf_of(s, 4)->reflectance), 128 / 255., 64 / 255., 1);
    assert_colour(value_of(s, bsdf_of(s, 5)->eta_texture), 1.99797, 1.99775, 1.9976);
    assert_colour(value_of(s, bsdf_of(s, 5)->k_texture), 3.79017, 3.47572, 3.12077);
    assert_colour(value_of(s, s->defaults.emitters[0].radiance), 3.33969, 2.35376, 1.92058);
    scene_free(s);

    /* From a file, with a comment. Its name is written as on Windows. */
    text_write_string("a.spd", "# nm value\n400 .1\n500 .2\n600 0.3 # red\n700 .15\n");
    s = load_file("<scene version='0.6.0'><sensor type='perspective'/>" DIFFUSE(
        "<spectrum name='reflectance' filename='.\\a.spd'/>") "</scene>");
    assert_colour(value_of(s, bsdf_of(s, 0)->reflectance), 0.28835, 0.246867, 0.140872);
    scene_free(s);

    /* A black body of 6504 K is about as white as D65; a colder one is red. */
    s = load_file("<scene version='0.6.0'><sensor type='perspective'/><emitter type='point'>"
                  "<blackbody name='intensity' temperature='6504K' scale='0.01'/></emitter>"
                  "<emitter type='point'><blackbody name='intensity' temperature='2700'/></emitter>"
                  "</scene>");
    struct vec3 white = value_of(s, s->defaults.emitters[0].radiance);
    struct vec3 red = value_of(s, s->defaults.emitters[1].radiance);
    assert_true(fabsf(white.x / white.y - 1) < 0.08f && fabsf(white.z / white.y - 1) < 0.08f);
    assert_true(red.x > 1.5f * red.y && red.y > 3 * red.z);
    /* Planck's law at 560 nm, where the observer is: 4.2e4 W / (m^2 sr nm). */
    assert_true(white.y > 390 && white.y < 450);
    scene_free(s);

    /* Spectra as plugins. */
    s = load_file("<scene version='3.0.0'><sensor type='perspective'/><emitter type='point'>"
                  "<spectrum type='d65' name='intensity'><rgb name='color' value='1, 2, 3'/>"
                  "<float name='scale' value='2'/></spectrum></emitter>" DIFFUSE(
                      "<spectrum type='uniform' name='reflectance'>"
                      "<float name='value' value='0.3'/></spectrum>") "</scene>");
    assert_colour(value_of(s, s->defaults.emitters[0].radiance), 2, 4, 6);
    assert_colour(value_of(s, bsdf_of(s, 0)->reflectance), 0.3, 0.3, 0.3);
    scene_free(s);

    assert_fails("<scene version='3.0.0'>" DIFFUSE(
                     "<spectrum name='reflectance' value='1, 2, 3'/>") "</scene>",
                 "<spectrum> takes one number");
    assert_fails("<scene version='3.0.0'>" DIFFUSE(
                     "<spectrum name='reflectance' value='400:1, 400:2'/>") "</scene>",
                 "wavelengths must increase");
    assert_fails("<scene version='3.0.0'>" DIFFUSE(
                     "<spectrum name='reflectance' value='400:1, 500'/>") "</scene>",
                 "needs pairs of wavelength and value");
    assert_fails("<scene version='3.0.0'>" DIFFUSE(
                     "<spectrum name='reflectance' value='400:nan, 500:1'/>") "</scene>",
                 "\"nan\" is not a number");
    assert_fails("<scene version='3.0.0'>" DIFFUSE(
                     "<blackbody name='reflectance' temperature='hot'/>") "</scene>",
                 "<blackbody> needs a temperature");
}

/* ---- Textures -------------------------------------------------------------------------------- */

static const struct texture *texture_of(const struct scene *s, uint32_t shape)
{
    return &s->defaults.textures[bsdf_of(s, shape)->reflectance];
}

static void textures_of_0_x(void **state)
{
    (void)state;
    text_write_string("p.pfm", "PF\n1 1\n-1\nabcdabcdabcd");
#define SCENE_06 "<scene version='0.6.0'><sensor type='perspective'/>"
    struct scene *s = load_file(
        SCENE_06 DIFFUSE(
            "<texture type='bitmap' name='reflectance'><string name='filename' value='p.pfm'/>"
            "<string name='filterType' value='ewa'/><string name='wrapModeU' value='clamp'/>"
            "<string name='wrapModeV' value='clamp'/><float name='gamma' value='1'/>"
            "<float name='uscale' value='3'/><float name='uoffset' value='0.5'/></texture>")
            DIFFUSE(
                "<texture type='checkerboard' name='reflectance'><float name='uvscale' value='4'/>"
                "<float name='vscale' value='2'/></texture>")
                DIFFUSE("<texture type='gridtexture' name='reflectance'>"
                        "<float name='lineWidth' value='0.1'/><rgb name='color1' value='1 0 "
                        "0'/></texture>")
                    DIFFUSE(
                        "<texture type='scale' name='reflectance'><float name='scale' value='0.5'/>"
                        "<texture type='checkerboard'/></texture>") "</scene>");
    const struct texture *t = texture_of(s, 0);
    assert_int_equal(t->filter, TEXTURE_BILINEAR);
    assert_int_equal(t->wrap, TEXTURE_CLAMP);
    assert_true(t->is_raw);
    assert_near(t->to_uv[0][0], 3);
    assert_near(t->to_uv[0][2], 1.5); /* as Mitsuba 3 reads it */
    t = texture_of(s, 1);
    assert_near(t->to_uv[0][0], 4);
    assert_near(t->to_uv[1][1], 2);
    t = texture_of(s, 2);
    assert_int_equal(t->kind, TEXTURE_GRID);
    assert_near(t->line_width, 0.1);
    assert_colour(t->color0, 0.2, 0.2, 0.2);
    assert_colour(t->color1, 1, 0, 0);
    t = texture_of(s, 3);
    assert_int_equal(t->kind, TEXTURE_CHECKERBOARD);
    assert_colour(t->value, 0.5, 0.5, 0.5);
    scene_free(s);

    assert_fails(
        SCENE_06 DIFFUSE(
            "<texture type='bitmap' name='reflectance'>"
            "<string name='filename' value='p.pfm'/><string name='wrapModeU' value='clamp'/>"
            "<string name='wrapModeV' value='mirror'/></texture>") "</scene>",
        "wrapModeU and wrapModeV that differ are not supported");
    assert_fails(SCENE_06 DIFFUSE("<texture type='scale' name='reflectance'/>") "</scene>",
                 "the texture \"scale\" needs another one in it");
    /* Newer files have other words. */
    assert_fails(
        "<scene version='3.0.0'>" DIFFUSE("<texture type='checkerboard' name='reflectance'>"
                                          "<float name='uscale' value='2'/></texture>") "</scene>",
        "unknown property");
}

/* Copper was the metal of conductors that name none. */
static void conductors_of_0_x(void **state)
{
    (void)state;
#define CONDUCTOR \
    "<sensor type='perspective'/><shape type='sphere'><bsdf type='conductor'/></shape>"
    struct scene *s = load_file("<scene version='0.6.0'>" CONDUCTOR "</scene>");
    assert_colour(value_of(s, bsdf_of(s, 0)->eta_texture), 0.201005, 0.92375, 1.10222);
    scene_free(s);
    s = load_file("<scene version='3.0.0'>" CONDUCTOR "</scene>");
    assert_colour(value_of(s, bsdf_of(s, 0)->eta_texture), 0, 0, 0);
    scene_free(s);
}

/* ---- Refused --------------------------------------------------------------------------------- */

static void refused_by_name(void **state)
{
    (void)state;
    assert_fails("<scene version='0.6.0'><shape type='sphere'><animation name='toWorld'/></shape>"
                 "</scene>",
                 "<animation> (motion within a picture) is not supported");
    assert_fails("<scene version='0.6.0'><medium type='homogeneous' id='m'/></scene>",
                 "<medium> is not supported");
    assert_fails("<scene version='0.6.0'><shape type='sphere'>"
                 "<medium type='homogeneous' name='interior'/></shape></scene>",
                 "<medium> is not supported");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_scene_four_ways),
        cmocka_unit_test(names_of_another_version),
        cmocka_unit_test(ignored_things_are_told),
        cmocka_unit_test(wrapped_integrators),
        cmocka_unit_test(colours),
        cmocka_unit_test(textures_of_0_x),
        cmocka_unit_test(conductors_of_0_x),
        cmocka_unit_test(refused_by_name),
    };
    return cmocka_run_group_tests_name("generations", tests, text_setup, text_teardown);
}
