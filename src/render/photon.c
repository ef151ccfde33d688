/* SPDX-License-Identifier: Apache-2.0 */
#include "render/photon.h"

#include <stdlib.h>

#include "base/mem.h"
#include "render/surface.h"

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

struct vec3 photon_map_gather(const struct photon_map *m, const struct surface *s,
                              const struct bsdf_point *b, int32_t max_casters)
{
    struct vec3 sum = {0};
    if (m->n == 0 || max_casters == 0) return sum;
    uint32_t buckets[8], n_buckets = buckets_around(m, s->p, buckets);
    for (uint32_t i = 0; i < n_buckets; i++) {
        for (uint32_t k = m->first[buckets[i]]; k < m->first[buckets[i] + 1]; k++) {
            const struct photon *a = &m->photons[k];
            if (!is_near(a, s->p, s->n, m->radius)) continue;
            if (max_casters > 0 && a->n_casters > (uint32_t)max_casters) continue;
            struct vec3 value;
            float pdf, cosine = fabsf(vec3_dot(a->wo, s->n));
            bsdf_eval(b, s->wi, frame_to_local(&s->frame, a->wo), &value, &pdf);
            if (cosine > 1e-4f) /* photons lie by geometric area, values have the shading cosine */
                sum = vec3_madd(sum, vec3_mul(value, a->power), 1.0f / cosine);
        }
    }
    return vec3_scale(sum, MATH_INV_PI / (m->radius * m->radius));
}
