/* SPDX-License-Identifier: Apache-2.0 */
/* What lights send to a point, against values known from geometry and from the models that they are
 * made from. */
#include "base/rng.h"
#include "made_light.h"
#include "render/sky_model.h"

#include "../image/cmocka_all.h" /* last: its macro fail() hides ours */

/* What arrives at the reference point on a surface of normal n (0: from all around, without the
 * cosine), in the red channel, must be as expected within 4 standard errors, which are small. */
static void check_arrives(const char *name, const struct made_scene *m, struct vec3 n,
                          double expected)
{
    enum { SAMPLES = 200000 };
    struct rng rng = rng_keyed(3, 0, 0);
    double sum = 0, squares = 0;
    for (int k = 0; k < SAMPLES; k++) {
        float u1 = rng_float(&rng), u2 = rng_float(&rng);
        struct light_sample s;
        if (!light_sample(m->view, reference, u1, u2, &s)) continue;
        double cosine = vec3_is_zero(n) ? 1 : fmax(0, vec3_dot(n, s.d));
        double x = cosine * s.weight.x;
        sum += x;
        squares += x * x;
    }
    double mean = sum / SAMPLES, variance = fmax(0, squares / SAMPLES - mean * mean);
    double error = sqrt(variance / SAMPLES);
    if (error > 0.01 * expected || fabs(mean - expected) > 4 * error + 1e-4 * expected)
        fail_msg("%s: %g instead of %g (standard error %g)", name, mean, expected, error);
}

/* A light of radiance 1 (red), through an instance at a place that is ours. */
static struct made_scene *start(struct transform place)
{
    struct made_scene *m = made_scene_new();
    place_group(m, place);
    made_camera(m, vec3(0, 0, 3), vec3(0, 0, 0), 40, 4, 4);
    return m;
}

static void finish(const char *name, struct made_scene *m, struct vec3 n, double expected)
{
    made_view(m);
    check_arrives(name, m, n, expected);
    made_scene_free(m);
}

static void surfaces_send_what_they_should(void **state)
{
    (void)state;
    const struct vec3 up = {0, 0, 1}, aslant = {0.6f, 0, 0.8f};
    struct transform here = transform_translate(reference), turn, both;

    /* A sphere that is wholly above the horizon: pi L (R / D)^2 cos. */
    struct made_scene *m = start(here);
    made_sphere(m, vec3(0, 0, 3), 1.5f, black(m), area(m));
    finish("sphere", m, up, pi / 4);
    m = start(here);
    made_sphere(m, vec3(0, 0, 3), 1.5f, black(m), area(m));
    finish("sphere aslant", m, aslant, 0.8 * pi / 4);

    /* All around: pi L. From outside of a sphere that shines inwards, nothing. */
    m = start(here);
    uint32_t s = made_sphere(m, vec3(0.5f, 0.2f, 0), 2, black(m), area(m));
    m->shapes[s].flip_normals = true;
    finish("hollow sphere", m, up, pi);
    m = start(here);
    s = made_sphere(m, vec3(0, 0, 3), 1, black(m), area(m));
    m->shapes[s].flip_normals = true;
    finish("hollow sphere from outside", m, up, 0);

    /* A disk of radius 1.5 at height 2, facing us: pi L R^2 / (R^2 + h^2). */
    turn = transform_rotate(vec3(1, 0, 0), 180);
    both = transform_mul(&here, &turn);
    m = start(both);
    struct transform move = transform_translate(vec3(0, 0, -2)),
                     scale = transform_scale(vec3_splat(1.5f)), place;
    place = transform_mul(&move, &scale);
    made_disk(m, &place, black(m), area(m));
    finish("disk", m, up, pi * 2.25 / 6.25);
    m = start(here);
    move = transform_translate(vec3(0, 0, 2));
    place = transform_mul(&move, &scale);
    made_disk(m, &place, black(m), area(m));
    finish("disk from behind", m, up, 0);

    /* From inside of a cylinder of radius r and height h, at one end and looking along its axis:
     * all but the disk at the other end, pi L (1 - r^2 / (r^2 + h^2)). */
    m = start(here);
    scale = transform_scale(vec3(0.75f, 0.75f, 2));
    s = made_cylinder(m, &scale, black(m), area(m));
    m->shapes[s].flip_normals = true;
    finish("hollow cylinder", m, up, pi * (1 - 0.5625 / 4.5625));
    m = start(here);
    made_cylinder(m, &scale, black(m), area(m));
    finish("cylinder from inside", m, up, 0);
    scale = transform_scale(vec3_splat(1.5f));

    /* A rectangle 2a x 2b at height h: four times the form factor of a corner (Lambert). */
    scale = transform_scale(vec3(0.5f, 2, 1));
    both = transform_mul(&here, &scale);
    m = start(both);
    made_quad(m, vec3(-1, -1, 1.25f), vec3(0, 2, 0), vec3(2, 0, 0), black(m), area(m));
    double x = 0.5 / 1.25, y = 2 / 1.25, rx = sqrt(1 + x * x), ry = sqrt(1 + y * y);
    finish("rectangle", m, up, 2 * (x / rx * atan(y / rx) + y / ry * atan(x / ry)));

    /* A point of intensity 1. */
    m = start(here);
    made_point(m, vec3_add(reference, vec3(0, 3, 4)), vec3_splat(1));
    finish("point", m, up, 0.8 / 25);

    /* One of each: the sum, whichever light is chosen. */
    m = start(here);
    made_sphere(m, vec3(0, 0, 3), 1.5f, black(m), area(m));
    made_sphere(m, vec3(3, 0, 4), 0.5f, black(m), area(m));
    made_point(m, vec3_add(reference, vec3(0, 3, 4)), vec3_splat(1));
    made_emitter(m, EMITTER_CONSTANT, vec3_splat(2));
    finish("four lights", m, up, pi / 4 + 0.8 * pi / 100 + 0.8 / 25 + 2 * pi);
}

static void environments_send_what_they_should(void **state)
{
    (void)state;
    const struct vec3 up = {0, 0, 1}, nowhere = {0, 0, 0};
    struct made_scene *m = start(transform_identity());
    made_emitter(m, EMITTER_CONSTANT, vec3_splat(0.7f));
    finish("constant", m, up, 0.7 * pi);

    /* A map whose rows are alike: radiance is linear in the angle from +y, between the rows. Over
     * the sphere: 2 pi times the integral of sin t f(t). */
    const float rows[3] = {4, 0, 1};
    float rgb[6 * 3 * 3];
    for (int i = 0; i < 6 * 3 * 3; i++) rgb[i] = rows[i / 18];
    m = start(transform_identity());
    uint32_t e = made_emitter(m, EMITTER_ENVMAP, vec3_splat(1));
    m->emitters[e].bitmap = made_bitmap(m, 6, 3, rgb);
    m->emitters[e].scale = 0.5f;
    m->emitters[e].to_world = transform_rotate(vec3(1, 2, 3), 77);
    /* The integral of sin t (1 - 2 t / pi) from 0 to pi / 2 is 1 - 2 / pi. */
    finish("rows", m, nowhere, 0.5 * 2 * pi * (1 - 2 / pi) * (4 + 1));
}

/* The sky's table against the model that it is made from, by a sum over the upper half. */
static void skies_send_what_they_should(void **state)
{
    (void)state;
    const struct vec3 up = {0, 0, 1}, aslant = {0.6f, 0, 0.8f};
    const double elevation = 20 * pi / 180;
    enum { ROWS = 400, COLUMNS = 800 };
    struct sky_model model;
    sky_model_init(&model, 2.5, elevation);
    double sums[2] = {0};
    for (int i = 0; i < ROWS; i++) {
        double z = (i + 0.5) / ROWS, r = sqrt(1 - z * z);
        for (int k = 0; k < COLUMNS; k++) {
            double phi = 2 * pi * (k + 0.5) / COLUMNS, beta = phi - (20 - 140) * pi / 180;
            double gamma = z * sin(elevation) + r * cos(elevation) * cos(beta);
            struct vec3 c = sky_model_radiance(&model, (float)z, (float)gamma);
            double share = 1.5 * 2 * pi / ROWS / COLUMNS * c.x;
            sums[0] += share * z;
            sums[1] += share * fmax(0, 0.6 * r * cos(phi) + 0.8 * z);
        }
    }
    for (int i = 0; i < 2; i++) {
        struct made_scene *m = start(transform_identity());
        add_sky(m);
        finish("sky", m, i ? aslant : up, sums[i]);
    }

    /* The sun sends the same whatever its size; what of it has set sends nothing. */
    double light = sky_model_sun(2.5, elevation).x;
    for (int i = 0; i < 3; i++) {
        struct made_scene *m = start(transform_identity());
        add_sun(m);
        m->emitters[0].sun_elevation = 20;
        m->emitters[0].sun_aperture = i == 0 ? 0.2f : i == 1 ? 0.5358f : 4;
        finish("sun", m, up, 2 * light * sin(elevation));
    }
    struct made_scene *m = start(transform_identity());
    add_sun(m);
    m->emitters[0].sun_elevation = 1e-3f;
    m->emitters[0].scale = 1e6f;
    light = 1e6 * sky_model_sun(2.5, 1e-3 * pi / 180).x;
    finish("setting sun", m, vec3(0, 0, 0), light);
}

/* Numbers worked out by hand from the formulas of the paper: T = 3, 45 degrees. */
static void the_sky_is_preethams(void **state)
{
    (void)state;
    struct sky_model m;
    sky_model_init(&m, 3, pi / 4);
    struct vec3 c = sky_model_radiance(&m, 1, (float)sqrt(0.5));
    double chi = (4.0 / 9 - 3.0 / 120) * pi / 2;
    double kcd = (4.0453 * 3 - 4.9710) * tan(chi) - 0.2155 * 3 + 2.4192;
    assert_float_equal(kcd, 7.3204, 1e-3);
    double Y = 0.2126729 * c.x + 0.7151522 * c.y + 0.0721750 * c.z;
    assert_float_equal(Y * 683 * 106.857, kcd * 1000, 1);
    /* x = .2453, y = .2466 at the zenith */
    double X = 0.4124564 * c.x + 0.3575761 * c.y + 0.1804375 * c.z;
    double Z = 0.0193339 * c.x + 0.1191920 * c.y + 0.9503041 * c.z;
    double t = pi / 4, t2 = t * t, t3 = t2 * t;
    double x = 9 * (0.00166 * t3 - 0.00375 * t2 + 0.00209 * t) +
               3 * (-0.02903 * t3 + 0.06377 * t2 - 0.03202 * t + 0.00394) + 0.11693 * t3 -
               0.21196 * t2 + 0.06052 * t + 0.25886;
    assert_float_equal(X / (X + Y + Z), x, 1e-4);
    /* A sun overhead in clear air has most of its light: 1.9 W / (m^2 nm) at 550 nm outside. */
    struct vec3 sun = sky_model_sun(2, pi / 2);
    assert_true(sun.y > 1.2f && sun.y < 1.6f && sun.x > sun.y && sun.y > sun.z);
    assert_true(vec3_is_zero(sky_model_sun(2, -0.1)));
    /* Below the horizon and in absurd air nothing is negative or broken. */
    for (double turbidity = 1; turbidity <= 10; turbidity += 0.5)
        for (double elevation = -90; elevation <= 90; elevation += 7.5) {
            sky_model_init(&m, turbidity, elevation * pi / 180);
            for (int i = 0; i <= 100; i++) {
                c = sky_model_radiance(&m, (float)(i % 11) / 10, (float)(i - 50) / 50);
                assert_true(vec3_is_finite(c) && c.x >= 0 && c.y >= 0 && c.z >= 0);
            }
        }
}

/* Red light of lights that send it from one direction: what they should, or nothing. */
static void check_delta(const char *name, struct made_scene *m, double expected)
{
    m->textures[m->emitters[0].radiance].value = vec3(2, 1, 0.5f);
    m->emitters[0].scale = 1.5f;
    finish(name, m, vec3(0, 0, 1), 3 * expected);
}

/* A light at (0, 3, 4) from the reference point that looks back at it, turned off by `degrees`. */
static struct made_scene *start_delta(enum emitter_kind kind, float degrees)
{
    struct made_scene *m = start(transform_identity());
    uint32_t e = made_emitter(m, kind, vec3_splat(1));
    struct transform turn = transform_rotate(vec3(0, 1, 0), degrees);
    struct transform look = transform_look_at(vec3_add(reference, vec3(0, 3, 4)), reference,
                                              vec3(1, 0, 0));
    m->emitters[e].to_world = transform_mul(&look, &turn);
    m->emitters[e].cutoff = 30;
    m->emitters[e].beam_width = 10;
    m->emitters[e].fov = 60;
    return m;
}

static void single_directions_send_what_they_should(void **state)
{
    (void)state;
    /* Spots: intensity / distance^2 times the cosine, falling evenly from 10 to 30 degrees. */
    check_delta("spot", start_delta(EMITTER_SPOT, 9.9f), 0.8 / 25);
    check_delta("spot's rim", start_delta(EMITTER_SPOT, 25), 0.8 / 25 * 0.25);
    check_delta("beyond a spot", start_delta(EMITTER_SPOT, 30.1f), 0);
    struct made_scene *m = start_delta(EMITTER_SPOT, 10);
    m->emitters[0].beam_width = 40; /* variables can do that */
    m->emitters[0].cutoff = 10.1f;
    check_delta("sharp spot", m, 0.8 / 25);

    /* A picture of two colours on the cone: one half of it is left of the axis. */
    for (int side = -1; side <= 1; side += 2) {
        m = start_delta(EMITTER_SPOT, (float)side * 5);
        uint32_t t = made_texture(m, vec3_splat(1));
        m->textures[t] = (struct texture){.kind = TEXTURE_CHECKERBOARD,
                                          .value = vec3_splat(1),
                                          .color0 = vec3_splat(0.25f),
                                          .color1 = vec3_splat(0.75f),
                                          .to_uv = {{1, 0, 0}, {0, 0, 0.25f}}};
        m->emitters[0].picture = t;
        /* Turned by +5 degrees about y, the light has the point at its -x. */
        check_delta("picture of a spot", m, 0.8 / 25 * (side > 0 ? 0.25 : 0.75));
    }

    /* From infinity: irradiance times the cosine, whatever the scale of to_world. */
    m = start(transform_identity());
    made_emitter(m, EMITTER_DIRECTIONAL, vec3_splat(1));
    struct transform turn = transform_rotate(vec3(0, 1, 0), 180 - 60),
                     scale = transform_scale(vec3_splat(7));
    m->emitters[0].to_world = transform_mul(&turn, &scale);
    check_delta("directional", m, 0.5);
    m = start(transform_identity());
    made_emitter(m, EMITTER_DIRECTIONAL, vec3_splat(1));
    check_delta("directional from below", m, 0);

    /* A projector of 60 degrees: pi E / z^2 / cos on what faces its rays, within its picture. */
    check_delta("projector", start_delta(EMITTER_PROJECTOR, 0), pi * 0.8 / 25);
    double cosine = cos(25 * pi / 180);
    check_delta("aside in a projector", start_delta(EMITTER_PROJECTOR, 25),
                pi * 0.8 / 25 / (cosine * cosine * cosine));
    check_delta("beyond a projector", start_delta(EMITTER_PROJECTOR, 30.1f), 0);
    check_delta("behind a projector", start_delta(EMITTER_PROJECTOR, 180), 0);
}

/* Lights along normals: what of the power per area of 1 arrives. */
static void normals_send_what_they_should(void **state)
{
    (void)state;
    const struct vec3 up = {0, 0, 1}, aslant = {0.6f, 0, 0.8f}, any = {0, 0, 0};
    struct transform here = transform_translate(reference);

    /* A plate above, at any height; one whose edge ends before; one that looks away. */
    struct made_scene *m = start(here);
    made_quad(m, vec3(-1, -1.5f, 5), vec3(0, 2, 0), vec3(2, 0, 0), black(m), area(m));
    m->emitters[0].kind = EMITTER_DIRECTIONAL_AREA;
    finish("plate", m, aslant, 0.8);
    m = start(here);
    made_quad(m, vec3(0.01f, -1, 5), vec3(0, 2, 0), vec3(2, 0, 0), black(m), area(m));
    m->emitters[0].kind = EMITTER_DIRECTIONAL_AREA;
    finish("plate beside", m, aslant, 0);
    m = start(here);
    made_quad(m, vec3(-1, -1.5f, 5), vec3(2, 0, 0), vec3(0, 2, 0), black(m), area(m));
    m->emitters[0].kind = EMITTER_DIRECTIONAL_AREA;
    finish("plate from behind", m, aslant, 0);

    /* A mesh of three plates above each other, of which one is turned: no light is lost to the
     * choice among the other two. Mirrored by its instance, it is the one. */
    static const float positions[] = {-1, -1, 2, 1, -1, 2,  0, 1, 2,  -1, -1, 3, 1, -1,
                                      3,  0,  1, 3, -1, -1, 4, 1, -1, 4,  0,  1, 4};
    static const uint32_t indices[] = {0, 2, 1, 3, 4, 5, 6, 8, 7};
    m = start(here);
    made_mesh(m, 9, positions, 3, indices, black(m), area(m));
    m->emitters[0].kind = EMITTER_DIRECTIONAL_AREA;
    finish("plates", m, up, 2);
    struct transform turn = transform_scale(vec3(1, 1, -1)), place = transform_mul(&here, &turn);
    m = start(place);
    made_mesh(m, 9, positions, 3, indices, black(m), area(m));
    m->emitters[0].kind = EMITTER_DIRECTIONAL_AREA;
    finish("plates, mirrored", m, vec3(0, 0, -1), 2);

    /* Ellipses of a disk: its middle and its end. */
    struct transform down = transform_rotate(vec3(1, 0, 0), 180),
                     wide = transform_scale(vec3(2, 0.5f, 1));
    for (int i = 0; i < 2; i++) {
        struct transform move = transform_translate(vec3(i ? 1.9f : 2.1f, 0, 3));
        struct transform disk = transform_mul(&wide, &down);
        disk = transform_mul(&move, &disk);
        m = start(here);
        made_disk(m, &disk, black(m), area(m));
        m->emitters[0].kind = EMITTER_DIRECTIONAL_AREA;
        finish("disk along its normal", m, up, i ? 1 : 0);
    }

    /* A sphere spreads its light, a hollow one gathers that of both sides. */
    m = start(here);
    made_sphere(m, vec3(0, 0, 3), 1.5f, black(m), area(m));
    m->emitters[0].kind = EMITTER_DIRECTIONAL_AREA;
    finish("sphere along normals", m, aslant, 0.8 / 4);
    m = start(here);
    uint32_t s = made_sphere(m, vec3(0, 0, 1), 2, black(m), area(m));
    m->shapes[s].flip_normals = true;
    m->emitters[0].kind = EMITTER_DIRECTIONAL_AREA;
    finish("hollow sphere along normals", m, any, 2 * 4);
    m = start(here);
    s = made_sphere(m, vec3(0, 0, 1), 2, black(m), area(m));
    m->emitters[0].kind = EMITTER_DIRECTIONAL_AREA;
    finish("sphere along normals, from inside", m, any, 0);

    /* It cannot be seen. */
    m = start(transform_identity());
    made_sphere(m, vec3(2, 0, 0), 0.5f, black(m), area(m));
    m->emitters[0].kind = EMITTER_DIRECTIONAL_AREA;
    made_view(m);
    struct surface at;
    struct vec3 d = vec3_normalize(vec3_sub(vec3(2, 0, 0), reference));
    assert_true(seen(m->view, d, &at));
    assert_true(vec3_is_zero(light_surface_radiance(m->view, &at, d)));
    made_scene_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_send_what_they_should),
        cmocka_unit_test(environments_send_what_they_should),
        cmocka_unit_test(normals_send_what_they_should),
        cmocka_unit_test(skies_send_what_they_should),
        cmocka_unit_test(the_sky_is_preethams),
        cmocka_unit_test(single_directions_send_what_they_should),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
