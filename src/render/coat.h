/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_COAT_H
#define RENDER_COAT_H

#include "render/microfacet.h"

/*
 * What a rough dielectric interface lets through, for rough plastic: for light from outside by its
 * cosine mu, and the mean over all directions of what is reflected back inside. Both are integrals
 * over the visible facets (of Fresnel's reflectance and shadowing; Burley et al. in Mitsuba's
 * `roughplastic`), worked out for a row of roughnesses when they are first needed, then
 * interpolated: a variable roughness or a picture of it costs nothing more.
 */
enum { COAT_ROWS = 32, COAT_COLUMNS = 64 };

struct coat {
    bool is_set;
    enum microfacet_kind kind;
    float eta; /* index inside / outside */
    bool has_row[COAT_ROWS];
    float transmittance[COAT_ROWS][COAT_COLUMNS]; /* [alpha][mu] */
    float internal[COAT_ROWS];
};

/* A coat of one roughness: between rows `row` and `row` + 1. */
struct coat_at {
    const struct coat *coat;
    uint32_t row;
    float weight; /* of the second */
};

/* Makes it a coat of that kind; rows of another one are forgotten. */
void coat_init(struct coat *c, enum microfacet_kind kind, float eta);

/* Works out the rows that roughnesses from `least` to `most` need. */
void coat_prepare(struct coat *c, float least, float most);

/* For a roughness that is prepared. */
struct coat_at coat_at(const struct coat *c, float alpha);

/* The part of light at cosine mu >= 0 that gets in (or out again). */
float coat_transmittance(const struct coat_at *at, float mu);
float coat_internal(const struct coat_at *at);

#endif
