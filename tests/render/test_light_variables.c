/* SPDX-License-Identifier: Apache-2.0 */
/* Variables that drive the values of lights and sensors: each changes the picture, what was set
 * before does not matter, and setting allocates nothing. */
#include "../scene/scene_text.h"

#include "base/cpu.h"
#include "base/mem.h"
#include "picture.h"
#include "render/world.h"

enum { SIDE = 32 };

#define NUMBER(name, path, low, high)                                                           \
    "{\"name\": \"" name "\", \"kind\": \"float\", \"targets\": \"" path "\", \"range\": [" low \
    "," high "]}"
#define LIGHT(name, path)                                                    \
    "{\"name\": \"" name "\", \"kind\": \"intensity\", \"targets\": \"" path \
    "\", \"range\": [0.2, 3]}"
#define TURN(name, path)                                                  \
    "{\"name\": \"" name "\", \"kind\": \"rotate\", \"targets\": \"" path \
    "\", \"axis\": [0, 0, 1], \"range\": [-20, 20]}"

static const char things[] =
    "<shape type='rectangle'><transform name='to_world'><rotate x='1' angle='-90'/>"
    "<scale value='3'/></transform></shape>"
    "<shape type='sphere'><point name='center' value='.2 .5 -.4'/><float name='radius' "
    "value='.5'/></shape>";

static const char perspective[] =
    "<sensor type='perspective'><transform name='to_world'><lookat origin='0,2,4' "
    "target='0,0.4,0' up='0,1,0'/></transform><float name='fov' value='40'/></sensor>";

struct stage {
    const char *name, *sensor, *lights, *variables;
};

static const struct stage stages[] = {
    {"spot", perspective,
     "<emitter type='spot' id='spot'><transform name='to_world'><lookat origin='1,3,1' "
     "target='0,0,0' up='0,0,1'/></transform><texture type='checkerboard' "
     "name='texture'/></emitter>",
     LIGHT("power", "spot") "," TURN("turn", "spot") "," NUMBER(
         "cut", "spot.cutoff_angle", "12", "30") "," NUMBER("beam", "spot.beam_width", "2",
                                                            "40") "," NUMBER("tint", "spot.texture",
                                                                             "0.5", "2")},
    {"directional", perspective,
     "<emitter type='directional' id='far'><vector name='direction' value='.3 -1 -.2'/></emitter>",
     LIGHT("power", "far") "," TURN("turn", "far")},
    {"projector", perspective,
     "<emitter type='projector' id='beamer'><transform name='to_world'><lookat origin='-1,3,1' "
     "target='0,0,0' up='0,0,1'/></transform><texture type='checkerboard' name='irradiance'/>"
     "</emitter>",
     LIGHT("power", "beamer") "," TURN("turn", "beamer") "," NUMBER("fov", "beamer.fov", "15",
                                                                    "60")},
    {"sunsky", perspective,
     "<emitter type='sunsky' id='day'><transform name='to_world'><rotate x='1' angle='-90'/>"
     "</transform></emitter>",
     LIGHT("power", "day") "," NUMBER("haze", "day.turbidity", "2", "9") "," NUMBER(
         "height", "day.sun_elevation", "5",
         "85") "," NUMBER("way", "day.sun_azimuth", "0",
                          "180") "," NUMBER("sky", "day.sky_scale", "0",
                                            "2") "," NUMBER("sun", "day.sun_scale", "0",
                                                            "2") "," NUMBER("size",
                                                                            "day.sun_aperture",
                                                                            "0.5",
                                                                            "20") ","
                                                                                  "{\"name\": "
                                                                                  "\"turn\", "
                                                                                  "\"kind\": "
                                                                                  "\"envmap\", "
                                                                                  "\"range\": [0, "
                                                                                  "90]}"},
    {"directionalarea", perspective,
     "<shape type='disk' id='plate'><transform name='to_world'><rotate x='1' angle='80'/>"
     "<translate y='3'/></transform><emitter type='directionalarea' id='glow'/></shape>",
     LIGHT("power", "glow") "," TURN("turn", "plate")},
    {"thinlens",
     "<sensor type='thinlens'><transform name='to_world'><lookat origin='0,2,4' "
     "target='0,0.4,0' up='0,1,0'/></transform><float name='fov' value='40'/>"
     "<float name='aperture_radius' value='.1'/><float name='focus_distance' value='3'/></sensor>",
     "<emitter type='constant'/>",
     NUMBER("aperture", "sensor.aperture_radius", "0", "0.4") "," NUMBER(
         "focus", "sensor.focus_distance", "2",
         "5") "," NUMBER("shift", "sensor.principal_point_offset_x", "-0.2", "0.2")},
    {"orthographic",
     "<sensor type='orthographic'><transform name='to_world'><scale x='2' y='1.5'/>"
     "<lookat origin='0,2,4' target='0,0.4,0' up='0,1,0'/></transform></sensor>",
     "<emitter type='constant'/>",
     NUMBER("wide", "sensor.scale_x", "1", "3") "," NUMBER(
         "high", "sensor.scale_y", "1", "3") ",{\"name\": \"camera\", \"kind\": \"camera\", "
                                             "\"origin\": {\"min\": [-1, 2, 4], \"max\": "
                                             "[1, 2, 4]}, \"target\": [0, 0.4, 0]}"},
};
enum { N_STAGES = sizeof stages / sizeof *stages };

static struct scene *load(const struct stage *stage)
{
    static char text[8192];
    struct scene *s;
    struct error err;
    snprintf(text, sizeof text, "<scene version='3.0.0'>%s%s%s</scene>", stage->sensor, things,
             stage->lights);
    text_write_string("stage.xml", text);
    snprintf(text, sizeof text, "{\"variables\": [%s]}", stage->variables);
    text_write_string("stage.variables.json", text);
    if (text_load_file("stage.xml", NULL, &s, &err) != LMN_OK)
        fail_msg("%s: %s", stage->name, err.text);
    return s;
}

static struct picture shot(const struct view *v)
{
    struct trace_settings t;
    struct window w = picture_whole(SIDE, SIDE);
    trace_settings_init(&t, view_scene(v));
    t.spp = 4;
    t.max_depth = 3;
    return picture_trace(view_trace, v, &t, &w);
}

static void every_value_counts(void **state)
{
    (void)state;
    for (int i = 0; i < N_STAGES; i++) {
        struct scene *s = load(&stages[i]);
        struct world *w;
        struct view *used, *fresh;
        struct error err;
        float u[16];
        if (world_new(s, cpu_detect(), &w, &err) || view_new(w, &used, &err))
            fail_msg("%s", err.text);
        assert_true(s->n_variables > 0 && s->n_variables <= 16);
        for (uint32_t k = 0; k < s->n_variables; k++) u[k] = 0.4f;
        view_set(used, u);
        struct picture before = shot(used);
        assert_true(picture_mean(before.color, 3 * before.n_pixels) > 0.001);
        for (uint32_t k = 0; k < s->n_variables; k++) {
            u[k] = 0.9f;
            mem_fail_after(1);
            view_set(used, u);
            mem_fail_after(0);
            if (view_new(w, &fresh, &err)) fail_msg("%s", err.text);
            view_set(fresh, u);
            struct picture a = shot(used), b = shot(fresh);
            const char *name = s->variables[k].name;
            if (!picture_is_crop(&a, &b, 0, 0))
                fail_msg("%s: %s depends on the past", stages[i].name, name);
            if (picture_different(a.color, before.color, a.n_pixels, 3, 1e-3) < 0.005)
                fail_msg("%s: %s changes nothing", stages[i].name, name);
            picture_release(&a);
            picture_release(&b);
            view_free(fresh);
            u[k] = 0.4f;
        }
        view_set(used, u);
        struct picture after = shot(used);
        assert_true(picture_is_crop(&after, &before, 0, 0));
        picture_release(&after);
        picture_release(&before);
        view_free(used);
        world_free(w);
        scene_free(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_value_counts),
    };
    return cmocka_run_group_tests(tests, text_setup, text_teardown);
}
