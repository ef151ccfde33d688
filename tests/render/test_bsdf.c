/* SPDX-License-Identifier: Apache-2.0 */
/* The basic materials; test_materials.c has the others. */
#include "bsdf_checks.h"

#include "../image/cmocka_all.h"

enum { N_CASES = 17 };

static int make_cases(struct material_case cases[N_CASES])
{
    int n = 0;
    struct bsdf_point p = checks_point(BSDF_DIFFUSE, LOBE_DIFFUSE);
    cases[n++] = (struct material_case){"diffuse", p, .loss = 1e-6};
    p.is_mirrored = true;
    cases[n++] = (struct material_case){"diffuse from behind", p, .loss = 1e-6};
    p.is_mirrored = false;
    p.opacity = 0.4f;
    p.lobes |= LOBE_NULL;
    cases[n++] = (struct material_case){"masked diffuse", p, .loss = 1e-6};
    cases[n++] = (struct material_case){"conductor", checks_point(BSDF_CONDUCTOR, LOBE_SPECULAR),
                                        .loss = 1e-6};
    cases[n++] = (struct material_case){"dielectric", checks_point(BSDF_DIELECTRIC, LOBE_SPECULAR),
                                        .loss = 1e-5, .has_back = true};
    static const float alphas[2] = {0.2f, 0.7f};
    for (int k = 0; k < 2; k++) {
        enum microfacet_kind kind = k ? MICROFACET_GGX : MICROFACET_BECKMANN;
        static const double losses[2] = {0.2, 0.6};
        for (int a = 0; a < 2; a++)
            cases[n++] = (struct material_case){
                k ? "rough conductor, GGX" : "rough conductor, Beckmann",
                checks_rough(BSDF_ROUGH_CONDUCTOR, kind, alphas[a], alphas[a]), .loss = losses[a]};
        for (int a = 0; a < 2; a++)
            cases[n++] = (struct material_case){
                k ? "rough dielectric, GGX" : "rough dielectric, Beckmann",
                checks_rough(BSDF_ROUGH_DIELECTRIC, kind, alphas[a], alphas[a]), .loss = losses[a],
                .has_back = true};
    }
    cases[n++] = (struct material_case){
        "rough conductor, anisotropic",
        checks_rough(BSDF_ROUGH_CONDUCTOR, MICROFACET_GGX, 0.15f, 0.5f), .loss = 0.5};
    cases[n++] = (struct material_case){
        "rough dielectric, anisotropic",
        checks_rough(BSDF_ROUGH_DIELECTRIC, MICROFACET_GGX, 0.15f, 0.5f), .loss = 0.5,
        .has_back = true};
    p = checks_point(BSDF_PLASTIC, LOBE_DIFFUSE | LOBE_SPECULAR);
    p.specular_weight = 0.6f;
    p.internal_reflection = 0.5966f; /* of 1 / 1.5 */
    cases[n++] = (struct material_case){"plastic", p, .loss = 0.02};
    p.is_nonlinear = true;
    cases[n++] = (struct material_case){"plastic, nonlinear", p, .loss = 0.02};
    return n;
}

static void directions_follow_the_density(void **state)
{
    (void)state;
    struct material_case cases[N_CASES];
    check_directions(cases, make_cases(cases));
}

static void weights_are_value_by_density(void **state)
{
    (void)state;
    struct material_case cases[N_CASES];
    check_weights(cases, make_cases(cases));
}

static void energy(void **state)
{
    (void)state;
    struct material_case cases[N_CASES];
    check_energy(cases, make_cases(cases));
}

static void reciprocity(void **state)
{
    (void)state;
    struct material_case cases[N_CASES];
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
