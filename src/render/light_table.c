/* SPDX-License-Identifier: Apache-2.0 */
#include "render/light.h"

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
    enum { ARRAYS = 3 * 6 + 4 };
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
    t->memory = mem_new(n, ARRAYS * sizeof(float) + 2 * sizeof(int32_t));
    if (!t->memory) return false;
    float *at = t->memory,
          **const arrays[ARRAYS] = {
              &t->p.x,     &t->p.y,     &t->p.z,     &t->e0.x,     &t->e0.y,     &t->e0.z,
              &t->e1.x,    &t->e1.y,    &t->e1.z,    &t->normal.x, &t->normal.y, &t->normal.z,
              &t->turn0.x, &t->turn0.y, &t->turn0.z, &t->turn1.x,  &t->turn1.y,  &t->turn1.z,
              &t->radius,  &t->cdf,     &t->scale,   &t->pdf};
    for (int k = 0; k < ARRAYS; k++, at += n) *arrays[k] = at;
    t->light = (int32_t *)at;
    t->is_disk = t->light + n;
    t->capacity = (uint32_t)n;
    return true;
}

void light_table_release(struct light_table *t)
{
    mem_free(t->memory);
}

#define STORE3(to, i, v)              \
    do {                              \
        const struct vec3 stored = v; \
        (to).x[i] = stored.x;         \
        (to).y[i] = stored.y;         \
        (to).z[i] = stored.z;         \
    } while (0)

static int32_t add_element(struct light_table *t, uint32_t light)
{
    const struct vec3 none = vec3_splat(0.0f);
    int32_t i = t->n++;
    STORE3(t->turn0, i, none);
    STORE3(t->turn1, i, none);
    t->light[i] = (int32_t)light;
    t->cdf[i] = t->radius[i] = 0.0f;
    t->scale[i] = 1.0f;
    t->is_disk[i] = false;
    return i;
}

static void add_disk(struct light_table *t, const struct view *v, uint32_t light)
{
    const struct light *l = &v->lights[light];
    const struct transform *to_group = l->shape->to_group,
                           *to_world = v->instances[l->instance].to_world;
    struct vec3 p = transform_point(to_world, transform_point(to_group, vec3_splat(0.0f)));
    struct vec3 e0 = transform_vector(to_group, vec3(1.0f, 0.0f, 0.0f));
    struct vec3 e1 = transform_vector(to_group, vec3(0.0f, 1.0f, 0.0f));
    struct light_point any;
    light_point_sample(v, l, 0.5f, 0.5f, &any);
    int32_t i = add_element(t, light);
    e0 = transform_vector(to_world, e0);
    e1 = transform_vector(to_world, e1);
    STORE3(t->p, i, p);
    STORE3(t->e0, i, e0);
    STORE3(t->e1, i, e1);
    STORE3(t->normal, i, any.n);
    t->pdf[i] = any.pdf;
    t->is_disk[i] = true;
}

static void add_sphere(struct light_table *t, const struct view *v, uint32_t light)
{
    const struct light *l = &v->lights[light];
    const struct view_instance *instance = &v->instances[l->instance];
    struct vec3 center = transform_point(instance->to_world, l->shape->center);
    const struct vec3 none = vec3_splat(0.0f);
    int32_t i = add_element(t, light);
    STORE3(t->p, i, center);
    STORE3(t->e0, i, none);
    STORE3(t->e1, i, none);
    STORE3(t->normal, i, vec3(0.0f, 0.0f, 1.0f));
    t->radius[i] = l->shape->radius * instance->scale;
    t->pdf[i] = WARP_SPHERE_PDF / (t->radius[i] * t->radius[i]);
    t->has_spheres = true;
}

/* Triangle `index` of a light's mesh. */
static void add_triangle(struct light_table *t, const struct view *v, uint32_t light,
                         uint32_t index)
{
    const struct light *l = &v->lights[light];
    const struct view_instance *instance = &v->instances[l->instance];
    const struct world_shape *shape = l->shape;
    const uint32_t *at = shape->indices + 3 * (size_t)index;
    const float side = shape->is_flipped ? -1.0f : 1.0f;
    struct vec3 corner[3], n[3];
    for (int k = 0; k < 3; k++) corner[k] = vec3_load(shape->positions + 3 * (size_t)at[k]);
    struct vec3 e0 = vec3_sub(corner[1], corner[0]), e1 = vec3_sub(corner[2], corner[0]);
    for (int k = 0; k < 3; k++) {
        n[k] = shape->normals ? vec3_load(shape->normals + 3 * (size_t)at[k])
                              : vec3_normalize(vec3_cross(e0, e1));
        n[k] = vec3_scale(transform_normal(instance->to_world, n[k]), side);
    }
    corner[0] = transform_point(instance->to_world, corner[0]);
    e0 = transform_vector(instance->to_world, e0);
    e1 = transform_vector(instance->to_world, e1);
    int32_t i = add_element(t, light);
    STORE3(t->p, i, corner[0]);
    STORE3(t->e0, i, e0);
    STORE3(t->e1, i, e1);
    STORE3(t->normal, i, n[0]);
    STORE3(t->turn0, i, vec3_sub(n[1], n[0]));
    STORE3(t->turn1, i, vec3_sub(n[2], n[0]));
    t->cdf[i] = shape->area.cdf[index];
    t->scale[i] = 1.0f / distribution_probability(&shape->area, index);
    t->pdf[i] = 1.0f / (shape->total_area * instance->scale * instance->scale);
}

static void fill(struct light_table *t, const struct view *v)
{
    t->n = 0;
    t->has_spheres = false;
    for (uint32_t i = 0; i < v->n_lights; i++) {
        const struct light *l = &v->lights[i];
        const struct distribution *d = &l->shape->area;
        t->first[i] = t->n;
        if (l->shape->kind == SHAPE_DISK) add_disk(t, v, i);
        if (l->shape->kind == SHAPE_SPHERE) add_sphere(t, v, i);
        if (l->shape->kind != SHAPE_MESH) continue;
        for (uint32_t k = 0; k < d->n; k++)
            if (distribution_probability(d, k) > 0.0f) add_triangle(t, v, i, k);
    }
    t->first[v->n_lights] = t->n;
}

void light_table_init(struct light_table *t, const struct view *v, bool has_moved)
{
    bool is_usable = t->capacity > 0 && (v->n_lights <= 1 || v->guide.n > 0);
    for (uint32_t i = 0; is_usable && i < v->n_lights; i++) is_usable = is_plain(v, &v->lights[i]);
    if (!is_usable)
        t->n = 0;
    else if (has_moved || t->n == 0)
        fill(t, v);
    for (uint32_t i = 0; t->n > 0 && i < v->n_lights; i++) {
        const struct emitter *e = &v->state.emitters[v->lights[i].emitter];
        t->radiance[i] = vec3_scale(v->textures.textures[e->radiance].value, e->scale);
    }
}
