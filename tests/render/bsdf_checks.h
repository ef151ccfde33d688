/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_RENDER_BSDF_CHECKS_H
#define TESTS_RENDER_BSDF_CHECKS_H

#include "render/bsdf.h"

/* What every material must fulfil: sampled directions against their density, sampled weights
 * against values, reciprocity, and that no more light comes out than goes in. A check fails the
 * test that calls it. */
struct material_case {
    const char *name;
    struct bsdf_point point;
    double loss;   /* the part of light that a white one may lose, seen from its front */
    double gain;   /* the part that it may win: models that are known not to conserve energy */
    bool has_back; /* light is scattered from behind as well, and no more of it lost */
    bool is_irreciprocal;
};

void check_directions(const struct material_case *cases, int n);
void check_weights(const struct material_case *cases, int n);
void check_energy(const struct material_case *cases, int n);
void check_reciprocity(const struct material_case *cases, int n);

/* White (in x) points to start from, index of refraction 1.5. */
struct bsdf_point checks_point(enum bsdf_kind kind, uint32_t lobes);
struct bsdf_point checks_rough(enum bsdf_kind kind, enum microfacet_kind facets, float alpha_u,
                               float alpha_v);

#endif
