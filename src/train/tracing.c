/* SPDX-License-Identifier: Apache-2.0 */
#include "train/tracing.h"

#include "base/mem.h"
#include "scene/assign.h"

enum { TRIALS = 8, PASS_SPP = 32, PATHS_PER_PHOTON = 8, MIN_PHOTONS = 1 << 11 };

lmn_status tracing_has_photons(uint32_t integrator, const struct workplace *place,
                               const struct trace_settings *t, bool *out, struct error *err)
{
    lmn_status status = LMN_OK;
    const struct scene *s = place->scene;
    struct view *view = NULL;
    float *u = NULL;
    *out = integrator == LMN_INTEGRATOR_PHOTONS;
    if (integrator != LMN_INTEGRATOR_AUTO) return LMN_OK;
    u = mem_new((size_t)s->n_variables + 1, sizeof *u);
    if (!u) {
        status = fail_memory(err, "tracing");
        goto done;
    }
    TRY(view_new(place->world, &view, err)); /* at the defaults */
    TRY(view_wants_photons(view, place->pool, t, out, err));
    for (uint32_t i = 0; i < TRIALS && !*out; i++) {
        scene_random_units(s, 0, i, u);
        view_set(view, u);
        TRY(view_wants_photons(view, place->pool, t, out, err));
    }
done:
    view_free(view);
    mem_free(u);
    return status;
}

/* A pass has two maps for its PASS_SPP samples, so that a quarter as many photons fly as paths. */
uint32_t tracing_n_photons(uint32_t n_pixels, uint32_t spp)
{
    uint64_t n_paths = (uint64_t)n_pixels * (spp < PASS_SPP ? spp : PASS_SPP);
    uint64_t n = n_paths / PATHS_PER_PHOTON;
    return n < MIN_PHOTONS ? MIN_PHOTONS : (uint32_t)n;
}
