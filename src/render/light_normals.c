/* SPDX-License-Identifier: Apache-2.0 */
/* Surfaces that shine along their normals only (`directionalarea`): a point is lit from the places
 * whose normals run through it. Those are found exactly; no other strategy can meet them. Mitsuba
 * leaves that to particle tracers and shows nothing in its `path`. */
#include "render/light.h"

/* A place that shines at the reference point, and what of its power per area arrives there. */
struct foot {
    struct vec3 p, d; /* d: to it */
    float u, v, share;
};

/* Corner k of a triangle in world space. */
static struct vec3 corner(const struct world_shape *shape, const struct view_instance *i,
                          uint32_t index)
{
    struct vec3 p = vec3_load(shape->positions + 3 * (size_t)index);
    return i->is_identity ? p : transform_point(i->to_world, p);
}

/* One of the triangles that the reference point is straight before. */
static bool find_on_mesh(const struct world_shape *shape, const struct view_instance *instance,
                         struct vec3 reference, float choice, struct foot *f)
{
    uint32_t n_found = 0;
    bool is_turned = shape->is_flipped != (!instance->is_identity && instance->determinant < 0.0f);
    float side = is_turned != (shape->flat_side < 0.0f) ? -1.0f : 1.0f;
    for (uint32_t i = 0; i < shape->area.n; i++) {
        const uint32_t *at = shape->indices + 3 * (size_t)i;
        struct vec3 p = corner(shape, instance, at[0]);
        struct vec3 a = vec3_sub(corner(shape, instance, at[1]), p);
        struct vec3 b = vec3_sub(corner(shape, instance, at[2]), p);
        struct vec3 n = vec3_cross(a, b), r = vec3_sub(reference, p);
        float area2 = vec3_dot(n, n), height = side * vec3_dot(r, n);
        float u = vec3_dot(vec3_cross(r, b), n), v = vec3_dot(vec3_cross(a, r), n);
        if (!(height > 0.0f && u >= 0.0f && v >= 0.0f && u + v <= area2)) continue;
        /* Every one found so far with the same chance. */
        n_found++;
        choice *= (float)n_found;
        if (choice >= 1.0f) {
            choice = (choice - 1.0f) / (float)(n_found - 1);
            continue;
        }
        u /= area2;
        v /= area2;
        f->d = vec3_scale(n, -side / sqrtf(area2));
        f->p = vec3_madd(vec3_madd(p, a, u), b, v);
        f->u = u;
        f->v = v;
        if (!shape->uvs) continue;
        const float *ta = shape->uvs + 2 * (size_t)at[0], *tb = shape->uvs + 2 * (size_t)at[1],
                    *tc = shape->uvs + 2 * (size_t)at[2];
        float w = 1.0f - u - v;
        f->u = ta[0] * w + tb[0] * u + tc[0] * v;
        f->v = ta[1] * w + tb[1] * u + tc[1] * v;
    }
    f->share = (float)n_found;
    return n_found > 0;
}

static float turn_of(struct vec3 d)
{
    float t = atan2f(d.y, d.x) * (0.5f * MATH_INV_PI);
    return t < 0.0f ? t + 1.0f : t;
}

static bool find_on_disk(const struct world_shape *shape, const struct transform *to_world,
                         struct vec3 reference, struct foot *f)
{
    struct vec3 n = vec3_normalize(transform_normal(to_world, vec3(0.0f, 0.0f, 1.0f)));
    if (shape->is_flipped) n = vec3_neg(n);
    struct vec3 center = transform_point(to_world, vec3_splat(0.0f));
    float height = vec3_dot(vec3_sub(reference, center), n);
    f->p = vec3_madd(reference, n, -height);
    f->d = vec3_neg(n);
    struct vec3 local = transform_point_inverse(to_world, f->p);
    float r2 = local.x * local.x + local.y * local.y;
    f->u = sqrtf(r2);
    f->v = turn_of(local);
    return height > 0.0f && r2 <= 1.0f;
}

/* Spheres and cylinders: light spreads, or gathers, as the distance to the centre or axis grows;
 * from inside there are two places, on both sides. */
static bool find_on_round(const struct world_shape *shape, const struct transform *to_world,
                          struct vec3 reference, float choice, struct foot *f)
{
    bool is_sphere = shape->kind == SHAPE_SPHERE;
    struct vec3 q = transform_point_inverse(to_world, reference), out = q;
    if (!is_sphere) out.z = 0.0f;
    float r = vec3_length(out);
    if (!(r > 0.0f) || (r > 1.0f) == shape->is_flipped ||
        (!is_sphere && !(q.z >= 0.0f && q.z <= 1.0f)))
        return false;
    f->share = is_sphere ? 1.0f / (r * r) : 1.0f / r;
    struct vec3 p = vec3_scale(out, (shape->is_flipped && choice < 0.5f ? -1.0f : 1.0f) / r);
    if (shape->is_flipped) f->share *= 2.0f;
    f->u = turn_of(p);
    f->v = is_sphere ? acosf(min_float(max_float(p.z, -1.0f), 1.0f)) * MATH_INV_PI : q.z;
    if (!is_sphere) p.z = q.z;
    f->p = transform_point(to_world, p);
    struct vec3 d = vec3_sub(f->p, reference);
    float distance = vec3_length(d);
    f->d = vec3_scale(d, 1.0f / distance);
    return distance > 0.0f;
}

bool light_sample_normals(const struct view *v, const struct light *l, struct vec3 reference,
                          float choice, struct light_sample *s)
{
    const struct view_instance *instance = &v->instances[l->instance];
    const struct emitter *e = &v->state.emitters[l->emitter];
    const struct world_shape *shape = l->shape;
    struct foot f = {.share = 1.0f};
    if (shape->kind == SHAPE_MESH) {
        if (!find_on_mesh(shape, instance, reference, choice, &f)) return false;
    } else {
        struct transform to_world = transform_mul(instance->to_world, shape->to_group);
        if (shape->kind == SHAPE_DISK) {
            if (!find_on_disk(shape, &to_world, reference, &f)) return false;
        } else if (!(instance->scale > 0.0f) ||
                   !find_on_round(shape, &to_world, reference, choice, &f)) {
            return false;
        }
    }
    s->p = f.p;
    s->d = f.d;
    s->pdf = 1.0f;
    s->is_delta = true;
    s->weight = vec3_scale(texture_eval(&v->textures, e->radiance, f.u, f.v), e->scale * f.share);
    return true;
}
