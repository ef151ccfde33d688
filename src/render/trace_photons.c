/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "base/mem.h"
#include "render/photon.h"
#include "scene/bounds.h"

/* Samples of a pass, an even number. Their radius is that of the first pass times n^(-1/6) for the
 * n-th: variance and bias vanish together (Knaus & Zwicker 2011, alpha = 2/3). */
enum { PASS_SPP = 32, MIN_PHOTONS = 1 << 16, MAX_PHOTONS = 1 << 20 };

struct passes {
    struct photon_map *maps[2]; /* for even and odd samples: the halves stay independent */
    float radius;               /* of the first pass */
    float *parts[4];            /* a pass's colour, halves, buffers; NULL where not wanted */
    size_t n_pixels;
};

static float **wanted(struct trace_output *out, int k)
{
    return k == 0 ? &out->color : k == 1 ? &out->half_a : k == 2 ? &out->half_b : &out->buffers;
}

static size_t n_channels(int k)
{
    return k == 3 ? BUFFER_CHANNELS : 3;
}

static void passes_release(struct passes *p)
{
    for (int k = 0; k < 2; k++) photon_map_free(p->maps[k]);
    for (int k = 0; k < 4; k++) mem_free(p->parts[k]);
}

static lmn_status passes_init(struct passes *p, const struct window *w, struct trace_output *out,
                              struct error *err)
{
    uint64_t n = 2 * (uint64_t)w->full_width * w->full_height;
    uint32_t n_photons = n < MIN_PHOTONS   ? MIN_PHOTONS
                         : n > MAX_PHOTONS ? MAX_PHOTONS
                                           : (uint32_t)n;
    lmn_status status = LMN_OK;
    *p = (struct passes){.n_pixels = (size_t)w->width * w->height};
    for (int k = 0; k < 2 && !status; k++) status = photon_map_new(n_photons, &p->maps[k], err);
    for (int k = 0; k < 4 && !status; k++) {
        if (!*wanted(out, k)) continue;
        p->parts[k] = mem_new(p->n_pixels * n_channels(k), sizeof **p->parts);
        if (!p->parts[k]) status = fail_memory(err, "passes");
    }
    return status;
}

/* Adds a pass that has `share` of all samples. Ids are those of the first sample. */
static void add_pass(const struct passes *p, struct trace_output *out, float share, bool is_first)
{
    for (int k = 0; k < 4; k++) {
        float *to = *wanted(out, k);
        const float *from = p->parts[k];
        size_t channels = n_channels(k);
        for (size_t i = 0; to && i < p->n_pixels * channels; i++) {
            bool is_id = k == 3 && i % channels >= BUFFER_SHAPE_ID;
            if (is_first) to[i] = is_id ? from[i] : 0.0f;
            if (!is_id) to[i] += share * from[i];
        }
    }
}

/* The photons of a pass. */
static void trace_photons(struct passes *p, const struct view *v, struct pool *pool,
                          const struct trace_settings *t, uint32_t pass)
{
    const struct bounds b = scene_bounds(view_scene(v), view_state(v));
    float scene_radius = 0.5f * vec3_length(vec3_sub(b.max, b.min));
    for (uint32_t k = 0; k < 2; k++) {
        struct photon_map *m = p->maps[k];
        photon_map_trace(m, v, pool, t, 2 * (uint64_t)pass + k);
        if (pass == 0 && k == 0) p->radius = photon_map_typical_radius(m, scene_radius);
        if (!(p->radius > 0.0f)) p->radius = 0.01f * scene_radius;
        photon_map_build(m, p->radius * powf((float)(pass + 1), -1.0f / 6.0f));
    }
}

/* Progress of all passes from that of one. */
struct progress {
    lmn_progress_fn *fn;
    void *user;
    uint32_t pass, n_passes;
};

static int report(void *user, double done, double total)
{
    const struct progress *p = user;
    return p->fn(p->user, p->pass * total + done, p->n_passes * total);
}

lmn_status view_trace_photons(const struct view *v, struct pool *pool,
                              const struct trace_settings *t, const struct window *w,
                              struct trace_output *out, lmn_progress_fn *progress,
                              void *progress_user, struct error *err)
{
    lmn_status status = LMN_OK;
    struct trace_settings s = *t;
    struct passes p;
    uint32_t spp = (t->spp + 1) / 2 * 2;
    struct progress told = {progress, progress_user, 0, (spp + PASS_SPP - 1) / PASS_SPP};
    TRY(passes_init(&p, w, out, err));
    struct trace_output part = {
        .color = p.parts[0], .half_a = p.parts[1], .half_b = p.parts[2], .buffers = p.parts[3]};
    for (uint32_t first = 0; first < spp; first += PASS_SPP) {
        trace_photons(&p, v, pool, t, told.pass);
        s.first_sample = first;
        s.spp = spp - first < PASS_SPP ? spp - first : PASS_SPP;
        s.photons[0] = p.maps[0];
        s.photons[1] = p.maps[1];
        TRY(view_trace_parallel(v, pool, &s, w, &part, progress ? report : NULL, &told, err));
        add_pass(&p, out, (float)s.spp / (float)spp, first == 0);
        told.pass++;
    }
done:
    passes_release(&p);
    return status;
}
