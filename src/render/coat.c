/* SPDX-License-Identifier: Apache-2.0 */
#include "render/coat.h"

#include <math.h>

#include "render/fresnel.h"

/* Rows are even in the square root of alpha: reflectance at grazing angles changes fastest where
 * the surface is smooth. */
static float position_of(float alpha)
{
    return sqrtf(min_float(max_float(alpha, 0.0f), 1.0f)) * (COAT_ROWS - 1);
}

static float alpha_of(uint32_t row)
{
    float x = (float)row / (COAT_ROWS - 1);
    return x * x;
}

/* ---- Integrals ------------------------------------------------------------------------------- */

enum { NODES_MAX = 64 };

/* Gauss and Legendre's nodes and weights on [0,1]. */
struct quadrature {
    int n;
    float x[NODES_MAX], weight[NODES_MAX];
};

static void quadrature_init(struct quadrature *q, int n)
{
    q->n = n;
    for (int i = 0; i < n; i++) {
        double x = cos(3.14159265358979323846 * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 8; step++) { /* Newton's method on the polynomial */
            double p = 1, before = 0;
            for (int k = 1; k <= n; k++) {
                double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
                before = p;
                p = next;
            }
            slope = n * (x * p - before) / (x * x - 1);
            x -= p / slope;
        }
        q->x[i] = (float)(0.5 * (1 - x));
        q->weight[i] = (float)(1 / ((1 - x * x) * slope * slope));
    }
}

/* The part of light that one facet normal reflects, or lets through: what meets another facet
 * afterwards is in neither. */
static float part_of(const struct microfacet *f, struct vec3 wi, float eta, bool is_reflection,
                     float u, float v)
{
    struct vec3 m = microfacet_normal(f, wi, u, v);
    struct fresnel t = fresnel_dielectric(vec3_dot(wi, m), eta);
    struct vec3 wo = is_reflection ? fresnel_reflect(wi, m)
                                   : fresnel_refract(wi, m, t.cos_t, t.eta_ti);
    float part = is_reflection ? t.r : 1.0f - t.r;
    if (is_reflection != (wo.z > 0.0f) || part == 0.0f) return 0.0f;
    return part * microfacet_g1(f, wo, m);
}

/* The same over all facets that light at cosine mu sees. They are alike on both sides of the plane
 * of incidence, so half of the grid is enough: of u for GGX's samples, of v for Beckmann's. */
static float gather(const struct microfacet *f, float mu, float eta, bool is_reflection,
                    const struct quadrature *q)
{
    struct vec3 wi = vec3(sqrtf(max_float(0.0f, 1.0f - mu * mu)), 0.0f, mu);
    double sum = 0;
    for (int i = 0; i < q->n / 2; i++) {
        for (int j = 0; j < q->n; j++) {
            bool is_ggx = f->kind == MICROFACET_GGX;
            float part = part_of(f, wi, eta, is_reflection, q->x[is_ggx ? i : j],
                                 q->x[is_ggx ? j : i]);
            sum += (double)(part * q->weight[i] * q->weight[j]);
        }
    }
    return (float)(2 * sum);
}

/* ---- Rows ------------------------------------------------------------------------------------ */

static void work_out(struct coat *c, uint32_t row)
{
    const struct microfacet f = microfacet(c->kind, alpha_of(row), alpha_of(row));
    struct quadrature outside, inside;
    double sum = 0;
    /* GGX has long tails, and from inside, total reflection has an edge: finer grids. The error is
     * below 1e-3. */
    quadrature_init(&outside, c->kind == MICROFACET_GGX ? 32 : 24);
    quadrature_init(&inside, c->kind == MICROFACET_GGX ? 64 : 32);
    for (int i = 0; i < COAT_COLUMNS; i++) {
        float mu = max_float(1e-6f, (float)i / (COAT_COLUMNS - 1));
        c->transmittance[row][i] = gather(&f, mu, c->eta, false, &outside);
        sum += (double)(gather(&f, mu, 1.0f / c->eta, true, &inside) * mu);
    }
    c->internal[row] = (float)(2 * sum / COAT_COLUMNS);
    c->has_row[row] = true;
}

void coat_init(struct coat *c, enum microfacet_kind kind, float eta)
{
    if (c->is_set && c->kind == kind && c->eta == eta) return;
    *c = (struct coat){.is_set = true, .kind = kind, .eta = eta};
}

struct coat_at coat_at(const struct coat *c, float alpha)
{
    float x = position_of(alpha);
    uint32_t row = (uint32_t)x;
    if (row > COAT_ROWS - 2) row = COAT_ROWS - 2;
    return (struct coat_at){c, row, x - (float)row};
}

void coat_prepare(struct coat *c, float least, float most)
{
    uint32_t last = coat_at(c, most).row + 1;
    for (uint32_t row = coat_at(c, least).row; row <= last; row++)
        if (!c->has_row[row]) work_out(c, row);
}

static float lerp(float a, float b, float t)
{
    return a + (b - a) * t;
}

float coat_transmittance(const struct coat_at *at, float mu)
{
    float x = min_float(mu, 1.0f) * (COAT_COLUMNS - 1);
    uint32_t i = (uint32_t)x;
    if (i > COAT_COLUMNS - 2) i = COAT_COLUMNS - 2;
    const float *a = at->coat->transmittance[at->row] + i, *b = a + COAT_COLUMNS;
    float t = x - (float)i;
    return lerp(lerp(a[0], a[1], t), lerp(b[0], b[1], t), at->weight);
}

float coat_internal(const struct coat_at *at)
{
    const float *a = at->coat->internal + at->row;
    return lerp(a[0], a[1], at->weight);
}
