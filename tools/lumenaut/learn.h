/* SPDX-License-Identifier: Apache-2.0 */
#ifndef LEARN_H
#define LEARN_H

#include "cli_options.h"

/*
 * lumenaut bench learn: trains several methods on several scenes, with several seeds, measures them
 * on the way against test sets made beforehand, and says which learns faster. Everything is kept in
 * files; the same command goes on after any interruption, kill -9 included.
 *
 *   TESTS/SCENE-HASH/hard-PROBE-N.json       which configurations are hard (learn_hard.c)
 *   TESTS/SCENE-HASH/SIZE-SPP-HOW/X-I.exr    references, two halves each (learn_tests.c)
 *   OUT/SCENE-METHOD-SEED.lmn, .lmn.state, .metrics.jsonl   the training (learn_train.c)
 *   OUT/SCENE-METHOD-SEED.jsonl              a line of what is measured, then one per evaluation
 *   OUT/SCENE.svg, OUT/SCENE-sheet.png       curves, and pictures (learn_sheet.c)
 *   OUT/results.json, OUT/table.txt          all of it, with a summary (learn_results.c)
 *
 * Functions that return int give an exit code, after saying why it is not EXIT_OK.
 */

struct learn_args {
    const char *methods;
    double minutes; /* processor time / threads of each training; 0: steps */
    uint64_t steps;
    uint32_t seeds, width_faithful;
    const char *out, *tests; /* folders; tests NULL: OUT/tests */
    uint32_t n, n_candidates, resolution, reference_spp;
    uint32_t integrator; /* of the references: path, path+photons, auto */
    struct arg_interval probe;
};
enum { N_LEARN_OPTIONS = 13 };
extern const struct arg_option learn_options[N_LEARN_OPTIONS];
void learn_args_init(struct learn_args *a);

/* The command; checks the arguments first. */
int learn_bench(struct app *app, const struct learn_args *a, const struct scene_args *scene_args,
                char *const *paths, uint32_t n_paths, bool as_json);

enum {
    LEARN_PATH = 4096,
    LEARN_NAME = 128,
    LEARN_RULE = 64,
    LEARN_MAX_METHODS = 32,
    LEARN_MAX_SEEDS = 16
};

/* ---- Methods (learn_methods.c) ------------------------------------------------------------ */

struct learn_method {
    char label[LEARN_NAME]; /* as the user wrote it */
    char file[LEARN_NAME];  /* the same, fit for names of files */
    lmn_train_options options;
};

/* "faithful:64,uniform,improved:spp=4:memory_mib=64": a number is the width. out
 * [LEARN_MAX_METHODS]. */
int learn_parse_methods(struct app *app, const struct learn_args *a, struct learn_method *out,
                        uint32_t *n);

/* The improved network on uniform draws: a method, and what the hard set is chosen by. */
void learn_uniform_options(lmn_train_options *o);

/* ---- Test sets ---------------------------------------------------------------------------- */

enum learn_set_kind { LEARN_UNIFORM, LEARN_HARD, N_LEARN_SETS };
extern const char *const learn_set_names[N_LEARN_SETS]; /* "uniform", "hard" */

struct learn_set {
    uint32_t n;
    double *values;         /* [n][n_variables], in scene units; owned, as all below */
    lmn_image **references; /* [n], R G B */
    lmn_metrics noise;      /* of the references themselves, as lumenaut eval has it */
};

struct learn_tests {
    char folder[LEARN_PATH];
    char rule[LEARN_RULE]; /* what the hard set was chosen by */
    uint32_t width, height, n_variables;
    struct learn_set sets[N_LEARN_SETS];
};

/* Makes what is missing of the test sets of a scene, and loads them. */
int learn_tests_open(struct learn_tests *t, struct app *app, const struct learn_args *a,
                     const lmn_scene *scene, const char *scene_name);
void learn_tests_release(struct learn_tests *t);

/* Seeds that no training has: of uniform test configurations, and of candidates for hard ones. */
#define LEARN_SEED_UNIFORM   0x6c6561726e2d7531u
#define LEARN_SEED_CANDIDATE 0x6c6561726e2d6833u

/* The n candidates (indices of lmn_scene_random_values() of LEARN_SEED_CANDIDATE) where a network
 * trained for a short while on uniform draws is worst, worst first. Kept in `folder`; rule: what
 * they depend on, in short. */
int learn_choose_hard(struct app *app, const struct learn_args *a, const lmn_scene *scene,
                      const char *folder, char rule[LEARN_RULE], uint32_t *indices, uint32_t n);

/* The size of pictures of a scene whose longer side has so many pixels. */
void learn_picture_size(const lmn_scene *scene, uint32_t longer, uint32_t size[2]);

/* Traces one configuration with two half-buffers. */
lmn_status learn_trace(struct app *app, const lmn_scene *scene, const double *values,
                       const uint32_t size[2], uint32_t spp, uint64_t seed, const char *integrator,
                       lmn_image **out);

/* Copies three channels, "a." and R, G, B for instance, to out [n_pixels][3]; false when one is
 * missing. */
bool learn_read_channels(lmn_image *image, const char *prefix, float *out);

/* ---- Training (learn_train.c) -------------------------------------------------------------- */

struct learn_job {
    struct app *app;
    const lmn_scene *scene;
    const char *scene_name;
    const struct learn_method *method;
    const struct learn_tests *tests;
    uint64_t seed;
    double minutes;
    uint64_t steps;
    char base[LEARN_PATH]; /* OUT/SCENE-METHOD-SEED */
};

/* Trains and measures, from where an earlier run of the same job stopped. */
int learn_train(const struct learn_job *job);

/* ---- Results (learn_results.c) -------------------------------------------------------------- */

enum { LEARN_MAPE, LEARN_RELMSE, LEARN_FLIP, N_LEARN_METRICS };

/* What the JSON text says after "key":, from `from` on; NAN without it. */
double learn_number(const char *from, const char *key);

/* What marks the last line of a training that came apart. */
#define LEARN_FAILED "\"failed\":"

/* One evaluation. */
struct learn_point {
    char *line; /* of the file; owned */
    double step, cpu_s, error[N_LEARN_SETS][N_LEARN_METRICS];
};

struct learn_curve {
    struct learn_point *points; /* owned */
    uint32_t n;
    char *failure; /* the line of a training that came apart after them, or NULL; owned */
};

/* Reads the evaluations up to the first at or after the end of the job; fewer when it is not
 * finished. */
int learn_curve_read(struct learn_curve *c, const struct learn_job *job);
void learn_curve_release(struct learn_curve *c);

/* Everything about one scene. */
struct learn_scene {
    const char *path;
    char name[LEARN_NAME];
    lmn_scene *scene;
    struct learn_tests tests;
    struct learn_curve
        curves[LEARN_MAX_METHODS * LEARN_MAX_SEEDS]; /* [method * seeds + seed - 1] */
    bool has_curves;
};

struct learn_results {
    struct app *app;
    const struct learn_args *args;
    const struct learn_method *methods;
    uint32_t n_methods;
    struct learn_scene *scenes;
    uint32_t n_scenes;
};

/* For programs, and for people; of all that is there so far. */
void learn_results_write(const struct learn_results *r, FILE *f);
void learn_results_print(const struct learn_results *r, FILE *f);

/* Both, as OUT/results.json and OUT/table.txt. */
int learn_results_save(const struct learn_results *r);

/* OUT/SCENE-sheet.png: some uniform and the hardest configurations, traced and by each method's
 * network of seed 1, with FLIP maps (learn_sheet.c). All trainings of the scene are finished. */
int learn_sheet_save(const struct learn_results *r, const struct learn_scene *scene);

/* ---- Files ---------------------------------------------------------------------------------- */

/* Makes a folder and those above it. */
int learn_make_folder(struct app *app, const char *path);

/* Keeps other processes out of a folder until *lock is closed or the process ends. */
int learn_lock(struct app *app, const char *folder, int *lock);

/* Writes a whole text so that others see the old or the new one. */
int learn_save_text(struct app *app, const char *path, const char *text, size_t size);

/* The whole text of a file, free() it; NULL when it cannot be read. */
char *learn_load_text(const char *path);

/* snprintf() into a path; what does not fit is cut, which opening the file then reports. */
__attribute__((format(printf, 2, 3))) void learn_path(char out[LEARN_PATH], const char *format,
                                                      ...);

#endif
