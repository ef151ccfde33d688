/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "render/photon.h"
#include "scene/bounds.h"

/* Samples of a pass, an even number. Their radius is that of the first pass times n^(-1/6) for the
 * n-th: variance and bias vanish together (Knaus & Zwicker 2011, alpha = 2/3). */
enum { PASS_SPP = 32, MIN_PHOTONS = 1 << 13, MAX_PHOTONS = 1 << 19 };

enum { PARTS = 6, PART_BUFFERS = 3, PART_GROUPS = 4, PART_CHAIN = 5 };

struct photon_passes {
    struct photon_map *maps[2]; /* for even and odd samples: the halves stay independent */
    float radius;               /* of the first pass of the picture under way */
    float *parts[PARTS];        /* a pass's colour, halves, buffers, groups, chain; or NULL */
    size_t n_pixels;            /* room in each */
    uint64_t memory_size;
};

static float **wanted(struct trace_output *out, int k)
{
    float **all[PARTS] = {&out->color,   &out->half_a, &out->half_b,
                          &out->buffers, &out->groups, &out->chain};
    return all[k];
}

/* Floats for each pixel. */
static size_t n_channels(const struct trace_output *out, int k)
{
    if (k == PART_BUFFERS) return BUFFER_CHANNELS;
    if (k == PART_CHAIN) return CHAIN_CHANNELS;
    return k == PART_GROUPS ? 3 * (size_t)out->n_groups : 3;
}

void photon_passes_free(struct photon_passes *p)
{
    if (!p) return;
    for (int k = 0; k < 2; k++) photon_map_free(p->maps[k]);
    for (int k = 0; k < PARTS; k++) mem_free(p->parts[k]);
    mem_free(p);
}

uint64_t photon_passes_memory(const struct photon_passes *p)
{
    return p->memory_size;
}

lmn_status photon_passes_new(uint32_t n_photons, size_t n_pixels, const struct trace_output *want,
                             struct photon_passes **out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct trace_output like = *want;
    struct photon_passes *p = mem_new(1, sizeof *p);
    *out = NULL;
    if (!p) return fail_memory(err, "photons");
    p->n_pixels = n_pixels;
    p->memory_size = sizeof *p;
    for (int k = 0; k < 2; k++) {
        TRY(photon_map_new(n_photons, &p->maps[k], err));
        p->memory_size += photon_map_memory(p->maps[k]);
    }
    for (int k = 0; k < PARTS; k++) {
        if (!*wanted(&like, k)) continue;
        size_t n = n_pixels * n_channels(want, k);
        p->parts[k] = mem_new(n, sizeof **p->parts);
        p->memory_size += n * sizeof **p->parts;
        if (!p->parts[k] && n > 0) {
            status = fail_memory(err, "photons");
            goto done;
        }
    }
    *out = p;
    p = NULL;
done:
    photon_passes_free(p);
    return status;
}

/* Adds a pass that has `share` of all samples. Ids are those of the first sample. */
static void add_pass(const struct photon_passes *p, struct trace_output *out, size_t n_pixels,
                     float share, bool is_first)
{
    for (int k = 0; k < PARTS; k++) {
        float *to = *wanted(out, k);
        const float *from = p->parts[k];
        size_t channels = n_channels(out, k);
        for (size_t i = 0; to && i < n_pixels * channels; i++) {
            bool is_id = k == PART_BUFFERS && i % channels >= BUFFER_SHAPE_ID;
            if (is_first) to[i] = is_id ? from[i] : 0.0f;
            if (!is_id) to[i] += share * from[i];
        }
    }
}

/* Colour is the sum of groups, to the last bit. */
static void add_groups(struct trace_output *out, size_t n_pixels)
{
    if (!out->groups || !out->color) return;
    for (size_t i = 0; i < 3 * n_pixels; i++) {
        float sum = 0.0f;
        for (uint32_t g = 0; g < out->n_groups; g++) sum += out->groups[g * 3 * n_pixels + i];
        out->color[i] = sum;
    }
}

/* The photons of a pass. */
static void trace_photons(struct photon_passes *p, const struct view *v, struct pool *pool,
                          const struct trace_settings *t, uint32_t pass)
{
    const struct bounds b = scene_bounds(view_scene(v), view_state(v));
    float scene_radius = 0.5f * vec3_length(vec3_sub(b.max, b.min));
    for (uint32_t k = 0; k < 2; k++) {
        struct photon_map *m = p->maps[k];
        photon_map_trace(m, v, pool, t, 2 * (uint64_t)pass + k);
        if (!(p->radius > 0.0f) && k == 0) p->radius = photon_map_typical_radius(m, scene_radius);
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

lmn_status photon_passes_trace(struct photon_passes *p, const struct view *v, struct pool *pool,
                               const struct trace_settings *t, const struct window *w,
                               struct trace_output *out, lmn_progress_fn *progress,
                               void *progress_user, struct error *err)
{
    lmn_status status = LMN_OK;
    struct trace_settings s = *t;
    const size_t n_pixels = (size_t)w->width * w->height;
    uint32_t spp = (t->spp + 1) / 2 * 2;
    /* A picture of later samples has the photons of later passes. */
    const uint32_t first_pass = t->first_sample / PASS_SPP;
    struct progress told = {progress, progress_user, 0, (spp + PASS_SPP - 1) / PASS_SPP};
    struct trace_output part = *out;
    for (int k = 0; k < PARTS; k++) *wanted(&part, k) = p->parts[k];
    p->radius = 0.0f; /* of this configuration's photons */
    for (uint32_t first = 0; first < spp; first += PASS_SPP) {
        trace_photons(p, v, pool, t, first_pass + told.pass);
        s.first_sample = t->first_sample + first;
        s.spp = spp - first < PASS_SPP ? spp - first : PASS_SPP;
        s.photons[0] = p->maps[0];
        s.photons[1] = p->maps[1];
        if (part.groups)
            memset(part.groups, 0, n_pixels * n_channels(out, PART_GROUPS) * sizeof *part.groups);
        if (pool)
            TRY(view_trace_parallel(v, pool, &s, w, &part, progress ? report : NULL, &told, err));
        else
            view_trace(v, &s, w, &part);
        add_pass(p, out, n_pixels, (float)s.spp / (float)spp, first == 0);
        told.pass++;
    }
    add_groups(out, n_pixels);
done:
    return status;
}

lmn_status view_trace_photons(const struct view *v, struct pool *pool,
                              const struct trace_settings *t, const struct window *w,
                              struct trace_output *out, lmn_progress_fn *progress,
                              void *progress_user, struct error *err)
{
    uint64_t n = (uint64_t)w->full_width * w->full_height; /* a photon for each pixel */
    uint32_t n_photons = n < MIN_PHOTONS   ? MIN_PHOTONS
                         : n > MAX_PHOTONS ? MAX_PHOTONS
                                           : (uint32_t)n;
    struct photon_passes *p;
    lmn_status status = photon_passes_new(n_photons, (size_t)w->width * w->height, out, &p, err);
    if (status == LMN_OK)
        status = photon_passes_trace(p, v, pool, t, w, out, progress, progress_user, err);
    photon_passes_free(p);
    return status;
}
