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
        m->n_cells = 1;
        while (m->n_cells < n_emitted) m->n_cells *= 2;
        m->photons = mem_new(n_emitted, sizeof *m->photons);
        m->landed = mem_new(n_emitted, sizeof *m->landed);
        m->first = mem_new((size_t)m->n_cells + 1, sizeof *m->first);
    }
    if (!m || !m->photons || !m->landed || !m->first) {
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
    mem_free(m->first);
    mem_free(m);
}

uint64_t photon_map_memory(const struct photon_map *m)
{
    return sizeof *m + 2 * (uint64_t)m->n_emitted * sizeof *m->photons +
           ((uint64_t)m->n_cells + 1) * sizeof *m->first;
}

/* ---- Grid ------------------------------------------------------------------------------------ */

/* Cells are as wide as the sphere of gathering, so that this meets two of them in each direction.
 */
struct cell {
    int32_t x, y, z;
};

static struct cell cell_of(const struct photon_map *m, struct vec3 p)
{
    float scale = 0.5f / m->radius;
    return (struct cell){(int32_t)floor_float(p.x * scale), (int32_t)floor_float(p.y * scale),
                         (int32_t)floor_float(p.z * scale)};
}

/* Teschner et al. 2003 */
static uint32_t bucket_of(const struct photon_map *m, struct cell c)
{
    uint32_t h = (uint32_t)c.x * 73856093u ^ (uint32_t)c.y * 19349663u ^ (uint32_t)c.z * 83492791u;
    return (h ^ (h >> 15)) & (m->n_cells - 1);
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
        m->photons[--m->first[bucket_of(m, cell_of(m, m->landed[i].p))]] = m->landed[i];
    }
}

/* Buckets of the cells around p, each once. */
static uint32_t buckets_around(const struct photon_map *m, struct vec3 p, uint32_t buckets[8])
{
    struct cell c = cell_of(m, vec3_sub(p, vec3_splat(m->radius)));
    uint32_t n = 0;
    for (int32_t k = 0; k < 8; k++) {
        struct cell near = {c.x + (k & 1), c.y + (k >> 1 & 1), c.z + (k >> 2)};
        uint32_t bucket = bucket_of(m, near), j = 0;
        if (m->first[bucket] == m->first[bucket + 1]) continue;
        while (j < n && buckets[j] != bucket) j++;
        if (j == n) buckets[n++] = bucket;
    }
    return n;
}

static bool is_near(const struct photon *a, struct vec3 p, struct vec3 n, float radius)
{
    struct vec3 d = vec3_sub(a->p, p);
    return vec3_dot(d, d) < radius * radius && vec3_dot(a->n, n) > 0.7f;
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

float photon_map_typical_radius(struct photon_map *m, float scene_radius)
{
    enum { PROBES = 255, WANTED = 12 };
    float radii[PROBES];
    uint32_t n = 0;
    photon_map_build(m, 0.02f * scene_radius);
    uint32_t step = m->n / PROBES + 1;
    for (uint32_t i = 0; i < m->n && n < PROBES; i += step) {
        const struct photon *at = &m->photons[i];
        uint32_t buckets[8], n_buckets = buckets_around(m, at->p, buckets), count = 0;
        for (uint32_t b = 0; b < n_buckets; b++)
            for (uint32_t k = m->first[buckets[b]]; k < m->first[buckets[b] + 1]; k++)
                count += is_near(&m->photons[k], at->p, at->n, m->radius);
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
    struct vec3 scale = vec3_splat(MATH_INV_PI / (m->radius * m->radius));
    if (!r->bsdf) scale = vec3_scale(vec3_mul(scale, r->reflectance), MATH_INV_PI);
    uint32_t buckets[8], n_buckets = buckets_around(m, r->p, buckets);
    for (uint32_t i = 0; i < n_buckets; i++) {
        uint32_t end = m->first[buckets[i] + 1];
        for (uint32_t k = m->first[buckets[i]]; k < end; k++) {
            const struct photon *a = &m->photons[k];
            if (!is_near(a, r->p, r->n, m->radius) || a->n_casters > most) continue;
            struct vec3 light = seen(r, a);
            sum = vec3_add(sum, light);
            if (split) add_to_group(split, a, vec3_mul(light, scale));
        }
    }
    return vec3_mul(sum, scale);
}
