/* SPDX-License-Identifier: Apache-2.0 */
/* Groups of emitters, as a scene file and as a user names them. */
#include "scene_text.h"

#include "scene/light_groups.h"

static const char *const lights = TEXT_SENSOR
    "<emitter type='point' id='lamp_1'><string name='light_group' value='lamps'/></emitter>"
    "<emitter type='constant' id='sky'/>"
    "<emitter type='spot' id='lamp_2'><string name='light_group' value='lamps'/></emitter>"
    "<shape type='sphere' id='bulb'><emitter type='area'/></shape>"
    "<shape type='sphere'><emitter type='area' id='tube'/></shape>";

/* Which group each emitter is in, and their names: "01012 a b c". */
static const char *describe(const char *text)
{
    static char told[256];
    struct light_groups g;
    struct error err = {""};
    struct scene *s = text_scene(lights);
    if (light_groups_init(&g, s, text, &err)) fail_msg("%s", err.text);
    size_t n = 0;
    for (uint32_t i = 0; i < s->n_emitters; i++)
        n += (size_t)snprintf(told + n, sizeof told - n, "%u", g.of[i]);
    for (uint32_t i = 0; i < g.n; i++)
        n += (size_t)snprintf(told + n, sizeof told - n, " %s", g.names[i]);
    light_groups_release(&g);
    scene_free(s);
    return told;
}

static void groups(void **state)
{
    (void)state;
    assert_string_equal(describe(NULL), "01023 lamps sky bulb.emitter tube");
    assert_string_equal(describe(""), "01023 lamps sky bulb.emitter tube");
    assert_string_equal(describe("a=sky,bulb"), "01012 lamps a tube");
    assert_string_equal(describe("a=lamp_1;b=tube,bulb.emitter"), "01233 a sky lamps b");
    assert_string_equal(describe("all=lamp_1,lamp_2,sky,tube,bulb"), "00000 all");
    assert_string_equal(describe("sky=sky;x=tube,tube"), "01023 lamps sky bulb.emitter x");
    assert_string_equal(describe("lamps=tube"), "01020 lamps sky bulb.emitter");
}

static void what_users_get_wrong(void **state)
{
    static const char *const wrong[][2] = {
        {"a", "light groups: \"a\": expected NAME=EMITTER,EMITTER;NAME=..."},
        {"=sky", "light groups: \"\": expected NAME=EMITTER,EMITTER;NAME=..."},
        {"a=", "light groups: \"a\": expected NAME=EMITTER,EMITTER;NAME=..."},
        {"a=sky;", "light groups: \"\": expected NAME=EMITTER,EMITTER;NAME=..."},
        {"a=sky,", "light group \"a\": no emitter \"\""},
        {"a=skye", "light group \"a\": no emitter \"skye\"; did you mean \"sky\"?"},
        {"a=sky;b=tube,sky", "light group \"b\": \"sky\" is in \"a\" already"},
        {"sky=tube", "light group \"sky\": an emitter that is not in it has that name"},
    };
    (void)state;
    struct scene *s = text_scene(lights);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct light_groups g;
        struct error err = {""};
        assert_int_equal(light_groups_init(&g, s, wrong[i][0], &err), LMN_ERR_ARGUMENT);
        assert_string_equal(err.text, wrong[i][1]);
        assert_null(g.of);
    }
    scene_free(s);
}

static void scenes_without(void **state)
{
    (void)state;
    struct light_groups g;
    struct error err = {""};
    struct scene *s = text_scene(TEXT_SENSOR);
    assert_int_equal(light_groups_init(&g, s, NULL, &err), LMN_OK);
    assert_int_equal(g.n, 0);
    light_groups_release(&g);
    scene_free(s);
    assert_true(text_load(TEXT_SENSOR "<emitter type='point'><string name='light_group' value=''/>"
                                      "</emitter>",
                          &s, &err) == LMN_ERR_PARSE);
    assert_non_null(strstr(err.text, ":2:29: \"light_group\" has 1 to 40 characters"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(groups),
        cmocka_unit_test(what_users_get_wrong),
        cmocka_unit_test(scenes_without),
    };
    return cmocka_run_group_tests(tests, text_setup, text_teardown);
}
