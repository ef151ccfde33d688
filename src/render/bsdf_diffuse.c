/* SPDX-License-Identifier: Apache-2.0 */
/* Lambert's law, one-sided: value = reflectance cos / pi, sampled exactly. */
#include "render/bsdf.h"

void diffuse_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
                  float *pdf)
{
    if (wi.z <= 0.0f || wo.z <= 0.0f) return;
    *pdf = wo.z * MATH_INV_PI;
    *value = vec3_scale(p->reflectance, *pdf);
}

void diffuse_sample(const struct bsdf_point *p, struct vec3 wi, float u2, float v2,
                    struct bsdf_sample *s)
{
    if (wi.z <= 0.0f) return;
    s->wo = warp_cosine_hemisphere(u2, v2);
    s->pdf = warp_cosine_hemisphere_pdf(s->wo.z);
    s->lobe = LOBE_DIFFUSE;
    if (s->pdf > 0.0f) s->weight = p->reflectance;
}
