/* SPDX-License-Identifier: Apache-2.0 */
/* Layered, mixed and mapped materials as read from files, and the paths of their values. */
#include <math.h>

#include "scene/materials.h"
#include "variables_text.h"

#define ON_RECTANGLE(material) TEXT_SENSOR "<shape type='rectangle'>" material "</shape>"

static const struct bsdf *bsdf_of(const struct scene *s)
{
    return &s->defaults.bsdfs[s->defaults.shape_bsdfs[0]];
}

static const struct bsdf *child_of(const struct scene *s, const struct bsdf *f, int i)
{
    assert_in_range(f->child[i], 0, s->n_bsdfs - 1);
    return &s->defaults.bsdfs[f->child[i]];
}

static void near(double value, double expected)
{
    if (!(value > expected - 1e-5 && value < expected + 1e-5))
        fail_msg("%g instead of %g", value, expected);
}

/* The value at a path, by its first channel. */
static double value_at(const struct scene *s, const char *path)
{
    struct scene_state state = text_state(s);
    double x = (double)*text_value(s, &state, path);
    scene_state_release(&state);
    return x;
}

static void have_defaults(void **state)
{
    static const struct {
        const char *type;
        enum bsdf_kind kind;
        const char *path;
        double value;
    } wanted[] = {
        {"roughplastic", BSDF_ROUGH_PLASTIC, "alpha.value", 0.1},
        {"roughplastic", BSDF_ROUGH_PLASTIC, "eta", 1.49 / 1.000277},
        {"roughplastic", BSDF_ROUGH_PLASTIC, "diffuse_reflectance.value", 0.5},
        {"thindielectric", BSDF_THIN_DIELECTRIC, "eta", 1.5046 / 1.000277},
        {"roughdiffuse", BSDF_ROUGH_DIFFUSE, "reflectance.value", 0.5},
        {"roughdiffuse", BSDF_ROUGH_DIFFUSE, "alpha.value", 0.2},
        {"phong", BSDF_PHONG, "exponent.value", 30},
        {"phong", BSDF_PHONG, "specular_reflectance.value", 0.2},
        {"blinnphong", BSDF_BLINN_PHONG, "diffuse_reflectance.value", 0.5},
        {"principled", BSDF_PRINCIPLED, "base_color.value", 0.5},
        {"principled", BSDF_PRINCIPLED, "roughness.value", 0.5},
        {"principled", BSDF_PRINCIPLED, "eta", 1.5},
        {"principled", BSDF_PRINCIPLED, "anisotropic.value", 0},
        {"principled", BSDF_PRINCIPLED, "metallic.value", 0},
        {"principled", BSDF_PRINCIPLED, "spec_trans.value", 0},
        {"principled", BSDF_PRINCIPLED, "spec_tint.value", 0},
        {"principled", BSDF_PRINCIPLED, "sheen.value", 0},
        {"principled", BSDF_PRINCIPLED, "sheen_tint.value", 0},
        {"principled", BSDF_PRINCIPLED, "flatness.value", 0},
        {"principled", BSDF_PRINCIPLED, "clearcoat.value", 0},
        {"principled", BSDF_PRINCIPLED, "clearcoat_gloss.value", 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        char body[256], path[64];
        snprintf(body, sizeof body, ON_RECTANGLE("<bsdf type='%s' id='m'/>"), wanted[i].type);
        snprintf(path, sizeof path, "m.%s", wanted[i].path);
        struct scene *s = text_scene(body);
        assert_int_equal(bsdf_of(s)->kind, wanted[i].kind);
        near(value_at(s, path), wanted[i].value);
        scene_free(s);
    }
    struct scene *s = text_scene(ON_RECTANGLE("<bsdf type='null'/>"));
    assert_int_equal(bsdf_of(s)->kind, BSDF_NULL);
    scene_free(s);
}

static void are_read(void **state)
{
    (void)state;
    struct scene *s = text_scene(
        ON_RECTANGLE("<bsdf type='principled' id='m'><float name='metallic' value='.25'/>"
                     "<float name='specular' value='1'/><float name='clearcoat_gloss' value='.75'/>"
                     "<float name='main_specular_sampling_rate' value='2'/></bsdf>"));
    near(value_at(s, "m.metallic.value"), 0.25);
    near(value_at(s, "m.clearcoat_gloss.value"), 0.75);
    near((double)bsdf_of(s)->eta, 2 / (1 - sqrt(0.08)) - 1);
    near((double)bsdf_of(s)->specular_rate, 2);
    scene_free(s);

    s = text_scene(ON_RECTANGLE("<bsdf type='roughdiffuse'><boolean name='use_fast_approx' "
                                "value='true'/><rgb name='diffuse_reflectance' value='.1 .2 .3'/>"
                                "</bsdf>"));
    assert_true(bsdf_of(s)->is_approximate);
    near((double)s->defaults.textures[bsdf_of(s)->reflectance].value.z, 0.3);
    scene_free(s);

    s = text_scene(ON_RECTANGLE("<bsdf type='roughplastic'><boolean name='nonlinear' value='true'/>"
                                "<string name='distribution' value='phong'/></bsdf>"));
    assert_true(bsdf_of(s)->is_nonlinear);
    assert_int_equal(bsdf_of(s)->distribution, MICROFACET_BECKMANN);
    assert_non_null(strstr(text_note, "phong"));
    scene_free(s);
}

static void are_nested(void **state)
{
    (void)state;
    struct scene *s = text_scene(
        ON_RECTANGLE("<bsdf type='blendbsdf' id='m'><float name='weight' value='.3'/>"
                     "<bsdf type='diffuse'/><bsdf type='roughconductor'/></bsdf>"));
    assert_int_equal(bsdf_of(s)->kind, BSDF_BLEND);
    assert_int_equal(child_of(s, bsdf_of(s), 0)->kind, BSDF_DIFFUSE);
    assert_int_equal(child_of(s, bsdf_of(s), 1)->kind, BSDF_ROUGH_CONDUCTOR);
    near(value_at(s, "m.weight.value"), 0.3);
    near(value_at(s, "m.bsdf_0.reflectance.value"), 0.5);
    near(value_at(s, "m.bsdf_1.alpha.value"), 0.1);
    scene_free(s);

    s = text_scene(ON_RECTANGLE("<bsdf type='bumpmap' id='m'><float name='scale' value='2.5'/>"
                                "<texture type='checkerboard' name='any'/>"
                                "<bsdf type='twosided'><bsdf type='diffuse'/></bsdf></bsdf>"));
    assert_int_equal(bsdf_of(s)->kind, BSDF_BUMPMAP);
    assert_true(bsdf_of(s)->flips_normals && bsdf_of(s)->has_shadowing);
    near(value_at(s, "m.scale"), 2.5);
    near(value_at(s, "m.nested_bsdf.brdf_0.reflectance.value"), 0.5);
    scene_free(s);

    s = text_scene(ON_RECTANGLE(
        "<bsdf type='normalmap' id='m'><rgb name='normalmap' value='.5 .5 1'/>"
        "<boolean name='flip_invalid_normals' value='false'/>"
        "<boolean name='use_shadowing_function' value='false'/><bsdf type='plastic'/></bsdf>"));
    assert_int_equal(bsdf_of(s)->kind, BSDF_NORMALMAP);
    assert_false(bsdf_of(s)->flips_normals || bsdf_of(s)->has_shadowing);
    near(value_at(s, "m.normalmap.value"), 0.5);
    scene_free(s);
}

/* A mixture is blends: the share of each part is the product of weights on the way to it. */
static void mixtures_are_blends(void **state)
{
    (void)state;
    struct scene *s = text_scene(ON_RECTANGLE(
        "<bsdf type='mixturebsdf'><string name='weights' value='0.5, 0.2 0.1'/>"
        "<bsdf type='diffuse'/><bsdf type='plastic'/><bsdf type='roughplastic'/></bsdf>"));
    static const struct {
        enum bsdf_kind kind;
        double share;
    } wanted[] = {{BSDF_DIFFUSE, 0.5}, {BSDF_PLASTIC, 0.2}, {BSDF_ROUGH_PLASTIC, 0.1}};
    const struct bsdf *f = bsdf_of(s);
    double rest = 1;
    for (int i = 0; i < 3; i++) {
        assert_int_equal(f->kind, BSDF_BLEND);
        assert_int_equal(child_of(s, f, 1)->kind, wanted[i].kind);
        double weight = (double)s->defaults.textures[f->weight].value.x;
        near(rest * weight, wanted[i].share);
        rest *= 1 - weight;
        f = child_of(s, f, 0);
    }
    assert_int_equal(f->kind, BSDF_DIFFUSE);
    near((double)s->defaults.textures[f->reflectance].value.x, 0);
    scene_free(s);
}

/* Whatever nests can be seen from both sides only when none of it lets light through. */
static void twosided_holds_what_is_opaque(void **state)
{
    static const struct {
        const char *material;
        bool is_opaque;
    } cases[] = {
        {"<bsdf type='principled'/>", true},
        {"<bsdf type='principled'><float name='spec_trans' value='.5'/></bsdf>", false},
        {"<bsdf type='principled'><texture type='checkerboard' name='spec_trans'/></bsdf>", false},
        {"<bsdf type='null'/>", false},
        {"<bsdf type='thindielectric'/>", false},
        {"<bsdf type='blendbsdf'><bsdf type='diffuse'/><bsdf type='plastic'/></bsdf>", true},
        {"<bsdf type='blendbsdf'><bsdf type='diffuse'/><bsdf type='null'/></bsdf>", false},
        {"<bsdf type='bumpmap'><texture type='checkerboard'/><bsdf type='roughplastic'/></bsdf>",
         true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene *s;
        struct error err;
        char body[512];
        snprintf(body, sizeof body, ON_RECTANGLE("<bsdf type='twosided'>%s</bsdf>"),
                 cases[i].material);
        lmn_status status = text_load(body, &s, &err);
        assert_int_equal(status, cases[i].is_opaque ? LMN_OK : LMN_ERR_PARSE);
        if (status != LMN_OK) assert_non_null(strstr(err.text, ":2:"));
        scene_free(s);
    }
}

static void metals_have_names(void **state)
{
    (void)state;
    struct vec3 eta, k, same_eta, same_k;
    static const char *const sources[] = {"Be", "AlAs", "Hg", "K", "W", "TiO2", "Te-e", "SnTe"};
    for (size_t i = 0; i < sizeof sources / sizeof *sources; i++) {
        char palik[32];
        snprintf(palik, sizeof palik, "%s_palik", sources[i]);
        assert_true(find_conductor(sources[i], &eta, &k));
        assert_true(find_conductor(palik, &same_eta, &same_k));
        assert_memory_equal(&eta, &same_eta, sizeof eta);
        assert_memory_equal(&k, &same_k, sizeof k);
    }
    assert_true(find_conductor("Cu_palik", &eta, &k));
    near((double)eta.x, 0.213229);
    assert_true(find_conductor("none", &eta, &k));
    assert_true(eta.x == 0 && k.x == 1);
    assert_false(find_conductor("Na", &eta, &k));
    assert_false(find_conductor("_palik", &eta, &k));
    assert_false(find_conductor("", &eta, &k));
}

/* Numbers and colours of new materials follow variables. */
static void follow_variables(void **state)
{
    (void)state;
    text_write_string("v.xml", "<scene version='3.0.0'>" TEXT_SENSOR
                               "<bsdf type='blendbsdf' id='mix'><bsdf type='diffuse'/>"
                               "<bsdf type='principled' id='car'/></bsdf>"
                               "<bsdf type='bumpmap' id='bumps'><texture type='checkerboard'/>"
                               "<bsdf type='roughplastic'/></bsdf>"
                               "<shape type='sphere'><ref id='mix'/></shape>"
                               "<shape type='sphere'><ref id='bumps'/></shape></scene>");
    text_write_string(
        "v.variables.json",
        "{\"variables\": ["
        "{\"name\": \"w\", \"kind\": \"float\", \"targets\": \"mix.weight\", \"range\": [0, 1]},"
        "{\"name\": \"m\", \"kind\": \"float\", \"targets\": \"car.metallic\", \"range\": [0, 1]},"
        "{\"name\": \"b\", \"kind\": \"float\", \"targets\": \"bumps.scale\", \"range\": [0, 4]},"
        "{\"name\": \"a\", \"kind\": \"float\", \"targets\": \"bumps.alpha\", \"range\": [0.1, "
        "0.5]},"
        "{\"name\": \"c\", \"kind\": \"color\", \"targets\": \"car.base_color\","
        " \"range\": [0, 1]}]}");
    struct scene *s;
    struct error err;
    if (text_load_file("v.xml", NULL, &s, &err) != LMN_OK) fail_msg("%s", err.text);
    assert_int_equal(s->n_variables, 7);
    struct scene_state now = text_state(s);
    const float u[] = {0.25f, 0.5f, 0.75f, 1, 0.1f, 0.2f, 0.3f};
    scene_apply(s, u, &now);
    near((double)*text_value(s, &now, "mix.weight.value"), 0.25);
    near((double)*text_value(s, &now, "car.metallic.value"), 0.5);
    near((double)*text_value(s, &now, "bumps.scale"), 3);
    near((double)*text_value(s, &now, "bumps.nested_bsdf.alpha.value"), 0.5);
    near((double)text_value(s, &now, "car.base_color.value")[2], 0.3);
    scene_state_release(&now);
    scene_free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(have_defaults),
        cmocka_unit_test(are_read),
        cmocka_unit_test(are_nested),
        cmocka_unit_test(mixtures_are_blends),
        cmocka_unit_test(twosided_holds_what_is_opaque),
        cmocka_unit_test(metals_have_names),
        cmocka_unit_test(follow_variables),
    };
    return cmocka_run_group_tests_name("materials", tests, text_setup, text_teardown);
}
