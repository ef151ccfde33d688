/* SPDX-License-Identifier: Apache-2.0 */
/* (1 - weight) of one material and weight of another. Each is looked up at the point when asked
 * for, so that blends can be nested. */
#include "render/bsdf.h"

static void child_init(struct bsdf_point *child, const struct bsdf_point *p, int i, struct vec3 wi)
{
    struct bsdf_place at = p->place;
    at.wi = wi;
    bsdf_point_init(child, p->materials, p->child[i], p->textures, &at);
}

void blend_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
                float *pdf)
{
    for (int i = 0; i < 2; i++) {
        float weight = i == 0 ? 1.0f - p->weight : p->weight, child_pdf;
        struct bsdf_point child;
        struct vec3 child_value;
        if (weight == 0.0f) continue;
        child_init(&child, p, i, wi);
        if (!(child.lobes & LOBE_SMOOTH)) continue;
        bsdf_eval(&child, wi, wo, &child_value, &child_pdf);
        *value = vec3_madd(*value, child_value, weight);
        *pdf += weight * child_pdf;
    }
}

void blend_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2, float v2,
                  struct bsdf_sample *s)
{
    int chosen = u1 < p->weight;
    float weight = chosen ? p->weight : 1.0f - p->weight;
    struct bsdf_point child;
    child_init(&child, p, chosen, wi);
    u1 = chosen ? u1 / weight : (u1 - p->weight) / weight;
    *s = bsdf_sample(&child, wi, min_float(u1, 0x1.fffffep-1f), u2, v2);
    if (!(s->pdf > 0.0f) || !(s->lobe & LOBE_SMOOTH) || weight == 1.0f) {
        s->pdf *= weight;
        return;
    }
    /* A black part draws directions, too; none that it does not say it would draw. */
    struct vec3 unused;
    if (vec3_is_zero(s->weight)) bsdf_eval(&child, wi, s->wo, &unused, &s->pdf);
    if (!(s->pdf > 0.0f)) return;
    struct vec3 value = vec3_scale(s->weight, s->pdf * weight);
    s->pdf *= weight;
    /* The other could have drawn this direction as well. */
    struct vec3 other;
    float other_pdf;
    child_init(&child, p, !chosen, wi);
    if (!(child.lobes & LOBE_SMOOTH)) return;
    bsdf_eval(&child, wi, s->wo, &other, &other_pdf);
    s->pdf += (1.0f - weight) * other_pdf;
    s->weight = vec3_scale(vec3_madd(value, other, 1.0f - weight), 1.0f / s->pdf);
}
