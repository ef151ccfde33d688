/* SPDX-License-Identifier: Apache-2.0 */
#include "made_scene.h"

#include <stdlib.h>
#include <string.h>

#include "base/cpu.h"
#include "base/mem.h"
#include "scene/bounds.h"

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
    s->variables = m->variables;
    s->bindings = m->bindings;
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
        mem_free(m->meshes[i].normals);
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
    m->bsdfs[m->scene.n_bsdfs] = bsdf_blank(kind);
    m->bsdfs[m->scene.n_bsdfs].eta = 1.5f;
    return m->scene.n_bsdfs++;
}

uint32_t made_diffuse(struct made_scene *m, struct vec3 reflectance)
{
    uint32_t b = made_bsdf(m, BSDF_DIFFUSE);
    m->bsdfs[b].reflectance = made_texture(m, reflectance);
    return b;
}

uint32_t made_rough(struct made_scene *m, enum bsdf_kind kind, enum microfacet_kind distribution,
                    float alpha)
{
    uint32_t b = made_bsdf(m, kind);
    m->bsdfs[b].distribution = distribution;
    m->bsdfs[b].alpha_u = m->bsdfs[b].alpha_v = made_texture(m, vec3_splat(alpha));
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
                                                        .picture = SCENE_NONE,
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

uint32_t made_cylinder(struct made_scene *m, const struct transform *to_group, uint32_t bsdf,
                       uint32_t emitter)
{
    struct shape s = {.kind = SHAPE_CYLINDER, .emitter = emitter, .to_group = *to_group};
    return add_shape(m, &s, bsdf);
}

uint32_t made_mesh(struct made_scene *m, uint32_t n_vertices, const float *positions,
                   uint32_t n_triangles, const uint32_t *indices, uint32_t bsdf, uint32_t emitter)
{
    size_t n = (size_t)n_vertices * 3, n_indices = (size_t)n_triangles * 3;
    struct mesh *mesh = &m->meshes[m->scene.n_meshes];
    mesh->n_vertices = n_vertices;
    mesh->n_triangles = n_triangles;
    mesh->positions = must(mem_new(n + 4, sizeof(float))); /* padded for Embree */
    mesh->indices = must(mem_new(n_indices + 4, sizeof(uint32_t)));
    memcpy(mesh->positions, positions, n * sizeof(float));
    memcpy(mesh->indices, indices, n_indices * sizeof(uint32_t));
    struct shape s = {.kind = SHAPE_MESH,
                      .mesh = m->scene.n_meshes++,
                      .emitter = emitter,
                      .to_group = transform_identity()};
    return add_shape(m, &s, bsdf);
}

uint32_t made_quad(struct made_scene *m, struct vec3 p, struct vec3 a, struct vec3 b, uint32_t bsdf,
                   uint32_t emitter)
{
    const struct vec3 corners[4] = {p, vec3_add(p, a), vec3_add(vec3_add(p, a), b), vec3_add(p, b)};
    static const float uvs[8] = {0, 0, 1, 0, 1, 1, 0, 1};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    float positions[4 * 3];
    for (int i = 0; i < 4; i++) {
        positions[3 * i + 0] = corners[i].x;
        positions[3 * i + 1] = corners[i].y;
        positions[3 * i + 2] = corners[i].z;
    }
    uint32_t shape = made_mesh(m, 4, positions, 2, indices, bsdf, emitter);
    struct mesh *mesh = &m->meshes[m->scene.n_meshes - 1];
    mesh->uvs = must(mem_new(4 * 2 + 4, sizeof(float)));
    memcpy(mesh->uvs, uvs, sizeof uvs);
    return shape;
}

uint32_t made_variable(struct made_scene *m, uint32_t n_choices)
{
    struct variable *v = &m->variables[m->scene.n_variables];
    *v = (struct variable){.name = "variable", .max = n_choices ? n_choices : 1};
    v->n_choices = n_choices;
    return m->scene.n_variables++;
}

void made_motion(struct made_scene *m, uint32_t instance, uint32_t variable, struct vec3 axis,
                 struct vec3 pivot, float degrees, struct vec3 offset)
{
    uint32_t n = m->scene.n_bindings++;
    struct binding_step *steps = &m->steps[2 * n]; /* the last applies first */
    steps[0] = (struct binding_step){
        .kind = STEP_TRANSLATE,
        .drive = {{variable, 0, offset.x}, {variable, 0, offset.y}, {variable, 0, offset.z}}};
    steps[1] = (struct binding_step){
        .kind = STEP_ROTATE, .drive = {{variable, 0, degrees}}, .axis = axis, .pivot = pivot};
    m->bindings[n] = (struct binding){.kind = BINDING_TRANSFORM,
                                      .array = STATE_INSTANCES,
                                      .index = instance,
                                      .offset = offsetof(struct instance, to_world),
                                      .steps = steps,
                                      .n_steps = 2};
}

void made_visible(struct made_scene *m, uint32_t instance, uint32_t variable, uint32_t choice)
{
    uint32_t n = m->scene.n_bindings++;
    m->conditions[n] = (struct binding_condition){variable, choice};
    m->bindings[n] = (struct binding){.kind = BINDING_VISIBLE,
                                      .array = STATE_INSTANCES,
                                      .index = instance,
                                      .offset = offsetof(struct instance, is_visible),
                                      .conditions = &m->conditions[n],
                                      .n_conditions = 1};
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

/* A room of checkers, mirror and glossy walls. */
static void add_room(struct made_scene *m)
{
    uint32_t checkers = made_diffuse(m, vec3_splat(1.0f));
    m->textures[m->bsdfs[checkers].reflectance] = (struct texture){.kind = TEXTURE_CHECKERBOARD,
                                                                   .value = vec3_splat(1.0f),
                                                                   .color0 = vec3(0.7f, 0.6f, 0.4f),
                                                                   .color1 = vec3(0.1f, 0.2f, 0.3f),
                                                                   .to_uv = {{6, 0, 0}, {0, 6, 0}}};
    uint32_t mirror = made_bsdf(m, BSDF_CONDUCTOR);
    m->bsdfs[mirror].eta_texture = made_texture(m, vec3(0.2f, 0.9f, 1.1f));
    m->bsdfs[mirror].k_texture = made_texture(m, vec3(3.9f, 2.4f, 2.2f));
    uint32_t glossy = made_rough(m, BSDF_ROUGH_CONDUCTOR, MICROFACET_BECKMANN, 0.3f);
    m->bsdfs[glossy].eta_texture = made_texture(m, vec3_splat(1.0f));
    m->bsdfs[glossy].k_texture = made_texture(m, vec3(3, 4, 5));
    m->bsdfs[glossy].alpha_v = made_texture(m, vec3_splat(0.1f)); /* anisotropic */
    made_quad(m, vec3(-3, 0, 3), vec3(6, 0, 0), vec3(0, 0, -6), checkers, SCENE_NONE);
    made_quad(m, vec3(-3, 0, -2), vec3(3, 0, 0), vec3(0, 3, 0), mirror, SCENE_NONE);
    made_quad(m, vec3(0, 0, -2), vec3(3, 0, 0), vec3(0, 3, 0), made_twosided(m, glossy),
              SCENE_NONE);
}

/* Two spheres and a half-open card: this group is there twice. */
static void add_objects(struct made_scene *m)
{
    uint32_t mask = made_bsdf(m, BSDF_MASK), glass = made_bsdf(m, BSDF_DIELECTRIC);
    m->bsdfs[mask].child[0] = made_twosided(m, made_diffuse(m, vec3(0.8f, 0.3f, 0.2f)));
    m->bsdfs[mask].opacity = made_texture(m, vec3_splat(0.6f));
    uint32_t frosted = made_rough(m, BSDF_ROUGH_DIELECTRIC, MICROFACET_GGX, 0.25f);
    made_group(m);
    made_sphere(m, vec3(-0.4f, 0.3f, 0), 0.3f, glass, SCENE_NONE);
    made_sphere(m, vec3(0.4f, 0.3f, 0), 0.3f, frosted, SCENE_NONE);
    made_quad(m, vec3(-0.5f, 0.65f, -0.4f), vec3(1, 0, 0), vec3(0, 0.4f, 0.3f), mask, SCENE_NONE);
}

/* A sphere and a disk that shine, and a mesh and a ball of plastic, turned together. */
static void add_lamps(struct made_scene *m)
{
    uint32_t grey = made_diffuse(m, vec3_splat(0.5f)), plastic = made_bsdf(m, BSDF_PLASTIC);
    m->bsdfs[plastic].reflectance = made_texture(m, vec3(0.1f, 0.3f, 0.6f));
    m->bsdfs[plastic].is_nonlinear = true;
    uint32_t ball = made_emitter(m, EMITTER_AREA, vec3(4, 3, 2));
    uint32_t dish = made_emitter(m, EMITTER_AREA, vec3(1, 2, 4));
    uint32_t tile = made_emitter(m, EMITTER_AREA, vec3(3, 3, 3));
    struct transform down = transform_rotate(vec3(1, 0, 0), 110), up, place;
    up = transform_translate(vec3(0.9f, 1.8f, 0.2f));
    place = transform_mul(&up, &down);
    made_group(m);
    made_sphere(m, vec3(-1.2f, 1.3f, -0.5f), 0.25f, grey, ball);
    made_disk(m, &place, grey, dish);
    made_quad(m, vec3(-0.4f, 2.2f, -0.2f), vec3(0.5f, 0, 0), vec3(0, 0, 0.4f), grey, tile);
    made_sphere(m, vec3(0, 0.25f, 0.8f), 0.25f, plastic, SCENE_NONE);
}

static uint32_t made_around(struct made_scene *m, enum bsdf_kind kind, uint32_t child)
{
    uint32_t b = made_bsdf(m, kind);
    m->bsdfs[b].child[0] = child;
    return b;
}

/* A row of balls of layered, mixed and mapped materials, and a pane of thin glass. */
static void add_layers(struct made_scene *m)
{
    float relief[8 * 8 * 3];
    for (int i = 0; i < 8 * 8 * 3; i++) relief[i] = 0.2f + 0.1f * (float)(i * 5 % 7);
    uint32_t picture = made_texture(m, vec3_splat(1.0f));
    m->textures[picture] = (struct texture){.kind = TEXTURE_BITMAP,
                                            .value = vec3_splat(1.0f),
                                            .bitmap = made_bitmap(m, 8, 8, relief),
                                            .to_uv = {{2, 0, 0}, {0, 3, 0}}};
    uint32_t paint = made_rough(m, BSDF_ROUGH_PLASTIC, MICROFACET_GGX, 0.2f);
    m->bsdfs[paint].reflectance = made_texture(m, vec3(0.6f, 0.2f, 0.1f));
    uint32_t car = made_bsdf(m, BSDF_PRINCIPLED);
    m->bsdfs[car].reflectance = picture;
    m->bsdfs[car].alpha_u = m->bsdfs[car].alpha_v = made_texture(m, vec3_splat(0.5f));
    for (int i = 0; i < PRINCIPLED_SLOTS; i++)
        m->bsdfs[car].principled[i] = made_texture(m, vec3_splat(0.3f));
    uint32_t shiny = made_bsdf(m, BSDF_PHONG);
    m->bsdfs[shiny].reflectance = m->bsdfs[shiny].specular_reflectance = made_texture(
        m, vec3(0.4f, 0.3f, 0.5f));
    m->bsdfs[shiny].exponent = made_texture(m, vec3_splat(25.0f));
    uint32_t clay = made_rough(m, BSDF_ROUGH_DIFFUSE, MICROFACET_BECKMANN, 0.4f);
    m->bsdfs[clay].reflectance = made_texture(m, vec3(0.7f, 0.5f, 0.4f));
    uint32_t dented = made_around(m, BSDF_BUMPMAP, clay), leather, mixed;
    m->bsdfs[dented].normals = picture;
    m->bsdfs[dented].scale = 0.1f;
    mixed = made_around(m, BSDF_BLEND, dented);
    m->bsdfs[mixed].child[1] = made_around(m, BSDF_TWOSIDED, shiny);
    m->bsdfs[mixed].weight = picture;
    leather = made_around(m, BSDF_NORMALMAP, paint);
    m->bsdfs[leather].normals = picture;
    const uint32_t balls[] = {leather, car, mixed, dented};
    made_group(m);
    for (int i = 0; i < 4; i++)
        made_sphere(m, vec3(-1.2f + 0.75f * (float)i, 0.2f, 1.6f), 0.2f, balls[i], SCENE_NONE);
    made_quad(m, vec3(-0.8f, 0, 1.9f), vec3(0.8f, 0, 0), vec3(0, 0.8f, 0),
              made_bsdf(m, BSDF_THIN_DIELECTRIC), SCENE_NONE);
}

struct made_scene *made_all_kinds(uint32_t width, uint32_t height)
{
    struct made_scene *m = made_scene_new();
    float sky[8 * 4 * 3];
    for (int i = 0; i < 8 * 4 * 3; i++) sky[i] = i == 30 ? 9.0f : 0.1f * (float)(i * 7 % 5);
    struct transform turn = transform_rotate(vec3(0, 1, 0), 40), move, scale;
    uint32_t map = made_emitter(m, EMITTER_ENVMAP, vec3_splat(1.0f));
    m->emitters[map].bitmap = made_bitmap(m, 8, 4, sky);
    m->emitters[map].to_world = turn;
    m->emitters[map].scale = 0.5f;
    made_emitter(m, EMITTER_CONSTANT, vec3(0.1f, 0.15f, 0.2f));
    made_point(m, vec3(1.5f, 2.5f, 2), vec3(4, 4, 3));
    add_room(m);
    add_objects(m);
    scale = transform_scale(vec3(1.3f, 0.9f, 1.3f));
    scale = transform_mul(&turn, &scale);
    move = transform_translate(vec3(-1.1f, 0, -0.8f));
    move = transform_mul(&move, &scale);
    made_instance(m, 1, &move);
    move = transform_translate(vec3(0.9f, 0, 0.3f));
    made_instance(m, 1, &move);
    add_lamps(m);
    turn = transform_rotate(vec3(0, 1, 0), -25);
    made_instance(m, 2, &turn);
    add_layers(m);
    made_instance(m, 3, &turn);
    made_camera(m, vec3(0.3f, 1.4f, 4.5f), vec3(0, 0.8f, 0), 45, width, height);
    return m;
}

struct view *made_view(struct made_scene *m)
{
    for (uint32_t i = 0; i < m->scene.n_groups; i++)
        m->groups[i].bounds = group_bounds(&m->scene, &m->groups[i]);
    struct error err = {""};
    if (world_new(&m->scene, cpu_detect(), &m->world, &err) || view_new(m->world, &m->view, &err))
        abort();
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
