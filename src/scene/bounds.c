/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/bounds.h"

struct bounds bounds_empty(void)
{
    return (struct bounds){vec3_splat(INFINITY), vec3_splat(-INFINITY)};
}

bool bounds_is_empty(const struct bounds *b)
{
    return !(b->min.x <= b->max.x && b->min.y <= b->max.y && b->min.z <= b->max.z);
}

void bounds_add(struct bounds *b, struct vec3 p)
{
    b->min = vec3(fminf(b->min.x, p.x), fminf(b->min.y, p.y), fminf(b->min.z, p.z));
    b->max = vec3(fmaxf(b->max.x, p.x), fmaxf(b->max.y, p.y), fmaxf(b->max.z, p.z));
}

/* Half the extent of the unit sphere (or of its z = 0 circle) along each axis after a linear map.
 */
static struct vec3 round_extent(const struct transform *t, bool is_circle)
{
    float e[3];
    for (int i = 0; i < 3; i++) {
        float z = is_circle ? 0.0f : t->m[i][2];
        e[i] = sqrtf(t->m[i][0] * t->m[i][0] + t->m[i][1] * t->m[i][1] + z * z);
    }
    return vec3(e[0], e[1], e[2]);
}

struct bounds bounds_transform(const struct bounds *b, const struct transform *t)
{
    struct bounds out = bounds_empty();
    for (int corner = 0; corner < 8; corner++) {
        struct vec3 p = vec3(corner & 1 ? b->max.x : b->min.x, corner & 2 ? b->max.y : b->min.y,
                             corner & 4 ? b->max.z : b->min.z);
        bounds_add(&out, transform_point(t, p));
    }
    return out;
}

static void add_bounds(struct bounds *b, const struct bounds *other)
{
    if (bounds_is_empty(other)) return;
    bounds_add(b, other->min);
    bounds_add(b, other->max);
}

struct bounds shape_bounds(const struct scene *s, const struct shape *shape)
{
    struct bounds b = bounds_empty();
    if (shape->kind == SHAPE_MESH) {
        const struct mesh *m = &s->meshes[shape->mesh];
        for (size_t v = 0; v < m->n_vertices; v++) {
            const float *p = m->positions + 3 * v;
            bounds_add(&b, vec3(p[0], p[1], p[2]));
        }
    } else {
        struct vec3 c = transform_point(&shape->to_group, vec3_splat(0.0f));
        struct vec3 e = round_extent(&shape->to_group, shape->kind == SHAPE_DISK);
        bounds_add(&b, vec3_sub(c, e));
        bounds_add(&b, vec3_add(c, e));
    }
    return b;
}

struct bounds group_bounds(const struct scene *s, const struct group *g)
{
    struct bounds all = bounds_empty();
    for (uint32_t i = g->first_shape; i < g->first_shape + g->n_shapes; i++) {
        struct bounds b = shape_bounds(s, &s->shapes[i]);
        add_bounds(&all, &b);
    }
    return all;
}

struct bounds scene_bounds(const struct scene *s, const struct scene_state *state)
{
    struct bounds all = bounds_empty();
    for (uint32_t i = 0; i < s->n_instances; i++) {
        const struct instance *in = &state->instances[i];
        const struct bounds *g = &s->groups[in->group].bounds;
        if (!in->is_visible || bounds_is_empty(g)) continue;
        struct bounds b = bounds_transform(g, &in->to_world);
        add_bounds(&all, &b);
    }
    if (bounds_is_empty(&all)) all = (struct bounds){vec3_splat(0.0f), vec3_splat(0.0f)};
    return all;
}
