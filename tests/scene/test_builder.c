/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_text.h"

#include "scene/builder.h"
#include "scene/reader_mitsuba.h"

/* Sorting shapes into groups and instances, and looking objects up by name. */

static struct builder *read_scene(const char *body)
{
    struct builder *b = NULL;
    struct error err = {{0}};
    char text[4096];
    snprintf(text, sizeof text, "<scene version='3.0.0'>%s</scene>", body);
    text_write_string("scene.xml", text);
    if (builder_new(text_path("scene.xml"), &b, &err) != LMN_OK ||
        reader_mitsuba_read(b, NULL, &err) != LMN_OK)
        fail_msg("%s", err.text);
    return b;
}

static struct scene *finish(struct builder *b)
{
    struct scene *s = NULL;
    struct error err = {{0}};
    if (builder_finish(b, &s, &err) != LMN_OK) fail_msg("%s", err.text);
    return s;
}

static uint32_t find(const struct builder *b, const char *id, enum builder_kind wanted)
{
    enum builder_kind kind;
    uint32_t index;
    assert_true(builder_find(b, id, &kind, &index));
    assert_int_equal(kind, wanted);
    return index;
}

static void lookup(void **state)
{
    (void)state;
    struct builder *b = read_scene(
        TEXT_SENSOR "<bsdf type='diffuse' id='paint'><texture type='checkerboard' id='squares'"
                    " name='reflectance'/></bsdf>"
                    "<emitter type='area' id='lamp'/><shape type='cube' id='box'><ref id='paint'/>"
                    "</shape><shape type='sphere'><ref id='lamp'/></shape>"
                    "<shape type='shapegroup' id='group'><shape type='disk'/></shape>"
                    "<shape type='instance' id='copy'><ref id='group'/></shape>");
    enum builder_kind kind;
    uint32_t i;
    i = find(b, "paint", BUILDER_BSDF);
    assert_int_equal(b->bsdfs[i].bsdf.reflectance, find(b, "squares", BUILDER_TEXTURE));
    i = find(b, "box", BUILDER_SHAPE);
    assert_string_equal(b->shapes[i].name, "box");
    assert_int_equal(b->shapes[i].bsdf, find(b, "paint", BUILDER_BSDF));
    i = find(b, "sphere", BUILDER_SHAPE); /* a made-up name */
    assert_null(b->shapes[i].object.id);
    assert_int_equal(b->shapes[i].emitter, find(b, "lamp", BUILDER_EMITTER));
    i = find(b, "copy", BUILDER_INSTANCE);
    assert_int_equal(b->instances[i].group, find(b, "group", BUILDER_GROUP));
    find(b, "sensor", BUILDER_SENSOR);
    assert_false(builder_find(b, "pant", &kind, &i));
    assert_string_equal(builder_closest(b, "pant"), "paint");
    assert_null(builder_closest(b, "something else"));
    assert_int_equal(builder_count(b, BUILDER_SHAPE), 3);
    assert_string_equal(builder_object(b, BUILDER_BSDF, 0)->id, "paint");
    assert_int_equal(builder_object(b, BUILDER_BSDF, 0)->place.line, 1);
    builder_free(b);
}

/* a and c stay, b moves; g has d and e, of which e is an alternative; two instances of g. */
static void movable(void **state)
{
    (void)state;
    struct builder *b = read_scene(
        TEXT_SENSOR "<shape type='cube' id='a'/><shape type='cube' id='b'>"
                    "<transform name='to_world'><translate x='3'/></transform></shape>"
                    "<shape type='cube' id='c'/>"
                    "<shape type='shapegroup' id='g'><shape type='sphere' id='d'/>"
                    "<shape type='sphere' id='e'/></shape>"
                    "<shape type='instance' id='one'><ref id='g'/></shape>"
                    "<shape type='instance' id='two'><ref id='g'/><transform name='to_world'>"
                    "<translate z='7'/></transform></shape>");
    uint32_t shape_b = find(b, "b", BUILDER_SHAPE), shape_e = find(b, "e", BUILDER_SHAPE);
    builder_make_movable(b, shape_b);
    builder_make_movable(b, shape_e);
    struct scene *s = finish(b);

    /* Groups: what stays (a, c), rest of g (d), b, e. Shapes are in the order of groups. */
    assert_int_equal(s->n_groups, 4);
    static const char *const names[] = {"a", "c", "d", "b", "e"};
    for (int i = 0; i < 5; i++) assert_string_equal(s->shapes[i].name, names[i]);
    assert_int_equal(s->groups[0].n_shapes, 2);
    assert_int_equal(s->groups[1].first_shape, 2);
    assert_int_equal(b->shapes[shape_e].final_shape, 4);

    /* Instances: 0; b alone; (rest of g, e) for `one` and for `two`. */
    static const struct {
        uint32_t group, shape, instance;
        float z;
    } wanted[] = {{0, SCENE_NONE, SCENE_NONE, 0}, {2, 1, SCENE_NONE, 0},
                  {1, SCENE_NONE, 0, 0},          {3, 4, 0, 0},
                  {1, SCENE_NONE, 1, 7},          {3, 4, 1, 7}};
    assert_int_equal(s->n_instances, 6);
    for (uint32_t i = 0; i < 6; i++) {
        const struct instance *in = &s->defaults.instances[i];
        assert_int_equal(in->group, wanted[i].group);
        assert_true(in->is_visible);
        assert_float_equal(in->to_world.m[2][3], wanted[i].z, 0.0f);
        assert_int_equal(b->placements[i].instance, wanted[i].instance);
        assert_int_equal(b->placements[i].shape, wanted[i].shape);
    }
    /* A movable shape keeps its own to_world in its vertices. */
    assert_float_equal(s->groups[2].bounds.min.x, 2.0f, 0.0f);
    assert_float_equal(s->bounds.max.z, 8.0f, 0.0f);

    s->defaults.instances[4].is_visible = s->defaults.instances[5].is_visible = false;
    assert_float_equal(scene_bounds(s, &s->defaults).max.z, 1.0f, 0.0f);
    builder_free(b);
    scene_free(s);
}

/* A shapegroup of which every shape is an alternative leaves no group of its own. */
static void alternatives(void **state)
{
    (void)state;
    struct builder *b = read_scene(
        TEXT_SENSOR "<shape type='shapegroup' id='g'><shape type='cube'/><shape type='disk'/>"
                    "</shape><shape type='instance'><ref id='g'/></shape>");
    builder_make_movable(b, 0);
    builder_make_movable(b, 1);
    struct scene *s = finish(b);
    assert_int_equal(s->n_groups, 3);
    assert_int_equal(s->groups[0].n_shapes, 0);
    assert_int_equal(s->n_instances, 3);
    assert_int_equal(b->placements[1].shape, 0);
    assert_int_equal(b->placements[2].shape, 1);
    builder_free(b);
    scene_free(s);
}

/* The authors' extra children, kept with their places. */
static void extras(void **state)
{
    (void)state;
    struct builder *b = read_scene(
        "\n<sensor type='perspective' id='var_sensor'>\n"
        "<vector name='min_bounds' value='1.0, 0.4, -4'/><integer name='num_parameters' value='5'/>"
        "</sensor><texture type='checkerboard' id='t1'/><texture type='checkerboard' id='t2'/>"
        "<bsdf type='diffuse' id='var_wall'><ref name='reflectance' id='t1'/>"
        "<ref name='reflectance' id='t2'/></bsdf>"
        "<bsdf type='roughconductor' id='var_metal'>"
        "<vector4f name='min_bounds' value='0, 0, 0, .01'/></bsdf>"
        "<shape type='cube' id='stays'><vector name='rotation_axis' x='0' y='-1' z='0'/></shape>");
    const struct builder_object *o = &b->sensor_object;
    assert_int_equal(o->n_extras, 2);
    assert_string_equal(o->extras[0].name, "min_bounds");
    assert_int_equal(o->extras[0].n_values, 3);
    assert_float_equal((float)o->extras[0].values[2], -4.0f, 0.0f);
    assert_int_equal(o->extras[0].place.line, 3);
    assert_int_equal(o->extras[0].place.column, 1);
    assert_string_equal(o->extras[1].name, "num_parameters");
    assert_float_equal((float)o->extras[1].values[0], 5.0f, 0.0f);

    o = &b->bsdfs[find(b, "var_wall", BUILDER_BSDF)].object;
    assert_int_equal(o->n_extras, 1);
    assert_string_equal(o->extras[0].name, "reflectance");
    assert_int_equal(o->extras[0].texture, find(b, "t2", BUILDER_TEXTURE));
    uint32_t wall = find(b, "var_wall", BUILDER_BSDF);
    assert_int_equal(b->bsdfs[wall].bsdf.reflectance, find(b, "t1", BUILDER_TEXTURE));

    o = &b->bsdfs[find(b, "var_metal", BUILDER_BSDF)].object;
    assert_int_equal(o->extras[0].n_values, 4);
    o = &b->shapes[0].object;
    assert_float_equal((float)o->extras[0].values[1], -1.0f, 0.0f);
    builder_free(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lookup),
        cmocka_unit_test(movable),
        cmocka_unit_test(alternatives),
        cmocka_unit_test(extras),
    };
    return cmocka_run_group_tests_name("scene builder", tests, text_setup, text_teardown);
}
