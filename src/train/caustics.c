/* SPDX-License-Identifier: Apache-2.0 */
#include "train/caustics.h"

#include <math.h>

#include "scene/bounds.h"

/* Others that a photon spreads among at first, and the steps until their number falls as the cube
 * root of the steps. */
#define NEIGHBOURS  3.0f
#define BLUNT_STEPS 20000.0

/* Spreading where there is no typical photon, by the scene's radius. */
#define LONELY 0.01f

lmn_status caustics_init(struct caustics *c, uint32_t n_photons, struct error *err)
{
    lmn_status status = LMN_OK;
    *c = (struct caustics){0};
    for (int k = 0; k < 2 && status == LMN_OK; k++)
        status = photon_map_new(n_photons, &c->maps[k], err);
    return status;
}

void caustics_release(struct caustics *c)
{
    for (int k = 0; k < 2; k++) photon_map_free(c->maps[k]);
    *c = (struct caustics){0};
}

uint64_t caustics_memory_size(const struct caustics *c)
{
    return photon_map_memory(c->maps[0]) + photon_map_memory(c->maps[1]);
}

void caustics_trace(struct caustics *c, const struct view *v, const struct trace_settings *t,
                    uint64_t step)
{
    const float neighbours = NEIGHBOURS / (float)cbrt(1.0 + (double)step / BLUNT_STEPS);
    const struct bounds b = scene_bounds(view_scene(v), view_state(v));
    const float scene_radius = 0.5f * vec3_length(vec3_sub(b.max, b.min));
    for (uint32_t k = 0; k < 2; k++) {
        struct photon_map *m = c->maps[k];
        photon_map_trace(m, v, NULL, t, k);
        const float radius = photon_map_typical_radius(m, scene_radius);
        photon_map_build(m, radius > 0.0f ? radius : LONELY * scene_radius);
        photon_map_sharpen(m, neighbours);
    }
}
