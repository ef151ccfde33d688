/* SPDX-License-Identifier: Apache-2.0 */
#include "render/light.h"

/* Whether the elements of a light can stand in a table. */
static bool is_plain(const struct view *v, const struct light *l)
{
    uint32_t radiance = v->state.emitters[l->emitter].radiance;
    bool is_scaled_alike = v->instances[l->instance].scale > 0.0f;
    if (l->kind != EMITTER_AREA || v->state.textures[radiance].kind != TEXTURE_CONSTANT)
        return false;
    switch (l->shape->kind) {
    case SHAPE_MESH:
        return l->shape->flat_side != 0.0f && is_scaled_alike;
    case SHAPE_DISK:
        return true;
    case SHAPE_SPHERE:
        return is_scaled_alike && l->shape->radius > 0.0f && !l->shape->is_flipped;
    default:
        return false;
    }
}

/* How many elements it has. */
static uint32_t count(const struct light *l)
{
    return l->shape->kind == SHAPE_MESH ? l->shape->area.n : 1;
}

#define STORE3(to, i, v) ((to).x[i] = (v).x, (to).y[i] = (v).y, (to).z[i] = (v).z)

static int32_t add_element(struct light_table *t, const struct view *v, uint32_t light)
{
    const struct emitter *e = &v->state.emitters[v->lights[light].emitter];
    struct vec3 radiance = vec3_scale(v->textures.textures[e->radiance].value, e->scale);
    int32_t i = t->n++;
    STORE3(t->radiance, i, radiance);
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
    int32_t i = add_element(t, v, light);
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
    int32_t i = add_element(t, v, light);
    STORE3(t->p, i, center);
    STORE3(t->e0, i, none);
    STORE3(t->e1, i, none);
    STORE3(t->normal, i, none);
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
    struct vec3 p = vec3_load(shape->positions + 3 * (size_t)at[0]);
    struct vec3 e0 = vec3_sub(vec3_load(shape->positions + 3 * (size_t)at[1]), p);
    struct vec3 e1 = vec3_sub(vec3_load(shape->positions + 3 * (size_t)at[2]), p);
    if (!instance->is_identity) {
        p = transform_point(instance->to_world, p);
        e0 = transform_vector(instance->to_world, e0);
        e1 = transform_vector(instance->to_world, e1);
    }
    bool is_turned = shape->is_flipped != (instance->determinant < 0.0f);
    float side = is_turned ? -shape->flat_side : shape->flat_side;
    struct vec3 n = vec3_scale(vec3_normalize(vec3_cross(e0, e1)), side);
    int32_t i = add_element(t, v, light);
    STORE3(t->p, i, p);
    STORE3(t->e0, i, e0);
    STORE3(t->e1, i, e1);
    STORE3(t->normal, i, n);
    t->cdf[i] = shape->area.cdf[index];
    t->scale[i] = 1.0f / distribution_probability(&shape->area, index);
    t->pdf[i] = 1.0f / (shape->total_area * instance->scale * instance->scale);
}

void light_table_init(struct light_table *t, const struct view *v)
{
    uint32_t n = 0;
    t->n = 0;
    t->has_spheres = false;
    if (v->n_lights > 1 && v->guide.n == 0) return;
    for (uint32_t i = 0; i < v->n_lights; i++) {
        if (!is_plain(v, &v->lights[i])) return;
        n += count(&v->lights[i]);
        if (n > LIGHT_TABLE_SIZE) return;
    }
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
