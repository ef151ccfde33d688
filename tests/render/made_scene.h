/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_RENDER_MADE_SCENE_H
#define TESTS_RENDER_MADE_SCENE_H

#include "render/view.h"
#include "scene/binding.h"

/*
 * Small scenes made in code: fixed room for a few objects, one group per made_group() call. Freed
 * by made_scene_free().
 *
 *   struct made_scene *m = made_scene_new();
 *   uint32_t grey = made_diffuse(m, vec3_splat(.5f));
 *   made_sphere(m, vec3(0, 0, 0), 1, grey, SCENE_NONE);
 *   made_camera(m, origin, target, fov, width, height);
 *   struct view *v = made_view(m);
 */
enum { MADE_MAX = 64 };

struct made_scene {
    struct scene scene;
    struct world *world;
    struct view *view;
    struct texture textures[MADE_MAX];
    struct bsdf bsdfs[MADE_MAX];
    struct emitter emitters[MADE_MAX];
    struct instance instances[MADE_MAX];
    struct shape shapes[MADE_MAX];
    struct group groups[MADE_MAX];
    struct mesh meshes[MADE_MAX];
    struct bitmap bitmaps[MADE_MAX];
    struct variable variables[MADE_MAX];
    struct binding bindings[MADE_MAX];
    struct binding_step steps[MADE_MAX]; /* two per binding at most */
    struct binding_condition conditions[MADE_MAX];
    uint32_t shape_bsdfs[MADE_MAX];
};

struct made_scene *made_scene_new(void);
void made_scene_free(struct made_scene *m);

uint32_t made_texture(struct made_scene *m, struct vec3 value);
uint32_t made_bsdf(struct made_scene *m, enum bsdf_kind kind); /* all indices SCENE_NONE, eta 1.5 */
uint32_t made_diffuse(struct made_scene *m, struct vec3 reflectance);
uint32_t made_rough(struct made_scene *m, enum bsdf_kind kind, enum microfacet_kind distribution,
                    float alpha);
uint32_t made_twosided(struct made_scene *m, uint32_t child);
uint32_t made_emitter(struct made_scene *m, enum emitter_kind kind, struct vec3 radiance);
uint32_t made_point(struct made_scene *m, struct vec3 position, struct vec3 intensity);

/* A float bitmap [height][width][3]; copies `rgb`. */
uint32_t made_bitmap(struct made_scene *m, uint32_t width, uint32_t height, const float *rgb);

/* Shapes go into the last group; the first group and its instance are made by the first shape. */
uint32_t made_sphere(struct made_scene *m, struct vec3 center, float radius, uint32_t bsdf,
                     uint32_t emitter);
uint32_t made_disk(struct made_scene *m, const struct transform *to_group, uint32_t bsdf,
                   uint32_t emitter);
/* The parallelogram p, p + a, p + a + b, p + b; normal along a x b. */
uint32_t made_quad(struct made_scene *m, struct vec3 p, struct vec3 a, struct vec3 b, uint32_t bsdf,
                   uint32_t emitter);
/* Copies positions [n_vertices][3] and indices [n_triangles][3]; neither normals nor uvs. */
uint32_t made_cylinder(struct made_scene *m, const struct transform *to_group, uint32_t bsdf,
                       uint32_t emitter);
uint32_t made_mesh(struct made_scene *m, uint32_t n_vertices, const float *positions,
                   uint32_t n_triangles, const uint32_t *indices, uint32_t bsdf, uint32_t emitter);
void made_group(struct made_scene *m);
uint32_t made_instance(struct made_scene *m, uint32_t group, const struct transform *to_world);

/* A variable; n_choices 0: continuous, in [0,1]. What it drives: an instance that turns about an
 * axis through `pivot` from 0 to `degrees`, then moves from 0 to `offset`; one that is seen when
 * the variable takes the choice. */
uint32_t made_variable(struct made_scene *m, uint32_t n_choices);
void made_motion(struct made_scene *m, uint32_t instance, uint32_t variable, struct vec3 axis,
                 struct vec3 pivot, float degrees, struct vec3 offset);
void made_visible(struct made_scene *m, uint32_t instance, uint32_t variable, uint32_t choice);

void made_camera(struct made_scene *m, struct vec3 origin, struct vec3 target, float fov,
                 uint32_t width, uint32_t height);

/* Every kind of bsdf, shape and emitter, nested and plain, in three groups of which one is there
 * twice, turned and scaled; seen by a camera, without a view yet. */
struct made_scene *made_all_kinds(uint32_t width, uint32_t height);

/* World and view; they belong to m. */
struct view *made_view(struct made_scene *m);

/* Box filter, independent sampler, no roulette before 1000, and the given depth and samples. */
struct trace_settings made_settings(const struct made_scene *m, int32_t max_depth, uint32_t spp);

/* Traces the whole picture into a new array [height][width][3], to be freed with mem_free(). */
float *made_trace(const struct made_scene *m, const struct trace_settings *t);

/* Mean over pixels and channels. */
double made_mean(const float *rgb, const struct made_scene *m);

#endif
