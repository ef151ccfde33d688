/* SPDX-License-Identifier: Apache-2.0 */
#include "render/surface.h"

struct frame surface_frame_along(struct vec3 n, struct vec3 dp_du)
{
    struct vec3 s = vec3_madd(dp_du, n, -vec3_dot(n, dp_du));
    float length = vec3_length(s);
    if (!(length > 0.0f) || !isfinite(length)) return frame_from_normal(n);
    s = vec3_scale(s, 1.0f / length);
    return (struct frame){s, vec3_cross(n, s), n};
}

/* How the position changes with u and v. */
struct tangents {
    struct vec3 u, v;
};

/* Of a triangle; without texture coordinates u and v are barycentric. Zero where they do not span
 * anything. */
static struct tangents mesh_tangents(const struct world_shape *shape, const uint32_t *at)
{
    struct tangents none = {{0, 0, 0}, {0, 0, 0}};
    struct vec3 p = vec3_load(shape->positions + 3 * (size_t)at[0]);
    struct vec3 e0 = vec3_sub(vec3_load(shape->positions + 3 * (size_t)at[1]), p);
    struct vec3 e1 = vec3_sub(vec3_load(shape->positions + 3 * (size_t)at[2]), p);
    if (!shape->uvs) return (struct tangents){e0, e1};
    const float *a = shape->uvs + 2 * (size_t)at[0], *b = shape->uvs + 2 * (size_t)at[1],
                *c = shape->uvs + 2 * (size_t)at[2];
    float du0 = b[0] - a[0], dv0 = b[1] - a[1], du1 = c[0] - a[0], dv1 = c[1] - a[1];
    float det = du0 * dv1 - dv0 * du1;
    if (det == 0.0f) return none;
    return (struct tangents){
        vec3_scale(vec3_sub(vec3_scale(e0, dv1), vec3_scale(e1, dv0)), 1.0f / det),
        vec3_scale(vec3_sub(vec3_scale(e1, du0), vec3_scale(e0, du1)), 1.0f / det)};
}

/* Quadrics: texture coordinates and tangents at a point of the unit shape. */
static struct tangents quadric_uv(struct surface *s, enum shape_kind kind, struct vec3 local)
{
    const float two_pi = 2.0f * MATH_PI;
    float phi = atan2f(local.y, local.x) * (0.5f * MATH_INV_PI);
    if (phi < 0.0f) phi += 1.0f;
    float r = sqrtf(local.x * local.x + local.y * local.y);
    float c = r > 0.0f ? local.x / r : 1.0f, sine = r > 0.0f ? local.y / r : 0.0f;
    if (kind == SHAPE_SPHERE) {
        float length = vec3_length(local);
        s->u = phi;
        s->v = acosf(min_float(max_float(local.z / length, -1.0f), 1.0f)) * MATH_INV_PI;
        return (struct tangents){
            vec3(-local.y * two_pi, local.x * two_pi, 0.0f),
            vec3(local.z * c * MATH_PI, local.z * sine * MATH_PI, -r * MATH_PI)};
    }
    if (kind == SHAPE_CYLINDER) {
        s->u = phi;
        s->v = local.z;
        return (struct tangents){vec3(-local.y * two_pi, local.x * two_pi, 0.0f), vec3(0, 0, 1)};
    }
    s->u = r;
    s->v = phi;
    return (struct tangents){vec3(c, sine, 0.0f), vec3(-local.y * two_pi, local.x * two_pi, 0.0f)};
}

void surface_fetch(struct surface *s, const struct view *v, const struct ray *r,
                   const struct hit *hit)
{
    const struct view_instance *instance = &v->instances[hit->instance];
    const struct world_shape *shape = &instance->shapes[hit->shape];
    const struct material *material = &v->materials[v->state.shape_bsdfs[shape->index]];
    s->shape = shape;
    s->instance = hit->instance;
    s->primitive = hit->primitive;
    s->b1 = hit->u;
    s->b2 = hit->v;
    s->t = hit->t;
    s->p = vec3_madd(r->o, r->d, hit->t);

    struct vec3 n = hit->ng, ns;
    struct tangents tangents = {{0, 0, 0}, {0, 0, 0}};
    bool has_tangents = material->has_direction || material->has_tangents;
    bool has_own_shading = false, needs_uv = material->has_uv || shape->emitter != SCENE_NONE;
    if (shape->kind == SHAPE_MESH) {
        const uint32_t *at = shape->indices + 3 * (size_t)hit->primitive;
        if (shape->normals) {
            ns = surface_interpolate(shape->normals, at, hit->u, hit->v);
            has_own_shading = true;
        }
        if (shape->uvs && needs_uv) {
            struct vec2 uv = surface_uv(shape->uvs, at, hit->u, hit->v);
            s->u = uv.x;
            s->v = uv.y;
        } else {
            s->u = hit->u;
            s->v = hit->v;
        }
        if (has_tangents) tangents = mesh_tangents(shape, at);
    } else {
        struct vec3 p = instance->is_identity ? s->p
                                              : transform_point_inverse(instance->to_world, s->p);
        if (shape->kind == SHAPE_SPHERE) {
            /* Pull the point back onto the sphere. */
            n = vec3_normalize(vec3_sub(p, shape->center));
            p = vec3_madd(shape->center, n, shape->radius);
            s->p = instance->is_identity ? p : transform_point(instance->to_world, p);
        }
        if (shape->kind == SHAPE_CYLINDER) {
            struct vec3 q = transform_point_inverse(shape->to_group, p);
            float scale = 1.0f / sqrtf(q.x * q.x + q.y * q.y);
            q.x *= scale;
            q.y *= scale;
            n = transform_normal(shape->to_group, vec3(q.x, q.y, 0.0f));
            p = transform_point(shape->to_group, q);
            s->p = instance->is_identity ? p : transform_point(instance->to_world, p);
        }
        s->u = s->v = 0.0f;
        if (needs_uv || has_tangents) {
            tangents = quadric_uv(s, shape->kind, transform_point_inverse(shape->to_group, p));
            tangents.u = transform_vector(shape->to_group, tangents.u);
            tangents.v = transform_vector(shape->to_group, tangents.v);
        }
    }
    if (!instance->is_identity) {
        n = transform_normal(instance->to_world, n);
        if (has_own_shading) ns = transform_normal(instance->to_world, ns);
        if (has_tangents) {
            tangents.u = transform_vector(instance->to_world, tangents.u);
            tangents.v = transform_vector(instance->to_world, tangents.v);
        }
    }
    if (!has_own_shading) ns = n;
    s->n = shape->is_flipped ? vec3_neg(n) : n;
    s->frame.n = shape->is_flipped ? vec3_neg(ns) : ns;
    if (material->has_direction) s->frame.s = tangents.u;
    if (!material->has_tangents) return;
    s->dp_du = tangents.u;
    s->dp_dv = tangents.v;
}

void surface_init(struct surface *s, const struct view *v, const struct ray *r,
                  const struct hit *hit)
{
    surface_fetch(s, v, r, hit);
    surface_normals(&s->n, &s->frame.n);
    const struct material *material = &v->materials[v->state.shape_bsdfs[s->shape->index]];
    s->frame = material->has_direction ? surface_frame_along(s->frame.n, s->frame.s)
                                       : frame_from_normal(s->frame.n);
    s->wi = frame_to_local(&s->frame, vec3_neg(r->d));
}

void surface_bsdf(const struct surface *s, const struct view *v, struct bsdf_point *out)
{
    const uint32_t bsdf = v->state.shape_bsdfs[s->shape->index];
    const struct bsdf_place at = surface_place(s, &v->materials[bsdf]);
    bsdf_point_init(out, v->materials, bsdf, &v->textures, &at);
}
