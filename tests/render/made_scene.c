/* SPDX-License-Identifier: Apache-2.0 */
#include "made_scene.h"

#include <stdlib.h>
#include <string.h>

#include "base/mem.h"

/* Tests have no use for a half-made scene. */
static void *must(void *p)
{
    if (!p) abort();
    return p;
}

struct made_scene *made_scene_new(void)
{
    struct made_scene *m = must(mem_new(1, sizeof *m));
    struct scene *s = &m->scene;
    s->path = "made";
    s->meshes = m->meshes;
    s->shapes = m->shapes;
    s->groups = m->groups;
    s->bitmaps = m->bitmaps;
    s->defaults = (struct scene_state){.textures = m->textures,
                                       .bsdfs = m->bsdfs,
                                       .emitters = m->emitters,
                                       .instances = m->instances,
                                       .shape_bsdfs = m->shape_bsdfs};
    s->settings = (struct render_settings){.width = 16,
                                           .height = 16,
                                           .spp = 16,
                                           .max_depth = -1,
                                           .rr_depth = 5,
                                           .filter = FILTER_BOX,
                                           .filter_radius = 0.5f,
                                           .filter_stddev = 0.5f};
    return m;
}

void made_scene_free(struct made_scene *m)
{
    view_free(m->view);
    world_free(m->world);
    for (uint32_t i = 0; i < m->scene.n_meshes; i++) {
        mem_free(m->meshes[i].positions);
        mem_free(m->meshes[i].uvs);
        mem_free(m->meshes[i].indices);
    }
    for (uint32_t i = 0; i < m->scene.n_bitmaps; i++) mem_free(m->bitmaps[i].f32);
    mem_free(m);
}

uint32_t made_texture(struct made_scene *m, struct vec3 value)
{
    m->textures[m->scene.n_textures] = (struct texture){.kind = TEXTURE_CONSTANT, .value = value};
    return m->scene.n_textures++;
}

uint32_t made_bsdf(struct made_scene *m, enum bsdf_kind kind)
{
    m->bsdfs[m->scene.n_bsdfs] = (struct bsdf){.kind = kind,
                                               .reflectance = SCENE_NONE,
                                               .specular_reflectance = SCENE_NONE,
                                               .specular_transmittance = SCENE_NONE,
                                               .alpha_u = SCENE_NONE,
                                               .alpha_v = SCENE_NONE,
                                               .eta_texture = SCENE_NONE,
                                               .k_texture = SCENE_NONE,
                                               .opacity = SCENE_NONE,
                                               .eta = 1.5f,
                                               .child = {SCENE_NONE, SCENE_NONE}};
    return m->scene.n_bsdfs++;
}

uint32_t made_diffuse(struct made_scene *m, struct vec3 reflectance)
{
    uint32_t b = made_bsdf(m, BSDF_DIFFUSE);
    m->bsdfs[b].reflectance = made_texture(m, reflectance);
    return b;
}

uint32_t made_twosided(struct made_scene *m, uint32_t child)
{
    uint32_t b = made_bsdf(m, BSDF_TWOSIDED);
    m->bsdfs[b].child[0] = m->bsdfs[b].child[1] = child;
    return b;
}

uint32_t made_emitter(struct made_scene *m, enum emitter_kind kind, struct vec3 radiance)
{
    m->emitters[m->scene.n_emitters] = (struct emitter){.kind = kind,
                                                        .radiance = made_texture(m, radiance),
                                                        .scale = 1.0f,
                                                        .to_world = transform_identity()};
    return m->scene.n_emitters++;
}

uint32_t made_point(struct made_scene *m, struct vec3 position, struct vec3 intensity)
{
    uint32_t e = made_emitter(m, EMITTER_POINT, intensity);
    m->emitters[e].to_world = transform_translate(position);
    return e;
}

uint32_t made_bitmap(struct made_scene *m, uint32_t width, uint32_t height, const float *rgb)
{
    struct bitmap *b = &m->bitmaps[m->scene.n_bitmaps];
    size_t n = (size_t)width * height * 3;
    *b = (struct bitmap){.width = width, .height = height, .n_channels = 3};
    b->f32 = must(mem_new(n, sizeof(float)));
    memcpy(b->f32, rgb, n * sizeof(float));
    return m->scene.n_bitmaps++;
}

void made_group(struct made_scene *m)
{
    m->groups[m->scene.n_groups++] = (struct group){.name = "group",
                                                    .first_shape = m->scene.n_shapes};
}

uint32_t made_instance(struct made_scene *m, uint32_t group, const struct transform *to_world)
{
    m->instances[m->scene.n_instances] = (struct instance){
        .group = group, .to_world = *to_world, .is_visible = true};
    return m->scene.n_instances++;
}

static uint32_t add_shape(struct made_scene *m, const struct shape *shape, uint32_t bsdf)
{
    if (m->scene.n_groups == 0) {
        struct transform identity = transform_identity();
        made_group(m);
        made_instance(m, 0, &identity);
    }
    m->shapes[m->scene.n_shapes] = *shape;
    m->shapes[m->scene.n_shapes].name = "shape";
    m->shape_bsdfs[m->scene.n_shapes] = bsdf;
    m->groups[m->scene.n_groups - 1].n_shapes++;
    return m->scene.n_shapes++;
}

uint32_t made_sphere(struct made_scene *m, struct vec3 center, float radius, uint32_t bsdf,
                     uint32_t emitter)
{
    struct transform t = transform_translate(center), scale = transform_scale(vec3_splat(radius));
    struct shape s = {.kind = SHAPE_SPHERE, .emitter = emitter};
    s.to_group = transform_mul(&t, &scale);
    return add_shape(m, &s, bsdf);
}

uint32_t made_disk(struct made_scene *m, const struct transform *to_group, uint32_t bsdf,
                   uint32_t emitter)
{
    struct shape s = {.kind = SHAPE_DISK, .emitter = emitter, .to_group = *to_group};
    return add_shape(m, &s, bsdf);
}

uint32_t made_quad(struct made_scene *m, struct vec3 p, struct vec3 a, struct vec3 b, uint32_t bsdf,
                   uint32_t emitter)
{
    const struct vec3 corners[4] = {p, vec3_add(p, a), vec3_add(vec3_add(p, a), b), vec3_add(p, b)};
    static const float uvs[8] = {0, 0, 1, 0, 1, 1, 0, 1};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    struct mesh *mesh = &m->meshes[m->scene.n_meshes];
    mesh->n_vertices = 4;
    mesh->n_triangles = 2;
    mesh->positions = must(mem_new(4 * 3 + 4, sizeof(float)));
    mesh->uvs = must(mem_new(4 * 2 + 4, sizeof(float)));
    mesh->indices = must(mem_new(2 * 3 + 4, sizeof(uint32_t)));
    for (int i = 0; i < 4; i++) {
        mesh->positions[3 * i + 0] = corners[i].x;
        mesh->positions[3 * i + 1] = corners[i].y;
        mesh->positions[3 * i + 2] = corners[i].z;
    }
    memcpy(mesh->uvs, uvs, sizeof uvs);
    memcpy(mesh->indices, indices, sizeof indices);
    struct shape s = {.kind = SHAPE_MESH,
                      .mesh = m->scene.n_meshes++,
                      .emitter = emitter,
                      .to_group = transform_identity()};
    return add_shape(m, &s, bsdf);
}

void made_camera(struct made_scene *m, struct vec3 origin, struct vec3 target, float fov,
                 uint32_t width, uint32_t height)
{
    struct vec3 d = vec3_sub(target, origin);
    struct vec3 up = d.x == 0.0f && d.z == 0.0f ? vec3(0, 0, 1) : vec3(0, 1, 0);
    m->scene.defaults.sensor = (struct sensor){.to_world = transform_look_at(origin, target, up),
                                               .fov = fov,
                                               .fov_axis = FOV_X,
                                               .near_clip = 1e-2f,
                                               .far_clip = 1e4f};
    m->scene.settings.width = width;
    m->scene.settings.height = height;
}

struct view *made_view(struct made_scene *m)
{
    struct error err = {""};
    if (world_new(&m->scene, &m->world, &err) || view_new(m->world, &m->view, &err)) abort();
    return m->view;
}

struct trace_settings made_settings(const struct made_scene *m, int32_t max_depth, uint32_t spp)
{
    struct trace_settings t;
    trace_settings_init(&t, &m->scene);
    t.max_depth = max_depth;
    t.spp = spp;
    t.rr_depth = 1000;
    t.seed = 1;
    return t;
}

float *made_trace(const struct made_scene *m, const struct trace_settings *t)
{
    uint32_t width = m->scene.settings.width, height = m->scene.settings.height;
    struct window w = {width, height, 0, 0, width, height};
    struct trace_output out = {.color = must(mem_new((size_t)width * height * 3, sizeof(float)))};
    view_trace(m->view, t, &w, &out);
    return out.color;
}

double made_mean(const float *rgb, const struct made_scene *m)
{
    size_t n = (size_t)m->scene.settings.width * m->scene.settings.height * 3;
    double sum = 0;
    for (size_t i = 0; i < n; i++) sum += rgb[i];
    return sum / (double)n;
}
