/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_text.h"

#include <math.h>

#include "scene/sun_position.h"

/* What the reader makes of each element and plugin. */

#define RECTANGLE_WITH(bsdf) TEXT_SENSOR "<shape type='rectangle' id='r'>" bsdf "</shape>"

static void assert_vec3(struct vec3 v, float x, float y, float z)
{
    const float tolerance = 2e-6f * (1.0f + fabsf(x) + fabsf(y) + fabsf(z));
    if (!(fabsf(v.x - x) <= tolerance && fabsf(v.y - y) <= tolerance &&
          fabsf(v.z - z) <= tolerance))
        fail_msg("(%.7g %.7g %.7g) is not (%.7g %.7g %.7g)", (double)v.x, (double)v.y, (double)v.z,
                 (double)x, (double)y, (double)z);
}

static void assert_close(float a, float b)
{
    if (!(fabsf(a - b) <= 1e-5f * (1.0f + fabsf(b))))
        fail_msg("%.8g is not %.8g", (double)a, (double)b);
}

/* The material of the first shape. */
static const struct bsdf *bsdf_of(const struct scene *s)
{
    return &s->defaults.bsdfs[s->defaults.shape_bsdfs[0]];
}

static struct vec3 value_of(const struct scene *s, uint32_t texture)
{
    assert_true(texture < s->n_textures);
    assert_int_equal(s->defaults.textures[texture].kind, TEXTURE_CONSTANT);
    return s->defaults.textures[texture].value;
}

/* ---- Colours ------------------------------------------------------------------------------- */

static void check_reflectance(const char *element, float x, float y, float z)
{
    char body[512];
    snprintf(body, sizeof body, RECTANGLE_WITH("<bsdf type='diffuse'>%s</bsdf>"), element);
    struct scene *s = text_scene(body);
    assert_vec3(value_of(s, bsdf_of(s)->reflectance), x, y, z);
    scene_free(s);
}

static void colours(void **state)
{
    (void)state;
    check_reflectance("", 0.5f, 0.5f, 0.5f);
    check_reflectance("<rgb name='reflectance' value='0.1, 0.2, 0.3'/>", 0.1f, 0.2f, 0.3f);
    check_reflectance("<rgb name='reflectance' value='.1 2e-1\t0.3'/>", 0.1f, 0.2f, 0.3f);
    check_reflectance("<rgb name='reflectance' value='0.25'/>", 0.25f, 0.25f, 0.25f);
    check_reflectance("<rgb name='reflectance' value='#ff8000'/>", 1.0f, 128.0f / 255.0f, 0.0f);
    check_reflectance("<spectrum name='reflectance' value='0.3'/>", 0.3f, 0.3f, 0.3f);
    check_reflectance("<float name='reflectance' value='9.6e-008'/>", 9.6e-8f, 9.6e-8f, 9.6e-8f);
}

static void light_spectra(void **state)
{
    /* Measured: Mitsuba 3.9.1, scalar_rgb, <spectrum value="5"/> as radiance. */
    (void)state;
    struct scene *s = text_scene(
        TEXT_SENSOR "<shape type='sphere'><emitter type='area'>"
                    "<spectrum name='radiance' value='5'/></emitter></shape>"
                    "<emitter type='point'><float name='intensity' value='5'/></emitter>");
    assert_int_equal(s->n_emitters, 2);
    assert_vec3(value_of(s, s->defaults.emitters[0].radiance), 6.02397f, 4.741455f, 4.54458f);
    assert_vec3(value_of(s, s->defaults.emitters[1].radiance), 5, 5, 5);
    scene_free(s);
}

/* ---- Transforms ---------------------------------------------------------------------------- */

/* Where the step puts the point (1, 2, 3). */
static void check_transform(const char *steps, float x, float y, float z)
{
    char body[1024];
    snprintf(body, sizeof body,
             TEXT_SENSOR "<shape type='shapegroup' id='g'><shape type='sphere'/></shape>"
                         "<shape type='instance'><ref id='g'/><transform name='to_world'>%s"
                         "</transform></shape>",
             steps);
    struct scene *s = text_scene(body);
    assert_int_equal(s->n_instances, 2);
    const struct transform *t = &s->defaults.instances[1].to_world;
    struct vec3 p = transform_point(t, vec3(1, 2, 3));
    assert_vec3(p, x, y, z);
    assert_vec3(transform_point_inverse(t, p), 1, 2, 3);
    scene_free(s);
}

static void transforms(void **state)
{
    (void)state;
    check_transform("", 1, 2, 3);
    check_transform("<translate x='1' z='-2'/>", 2, 2, 1);
    check_transform("<translate value='1, 0, -2'/>", 2, 2, 1);
    check_transform("<scale value='2'/>", 2, 4, 6);
    check_transform("<scale x='2' y='3'/>", 2, 6, 3);
    check_transform("<rotate z='1' angle='90'/>", -2, 1, 3);
    check_transform("<rotate value='0 0 5' angle='90'/>", -2, 1, 3);
    /* Later steps are applied later. */
    check_transform("<translate x='1'/><scale value='2'/>", 4, 4, 6);
    check_transform("<scale value='2'/><translate x='1'/>", 3, 4, 6);
    check_transform("<matrix value='1 0 0 5 0 0 -1 6 0 1 0 7 0 0 0 1'/>", 6, 3, 9);
    check_transform("<matrix value='0 1 0 0 0 1 1 0 0'/>", 2, 3, 1);
    /* +z looks at the target, +x is left, as Mitsuba's lookat. */
    check_transform("<lookat origin='0,0,10' target='0,0,0' up='0,1,0'/>", -1, 2, 7);
}

/* ---- Materials ----------------------------------------------------------------------------- */

static void smooth_materials(void **state)
{
    (void)state;
    struct scene *s = text_scene(RECTANGLE_WITH("<bsdf type='conductor'/>"));
    assert_int_equal(bsdf_of(s)->kind, BSDF_CONDUCTOR);
    assert_vec3(value_of(s, bsdf_of(s)->eta_texture), 0, 0, 0);
    assert_vec3(value_of(s, bsdf_of(s)->k_texture), 1, 1, 1);
    assert_int_equal(bsdf_of(s)->specular_reflectance, SCENE_NONE);
    scene_free(s);

    s = text_scene(RECTANGLE_WITH("<bsdf type='conductor'><string name='material' value='Cu'/>"
                                  "<rgb name='specular_reflectance' value='1 .5 0'/></bsdf>"));
    assert_vec3(value_of(s, bsdf_of(s)->eta_texture), 0.201005f, 0.92375f, 1.10222f);
    assert_vec3(value_of(s, bsdf_of(s)->k_texture), 3.91326f, 2.45305f, 2.14209f);
    assert_vec3(value_of(s, bsdf_of(s)->specular_reflectance), 1, 0.5f, 0);
    scene_free(s);

    s = text_scene(RECTANGLE_WITH("<bsdf type='dielectric'/>"));
    assert_int_equal(bsdf_of(s)->kind, BSDF_DIELECTRIC);
    assert_close(bsdf_of(s)->eta, 1.504183292f);
    scene_free(s);

    s = text_scene(RECTANGLE_WITH("<bsdf type='dielectric'><string name='int_ior' value='diamond'/>"
                                  "<float name='ext_ior' value='1'/></bsdf>"));
    assert_close(bsdf_of(s)->eta, 2.419f);
    scene_free(s);

    s = text_scene(RECTANGLE_WITH("<bsdf type='plastic'><boolean name='nonlinear' value='true'/>"
                                  "<rgb name='diffuse_reflectance' value='.1 .2 .3'/></bsdf>"));
    assert_int_equal(bsdf_of(s)->kind, BSDF_PLASTIC);
    assert_close(bsdf_of(s)->eta, 1.489587307f);
    assert_true(bsdf_of(s)->is_nonlinear);
    assert_vec3(value_of(s, bsdf_of(s)->reflectance), 0.1f, 0.2f, 0.3f);
    scene_free(s);
}

static void rough_materials(void **state)
{
    (void)state;
    struct scene *s = text_scene(RECTANGLE_WITH("<bsdf type='roughconductor'/>"));
    assert_int_equal(bsdf_of(s)->kind, BSDF_ROUGH_CONDUCTOR);
    assert_int_equal(bsdf_of(s)->distribution, MICROFACET_BECKMANN);
    assert_int_equal(bsdf_of(s)->alpha_u, bsdf_of(s)->alpha_v);
    assert_vec3(value_of(s, bsdf_of(s)->alpha_u), 0.1f, 0.1f, 0.1f);
    scene_free(s);

    s = text_scene(RECTANGLE_WITH("<bsdf type='roughdielectric'>"
                                  "<string name='distribution' value='ggx'/>"
                                  "<float name='alpha_u' value='.2'/>"
                                  "<float name='alpha_v' value='.3'/></bsdf>"));
    assert_int_equal(bsdf_of(s)->kind, BSDF_ROUGH_DIELECTRIC);
    assert_int_equal(bsdf_of(s)->distribution, MICROFACET_GGX);
    assert_close(value_of(s, bsdf_of(s)->alpha_u).x, 0.2f);
    assert_close(value_of(s, bsdf_of(s)->alpha_v).x, 0.3f);
    scene_free(s);
}

static void nested_materials(void **state)
{
    (void)state;
    struct scene *s = text_scene(RECTANGLE_WITH("<bsdf type='twosided'><bsdf type='diffuse'/>"
                                                "<bsdf type='conductor'/></bsdf>"));
    const struct bsdf *f = bsdf_of(s);
    assert_int_equal(f->kind, BSDF_TWOSIDED);
    assert_int_equal(s->defaults.bsdfs[f->child[0]].kind, BSDF_DIFFUSE);
    assert_int_equal(s->defaults.bsdfs[f->child[1]].kind, BSDF_CONDUCTOR);
    scene_free(s);

    s = text_scene(TEXT_SENSOR "<bsdf type='diffuse' id='m'/><shape type='rectangle'>"
                               "<bsdf type='mask'><float name='opacity' value='.25'/>"
                               "<bsdf type='twosided'><ref id='m'/></bsdf></bsdf></shape>");
    f = bsdf_of(s);
    assert_int_equal(f->kind, BSDF_MASK);
    assert_close(value_of(s, f->opacity).x, 0.25f);
    f = &s->defaults.bsdfs[f->child[0]];
    assert_int_equal(f->kind, BSDF_TWOSIDED);
    assert_int_equal(f->child[0], f->child[1]);
    scene_free(s);
}

static void default_material(void **state)
{
    (void)state;
    struct scene *s = text_scene(TEXT_SENSOR "<shape type='rectangle'/><shape type='rectangle'>"
                                             "<emitter type='area'/></shape>");
    assert_vec3(value_of(s, bsdf_of(s)->reflectance), 0.5f, 0.5f, 0.5f);
    assert_int_equal(s->shapes[0].emitter, SCENE_NONE);
    /* A light without a material is black, as in Mitsuba 3. */
    const struct bsdf *f = &s->defaults.bsdfs[s->defaults.shape_bsdfs[1]];
    assert_vec3(value_of(s, f->reflectance), 0, 0, 0);
    assert_int_equal(s->shapes[1].emitter, 0);
    scene_free(s);
}

/* ---- Textures and emitters ------------------------------------------------------------------ */

static void textures(void **state)
{
    (void)state;
    struct scene *s = text_scene(
        TEXT_SENSOR
        "<texture type='checkerboard' id='t'><rgb name='color0' value='1 0 0'/>"
        "<transform name='to_uv'><scale x='20' y='80'/><translate x='.5'/></transform></texture>"
        "<shape type='rectangle'><bsdf type='diffuse'><ref name='reflectance' id='t'/></bsdf>"
        "</shape>");
    const struct texture *t = &s->defaults.textures[bsdf_of(s)->reflectance];
    assert_int_equal(t->kind, TEXTURE_CHECKERBOARD);
    assert_vec3(t->color0, 1, 0, 0);
    assert_vec3(t->color1, 0.2f, 0.2f, 0.2f);
    assert_vec3(t->value, 1, 1, 1);
    assert_vec3(vec3(t->to_uv[0][0], t->to_uv[0][1], t->to_uv[0][2]), 20, 0, 0.5f);
    assert_vec3(vec3(t->to_uv[1][0], t->to_uv[1][1], t->to_uv[1][2]), 0, 80, 0);
    scene_free(s);
}

/* A 2 x 1 image that needs no library to write. */
static void write_pfm(const char *name)
{
    static const float pixels[6] = {1, 0, 0, 0, 1, 0};
    char bytes[64];
    int n = snprintf(bytes, sizeof bytes, "PF\n2 1\n-1\n");
    memcpy(bytes + n, pixels, sizeof pixels);
    text_write(name, bytes, (size_t)n + sizeof pixels);
}

static void bitmaps(void **state)
{
    (void)state;
    write_pfm("a picture.pfm");
    struct scene *s = text_scene(
        TEXT_SENSOR "<shape type='rectangle'><bsdf type='diffuse'>"
                    "<texture type='bitmap' name='reflectance'>"
                    "<string name='filename' value='a picture.pfm'/>"
                    "<string name='filter_type' value='nearest'/>"
                    "<string name='wrap_mode' value='mirror'/>"
                    "<boolean name='raw' value='true'/></texture></bsdf></shape>"
                    "<emitter type='envmap'><string name='filename' value='a picture.pfm'/>"
                    "<float name='scale' value='2'/><transform name='to_world'>"
                    "<rotate y='1' angle='90'/></transform></emitter>");
    const struct texture *t = &s->defaults.textures[bsdf_of(s)->reflectance];
    assert_int_equal(t->kind, TEXTURE_BITMAP);
    assert_int_equal(t->filter, TEXTURE_NEAREST);
    assert_int_equal(t->wrap, TEXTURE_MIRROR);
    assert_true(t->is_raw);
    assert_int_equal(s->n_bitmaps, 1); /* one file, loaded once */
    assert_int_equal(s->bitmaps[0].width, 2);
    const struct emitter *e = &s->defaults.emitters[0];
    assert_int_equal(e->kind, EMITTER_ENVMAP);
    assert_int_equal(e->bitmap, t->bitmap);
    assert_close(e->scale, 2.0f);
    assert_vec3(transform_vector(&e->to_world, vec3(0, 0, 1)), 1, 0, 0);
    scene_free(s);
}

static void emitters(void **state)
{
    (void)state;
    struct scene *s = text_scene(
        TEXT_SENSOR "<emitter type='point'><point name='position' x='1' y='2' z='3'/>"
                    "<rgb name='intensity' value='4 5 6'/></emitter>"
                    "<emitter type='constant'><rgb name='radiance' value='.1 .2 .3'/></emitter>"
                    "<emitter type='area' id='lamp'><rgb name='radiance' value='7'/></emitter>"
                    "<shape type='sphere'><ref id='lamp'/></shape>"
                    "<shape type='disk'><ref id='lamp'/></shape>");
    const struct emitter *e = s->defaults.emitters;
    assert_int_equal(s->n_emitters, 3);
    assert_int_equal(e[0].kind, EMITTER_POINT);
    assert_vec3(transform_point(&e[0].to_world, vec3(0, 0, 0)), 1, 2, 3);
    assert_vec3(value_of(s, e[0].radiance), 4, 5, 6);
    assert_int_equal(e[1].kind, EMITTER_CONSTANT);
    assert_int_equal(e[2].kind, EMITTER_AREA);
    assert_int_equal(s->shapes[0].emitter, 2);
    assert_int_equal(s->shapes[1].emitter, 2);
    scene_free(s);
}

static void spots_and_the_like(void **state)
{
    (void)state;
    write_pfm("a picture.pfm");
    struct scene *s = text_scene(
        TEXT_SENSOR "<emitter type='spot'><float name='cutoff_angle' value='40'/>"
                    "<texture type='checkerboard' name='texture'/></emitter>"
                    "<emitter type='directional'><vector name='direction' value='0 -2 0'/>"
                    "<rgb name='irradiance' value='1 2 3'/></emitter>"
                    "<emitter type='projector'><float name='fov' value='30'/>"
                    "<string name='fov_axis' value='y'/><texture type='bitmap' name='irradiance'>"
                    "<string name='filename' value='a picture.pfm'/></texture></emitter>");
    const struct emitter *e = s->defaults.emitters;
    assert_int_equal(e[0].kind, EMITTER_SPOT);
    assert_close(e[0].cutoff, 40);
    assert_close(e[0].beam_width, 30);
    assert_int_equal(s->defaults.textures[e[0].picture].kind, TEXTURE_CHECKERBOARD);
    assert_vec3(value_of(s, e[0].radiance), 1, 1, 1);
    assert_int_equal(e[1].kind, EMITTER_DIRECTIONAL);
    assert_vec3(transform_vector(&e[1].to_world, vec3(0, 0, 1)), 0, -1, 0);
    assert_vec3(value_of(s, e[1].radiance), 1, 2, 3);
    assert_int_equal(e[2].kind, EMITTER_PROJECTOR);
    assert_int_equal(e[2].fov_axis, FOV_Y);
    assert_int_equal(s->defaults.textures[e[2].radiance].kind, TEXTURE_BITMAP);
    static const char *const paths[] = {"spot.intensity.value", "spot.texture.value",
                                        "spot.cutoff_angle",    "spot.beam_width",
                                        "spot.to_world",        "directional.irradiance.value",
                                        "projector.fov",        "projector.scale",
                                        "directional.to_world", "projector.irradiance.value"};
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
        bool is_there = false;
        for (uint32_t k = 0; k < s->n_params; k++)
            is_there |= strcmp(s->params[k].path, paths[i]) == 0;
        if (!is_there) fail_msg("no %s", paths[i]);
    }
    scene_free(s);
}

static void skies(void **state)
{
    (void)state;
    struct scene *s = text_scene(
        TEXT_SENSOR "<emitter type='sunsky'><float name='turbidity' value='4'/>"
                    "<vector name='sun_direction' value='0 1 0'/><transform name='to_world'>"
                    "<rotate x='1' angle='-60'/></transform>"
                    "<float name='sky_scale' value='.5'/></emitter>");
    const struct emitter *e = s->defaults.emitters;
    assert_int_equal(e->kind, EMITTER_SKY);
    assert_close(e->turbidity, 4);
    assert_close(e->sun_elevation, 60);
    assert_close(e->sun_azimuth, 90);
    assert_close(e->sky_scale, 0.5f);
    assert_close(e->sun_scale, 1);
    assert_close(e->sun_aperture, 0.5358f);
    scene_free(s);
    /* Mitsuba 3.9 has the sun of its default day at (.0514, .6917, .7203). */
    s = text_scene(TEXT_SENSOR "<emitter type='sunsky' id='day'/>");
    e = s->defaults.emitters;
    assert_float_equal(e->sun_elevation, 46.080, 0.003); /* it computes in floats */
    assert_float_equal(e->sun_azimuth, 85.752, 0.003);
    scene_free(s);
    /* Mitsuba 0.6: +y is up, and the sun in the east is at +x. */
    text_write_string("old.xml",
                      "<scene version='0.6.0'><sensor type='perspective'/>"
                      "<emitter type='sky'><float name='scale' value='2'/>"
                      "<vector name='sunDirection' x='3' y='4' z='0'/></emitter>"
                      "<emitter type='sun'><float name='sunRadiusScale' value='10'/>"
                      "<vector name='sunDirection' x='3' y='4' z='0'/></emitter></scene>");
    struct error err;
    struct scene_load_options options = {0};
    assert_int_equal(scene_load(text_path("old.xml"), &options, &s, &err), LMN_OK);
    e = s->defaults.emitters;
    assert_int_equal(s->n_emitters, 2);
    assert_close(e[0].sky_scale, 2);
    assert_close(e[0].sun_scale, 0);
    assert_close(e[0].sun_elevation, 53.1301f);
    assert_vec3(transform_vector(&e[0].to_world, vec3(0, 0, 1)), 0, 1, 0);
    double azimuth = (double)e[0].sun_azimuth * 3.14159265358979 / 180;
    assert_vec3(transform_vector(&e[0].to_world, vec3(0.6f * cosf((float)azimuth),
                                                      0.6f * sinf((float)azimuth), 0.8f)),
                0.6f, 0.8f, 0);
    assert_close(e[1].sky_scale, 0);
    assert_close(e[1].sun_aperture, 5.358f);
    scene_free(s);
    /* On its default day the sun is in the west, at -x, and a little south, at +z. */
    text_write_string("old.xml", "<scene version='0.6.0'><sensor type='perspective'/>"
                                 "<emitter type='sunsky'><float name='scale' value='2'/>"
                                 "<float name='sunScale' value='3'/></emitter></scene>");
    assert_int_equal(scene_load(text_path("old.xml"), &options, &s, &err), LMN_OK);
    e = s->defaults.emitters;
    assert_close(e[0].sky_scale, 2);
    assert_close(e[0].sun_scale, 3);
    azimuth = (double)e[0].sun_azimuth * 3.14159265358979 / 180;
    struct vec3 d = transform_vector(
        &e[0].to_world,
        vec3(0.69367f * cosf((float)azimuth), 0.69367f * sinf((float)azimuth), 0.7203f));
    assert_true(fabsf(d.x + 0.6918f) < 1e-3f && fabsf(d.y - 0.7203f) < 1e-3f &&
                fabsf(d.z - 0.0514f) < 1e-3f);
    scene_free(s);
}

/* Against the almanac: where and when the sun is overhead, sets, or crosses the meridian. */
static void sun_positions(void **state)
{
    (void)state;
    double elevation, azimuth;
    /* Equinox of 2004, March 20, 06:49 UT: above the equator, at noon where it is 6 h 49 min + 7
     * min 28 s (equation of time) before Greenwich's. */
    struct sun_time t = {
        .longitude = 79.6, .year = 2004, .month = 3, .day = 20, .hour = 6, .minute = 49};
    sun_position(&t, &elevation, &azimuth);
    assert_true(elevation > 89.8);
    /* Solstice at Greenwich, 21 June 2010, about 12:02 UT: 90 - 51.4779 + 23.4385 to the south. */
    t = (struct sun_time){.latitude = 51.4779,
                          .year = 2010,
                          .month = 6,
                          .day = 21,
                          .hour = 13,
                          .minute = 1,
                          .second = 50,
                          .timezone = 1};
    sun_position(&t, &elevation, &azimuth);
    assert_float_equal(elevation, 61.9606, 0.01);
    assert_float_equal(azimuth, 180, 0.3);
    /* A leap day, and the day after: half a day's change around noon is small. */
    t = (struct sun_time){.latitude = 40, .year = 2000, .month = 2, .day = 29, .hour = 24};
    sun_position(&t, &elevation, &azimuth);
    double e0 = elevation, a0 = azimuth;
    t = (struct sun_time){.latitude = 40, .year = 2000, .month = 3, .day = 1, .hour = 0};
    sun_position(&t, &elevation, &azimuth);
    assert_float_equal(elevation, e0, 1e-9);
    assert_float_equal(azimuth, a0, 1e-9);
    t = (struct sun_time){.latitude = 40, .year = 1999, .month = 12, .day = 31, .hour = 36};
    sun_position(&t, &elevation, &azimuth);
    e0 = elevation;
    t = (struct sun_time){.latitude = 40, .year = 2000, .month = 1, .day = 1, .hour = 12};
    sun_position(&t, &elevation, &azimuth);
    assert_float_equal(elevation, e0, 1e-9);
}

/* ---- Shapes -------------------------------------------------------------------------------- */

static void spheres_and_disks(void **state)
{
    (void)state;
    struct scene *s = text_scene(
        TEXT_SENSOR "<shape type='sphere' id='s'><point name='center' value='1 2 3'/>"
                    "<float name='radius' value='.5'/><transform name='to_world'>"
                    "<scale value='2'/><translate x='1'/></transform></shape>"
                    "<shape type='disk'><transform name='to_world'><scale x='2' y='3'/></transform>"
                    "<boolean name='flip_normals' value='true'/></shape>"
                    "<shape type='sphere'><transform name='to_world'><scale x='-1'/></transform>"
                    "</shape>");
    assert_string_equal(s->shapes[0].name, "s");
    assert_int_equal(s->shapes[0].kind, SHAPE_SPHERE);
    assert_vec3(transform_point(&s->shapes[0].to_group, vec3(0, 0, 0)), 3, 4, 6);
    assert_vec3(transform_vector(&s->shapes[0].to_group, vec3(1, 0, 0)), 1, 0, 0);
    assert_int_equal(s->shapes[1].kind, SHAPE_DISK);
    assert_string_equal(s->shapes[1].name, "disk");
    assert_true(s->shapes[1].flip_normals);
    assert_vec3(transform_point(&s->shapes[1].to_group, vec3(1, 1, 0)), 2, 3, 0);
    assert_string_equal(s->shapes[2].name, "sphere");
    assert_true(s->shapes[2].flip_normals); /* a mirror turns a sphere inside out */
    assert_vec3(s->bounds.min, -2, -3, -1);
    assert_vec3(s->bounds.max, 4, 5, 7);
    scene_free(s);
}

static void groups_and_instances(void **state)
{
    (void)state;
    struct scene *s = text_scene(
        TEXT_SENSOR "<shape type='rectangle' id='floor'/>"
                    "<shape type='shapegroup' id='g'><shape type='cube' id='a'/>"
                    "<shape type='sphere'><emitter type='area'/></shape></shape>"
                    "<shape type='instance' id='one'><ref id='g'/><transform name='to_world'>"
                    "<translate x='5'/></transform></shape>"
                    "<shape type='instance'><ref id='g'/></shape>");
    assert_int_equal(s->n_groups, 2);
    assert_int_equal(s->n_shapes, 3);
    assert_int_equal(s->groups[0].n_shapes, 1);
    assert_int_equal(s->groups[1].n_shapes, 2);
    assert_int_equal(s->n_instances, 3);
    assert_int_equal(s->defaults.instances[0].group, 0);
    assert_int_equal(s->defaults.instances[1].group, 1);
    assert_int_equal(s->defaults.instances[2].group, 1);
    assert_true(s->defaults.instances[1].is_visible);
    assert_vec3(s->bounds.min, -1, -1, -1);
    assert_vec3(s->bounds.max, 6, 1, 1);
    scene_free(s);
}

/* ---- Sensor, film, integrator ---------------------------------------------------------------- */

static void settings(void **state)
{
    (void)state;
    struct scene *s = text_scene(
        "<integrator type='aov'><string name='aovs' value='a:albedo'/><integrator type='path'>"
        "<integer name='max_depth' value='7'/><integer name='rr_depth' value='3'/>"
        "<boolean name='hide_emitters' value='true'/></integrator></integrator>"
        "<sensor type='perspective'><float name='fov' value='40'/>"
        "<string name='fov_axis' value='smaller'/><float name='near_clip' value='.1'/>"
        "<sampler type='multijitter'><integer name='sample_count' value='64'/>"
        "<integer name='seed' value='5'/></sampler>"
        "<film type='hdrfilm'><integer name='width' value='320'/>"
        "<integer name='height' value='240'/>"
        "<rfilter type='gaussian'><float name='stddev' value='.4'/></rfilter>"
        "<string name='pixel_format' value='rgb'/></film></sensor>");
    const struct render_settings *r = &s->settings;
    assert_int_equal(r->max_depth, 7);
    assert_int_equal(r->rr_depth, 3);
    assert_true(r->hide_emitters);
    assert_int_equal(r->spp, 64);
    assert_int_equal(r->seed, 5);
    assert_int_equal(r->sampler, SAMPLER_SOBOL);
    assert_int_equal(r->width, 320);
    assert_int_equal(r->height, 240);
    assert_int_equal(r->filter, FILTER_GAUSSIAN);
    assert_close(r->filter_stddev, 0.4f);
    assert_close(r->filter_radius, 1.6f);
    assert_close(s->defaults.sensor.fov, 40.0f);
    assert_int_equal(s->defaults.sensor.fov_axis, FOV_SMALLER);
    assert_non_null(strstr(text_note, "multijitter"));
    assert_non_null(strstr(text_note, "aovs (line 2)"));
    assert_non_null(strstr(text_note, "pixel_format (line 2)"));
    scene_free(s);
}

static void sensors(void **state)
{
    (void)state;
    struct scene *s = text_scene(
        "<sensor type='thinlens'><float name='aperture_radius' value='.2'/>"
        "<float name='far_clip' value='70'/>"
        "<film type='hdrfilm'><integer name='width' value='100'/>"
        "<integer name='height' value='80'/><integer name='crop_offset_x' value='25'/>"
        "<integer name='crop_width' value='50'/><integer name='crop_offset_y' value='20'/></film>"
        "</sensor>");
    const struct sensor *c = &s->defaults.sensor;
    assert_int_equal(c->kind, SENSOR_THINLENS);
    assert_close(c->aperture_radius, 0.2f);
    assert_close(c->focus_distance, 70);
    assert_int_equal(s->settings.width, 50);
    assert_int_equal(s->settings.height, 60);
    assert_close(c->crop.left, 0.25f);
    assert_close(c->crop.right, 0.25f);
    assert_close(c->crop.top, 0.25f);
    assert_close(c->crop.bottom, 0);
    scene_free(s);
    /* The scale is a value of its own, so that moves keep it. */
    s = text_scene("<sensor type='orthographic'><transform name='to_world'>"
                   "<scale x='-2' y='3' z='5'/><rotate y='1' angle='90'/><translate x='7'/>"
                   "</transform></sensor>");
    c = &s->defaults.sensor;
    assert_int_equal(c->kind, SENSOR_ORTHOGRAPHIC);
    assert_close(c->scale_x, 2);
    assert_close(c->scale_y, 3);
    assert_vec3(transform_vector(&c->to_world, vec3(0, 0, 1)), 1, 0, 0);
    assert_vec3(transform_vector(&c->to_world, vec3(1, 0, 0)), 0, 0, 1);
    assert_vec3(transform_point(&c->to_world, vec3(0, 0, 0)), 7, 0, 0);
    scene_free(s);
    s = text_scene("<sensor type='perspective'><float name='principal_point_offset_x' value='.1'/>"
                   "<float name='principal_point_offset_y' value='-.2'/></sensor>");
    assert_close(s->defaults.sensor.shift_x, 0.1f);
    assert_close(s->defaults.sensor.shift_y, -0.2f);
    scene_free(s);
}

static void default_settings(void **state)
{
    (void)state;
    struct scene *s = text_scene(TEXT_SENSOR);
    const struct render_settings *r = &s->settings;
    assert_int_equal(r->max_depth, -1);
    assert_int_equal(r->rr_depth, 5);
    assert_int_equal(r->width, 768);
    assert_int_equal(r->height, 576);
    assert_int_equal(r->filter, FILTER_GAUSSIAN);
    assert_int_equal(r->sampler, SAMPLER_INDEPENDENT);
    /* 50 mm on the diagonal of 36 x 24 mm film. */
    assert_int_equal(s->defaults.sensor.fov_axis, FOV_DIAGONAL);
    assert_close(s->defaults.sensor.fov, 46.793f);
    assert_string_equal(text_note, "");
    scene_free(s);
}

/* ---- Documents ------------------------------------------------------------------------------- */

static void defines(void **state)
{
    struct scene *s;
    struct error err;
    (void)state;
    text_write_string("d.xml", "<scene version='3.0.0'><default name='w' value='10'/>"
                               "<default name='h' value='20'/><sensor type='perspective'>"
                               "<film type='hdrfilm'><integer name='width' value='$w'/>"
                               "<integer name='height' value='1$h'/></film></sensor></scene>");
    assert_int_equal(text_load_file("d.xml", NULL, &s, &err), LMN_OK);
    assert_int_equal(s->settings.width, 10);
    assert_int_equal(s->settings.height, 120);
    uint64_t hash = s->hash;
    scene_free(s);
    assert_int_equal(text_load_file("d.xml", "w=30", &s, &err), LMN_OK);
    assert_int_equal(s->settings.width, 30);
    assert_int_not_equal(s->hash, hash);
    scene_free(s);
    assert_int_equal(text_load_file("d.xml", "ww=30", &s, &err), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(err.text, "unknown define \"ww\"; did you mean \"w\"?"));
    assert_int_equal(text_load_file("d.xml", "w", &s, &err), LMN_ERR_ARGUMENT);
    assert_null(s);
}

static void includes(void **state)
{
    (void)state;
    char folder[300];
    snprintf(folder, sizeof folder, "mkdir -p '%s/parts'", text_folder);
    assert_int_equal(system(folder), 0);
    text_write_string("parts/shapes.xml",
                      "<scene version='3.0.0'><default name='r' value='2'/>"
                      "<shape type='sphere' id='a'><float name='radius' value='$r'/></shape>"
                      "<include filename='one.xml'/></scene>");
    text_write_string("parts/one.xml", "<shape type='cube' id='b'><ref id='m'/></shape>");
    struct scene *s = text_scene(TEXT_SENSOR "<include filename='parts/shapes.xml'/>"
                                             "<bsdf type='diffuse' id='mm'/>"
                                             "<alias id='mm' as='m'/>");
    assert_int_equal(s->n_shapes, 2);
    assert_string_equal(s->shapes[0].name, "a");
    assert_string_equal(s->shapes[1].name, "b");
    assert_close(s->bounds.max.x, 2.0f);
    scene_free(s);
}

static void old_names(void **state)
{
    struct scene *s;
    struct error err;
    (void)state;
    text_write_string("old.xml",
                      "<scene version='0.6.0'><sensor type='perspective'><transform name='toWorld'>"
                      "<lookAt origin='0,0,5' target='0,0,0' up='0,1,0'/></transform></sensor>"
                      "<shape type='sphere'><bsdf type='dielectric'>"
                      "<float name='intIOR' value='1.5'/><float name='extIOR' value='1'/></bsdf>"
                      "</shape><shape type='cube'><bsdf type='roughconductor'>"
                      "<float name='extEta' value='2'/><rgb name='eta' value='1 2 3'/>"
                      "<rgb name='k' value='4'/></bsdf></shape></scene>");
    assert_int_equal(text_load_file("old.xml", NULL, &s, &err), LMN_OK);
    assert_close(bsdf_of(s)->eta, 1.5f);
    const struct bsdf *f = &s->defaults.bsdfs[s->defaults.shape_bsdfs[1]];
    assert_vec3(value_of(s, f->eta_texture), 0.5f, 1, 1.5f);
    assert_vec3(value_of(s, f->k_texture), 2, 2, 2);
    scene_free(s);
}

static void made_up_names(void **state)
{
    (void)state;
    struct scene *s = text_scene(TEXT_SENSOR "<shape type='cube'/><shape type='cube'/>"
                                             "<shape type='sphere' id='cube'/>");
    assert_string_equal(s->shapes[2].name, "cube"); /* an id wins over a name made up before */
    for (int i = 0; i < 2; i++) {
        assert_memory_equal(s->shapes[i].name, "cube_", 5);
        assert_string_not_equal(s->shapes[i].name, s->shapes[i ? 0 : 1].name);
    }
    scene_free(s);
}

static void hash_follows_files(void **state)
{
    (void)state;
    static const char obj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    static const char body[] = TEXT_SENSOR "<shape type='obj'>"
                                           "<string name='filename' value='a.obj'/></shape>";
    uint64_t hashes[3];
    for (int i = 0; i < 3; i++) {
        char text[sizeof obj];
        memcpy(text, obj, sizeof obj);
        if (i == 2) text[10] = '2';
        text_write_string("a.obj", text);
        struct scene *s = text_scene(body);
        assert_string_equal(s->shapes[0].name, "a");
        hashes[i] = s->hash;
        scene_free(s);
    }
    assert_int_equal(hashes[0], hashes[1]);
    assert_int_not_equal(hashes[0], hashes[2]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colours),
        cmocka_unit_test(light_spectra),
        cmocka_unit_test(transforms),
        cmocka_unit_test(smooth_materials),
        cmocka_unit_test(rough_materials),
        cmocka_unit_test(nested_materials),
        cmocka_unit_test(default_material),
        cmocka_unit_test(textures),
        cmocka_unit_test(bitmaps),
        cmocka_unit_test(emitters),
        cmocka_unit_test(spots_and_the_like),
        cmocka_unit_test(skies),
        cmocka_unit_test(sun_positions),
        cmocka_unit_test(spheres_and_disks),
        cmocka_unit_test(groups_and_instances),
        cmocka_unit_test(settings),
        cmocka_unit_test(default_settings),
        cmocka_unit_test(sensors),
        cmocka_unit_test(defines),
        cmocka_unit_test(includes),
        cmocka_unit_test(old_names),
        cmocka_unit_test(made_up_names),
        cmocka_unit_test(hash_follows_files),
    };
    return cmocka_run_group_tests_name("scene reader", tests, text_setup, text_teardown);
}
