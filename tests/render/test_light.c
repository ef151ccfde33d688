/* SPDX-License-Identifier: Apache-2.0 */
/* Directions chosen to lights: against the densities that multiple importance sampling asks for.
 * The chi-square tests together fail by chance once in 100 times (Bonferroni); seeds are fixed. */
#include "../math/chi2.h"
#include "base/rng.h"
#include "made_light.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

enum { N = 100000 };

/* ---- Scenes ---------------------------------------------------------------------------------- */

/* Unequal triangles, of which one shines away, that hide nothing of each other. */
static void add_triangles(struct made_scene *m)
{
    static const float positions[] = {2,    -0.9f, -0.8f, 2.2f, 0.1f, -0.9f, 1.8f, -0.2f, 0.3f,
                                      2.5f, 1.1f,  0.7f,  1.9f, 0.3f, 0.9f,  2.1f, -1,    0.8f};
    static const uint32_t indices[] = {0, 2, 1, 1, 2, 3, 2, 4, 3, 0, 2, 5};
    made_mesh(m, 6, positions, 4, indices, black(m), area(m));
}

static void add_triangles_placed(struct made_scene *m)
{
    struct transform turn = transform_rotate(vec3(1, 0, 0), 35),
                     scale = transform_scale(vec3(1.2f, 0.7f, 1.1f));
    place_group(m, transform_mul(&scale, &turn));
    add_triangles(m);
}

static void add_sphere(struct made_scene *m)
{
    made_sphere(m, vec3(2, 0.1f, 0.1f), 0.9f, black(m), area(m));
}

static void add_sphere_placed(struct made_scene *m)
{
    struct transform scale = transform_scale(vec3_splat(0.5f)),
                     move = transform_translate(vec3(1, 0, 0));
    place_group(m, transform_mul(&move, &scale));
    add_sphere(m);
}

static const struct vec3 ellipsoid_scale = {1, 0.5f, 1.1f}, ellipsoid_center = {2, 0.1f, 0.1f};

static void add_ellipsoid(struct made_scene *m)
{
    place_group(m, transform_scale(ellipsoid_scale));
    made_sphere(m, ellipsoid_center, 0.8f, black(m), area(m));
}

/* The reference point is inside. */
static void add_hollow_sphere(struct made_scene *m)
{
    uint32_t s = made_sphere(m, vec3(0.5f, 0.5f, 0.3f), 1.5f, black(m), area(m));
    m->shapes[s].flip_normals = true;
}

static void add_disk(struct made_scene *m)
{
    struct transform turn = transform_rotate(vec3(0.1f, 1, 0.2f), -70),
                     scale = transform_scale(vec3(0.9f, 0.6f, 1)),
                     move = transform_translate(vec3(1.8f, 0.1f, 0)), place;
    place = transform_mul(&turn, &scale);
    place = transform_mul(&move, &place);
    made_disk(m, &place, black(m), area(m));
}

/* Open ends: from here, some of its inside is seen, too, which does not shine. */
static void add_cylinder(struct made_scene *m)
{
    struct transform turn = transform_rotate(vec3(0.2f, 1, 0.3f), 60),
                     scale = transform_scale(vec3(0.5f, 0.5f, 1.4f)),
                     move = transform_translate(vec3(1.4f, -0.1f, -0.4f)), place;
    place = transform_mul(&turn, &scale);
    place = transform_mul(&move, &place);
    made_cylinder(m, &place, black(m), area(m));
}

static void add_cylinder_placed(struct made_scene *m)
{
    struct transform turn = transform_rotate(vec3(1, 0, 0), 25),
                     scale = transform_scale(vec3(1.1f, 0.8f, 0.9f));
    place_group(m, transform_mul(&scale, &turn));
    add_cylinder(m);
}

/* The reference point is inside. */
static void add_hollow_cylinder(struct made_scene *m)
{
    struct transform scale = transform_scale(vec3(0.8f, 0.8f, 2)),
                     move = transform_translate(vec3(0.3f, 0.1f, -0.9f)), place;
    place = transform_mul(&move, &scale);
    uint32_t s = made_cylinder(m, &place, black(m), area(m));
    m->shapes[s].flip_normals = true;
}

static void add_constant(struct made_scene *m)
{
    made_emitter(m, EMITTER_CONSTANT, vec3(1, 2, 3));
}

/* Bright and black texels side by side, poles included, turned about two axes. */
static void add_envmap(struct made_scene *m)
{
    enum { WIDTH = 11, HEIGHT = 6 };
    float rgb[WIDTH * HEIGHT * 3] = {0};
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        float light = i % 5 == 2 ? 20.0f : i % 7 == 0 ? 3.0f : i < 2 * WIDTH ? 0.5f : 0.0f;
        for (int c = 0; c < 3; c++) rgb[3 * i + c] = light * (float)(c + 1);
    }
    struct transform a = transform_rotate(vec3(0, 1, 0), 50), b;
    b = transform_rotate(vec3(1, 0, 0), 30);
    uint32_t e = made_emitter(m, EMITTER_ENVMAP, vec3_splat(1));
    m->emitters[e].bitmap = made_bitmap(m, WIDTH, HEIGHT, rgb);
    m->emitters[e].scale = 0.25f;
    m->emitters[e].to_world = transform_mul(&a, &b);
}

/* All, beside each other as seen from the reference point. */
static void add_all(struct made_scene *m)
{
    struct transform turn = transform_rotate(vec3(0, 1, 0), 180);
    add_disk(m);
    made_sphere(m, vec3(-0.2f, 0.1f, 2), 0.5f, black(m), area(m));
    made_sphere(m, vec3(0.3f, -2, -0.2f), 0.8f, black(m), area(m));
    made_group(m);
    made_instance(m, 1, &turn);
    add_triangles(m);
    add_envmap(m);
    made_point(m, vec3(0, 3, 0), vec3(1, 1, 1));
    add_constant(m);
}

/* ---- Densities ------------------------------------------------------------------------------- */

static double density_along(const struct view *v, struct vec3 d)
{
    struct surface s;
    double sum = 0;
    if (seen(v, d, &s)) sum += light_surface_pdf(v, reference, &s, d, s.t);
    for (uint32_t i = v->first_environment; i < v->n_lights; i++)
        sum += light_environment_pdf(v, &v->lights[i], reference, d);
    return sum;
}

/* By direction, as (phi, z). */
static bool draw_direction(const void *ctx, const float u[3], double *x, double *y)
{
    struct light_sample s;
    if (!light_sample(ctx, reference, u[0], u[1], &s) || s.is_delta) return false;
    chi2_from_direction(s.d, x, y);
    return true;
}

static double direction_density(const void *ctx, double x, double y)
{
    return density_along(ctx, chi2_direction(x, y));
}

/* By the point of the unit sphere that the ellipsoid is made from: seen from the reference point,
 * densities grow without end towards its rim. */
static bool draw_place(const void *ctx, const float u[3], double *x, double *y)
{
    struct light_sample s;
    if (!light_sample(ctx, reference, u[0], u[1], &s)) return false;
    struct vec3 p = transform_point_inverse(
        &((const struct view *)ctx)->state.instances[1].to_world, s.p);
    chi2_from_direction(vec3_normalize(vec3_sub(p, ellipsoid_center)), x, y);
    return true;
}

static double place_density(const void *ctx, double x, double y)
{
    const struct vec3 k = ellipsoid_scale;
    struct vec3 n = chi2_direction(x, y);
    struct vec3 p = vec3_mul(vec3_madd(ellipsoid_center, n, 0.8f), k);
    /* Cofactors times the unit normal: the normal, as long as areas grow. */
    struct vec3 grown = vec3_scale(vec3(k.y * k.z * n.x, k.x * k.z * n.y, k.x * k.y * n.z),
                                   0.8f * 0.8f);
    struct vec3 d = vec3_sub(p, reference);
    double distance = vec3_length(d);
    d = vec3_normalize(d);
    return fmax(0, -vec3_dot(grown, d)) / (distance * distance) * density_along(ctx, d);
}

/* By turn and height on the cylinder that is the only shape, for the same reason. */
static struct transform cylinder_place(const struct view *v)
{
    const struct light *l = &v->lights[0];
    return transform_mul(&v->state.instances[l->instance].to_world, l->shape->to_group);
}

static bool draw_on_cylinder(const void *ctx, const float u[3], double *x, double *y)
{
    struct light_sample s;
    if (!light_sample(ctx, reference, u[0], u[1], &s)) return false;
    struct transform place = cylinder_place(ctx);
    struct vec3 p = transform_point_inverse(&place, s.p);
    double turn = atan2(p.y, p.x) / (2 * pi);
    *x = turn < 0 ? turn + 1 : turn;
    *y = p.z;
    return true;
}

static double cylinder_density(const void *ctx, double x, double y)
{
    struct transform place = cylinder_place(ctx);
    float s = (float)sin(2 * pi * x), c = (float)cos(2 * pi * x), turn = (float)(2 * pi);
    struct vec3 p = transform_point(&place, vec3(c, s, (float)y));
    struct vec3 grown = vec3_cross(transform_vector(&place, vec3(-turn * s, turn * c, 0)),
                                   transform_vector(&place, vec3(0, 0, 1)));
    if (((const struct view *)ctx)->lights[0].shape->is_flipped) grown = vec3_neg(grown);
    struct vec3 d = vec3_sub(p, reference);
    double distance = vec3_length(d);
    d = vec3_normalize(d);
    return fmax(0, -vec3_dot(grown, d)) / (distance * distance) * density_along(ctx, d);
}

/* By place (u, v) in the picture: densities per solid angle grow without end towards the poles. */
static const double places_per_angle = 2 * 3.14159265358979 * 3.14159265358979; /* times sin */

static bool draw_texel(const void *ctx, const float u[3], double *x, double *y)
{
    const struct view *v = ctx;
    struct light_sample s;
    if (!light_sample(v, reference, u[0], u[1], &s)) return false;
    struct vec3 d = transform_vector_inverse(&v->state.emitters[0].to_world, s.d);
    double turn = atan2(d.x, -d.z) / (2 * pi);
    *x = turn < 0 ? turn + 1 : turn;
    *y = acos(fmin(fmax(d.y, -1), 1)) / pi;
    return true;
}

static double texel_density(const void *ctx, double x, double y)
{
    const struct view *v = ctx;
    double phi = 2 * pi * x, theta = pi * y;
    struct vec3 d = vec3((float)(sin(phi) * sin(theta)), (float)cos(theta),
                         (float)(-cos(phi) * sin(theta)));
    d = transform_vector(&v->state.emitters[0].to_world, d);
    return density_along(v, d) * places_per_angle * sin(theta);
}

struct light_case {
    const char *name;
    void (*add)(struct made_scene *m);
    struct chi2_domain domain;
    chi2_sample_fn *sample;
    chi2_pdf_fn *pdf;
};

/* Domains of (phi, z) leave little around the lights, so that few bins lie across an edge. */
#define DIRECTIONS draw_direction, direction_density
#define SPHERE                                                   \
    {                                                            \
        -3.14159265358979, 3.14159265358979, -1, 1, 32, 24, true \
    }
#define TURNS {0, 1, 0, 1, 36, 20, false}, draw_on_cylinder, cylinder_density
static const struct light_case cases[] = {
    {"triangles", add_triangles, {-0.6, 0.5, -0.45, 0.5, 28, 24, false}, DIRECTIONS},
    {"triangles, placed", add_triangles_placed, {-0.6, 0.5, -0.45, 0.5, 28, 24, false}, DIRECTIONS},
    {"sphere", add_sphere, {-0.6, 0.5, -0.4, 0.6, 28, 24, false}, DIRECTIONS},
    {"sphere, placed", add_sphere_placed, {-0.35, 0.25, -0.2, 0.35, 28, 24, false}, DIRECTIONS},
    {"ellipsoid", add_ellipsoid, SPHERE, draw_place, place_density},
    {"sphere from inside", add_hollow_sphere, SPHERE, DIRECTIONS},
    {"disk", add_disk, {-0.5, 0.5, -0.6, 0.6, 28, 24, false}, DIRECTIONS},
    {"cylinder", add_cylinder, TURNS},
    {"cylinder, placed", add_cylinder_placed, TURNS},
    {"cylinder from inside", add_hollow_cylinder, TURNS},
    {"constant", add_constant, SPHERE, DIRECTIONS},
    {"envmap", add_envmap, {0, 1, 0, 1, 44, 20, false}, draw_texel, texel_density},
    {"sky", add_sky, SPHERE, DIRECTIONS},
    {"sun", add_sun, {-0.12, 0.12, -0.08, 0.14, 20, 22, false}, DIRECTIONS},
    {"all", add_all, SPHERE, DIRECTIONS},
};
enum { N_CASES = sizeof cases / sizeof *cases };

static struct made_scene *make(int i)
{
    struct made_scene *m = made_scene_new();
    cases[i].add(m);
    made_camera(m, vec3(0, 0, 3), vec3(0, 0, 0), 40, 4, 4);
    made_view(m);
    return m;
}

static void directions_follow_the_density(void **state)
{
    (void)state;
    for (int i = 0; i < N_CASES; i++) {
        struct made_scene *m = make(i);
        const struct light_case *c = &cases[i];
        struct chi2_result r = chi2_test(&c->domain, c->sample, c->pdf, m->view, N, (uint64_t)i);
        if (r.p < 0.01 / N_CASES || fabs(r.integral + r.lost - 1) > 0.01)
            fail_msg("%s: p = %g; density %g and %g not drawn are not 1", c->name, r.p, r.integral,
                     r.lost);
        made_scene_free(m);
    }
}

/* More than struct light_guide holds. */
static void add_many(struct made_scene *m)
{
    uint32_t bsdf = black(m), emitter = area(m);
    for (int i = 0; i < LIGHT_GUIDES + 5; i++) {
        float a = 0.17f * (float)i, r = 2.0f + 0.05f * (float)i;
        struct vec3 center = vec3(r * cosf(a), 0.1f * (float)(i % 5), r * sinf(a));
        made_sphere(m, center, 0.1f + 0.004f * (float)i, bsdf, emitter);
    }
}

/* Lights are chosen as often as light_probability() says, at several places; what is left of the
 * random number is uniform. Chi-square, and five standard errors. */
static void choices_follow_the_probability(void **state)
{
    (void)state;
    static void (*const add[])(struct made_scene *) = {add_many, add_all};
    for (int i = 0; i < 2; i++) {
        struct made_scene *m = made_scene_new();
        add[i](m);
        made_camera(m, vec3(0, 0, 3), vec3(0, 0, 0), 40, 4, 4);
        const struct view *v = made_view(m);
        assert_true((v->n_lights > LIGHT_GUIDES) == (i == 0));
        for (int place = 0; place < 3; place++) {
            struct vec3 p = vec3(0.4f * (float)place, 0.2f, -0.3f * (float)place);
            struct rng rng = rng_keyed(11, (uint64_t)i, (uint64_t)place);
            enum { DRAWS = 200000 };
            int counts[MADE_MAX] = {0};
            double rest = 0, total = 0, chi2 = 0;
            int freedom = -1;
            for (int k = 0; k < DRAWS; k++) {
                float u1 = rng_float(&rng), probability;
                uint32_t light = light_choose(v, p, &u1, &probability);
                assert_true(light < v->n_lights && u1 >= 0 && u1 < 1);
                assert_true(fabsf(probability - light_probability(v, p, light)) < 1e-6f);
                counts[light]++;
                rest += u1;
            }
            for (uint32_t k = 0; k < v->n_lights; k++) {
                double expected = DRAWS * (double)light_probability(v, p, k);
                total += expected;
                if (expected >= 5) {
                    chi2 += (counts[k] - expected) * (counts[k] - expected) / expected;
                    freedom++;
                }
                if (fabs(counts[k] - expected) > 5 * sqrt(expected))
                    fail_msg("light %u: %d times instead of %g", k, counts[k], expected);
            }
            assert_true(freedom > 0);
            if (chi2_tail(chi2, freedom) < 1e-3)
                fail_msg("place %d: p = %g", place, chi2_tail(chi2, freedom));
            assert_true(fabs(total / DRAWS - 1) < 1e-5);
            assert_true(fabs(rest / DRAWS - 0.5) < 5 * sqrt(1.0 / 12 / DRAWS));
        }
        made_scene_free(m);
    }
}

/* How far a and b are apart, relative to b. */
static double apart(struct vec3 a, struct vec3 b)
{
    return vec3_length(vec3_sub(a, b)) / fmax(vec3_length(b), 1e-20);
}

/* The density that comes with a sample, and its weight, are what the functions say there. Places
 * seen at grazing angles are left out: their cosine is mostly rounding. One in 1000 may lie across
 * an edge, or at the pole of a map. */
static void samples_agree_with_functions(void **state)
{
    (void)state;
    for (int i = 0; i < N_CASES; i++) {
        struct made_scene *m = make(i);
        const struct view *v = m->view;
        struct rng rng = rng_keyed(2, (uint64_t)i, 0);
        int n_checked = 0, n_off = 0;
        for (int k = 0; k < 20000; k++) {
            float u1 = rng_float(&rng), u2 = rng_float(&rng);
            struct light_sample s;
            if (!light_sample(v, reference, u1, u2, &s) || s.is_delta) continue;
            if (fabsf(vec3_length(s.d) - 1) > 1e-5f) fail_msg("%s: not unit", cases[i].name);
            struct surface at;
            double error = INFINITY;
            if (s.is_infinite) {
                for (uint32_t j = v->first_environment; j < v->n_lights; j++) {
                    const struct light *l = &v->lights[j];
                    double pdf = light_environment_pdf(v, l, reference, s.d);
                    struct vec3 radiance = light_environment_radiance(v, l, s.d);
                    error = fmin(error, fmax(fabs(pdf / s.pdf - 1),
                                             apart(vec3_scale(s.weight, s.pdf), radiance)));
                }
            } else {
                if (!seen(v, s.d, &at) || vec3_dot(at.frame.n, s.d) > -0.05f) continue;
                double pdf = light_surface_pdf(v, reference, &at, s.d, at.t);
                struct vec3 radiance = light_surface_radiance(v, &at, s.d);
                error = fmax(fabs(pdf / s.pdf - 1), apart(vec3_scale(s.weight, s.pdf), radiance));
                error = fmax(error, vec3_length(vec3_sub(at.p, s.p)));
            }
            n_checked++;
            n_off += !(error <= 1e-3);
        }
        if (n_off > n_checked / 1000)
            fail_msg("%s: %d of %d samples are off", cases[i].name, n_off, n_checked);
        made_scene_free(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(directions_follow_the_density),
        cmocka_unit_test(choices_follow_the_probability),
        cmocka_unit_test(samples_agree_with_functions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
