/* SPDX-License-Identifier: Apache-2.0 */
/* The rough materials of facets.h in vector code, for one instruction set: a part of
 * stream_kernels.h. Lanes of one material and kind of facets are brought together, worked on, and
 * brought back. */
#include "render/facets.h"

/* From the lanes of a list; directions into the material's own frame. */
static void facets_gather_list(struct facet_block *b, struct stream *s, enum facet_list list)
{
    uint32_t *lanes = s->facets[list];
    b->n = s->n_facets[list];
    b->n_filled = stream_whole(b->n);
    for (uint32_t k = b->n; k < b->n_filled; k++) lanes[k] = lanes[0];
    for (uint32_t k = 0; k < b->n_filled; k++) {
        const uint32_t i = lanes[k];
        const struct bsdf_point *p = s->bsdf[i];
        const float side = p->is_mirrored ? -1.0f : 1.0f;
        struct vec3 wi = lanes3_get(&s->wi, i);
        lanes3_set(&b->wi, k, vec3(wi.x, wi.y, wi.z * side));
        b->alpha_u[k] = p->facets.alpha_u;
        b->alpha_v[k] = p->facets.alpha_v;
        if (facet_list_is_plastic(list)) {
            lanes3_set(&b->base, k, lanes3_get(&s->reflectance, i));
            lanes3_set(&b->specular, k, p->specular_reflectance);
            b->index[k] = p->eta;
            b->specular_weight[k] = p->specular_weight;
            b->internal[k] = p->internal_reflection;
            b->nonlinear[k] = p->is_nonlinear ? 1.0f : 0.0f;
            b->t_i[k] = coat_transmittance(&p->coat, max_float(wi.z * side, 0.0f));
        } else if (facet_list_is_dielectric(list)) {
            lanes3_set(&b->specular, k, p->specular_reflectance);
            lanes3_set(&b->base, k, p->specular_transmittance);
            b->index[k] = p->eta;
        } else {
            lanes3_set(&b->specular, k, lanes3_get(&s->reflectance, i));
            lanes3_set(&b->eta, k, p->eta_rgb);
            lanes3_set(&b->k, k, p->k_rgb);
        }
    }
}

static void facets_gather(struct stream *s)
{
    for (enum facet_list list = 0; list < FACET_LISTS_N; list++)
        if (s->n_facets[list] > 0) facets_gather_list(&s->facet_blocks[list], s, list);
}

static void facets_let_out(struct facet_block *b, const struct stream *s, enum facet_list list)
{
    if (!facet_list_is_plastic(list)) return;
    for (uint32_t k = 0; k < b->n_filled; k++)
        b->t_o[k] = coat_transmittance(&s->bsdf[s->facets[list][k]]->coat,
                                       max_float(b->wo.z[k], 0.0f));
}

LANE void facets_eval_lane(struct facet_block *b, uint32_t k, enum facet_list list)
{
    const enum microfacet_kind kind = facet_list_kind(list);
    struct vec3 value, wi = lanes3_get(&b->wi, k), wo = lanes3_get(&b->wo, k);
    float pdf;
    if (facet_list_is_plastic(list)) {
        facets_plastic_eval(kind, b->alpha_u[k], b->alpha_v[k], b->index[k], b->specular_weight[k],
                            b->internal[k], b->nonlinear[k], lanes3_get(&b->base, k),
                            lanes3_get(&b->specular, k), wi, wo, b->t_i[k], b->t_o[k], &value,
                            &pdf);
    } else if (facet_list_is_dielectric(list)) {
        facets_dielectric_eval(kind, b->alpha_u[k], b->alpha_v[k], b->index[k],
                               lanes3_get(&b->specular, k), lanes3_get(&b->base, k), wi, wo, &value,
                               &pdf);
    } else {
        facets_conductor_eval(kind, b->alpha_u[k], b->alpha_v[k], lanes3_get(&b->eta, k),
                              lanes3_get(&b->k, k), lanes3_get(&b->specular, k), wi, wo, &value,
                              &pdf);
    }
    lanes3_set(&b->value, k, value);
    b->pdf[k] = pdf;
}

LANE void facets_sample_lane(struct facet_block *b, uint32_t k, enum facet_list list)
{
    const enum microfacet_kind kind = facet_list_kind(list);
    struct vec3 wi = lanes3_get(&b->wi, k), wo, weight;
    if (facet_list_is_plastic(list)) {
        wo = facets_plastic_sample(kind, b->alpha_u[k], b->alpha_v[k], b->specular_weight[k], wi,
                                   b->t_i[k], b->u1[k], b->u2[k], b->v2[k]);
    } else if (facet_list_is_dielectric(list)) {
        float pdf, eta;
        facets_dielectric_sample(kind, b->alpha_u[k], b->alpha_v[k], b->index[k],
                                 lanes3_get(&b->specular, k), lanes3_get(&b->base, k), wi, b->u1[k],
                                 b->u2[k], b->v2[k], &wo, &weight, &pdf, &eta);
        lanes3_set(&b->value, k, weight);
        b->pdf[k] = pdf;
        b->wo_eta[k] = eta;
    } else {
        float pdf;
        facets_conductor_sample(kind, b->alpha_u[k], b->alpha_v[k], lanes3_get(&b->eta, k),
                                lanes3_get(&b->k, k), lanes3_get(&b->specular, k), wi, b->u2[k],
                                b->v2[k], &wo, &weight, &pdf);
        lanes3_set(&b->value, k, weight);
        b->pdf[k] = pdf;
    }
    lanes3_set(&b->wo, k, wo);
}

/* A loop of vectors for each list. */
#define FACET_LOOP(b, lane)                                              \
    do {                                                                 \
        const uint32_t n_lanes = (b)->n_filled;                          \
        _Pragma("omp simd") for (uint32_t k = 0; k < n_lanes; k++) lane; \
    } while (0)

#define FACET_LISTS(b, name, list)                                \
    do {                                                          \
        if ((list) == FACET_CONDUCTOR_GGX)                        \
            FACET_LOOP(b, name(b, k, FACET_CONDUCTOR_GGX));       \
        else if ((list) == FACET_CONDUCTOR_BECKMANN)              \
            FACET_LOOP(b, name(b, k, FACET_CONDUCTOR_BECKMANN));  \
        else if ((list) == FACET_PLASTIC_GGX)                     \
            FACET_LOOP(b, name(b, k, FACET_PLASTIC_GGX));         \
        else if ((list) == FACET_PLASTIC_BECKMANN)                \
            FACET_LOOP(b, name(b, k, FACET_PLASTIC_BECKMANN));    \
        else if ((list) == FACET_DIELECTRIC_GGX)                  \
            FACET_LOOP(b, name(b, k, FACET_DIELECTRIC_GGX));      \
        else                                                      \
            FACET_LOOP(b, name(b, k, FACET_DIELECTRIC_BECKMANN)); \
    } while (0)

KERNEL facets_eval_block(struct facet_block *b, enum facet_list list)
{
    FACET_LISTS(b, facets_eval_lane, list);
}

KERNEL facets_sample_block(struct facet_block *b, enum facet_list list)
{
    FACET_LISTS(b, facets_sample_lane, list);
}

/* Values and densities towards the lights, of all lists. */
static void facets_eval(struct stream *s)
{
    for (enum facet_list list = 0; list < FACET_LISTS_N; list++) {
        struct facet_block *b = &s->facet_blocks[list];
        if (s->n_facets[list] == 0) continue;
        for (uint32_t k = 0; k < b->n_filled; k++) {
            const uint32_t i = s->facets[list][k];
            const float side = s->bsdf[i]->is_mirrored ? -1.0f : 1.0f;
            struct vec3 wo = lanes3_get(&s->light_wo, i);
            lanes3_set(&b->wo, k, vec3(wo.x, wo.y, wo.z * side));
        }
        facets_let_out(b, s, list);
        facets_eval_block(b, list);
        for (uint32_t k = 0; k < b->n; k++) {
            const uint32_t i = s->facets[list][k];
            bool is_lit = facet_list_is_dielectric(list) ||
                          (b->wi.z[k] > 0.0f && b->wo.z[k] > 0.0f);
            lanes3_set(&s->value, i, is_lit ? lanes3_get(&b->value, k) : vec3_splat(0.0f));
            s->value_pdf[i] = is_lit ? b->pdf[k] : 0.0f;
        }
    }
}

/* The next directions, of all lists. */
static void facets_sample(struct stream *s)
{
    for (enum facet_list list = 0; list < FACET_LISTS_N; list++) {
        struct facet_block *b = &s->facet_blocks[list];
        if (s->n_facets[list] == 0) continue;
        for (uint32_t k = 0; k < b->n_filled; k++) {
            const uint32_t i = s->facets[list][k];
            b->u1[k] = s->u[4][i];
            b->u2[k] = s->u[2][i];
            b->v2[k] = s->u[3][i];
        }
        facets_sample_block(b, list);
        if (facet_list_is_plastic(list)) {
            facets_let_out(b, s, list);
            facets_eval_block(b, list);
        }
        for (uint32_t k = 0; k < b->n; k++) {
            const uint32_t i = s->facets[list][k];
            const float side = s->bsdf[i]->is_mirrored ? -1.0f : 1.0f, pdf = b->pdf[k];
            struct vec3 wo = lanes3_get(&b->wo, k), weight = lanes3_get(&b->value, k);
            bool is_finite = vec3_is_finite(wo); /* not of absurd values, or from below */
            bool is_above = facet_list_is_dielectric(list) || (b->wi.z[k] > 0.0f && wo.z > 0.0f);
            bool is_lit = is_finite && is_above && pdf > 0.0f;
            if (facet_list_is_plastic(list)) weight = vec3_scale(weight, 1.0f / pdf);
            if (!is_lit) weight = vec3_splat(0.0f);
            lanes3_set(&s->wo, i, is_finite ? vec3(wo.x, wo.y, wo.z * side) : vec3(0, 0, 1));
            lanes3_set(&s->weight, i, weight);
            s->wo_pdf[i] = pdf;
            s->wo_eta[i] = facet_list_is_dielectric(list) ? b->wo_eta[k] : 1.0f;
            s->wo_is_delta[i] = 0;
        }
    }
}
