/* SPDX-License-Identifier: Apache-2.0 */
#include "render/light.h"

#include "render/light_table.h"

/* world area / group-space area around a point of a surface with unit world normal n: the cofactor
 * |det M| |M^-T n_group|, which is |det M| / |M^T n|. */
static float area_scale(const struct view_instance *i, struct vec3 n)
{
    if (i->is_identity) return 1.0f;
    if (i->scale > 0.0f) return i->scale * i->scale;
    const float(*m)[4] = i->to_world->m;
    struct vec3 t = vec3(m[0][0] * n.x + m[1][0] * n.y + m[2][0] * n.z,
                         m[0][1] * n.x + m[1][1] * n.y + m[2][1] * n.z,
                         m[0][2] * n.x + m[1][2] * n.y + m[2][2] * n.z);
    return fabsf(i->determinant) / vec3_length(t);
}

static struct vec3 emitted(const struct view *v, uint32_t emitter, float u, float uv_v)
{
    const struct emitter *e = &v->state.emitters[emitter];
    return vec3_scale(texture_eval(&v->textures, e->radiance, u, uv_v), e->scale);
}

/* A point on a light and its density per world area. */
struct area_sample {
    struct vec3 p, n; /* n: the normal that cosines are taken with, unit */
    float u, v, pdf;
};

static void sample_mesh(const struct light *l, const struct view_instance *instance, float u1,
                        float u2, struct area_sample *s)
{
    const struct world_shape *shape = l->shape;
    uint32_t triangle = distribution_sample(&shape->area, &u1);
    struct vec2 b = warp_triangle(u1, u2);
    float w = 1.0f - b.x - b.y;
    const uint32_t *at = shape->indices + 3 * (size_t)triangle;
    struct vec3 p0 = vec3_load(shape->positions + 3 * (size_t)at[0]);
    struct vec3 e0 = vec3_sub(vec3_load(shape->positions + 3 * (size_t)at[1]), p0);
    struct vec3 e1 = vec3_sub(vec3_load(shape->positions + 3 * (size_t)at[2]), p0);
    struct vec3 p = vec3_madd(vec3_madd(p0, e0, b.x), e1, b.y);
    struct vec3 n = vec3_cross(e0, e1), ns = n;
    if (shape->normals)
        ns = vec3_madd(vec3_madd(vec3_scale(vec3_load(shape->normals + 3 * (size_t)at[0]), w),
                                 vec3_load(shape->normals + 3 * (size_t)at[1]), b.x),
                       vec3_load(shape->normals + 3 * (size_t)at[2]), b.y);
    if (!instance->is_identity) {
        p = transform_point(instance->to_world, p);
        n = transform_normal(instance->to_world, n);
        if (shape->normals) ns = transform_normal(instance->to_world, ns);
    }
    n = vec3_normalize(n);
    if (shape->normals) {
        float length = vec3_length(ns);
        ns = length > 1e-10f ? vec3_scale(ns, 1.0f / length) : n;
    } else {
        ns = n;
    }
    s->p = p;
    s->n = shape->is_flipped ? vec3_neg(ns) : ns;
    s->pdf = 1.0f / (shape->total_area * area_scale(instance, n));
    s->u = b.x;
    s->v = b.y;
    if (shape->uvs) {
        const float *a = shape->uvs + 2 * (size_t)at[0], *c = shape->uvs + 2 * (size_t)at[1],
                    *d = shape->uvs + 2 * (size_t)at[2];
        s->u = a[0] * w + c[0] * b.x + d[0] * b.y;
        s->v = a[1] * w + c[1] * b.x + d[1] * b.y;
    }
}

/* Disks, uniformly by area. */
static float disk_pdf(const struct world_shape *shape, const struct view_instance *instance)
{
    struct vec3 a = transform_vector(shape->to_group, vec3(1.0f, 0.0f, 0.0f));
    struct vec3 b = transform_vector(shape->to_group, vec3(0.0f, 1.0f, 0.0f));
    a = transform_vector(instance->to_world, a);
    b = transform_vector(instance->to_world, b);
    return MATH_INV_PI / vec3_length(vec3_cross(a, b));
}

static void sample_disk(const struct light *l, const struct view_instance *instance, float u1,
                        float u2, struct area_sample *s)
{
    const struct world_shape *shape = l->shape;
    struct vec2 d = warp_disk(u1, u2);
    struct vec3 n = transform_normal(shape->to_group, vec3(0.0f, 0.0f, 1.0f));
    s->p = transform_point(instance->to_world,
                           transform_point(shape->to_group, vec3(d.x, d.y, 0.0f)));
    n = vec3_normalize(transform_normal(instance->to_world, n));
    s->n = shape->is_flipped ? vec3_neg(n) : n;
    s->pdf = disk_pdf(shape, instance);
    float phi = atan2f(d.y, d.x) * (0.5f * MATH_INV_PI);
    s->u = sqrtf(d.x * d.x + d.y * d.y);
    s->v = phi < 0.0f ? phi + 1.0f : phi;
}

/* Cylinders, uniformly by area where the instance does not change that. */
static void sample_cylinder(const struct light *l, const struct view_instance *instance, float u1,
                            float u2, struct area_sample *s)
{
    const struct world_shape *shape = l->shape;
    struct vec3 n;
    warp_sincos_turn(u1, &n.y, &n.x);
    s->p = transform_point(instance->to_world,
                           transform_point(shape->to_group, vec3(n.x, n.y, u2)));
    n = transform_normal(shape->to_group, vec3(n.x, n.y, 0.0f));
    n = vec3_normalize(transform_normal(instance->to_world, n));
    s->n = shape->is_flipped ? vec3_neg(n) : n;
    s->pdf = 1.0f / (shape->total_area * area_scale(instance, n));
    s->u = u1;
    s->v = u2;
}

/* ---- Spheres --------------------------------------------------------------------------------- */

static struct sphere sphere_in_world(const struct world_shape *shape,
                                     const struct view_instance *instance)
{
    if (instance->is_identity) return (struct sphere){shape->center, shape->radius};
    return (struct sphere){transform_point(instance->to_world, shape->center),
                           shape->radius * instance->scale};
}

static void sphere_uv(const struct world_shape *shape, const struct view_instance *instance,
                      struct area_sample *s)
{
    struct vec3 local = transform_point_inverse(shape->to_group,
                                                transform_point_inverse(instance->to_world, s->p));
    float phi = atan2f(local.y, local.x) * (0.5f * MATH_INV_PI);
    s->u = phi < 0.0f ? phi + 1.0f : phi;
    s->v = acosf(min_float(max_float(local.z / vec3_length(local), -1.0f), 1.0f)) * MATH_INV_PI;
}

/* By area, for points inside and for ellipsoids. */
static void sample_sphere_area(const struct light *l, const struct view_instance *instance,
                               float u1, float u2, struct area_sample *s)
{
    const struct world_shape *shape = l->shape;
    struct vec3 n = warp_sphere(u1, u2);
    struct vec3 p = vec3_madd(shape->center, n, shape->radius);
    s->p = transform_point(instance->to_world, p);
    n = vec3_normalize(transform_normal(instance->to_world, n));
    s->n = shape->is_flipped ? vec3_neg(n) : n;
    s->pdf = WARP_SPHERE_PDF / (shape->radius * shape->radius * area_scale(instance, n));
    sphere_uv(shape, instance, s);
}

/* Directions uniform in the cone that the sphere fills; the point is where they meet it first. */
static bool sample_sphere_cone(const struct light *l, const struct view_instance *instance,
                               struct vec3 reference, float u1, float u2, struct area_sample *s,
                               float *pdf)
{
    struct sphere sphere = sphere_in_world(l->shape, instance);
    struct vec3 to_center = vec3_sub(sphere.center, reference);
    float sin_max2 = sphere_cone(&sphere, to_center);
    if (sin_max2 == 0.0f) return false;
    struct vec3 n = sphere_cone_sample(to_center, sin_max2, u1, u2);
    s->p = vec3_madd(sphere.center, n, sphere.radius);
    s->n = l->shape->is_flipped ? vec3_neg(n) : n;
    s->pdf = 1.0f; /* not used */
    *pdf = sphere_cone_pdf(sin_max2);
    sphere_uv(l->shape, instance, s);
    return true;
}

/* ---- All kinds ------------------------------------------------------------------------------- */

/* By area, whatever the place that is lit. */
static void sample_surface(const struct light *l, const struct view_instance *instance, float u1,
                           float u2, struct area_sample *s)
{
    switch (l->shape->kind) {
    case SHAPE_MESH:
        sample_mesh(l, instance, u1, u2, s);
        break;
    case SHAPE_DISK:
        sample_disk(l, instance, u1, u2, s);
        break;
    case SHAPE_CYLINDER:
        sample_cylinder(l, instance, u1, u2, s);
        break;
    case SHAPE_SPHERE:
        sample_sphere_area(l, instance, u1, u2, s);
        break;
    }
}

void light_point_sample(const struct view *v, const struct light *l, float u1, float u2,
                        struct light_point *s)
{
    struct area_sample a = {0};
    sample_surface(l, &v->instances[l->instance], u1, u2, &a);
    *s = (struct light_point){a.p, a.n, emitted(v, l->emitter, a.u, a.v), a.pdf};
}

static bool sample_area(const struct view *v, const struct light *l, struct vec3 reference,
                        float u1, float u2, float choice, struct light_sample *s)
{
    const struct view_instance *instance = &v->instances[l->instance];
    struct area_sample a = {0};
    float pdf = 0.0f;
    bool is_cone = l->shape->kind == SHAPE_SPHERE &&
                   sample_sphere_cone(l, instance, reference, u1, u2, &a, &pdf);
    if (!is_cone) sample_surface(l, instance, u1, u2, &a);
    s->p = a.p;
    struct vec3 radiance = emitted(v, l->emitter, a.u, a.v);
    return light_sample_finish(s, reference, a.n, a.pdf, is_cone ? pdf : 0.0f, radiance, choice);
}

bool light_sample_chosen(const struct view *v, uint32_t light, struct vec3 reference, float u1,
                         float u2, float choice, struct light_sample *s)
{
    const struct light *l = &v->lights[light];
    s->light = light;
    if (light_table_has(&v->table, light))
        return light_table_sample(s, &v->table, light, reference, u1, u2, choice);
    s->p = vec3_splat(0.0f);
    s->is_delta = s->is_infinite = false;
    if (l->kind == EMITTER_AREA) return sample_area(v, l, reference, u1, u2, choice, s);
    bool is_found;
    if (l->kind == EMITTER_DIRECTIONAL_AREA)
        is_found = light_sample_normals(v, l, reference, u1, s);
    else if (emitter_is_environment(l->kind))
        is_found = light_environment_sample(v, l, u1, u2, s);
    else
        is_found = light_sample_delta(v, l, reference, s);
    if (!is_found || !(s->pdf > 0.0f) || !isfinite(s->pdf)) return false;
    s->pdf *= choice;
    s->weight = vec3_scale(s->weight, 1.0f / s->pdf);
    return true;
}

bool light_sample(const struct view *v, struct vec3 reference, float u1, float u2,
                  struct light_sample *s)
{
    float choice;
    if (v->n_lights == 0) return false;
    uint32_t light = light_choose(v, reference, &u1, &choice);
    return light_sample_chosen(v, light, reference, u1, u2, choice, s);
}

struct vec3 light_surface_radiance(const struct view *v, const struct surface *s, struct vec3 d)
{
    if (s->shape->emitter == SCENE_NONE || !(vec3_dot(s->frame.n, d) < 0.0f))
        return vec3_splat(0.0f);
    if (v->state.emitters[s->shape->emitter].kind != EMITTER_AREA) /* along its normals only */
        return vec3_splat(0.0f);
    return emitted(v, s->shape->emitter, s->u, s->v);
}

float light_surface_pdf(const struct view *v, struct vec3 reference, const struct surface *s,
                        struct vec3 d, float distance)
{
    const struct world_shape *shape = s->shape;
    const struct view_instance *instance = &v->instances[s->instance];
    float cosine = fabsf(vec3_dot(d, s->frame.n)), per_area = 0.0f;
    float choice = light_probability(v, reference, instance->first_light + shape->light);
    switch (shape->kind) {
    case SHAPE_MESH:
    case SHAPE_CYLINDER:
        per_area = 1.0f / (shape->total_area * area_scale(instance, s->n));
        break;
    case SHAPE_DISK:
        per_area = disk_pdf(shape, instance);
        break;
    case SHAPE_SPHERE: {
        struct sphere sphere = sphere_in_world(shape, instance);
        float sin_max2 = sphere_cone(&sphere, vec3_sub(sphere.center, reference));
        if (sin_max2 > 0.0f) return sphere_cone_pdf(sin_max2) * choice;
        per_area = WARP_SPHERE_PDF / (shape->radius * shape->radius * area_scale(instance, s->n));
        break;
    }
    }
    return cosine > 0.0f ? per_area * distance * distance * choice / cosine : 0.0f;
}
