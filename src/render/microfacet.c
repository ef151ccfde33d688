/* SPDX-License-Identifier: Apache-2.0 */
#include "render/microfacet.h"

#include "render/facets.h"

/* Compilers make one function of each kind. */
#define OF_KIND(f, name, ...)                                            \
    ((f)->kind == MICROFACET_GGX                                         \
         ? name(MICROFACET_GGX, (f)->alpha_u, (f)->alpha_v, __VA_ARGS__) \
         : name(MICROFACET_BECKMANN, (f)->alpha_u, (f)->alpha_v, __VA_ARGS__))

float microfacet_d(const struct microfacet *f, struct vec3 m)
{
    return OF_KIND(f, facets_d, m);
}

float microfacet_g1(const struct microfacet *f, struct vec3 v, struct vec3 m)
{
    return OF_KIND(f, facets_g1, v, m);
}

float microfacet_pdf(const struct microfacet *f, struct vec3 wi, struct vec3 m)
{
    return microfacet_d(f, m) * microfacet_g1(f, wi, m) * fabsf(vec3_dot(wi, m)) / wi.z;
}

struct vec3 microfacet_normal(const struct microfacet *f, struct vec3 wi, float u, float v)
{
    return OF_KIND(f, facets_normal, wi, u, v);
}
