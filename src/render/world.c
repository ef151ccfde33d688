/* SPDX-License-Identifier: Apache-2.0 */
#include "render/world.h"

#include "base/mem.h"
#include "render/light.h"
#include "render/stream.h"
#include "scene/bounds.h"

static struct vec3 vertex(const struct mesh *m, uint32_t index)
{
    return vec3_load(m->positions + 3 * (size_t)index);
}

/* Where an emissive mesh is, and how far it reaches. */
static void init_place(struct world_shape *shape, const struct mesh *m, const float *areas)
{
    double total = 0, sum[3] = {0, 0, 0};
    for (uint32_t i = 0; i < m->n_triangles; i++) {
        total += areas[i];
        for (int k = 0; k < 3; k++) {
            struct vec3 p = vertex(m, m->indices[3 * (size_t)i + (size_t)k]);
            sum[0] += (double)(areas[i] * p.x);
            sum[1] += (double)(areas[i] * p.y);
            sum[2] += (double)(areas[i] * p.z);
        }
    }
    double scale = total > 0 ? 1 / (3 * total) : 0;
    shape->center = vec3((float)(sum[0] * scale), (float)(sum[1] * scale), (float)(sum[2] * scale));
    for (size_t i = 0; i < 3 * (size_t)m->n_triangles; i++) {
        struct vec3 d = vec3_sub(vertex(m, m->indices[i]), shape->center);
        shape->extent = max_float(shape->extent, vec3_length(d));
    }
}

/* Triangles by area, for choosing points on a mesh that shines. */
static lmn_status init_area(struct world_shape *shape, const struct mesh *m, struct error *err)
{
    float *areas = mem_new(m->n_triangles, sizeof *areas);
    bool ok = areas != NULL;
    for (uint32_t i = 0; ok && i < m->n_triangles; i++) {
        const uint32_t *at = m->indices + 3 * (size_t)i;
        struct vec3 p = vertex(m, at[0]);
        struct vec3 n = vec3_cross(vec3_sub(vertex(m, at[1]), p), vec3_sub(vertex(m, at[2]), p));
        areas[i] = 0.5f * vec3_length(n);
    }
    ok = ok && distribution_init(&shape->area, areas, m->n_triangles);
    shape->total_area = ok ? (float)shape->area.total : 0.0f;
    if (ok) init_place(shape, m, areas);
    mem_free(areas);
    return ok ? LMN_OK : fail_memory(err, "light table");
}

/* Whether shading normals differ from the faces' by no more than rounding: 1, -1 or 0, as
 * world_shape has it. Many files give normals to flat things. */
static float flat_side(const struct mesh *m)
{
    float sides[2] = {0, 0};
    if (!m->normals) return 1.0f;
    for (uint32_t i = 0; i < m->n_triangles; i++) {
        const uint32_t *at = m->indices + 3 * (size_t)i;
        struct vec3 p = vertex(m, at[0]);
        struct vec3 n = vec3_cross(vec3_sub(vertex(m, at[1]), p), vec3_sub(vertex(m, at[2]), p));
        for (int k = 0; k < 3; k++) {
            const float *q = m->normals + 3 * (size_t)at[k];
            struct vec3 ns = vec3(q[0], q[1], q[2]);
            float cosine = vec3_dot(n, ns) / (vec3_length(n) * vec3_length(ns));
            if (!(fabsf(cosine) > 1.0f - 1e-6f)) return 0.0f; /* a NaN too */
            sides[cosine < 0.0f] = 1.0f;
        }
    }
    return sides[0] - sides[1];
}

/* How far a shape reaches from the middle of its bounds. */
static float reach_of(const struct world_shape *shape)
{
    struct vec3 size = vec3_sub(shape->bounds.max, shape->bounds.min);
    struct vec3 middle = vec3_scale(vec3_add(shape->bounds.min, shape->bounds.max), 0.5f);
    float corner = 0.5f * vec3_length(size), reach2 = 0.0f;
    if (shape->kind == SHAPE_SPHERE || shape->kind == SHAPE_DISK)
        return min_float(shape->radius, corner);
    if (shape->kind != SHAPE_MESH) return corner;
    for (uint32_t i = 0; i < shape->mesh->n_vertices; i++) {
        struct vec3 d = vec3_sub(vertex(shape->mesh, i), middle);
        reach2 = max_float(reach2, vec3_dot(d, d));
    }
    return min_float(sqrtf(reach2), corner);
}

static lmn_status init_shape(struct world *w, uint32_t index, struct error *err)
{
    const struct shape *s = &w->scene->shapes[index];
    struct world_shape *shape = &w->shapes[index];
    *shape = (struct world_shape){.kind = s->kind,
                                  .is_flipped = s->flip_normals,
                                  .emitter = s->emitter,
                                  .to_group = &s->to_group,
                                  .index = index};
    if (s->kind == SHAPE_SPHERE || s->kind == SHAPE_DISK) {
        shape->center = transform_point(&s->to_group, vec3_splat(0.0f));
        shape->radius = vec3_length(transform_vector(&s->to_group, vec3(1.0f, 0.0f, 0.0f)));
        shape->extent = shape->radius;
    }
    shape->bounds = shape_bounds(w->scene, s);
    if (s->kind == SHAPE_CYLINDER) {
        shape->radius = vec3_length(transform_vector(&s->to_group, vec3(1.0f, 0.0f, 0.0f)));
        float length = vec3_length(transform_vector(&s->to_group, vec3(0.0f, 0.0f, 1.0f)));
        shape->total_area = 2.0f * MATH_PI * shape->radius * length;
        shape->center = transform_point(&s->to_group, vec3(0.0f, 0.0f, 0.5f));
        shape->extent = shape->radius + 0.5f * length;
    }
    if (s->kind != SHAPE_MESH) {
        shape->reach = reach_of(shape);
        return LMN_OK;
    }
    const struct mesh *m = &w->scene->meshes[s->mesh];
    shape->mesh = m;
    shape->positions = m->positions;
    shape->normals = m->normals;
    shape->uvs = m->uvs;
    shape->indices = m->indices;
    shape->reach = reach_of(shape);
    if (s->emitter == SCENE_NONE) return LMN_OK;
    shape->flat_side = flat_side(m);
    return init_area(shape, m, err);
}

/* Shapes that no light can be on: nothing to choose a point from. */
static bool can_shine(const struct world_shape *s)
{
    return s->emitter != SCENE_NONE && (s->kind != SHAPE_MESH || s->total_area > 0.0f);
}

static lmn_status init_shapes(struct world *w, struct error *err)
{
    lmn_status status = LMN_OK;
    const struct scene *s = w->scene;
    for (uint32_t i = 0; i < s->n_shapes; i++) TRY(init_shape(w, i, err));
    for (uint32_t g = 0; g < s->n_groups; g++) {
        for (uint32_t i = 0; i < s->groups[g].n_shapes; i++) {
            struct world_shape *shape = &w->shapes[s->groups[g].first_shape + i];
            if (!can_shine(shape)) shape->emitter = SCENE_NONE;
            if (shape->emitter != SCENE_NONE) shape->light = w->group_n_lights[g]++;
        }
    }
    for (uint32_t i = 0; i < s->n_instances; i++)
        w->n_lights_max += w->group_n_lights[s->defaults.instances[i].group];
    for (uint32_t i = 0; i < s->n_emitters; i++)
        if (!emitter_is_surface(s->defaults.emitters[i].kind)) w->n_lights_max++;
    for (uint32_t i = 0; i < s->n_emitters; i++)
        if (s->defaults.emitters[i].kind == EMITTER_SKY) w->n_skies++;
    w->n_lights_max += w->n_skies; /* their suns */
done:
    return status;
}

/* An envmap's bitmap cannot change, so one table each is enough. */
static lmn_status init_envmaps(struct world *w, struct error *err)
{
    const struct scene *s = w->scene;
    for (uint32_t i = 0; i < s->n_emitters; i++) {
        const struct emitter *e = &s->defaults.emitters[i];
        if (e->kind != EMITTER_ENVMAP || w->envmaps[e->bitmap].rgb) continue;
        if (!envmap_init(&w->envmaps[e->bitmap], &s->bitmaps[e->bitmap], w->decode[0]))
            return fail_memory(err, "environment map");
    }
    return LMN_OK;
}

lmn_status world_new(const struct scene *scene, uint32_t cpu, struct world **out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct world *w = mem_new(1, sizeof *w);
    *out = NULL;
    if (!w) return fail_memory(err, "renderer");
    w->scene = scene;
    w->kernels = stream_kernels_for(cpu);
    w->shapes = mem_new(scene->n_shapes, sizeof *w->shapes);
    w->group_n_lights = mem_new(scene->n_groups, sizeof *w->group_n_lights);
    w->envmaps = mem_new(scene->n_bitmaps, sizeof *w->envmaps);
    if ((!w->shapes && scene->n_shapes) || (!w->group_n_lights && scene->n_groups) ||
        (!w->envmaps && scene->n_bitmaps)) {
        status = fail_memory(err, "renderer");
        goto done;
    }
    texture_decode_init(w->decode);
    TRY(init_shapes(w, err));
    TRY(init_envmaps(w, err));
    TRY(accel_new(scene, cpu, &w->accel, err));
    *out = w;
    w = NULL;
done:
    world_free(w);
    return status;
}

void world_free(struct world *w)
{
    if (!w) return;
    for (uint32_t i = 0; w->shapes && i < w->scene->n_shapes; i++)
        distribution_release(&w->shapes[i].area);
    for (uint32_t i = 0; w->envmaps && i < w->scene->n_bitmaps; i++) envmap_release(&w->envmaps[i]);
    accel_free(w->accel);
    mem_free(w->shapes);
    mem_free(w->group_n_lights);
    mem_free(w->envmaps);
    mem_free(w);
}
