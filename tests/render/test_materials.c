/* SPDX-License-Identifier: Apache-2.0 */
/* Layered, mixed and mapped materials: the checks of bsdf_checks.h. */
#include "shelf.h"

enum { MAX_CASES = 48 };

struct described {
    const char *name;
    const struct bsdf *bsdf;
    double loss, gain;
    bool has_back, is_irreciprocal;
};

static int describe(struct described *d)
{
    int n = 0;
    shelf.n_bsdfs = shelf.n_textures = 0;
    struct bsdf *white = put(BSDF_DIFFUSE), *mirror = put(BSDF_CONDUCTOR),
                *nothing = put(BSDF_NULL);
    struct bsdf *glass = put(BSDF_DIELECTRIC);
    struct bsdf *metal = rough(BSDF_ROUGH_CONDUCTOR, MICROFACET_GGX, 0.3f);
    struct bsdf *frost = rough(BSDF_ROUGH_DIELECTRIC, MICROFACET_GGX, 0.3f);

    struct bsdf *f = rough(BSDF_ROUGH_PLASTIC, MICROFACET_BECKMANN, 0.1f);
    d[n++] = (struct described){"rough plastic, Beckmann", f, .loss = 0.1};
    f = rough(BSDF_ROUGH_PLASTIC, MICROFACET_GGX, 0.25f);
    d[n++] = (struct described){"rough plastic, GGX", f, .loss = 0.35};
    f = rough(BSDF_ROUGH_PLASTIC, MICROFACET_GGX, 0.7f);
    f->is_nonlinear = true;
    /* Light that meets another facet is lost, on the way in and out. */
    d[n++] = (struct described){"rough plastic, nonlinear", f, .loss = 0.75};
    d[n++] = (struct described){"thin dielectric", put(BSDF_THIN_DIELECTRIC), .loss = 1e-5,
                                .has_back = true};
    d[n++] = (struct described){"null", nothing, .loss = 1e-6, .has_back = true};
    f = rough(BSDF_ROUGH_DIFFUSE, MICROFACET_BECKMANN, 0.2f);
    d[n++] = (struct described){"rough diffuse", f, .loss = 0.1, .gain = 0.02};
    f = rough(BSDF_ROUGH_DIFFUSE, MICROFACET_BECKMANN, 0.6f);
    d[n++] = (struct described){"very rough diffuse", f, .loss = 0.25, .gain = 0.02};
    f = rough(BSDF_ROUGH_DIFFUSE, MICROFACET_BECKMANN, 0.6f);
    f->is_approximate = true;
    d[n++] = (struct described){"rough diffuse, approximate", f, .loss = 0.35, .gain = 0.02};

    static const float exponents[3] = {0, 12, 150};
    for (int i = 0; i < 3; i++) {
        d[n++] = (struct described){"phong", phong(BSDF_PHONG, exponents[i]), .loss = 0.6};
        d[n++] = (struct described){"blinn-phong", phong(BSDF_BLINN_PHONG, exponents[i]),
                                    .loss = 0.6, .gain = 0.05};
    }

    /* Burley's diffuse term grows towards grazing angles by design; sheen and coat come on top. */
    d[n++] = (struct described){"principled", principled(0.5f, NULL, 0), .loss = 0.6, .gain = 0.2};
    static const float paint[][2] = {
        {PRINCIPLED_SPEC_TINT, 0.5f},  {PRINCIPLED_SHEEN, 0.6f},
        {PRINCIPLED_SHEEN_TINT, 0.5f}, {PRINCIPLED_FLATNESS, 0.4f},
        {PRINCIPLED_CLEARCOAT, 1.0f},  {PRINCIPLED_CLEARCOAT_GLOSS, 0.2f}};
    d[n++] = (struct described){"principled paint", principled(0.3f, paint, 6), .loss = 0.6,
                                .gain = 0.6};
    static const float brushed[][2] = {{PRINCIPLED_METALLIC, 1.0f}, {PRINCIPLED_ANISOTROPIC, 0.8f}};
    d[n++] = (struct described){"principled metal", principled(0.5f, brushed, 2), .loss = 0.5};
    static const float clear[][2] = {{PRINCIPLED_SPEC_TRANS, 1.0f}};
    d[n++] = (struct described){"principled glass", principled(0.5f, clear, 1), .loss = 0.5,
                                .has_back = true};
    static const float part[][2] = {
        {PRINCIPLED_SPEC_TRANS, 0.6f}, {PRINCIPLED_METALLIC, 0.3f}, {PRINCIPLED_CLEARCOAT, 0.5f}};
    /* From behind, only the part that is glass does anything. */
    d[n++] = (struct described){
        "principled, all of it", principled(0.6f, part, 3), .loss = 0.7, .gain = 0.2,
        .has_back = false,       .is_irreciprocal = true};

    d[n++] = (struct described){"blend of mirror and white", blend(mirror, white, 0.3f),
                                .loss = 1e-5};
    f = blend(blend(mirror, nothing, 0.4f), white, 0.5f);
    d[n++] = (struct described){"blend of a blend", f, .loss = 1e-5};
    struct bsdf *black = put(BSDF_DIFFUSE);
    black->reflectance = number(0.0f);
    d[n++] = (struct described){"blend of black and white", blend(black, white, 0.6f), .loss = 0.4};
    d[n++] = (struct described){"blend of rough ones", blend(metal, white, 0.6f), .loss = 0.2};
    d[n++] = (struct described){"blend of glass", blend(glass, frost, 0.5f), .loss = 0.15,
                                .has_back = true};
    f = put(BSDF_MASK);
    f->child[0] = index_of(blend(frost, nothing, 0.25f));
    f->opacity = number(0.7f);
    d[n++] = (struct described){"masked blend", f, .loss = 0.2, .has_back = true};

    /* A normal that leans to the side: light is lost below the surface. */
    struct bsdf *leaning = around(BSDF_NORMALMAP, white);
    leaning->normals = color(0.7f, 0.4f, 0.9f);
    leaning->flips_normals = false;
    d[n++] = (struct described){"normal map", leaning, .loss = 1, .is_irreciprocal = true};
    f = around(BSDF_NORMALMAP, frost);
    f->normals = color(0.65f, 0.55f, 0.95f);
    f->flips_normals = f->has_shadowing = false;
    d[n++] = (struct described){"normal map on frost", f, .loss = 1, .is_irreciprocal = true};
    f = around(BSDF_NORMALMAP, blend(metal, white, 0.5f));
    f->normals = color(0.4f, 0.3f, 0.9f);
    f->flips_normals = false;
    d[n++] = (struct described){"normal map on a blend", f, .loss = 1, .is_irreciprocal = true};
    f = blend(leaning, metal, 0.5f);
    d[n++] = (struct described){"blend with a normal map", f, .loss = 1, .is_irreciprocal = true};
    assert_true(n <= MAX_CASES);
    return n;
}

static int make_cases(struct material_case *cases)
{
    struct described d[MAX_CASES];
    int n = describe(d);
    prepare();
    for (int i = 0; i < n; i++)
        cases[i] = (struct material_case){.name = d[i].name,
                                          .point = point_at(d[i].bsdf, vec3(0, 0, 1)),
                                          .loss = d[i].loss,
                                          .gain = d[i].gain,
                                          .has_back = d[i].has_back,
                                          .is_irreciprocal = d[i].is_irreciprocal};
    return n;
}

static void directions_follow_the_density(void **state)
{
    (void)state;
    struct material_case cases[MAX_CASES];
    check_directions(cases, make_cases(cases));
}

static void weights_are_value_by_density(void **state)
{
    (void)state;
    struct material_case cases[MAX_CASES];
    check_weights(cases, make_cases(cases));
}

static void energy(void **state)
{
    (void)state;
    struct material_case cases[MAX_CASES];
    check_energy(cases, make_cases(cases));
}

static void reciprocity(void **state)
{
    (void)state;
    struct material_case cases[MAX_CASES];
    check_reciprocity(cases, make_cases(cases));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(directions_follow_the_density),
        cmocka_unit_test(weights_are_value_by_density),
        cmocka_unit_test(energy),
        cmocka_unit_test(reciprocity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
