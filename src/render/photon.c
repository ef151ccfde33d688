/* SPDX-License-Identifier: Apache-2.0 */
#include "render/photon.h"

#include <stdlib.h>

#include "base/mem.h"

lmn_status photon_map_new(uint32_t n_emitted, struct photon_map **out, struct error *err)
{
    struct photon_map *m = mem_new(1, sizeof *m);
    *out = NULL;
    if (m) {
        m->n_emitted = n_emitted;
        m->n_cells = 8;
        while (m->n_cells < n_emitted) m->n_cells *= 2;
        m->photons = mem_new(n_emitted, sizeof *m->photons);
        m->landed = mem_new(n_emitted, sizeof *m->landed);
        m->x = mem_new(n_emitted, 3 * sizeof *m->x);
        m->y = m->x + (m->x ? n_emitted : 0);
        m->z = m->y + (m->x ? n_emitted : 0);
        m->first = mem_new((size_t)m->n_cells + 1, sizeof *m->first);
    }
    if (!m || !m->photons || !m->landed || !m->x || !m->first) {
        photon_map_free(m);
        return fail_memory(err, "photons");
    }
    *out = m;
    return LMN_OK;
}

void photon_map_free(struct photon_map *m)
{
    if (!m) return;
    mem_free(m->photons);
    mem_free(m->landed);
    mem_free(m->x);
    mem_free(m->first);
    mem_free(m);
}

uint64_t photon_map_memory(const struct photon_map *m)
{
    return sizeof *m + (uint64_t)m->n_emitted * (2 * sizeof *m->photons + 3 * sizeof *m->x) +
           ((uint64_t)m->n_cells + 1) * sizeof *m->first;
}

/* ---- Grid ------------------------------------------------------------------------------------ */

/* Cells are as wide as the sphere of gathering, so that this meets two of them in each direction.
 * Blocks of eight cells are hashed (Teschner et al. 2003), which keeps cells around a point apart.
 */
struct cell {
    uint32_t x, y, z;
};

static struct cell cell_of(const struct photon_map *m, struct vec3 p)
{
    float scale = 0.5f / m->radius;
    return (struct cell){(uint32_t)(int32_t)floor_float(p.x * scale),
                         (uint32_t)(int32_t)floor_float(p.y * scale),
                         (uint32_t)(int32_t)floor_float(p.z * scale)};
}

static uint32_t bucket_of(const struct photon_map *m, struct cell c)
{
    uint32_t h = (c.x >> 1) * 73856093u ^ (c.y >> 1) * 19349663u ^ (c.z >> 1) * 83492791u;
    uint32_t place = (c.x & 1) | (c.y & 1) << 1 | (c.z & 1) << 2;
    return ((h ^ (h >> 15)) << 3 & (m->n_cells - 1)) | place;
}

void photon_map_build(struct photon_map *m, float radius)
{
    m->radius = radius;
    m->n = 0;
    for (uint32_t i = 0; i <= m->n_cells; i++) m->first[i] = 0;
    for (uint32_t i = 0; i < m->n_emitted; i++) {
        if (m->landed[i].n_casters == 0) continue;
        m->first[bucket_of(m, cell_of(m, m->landed[i].p))]++;
        m->n++;
    }
    uint32_t end = 0;
    for (uint32_t i = 0; i <= m->n_cells; i++) {
        end += m->first[i];
        m->first[i] = end;
    }
    /* Backwards, so that photons of a cell keep their order. */
    for (uint32_t i = m->n_emitted; i-- > 0;) {
        if (m->landed[i].n_casters == 0) continue;
        uint32_t k = --m->first[bucket_of(m, cell_of(m, m->landed[i].p))];
        m->photons[k] = m->landed[i];
        m->photons[k].radius2 = radius * radius;
        m->x[k] = m->landed[i].p.x;
        m->y[k] = m->landed[i].p.y;
        m->z[k] = m->landed[i].p.z;
    }
}

/* Distances are found in vector code, of so many photons at a time. */
enum { RUN = 64 };

/* Photons of a cell: a run of the map's. */
struct run {
    uint32_t first, end;
};

/* What is in the cells around p. */
static uint32_t runs_around(const struct photon_map *m, struct vec3 p, struct run runs[8])
{
    struct cell c = cell_of(m, vec3_sub(p, vec3_splat(m->radius)));
    uint32_t n = 0;
    if (m->n <= RUN) { /* sooner all compared than found */
        runs[0] = (struct run){0, m->n};
        return m->n > 0;
    }
    for (uint32_t k = 0; k < 8; k++) {
        uint32_t b = bucket_of(m, (struct cell){c.x + (k & 1), c.y + (k >> 1 & 1), c.z + (k >> 2)});
        runs[n] = (struct run){m->first[b], m->first[b + 1]};
        n += runs[n].first < runs[n].end;
    }
    return n;
}

/* Photons of one bucket that are near a point: RUN at a time. */
static uint32_t near_of_run(const struct photon_map *m, uint32_t first, uint32_t n, struct vec3 p,
                            uint32_t near[RUN])
{
    const float *x = m->x + first, *y = m->y + first, *z = m->z + first;
    float d2[RUN], r2 = m->radius * m->radius;
    uint32_t n_near = 0;
    for (uint32_t k = 0; k < n; k++) {
        float dx = x[k] - p.x, dy = y[k] - p.y, dz = z[k] - p.z;
        d2[k] = dx * dx + dy * dy + dz * dz;
    }
    for (uint32_t k = 0; k < n; k++) {
        near[n_near] = first + k;
        n_near += d2[k] < r2;
    }
    return n_near;
}

/* On the same side of the same surface, roughly? */
static bool is_alike(const struct photon *a, struct vec3 n)
{
    return vec3_dot(a->n, n) > 0.7f;
}

static uint32_t min_u32(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* How many photons are near one of them. */
static uint32_t neighbours(const struct photon_map *m, const struct photon *at)
{
    struct run runs[8];
    uint32_t near[RUN], n_runs = runs_around(m, at->p, runs), count = 0;
    for (uint32_t r = 0; r < n_runs; r++) {
        for (uint32_t k = runs[r].first; k < runs[r].end; k += RUN) {
            uint32_t n = near_of_run(m, k, min_u32(runs[r].end - k, RUN), at->p, near);
            for (uint32_t i = 0; i < n; i++) count += is_alike(&m->photons[near[i]], at->n);
        }
    }
    return count;
}

void photon_map_sharpen(struct photon_map *m, float wanted)
{
    for (uint32_t i = 0; i < m->n; i++) {
        const float others = (float)(neighbours(m, &m->photons[i]) - 1);
        if (others > wanted) m->photons[i].radius2 *= wanted / others;
    }
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

float photon_map_typical_radius(struct photon_map *m, float scene_radius)
{
    enum { PROBES = 255, WANTED = 24 };
    float radii[PROBES];
    uint32_t n = 0;
    photon_map_build(m, 0.02f * scene_radius);
    uint32_t step = m->n / PROBES + 1;
    for (uint32_t i = 0; i < m->n && n < PROBES; i += step) {
        uint32_t count = neighbours(m, &m->photons[i]);
        radii[n++] = m->radius * sqrtf((float)WANTED / (float)(count > 0 ? count : 1));
    }
    if (n == 0) return 0.0f;
    qsort(radii, n, sizeof *radii, compare_floats);
    return min_float(radii[n / 2], 0.05f * scene_radius);
}

/* ---- Gathering ------------------------------------------------------------------------------- */

/* The part of a photon's power that is seen: photons lie by geometric area, values have the shading
 * cosine. */
static struct vec3 seen(const struct photon_receiver *r, const struct photon *a)
{
    float cosine = fabsf(vec3_dot(a->wo, r->n));
    if (!(cosine > 1e-4f)) return vec3_splat(0.0f);
    if (!r->bsdf) {
        float up = vec3_dot(a->wo, r->frame.n) * r->side;
        return vec3_scale(a->power, up > 0.0f ? up / cosine : 0.0f);
    }
    struct vec3 value;
    float pdf;
    bsdf_eval(r->bsdf, r->wi, frame_to_local(&r->frame, a->wo), &value, &pdf);
    return vec3_scale(vec3_mul(value, a->power), 1.0f / cosine);
}

static bool reaches(const struct photon *a, struct vec3 p)
{
    struct vec3 d = vec3_sub(a->p, p);
    return vec3_dot(d, d) < a->radius2;
}

static void add_to_group(const struct photon_split *split, const struct photon *a,
                         struct vec3 light)
{
    struct vec3 value = vec3_mul(light, split->throughput);
    if (!vec3_is_finite(value)) return;
    float *to = split->to + split->group_of[a->emitter] * split->stride;
    to[0] += value.x;
    to[1] += value.y;
    to[2] += value.z;
}

struct vec3 photon_map_gather(const struct photon_map *m, const struct photon_receiver *r,
                              int32_t max_casters, const struct photon_split *split)
{
    struct vec3 sum = {0};
    if (m->n == 0 || max_casters == 0) return sum;
    if (!r->bsdf && !(r->wi.z * r->side > 0.0f)) return sum;
    uint32_t most = max_casters > 0 ? (uint32_t)max_casters : UINT32_MAX;
    struct vec3 scale = vec3_splat(MATH_INV_PI);
    if (!r->bsdf) scale = vec3_scale(vec3_mul(scale, r->reflectance), MATH_INV_PI);
    struct run runs[8];
    uint32_t near[RUN], n_runs = runs_around(m, r->p, runs);
    for (uint32_t i = 0; i < n_runs; i++) {
        for (uint32_t first = runs[i].first; first < runs[i].end; first += RUN) {
            uint32_t n = near_of_run(m, first, min_u32(runs[i].end - first, RUN), r->p, near);
            for (uint32_t k = 0; k < n; k++) {
                const struct photon *a = &m->photons[near[k]];
                if (!is_alike(a, r->n) || a->n_casters > most || !reaches(a, r->p)) continue;
                struct vec3 light = vec3_scale(seen(r, a), 1.0f / a->radius2);
                sum = vec3_add(sum, light);
                if (split) add_to_group(split, a, vec3_mul(light, scale));
            }
        }
    }
    return vec3_mul(sum, scale);
}
