/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut bench learn: its options, and the order of its work. */
#include "learn.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const struct arg_option learn_options[N_LEARN_OPTIONS] = {
    {.name = "methods",
     .type = ARG_TEXT,
     .argument = "LIST",
     .help = "methods by commas: faithful, uniform, improved; options of training after colons, a "
             "number alone is the width: faithful:64,improved:spp=4",
     .offset = offsetof(struct learn_args, methods)},
    {.name = "minutes",
     .type = ARG_NUMBER,
     .argument = "N",
     .help = "processor time, divided by threads, of each training",
     .min = 0.001,
     .max = 100000,
     .offset = offsetof(struct learn_args, minutes)},
    {.name = "steps",
     .type = ARG_WHOLE,
     .argument = "N",
     .help = "its steps instead",
     .fallback = "none",
     .offset = offsetof(struct learn_args, steps)},
    {.name = "seeds",
     .type = ARG_COUNT,
     .argument = "K",
     .help = "trainings of each method, with the seeds 1 to K",
     .min = 1,
     .max = LEARN_MAX_SEEDS,
     .offset = offsetof(struct learn_args, seeds)},
    {.name = "out",
     .type = ARG_FILE,
     .argument = "DIR",
     .help = "the folder of results; the same command goes on with what is there",
     .offset = offsetof(struct learn_args, out)},
    {.name = "tests",
     .type = ARG_FILE,
     .argument = "DIR",
     .help = "the folder of test sets, which several experiments can share",
     .fallback = "tests in the folder of results",
     .offset = offsetof(struct learn_args, tests)},
    {.name = "width-faithful",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "features per layer of faithful where the list says none",
     .min = 1,
     .max = 1024,
     .offset = offsetof(struct learn_args, width_faithful)},
    {.name = "configurations",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "configurations of each of the two test sets",
     .min = 1,
     .max = 4096,
     .offset = offsetof(struct learn_args, n)},
    {.name = "candidates",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "configurations that the hard ones are chosen from",
     .min = 1,
     .max = 65536,
     .offset = offsetof(struct learn_args, n_candidates)},
    {.name = "probe",
     .type = ARG_INTERVAL,
     .argument = "EVERY",
     .help = "how long the network is trained that they are chosen by",
     .fallback = "2m; with --steps a quarter of them",
     .offset = offsetof(struct learn_args, probe)},
    {.name = "resolution",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "pixels of the longer side of test pictures",
     .min = 11,
     .max = 4096,
     .offset = offsetof(struct learn_args, resolution)},
    {.name = "reference-spp",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "samples per pixel of references",
     .min = 2,
     .max = 1 << 20,
     .offset = offsetof(struct learn_args, reference_spp)},
    {.name = "integrator",
     .type = ARG_CHOICE,
     .argument = "NAME",
     .help = "how references are traced",
     .choices = "path path+photons auto",
     .offset = offsetof(struct learn_args, integrator)},
};

void learn_args_init(struct learn_args *a)
{
    a->methods = "faithful,uniform,improved";
    a->minutes = 10.0;
    a->seeds = 3;
    a->width_faithful = 128;
    a->n = 64;
    a->n_candidates = 512;
    a->resolution = 128;
    a->reference_spp = 4096;
}

static int check(struct app *app, struct learn_args *a, const struct scene_args *scene_args,
                 uint32_t n_paths)
{
    if (!a->out) return app_error(app, EXIT_USAGE, "no folder for results: give --out DIR");
    if (n_paths == 0) return app_error(app, EXIT_USAGE, "bench learn: no scene");
    if (n_paths > 1 && scene_args->variables)
        return app_error(app, EXIT_USAGE, "--variables: for one scene only");
    if (a->n > a->n_candidates)
        return app_error(app, EXIT_USAGE, "--candidates %u: fewer than --configurations %u",
                         a->n_candidates, a->n);
    if (a->probe.steps == 0 && !(a->probe.seconds > 0.0)) {
        if (a->steps)
            a->probe.steps = (a->steps + 3) / 4;
        else
            a->probe.seconds = 120.0;
    }
    return EXIT_OK;
}

static struct learn_job make_job(const struct learn_results *r, const struct learn_scene *s,
                                 uint32_t method, uint64_t seed)
{
    struct learn_job job = {.app = r->app,
                            .scene = s->scene,
                            .scene_name = s->name,
                            .method = &r->methods[method],
                            .tests = &s->tests,
                            .seed = seed,
                            .minutes = r->args->minutes,
                            .steps = r->args->steps};
    learn_path(job.base, "%s/%s-%s-%llu", r->args->out, s->name, job.method->file,
               (unsigned long long)seed);
    return job;
}

/* OUT/SCENE.svg, from OUT/results.json */
static int save_curves(const struct learn_results *r, const struct learn_scene *s)
{
    char results[LEARN_PATH], svg[LEARN_PATH];
    learn_path(results, "%s/results.json", r->args->out);
    learn_path(svg, "%s/%s.svg", r->args->out, s->name);
    const lmn_status status = lmn_plot_learning(r->app->context, results, s->name, svg);
    return status == LMN_OK ? EXIT_OK : app_failed(r->app, status, BLAME_WORK);
}

/* All trainings of a scene, seed by seed, so that methods can be compared before all is done. */
static int run_scene(struct learn_results *r, struct learn_scene *s)
{
    int code = EXIT_OK;
    for (uint32_t i = 0; code == EXIT_OK && i < r->args->seeds; i++) {
        for (uint32_t m = 0; code == EXIT_OK && m < r->n_methods; m++) {
            const struct learn_job job = make_job(r, s, m, i + 1);
            code = learn_train(&job);
            if (code == EXIT_OK) code = learn_curve_read(&s->curves[m * r->args->seeds + i], &job);
            s->has_curves = true;
            if (code == EXIT_OK) code = learn_results_save(r);
            if (code == EXIT_OK) code = save_curves(r, s);
        }
    }
    if (code == EXIT_OK) code = learn_sheet_save(r, s);
    return code;
}

static int open_scenes(struct learn_results *r, const struct scene_args *scene_args,
                       char *const *paths)
{
    int code = EXIT_OK;
    for (uint32_t i = 0; code == EXIT_OK && i < r->n_scenes; i++) {
        struct learn_scene *s = &r->scenes[i];
        s->path = paths[i];
        scene_name(paths[i], s->name, sizeof s->name);
        for (uint32_t k = 0; k < i && code == EXIT_OK; k++)
            if (strcmp(r->scenes[k].name, s->name) == 0)
                code = app_error(r->app, EXIT_USAGE, "%s and %s: both scenes would be called %s",
                                 r->scenes[k].path, s->path, s->name);
        if (code == EXIT_OK) code = load_scene(r->app, paths[i], scene_args, &s->scene);
    }
    return code;
}

static void announce(const struct learn_results *r)
{
    const struct learn_args *a = r->args;
    const uint32_t n = r->n_scenes * r->n_methods * a->seeds;
    if (a->steps)
        app_say(r->app, "%u trainings of %llu steps", n, (unsigned long long)a->steps);
    else
        app_say(r->app, "%u trainings of %g minutes, %.3g h, besides tests", n, a->minutes,
                n * a->minutes / 60.0);
}

int learn_bench(struct app *app, const struct learn_args *args, const struct scene_args *scene_args,
                char *const *paths, uint32_t n_paths, bool as_json)
{
    struct learn_args a = *args;
    struct learn_method *methods = calloc(LEARN_MAX_METHODS, sizeof *methods);
    struct learn_results r = {.app = app, .args = &a, .methods = methods, .n_scenes = n_paths};
    int lock = -1;
    r.scenes = calloc(n_paths + 1u, sizeof *r.scenes);
    int code = methods && r.scenes ? check(app, &a, scene_args, n_paths)
                                   : app_error(app, EXIT_FAILED, "out of memory");
    if (code == EXIT_OK) code = learn_parse_methods(app, &a, methods, &r.n_methods);
    if (code == EXIT_OK) code = open_scenes(&r, scene_args, paths);
    if (code == EXIT_OK) code = learn_make_folder(app, a.out);
    if (code == EXIT_OK) code = learn_lock(app, a.out, &lock);
    if (code == EXIT_OK) announce(&r);
    for (uint32_t i = 0; code == EXIT_OK && i < n_paths; i++)
        code = learn_tests_open(&r.scenes[i].tests, app, &a, r.scenes[i].scene, r.scenes[i].name);
    for (uint32_t i = 0; code == EXIT_OK && i < n_paths; i++) code = run_scene(&r, &r.scenes[i]);
    if (code == EXIT_OK && as_json) learn_results_write(&r, stdout);
    if (code == EXIT_OK && !as_json) learn_results_print(&r, stdout);
    for (uint32_t i = 0; r.scenes && i < n_paths; i++) {
        struct learn_scene *s = &r.scenes[i];
        for (size_t k = 0; k < COUNT_OF(s->curves); k++) learn_curve_release(&s->curves[k]);
        learn_tests_release(&s->tests);
        lmn_scene_free(s->scene);
    }
    free(r.scenes);
    free(methods);
    if (lock >= 0) close(lock);
    return code;
}
