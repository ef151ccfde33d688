/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_text.h"

/* The scenes of others, which the project does not hold: found through LUMENAUT_SCENES, else in
 * ../shared/scenes beside the source; skipped where there are none. */

static char scenes[512];

static bool find_scenes(void)
{
    const char *given = getenv("LUMENAUT_SCENES");
    if (given && *given) {
        snprintf(scenes, sizeof scenes, "%s", given);
    } else {
        snprintf(scenes, sizeof scenes, "%s/../shared/scenes", LMN_SOURCE_DIR);
    }
    return access(scenes, R_OK) == 0;
}

static lmn_status load(const char *name, struct scene **out, struct error *err)
{
    char path[600];
    struct scene_load_options options = {.note = text_on_note};
    snprintf(path, sizeof path, "%s/%s", scenes, name);
    *out = NULL;
    return scene_load(path, &options, out, err);
}

static uint64_t count_triangles(const struct scene *s)
{
    uint64_t n = 0;
    for (uint32_t i = 0; i < s->n_shapes; i++) {
        if (s->shapes[i].kind == SHAPE_MESH) n += s->meshes[s->shapes[i].mesh].n_triangles;
    }
    return n;
}

static void loads(void **state)
{
    static const struct {
        const char *name;
        uint32_t n_triangles, n_shapes, n_bitmaps, width, spp;
        int32_t max_depth;
    } wanted[] = {
        {"official/sphere-caustic/scene.xml", 12, 7, 0, 128, 400, 5},
        {"official/sphere-caustic/preview.xml", 12, 7, 0, 600, 400, 5},
        {"official/sphere-caustic/preview_buffers.xml", 12, 7, 0, 600, 20, -1},
        {"official/veach-ajar/scene.xml", 382690, 22, 3, 512, 600, 9},
        {"bitterli/cornell-box/scene.xml", 36, 8, 0, 1024, 64, 2},
        {"bitterli/veach-mis/scene.xml", 52, 9, 0, 1280, 512, 5},
        {"official/spaceship/scene.xml", 320204, 89, 0, 128, 1200, 9},
        {"bitterli/staircase2/scene.xml", 30927, 32, 3, 1280, 256, 65},
        {"bitterli/classroom/scene.xml", 103832, 79, 3, 1280, 100, 17},
    };
    (void)state;
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        struct scene *s;
        struct error err;
        if (load(wanted[i].name, &s, &err) != LMN_OK) fail_msg("%s", err.text);
        assert_int_equal(count_triangles(s), wanted[i].n_triangles);
        assert_int_equal(s->n_shapes, wanted[i].n_shapes);
        assert_int_equal(s->n_bitmaps, wanted[i].n_bitmaps);
        assert_int_equal(s->settings.width, wanted[i].width);
        assert_int_equal(s->settings.spp, wanted[i].spp);
        assert_int_equal(s->settings.max_depth, wanted[i].max_depth);
        scene_free(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(loads)};
    if (!find_scenes()) {
        printf("skipped: no scenes at %s (set LUMENAUT_SCENES)\n", scenes);
        return 77;
    }
    return cmocka_run_group_tests_name("shared scenes", tests, NULL, NULL);
}
