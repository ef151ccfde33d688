/* SPDX-License-Identifier: Apache-2.0 */
/* Layered, mixed and mapped materials: known values. */
#include "render/fresnel.h"
#include "shelf.h"

static struct vec3 direction(double theta, double phi)
{
    return vec3((float)(sin(theta) * cos(phi)), (float)(sin(theta) * sin(phi)), (float)cos(theta));
}

static void near(double value, double expected, double relative)
{
    if (!(fabs(value - expected) <= relative * fabs(expected)))
        fail_msg("%.6f instead of %.6f", value, expected);
}

/* What comes back of light from wi, by a grid over the hemisphere (channel x). */
static double reflected(const struct bsdf_point *p, struct vec3 wi)
{
    enum { N = 400 };
    const double pi = 3.14159265358979;
    double sum = 0;
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            struct vec3 value;
            float pdf;
            double theta = (i + 0.5) / N * pi / 2;
            bsdf_eval(p, wi, direction(theta, (j + 0.5) / N * 2 * pi), &value, &pdf);
            sum += (double)value.x * sin(theta);
        }
    }
    return sum * (pi / 2 / N) * (2 * pi / N);
}

/* Oren and Nayar's equations 30 and 31 in angles. */
static double oren_nayar(double sigma, double rho, double theta_i, double theta_r, double phi)
{
    const double pi = 3.14159265358979;
    double alpha = fmax(theta_i, theta_r), beta = fmin(theta_i, theta_r), s2 = sigma * sigma;
    double c1 = 1 - 0.5 * s2 / (s2 + 0.33);
    double c2 = 0.45 * s2 / (s2 + 0.09) *
                (sin(alpha) - (cos(phi) >= 0 ? 0 : pow(2 * beta / pi, 3)));
    double c3 = 0.125 * s2 / (s2 + 0.09) * pow(4 * alpha * beta / (pi * pi), 2);
    double l1 = rho / pi *
                (c1 + cos(phi) * c2 * tan(beta) +
                 (1 - fabs(cos(phi))) * c3 * tan((alpha + beta) / 2));
    double l2 = 0.17 * rho * rho / pi * s2 / (s2 + 0.13) * (1 - cos(phi) * pow(2 * beta / pi, 2));
    return l1 + l2;
}

static void rough_diffuse_is_the_papers(void **state)
{
    (void)state;
    shelf.n_bsdfs = shelf.n_textures = 0;
    struct bsdf *f = rough(BSDF_ROUGH_DIFFUSE, MICROFACET_BECKMANN, 0.7f);
    prepare();
    struct bsdf_point p = point_at(f, vec3(0, 0, 1));
    for (int i = 0; i < 200; i++) {
        double theta_i = 0.05 + 0.0072 * i, theta_o = 1.5 - 0.0068 * i, phi = 0.033 * i;
        struct vec3 value;
        float pdf;
        bsdf_eval(&p, direction(theta_i, 0.3), direction(theta_o, 0.3 + phi), &value, &pdf);
        near((double)value.y / cos(theta_o),
             oren_nayar(0.7 / sqrt(2.0), 0.5, theta_i, theta_o, phi), 1e-3);
    }
}

/* Both lobes are normalised: what falls in straight comes out, whatever the exponent. */
static void phong_keeps_light_at_normal_incidence(void **state)
{
    (void)state;
    for (int i = 0; i < 8; i++) {
        shelf.n_bsdfs = shelf.n_textures = 0;
        struct bsdf *f = phong(i & 1 ? BSDF_PHONG : BSDF_BLINN_PHONG, (float)(7 * i));
        prepare();
        struct bsdf_point p = point_at(f, vec3(0, 0, 1));
        near(reflected(&p, vec3(0, 0, 1)), 1.0, 1e-3);
    }
    /* Colours beyond 1 are scaled down. */
    shelf.n_bsdfs = shelf.n_textures = 0;
    struct bsdf *f = phong(BSDF_PHONG, 20);
    f->reflectance = number(0.9f);
    prepare();
    struct bsdf_point p = point_at(f, vec3(0, 0, 1));
    near(reflected(&p, vec3(0, 0, 1)), 1.0, 1e-3);
}

/* A very smooth rough plastic is plastic; one part of its table against sampling. */
static void coats(void **state)
{
    (void)state;
    static struct coat c;
    for (int kind = 0; kind < 2; kind++) {
        coat_init(&c, (enum microfacet_kind)kind, 1.5f);
        coat_prepare(&c, 0.0f, 0.0f);
        struct coat_at at = coat_at(&c, 0.0f);
        for (float mu = 0.1f; mu < 1; mu += 0.1f) /* columns are interpolated */
            near((double)coat_transmittance(&at, mu), 1 - (double)fresnel_dielectric(mu, 1.5f).r,
                 2e-3);
        near((double)coat_internal(&at), (double)fresnel_diffuse_reflectance(1 / 1.5f), 2e-2);
        struct rng rng = rng_keyed(5, (uint64_t)kind, 0);
        static const float alphas[] = {0.05f, 0.13f, 0.3f, 0.62f, 0.95f};
        for (int a = 0; a < 5; a++) {
            const struct microfacet f = microfacet((enum microfacet_kind)kind, alphas[a],
                                                   alphas[a]);
            coat_prepare(&c, alphas[a], alphas[a]);
            at = coat_at(&c, alphas[a]);
            for (float mu = 0.15f; mu < 1; mu += 0.4f) {
                enum { SAMPLES = 200000 };
                struct vec3 wi = vec3(sqrtf(1 - mu * mu), 0, mu);
                double sum = 0;
                for (int i = 0; i < SAMPLES; i++) {
                    float u = rng_float(&rng), v = rng_float(&rng);
                    struct vec3 m = microfacet_normal(&f, wi, u, v);
                    struct fresnel t = fresnel_dielectric(vec3_dot(wi, m), 1.5f);
                    struct vec3 wo = fresnel_refract(wi, m, t.cos_t, t.eta_ti);
                    if (wo.z < 0) sum += (double)((1 - t.r) * microfacet_g1(&f, wo, m));
                }
                near((double)coat_transmittance(&at, mu), sum / SAMPLES, 5e-3);
            }
        }
    }
}

static struct vec3 value_of(const struct bsdf_point *p)
{
    struct vec3 value;
    float pdf;
    bsdf_eval(p, direction(0.4, 0), direction(0.9, 2), &value, &pdf);
    return value;
}

/* A variable changes roughness and index: tables from before are right or made anew, and materials
 * that share one do not disturb each other. */
static void coats_follow_variables(void **state)
{
    (void)state;
    static const float alphas[] = {0.1f, 0.4f, 0.1f, 0.8f}, etas[] = {1.5f, 1.5f, 1.7f, 1.5f};
    static struct coat fresh[2];
    shelf.n_bsdfs = shelf.n_textures = 0;
    struct bsdf *f = rough(BSDF_ROUGH_PLASTIC, MICROFACET_GGX, 0.2f);
    struct bsdf *g = rough(BSDF_ROUGH_PLASTIC, MICROFACET_GGX, 0.3f);
    for (int i = 0; i < 4; i++) {
        shelf.textures[g->alpha_u].value = vec3_splat(alphas[i]);
        g->eta = etas[i];
        prepare();
        struct bsdf_point p = point_at(g, vec3(0, 0, 1)), q = point_at(f, vec3(0, 0, 1));
        struct vec3 kept = value_of(&p), other = value_of(&q);
        memset(fresh, 0, sizeof fresh);
        material_init(shelf.materials, shelf.bsdfs, shelf.n_bsdfs, &shelf.set, fresh, shelf.ready);
        p = point_at(g, vec3(0, 0, 1));
        q = point_at(f, vec3(0, 0, 1));
        struct vec3 made = value_of(&p), other_made = value_of(&q);
        assert_memory_equal(&kept, &made, sizeof kept);
        assert_memory_equal(&other, &other_made, sizeof other);
    }
    assert_int_equal(material_count_coats(shelf.bsdfs, shelf.n_bsdfs), 2);
}

/* Thin glass: the sum over reflections back and forth. */
static void thin_glass(void **state)
{
    (void)state;
    shelf.n_bsdfs = shelf.n_textures = 0;
    struct bsdf *f = put(BSDF_THIN_DIELECTRIC);
    prepare();
    for (float z = -0.85f; z < 1; z += 0.3f) {
        struct vec3 wi = vec3(sqrtf(1 - z * z), 0, z);
        struct bsdf_point p = point_at(f, wi);
        double r = (double)fresnel_dielectric(fabsf(z), 1.5f).r, t = 1 - r, sum = r;
        for (int i = 1; i < 40; i += 2) sum += t * t * pow(r, i);
        struct bsdf_sample s = bsdf_sample(&p, wi, 0.0f, 0.5f, 0.5f);
        near((double)s.pdf, sum, 1e-4);
        assert_true(s.lobe == LOBE_SPECULAR && s.wo.z * z > 0);
        s = bsdf_sample(&p, wi, 0.9999f, 0.5f, 0.5f);
        assert_true(s.lobe == LOBE_NULL && s.wo.z == -z && s.eta == 1.0f);
    }
}

/* What a bump or normal map does to a mirror, and to the other side of a twosided one. */
static void maps_turn_the_frame(void **state)
{
    (void)state;
    shelf.n_bsdfs = shelf.n_textures = 0;
    struct bsdf *mirror = put(BSDF_CONDUCTOR), *f = around(BSDF_NORMALMAP, mirror);
    f->normals = color(0.65f, 0.5f, 0.5f * (1 + 0.9539392f)); /* (0.3, 0, 0.954) */
    f->has_shadowing = false;
    struct bsdf *inner = around(BSDF_TWOSIDED, f), *outer = around(BSDF_NORMALMAP, inner);
    outer->normals = color(0.5f, 0.5f, 1.0f); /* straight up: changes nothing */
    prepare();
    struct vec3 n = vec3(0.3f, 0, 0.9539392f);
    struct bsdf_point p = point_at(f, n);
    struct bsdf_sample s = bsdf_sample(&p, n, 0.5f, 0.5f, 0.5f);
    assert_true(vec3_length(vec3_sub(s.wo, n)) < 1e-5f);
    assert_true(vec3_length(vec3_sub(bsdf_normal(&p), n)) < 1e-5f);
    /* From behind, the map is mirrored with the frame. */
    struct vec3 below = vec3(0.3f, 0, -0.9539392f);
    for (int i = 0; i < 2; i++) {
        p = point_at(i ? outer : inner, below);
        s = bsdf_sample(&p, below, 0.5f, 0.5f, 0.5f);
        assert_true(vec3_length(vec3_sub(s.wo, below)) < 1e-5f);
        assert_true(s.weight.x > 0.999f);
    }
    /* A normal that faces away from the eye is flipped to the other side of the old one. */
    struct vec3 grazing = vec3(-0.994987f, 0, 0.1f);
    p = point_at(f, grazing);
    assert_true(bsdf_normal(&p).x < -0.29f);
    f->flips_normals = false;
    p = point_at(f, grazing);
    assert_true(bsdf_normal(&p).x > 0.29f);
}

/* Numbers that no reader lets through, or that only a variable can make: no sample has a direction
 * that is none, which would stop Embree. */
static void absurd_values_have_directions(void **state)
{
    (void)state;
    static const float etas[] = {1e-38f, 1.0f, 1e38f}, numbers[] = {0, 1e-20f, 1, 1e20f};
    struct rng rng = rng_keyed(3, 0, 0);
    for (int kind = 0; kind < BSDF_KINDS; kind++) {
        for (int i = 0; i < 12; i++) {
            shelf.n_bsdfs = shelf.n_textures = 0;
            struct bsdf *child = put(BSDF_DIELECTRIC), *f = put((enum bsdf_kind)kind);
            f->child[0] = f->child[1] = index_of(child);
            f->eta = child->eta = etas[i % 3];
            f->scale = 1e30f;
            for (int k = 0; k < BSDF_TEXTURES; k++) {
                const uint32_t t = number(numbers[i % 4]);
                memcpy((char *)f + bsdf_texture_offsets[k], &t, sizeof t);
            }
            prepare();
            for (int k = 0; k < 200; k++) {
                float a = rng_float(&rng), b = rng_float(&rng), c = rng_float(&rng),
                      d = rng_float(&rng), e = rng_float(&rng);
                struct vec3 wi = warp_sphere(a, b);
                struct bsdf_point p = point_at(f, wi);
                assert_true(vec3_is_finite(bsdf_sample(&p, wi, c, d, e).wo));
                assert_true(vec3_is_finite(bsdf_normal(&p)));
            }
        }
    }
}

/* Twosided paint behind paint: sides keep their own colours through wrappers. */
static void buffers(void **state)
{
    (void)state;
    shelf.n_bsdfs = shelf.n_textures = 0;
    struct bsdf *red = put(BSDF_DIFFUSE),
                *metal = rough(BSDF_ROUGH_CONDUCTOR, MICROFACET_GGX, 0.2f);
    red->reflectance = color(1, 0, 0);
    metal->specular_reflectance = color(0, 1, 0);
    struct bsdf *f = blend(red, metal, 0.25f);
    struct bsdf *shiny = phong(BSDF_PHONG, 30);
    prepare();
    struct bsdf_point p = point_at(f, vec3(0, 0, 1));
    assert_true(bsdf_albedo(&p).x == 0.75f && bsdf_albedo(&p).y == 0.25f);
    near((double)bsdf_roughness(&p), 0.75 + 0.25 * 0.2, 1e-6);
    p = point_at(shiny, vec3(0, 0, 1));
    near((double)bsdf_albedo(&p).x, 1.0, 1e-6);
    near((double)bsdf_roughness(&p), 0.25, 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rough_diffuse_is_the_papers),
        cmocka_unit_test(phong_keeps_light_at_normal_incidence),
        cmocka_unit_test(coats),
        cmocka_unit_test(coats_follow_variables),
        cmocka_unit_test(thin_glass),
        cmocka_unit_test(maps_turn_the_frame),
        cmocka_unit_test(absurd_values_have_directions),
        cmocka_unit_test(buffers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
