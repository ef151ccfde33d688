/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lumenaut: path-traces a variable scene, trains a neural renderer on those images while they are
 * being made, and shows any configuration of the scene at interactive rate.
 *
 * One header, read from top to bottom: status and context, images, scenes and their variables,
 * tracing, training, models, small services. C99 and C++11 clean.
 *
 * Rules that hold for every call:
 *  - A call that can fail returns lmn_status; the text is lmn_context_message() until the next call
 *    on that context. Results go through out-parameters, which are NULL or unchanged on failure.
 *  - Whoever receives a handle from a *_new, *_load, *_trace or *_render call frees it with the
 *    matching *_free. Every free takes NULL. Free handles before the context they came from.
 *  - Strings and pointers inside info structs belong to the handle they were asked from.
 *  - Structs of options start with struct_size and are zero-initialised for defaults, unless their
 *    comment names an init call.
 *  - The library never prints and never exits. Distinct contexts may be used from distinct threads
 *    at once; one context serves one thread at a time.
 *  - Same seed, same result, whatever the number of threads.
 */
#ifndef LUMENAUT_LUMENAUT_H
#define LUMENAUT_LUMENAUT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LMN_API __attribute__((visibility("default")))

/* ---- Status and context ------------------------------------------------------------------- */

typedef enum lmn_status {
    LMN_OK = 0,
    LMN_ERR_ARGUMENT = -1, /* the caller broke this header's contract, or named an unknown thing */
    LMN_ERR_MEMORY = -2,
    LMN_ERR_IO = -3,       /* the message names the path and the reason */
    LMN_ERR_PARSE = -4,    /* the message starts with file:line:column where it can */
    LMN_ERR_DEVICE = -5,   /* a backend is missing or refused the work */
    LMN_ERR_CANCELLED = -6 /* a progress callback asked to stop */
} lmn_status;

typedef struct lmn_context lmn_context;
typedef struct lmn_image lmn_image;
typedef struct lmn_scene lmn_scene;
typedef struct lmn_trainer lmn_trainer;
typedef struct lmn_model lmn_model;

/* Called now and then during long work, on the calling thread. `done` of `total` units are finished
 * (total 0: unknown). Return non-zero to stop; the call then returns LMN_ERR_CANCELLED. */
typedef int lmn_progress_fn(void *user, double done, double total);

/* Receives notes that are no errors (what a scene held that was ignored). One line, no newline. */
typedef void lmn_note_fn(void *user, const char *text);

typedef struct lmn_context_options {
    uint32_t struct_size;      /* sizeof(lmn_context_options) */
    uint32_t threads;          /* 0: every CPU in the process's affinity mask */
    const char *cpu;           /* NULL: best found; "baseline", "avx2", ... force a lower one */
    lmn_progress_fn *progress; /* may be NULL */
    void *progress_user;
    lmn_note_fn *note; /* may be NULL */
    void *note_user;
} lmn_context_options;

/* options may be NULL for defaults. On failure *out is NULL, and `message` (of message_size bytes,
 * may be NULL) gets the reason, as there is no context yet to ask. */
LMN_API lmn_status lmn_context_new(const lmn_context_options *options, lmn_context **out,
                                   char *message, size_t message_size);
LMN_API void lmn_context_free(lmn_context *context);

/* The text of the last failure on this context; "" when there was none. */
LMN_API const char *lmn_context_message(const lmn_context *context);

typedef struct lmn_info {
    const char *version;      /* "0.1.0" */
    const char *cpu_detected; /* best instruction set of this machine */
    const char *cpu_used;     /* the one in use */
    uint32_t threads;
    const char *embree; /* "3.13.5" */
} lmn_info;

LMN_API void lmn_context_info(const lmn_context *context, lmn_info *out);

/* ---- Images ------------------------------------------------------------------------------- */

/* An image holds width x height pixels of n_channels floats, interleaved, top row first. Channels
 * have names as in OpenEXR: "R", "G", "B", "albedo.R", "normal.X", "depth.Z". */
LMN_API lmn_status lmn_image_new(lmn_context *context, uint32_t width, uint32_t height,
                                 uint32_t n_channels, const char *const *names, lmn_image **out);
LMN_API void lmn_image_free(lmn_image *image);
LMN_API uint32_t lmn_image_width(const lmn_image *image);
LMN_API uint32_t lmn_image_height(const lmn_image *image);
LMN_API uint32_t lmn_image_n_channels(const lmn_image *image);
LMN_API const char *lmn_image_channel_name(const lmn_image *image, uint32_t channel);
LMN_API float *lmn_image_data(lmn_image *image);

/* Text that travels with the image (seed, parameters): an EXR attribute or a PNG text chunk. */
LMN_API lmn_status lmn_image_set_attribute(lmn_context *context, lmn_image *image, const char *name,
                                           const char *value);

/* The value of a text attribute, which belongs to the image; NULL when there is none. */
LMN_API const char *lmn_image_attribute(const lmn_image *image, const char *name);

/* EXR, PNG, JPEG, PFM, Radiance HDR, TGA, BMP; by content. Files of 8 and 16 bits come back as
 * linear radiance (sRGB decoded). */
LMN_API lmn_status lmn_image_load(lmn_context *context, const char *path, lmn_image **out);

/* EXR (multilayer), PNG (sRGB of `exposure` * RGB, clamped) or PFM, by the path's extension. `path`
 * may be "-" with `format` "exr", "png" or "pfm"; else format may be NULL. Colour channels are
 * stored as half floats in EXR, all others as floats. */
LMN_API lmn_status lmn_image_save(lmn_context *context, const lmn_image *image, const char *path,
                                  const char *format, double exposure);

enum {
    LMN_TONE_SRGB = 0, /* cut off at 1 */
    LMN_TONE_ACES = 1  /* rolled off as film does: the fit of Narkowicz 2015 */
};

/* What a screen shows: rgb [height][width][3] gets sRGB of the curve LMN_TONE_* of exposure times
 * the first three channels. */
LMN_API lmn_status lmn_image_tone(lmn_context *context, const lmn_image *image, double exposure,
                                  uint32_t tone, uint8_t *rgb);

typedef struct lmn_metrics {
    /* On linear radiance, mean over pixels and channels; p is the test image, g the reference. */
    double mae;    /* |p-g| */
    double mape;   /* |p-g| / (g + 0.01) */
    double relmse; /* (p-g)^2 / (g^2 + 0.01), without the 0.1 % largest pixels */
    double mse;    /* (p-g)^2 */
    /* On T = sRGB(clamp(k L, 0, 1)), k = 1 / 99th percentile of the reference. */
    double psnr;         /* dB */
    double dssim;        /* 1 - SSIM, 11x11 Gaussian of sigma 1.5 */
    double flip;         /* LDR-FLIP at 67 pixels per degree (Andersson et al. 2020) */
    double flip_hdr;     /* HDR-FLIP, ACES, automatic exposures (Andersson et al. 2021) */
    double dssim_log;    /* 1 - SSIM of log1p(L) */
    double dssim_legacy; /* as in the authors' code, whose window slides over (column, channel) */
    double exposure;     /* the k above */
} lmn_metrics;

/* Compares the R, G, B channels of two images of one size. If error_map is not NULL, *error_map
 * gets the LDR-FLIP map in false colour. */
LMN_API lmn_status lmn_image_compare(lmn_context *context, const lmn_image *test,
                                     const lmn_image *reference, lmn_metrics *out,
                                     lmn_image **error_map);

/* Compares tests[i] with references[i] for all i < n, on all threads; out [n]. */
LMN_API lmn_status lmn_image_compare_all(lmn_context *context, uint32_t n,
                                         const lmn_image *const *tests,
                                         const lmn_image *const *references, lmn_metrics *out);

/* Pictures beside each other, a row of columns and a caption for each configuration. */
typedef struct lmn_sheet {
    uint32_t struct_size;
    uint32_t n_rows, n_columns;
    uint32_t n_pictures; /* the first columns; the others are error maps of lmn_image_compare() */
    const lmn_image *const *images; /* [n_rows][n_columns], of one size in each row */
    const char *const *headings;    /* [n_columns]; cut where a column ends */
    const char *const *captions;    /* [n_rows], four lines at most */
    const double *exposures;        /* [n_rows], of the pictures */
} lmn_sheet;

/* Draws it; small pictures are enlarged. Save it with exposure 1. */
LMN_API lmn_status lmn_image_sheet(lmn_context *context, const lmn_sheet *sheet, lmn_image **out);

/* ---- Scenes ------------------------------------------------------------------------------- */

typedef struct lmn_scene_options {
    uint32_t struct_size;
    uint32_t n_defines;
    const char *const *defines; /* n_defines strings "name=value" that fill <default> and $name */
    const char *variables_path; /* NULL: SCENE.variables.json when it is there */
} lmn_scene_options;

/* Loads Mitsuba XML (3.x, and the variable scenes of the paper's authors). options may be NULL. */
LMN_API lmn_status lmn_scene_load(lmn_context *context, const char *path,
                                  const lmn_scene_options *options, lmn_scene **out);
LMN_API void lmn_scene_free(lmn_scene *scene);

typedef struct lmn_scene_info {
    const char *path;
    uint32_t n_variables, n_parameters;
    uint32_t n_shapes, n_instances, n_bsdfs, n_textures, n_emitters;
    uint64_t n_triangles;
    uint32_t width, height, spp; /* as the scene declares them */
    int32_t max_depth, rr_depth; /* max_depth -1: unlimited */
    float bounds_min[3], bounds_max[3];
    uint32_t orthographic; /* 1: its camera is */
    uint64_t hash;         /* changes with anything that changes an image */
} lmn_scene_info;

LMN_API void lmn_scene_get_info(const lmn_scene *scene, lmn_scene_info *out);

/* One number that can change: a dimension of the space of configurations. Variables that belong
 * together (the three channels of a colour, the box of a camera) share a group. */
typedef struct lmn_variable_info {
    const char *name;       /* "door", "wall.r", "camera.x" */
    const char *group;      /* "door", "wall", "camera" */
    const char *kind;       /* "camera", "translate", "rotate", "scale", "color", "float", "choice",
                               "visible", "envmap", "intensity" */
    const char *unit;       /* "deg", "m", ""; never NULL */
    double min, max, value; /* in scene units; value is the default */
    uint32_t n_choices;     /* > 0: a discrete variable with values 0 .. n_choices-1 */
    const char *const *choices; /* their names */
    const char *targets;        /* the parameter paths it drives, separated by spaces */
    const char *description;    /* of its group, for people; "" where there is none */
} lmn_variable_info;

LMN_API lmn_status lmn_scene_get_variable(const lmn_scene *scene, uint32_t index,
                                          lmn_variable_info *out);

/* One value of the scene, under a path as mi.traverse() would give: "door.to_world". */
typedef struct lmn_parameter_info {
    const char *path;
    const char *type;  /* "float", "rgb", "transform", "texture", "bool", ... */
    const char *value; /* as text */
} lmn_parameter_info;

LMN_API lmn_status lmn_scene_get_parameter(const lmn_scene *scene, uint32_t index,
                                           lmn_parameter_info *out);

/* Values of all variables, in scene units: an array of n_variables doubles in declaration order. */
LMN_API void lmn_scene_default_values(const lmn_scene *scene, double *values);

/* Applies "name=value" to values: scene units, "50%" of the range, a choice's name, or for a group
 * a comma-separated list. Unknown names and values out of range are errors with a suggestion. */
LMN_API lmn_status lmn_scene_parse_value(lmn_context *context, const lmn_scene *scene,
                                         const char *assignment, double *values);

/* A uniform draw from the space of configurations: the index-th of the stream `seed`. */
LMN_API void lmn_scene_random_values(const lmn_scene *scene, uint64_t seed, uint64_t index,
                                     double *values);

/* Where a picture is seen from; kind, film and lens stay those of the scene's camera. */
typedef struct lmn_camera {
    double origin[3], target[3], up[3]; /* scene units; up: any direction not along the view */
    double fov; /* degrees, along the axis that the scene gives; orthographic cameras: the width of
                   their film, scene units */
} lmn_camera;

/* The camera of a configuration. A scene says where it looks to, not how far: the target is as far
 * away as the middle of the scene, or as a lens is sharp. values NULL: the defaults. */
LMN_API lmn_status lmn_scene_get_camera(lmn_context *context, const lmn_scene *scene,
                                        const double *values, lmn_camera *out);

/* ---- Path tracing -------------------------------------------------------------------------- */

typedef struct lmn_trace_options {
    uint32_t struct_size;
    uint32_t width, height;                           /* 0: the scene's */
    uint32_t crop_x, crop_y, crop_width, crop_height; /* crop_width 0: everything */
    uint32_t spp;                                     /* 0: the scene's */
    uint32_t has_max_depth, has_rr_depth;             /* 0: the scene's */
    int32_t max_depth, rr_depth; /* as Mitsuba's `path`; max_depth -1: unlimited */
    uint64_t seed;
    uint32_t buffers; /* 1: append position, normals, albedo, roughness, ... channels */
    uint32_t
        half_buffers;    /* 1: append "a.R".. and "b.R"..: two independent halves of the samples */
    const char *sampler; /* NULL: "sobol", whatever the scene asks for; or "independent" */
    const char *mis;     /* NULL: "power"; or "balance" */
    /* "path"; "path+photons": caustics by photons, gathered within a radius that shrinks with spp
     * (biased by it, right in the limit), spp is then rounded up to even; "auto": photons where the
     * configuration holds caustics that paths hardly find. NULL: the scene's, else "auto". What was
     * used is the image's attribute "integrator". */
    const char *integrator;
    /* 1: append the light of each group of emitters, "NAME.R"... An emitter that the scene puts in
     * no group ("light_group") is one by itself, named as its parameters are. The sum over all, in
     * the order of channels, is colour exactly: weigh it and lights are dimmed and coloured without
     * tracing again. */
    uint32_t light_groups;
    /* The same with groups of one's own: "ceiling=lamp_1,lamp_2;outside=sky"; or NULL. */
    const char *light_group_names;
    /* 1: the buffers describe, behind perfect mirrors, smooth glass, null surfaces and the holes of
     * masks, the first other surface, to which each sample goes one way at random; seven
     * channels more: "chain_throughput.R".., the product of weights on the way,
     * "chain_emission.R".., what shines along it and on that surface, and "chain_length.Y", how
     * many surfaces are on it. A pixel's radiance is the mean of emission + throughput * what the
     * surface scatters. Only with `buffers`. */
    uint32_t follow_delta;
    /* 1: append the picture in two parts, "rest.R".. and "seen.R"..: light sources seen directly or
     * by mirrors and glass alone; with light groups each of them so, "NAME.rest.R".. and
     * "NAME.seen.R"... Colour is their sum exactly, in the order of channels. */
    uint32_t split_delta;
    const lmn_camera *camera; /* NULL: the configuration's */
    /* Even. Pictures of the samples from 0 on, from `spp` on, .. are parts of one with more: their
     * mean is what it shows. */
    uint32_t first_sample;
} lmn_trace_options;

/* Path-traces one configuration. values: n_variables doubles, NULL for the defaults. options may be
 * NULL. render_s, when not NULL, gets the seconds of rendering alone. */
LMN_API lmn_status lmn_scene_trace(lmn_context *context, const lmn_scene *scene,
                                   const double *values, const lmn_trace_options *options,
                                   lmn_image **out, double *render_s);

/* ---- Training ------------------------------------------------------------------------------ */

enum {
    LMN_METHOD_FAITHFUL = 0, /* the paper's network, exploration and replay */
    LMN_METHOD_IMPROVED = 1  /* a compact network on learnt grids, in the frames of what moves,
                                trained on scattered pixels of many configurations */
};

enum {
    LMN_EXPLORE_ACTIVE = 0,   /* Markov chains by loss x norm of the would-be Adam step; improved:
                                 uniform configurations, more pixels where light is focused */
    LMN_EXPLORE_UNIFORM = 1,  /* the paper's baseline: large steps only, all accepted; improved:
                                 uniform pixels of uniform configurations */
    LMN_EXPLORE_LOSS_ONLY = 2 /* the paper's ablation: target function without the Adam step; not
                                 of the improved method */
};

enum {
    LMN_INTEGRATOR_PATH = 0,    /* path tracing alone, as the paper: faithful's */
    LMN_INTEGRATOR_PHOTONS = 1, /* caustics by photons: "path+photons" of lmn_scene_trace() */
    LMN_INTEGRATOR_AUTO = 2     /* photons if some configuration wants them, for all then:
                                   improved's */
};

/* Ablations: parts of the improved method that can be left out. */
enum {
    LMN_WITHOUT_FRAMES = 1,    /* grids and features in the frames of what moves */
    LMN_WITHOUT_LIGHTS = 2,    /* where lights are, and what is on the way to them */
    LMN_WITHOUT_POWERS = 4,    /* variables of lights' powers are inputs like any other */
    LMN_WITHOUT_ALBEDO = 8,    /* radiance is not divided by albedo */
    LMN_WITHOUT_CUTS = 16,     /* light paths are traced to their ends */
    LMN_WITHOUT_HALVES = 32,   /* errors are relative to the prediction alone */
    LMN_WITHOUT_REPLAY = 64,   /* no pixel is learnt twice */
    LMN_WITHOUT_AVERAGE = 128, /* the weights shown are the last */
    LMN_WITHOUT_PHOTONS = 256, /* caustics by paths alone, whatever the integrator */
    LMN_WITHOUT_CHAINS = 512   /* mirrors and glass are surfaces like any other */
};

/* Fill with lmn_train_options_init(), which gives the paper's values, or for the improved method
 * with lmn_train_options_init_method(), then change what you need. The improved method takes seed,
 * width, depth, learning_rate, explore, memory_mib, resolution_max (of the pictures that pixels are
 * drawn from), spp, max_depth, rr_depth, integrator and without. */
typedef struct lmn_train_options {
    uint32_t struct_size;
    uint64_t seed;
    /* network (method: 8 hidden layers of 512) */
    uint32_t width,
        depth; /* features per layer; hidden layers besides the position layer and first */
    /* optimiser */
    double learning_rate; /* 1e-4 */
    uint32_t legacy_ssim; /* 1: the authors' SSIM axes */
    /* exploration */
    uint32_t explore;            /* LMN_EXPLORE_* */
    uint32_t n_chains;           /* 16 */
    double large_step;           /* probability, 0.3 */
    double step_min, step_max;   /* Kelemen's s1 = 1/25, s2 = 1/20 */
    uint32_t no_preconditioning; /* 1: position gets no layer of its own (Sec. 7.3) */
    /* sample reuse */
    uint32_t no_reuse;
    double reuse_bias;        /* beta of Eq. 5: 4.6 */
    double reuse_ema;         /* 0.9 */
    uint32_t reuse_warmup;    /* fresh batches before reuse may start: 100 */
    uint32_t reuse_batch;     /* patches per replayed batch: 16 */
    uint32_t replay_capacity; /* patches: 100000, less when memory_mib says so */
    uint32_t memory_mib;      /* bound of the replay memory: 1024 */
    /* resolution */
    uint32_t no_growth;
    uint32_t patch_size;       /* 32 */
    uint32_t resolution_start; /* 128 */
    uint32_t resolution_max;   /* 600 */
    uint32_t resolution_step;  /* 4 */
    uint32_t resolution_every; /* steps: 2000 */
    /* ground truth */
    uint32_t spp; /* 0: the scene's */
    uint32_t has_max_depth, has_rr_depth;
    int32_t max_depth, rr_depth;
    uint32_t integrator; /* LMN_INTEGRATOR_*, of training and of the references of tests */
    uint32_t method;     /* LMN_METHOD_* */
    uint32_t without;    /* sum of LMN_WITHOUT_*; improved only */
} lmn_train_options;

LMN_API void lmn_train_options_init(lmn_train_options *options);

/* The defaults of LMN_METHOD_*. */
LMN_API void lmn_train_options_init_method(lmn_train_options *options, uint32_t method);

/* "spp=4": sets an option by its name, with did-you-mean; flags and choices are numbers. */
LMN_API lmn_status lmn_train_options_set(lmn_context *context, lmn_train_options *options,
                                         const char *assignment);

/* The options, checked, as one JSON object: what models carry as config_json. *json belongs to the
 * context until its next call that gives JSON. */
LMN_API lmn_status lmn_train_options_json(lmn_context *context, const lmn_train_options *options,
                                          const char **json);

/* The scene must stay alive as long as the trainer. All memory is taken here. */
LMN_API lmn_status lmn_trainer_new(lmn_context *context, const lmn_scene *scene,
                                   const lmn_train_options *options, lmn_trainer **out);

/* Continues the training of a model that lmn_trainer_save() wrote, as if it had not stopped, from
 * the state beside it. Refuses a changed scene unless `force`, and another training's state. */
LMN_API lmn_status lmn_trainer_resume(lmn_context *context, const lmn_scene *scene,
                                      const char *path, int force, lmn_trainer **out);

/* Fine-tuning: gives a trainer of the improved method that has not made a step the weights of a
 * model of that method, of the same width and depth, trained on another version of the scene. They
 * are taken over by the names of what moves and of variables; what is new starts as ever, what is
 * gone is dropped. *report, when not NULL, gets lines that tell of each ("taken over: variable
 * door", "new: ...", "dropped: ..."), valid as long as the trainer. The model is not needed again.
 */
LMN_API lmn_status lmn_trainer_start_from(lmn_trainer *trainer, const char *path,
                                          const char **report);
LMN_API void lmn_trainer_free(lmn_trainer *trainer);

typedef struct lmn_train_stats {
    uint64_t step;                    /* optimiser steps so far */
    double loss;                      /* of the last batch */
    double loss_fresh, loss_replayed; /* averages of Eq. 5 */
    double reuse_probability;         /* p_s of Eq. 5 */
    double acceptance;                /* of proposals, running average */
    uint32_t resolution;              /* virtual resolution now */
    uint32_t fresh;                   /* 1: the last batch was traced, 0: replayed */
    uint32_t batch;                   /* patches in it; improved: configurations */
    uint64_t n_traced;                /* patches path-traced so far; improved: configurations */
    double cpu_s; /* processor time divided by threads, over all runs of this training */
    double trace_s, network_s; /* of it: path tracing, network */
    uint64_t memory_bytes;     /* the trainer's workspace, replay memory included */
} lmn_train_stats;

/* One optimiser step: traces or replays a batch, then trains on it. stats may be NULL. */
LMN_API lmn_status lmn_trainer_step(lmn_trainer *trainer, lmn_train_stats *stats);

/* Where the training stands, and what it was told: after resuming, what the file says. */
LMN_API void lmn_trainer_get_stats(const lmn_trainer *trainer, lmn_train_stats *out);
LMN_API void lmn_trainer_get_options(const lmn_trainer *trainer, lmn_train_options *out);

/* Where training looks now, at most `most` configurations, in values [most][n_variables]: the
 * chains' states, or of the improved method those that were traced last. Returns how many. */
LMN_API uint32_t lmn_trainer_get_states(const lmn_trainer *trainer, uint32_t most, double *values);

/* Writes the checkpoint, two files: at path + ".state" what resuming needs, then at path the model,
 * what rendering needs. Each is written to a temporary name, then renamed; what is there at any
 * moment can be resumed. */
LMN_API lmn_status lmn_trainer_save(lmn_trainer *trainer, const char *path);

/* Mean metrics of the network as it is now on the fixed test set of lmn_model_eval(). */
LMN_API lmn_status lmn_trainer_eval(lmn_trainer *trainer, uint32_t n, uint32_t resolution,
                                    uint32_t spp, uint64_t seed, lmn_metrics *out);

typedef struct lmn_render_options {
    uint32_t struct_size;
    uint32_t width, height;
    uint32_t crop_x, crop_y, crop_width, crop_height;
    uint32_t buffer_spp; /* samples per pixel, which smooth edges; 0: 16. The improved method's
                            network is asked for each, the paper's sees their mean buffers */
    uint32_t buffers;    /* 1: append them to the image */
    uint64_t seed;
    const lmn_camera *camera; /* NULL: the configuration's */
    uint32_t first_sample;    /* as in lmn_trace_options; may be odd */
} lmn_render_options;

/* Renders one configuration by the network as it is now; as lmn_model_render(), and not counted as
 * training. */
LMN_API lmn_status lmn_trainer_render(lmn_trainer *trainer, const double *values,
                                      const lmn_render_options *options, lmn_image **out,
                                      double *render_s);

/* The JSON text of one line of metrics.jsonl: before this trainer's first step the line that
 * describes the run, then the step just made. Valid until the next call; NULL when memory is
 * short. */
LMN_API const char *lmn_trainer_metrics_line(lmn_trainer *trainer);

/* ---- Models -------------------------------------------------------------------------------- */

/* Loads a trained model. `scene` is the scene it was trained on; a changed one is refused unless
 * `force`. The scene must stay alive as long as the model. */
LMN_API lmn_status lmn_model_load(lmn_context *context, const lmn_scene *scene, const char *path,
                                  int force, lmn_model **out);
LMN_API void lmn_model_free(lmn_model *model);

/* What a model file says of itself; needs no scene. Free the strings with lmn_model_info_free(). */
typedef struct lmn_model_info {
    char *scene_path;     /* as given when training */
    char *variables_path; /* "" when the default was used */
    char *config_json;    /* the training options */
    char **defines;       /* n_defines strings "name=value" */
    uint32_t n_defines;
    uint64_t scene_hash, step, n_weights;
    uint32_t method, width, depth; /* of the options */
    double cpu_s;
} lmn_model_info;

LMN_API lmn_status lmn_model_read_info(lmn_context *context, const char *path, lmn_model_info *out);
LMN_API void lmn_model_info_free(lmn_model_info *info);

/* Renders one configuration by the network. values as in lmn_scene_trace(). */
LMN_API lmn_status lmn_model_render(lmn_context *context, const lmn_model *model,
                                    const double *values, const lmn_render_options *options,
                                    lmn_image **out, double *render_s);

/* Seconds of the last picture of the improved method's network: tracing its buffers, and all that
 * the network does; 0 for the paper's. */
LMN_API void lmn_model_get_times(const lmn_model *model, double *buffers_s, double *network_s);

typedef struct lmn_eval_options {
    uint32_t struct_size;
    uint32_t n;          /* configurations, drawn uniformly; 0: 16 */
    uint32_t resolution; /* of the longer side; 0: 128 */
    uint32_t spp;        /* of the path-traced references; 0: 1024 */
    uint64_t seed;
} lmn_eval_options;

typedef struct lmn_eval_result {
    lmn_metrics mean;        /* of the network against the references */
    lmn_metrics noise;       /* of the references' two halves against each other: the noise floor */
    double frame_s, trace_s; /* median seconds of a neural frame and of a reference */
} lmn_eval_result;

/* Renders and traces the fixed seeded test set and compares. If sheet is not NULL, *sheet gets the
 * contact sheet: a row per configuration, neural | path traced | FLIP, with figures. `each`, when
 * not NULL, gets n metrics. */
LMN_API lmn_status lmn_model_eval(lmn_context *context, const lmn_model *model,
                                  const lmn_eval_options *options, lmn_eval_result *out,
                                  lmn_metrics *each, lmn_image **sheet);

/* ---- Small services ------------------------------------------------------------------------ */

/* Draws a run's metrics.jsonl (or a model's history) as SVG: loss, acceptance, reuse, error, and
 * where the chains were. Several are compared over seconds of training: errors, loss, the share of
 * replayed batches. paths: n_paths >= 1. */
LMN_API lmn_status lmn_plot(lmn_context *context, const char *const *paths, uint32_t n_paths,
                            const char *svg_path);

/* Draws what `lumenaut bench learn` wrote to results.json of one of its scenes, by name: errors
 * over time, a panel per metric and test set. */
LMN_API lmn_status lmn_plot_learning(lmn_context *context, const char *results_path,
                                     const char *scene, const char *svg_path);

/* Measures and describes in JSON: what = "kernels", "trace", "train", "buffers" or "frame".
 * options_json is documented in lumenaut-bench(1). *json belongs to the context until the next
 * call. */
LMN_API lmn_status lmn_bench(lmn_context *context, const char *what, const char *options_json,
                             const char **json);

#ifdef __cplusplus
}
#endif

#endif
