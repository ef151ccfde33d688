/* SPDX-License-Identifier: Apache-2.0 */
#include "variables_text.h"

#include "base/str.h"

/* Variables of scenes in the format of the paper's authors: names, order, ranges and effects. */

#define NEAR 2e-6f

static struct scene *load(const char *body, struct scene_state *state)
{
    struct scene *s = text_scene(body);
    *state = text_state(s);
    return s;
}

static void done(struct scene *s, struct scene_state *state)
{
    scene_state_release(state);
    scene_free(s);
}

static void assert_names(const struct scene *s, const char *names)
{
    struct str all = {0};
    for (uint32_t i = 0; i < s->n_variables; i++)
        str_add(&all, "%s%s", i ? " " : "", s->variables[i].name);
    assert_string_equal(all.length ? all.text : "", names);
    str_release(&all);
}

static void assert_vec(const float *v, float x, float y, float z)
{
    assert_float_equal(v[0], x, NEAR);
    assert_float_equal(v[1], y, NEAR);
    assert_float_equal(v[2], z, NEAR);
}

#define BOUNDS(min, range) \
    "<vector name='min_bounds' value='" min "'/><vector name='range_bounds' value='" range "'/>"
#define PARAMETERS(n) "<integer name='num_parameters' value='" n "'/>"
#define GROUP                                                                                  \
    "<shape type='shapegroup' id='g'><shape type='cube' id='a'/><shape type='sphere' id='b'/>" \
    "</shape>"

/* The sensor is first wherever it stands, everything else as the document has it. */
static void orders(void **unused)
{
    struct scene_state state;
    (void)unused;
    struct scene *s = load(
        "<bsdf type='diffuse' id='var_B'/>\n" GROUP
        "<shape type='instance' id='var_A'><ref id='g'/>" BOUNDS(
            "0 0 0",
            "1 0 2") "</shape>\n"
                     "<bsdf type='twosided'><bsdf type='roughconductor' id='var_C'>" PARAMETERS(
                         "1") "<vector4f name='min_bounds' value='0, 0, 0, 0.01'/>"
                              "<vector4f name='range_bounds' value='0, 0, 0, 0.5'/></bsdf></bsdf>"
                              "<sensor type='perspective' id='var_sensor'>" BOUNDS("0 1 2", "3 0 1")
                                  PARAMETERS("5") "</sensor>"
                                                  "<emitter type='point' id='var_E'>" BOUNDS(
                                                      "0 0 0", "1 1 1")
                                                      PARAMETERS("1") "</emitter>",
        &state);
    assert_names(s, "camera.x camera.z camera.target_x camera.target_z B.r B.g B.b A.x A.z C.alpha "
                    "E.intensity");
    assert_string_equal(s->variables[0].group, "camera");
    assert_string_equal(s->variables[0].kind, "camera");
    assert_string_equal(text_variable(s, "A.z")->targets, "A.to_world");
    assert_string_equal(text_variable(s, "C.alpha")->kind, "float");
    assert_string_equal(text_variable(s, "E.intensity")->kind, "intensity");
    done(s, &state);
}

/* Target: the middle third of the box in x and z, a third of the height in y. */
static void aims_the_camera(void **unused)
{
    struct scene_state state;
    const float u[] = {0.5f, 1.0f, 0.0f, 0.0f, 1.0f};
    (void)unused;
    struct scene *s = load(
        "<sensor type='perspective' id='var_s'>" BOUNDS("10 4 -2", "2 4 4") PARAMETERS(
            "5") "<transform name='to_world'><lookat origin='11 5 1' target='3.5 2 4' up='0 1 0'/>"
                 "</transform></sensor>"
                 "<shape type='cube'><transform name='to_world'><scale x='4.5' y='3' z='6'/>"
                 "<translate x='1.5' y='3' z='3'/></transform></shape>",
        &state);
    assert_names(s, "camera.x camera.y camera.z camera.target_x camera.target_z");
    assert_float_equal(s->variables[3].min, 0, NEAR);
    assert_float_equal(s->variables[3].max, 3, NEAR);
    assert_float_equal(s->variables[4].min, 1, NEAR);
    assert_float_equal(s->variables[4].max, 5, NEAR);
    /* The defaults are the scene's camera as far as they reach. */
    assert_float_equal(s->variables[0].value, 11, NEAR);
    assert_float_equal(s->variables[1].value, 5, NEAR);
    assert_float_equal(s->variables[2].value, 1, NEAR);
    scene_apply(s, u, &state);
    struct transform wanted = transform_look_at(vec3(11, 8, -2), vec3(0, 2, 5), vec3(0, 1, 0));
    for (int i = 0; i < 12; i++)
        assert_float_equal(state.sensor.to_world.m[i / 4][i % 4], wanted.m[i / 4][i % 4], NEAR);
    done(s, &state);
}

/* translate * rotate, which replaces an instance's to_world and is added to a shape's vertices. */
static void places(void **unused)
{
    struct scene_state state;
    const float u[] = {0.5f, 1.0f, 1.0f};
    (void)unused;
    struct scene *s = load(
        TEXT_SENSOR GROUP
        "<shape type='instance' id='var_i'><ref id='g'/><transform name='to_world'>"
        "<scale value='7'/></transform>" BOUNDS("1 2 3", "0 2 0")
            PARAMETERS("2") "<vector name='rotation_axis' value='0, 2, 0'/><float name='min_angle' "
                            "value='-90'/>"
                            "<float name='range_angle' value='180'/></shape>"
                            "<shape type='cube' id='var_c'><transform name='to_world'><translate "
                            "x='5'/></transform>" BOUNDS("0 0 0", "1 0 0")
                                PARAMETERS("1") "<vector name='rotation_axis' value='0, 1, "
                                                "0'/><float name='range_angle' value='180'/>"
                                                "</shape>",
        &state);
    assert_names(s, "i.y i.angle c.x");
    assert_string_equal(s->variables[1].unit, "deg");
    assert_float_equal(s->variables[1].min, -90, 0);
    assert_float_equal(s->variables[1].max, 90, 0);
    scene_apply(s, u, &state);
    const struct transform *t = (const void *)text_value(s, &state, "i.to_world");
    struct vec3 p = transform_point(t, vec3(1, 0, 0));
    assert_vec(&p.x, 1, 3, 2);
    t = (const void *)text_value(s, &state, "c.to_world");
    p = transform_point(t, vec3(6, 1, 1)); /* a vertex as it is */
    assert_vec(&p.x, 7, 1, 1);
    done(s, &state);
}

static void turns_a_door(void **unused)
{
    struct scene_state state;
    const float u[] = {1.0f};
    (void)unused;
    struct scene *s = load(
        TEXT_SENSOR GROUP "<shape type='instance' id='var_door'><ref id='g'/>" PARAMETERS("1")
            BOUNDS("-2.8, 0, -4.67",
                   "0 0 0") "<vector name='rotation_axis' value='0, -1, 0'/>"
                            "<float name='min_angle' value='-15'/>"
                            "<float name='range_angle' value='105'/></shape>"
                            "<shape type='instance' id='walls'><ref id='g'/>" BOUNDS(
                                "0 0 0", "1 1 1") "</shape>",
        &state);
    assert_names(s, "door");
    assert_float_equal(s->variables[0].value, 37.5, 1e-9);
    scene_apply(s, u, &state);
    const struct transform *t = (const void *)text_value(s, &state, "door.to_world");
    struct vec3 p = transform_point(t, vec3(1, 0, 0));
    assert_vec(&p.x, -2.8f, 0, -3.67f);
    done(s, &state);
}

static void lights(void **unused)
{
    struct scene_state state;
    const float u[] = {0.5f, 0.0f, 1.0f, 1.0f};
    static const char pfm[] = "PF\n1 1\n-1.0\n\0\0\200?\0\0\200?\0\0\200?";
    (void)unused;
    text_write("sky.pfm", pfm, sizeof pfm - 1);
    struct scene *s = load(
        TEXT_SENSOR "<emitter type='area' id='var_one'><rgb name='radiance' value='9 9 9'/>" BOUNDS(
            "1 0 0", "3000 500 100")
            PARAMETERS("1") "</emitter>"
                            "<emitter type='area' id='var_three'><rgb name='radiance' value='1 2 "
                            "3'/>" BOUNDS(
                                "0 7 0",
                                "10 0 10") "</emitter>"
                                           "<shape type='cube' id='p'><ref id='var_one'/></shape>"
                                           "<shape type='cube' id='q'><ref id='var_one'/></shape>"
                                           "<shape type='cube' id='r'><ref id='var_three'/></shape>"
                                           "<emitter type='envmap' id='var_sky'><string "
                                           "name='filename' value='sky.pfm'/></emitter>",
        &state);
    assert_names(s, "one.intensity three.r three.b sky");
    assert_float_equal(s->variables[1].value, 1, NEAR);
    assert_float_equal(s->variables[3].min, 100, 0);
    assert_float_equal(s->variables[3].max, 140, 0);
    scene_apply(s, u, &state);
    assert_vec(text_value(s, &state, "one.radiance.value"), 1501, 250, 50);
    assert_vec(text_value(s, &state, "three.radiance.value"), 0, 7, 10);
    struct transform wanted = transform_rotate(vec3(0, 1, 0), 140);
    assert_memory_equal(text_value(s, &state, "sky.to_world"), &wanted, sizeof wanted.m);
    done(s, &state);
}

static void colours(void **unused)
{
    struct scene_state state;
    const float u[] = {0.5f, 0.25f, 1.0f, 0.9f, 0.0f, 0.2f, 0.3f, 0.4f, 1.0f};
    (void)unused;
    struct scene *s = load(
        TEXT_SENSOR "<texture type='checkerboard' id='t'/><texture type='checkerboard' id='w'/>"
                    "<bsdf type='diffuse' id='plain'><ref name='reflectance' id='t'/></bsdf>"
                    "<bsdf type='diffuse' id='var_f'><ref name='reflectance' id='t'/></bsdf>"
                    "<bsdf type='twosided' id='outer'><bsdf type='diffuse' id='var_n'>" PARAMETERS(
                        "1") "<ref name='reflectance' id='t'/><ref name='reflectance' id='w'/>"
                             "</bsdf></bsdf>"
                             "<bsdf type='roughdielectric' id='var_m'>" PARAMETERS(
                                 "4") "<vector4f name='min_bounds' value='0, 0, 0, 0.01'/>"
                                      "<vector4f name='range_bounds' value='1, 1, 1, 0.5'/></bsdf>",
        &state);
    assert_names(s, "f.r f.g f.b n.texture m.r m.g m.b m.alpha");
    scene_apply(s, u, &state);
    /* A factor on the texture, which is another's, too. */
    assert_vec(text_value(s, &state, "f.reflectance.value"), 0.5f, 0.25f, 1);
    assert_vec(text_value(s, &state, "t.value"), 1, 1, 1);
    uint32_t index;
    memcpy(&index, text_value(s, &state, "n.reflectance"), sizeof index);
    assert_string_equal(text_variable(s, "n.texture")->choices[1], "w");
    assert_int_equal(index, 1);
    assert_vec(text_value(s, &state, "m.specular_reflectance.value"), 0, 0.2f, 0.3f);
    assert_float_equal(text_value(s, &state, "m.alpha.value")[0], 0.21f, NEAR);
    done(s, &state);
}

/* Both: a colour and one of several textures. */
static void colours_and_textures(void **unused)
{
    struct scene_state state;
    float u[] = {0.5f, 0.25f, 1.0f, 0.0f};
    (void)unused;
    struct scene *s = load(TEXT_SENSOR "<texture type='checkerboard' id='t'/>"
                                       "<texture type='checkerboard' id='w'/>"
                                       "<bsdf type='diffuse' id='var_d'>" PARAMETERS(
                                           "4") "<ref name='reflectance' id='t'/>"
                                                "<ref name='reflectance' id='w'/></bsdf>",
                           &state);
    assert_names(s, "d.r d.g d.b d.texture");
    for (int k = 0; k < 2; k++) {
        uint32_t index;
        u[3] = (float)k;
        scene_apply(s, u, &state);
        memcpy(&index, text_value(s, &state, "d.reflectance"), sizeof index);
        assert_in_range(index, 2, s->n_textures - 1);
        assert_vec(&state.textures[index].value.x, 0.5f, 0.25f, 1);
    }
    done(s, &state);
}

static void chooses_shapes(void **unused)
{
    struct scene_state state;
    const float first[] = {0.0f}, second[] = {0.99f};
    (void)unused;
    struct scene *s = load(TEXT_SENSOR
                           "<shape type='shapegroup' id='var_g'><shape type='cube' id='a'/>"
                           "<shape type='sphere' id='b'/></shape>"
                           "<shape type='instance' id='i'><ref id='var_g'/></shape>"
                           "<shape type='instance' id='j'><ref id='var_g'/></shape>",
                           &state);
    assert_names(s, "g.shape");
    assert_int_equal(s->variables[0].n_choices, 2);
    assert_string_equal(s->variables[0].choices[1], "b");
    scene_apply(s, first, &state);
    uint32_t n[2] = {0};
    for (uint32_t k = 0; k < s->n_instances; k++) n[0] += state.instances[k].is_visible;
    assert_true(*(const bool *)text_value(s, &state, "a.visible"));
    assert_false(*(const bool *)text_value(s, &state, "b.visible"));
    scene_apply(s, second, &state);
    for (uint32_t k = 0; k < s->n_instances; k++) n[1] += state.instances[k].is_visible;
    assert_false(*(const bool *)text_value(s, &state, "a.visible"));
    assert_true(*(const bool *)text_value(s, &state, "b.visible"));
    assert_int_equal(n[0], n[1]); /* one of two for each instance, and what stays */
    done(s, &state);
}

/* Marked, but nothing in it varies. */
static void leaves_constants(void **unused)
{
    struct scene_state state;
    (void)unused;
    struct scene *s = load(
        "<sensor type='perspective' id='var_s'/>" GROUP
        "<shape type='instance' id='var_i'><ref id='g'/></shape>"
        "<shape type='cube' id='var_c'>" BOUNDS(
            "1 1 1", "0 0 0") "</shape>"
                              "<emitter type='point' id='var_e'/>"
                              "<bsdf type='roughconductor' id='var_m'>" PARAMETERS("1") "</bsdf>",
        &state);
    assert_names(s, "");
    done(s, &state);
}

static void a_file_takes_over(void **unused)
{
    struct scene *s;
    struct error err;
    (void)unused;
    text_write_string("o.xml", "<scene version='2.2.1'>" TEXT_SENSOR
                               "<bsdf type='diffuse' id='var_w'/></scene>");
    text_write_string("o.variables.json",
                      "{\"variables\": [{\"name\": \"x\", \"kind\": \"float\","
                      " \"targets\": \"var_w.reflectance\", \"range\": [0, 1]}]}");
    if (text_load_file("o.xml", NULL, &s, &err) != LMN_OK) fail_msg("%s", err.text);
    assert_names(s, "x");
    scene_free(s);
}

static void tells_what_is_wrong(void **unused)
{
    static const struct {
        const char *body, *message;
    } cases[] = {
        {TEXT_SENSOR "<shape type='cube' id='var_c'>" PARAMETERS("7") "</shape>",
         "num_parameters is 7; it must be 1 to 5"},
        {TEXT_SENSOR "<shape type='cube' id='var_c'><vector name='min_bounds' value='0 0 0'/>"
                     "</shape>",
         "min_bounds without range_bounds"},
        {TEXT_SENSOR "<shape type='cube' id='var_c'>" PARAMETERS(
             "1") "<vector name='rotation_axis' value='0 0 0'/></shape>",
         "rotation_axis has no direction"},
        {TEXT_SENSOR "<bsdf type='conductor' id='var_c'>" PARAMETERS(
             "1") "<vector4f name='min_bounds' value='0, 0, 0, 0.01'/>"
                  "<vector4f name='range_bounds' value='1, 1, 1, 0.5'/></bsdf>",
         "\"var_c\" has a variable alpha but is not rough"},
    };
    (void)unused;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene *s;
        struct error err;
        assert_int_equal(text_load(cases[i].body, &s, &err), LMN_ERR_PARSE);
        assert_null(s);
        if (!str_ends(err.text, cases[i].message)) fail_msg("%s", err.text);
        assert_non_null(strstr(err.text, "scene.xml:2:"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orders),
        cmocka_unit_test(aims_the_camera),
        cmocka_unit_test(places),
        cmocka_unit_test(turns_a_door),
        cmocka_unit_test(lights),
        cmocka_unit_test(colours),
        cmocka_unit_test(colours_and_textures),
        cmocka_unit_test(chooses_shapes),
        cmocka_unit_test(leaves_constants),
        cmocka_unit_test(a_file_takes_over),
        cmocka_unit_test(tells_what_is_wrong),
    };
    return cmocka_run_group_tests_name("variables: the authors' scenes", tests, text_setup,
                                       text_teardown);
}
