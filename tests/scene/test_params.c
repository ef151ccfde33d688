/* SPDX-License-Identifier: Apache-2.0 */
#include "variables_text.h"

#include <math.h>

/* Paths of all values: unique, in the style of mi.traverse(), and pointing where they say. */

static int compare(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static void assert_value(const struct scene *s, const char *path, enum param_type type,
                         const char *value)
{
    const struct param *p = text_param(s, path);
    assert_int_equal(p->type, type);
    if (strcmp(p->value, value) != 0) fail_msg("%s: \"%s\", not \"%s\"", path, p->value, value);
}

static void lists_everything(void **unused)
{
    (void)unused;
    struct scene *s = text_variables("");
    assert_int_equal(s->n_variables, 0);
    assert_value(s, "cam.fov", PARAM_FLOAT, "40");
    assert_value(s, "cam.to_world", PARAM_TRANSFORM, "-1 0 0 0 0 1 0 1 0 0 -1 5");
    assert_value(s, "tiles.color0.value", PARAM_RGB, "0.1 0.2 0.3");
    assert_value(s, "tiles.color1.value", PARAM_RGB, "0.2 0.2 0.2");
    assert_value(s, "tiles.value", PARAM_RGB, "1 1 1");
    assert_value(s, "wall.reflectance", PARAM_TEXTURE, "constant");
    assert_value(s, "wall.reflectance.value", PARAM_RGB, "0.1 0.2 0.3");
    assert_value(s, "floor_mat.reflectance", PARAM_TEXTURE, "tiles");
    assert_value(s, "metal.brdf_0.alpha.value", PARAM_FLOAT, "0.2");
    assert_value(s, "glass.alpha.value", PARAM_FLOAT, "0.1");
    assert_value(s, "glass.eta", PARAM_FLOAT, "1.50418");
    assert_value(s, "box.to_world", PARAM_TRANSFORM, "1 0 0 3 0 1 0 0 0 0 1 0");
    assert_value(s, "box.visible", PARAM_BOOL, "true");
    assert_value(s, "box.bsdf", PARAM_BSDF, "wall");
    assert_value(s, "lid.bsdf.reflectance.value", PARAM_RGB, "0.5 0.5 0.5");
    assert_value(s, "one.to_world", PARAM_TRANSFORM, "2 0 0 -3 0 2 0 0 0 0 2 0");
    assert_value(s, "light.radiance.value", PARAM_RGB, "4 5 6");
    assert_value(s, "light.scale", PARAM_FLOAT, "1");
    assert_value(s, "sky.to_world", PARAM_TRANSFORM, "1 0 0 0 0 1 0 0 0 0 1 0");
    assert_value(s, "spark.intensity.value", PARAM_RGB, "1 1 1");
    scene_free(s);
}

static void are_unique(void **unused)
{
    (void)unused;
    struct scene *s = text_scene(TEXT_SENSOR
                                 "<shape type='sphere'><bsdf type='mask'><bsdf type='twosided'>"
                                 "<bsdf type='plastic'/><bsdf type='conductor'/></bsdf></bsdf>"
                                 "<emitter type='area'/></shape>"
                                 "<shape type='sphere'><emitter type='area'/></shape>"
                                 "<shape type='sphere' id='sphere_3'/><shape type='sphere'/>"
                                 "<shape type='sphere' id='var_sphere'/>"
                                 "<emitter type='point' id='point'/><emitter type='point'/>"
                                 "<emitter type='constant'/><bsdf type='diffuse' id='sphere_4'/>");
    const char *paths[256];
    assert_in_range(s->n_params, 30, 256);
    for (uint32_t i = 0; i < s->n_params; i++) {
        paths[i] = s->params[i].path;
        assert_non_null(s->params[i].value);
    }
    qsort(paths, s->n_params, sizeof *paths, compare);
    for (uint32_t i = 1; i < s->n_params; i++) assert_string_not_equal(paths[i - 1], paths[i]);
    text_param(s, "sphere.bsdf.nested_bsdf.brdf_1.k.value");
    text_param(s, "sphere.emitter.radiance.value");
    text_param(s, "sphere_2.emitter.radiance.value");
    text_param(s, "point_2.intensity.value");
    text_param(s, "constant.radiance.value");
    scene_free(s);
}

/* Writing through the place of a path is what a reader of the state sees. */
static void point_into_the_state(void **unused)
{
    (void)unused;
    struct scene *s = text_variables(
        "{\"name\": \"v\", \"kind\": \"visible\", \"targets\": [\"box\", \"part\"]}");
    struct scene_state state = text_state(s);
    for (uint32_t i = 0; i < s->n_params; i++) {
        const struct param *p = &s->params[i];
        void *at = param_in(p, &state);
        if (!at) {
            assert_int_equal(p->array, STATE_NOWHERE);
            continue;
        }
        if (p->type == PARAM_RGB) memcpy(at, &(struct vec3){7, 8, 9}, sizeof(struct vec3));
    }
    for (uint32_t i = 0; i < s->n_emitters; i++) {
        if (state.emitters[i].radiance == SCENE_NONE) continue;
        assert_float_equal(state.textures[state.emitters[i].radiance].value.y, 8, 0);
    }
    assert_null(param_in(text_param(s, "floor.to_world"), &state)); /* baked in */
    assert_non_null(param_in(text_param(s, "box.to_world"), &state));
    assert_non_null(param_in(text_param(s, "part.visible"), &state));
    scene_state_release(&state);
    scene_free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lists_everything),
                                       cmocka_unit_test(are_unique),
                                       cmocka_unit_test(point_into_the_state)};
    return cmocka_run_group_tests_name("parameters", tests, text_setup, text_teardown);
}
