/* SPDX-License-Identifier: Apache-2.0 */
#ifndef API_HANDLES_H
#define API_HANDLES_H

#include "base/pool.h"
#include "base/str.h"
#include "image/image.h"
#include "scene/pose.h"

/*
 * What the public handles are. src/api/ is the only code that knows both them and the modules; its
 * functions check what a caller may get wrong, turn handles into internals, and keep the text of
 * the last failure in the context.
 */

struct lmn_context {
    struct pool *pool; /* owned */
    uint32_t cpu;      /* flags of base/cpu.h that kernels may use */
    uint32_t cpu_detected;
    struct error error;
    struct str json; /* what lmn_bench() gave out last */
    lmn_progress_fn *progress;
    void *progress_user;
    lmn_note_fn *note;
    void *note_user;
};

struct lmn_image {
    struct image image;
};

struct world;
struct view;

/* What tracing needs beside the scene; made at the first call that needs it, as listing variables
 * needs no acceleration structure. */
struct scene_cache {
    uint32_t cpu; /* the context's */
    struct world *world;
    struct view *view; /* for lmn_scene_trace() */
    /* From the start, for the call under way: a configuration [n_variables], and a camera. */
    float *u;
    struct pose pose;
};

struct lmn_scene {
    struct scene *scene;
    struct scene_cache *cache;
    char *path, *variables_path; /* as given; variables_path "" when it was NULL */
    char **defines;              /* [n_defines] */
    uint32_t n_defines;
};

/* Clears the last message: every public call that can fail starts with it. */
struct error *context_begin(lmn_context *context);

/* The size that a struct of options claims, checked: an older, smaller struct is padded with zeros
 * into `full`, a newer one must not have set what this library does not know. */
lmn_status options_copy(const char *type, const void *options, void *full, size_t full_size,
                        struct error *err);

/* Owned copy in a new handle; on success `image` is emptied. */
lmn_status image_handle(struct image *image, lmn_image **out, struct error *err);

/* Makes the world (and the view) of a scene unless it is there. */
lmn_status scene_world(const lmn_scene *scene, struct error *err);
lmn_status scene_view(const lmn_scene *scene, struct error *err);

/* What training and networks of this scene work on; makes the world. Valid as long as both are. */
struct workplace;
lmn_status scene_workplace(lmn_context *context, const lmn_scene *scene, struct workplace *out,
                           struct error *err);

/* Scene units to u [n_variables] with range checks; values NULL: the defaults. */
lmn_status scene_units(const lmn_scene *scene, const double *values, float *u, struct error *err);

/* What to render of a configuration by a network; its values go to the scene's u, its camera to
 * the scene's pose. */
struct model_render_options;
lmn_status scene_render_options(const lmn_scene *scene, const double *values,
                                const lmn_render_options *options, struct model_render_options *out,
                                struct error *err);

/* The window that size and crop name; zeros: the scene's size, everything. */
struct window;
lmn_status scene_window(const lmn_scene *scene, const uint32_t size[2], const uint32_t crop[4],
                        struct window *out, struct error *err);

/* Writes what an image should say of itself: program, version, scene, seed, spp, variables, camera
 * where it is an own one (else NULL). */
lmn_status describe_image(struct image *image, const lmn_scene *scene, const float *u,
                          const struct pose *camera, uint64_t seed, uint32_t spp,
                          struct error *err);

/* A checked camera of the scene. */
lmn_status scene_pose(const lmn_scene *scene, const lmn_camera *camera, struct pose *out,
                      struct error *err);

#endif
