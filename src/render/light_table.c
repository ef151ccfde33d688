/* SPDX-License-Identifier: Apache-2.0 */
#include "render/light.h"

/* Whether the triangles of a light can stand in a table. */
static bool is_plain(const struct view *v, const struct light *l)
{
    if (l->kind != EMITTER_AREA || l->shape->flat_side == 0.0f) return false;
    uint32_t radiance = v->state.emitters[l->emitter].radiance;
    return v->instances[l->instance].scale > 0.0f &&
           v->state.textures[radiance].kind == TEXTURE_CONSTANT;
}

#define STORE3(to, i, v) ((to).x[i] = (v).x, (to).y[i] = (v).y, (to).z[i] = (v).z)

/* Triangle `index` of a light's mesh. */
static void add_triangle(struct light_table *t, const struct view *v, uint32_t light,
                         uint32_t index)
{
    const struct light *l = &v->lights[light];
    const struct view_instance *instance = &v->instances[l->instance];
    const struct world_shape *shape = l->shape;
    const struct emitter *e = &v->state.emitters[l->emitter];
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
    struct vec3 radiance = vec3_scale(v->textures.textures[e->radiance].value, e->scale);
    int32_t i = t->n++;
    STORE3(t->p, i, p);
    STORE3(t->e0, i, e0);
    STORE3(t->e1, i, e1);
    STORE3(t->normal, i, n);
    STORE3(t->radiance, i, radiance);
    t->light[i] = (int32_t)light;
    t->cdf[i] = shape->area.cdf[index];
    t->scale[i] = 1.0f / distribution_probability(&shape->area, index);
    t->pdf[i] = 1.0f / (shape->total_area * instance->scale * instance->scale);
}

void light_table_init(struct light_table *t, const struct view *v)
{
    uint32_t n = 0;
    t->n = 0;
    if (v->n_lights > 1 && v->guide.n == 0) return;
    for (uint32_t i = 0; i < v->n_lights; i++) {
        if (!is_plain(v, &v->lights[i])) return;
        n += v->lights[i].shape->area.n;
        if (n > LIGHT_TABLE_SIZE) return;
    }
    for (uint32_t i = 0; i < v->n_lights; i++) {
        const struct distribution *d = &v->lights[i].shape->area;
        t->first[i] = t->n;
        for (uint32_t k = 0; k < d->n; k++)
            if (distribution_probability(d, k) > 0.0f) add_triangle(t, v, i, k);
    }
    t->first[v->n_lights] = t->n;
}
