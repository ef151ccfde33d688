/* SPDX-License-Identifier: Apache-2.0 */
#include "render/few.h"

#include <string.h>

#include "render/world.h"

/* A primitive's place. */
struct owner {
    uint32_t instance, shape;
    const struct world_shape *of;
    const struct view_instance *in;
};

static struct vec3 corner(const struct owner *o, uint32_t triangle, uint32_t k)
{
    uint32_t vertex = o->of->indices[3 * (size_t)triangle + k % 3];
    return vec3_load(o->of->positions + 3 * (size_t)vertex);
}

/* Completes a face from its plane's axes in the group's space; false when they span nothing. */
static bool span(struct few_face *f, const struct owner *o, struct vec3 p, struct vec3 e0,
                 struct vec3 e1)
{
    const struct transform *m = o->in->to_world;
    f->instance = o->instance;
    f->shape = o->shape;
    f->ng = vec3_cross(e0, e1);
    if (!o->in->is_identity) {
        p = transform_point(m, p);
        e0 = transform_vector(m, e0);
        e1 = transform_vector(m, e1);
    }
    f->p = p;
    f->e0 = e0;
    f->e1 = e1;
    f->n = vec3_cross(e0, e1);
    float n2 = vec3_dot(f->n, f->n);
    f->to_x = vec3_scale(vec3_cross(e1, f->n), 1.0f / n2);
    f->to_y = vec3_scale(vec3_cross(f->n, e0), 1.0f / n2);
    return n2 > 0.0f && vec3_is_finite(f->to_x) && vec3_is_finite(f->to_y);
}

/* A triangle as a face: the origin is its corner k. */
static bool face_of(struct few_face *f, const struct owner *o, uint32_t triangle, uint32_t k)
{
    struct vec3 p = corner(o, triangle, k);
    *f = (struct few_face){.most = 1.0f, .most2 = 2.0f, .triangle = {triangle, triangle}};
    for (uint8_t i = 0; i < 2; i++) f->corner[0][i] = (uint8_t)((i + 1 + 3 - k) % 3);
    return span(f, o, p, vec3_sub(corner(o, triangle, k + 1), p),
                vec3_sub(corner(o, triangle, k + 2), p));
}

static bool is_same(struct vec3 a, struct vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* Makes a parallelogram of a triangle and the next one, if they are its halves and face the same
 * way: corner k of the first is opposite to corner l of the second, across the common edge. */
static bool merge(struct few_face *f, const struct owner *o, uint32_t triangle)
{
    for (uint32_t k = 0; k < 3; k++) {
        struct vec3 a = corner(o, triangle, k), b = corner(o, triangle, k + 1),
                    c = corner(o, triangle, k + 2);
        struct vec3 across = vec3_sub(vec3_add(b, c), a);
        for (uint32_t l = 0; l < 3; l++) {
            struct vec3 off = vec3_sub(corner(o, triangle + 1, l), across);
            float size2 = vec3_dot(vec3_sub(b, c), vec3_sub(b, c));
            if (!is_same(corner(o, triangle + 1, l + 1), c) ||
                !is_same(corner(o, triangle + 1, l + 2), b) || vec3_dot(off, off) > 1e-12f * size2)
                continue;
            if (!face_of(f, o, triangle, k)) return false;
            f->most = 2.0f;
            f->triangle[1] = triangle + 1;
            /* Corners l, l + 1, l + 2 have the weights x + y - 1, 1 - x, 1 - y: c, then b. */
            static const uint8_t weights[3] = {0, 2, 1};
            for (uint8_t i = 0; i < 2; i++) f->corner[1][i] = weights[(i + 1 + 3 - l) % 3];
            return true;
        }
    }
    return false;
}

static bool add_mesh(struct few *f, const struct owner *o)
{
    const uint32_t n = o->of->mesh->n_triangles;
    for (uint32_t i = 0; i < n; i++) {
        if (f->n_faces == FEW_FACES) return false;
        struct few_face *face = &f->faces[f->n_faces];
        if (i + 1 < n && merge(face, o, i)) {
            f->n_faces++;
            i++;
        } else if (face_of(face, o, i, 0)) { /* else it has no area */
            f->n_faces++;
        }
    }
    return true;
}

static bool add_disk(struct few *f, const struct owner *o)
{
    const struct transform *m = o->of->to_group;
    if (f->n_faces == FEW_FACES) return false;
    struct few_face *face = &f->faces[f->n_faces];
    *face = (struct few_face){.most = 2.0f, .most2 = 1.0f, .least = -1.0f};
    if (span(face, o, transform_point(m, vec3_splat(0.0f)),
             transform_vector(m, vec3(1.0f, 0.0f, 0.0f)),
             transform_vector(m, vec3(0.0f, 1.0f, 0.0f))))
        f->n_faces++;
    face->ng = transform_normal(m, vec3(0.0f, 0.0f, 1.0f));
    return true;
}

static bool add_sphere(struct few *f, const struct owner *o)
{
    if (f->n_spheres == FEW_SPHERES || !(o->in->scale > 0.0f) || !(o->of->radius > 0.0f))
        return false;
    struct vec3 c = transform_point(o->in->to_world, o->of->center);
    f->spheres[f->n_spheres++] = (struct few_sphere){
        .center = {c.x, c.y, c.z},
        .radius = (double)o->of->radius * o->in->scale,
        .instance = o->instance,
        .shape = o->shape,
    };
    return true;
}

/* The sign with which a is parallel to b and as long: 1, -1, or 0. */
static int alike(struct vec3 a, struct vec3 b)
{
    const float least = 1e-10f * vec3_dot(b, b);
    struct vec3 less = vec3_sub(a, b), more = vec3_add(a, b);
    return vec3_dot(less, less) < least ? 1 : vec3_dot(more, more) < least ? -1 : 0;
}

/* The middle of a parallelogram. */
static struct vec3 middle_of(const struct few_face *f)
{
    return vec3_madd(vec3_madd(f->p, f->e0, 0.5f), f->e1, 0.5f);
}

/* Makes a box of six faces, if they are one. */
static bool box_of(struct few_box *b, const struct few_face *faces, int32_t first)
{
    struct vec3 axis[3] = {faces[0].e0, faces[0].e1}, center = vec3_splat(0.0f);
    const struct few_face *side = &faces[1]; /* one that is not parallel to the first */
    if (alike(side->n, faces[0].n)) side = &faces[2];
    for (int k = 0; k < 6; k++) {
        if (faces[k].most != 2.0f || faces[k].most2 != 2.0f) return false;
        center = vec3_madd(center, middle_of(&faces[k]), 1.0f / 6.0f);
    }
    bool is_first_shared = alike(side->e0, axis[0]) || alike(side->e0, axis[1]);
    axis[2] = is_first_shared ? side->e1 : side->e0;
    float volume = vec3_dot(axis[0], vec3_cross(axis[1], axis[2]));
    if (!(fabsf(volume) > 0.0f)) return false;
    *b = (struct few_box){.center = center, .face = {{-1, -1}, {-1, -1}, {-1, -1}}};
    for (int k = 0; k < 3; k++) {
        struct vec3 across = vec3_cross(axis[(k + 1) % 3], axis[(k + 2) % 3]);
        b->to_local[k] = vec3_scale(across, 2.0f / volume);
    }
    for (int k = 0; k < 6; k++) {
        struct vec3 out = vec3_scale(vec3_sub(middle_of(&faces[k]), center), 2.0f);
        for (int a = 0; a < 3; a++) {
            const int sign = alike(out, axis[a]);
            if (sign == 0) continue;
            const struct vec3 u = axis[(a + 1) % 3], v = axis[(a + 2) % 3];
            bool is_whole = (alike(faces[k].e0, u) && alike(faces[k].e1, v)) ||
                            (alike(faces[k].e0, v) && alike(faces[k].e1, u));
            if (is_whole) b->face[a][sign > 0] = first + k;
        }
    }
    for (int a = 0; a < 3; a++)
        if (b->face[a][0] < 0 || b->face[a][1] < 0) return false;
    return vec3_is_finite(b->to_local[0]) && vec3_is_finite(b->to_local[1]) &&
           vec3_is_finite(b->to_local[2]);
}

/* The axis along which `e` runs alone; 3: none. */
static int axis_of(struct vec3 e)
{
    if (e.y == 0.0f && e.z == 0.0f) return 0;
    if (e.x == 0.0f && e.z == 0.0f) return 1;
    return e.x == 0.0f && e.y == 0.0f ? 2 : 3;
}

static float component(struct vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/* The axis that a rectangle along the axes stands across; 3: it is none. */
static int wall_axis(const struct few_face *f)
{
    int a = axis_of(f->e0), b = axis_of(f->e1);
    bool is_one = f->most == 2.0f && f->most2 == 2.0f && a < 3 && b < 3 && a != b;
    return is_one ? 3 - a - b : 3;
}

static struct few_wall wall_of(const struct few_face *f, int axis)
{
    struct few_wall w = {.at = component(f->p, axis), .shades = f->shades};
    for (int k = 0; k < 2; k++) {
        int along = (axis + 1 + k) % 3;
        float a = component(f->p, along);
        float b = component(vec3_add(vec3_add(f->p, f->e0), f->e1), along);
        w.low[k] = min_float(a, b);
        w.high[k] = max_float(a, b);
    }
    return w;
}

/* Finds boxes and walls among the faces, and puts the others first, then walls by axis. */
static bool pack(struct few *f)
{
    enum { LOOSE = 3, BOXED };
    struct few_face faces[FEW_FACES];
    int kind[FEW_FACES];
    const uint32_t n = f->n_faces;
    memcpy(faces, f->faces, n * sizeof *faces);
    for (uint32_t i = 0; i < n; i++) kind[i] = wall_axis(&faces[i]);
    for (uint32_t i = 0; i + 6 <= n && f->n_boxes < FEW_BOXES; i++) {
        const struct few_face *a = &faces[i], *b = &faces[i + 5];
        if (a->shape != b->shape || a->instance != b->instance) continue;
        if (!box_of(&f->boxes[f->n_boxes], a, 0)) continue;
        for (uint32_t k = 0; k < 6; k++) kind[i + k] = BOXED;
        f->n_boxes++;
        i += 5;
    }
    if (n - 6 * f->n_boxes > FEW_LOOSE) return false;
    f->n_faces = 0;
    for (uint32_t i = 0; i < n; i++)
        if (kind[i] == LOOSE) f->faces[f->n_faces++] = faces[i];
    f->n_loose = f->n_faces;
    for (int axis = 0; axis < 3; axis++) {
        f->first_wall[axis] = f->n_faces - f->n_loose;
        for (uint32_t i = 0; i < n; i++) {
            if (kind[i] != axis) continue;
            f->walls[f->n_faces - f->n_loose] = wall_of(&faces[i], axis);
            f->faces[f->n_faces++] = faces[i];
        }
    }
    f->first_wall[3] = f->n_faces - f->n_loose;
    for (uint32_t k = 0; k < f->n_boxes; k++)
        for (int a = 0; a < 6; a++) f->boxes[k].face[a / 2][a % 2] += (int32_t)(f->n_faces + 6 * k);
    for (uint32_t i = 0; i < n; i++)
        if (kind[i] == BOXED) f->faces[f->n_faces++] = faces[i];
    return true;
}

/* ---- Faces at the outside -------------------------------------------------------------------- */

/* How far primitives reach along the normal of a face from its plane, times that normal. */
struct reach {
    float low, high;
};

static void reach_to(struct reach *r, const struct few_face *plane, struct vec3 p, float margin)
{
    float along = vec3_dot(plane->n, vec3_sub(p, plane->p));
    r->low = min_float(r->low, along - margin);
    r->high = max_float(r->high, along + margin);
}

/* Whether everything lies on one side of the plane. */
static bool is_outside(const struct few *f, const struct few_face *plane)
{
    struct reach r = {0, 0};
    float length = vec3_length(plane->n);
    for (uint32_t i = 0; i < f->n_faces; i++) {
        const struct few_face *face = &f->faces[i];
        struct vec3 e0 = face->e0, e1 = face->e1;
        struct vec3 from = face->least < 0.0f ? vec3_sub(vec3_sub(face->p, e0), e1) : face->p;
        if (face->least < 0.0f) {
            e0 = vec3_scale(e0, 2.0f);
            e1 = vec3_scale(e1, 2.0f);
        }
        reach_to(&r, plane, from, 0.0f);
        reach_to(&r, plane, vec3_add(from, e0), 0.0f);
        reach_to(&r, plane, vec3_add(from, e1), 0.0f);
        if (face->most == 2.0f) reach_to(&r, plane, vec3_add(vec3_add(from, e0), e1), 0.0f);
    }
    for (uint32_t i = 0; i < f->n_spheres; i++) {
        const struct few_sphere *s = &f->spheres[i];
        struct vec3 c = vec3((float)s->center[0], (float)s->center[1], (float)s->center[2]);
        reach_to(&r, plane, c, length * (float)s->radius);
    }
    const float least = 1e-6f * (r.high - r.low);
    return r.low >= -least || r.high <= least;
}

/* Between a point of the scene and a light that is one of its primitives nothing is met at the
 * outside. Other lights shine from anywhere. */
static void find_shades(struct few *f, const struct view *v)
{
    bool is_closed = v->world->scene->n_emitters > 0;
    for (uint32_t i = 0; i < v->world->scene->n_emitters; i++)
        is_closed = is_closed && emitter_is_surface(v->state.emitters[i].kind);
    for (uint32_t i = 0; i < f->n_faces; i++)
        f->faces[i].shades = !is_closed || !is_outside(f, &f->faces[i]);
}

/* ---------------------------------------------------------------------------------------------- */

static bool add_shape(struct few *f, const struct owner *o)
{
    switch (o->of->kind) {
    case SHAPE_MESH:
        return add_mesh(f, o);
    case SHAPE_DISK:
        return add_disk(f, o);
    case SHAPE_SPHERE:
        return add_sphere(f, o);
    case SHAPE_CYLINDER:
        break;
    }
    return false;
}

static void clear(struct few *f)
{
    f->n_faces = f->n_spheres = f->n_loose = f->n_boxes = 0;
}

void few_init(struct few *f, const struct view *v)
{
    const struct scene *s = v->world->scene;
    clear(f);
    for (uint32_t i = 0; i < s->n_instances; i++) {
        const struct instance *instance = &v->state.instances[i];
        const struct group *g = &s->groups[instance->group];
        if (!instance->is_visible) continue;
        for (uint32_t j = 0; j < g->n_shapes; j++) {
            const struct owner o = {i, j, &v->instances[i].shapes[j], &v->instances[i]};
            if (add_shape(f, &o)) continue;
            clear(f);
            return;
        }
    }
    find_shades(f, v);
    if (!pack(f)) clear(f);
}

/* Whether shading normals are those of the face, but for rounding: 1; opposite to it: -1; else 0.
 * *n: one of them, so that frames around it are those that interpolated ones have. */
static int shading_side(const struct world_shape *shape, const struct few_face *f, struct vec3 *n)
{
    int side = 0;
    *n = f->ng;
    if (!shape->normals) return 1;
    for (int i = 0; i < 6; i++) {
        const uint32_t *at = shape->indices + 3 * (size_t)f->triangle[i / 3];
        *n = vec3_load(shape->normals + 3 * (size_t)at[i % 3]);
        struct vec3 ng = vec3_normalize(f->ng), here = vec3_normalize(*n);
        int sign = vec3_dot(ng, here) < 0.0f ? -1 : 1;
        struct vec3 off = vec3_madd(here, ng, -(float)sign);
        if (!(vec3_dot(off, off) < 1e-10f) || sign == -side) return 0;
        side = sign;
    }
    return side;
}

static void few_set(struct few_vectors *to, uint32_t i, struct vec3 v)
{
    to->x[i] = v.x;
    to->y[i] = v.y;
    to->z[i] = v.z;
}

void few_look_init(struct few *f, const struct view *v)
{
    struct few_look *look = &f->look;
    memset(look->flags, 0, sizeof look->flags);
    for (uint32_t i = 0; i < f->n_faces; i++) {
        const struct few_face *face = &f->faces[i];
        const struct view_instance *in = &v->instances[face->instance];
        const struct world_shape *shape = &in->shapes[face->shape];
        const struct material *m = &v->materials[v->state.shape_bsdfs[shape->index]];
        if (!m->is_plain || m->texture != SCENE_NONE || shape->emitter != SCENE_NONE) continue;
        struct vec3 n;
        int side = shape->kind == SHAPE_MESH ? shading_side(shape, face, &n) : 0;
        if (side == 0) continue;
        if (!in->is_identity) n = transform_normal(in->to_world, n);
        few_set(&look->shading, i, shape->is_flipped ? vec3_neg(n) : n);
        few_set(&look->reflectance, i, m->reflectance);
        int flags = FEW_EVEN | (m->is_twosided ? FEW_TWOSIDED : 0) | (side < 0 ? FEW_OPPOSITE : 0);
        look->flags[i] = (float)flags;
    }
}

void few_hit(const struct few *f, int32_t index, struct vec3 o, struct vec3 d, float t,
             struct hit *hit)
{
    hit->t = t;
    if (index < 0) {
        hit->shape = SCENE_NONE;
        return;
    }
    if ((uint32_t)index >= f->n_faces) {
        const struct few_sphere *s = &f->spheres[(uint32_t)index - f->n_faces];
        *hit = (struct hit){.t = t, .ng = {0, 0, 1}, .shape = s->shape, .instance = s->instance};
        return;
    }
    const struct few_face *face = &f->faces[index];
    struct vec3 at = vec3_madd(vec3_sub(o, face->p), d, t);
    const float x = vec3_dot(face->to_x, at), y = vec3_dot(face->to_y, at);
    bool is_beyond = x + y > 1.0f;
    const float weights[2][3] = {{1.0f - x - y, x, y}, {x + y - 1.0f, 1.0f - y, 1.0f - x}};
    const uint8_t *corner = face->corner[is_beyond];
    bool is_disk = face->least < 0.0f;
    hit->u = is_disk ? 0.0f : weights[is_beyond][corner[0]];
    hit->v = is_disk ? 0.0f : weights[is_beyond][corner[1]];
    hit->ng = face->ng;
    hit->shape = face->shape;
    hit->primitive = is_disk ? 0 : face->triangle[is_beyond];
    hit->instance = face->instance;
}
