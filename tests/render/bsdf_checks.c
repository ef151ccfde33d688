/* SPDX-License-Identifier: Apache-2.0 */
#include "bsdf_checks.h"

#include <math.h>
#include <stdio.h>

#include "../math/chi2.h"
#include "base/rng.h"

#include "../image/cmocka_all.h"

struct bsdf_point checks_point(enum bsdf_kind kind, uint32_t lobes)
{
    return (struct bsdf_point){.kind = kind,
                               .lobes = lobes,
                               .opacity = 1.0f,
                               .reflectance = {1, 0.5f, 0.25f},
                               .specular_reflectance = {1, 1, 1},
                               .specular_transmittance = {1, 1, 1},
                               .eta_rgb = {0, 0, 0},
                               .k_rgb = {1, 1, 1},
                               .eta = 1.5f};
}

struct bsdf_point checks_rough(enum bsdf_kind kind, enum microfacet_kind facets, float alpha_u,
                               float alpha_v)
{
    struct bsdf_point p = checks_point(kind, LOBE_GLOSSY);
    p.facets = microfacet(facets, alpha_u, alpha_v);
    return p;
}

/* Angles of incidence; the negative ones come from behind. */
static const float cosines[] = {1.0f, 0.9f, 0.5f, 0.1f, -0.15f, -0.8f, -1.0f};
enum { N_COSINES = sizeof cosines / sizeof *cosines };

static struct vec3 incident(int i)
{
    return chi2_direction(0.6, cosines[i]);
}

struct lobe_test {
    const struct bsdf_point *p;
    struct vec3 wi;
    double g1_correction;
};

/* A direction of a smooth lobe; others count as not drawn. */
static bool lobe_sample(const void *ctx, const float u[3], double *x, double *y)
{
    const struct lobe_test *t = ctx;
    struct bsdf_sample s = bsdf_sample(t->p, t->wi, u[2], u[0], u[1]);
    if (vec3_is_zero(s.weight) || !(s.lobe & LOBE_SMOOTH)) return false;
    chi2_from_direction(s.wo, x, y);
    return true;
}

/* Beckmann's G1 is a rational fit, up to 0.35 % off; normals are sampled by the true one. This is
 * true / fit for the viewing direction. */
static double g1_correction(const struct lobe_test *t)
{
    const struct microfacet *f = &t->p->facets;
    bool is_rough = t->p->kind == BSDF_ROUGH_CONDUCTOR || t->p->kind == BSDF_ROUGH_DIELECTRIC;
    if (!is_rough || f->kind != MICROFACET_BECKMANN) return 1;
    double x = (double)f->alpha_u * t->wi.x, y = (double)f->alpha_v * t->wi.y;
    if (x == 0 && y == 0) return 1;
    double a = fabs(t->wi.z) / sqrt(x * x + y * y);
    double lambda = 0.5 * (erf(a) - 1) + exp(-a * a) / (2 * a * sqrt(3.14159265358979));
    struct vec3 front = t->wi.z < 0 ? vec3_neg(t->wi) : t->wi;
    return 1 / (1 + lambda) / microfacet_g1(f, front, vec3(0, 0, 1));
}

static double lobe_pdf(const void *ctx, double x, double y)
{
    const struct lobe_test *t = ctx;
    struct vec3 value;
    float pdf;
    bsdf_eval(t->p, t->wi, chi2_direction(x, y), &value, &pdf);
    return pdf * t->g1_correction;
}

void check_directions(const struct material_case *cases, int n)
{
    for (int c = 0; c < n; c++) {
        if (!(cases[c].point.lobes & LOBE_SMOOTH)) continue;
        for (int i = 0; i < N_COSINES; i++) {
            struct lobe_test t = {&cases[c].point, incident(i), 1};
            t.g1_correction = g1_correction(&t);
            struct chi2_result r = chi2_test(&chi2_sphere, lobe_sample, lobe_pdf, &t, 100000,
                                             (uint64_t)(c * 16 + i));
            if (r.p < 1e-4)
                fail_msg("%s at cosine %g: p = %g (density %g, lost %g)", cases[c].name,
                         (double)cosines[i], r.p, r.integral, r.lost);
            if (r.integral > 1.003)
                fail_msg("%s at cosine %g: the density integrates to %g", cases[c].name,
                         (double)cosines[i], r.integral);
        }
    }
}

static double relative(double a, double b)
{
    double most = fmax(fabs(a), fabs(b));
    return most > 1e-6 ? fabs(a - b) / most : 0;
}

/* What sampling returns is value / density at its direction. */
void check_weights(const struct material_case *cases, int n)
{
    struct rng rng = rng_keyed(7, 0, 0);
    for (int c = 0; c < n; c++) {
        for (int i = 0; i < 2000; i++) {
            struct vec3 wi = incident(i % N_COSINES), value;
            float u1 = rng_float(&rng), u2 = rng_float(&rng), v2 = rng_float(&rng), pdf;
            struct bsdf_sample s = bsdf_sample(&cases[c].point, wi, u1, u2, v2);
            if (vec3_is_zero(s.weight)) continue;
            assert_true(fabs(vec3_length(s.wo) - 1) < 1e-4);
            assert_true(s.pdf > 0 && vec3_is_finite(s.weight));
            if (!(s.lobe & LOBE_SMOOTH)) continue;
            bsdf_eval(&cases[c].point, wi, s.wo, &value, &pdf);
            /* Near grazing wo the half-vector is ill-conditioned in single precision. */
            if (fabsf(s.wo.z) < 0.01f) continue;
            double e = fmax(relative(pdf, s.pdf),
                            relative((double)value.y, (double)s.weight.y * s.pdf));
            if (e > 0.01)
                fail_msg("%s: density %g sampled %g, value %g sampled %g (wi.z %g, wo.z %g)",
                         cases[c].name, (double)pdf, (double)s.pdf, (double)value.y,
                         (double)(s.weight.y * s.pdf), (double)wi.z, (double)s.wo.z);
        }
    }
}

/* Nothing creates light; white materials lose little. Radiance is scaled by 1/eta^2 when it enters
 * a medium, which is undone here. */
void check_energy(const struct material_case *cases, int n)
{
    enum { SAMPLES = 20000 };
    for (int c = 0; c < n; c++) {
        for (int i = 0; i < N_COSINES; i++) {
            bool is_behind = (cosines[i] < 0) != cases[c].point.is_mirrored;
            struct rng rng = rng_keyed(9, (uint64_t)c, (uint64_t)i);
            double sum = 0;
            for (int k = 0; k < SAMPLES; k++) {
                float u1 = rng_float(&rng), u2 = rng_float(&rng), v2 = rng_float(&rng);
                struct bsdf_sample s = bsdf_sample(&cases[c].point, incident(i), u1, u2, v2);
                if (s.lobe) sum += (double)s.weight.x * s.eta * s.eta;
            }
            sum /= SAMPLES;
            double least = is_behind && !cases[c].has_back ? 0 : 1 - cases[c].loss;
            if (sum > 1.005 + cases[c].gain || sum < least - 0.005)
                fail_msg("%s at cosine %g: %g comes out of 1", cases[c].name, (double)cosines[i],
                         sum);
        }
    }
}

/* f(wi, wo) = f(wo, wi), for transmission up to the square of the index. */
void check_reciprocity(const struct material_case *cases, int n)
{
    struct rng rng = rng_keyed(11, 0, 0);
    for (int c = 0; c < n; c++) {
        if (!(cases[c].point.lobes & LOBE_SMOOTH) || cases[c].is_irreciprocal) continue;
        int n_compared = 0;
        for (int i = 0; i < 5000; i++) {
            float a = rng_float(&rng), b = rng_float(&rng), d = rng_float(&rng),
                  e = rng_float(&rng), pdf;
            struct vec3 wi = warp_sphere(a, b), wo = warp_sphere(d, e), there, back;
            if (fabsf(wi.z) < 0.05f || fabsf(wo.z) < 0.05f) continue;
            bsdf_eval(&cases[c].point, wi, wo, &there, &pdf);
            bsdf_eval(&cases[c].point, wo, wi, &back, &pdf);
            double f = there.x / fabs(wo.z), g = back.x / fabs(wi.z);
            if (wi.z * wo.z < 0) { /* radiance: f(wi -> wo) / eta_o^2 is symmetric */
                double eta = cases[c].point.eta;
                if (wi.z > 0)
                    f *= eta * eta;
                else
                    g *= eta * eta;
            }
            if (f > 1e-3) n_compared++;
            /* What little gets through near total reflection is mostly rounding. */
            if (relative(f, g) > 0.01 && fmax(f, g) > 1e-3)
                fail_msg("%s: %g one way, %g the other", cases[c].name, f, g);
        }
        assert_true(n_compared > 50);
    }
}
