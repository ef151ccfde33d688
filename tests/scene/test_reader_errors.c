/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_text.h"

/* Every message that a scene file can cause: one line with its place. */

struct bad {
    const char *body;    /* at line 2, column 1 */
    const char *message; /* the whole of it, after the path */
};

#define RECT(x)    TEXT_SENSOR "<shape type='rectangle'>" x "</shape>"
#define DIFFUSE(x) RECT("\n<bsdf type='diffuse'>\n" x "</bsdf>")
#define BSDF(x)    RECT("\n" x)

static const struct bad cases[] = {
    /* the document */
    {"<shap/>", ":2:1: unknown element <shap>; did you mean <shape>?"},
    {"<qwertz/>", ":2:1: unknown element <qwertz>"},
    {"<bsdf/>", ":2:1: <bsdf> needs a type"},
    {"<bsdf type='diffuse' colour='red'/>",
     ":2:1: <bsdf> has no attribute \"colour\"; it takes type id name "},
    {"text", ":2:1: unexpected text in <scene>"},
    {"<bsdf type='diffuse'>", ":3:3: mismatched tag"},
    {"<float name='a' value='1'/>", ":2:1: <float> has no place in <scene>"},
    {"<film type='hdrfilm'/>", ":2:1: <film> has no place in <scene>"},
    {"<medium type='homogeneous'/>", ":2:1: <medium> is not supported"},
    {"<bsdf type='diffuse' id='a'/>\n<bsdf type='diffuse' id='a'/>",
     ":3:1: the id \"a\" is taken: see %s:2:1"},
    {"<shape type='instance'><ref/></shape>", ":2:24: <ref> needs an id"},
    {"<float value='1'/>", ":2:1: <float> needs a name"},
    {"<bsdf type='diffuse'><rgb name='reflectance' value='$grey'/></bsdf>",
     ":2:22: undefined parameter \"grey\""},
    {"<default name='gray' value='1'/>\n<bsdf type='$grey'/>",
     ":3:1: undefined parameter \"grey\"; did you mean \"gray\"?"},
    {"<default name='a'/>", ":2:1: <default> needs \"value\""},
    {"<alias id='a' as='b'/>", ":2:1: <alias> to an unknown id \"a\""},
    {"<include filename='nowhere.xml'/>", ":2:1: no file \"nowhere.xml\""},
    {"<include filename='scene.xml'/>", ":2:1: \"%s\" includes itself"},
    {"", ": the scene has no sensor"},

    /* references */
    {DIFFUSE("<ref name='reflectance' id='wood'/>"), ":4:1: <ref> to an unknown id \"wood\""},
    {"<texture type='checkerboard' id='woods'/>\n<bsdf type='diffuse'>"
     "<ref name='reflectance' id='wood'/></bsdf>",
     ":3:22: <ref> to an unknown id \"wood\"; did you mean \"woods\"?"},
    {"<bsdf type='twosided' id='a'><ref id='a'/></bsdf>",
     ":2:1: <bsdf type=\"twosided\"> refers to itself"},
    {"<bsdf type='twosided' id='a'><ref id='b'/></bsdf>"
     "<bsdf type='twosided' id='b'><ref id='a'/></bsdf>",
     ":2:1: <bsdf type=\"twosided\"> refers to itself"},

    /* properties */
    {BSDF("<bsdf type='roughconductor'>\n<float name='roughnes' value='.1'/></bsdf>"),
     ":4:1: <float name=\"roughnes\">: unknown property of <bsdf type=\"roughconductor\">; did you "
     "mean \"alpha\"?"},
    {BSDF("<bsdf type='roughconductor'>\n<float name='weight' value='.1'/></bsdf>"),
     ":4:1: <float name=\"weight\">: unknown property of <bsdf type=\"roughconductor\">"},
    {BSDF("<bsdf type='roughconductor'>\n<float name='alpa' value='.1'/></bsdf>"),
     ":4:1: <float name=\"alpa\">: unknown property of <bsdf type=\"roughconductor\">; did you "
     "mean \"alpha\"?"},
    {DIFFUSE("<rgb name='reflectance' value='1'/>\n<rgb name='reflectance' value='0'/>"),
     ":5:1: <rgb name=\"reflectance\">: given twice"},
    {DIFFUSE("<rgb name='reflectance' value='1 2'/>"), ":4:1: <rgb> takes one or three numbers"},
    {DIFFUSE("<rgb name='reflectance' value='1 x 3'/>"),
     ":4:1: <rgb> value: \"x\" is not a number"},
    {DIFFUSE("<rgb name='reflectance' value='nan'/>"),
     ":4:1: <rgb> value: \"nan\" is not a number"},
    {DIFFUSE("<rgb name='reflectance' value='1e39'/>"),
     ":4:1: <rgb> value: \"1e39\" is not a number"},
    {DIFFUSE("<rgb name='reflectance' value='1 2 3 4'/>"),
     ":4:1: <rgb> value: more than 3 numbers"},
    {DIFFUSE("<rgb name='reflectance'/>"), ":4:1: <rgb> value: a number is missing"},
    {DIFFUSE("<rgb name='reflectance' value='-1'/>"), ":4:1: \"reflectance\" must not be negative"},
    {DIFFUSE("<rgb name='reflectance' value='#12345'/>"),
     ":4:1: <rgb>: \"#12345\" is not a colour like #ff8000"},
    {DIFFUSE("<spectrum name='reflectance' value='400:1, 500'/>"),
     ":4:1: <spectrum> needs pairs of wavelength and value, two or more"},
    {DIFFUSE("<spectrum name='reflectance' value='1 2 3'/>"),
     ":4:1: <spectrum> takes one number; use <rgb> for a colour"},
    {DIFFUSE("<string name='reflectance' value='red'/>"),
     ":4:1: <string name=\"reflectance\">: expected a number, a colour or a texture"},
    {DIFFUSE("<ref id='r'/>") "<bsdf type='conductor' id='r'/>",
     ":4:1: <ref id=\"r\"> has no place in <bsdf type=\"diffuse\">"},
    {DIFFUSE("<emitter type='area'/>"),
     ":4:1: <emitter type=\"area\"> has no place in <bsdf type=\"diffuse\">"},
    {BSDF("<bsdf type='plastic'><string name='nonlinear' value='true'/></bsdf>"),
     ":3:22: <string name=\"nonlinear\">: expected a <boolean>"},
    {BSDF("<bsdf type='plastic'><boolean name='nonlinear' value='yes'/></bsdf>"),
     ":3:22: \"nonlinear\" must be true or false, not \"yes\""},

    /* transforms */
    {RECT("\n<transform name='to_world'><rotate angle='1'/></transform>"),
     ":3:28: <rotate> needs an axis"},
    {RECT("\n<transform name='to_world'><scale x='0'/></transform>"),
     ":3:28: <scale> by zero has no inverse"},
    {RECT("\n<transform name='to_world'><matrix value='1 2 3'/></transform>"),
     ":3:28: <matrix> needs 16 or 9 numbers, not 3"},
    {RECT("\n<transform name='to_world'><matrix value='1 0 0 0 0 0 0 0 1'/></transform>"),
     ":3:28: <matrix> is singular"},
    {RECT("\n<transform name='to_world'><matrix value='1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1'/>"
          "</transform>"),
     ":3:28: <matrix>: the last row must be 0 0 0 1"},
    {RECT("\n<transform name='to_world'><lookat origin='0 0 0' target='0 0 0'/></transform>"),
     ":3:28: <lookat>: origin and target are equal"},
    {RECT("\n<transform name='to_world'><lookat origin='0 0 0' target='0 1 0' up='0 1 0'/>"
          "</transform>"),
     ":3:28: <lookat>: up is parallel to the view direction"},
    {RECT("\n<transform name='to_world'><rgb name='a' value='1'/></transform>"),
     ":3:28: <rgb> cannot be part of a <transform>"},
    {RECT("\n<transform name='to_world'><translate value='1 2'/></transform>"),
     ":3:28: <translate> needs three numbers"},
    {RECT("\n<transform name='to_world'><scale value='1e20'/><scale value='1e18'/></transform>"),
     ":3:1: <transform> is singular or overflows"},

    /* materials */
    {"<bsdf type='difuse'/>", ":2:1: unknown bsdf \"difuse\"; did you mean \"diffuse\"?"},
    {"<bsdf type='ward'/>", ":2:1: <bsdf type=\"ward\"> is not supported yet"},
    {"<bsdf type='blendbsdf'><bsdf type='diffuse'/></bsdf>",
     ":2:1: blendbsdf needs two nested <bsdf>"},
    {"<bsdf type='bumpmap'><bsdf type='diffuse'/></bsdf>",
     ":2:1: bumpmap needs a nested <texture>"},
    {"<bsdf type='normalmap'><rgb name='normalmap' value='.5 .5 1'/></bsdf>",
     ":2:1: <bsdf type=\"normalmap\"> needs a nested <bsdf>"},
    {"<bsdf type='principled'><float name='eta' value='1.5'/><float name='specular' value='.5'/>"
     "</bsdf>",
     ":2:1: either \"eta\" or \"specular\""},
    {"<bsdf type='principled'><float name='metalic' value='1'/></bsdf>",
     ":2:25: <float name=\"metalic\">: unknown property of <bsdf type=\"principled\">; did you "
     "mean "
     "\"metallic\"?"},
    {"<bsdf type='dielectric'><float name='ext_ior' value='3e38'/></bsdf>",
     ":2:1: int_ior / ext_ior must be from 0.001 to 1000"},
    {"<bsdf type='principled'><float name='eta' value='1e30'/></bsdf>",
     ":2:1: \"eta\" must be from 0.001 to 1000"},
    {"<bsdf type='roughplastic'><float name='int_ior' value='1.000277'/></bsdf>",
     ":2:1: roughplastic needs int_ior different from ext_ior"},
    {"<bsdf type='mixturebsdf'><string name='weights' value='1, 2'/><bsdf type='diffuse'/></bsdf>",
     ":2:26: 2 weights for 1 materials"},
    {"<bsdf type='mixturebsdf'><bsdf type='diffuse'/></bsdf>",
     ":2:1: mixturebsdf needs \"weights\""},
    {"<bsdf type='phong'><float name='exponent' value='-1'/></bsdf>",
     ":2:20: \"exponent\" must not be negative"},
    {"<bsdf type='roughconductor'><string name='distribution' value='gxx'/></bsdf>",
     ":2:29: unknown distribution \"gxx\"; did you mean \"ggx\"?"},
    {"<bsdf type='roughconductor'><float name='alpha' value='1'/><float name='alpha_u' "
     "value='1'/></bsdf>",
     ":2:1: either \"alpha\" or \"alpha_u\" and \"alpha_v\""},
    {"<bsdf type='conductor'><string name='material' value='Xy'/></bsdf>",
     ":2:1: unknown material \"Xy\""},
    {"<bsdf type='conductor'><string name='material' value='Cu'/><rgb name='k' value='1'/></bsdf>",
     ":2:1: either \"material\" or \"eta\" and \"k\""},
    {"<bsdf type='dielectric'><string name='int_ior' value='watr'/></bsdf>",
     ":2:1: unknown substance \"watr\"; did you mean \"water\"?"},
    {"<bsdf type='dielectric'><float name='int_ior' value='0'/></bsdf>",
     ":2:25: \"int_ior\" must be above 0"},
    {"<bsdf type='roughdielectric'><float name='int_ior' value='1'/><float name='ext_ior' "
     "value='1'/></bsdf>",
     ":2:1: roughdielectric needs int_ior different from ext_ior"},
    {"<bsdf type='twosided'/>", ":2:1: <bsdf type=\"twosided\"> needs a nested <bsdf>"},
    {"<bsdf type='mask'/>", ":2:1: <bsdf type=\"mask\"> needs a nested <bsdf>"},
    {TEXT_SENSOR "\n<bsdf type='twosided'><bsdf type='dielectric'/></bsdf>",
     ":3:1: twosided: only materials without transmission can be nested in it"},

    /* textures */
    {"<texture type='bitmp'/>", ":2:1: unknown texture \"bitmp\"; did you mean \"bitmap\"?"},
    {"<texture type='volume'/>", ":2:1: <texture type=\"volume\"> is not supported yet"},
    {"<texture type='bitmap'/>", ":2:1: bitmap needs a \"filename\""},
    {"<texture type='bitmap'><string name='filename' value='no.png'/></texture>",
     ":2:1: no file \"no.png\""},
    {"<texture type='bitmap'><string name='filename' value=''/></texture>",
     ":2:1: the file name is empty"},
    {"<texture type='bitmap'><string name='filename' value='a'/><string name='wrap_mode' "
     "value='clmp'/></texture>",
     ":2:59: unknown wrap_mode \"clmp\"; did you mean \"clamp\"?"},

    /* emitters */
    {"<emitter type='collimated'/>", ":2:1: <emitter type=\"collimated\"> is not supported yet"},
    {"<emitter type='aria'/>", ":2:1: unknown emitter \"aria\"; did you mean \"area\"?"},
    {"<emitter type='envmap'/>", ":2:1: envmap needs a \"filename\""},
    {"<emitter type='area'><transform name='to_world'/></emitter>",
     ":2:1: an area emitter has no \"to_world\": its shape has"},
    {"<emitter type='point'><transform name='to_world'/><point name='position' x='1'/></emitter>",
     ":2:1: either \"position\" or \"to_world\""},
    {"<emitter type='constant'><texture type='checkerboard' name='radiance'/></emitter>",
     ":2:1: <emitter type=\"constant\">: it takes a colour, not a texture"},
    {"<emitter type='constant'/>\n<emitter type='constant'/>",
     ":3:1: a scene can have one environment (constant, envmap); another one is at line 2"},
    {RECT("<emitter type='point'/>"),
     ":2:29: shape \"rectangle\": only an area emitter can be on it"},

    /* shapes */
    {"<shape type='spher'/>", ":2:1: unknown shape \"spher\"; did you mean \"sphere\"?"},
    {"<shape type='heightfield'/>", ":2:1: <shape type=\"heightfield\"> is not supported yet"},
    {"<shape type='serialized'/>", ":2:1: serialized needs a \"filename\""},
    {"<shape type='obj'/>", ":2:1: obj needs a \"filename\""},
    {"<shape type='obj'><string name='filename' value='no.obj'/></shape>",
     ":2:1: no file \"no.obj\""},
    {"<shape type='sphere'><float name='radius' value='-1'/></shape>",
     ":2:22: \"radius\" must be above 0"},
    {"<shape type='sphere'><transform name='to_world'><scale x='2'/></transform></shape>",
     ":2:1: a sphere that is scaled non-uniformly is not supported"},
    {"<shape type='shapegroup'/>", ":2:1: the shapegroup is empty"},
    {"<shape type='shapegroup'>\n<shape type='instance'/></shape>",
     ":3:1: a shapegroup cannot hold a instance"},
    {"<shape type='instance'/>", ":2:1: an instance needs a <ref> to a shapegroup"},
    {"<shape type='sphere' id='s'/><shape type='instance'><ref id='s'/></shape>",
     ":2:30: an instance needs a <ref> to a shapegroup"},
    {RECT("<bsdf type='diffuse'/><bsdf type='diffuse'/>"),
     ":2:75: <bsdf type=\"diffuse\"> has no place in <shape type=\"rectangle\">"},

    /* sensor, film, integrator */
    {"<sensor type='distant'/>", ":2:1: <sensor type=\"distant\"> is not supported yet"},
    {"<sensor type='thinlens'/>", ":2:1: thinlens needs an \"aperture_radius\""},
    {"<sensor type='orthographic'><transform name='to_world'><matrix value='1 1 0 0 1 0 0 0 1'/>"
     "</transform></sensor>",
     ":2:1: the sensor's to_world must not shear"},
    {"<sensor type='perspective'><film type='hdrfilm'><integer name='crop_offset_x' value='700'/>"
     "<integer name='crop_width' value='70'/></film></sensor>",
     ":2:92: \"crop_width\" must be from 1 to 68"},
    {"<sensor type='perspectiv'/>",
     ":2:1: unknown sensor \"perspectiv\"; did you mean \"perspective\"?"},
    {"<sensor type='perspective'><float name='fov' value='180'/></sensor>",
     ":2:1: \"fov\" must be below 180 degrees"},
    {"<sensor type='perspective'><string name='focal_length' value='wide'/></sensor>",
     ":2:1: focal_length \"wide\" is not like \"50mm\""},
    {"<sensor type='perspective'><transform name='to_world'><scale x='2'/></transform></sensor>",
     ":2:1: the sensor's to_world must not scale or shear"},
    {"<sensor type='perspective'><float name='near_clip' value='1e5'/></sensor>",
     ":2:1: \"near_clip\" must be below \"far_clip\""},
    {"<sensor type='perspective'><float name='near_clip' value='1e20'/>"
     "<float name='far_clip' value='1e30'/></sensor>",
     ":2:1: \"near_clip\" must not be above 1e+06"},
    {"<sensor type='thinlens'><float name='aperture_radius' value='1e20'/></sensor>",
     ":2:1: \"aperture_radius\" must be from 0 to 1e+06"},
    {"<sensor type='thinlens'><float name='aperture_radius' value='1'/>"
     "<float name='focus_distance' value='1e-20'/></sensor>",
     ":2:1: \"focus_distance\" must be from 1e-06 to 1e+12"},
    {"<sensor type='perspective'><float name='principal_point_offset_x' value='-1e20'/></sensor>",
     ":2:1: the principal point is more than 1000 films aside"},
    {"<emitter type='spot'><float name='cutoff_angle' value='180'/></emitter>",
     ":2:1: \"cutoff_angle\" must be below 180 degrees"},
    {"<emitter type='spot'><float name='beam_width' value='21'/></emitter>",
     ":2:1: \"beam_width\" must be between 0 and \"cutoff_angle\""},
    {"<emitter type='directional'><vector name='direction' value='0 0 0'/></emitter>",
     ":2:1: \"direction\" has no length"},
    {"<emitter type='sunsky'><float name='turbidity' value='11'/></emitter>",
     ":2:1: \"turbidity\" must be from 1 to 10"},
    {"<emitter type='sunsky'><integer name='month' value='13'/></emitter>",
     ":2:24: \"month\" must be from 1 to 12"},
    {"<sensor type='perspective'><sampler type='sobl'/></sensor>",
     ":2:28: unknown sampler \"sobl\"; did you mean \"sobol\"?"},
    {"<sensor type='perspective'><sampler type='sobol'><integer name='sample_count' "
     "value='1.5'/></sampler></sensor>",
     ":2:50: \"sample_count\" must be a whole number"},
    {"<sensor type='perspective'><film type='hdrfilm'><integer name='width' value='0'/></film>"
     "</sensor>",
     ":2:49: \"width\" must be from 1 to 32768"},
    {"<sensor type='perspective'><film type='hdrfilm'><rfilter type='bx'/></film></sensor>",
     ":2:49: unknown rfilter \"bx\"; did you mean \"box\"?"},
    {"<integrator type='depth'/>", ":2:1: <integrator type=\"depth\"> is not supported yet"},
    {"<integrator type='pth'/>", ":2:1: unknown integrator \"pth\"; did you mean \"path\"?"},
    {"<integrator type='path'><integer name='max_depth' value='-2'/></integrator>",
     ":2:25: \"max_depth\" must be from -1 to 2147483647"},
    {"<integrator type='path'/>\n<integrator type='path'/>",
     ":3:1: a scene can have one <integrator>"},
};

static void messages(void **state)
{
    size_t n_wrong = 0;
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene *s;
        struct error err;
        char wanted[768], tail[400];
        lmn_status status = text_load(cases[i].body, &s, &err);
        const char *path = text_path("scene.xml");
        snprintf(tail, sizeof tail, cases[i].message, path);
        snprintf(wanted, sizeof wanted, "%s%s", path, tail);
        if (status == LMN_ERR_PARSE && strcmp(err.text, wanted) == 0) continue;
        print_error("case %zu, status %d\n  wanted: %s\n  got:    %s\n", i, (int)status, wanted,
                    err.text);
        scene_free(s);
        n_wrong++;
    }
    assert_int_equal(n_wrong, 0);
}

/* Whole files that text_load() cannot write. */
static void documents(void **state)
{
    static const struct bad files[] = {
        {"", ":1:1: no element found"},
        {"<scene/>", ":1:1: <scene> needs a version, as in \"3.0.0\""},
        {"<scene version='3'/>", ":1:1: version \"3\" is not like \"3.0.0\""},
        {"<scene version='4.0.0'/>", ":1:1: version 4 is not known; 3 is the newest"},
        {"<shape type='cube'/>", ":1:1: the root element must be <scene>, not <shape>"},
        {"<scene version='3.0.0'><bsdf", ":1:24: unclosed token"},
        {"<!DOCTYPE a [<!ENTITY b 'c'>]><scene version='3.0.0'/>",
         ":1:25: entity declarations (\"b\") are not allowed"},
        {"<?xml version='1.0' encoding='EBCDIC'?><scene version='3.0.0'/>",
         ":1:31: unknown encoding"},
    };
    struct scene *s;
    struct error err;
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char wanted[512];
        text_write_string("file.xml", files[i].body);
        assert_int_equal(text_load_file("file.xml", NULL, &s, &err), LMN_ERR_PARSE);
        snprintf(wanted, sizeof wanted, "%s%s", text_path("file.xml"), files[i].message);
        assert_string_equal(err.text, wanted);
    }
    assert_int_equal(text_load_file("absent.xml", NULL, &s, &err), LMN_ERR_IO);
    assert_non_null(strstr(err.text, "absent.xml: cannot open"));
}

/* a includes b, b includes a; and a chain that is too long. */
static void include_cycles(void **state)
{
    struct scene *s;
    struct error err;
    char name[32], text[128];
    (void)state;
    text_write_string("a.xml", "<scene version='3.0.0'><include filename='b.xml'/></scene>");
    text_write_string("b.xml", "<scene version='3.0.0'>\n<include filename='a.xml'/></scene>");
    assert_int_equal(text_load_file("a.xml", NULL, &s, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "b.xml:2:1: "));
    assert_non_null(strstr(err.text, "a.xml\" includes itself"));
    for (int i = 0; i < 30; i++) {
        snprintf(name, sizeof name, "c%d.xml", i);
        snprintf(text, sizeof text, "<scene version='3.0.0'><include filename='c%d.xml'/></scene>",
                 i + 1);
        text_write_string(name, text);
    }
    assert_int_equal(text_load_file("c0.xml", NULL, &s, &err), LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, "includes are nested deeper than 16"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(messages),
        cmocka_unit_test(documents),
        cmocka_unit_test(include_cycles),
    };
    return cmocka_run_group_tests_name("scene reader errors", tests, text_setup, text_teardown);
}
