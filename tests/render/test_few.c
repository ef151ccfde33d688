/* SPDX-License-Identifier: Apache-2.0 */
/* Rays into few primitives against Embree: the same triangles, at the same points. */
#include <math.h>

#include "base/cpu.h"
#include "base/rng.h"
#include "render/stream.h"
#include "render/world.h"

#include "../scene/scene_text.h" /* last: its macro fail() hides ours */

enum { N_STREAMS = 200 };

static const char box_and_ball[] = TEXT_SENSOR
    "<shape type='cube'><transform name='to_world'><scale x='.5' y='1' z='.7'/>"
    "<rotate y='1' angle='20'/><translate x='1.2' y='.3'/></transform></shape>"
    "<shape type='sphere'><point name='center' x='-1' y='.2' z='.3'/>"
    "<float name='radius' value='.8'/></shape>"
    "<shape type='disk'><transform name='to_world'><scale x='1.5' y='.6'/>"
    "<rotate x='1' angle='70'/><translate z='1.5'/></transform></shape>"
    "<shape type='rectangle'><boolean name='flip_normals' value='true'/>"
    "<transform name='to_world'><scale value='3'/><translate z='-2'/></transform></shape>";

/* A floor that turns, a wall, a ball and a lamp before the wall. */
static const char room[] = TEXT_SENSOR
    "<shape type='rectangle'><transform name='to_world'><scale value='3'/>"
    "<rotate x='1' angle='-70'/></transform></shape>"
    "<shape type='rectangle'><transform name='to_world'><scale value='3'/>"
    "<translate z='-4'/></transform></shape>"
    "<shape type='sphere'><point name='center' y='1.5' z='-2.6'/></shape>"
    "<shape type='rectangle'><transform name='to_world'><scale value='.6'/>"
    "<translate x='1.2' y='1.5' z='-1.5'/></transform>"
    "<emitter type='area'><rgb name='radiance' value='1'/></emitter></shape>";

struct made {
    struct scene *scene;
    struct world *world;
    struct view *view;
};

static struct made make(const char *text)
{
    struct made m = {0};
    struct error err = {""};
    m.scene = text_scene(text);
    if (world_new(m.scene, cpu_detect(), &m.world, &err) || view_new(m.world, &m.view, &err))
        fail_msg("%s", err.text);
    return m;
}

static void release(struct made *m)
{
    view_free(m->view);
    world_free(m->world);
    scene_free(m->scene);
}

/* Rays between points around the scene. */
static void fill(struct stream *s, struct rng *r)
{
    s->n = STREAM_SIZE;
    for (uint32_t i = 0; i < s->n; i++) {
        struct vec3 p[2];
        for (int k = 0; k < 2; k++) {
            float x = rng_float(r), y = rng_float(r), z = rng_float(r);
            p[k] = vec3(6.0f * x - 3.0f, 6.0f * y - 3.0f, 6.0f * z - 3.0f);
        }
        struct vec3 d = vec3_normalize(vec3_sub(p[1], p[0]));
        if (i % 16 == 0) d = vec3(0.0f, i % 32 ? 1.0f : -1.0f, 0.0f); /* along sides */
        s->is_alive[i] = s->is_connected[i] = true;
        lanes3_set(&s->o, i, p[0]);
        lanes3_set(&s->d, i, d);
        lanes3_set(&s->shadow_o, i, p[0]);
        lanes3_set(&s->shadow_d, i, d);
        s->t_max[i] = i % 2 ? INFINITY : 3.0f;
        s->shadow_t_max[i] = i % 3 ? INFINITY : 2.0f;
    }
}

static bool is_near(float a, float b)
{
    return fabsf(a - b) < 1e-4f * fmaxf(1.0f, fabsf(b));
}

static bool is_same(const struct hit *a, const struct hit *b)
{
    if (a->shape != b->shape) return false;
    if (a->shape == SCENE_NONE) return true;
    return a->primitive == b->primitive && a->instance == b->instance && is_near(a->t, b->t) &&
           is_near(a->u, b->u) && is_near(a->v, b->v);
}

static void hits_are_embree_s(void **state)
{
    (void)state;
    static struct stream s;
    struct made m = make(box_and_ball);
    struct view *v = m.view;
    const struct stream_kernels *const sets[] = {&stream_kernels_baseline, m.world->kernels};
    struct rng r = rng_keyed(5, 6, 7);
    uint32_t n_wrong = 0, n_hit = 0, n_dark = 0;
    assert_true(few_is_used(&v->few));
    assert_int_equal(v->few.n_faces, 6 + 1 + 1); /* a cube's sides are parallelograms */
    assert_int_equal(v->few.n_boxes, 1);
    assert_int_equal(v->few.n_loose, 1);
    assert_int_equal(v->few.first_wall[3], 1);
    assert_int_equal(v->few.n_spheres, 1);
    for (int k = 0; k < N_STREAMS; k++) {
        fill(&s, &r);
        sets[k % 2]->few_cast(&s, &v->few);
        stream_find_hits(&s, v);
        sets[k % 2]->few_shade(&s, &v->few, s.is_free);
        for (uint32_t i = 0; i < s.n; i++) {
            struct ray ray = {lanes3_get(&s.o, i), 0.0f, lanes3_get(&s.d, i), s.t_max[i]};
            struct hit want;
            accel_intersect(v->top, &ray, &want);
            ray.t_max = s.shadow_t_max[i];
            bool is_free = !accel_occluded(v->top, &ray);
            n_hit += want.shape != SCENE_NONE;
            n_dark += !is_free;
            n_wrong += !is_same(&s.hit[i], &want) || is_free != (s.is_free[i] != 0);
            if (want.shape == SCENE_NONE || want.shape == 1) continue; /* a sphere has none */
            struct vec3 a = vec3_normalize(s.hit[i].ng), b = vec3_normalize(want.ng);
            n_wrong += !(vec3_dot(a, b) > 0.999f);
        }
    }
    assert_true(n_hit > N_STREAMS * STREAM_SIZE / 4 && n_dark > N_STREAMS * STREAM_SIZE / 4);
    /* Rays on an edge may fall on either side of it. */
    if (n_wrong > 3) fail_msg("%u of %u rays differ", n_wrong, N_STREAMS * STREAM_SIZE);
    release(&m);
}

/* What is at the outside hides no light that is inside. */
static void outside_faces_are_skipped(void **state)
{
    (void)state;
    static struct stream s;
    struct made m = make(room);
    const struct few *few = &m.view->few;
    struct rng r = rng_keyed(8, 9, 10);
    uint32_t n_wrong = 0, n_lit = 0, n_dark = 0;
    /* The wall hides nothing; the floor, which the wall passes through, and the lamp may. */
    assert_int_equal(few->n_loose, 1);
    assert_true(few->faces[0].shades);
    assert_int_equal(few->first_wall[3], 2);
    for (int k = 0; k < 2; k++) assert_int_equal(few->walls[k].shades, few->walls[k].at == -1.5f);
    for (int k = 0; k < N_STREAMS; k++) {
        s.n = STREAM_SIZE;
        for (uint32_t i = 0; i < s.n; i++) { /* from the wall to the lamp's plane */
            float u[4];
            for (int c = 0; c < 4; c++) u[c] = 2.0f * rng_float(&r) - 1.0f;
            struct vec3 p = vec3(3.0f * u[0], 3.0f * u[1], -4.0f);
            struct vec3 d = vec3_sub(vec3(1.2f + u[2], 1.5f + u[3], -1.5f), p);
            lanes3_set(&s.shadow_o, i, vec3_madd(p, d, 1e-4f));
            lanes3_set(&s.shadow_d, i, d);
            s.shadow_t_max[i] = 0.999f;
            s.is_connected[i] = 1;
        }
        m.world->kernels->few_shade(&s, few, s.is_free);
        for (uint32_t i = 0; i < s.n; i++) {
            struct ray ray = {lanes3_get(&s.shadow_o, i), 0.0f, lanes3_get(&s.shadow_d, i), 0.999f};
            bool is_free = !accel_occluded(m.view->top, &ray);
            n_lit += is_free;
            n_dark += !is_free;
            n_wrong += is_free != (s.is_free[i] != 0);
        }
    }
    assert_true(n_lit > 1000 && n_dark > 1000);
    if (n_wrong > 1) fail_msg("%u of %u rays differ", n_wrong, n_lit + n_dark);
    release(&m);
}

/* Instruction sets agree to the bit. */
static void sets_agree(void **state)
{
    (void)state;
    static struct stream a, b;
    struct made m = make(box_and_ball);
    struct rng r = rng_keyed(1, 2, 3);
    fill(&a, &r);
    b = a;
    stream_kernels_baseline.few_cast(&a, &m.view->few);
    m.world->kernels->few_cast(&b, &m.view->few);
    for (uint32_t i = 0; i < a.n; i++) {
        assert_true(a.t[i] == b.t[i]);
        assert_int_equal(a.face[i], b.face[i]);
    }
    release(&m);
}

/* Too many, or of kinds that are left to Embree. */
static void others_are_not_few(void **state)
{
    (void)state;
    static const char *const texts[] = {
        TEXT_SENSOR "<shape type='cylinder'/>",
        TEXT_SENSOR "<shape type='sphere'/><shape type='sphere'/><shape type='sphere'/>"
                    "<shape type='sphere'/><shape type='sphere'/><shape type='sphere'/>"
                    "<shape type='sphere'/><shape type='sphere'/><shape type='sphere'/>",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        struct made m = make(texts[i]);
        assert_false(few_is_used(&m.view->few));
        release(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_embree_s),
        cmocka_unit_test(outside_faces_are_skipped),
        cmocka_unit_test(sets_agree),
        cmocka_unit_test(others_are_not_few),
    };
    return cmocka_run_group_tests(tests, text_setup, text_teardown);
}
