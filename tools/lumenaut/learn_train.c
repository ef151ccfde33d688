/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One training of bench learn, measured on the way.
 *
 * What is due at a step happens in this order: the checkpoint, the evaluation, its line in the file
 * of results. So a process may die anywhere: when it starts again at the checkpoint, the lines tell
 * whether the evaluation there was made.
 */
#include "learn.h"
#include "train_log.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Between evaluations a checkpoint is made so often. */
static const double save_every_s = 120.0;

struct training {
    const struct learn_job *job;
    struct app *app;
    lmn_trainer *trainer;
    lmn_train_stats stats;
    struct train_log log;
    char *header; /* the first line of the file of results, newline included */
    char model[LEARN_PATH], state[LEARN_PATH], path[LEARN_PATH];
    bool has_failed;
    double measured; /* position() of the last evaluation; 0: none */
    double saved_clock_s;
};

/* ---- When ----------------------------------------------------------------------------------- */

static double end_of(const struct learn_job *job)
{
    return job->steps ? (double)job->steps : 60.0 * job->minutes;
}

static double position(const struct learn_job *job, const lmn_train_stats *stats)
{
    return job->steps ? (double)stats->step : stats->cpu_s;
}

/* The next evaluation after one at `last`: powers of two of steps, or times that look even on a
 * logarithmic axis; and at the end. */
static double next_due(const struct learn_job *job, double last)
{
    static const double times[] = {5, 10, 15, 30, 60, 120, 180, 300, 420, 600, 900, 1200};
    const double end = end_of(job);
    double due = job->steps ? 1.0 : times[0];
    for (size_t i = 0; due <= last; i++) {
        if (job->steps)
            due *= 2.0;
        else
            due = i + 1 < COUNT_OF(times) ? times[i + 1] : 1.5 * due;
    }
    return due < end ? due : end;
}

/* ---- The file of results -------------------------------------------------------------------- */

/* What must be the same for a run to go on. */
static int make_header(struct training *t)
{
    const struct learn_job *job = t->job;
    lmn_train_options options = job->method->options;
    lmn_scene_info info;
    char hash[24];
    const char *json;
    size_t size = 0;
    options.seed = job->seed;
    const lmn_status status = lmn_train_options_json(t->app->context, &options, &json);
    if (status != LMN_OK) return app_failed(t->app, status, BLAME_USER);
    FILE *f = open_memstream(&t->header, &size);
    if (!f) return app_error(t->app, EXIT_FAILED, "out of memory");
    lmn_scene_get_info(job->scene, &info);
    snprintf(hash, sizeof hash, "%016llx", (unsigned long long)info.hash);
    struct json_out j = {.f = f};
    jo_object(&j, NULL);
    jo_string(&j, "scene", job->scene_name);
    jo_string(&j, "scene_hash", hash);
    jo_string(&j, "method", job->method->label);
    jo_count(&j, "seed", job->seed);
    jo_string(&j, "tests", strrchr(job->tests->folder, '/') + 1);
    jo_string(&j, "hard", job->tests->rule);
    jo_count(&j, "n", job->tests->sets[LEARN_UNIFORM].n);
    jo_raw(&j, "options", json);
    jo_end(&j);
    return fclose(f) == 0 ? EXIT_OK : app_error(t->app, EXIT_FAILED, "out of memory");
}

/* Compares what is there with the header. *last: the step of its last whole line. */
static int check_lines(struct training *t, const char *text, bool *is_usable)
{
    const size_t n = strlen(t->header);
    *is_usable = false;
    if (!text || !strchr(text, '\n')) return EXIT_OK;
    *is_usable = strncmp(text, t->header, n) == 0;
    if (*is_usable) return EXIT_OK;
    return app_error(t->app, EXIT_USAGE,
                     "%s: of another experiment: scene, test sets or options of the method have "
                     "changed; remove %s.* or choose another --out",
                     t->path, t->job->base);
}

/* Cuts off lines of steps after the checkpoint and what is no whole line; finds when the last
 * evaluation was. */
static int cut_lines(struct training *t, const char *text)
{
    size_t kept = strlen(t->header);
    for (const char *line = text + kept, *end; (end = strchr(line, '\n')); line = end + 1) {
        const double step = learn_number(line, "step"), cpu_s = learn_number(line, "cpu_s");
        if (!(step <= (double)t->stats.step) || !isfinite(cpu_s)) break;
        t->measured = t->job->steps ? step : cpu_s;
        kept = (size_t)(end + 1 - text);
    }
    if (truncate(t->path, (off_t)kept) == 0) return EXIT_OK;
    return app_error(t->app, EXIT_FAILED, "%s: %s", t->path, strerror(errno));
}

static int append_line(struct training *t, const char *line, size_t size)
{
    FILE *f = fopen(t->path, "a");
    bool is_good = f && fwrite(line, 1, size, f) == size && fflush(f) == 0 && fsync(fileno(f)) == 0;
    if (f && fclose(f) != 0) is_good = false;
    if (is_good) return EXIT_OK;
    return app_error(t->app, EXIT_FAILED, "%s: cannot write: %s", t->path, strerror(errno));
}

/* ---- Evaluation ----------------------------------------------------------------------------- */

static lmn_status render_set(struct training *t, const struct learn_set *set, lmn_image **frames)
{
    const struct learn_tests *tests = t->job->tests;
    const lmn_render_options o = {
        .struct_size = sizeof o, .width = tests->width, .height = tests->height};
    lmn_status status = LMN_OK;
    for (uint32_t i = 0; i < set->n && status == LMN_OK; i++) {
        const double *values = set->values + (size_t)i * tests->n_variables;
        status = lmn_trainer_render(t->trainer, values, &o, &frames[i], NULL);
        if (status == LMN_OK && app_signal()) status = LMN_ERR_CANCELLED;
    }
    return status;
}

static lmn_status measure_set(struct training *t, const struct learn_set *set, lmn_metrics *mean,
                              lmn_metrics *each)
{
    lmn_image **frames = calloc(set->n, sizeof *frames);
    double *sum = (double *)mean;
    *mean = (lmn_metrics){0};
    lmn_status status = frames ? render_set(t, set, frames) : LMN_ERR_MEMORY;
    if (status == LMN_OK)
        status = lmn_image_compare_all(t->app->context, set->n, (const lmn_image *const *)frames,
                                       (const lmn_image *const *)set->references, each);
    for (uint32_t i = 0; frames && i < set->n; i++) {
        const double *from = (const double *)&each[i];
        for (size_t k = 0; k < sizeof *mean / sizeof *sum; k++) sum[k] += from[k] / set->n;
        lmn_image_free(frames[i]);
    }
    free(frames);
    return status;
}

/* "mape":[0.1,...] with four digits, enough to see where errors lie. */
static void write_each(struct json_out *j, const char *key, const lmn_metrics *each, uint32_t n,
                       size_t offset)
{
    char text[32];
    jo_array(j, key);
    for (uint32_t i = 0; i < n; i++) {
        double value;
        memcpy(&value, (const char *)&each[i] + offset, sizeof value);
        snprintf(text, sizeof text, "%.4g", value);
        jo_raw(j, NULL, isfinite(value) ? text : "null");
    }
    jo_end(j);
}

/* A training that came apart has failed for good, and that is a result; the others go on. */
static int give_up(struct training *t)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f) return app_error(t->app, EXIT_FAILED, "out of memory");
    struct json_out j = {.f = f};
    jo_object(&j, NULL);
    jo_count(&j, "step", t->stats.step);
    jo_number(&j, "cpu_s", t->stats.cpu_s);
    jo_string(&j, "failed", lmn_context_message(t->app->context));
    jo_end(&j);
    int code = fclose(f) == 0 ? EXIT_OK : app_error(t->app, EXIT_FAILED, "out of memory");
    app_say(t->app, "%s seed %llu: %s", t->job->method->label, (unsigned long long)t->job->seed,
            lmn_context_message(t->app->context));
    if (code == EXIT_OK) code = append_line(t, text, size);
    free(text);
    t->has_failed = true;
    return code;
}

/* The line of an evaluation. */
static int record(struct training *t, const lmn_metrics *means, const lmn_metrics *each)
{
    const lmn_train_stats *s = &t->stats;
    const uint32_t n = t->job->tests->sets[LEARN_UNIFORM].n;
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f) return app_error(t->app, EXIT_FAILED, "out of memory");
    struct json_out j = {.f = f};
    jo_object(&j, NULL);
    jo_count(&j, "step", s->step);
    jo_number(&j, "cpu_s", s->cpu_s);
    jo_number(&j, "trace_s", s->trace_s);
    jo_number(&j, "network_s", s->network_s);
    jo_count(&j, "traced", s->n_traced);
    for (int k = 0; k < N_LEARN_SETS; k++) jo_metrics(&j, learn_set_names[k], &means[k]);
    jo_object(&j, "each");
    for (int k = 0; k < N_LEARN_SETS; k++) {
        const lmn_metrics *of = each + (size_t)k * n;
        jo_object(&j, learn_set_names[k]);
        write_each(&j, "mape", of, n, offsetof(lmn_metrics, mape));
        write_each(&j, "relmse", of, n, offsetof(lmn_metrics, relmse));
        write_each(&j, "flip", of, n, offsetof(lmn_metrics, flip));
        jo_end(&j);
    }
    jo_end(&j);
    jo_end(&j);
    int code = fclose(f) == 0 ? EXIT_OK : app_error(t->app, EXIT_FAILED, "out of memory");
    if (code == EXIT_OK) code = append_line(t, text, size);
    if (code == EXIT_OK)
        app_say(t->app, "%s seed %llu, step %llu, %.1f s: MAPE %.4f and %.4f (hard)",
                t->job->method->label, (unsigned long long)t->job->seed,
                (unsigned long long)s->step, s->cpu_s, means[LEARN_UNIFORM].mape,
                means[LEARN_HARD].mape);
    free(text);
    return code;
}

static int measure(struct training *t)
{
    const uint32_t n = t->job->tests->sets[LEARN_UNIFORM].n;
    lmn_metrics means[N_LEARN_SETS], *each = calloc(n * (size_t)N_LEARN_SETS, sizeof *each);
    lmn_status status = each ? LMN_OK : LMN_ERR_MEMORY;
    int code;
    t->app->is_silent = true;
    for (int k = 0; k < N_LEARN_SETS && status == LMN_OK; k++)
        status = measure_set(t, &t->job->tests->sets[k], &means[k], each + (size_t)k * n);
    t->app->is_silent = false;
    if (status == LMN_OK)
        code = record(t, means, each);
    else if (status == LMN_ERR_ARGUMENT) /* pictures that are not finite */
        code = give_up(t);
    else if (status == LMN_ERR_MEMORY)
        code = app_error(t->app, EXIT_FAILED, "out of memory");
    else
        code = app_failed(t->app, status, BLAME_WORK);
    t->measured = position(t->job, &t->stats);
    free(each);
    return code;
}

/* ---- Training ------------------------------------------------------------------------------- */

static int save(struct training *t)
{
    t->saved_clock_s = clock_s();
    if (!train_log_flush(&t->log))
        return app_error(t->app, EXIT_FAILED, "%s: cannot write: %s", t->log.path, strerror(errno));
    const lmn_status status = lmn_trainer_save(t->trainer, t->model);
    return status == LMN_OK ? EXIT_OK : app_failed(t->app, status, BLAME_WORK);
}

/* The trainer, from its checkpoint where there is one, and both files brought in line with it. */
static int begin(struct training *t, const char *text)
{
    const struct learn_job *job = t->job;
    lmn_train_options options = job->method->options;
    bool needs_header;
    const bool resumes = text && access(t->state, R_OK) == 0;
    options.seed = job->seed;
    if (!resumes) { /* what is there is not of this training */
        unlink(t->state);
        unlink(t->model);
    }
    const lmn_status status =
        resumes ? lmn_trainer_resume(t->app->context, job->scene, t->model, 0, &t->trainer)
                : lmn_trainer_new(t->app->context, job->scene, &options, &t->trainer);
    if (status != LMN_OK) return app_failed(t->app, status, resumes ? BLAME_INPUT : BLAME_USER);
    lmn_trainer_get_stats(t->trainer, &t->stats);
    int code = resumes ? cut_lines(t, text)
                       : learn_save_text(t->app, t->path, t->header, strlen(t->header));
    if (code != EXIT_OK) return code;
    code = train_log_open(&t->log, t->app, t->model, t->stats.step, !resumes, &needs_header);
    if (code != EXIT_OK) return code;
    const char *header = lmn_trainer_metrics_line(t->trainer);
    if (!header) return app_error(t->app, EXIT_FAILED, "out of memory");
    if (needs_header) train_log_add(&t->log, header);
    t->saved_clock_s = clock_s();
    return EXIT_OK;
}

static int step(struct training *t)
{
    char text[96];
    if (lmn_trainer_step(t->trainer, &t->stats) != LMN_OK) return give_up(t);
    const char *line = lmn_trainer_metrics_line(t->trainer);
    if (!line) return app_error(t->app, EXIT_FAILED, "out of memory");
    train_log_add(&t->log, line);
    snprintf(text, sizeof text, "step %llu  loss %.4f", (unsigned long long)t->stats.step,
             t->stats.loss);
    progress_update(&t->app->progress, position(t->job, &t->stats) / end_of(t->job),
                    (double)t->stats.step, text, NULL);
    return EXIT_OK;
}

static int loop(struct training *t)
{
    const struct learn_job *job = t->job;
    int code = EXIT_OK;
    while (code == EXIT_OK && !t->has_failed && t->measured < end_of(job)) {
        const bool is_due = position(job, &t->stats) >= next_due(job, t->measured);
        if (app_signal()) {
            code = save(t);
            return code == EXIT_OK ? app_failed(t->app, LMN_ERR_CANCELLED, BLAME_WORK) : code;
        }
        if (!is_due) code = step(t);
        if (t->has_failed) break;
        const bool is_now_due = position(job, &t->stats) >= next_due(job, t->measured);
        if (code == EXIT_OK && !is_due &&
            (is_now_due || clock_s() - t->saved_clock_s > save_every_s))
            code = save(t);
        if (code == EXIT_OK && is_now_due) code = measure(t);
    }
    return code;
}

static bool is_finished(const struct learn_job *job, const char *text)
{
    double last = 0.0;
    if (strstr(text, LEARN_FAILED)) return true;
    for (const char *line = text, *end; (end = strchr(line, '\n')); line = end + 1) {
        const double at = learn_number(line, job->steps ? "step" : "cpu_s");
        if (at > last) last = at;
    }
    return last >= end_of(job);
}

int learn_train(const struct learn_job *job)
{
    struct training t = {.job = job, .app = job->app};
    char phase[LEARN_NAME + 32];
    bool is_usable = false;
    learn_path(t.model, "%s.lmn", job->base);
    learn_path(t.state, "%s.lmn.state", job->base);
    learn_path(t.path, "%s.jsonl", job->base);
    char *text = learn_load_text(t.path);
    int code = make_header(&t);
    if (code == EXIT_OK) code = check_lines(&t, text, &is_usable);
    if (code != EXIT_OK || (is_usable && is_finished(job, text))) goto done;
    snprintf(phase, sizeof phase, "%s %s %llu", job->scene_name, job->method->label,
             (unsigned long long)job->seed);
    code = begin(&t, is_usable ? text : NULL);
    if (code == EXIT_OK) {
        app_begin(t.app, phase, "steps", 1.0);
        code = loop(&t);
        app_end(t.app);
    }
    train_log_close(&t.log);
    lmn_trainer_free(t.trainer);
done:
    free(text);
    free(t.header);
    return code;
}
