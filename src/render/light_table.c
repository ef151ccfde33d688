/* SPDX-License-Identifier: Apache-2.0 */
#include "render/light_table.h"

#include <string.h>

#include "base/mem.h"

/* Whether the elements of a light can stand in a table. */
static bool is_plain(const struct view *v, const struct light *l)
{
    uint32_t radiance = v->state.emitters[l->emitter].radiance;
    bool is_scaled_alike = v->instances[l->instance].scale > 0.0f;
    if (l->kind != EMITTER_AREA || v->state.textures[radiance].kind != TEXTURE_CONSTANT)
        return false;
    switch (l->shape->kind) {
    case SHAPE_MESH:
        return is_scaled_alike;
    case SHAPE_DISK:
        return true;
    case SHAPE_SPHERE:
        return is_scaled_alike && l->shape->radius > 0.0f && !l->shape->is_flipped;
    default:
        return false;
    }
}

/* How many elements a shape has. */
static uint32_t count(const struct world_shape *shape)
{
    return shape->kind == SHAPE_MESH ? shape->area.n : 1;
}

bool light_table_alloc(struct light_table *t, const struct view *v)
{
    const struct scene *s = v->world->scene;
    uint64_t n = 0;
    for (uint32_t i = 0; i < s->n_instances; i++) {
        const struct group *g = &s->groups[s->defaults.instances[i].group];
        for (uint32_t j = 0; j < g->n_shapes; j++) {
            const struct world_shape *shape = &v->world->shapes[g->first_shape + j];
            if (shape->emitter != SCENE_NONE) n += count(shape);
        }
    }
    if (n == 0 || n > LIGHT_TABLE_MAX) return true;
    t->memory = mem_new(n * (LIGHT_FIELDS + 2) + LIGHT_GUIDES, sizeof *t->memory);
    if (!t->memory) return false;
    t->rows = t->memory;
    t->cdf = t->rows + LIGHT_FIELDS * n;
    t->parts = (int32_t *)(t->cdf + n);
    t->capacity = (uint32_t)n;
    return true;
}

void light_table_release(struct light_table *t)
{
    mem_free(t->memory);
}

/* ---- Elements -------------------------------------------------------------------------------- */

static void add(struct light_table *t, const struct light_element *e, enum light_kinds kind)
{
    memcpy(t->rows + LIGHT_FIELDS * (size_t)t->n, e, sizeof *e);
    t->cdf[t->n++] = e->cdf;
    t->kinds |= kind;
}

static void add_disk(struct light_table *t, const struct view *v, const struct light *l)
{
    const struct transform *to_group = l->shape->to_group,
                           *to_world = v->instances[l->instance].to_world;
    struct vec3 p = transform_point(to_group, vec3_splat(0.0f));
    struct vec3 e0 = transform_vector(to_group, vec3(1.0f, 0.0f, 0.0f));
    struct vec3 e1 = transform_vector(to_group, vec3(0.0f, 1.0f, 0.0f));
    struct light_point any;
    light_point_sample(v, l, 0.5f, 0.5f, &any);
    const struct light_element e = {.p = transform_point(to_world, p),
                                    .e0 = transform_vector(to_world, e0),
                                    .e1 = transform_vector(to_world, e1),
                                    .n = any.n,
                                    .per_area = any.pdf,
                                    .scale = 1.0f,
                                    .is_disk = 1.0f};
    add(t, &e, LIGHT_DISKS);
}

static void add_sphere(struct light_table *t, const struct view *v, const struct light *l)
{
    const struct view_instance *instance = &v->instances[l->instance];
    const float radius = l->shape->radius * instance->scale;
    const struct light_element e = {.p = transform_point(instance->to_world, l->shape->center),
                                    .radius = radius,
                                    .n = {0.0f, 0.0f, 1.0f},
                                    .per_area = WARP_SPHERE_PDF / (radius * radius),
                                    .scale = 1.0f};
    add(t, &e, LIGHT_SPHERES);
}

/* A triangle of a light's mesh, in the group's space. */
struct triangle {
    struct vec3 corner[3], n[3];
};

static void fetch(struct triangle *t, const struct world_shape *shape, uint32_t index)
{
    const uint32_t *at = shape->indices + 3 * (size_t)index;
    for (int k = 0; k < 3; k++) t->corner[k] = vec3_load(shape->positions + 3 * (size_t)at[k]);
    struct vec3 n = vec3_normalize(
        vec3_cross(vec3_sub(t->corner[1], t->corner[0]), vec3_sub(t->corner[2], t->corner[0])));
    for (int k = 0; k < 3; k++)
        t->n[k] = shape->normals ? vec3_load(shape->normals + 3 * (size_t)at[k]) : n;
}

static bool is_same(struct vec3 a, struct vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool is_close(struct vec3 a, struct vec3 b, float distance2)
{
    struct vec3 d = vec3_sub(a, b);
    return vec3_dot(d, d) <= distance2;
}

static bool is_flat(const struct triangle *t)
{
    return is_same(t->n[0], t->n[1]) && is_same(t->n[0], t->n[2]);
}

/* Turns the corners of a round so that it is a half of a parallelogram of which b is the other: the
 * corner across their common edge becomes the first. False when they are no such halves. */
static bool is_half(struct triangle *a, const struct triangle *b)
{
    if (!is_flat(a) || !is_flat(b) || !is_close(a->n[0], b->n[0], 1e-12f)) return false;
    for (int k = 0; k < 3; k++) {
        const struct vec3 *c = a->corner, p[3] = {c[k], c[(k + 1) % 3], c[(k + 2) % 3]};
        const struct vec3 across = vec3_sub(vec3_add(p[1], p[2]), p[0]),
                          side = vec3_sub(p[1], p[2]);
        for (int l = 0; l < 3; l++) {
            if (!is_same(b->corner[(l + 1) % 3], p[2]) || !is_same(b->corner[(l + 2) % 3], p[1]) ||
                !is_close(b->corner[l], across, 1e-12f * vec3_dot(side, side)))
                continue;
            memcpy(a->corner, p, sizeof p);
            return true;
        }
    }
    return false;
}

/* Element of a share of the mesh that begins at `cdf`. */
static void add_face(struct light_table *t, const struct view *v, const struct light *l,
                     const struct triangle *of, bool is_whole, float cdf, float share)
{
    const struct view_instance *instance = &v->instances[l->instance];
    const float side = l->shape->is_flipped ? -1.0f : 1.0f;
    const struct transform *m = instance->to_world;
    struct vec3 n[3];
    for (int k = 0; k < 3; k++) n[k] = vec3_scale(transform_normal(m, of->n[k]), side);
    struct light_element e = {
        .p = transform_point(m, of->corner[0]),
        .e0 = transform_vector(m, vec3_sub(of->corner[1], of->corner[0])),
        .e1 = transform_vector(m, vec3_sub(of->corner[2], of->corner[0])),
        .per_area = 1.0f / (l->shape->total_area * instance->scale * instance->scale),
        .cdf = cdf,
        .scale = 1.0f / share,
        .is_whole = is_whole};
    if (is_flat(of)) {
        e.n = vec3_normalize(n[0]);
    } else {
        e.n = n[0];
        e.turn0 = vec3_sub(n[1], n[0]);
        e.turn1 = vec3_sub(n[2], n[0]);
    }
    add(t, &e, is_flat(of) ? LIGHT_FACES : LIGHT_SMOOTH);
}

static void add_mesh(struct light_table *t, const struct view *v, const struct light *l)
{
    const struct distribution *d = &l->shape->area;
    for (uint32_t i = 0; i < d->n; i++) {
        struct triangle one, next;
        if (!(distribution_probability(d, i) > 0.0f)) continue;
        fetch(&one, l->shape, i);
        bool is_whole = false;
        if (i + 1 < d->n && distribution_probability(d, i + 1) > 0.0f) {
            fetch(&next, l->shape, i + 1);
            is_whole = is_half(&one, &next);
        }
        const float cdf = d->cdf[i];
        if (is_whole) i++;
        add_face(t, v, l, &one, is_whole, cdf, d->cdf[i + 1] - cdf);
    }
}

/* ---- Choosing among them --------------------------------------------------------------------- */

/* The part of n that u lies in, as light_table_part() finds it, and n beyond. */
static int32_t part_of(float u, int32_t n)
{
    int32_t part = (int32_t)(u * (float)n);
    return part < n ? part : n;
}

/* Of a light's elements, from `first` on. Where an element ends, a later part begins. */
static void divide(struct light_table *t, uint32_t light, int32_t first)
{
    const int32_t n = t->n - first;
    int32_t *parts = t->parts + first + light, element = first;
    for (int32_t part = 0; part <= n; part++) {
        while (element + 1 < t->n && part_of(t->cdf[element + 1], n) < part) element++;
        parts[part] = element;
        if (part == 0) continue;
        int32_t width = element + 1 - parts[part - 1];
        t->n_widest = width > t->n_widest ? width : t->n_widest;
    }
    t->first[light] = first;
    t->count[light] = n;
    t->first_part[light] = first + (int32_t)light;
    t->holds |= 1u << light;
}

static void fill(struct light_table *t, const struct view *v)
{
    uint32_t any = 0;
    t->n = t->n_widest = 0;
    t->kinds = 0;
    t->holds = 0;
    for (uint32_t i = 0; i < v->n_lights; i++) {
        const struct light *l = &v->lights[i];
        const int32_t first = t->n;
        if (!is_plain(v, l)) continue;
        if (l->shape->kind == SHAPE_DISK) add_disk(t, v, l);
        if (l->shape->kind == SHAPE_SPHERE) add_sphere(t, v, l);
        if (l->shape->kind == SHAPE_MESH) add_mesh(t, v, l);
        if (t->n == first) continue;
        divide(t, i, first);
        any = i;
    }
    for (uint32_t i = 0; i < v->n_lights; i++) {
        if (t->holds >> i & 1) continue;
        t->first[i] = t->first[any];
        t->count[i] = t->count[any];
        t->first_part[i] = t->first_part[any];
    }
    bool is_mixed = (t->kinds & (LIGHT_DISKS | LIGHT_SPHERES)) != 0;
    if (is_mixed && t->kinds != LIGHT_DISKS && t->kinds != LIGHT_SPHERES) t->kinds = LIGHT_ALL;
    for (int32_t k = 0; k < t->n && t->n <= LIGHT_TABLE_FEW; k++)
        for (int f = 0; f < LIGHT_FIELDS; f++) t->columns[f][k] = t->rows[LIGHT_FIELDS * k + f];
}

void light_table_init(struct light_table *t, const struct view *v, bool has_moved)
{
    bool is_usable = t->capacity > 0 && v->n_lights > 0 && light_is_guided(v);
    if (!is_usable)
        t->n = 0;
    else if (has_moved || t->n == 0)
        fill(t, v);
    for (uint32_t i = 0; t->n > 0 && i < v->n_lights; i++) {
        if (!light_table_has(t, i)) continue;
        const struct emitter *e = &v->state.emitters[v->lights[i].emitter];
        struct vec3 radiance = vec3_scale(v->textures.textures[e->radiance].value, e->scale);
        t->radiance[0][i] = radiance.x;
        t->radiance[1][i] = radiance.y;
        t->radiance[2][i] = radiance.z;
    }
}

/* The element of a light that u chooses: cdf[k] <= u < cdf[k + 1]. */
static int32_t search(const struct light_table *t, uint32_t light, float u)
{
    const int32_t part = t->first_part[light] + light_table_part(u, t->count[light]);
    int32_t low = t->parts[part], high = t->parts[part + 1] + 1;
    while (high - low > 1) {
        int32_t middle = (low + high) / 2;
        bool is_above = t->cdf[middle] <= u;
        low = is_above ? middle : low;
        high = is_above ? high : middle;
    }
    return low;
}

bool light_table_sample(struct light_sample *s, const struct light_table *t, uint32_t light,
                        struct vec3 reference, float u1, float u2, float choice)
{
    struct light_element e;
    memcpy(&e, t->rows + LIGHT_FIELDS * (size_t)search(t, light, u1), sizeof e);
    const struct vec3 radiance = {t->radiance[0][light], t->radiance[1][light],
                                  t->radiance[2][light]};
    const struct sphere_sample a = light_sphere_sample(e.p, e.radius, reference, u1, u2);
    return light_element_sample(s, t->kinds, e, radiance, reference, u1, u2, choice, a);
}
