/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut train: the loop around lmn_trainer_step(): when to stop, save, measure, and what to
 * say. */
#include "train_args.h"
#include "train_log.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* When no rule to stop is given. */
static const double default_time_s = 900.0;

struct run {
    const struct train_args *a;
    struct app app;
    lmn_scene *scene;
    lmn_trainer *trainer;
    struct train_log log;
    lmn_train_stats stats;
    struct train_target target;
    struct view_host host; /* its viewer is NULL without --view */
    double time_s;         /* 0: no limit */
    bool has_eval, target_reached;
    lmn_metrics eval;
    uint64_t eval_step, saved_step, first_step;
    double eval_cpu_s, saved_clock_s, first_cpu_s;
};

static int save(struct run *r)
{
    if (!train_log_flush(&r->log))
        return app_error(&r->app, EXIT_FAILED, "%s: cannot write: %s", r->log.path,
                         strerror(errno));
    const lmn_status status = lmn_trainer_save(r->trainer, r->a->output);
    r->saved_step = r->stats.step;
    r->saved_clock_s = clock_s();
    return status == LMN_OK ? EXIT_OK : app_failed(&r->app, status, BLAME_WORK);
}

static bool is_due(const struct arg_interval *every, uint64_t step, uint64_t last_step,
                   double time_s, double last_s)
{
    if (every->steps > 0) return step >= last_step + every->steps;
    return every->seconds > 0.0 && time_s - last_s >= every->seconds;
}

/* Measures the network; a signal meanwhile only skips the figures. */
static int measure(struct run *r)
{
    const struct train_args *a = r->a;
    r->app.ignore_signal = false;
    r->app.is_silent = true;
    const lmn_status status = lmn_trainer_eval(r->trainer, a->eval_n, a->eval_size, a->eval_spp,
                                               a->eval_seed, &r->eval);
    r->app.ignore_signal = true;
    r->app.is_silent = false;
    r->eval_step = r->stats.step;
    r->eval_cpu_s = r->stats.cpu_s;
    if (status == LMN_ERR_CANCELLED) return EXIT_OK;
    if (status != LMN_OK) return app_failed(&r->app, status, BLAME_WORK);
    r->has_eval = true;
    r->target_reached = a->target && train_target_reached(&r->target, &r->eval);
    return EXIT_OK;
}

static bool is_finished(const struct run *r)
{
    return (r->a->steps > 0 && r->stats.step >= r->a->steps) ||
           (r->time_s > 0.0 && r->stats.cpu_s >= r->time_s) || r->target_reached;
}

static void show(struct run *r)
{
    const lmn_train_stats *s = &r->stats;
    char text[160], json[512], error[48] = "", resolution[24] = "";
    lmn_train_options used;
    double fraction = -1.0;
    if (!progress_is_due(&r->app.progress) && s->step > r->first_step + 1) return;
    lmn_trainer_get_options(r->trainer, &used);
    if (used.method == LMN_METHOD_FAITHFUL)
        snprintf(resolution, sizeof resolution, "  res %u", s->resolution);
    if (r->a->steps > 0) fraction = (double)s->step / (double)r->a->steps;
    if (r->time_s > 0.0 && s->cpu_s / r->time_s > fraction) fraction = s->cpu_s / r->time_s;
    if (r->has_eval) snprintf(error, sizeof error, "  MAPE %.4f", r->eval.mape);
    snprintf(text, sizeof text, "step %llu  loss %.4f%s%s  trace %.0f %%",
             (unsigned long long)s->step, s->loss, error, resolution,
             s->cpu_s > 0.0 ? 100.0 * s->trace_s / s->cpu_s : 0.0);
    snprintf(json, sizeof json,
             "\"step\":%llu,\"loss\":%.6g,\"resolution\":%u,\"acceptance\":%.4g,"
             "\"reuse_probability\":%.4g,\"fresh\":%s,\"cpu_s\":%.3f%s%.6g",
             (unsigned long long)s->step, s->loss, s->resolution, s->acceptance,
             s->reuse_probability, s->fresh ? "true" : "false", s->cpu_s,
             r->has_eval ? ",\"mape\":" : ",\"trace_s\":", r->has_eval ? r->eval.mape : s->trace_s);
    progress_update(&r->app.progress, fraction, (double)s->step, text, json);
}

static bool is_watched(const struct train_args *a)
{
    return a->eval_every.steps > 0 || a->eval_every.seconds > 0.0;
}

/* Pages' turn between steps. False: they asked to stop. */
static bool serve_pages(struct run *r, int *code)
{
    struct viewer_orders orders = {0};
    r->app.is_silent = true;
    do {
        viewer_work(r->host.viewer, &r->stats, &orders);
        if (orders.must_save) *code = save(r);
    } while (orders.is_paused && !orders.must_stop && *code == EXIT_OK && !app_signal());
    r->app.is_silent = false;
    return !orders.must_stop;
}

static int open_page(struct run *r)
{
    const struct train_args *a = r->a;
    struct view_words render, trace;
    view_words_render(&render, a->output, NULL, false);
    view_words_trace(&trace, a->common.operands[0], &a->scene);
    struct viewer_options options = {.scene = r->scene,
                                     .trainer = r->trainer,
                                     .scene_path = a->common.operands[0],
                                     .model_path = a->output,
                                     .render = render.list,
                                     .trace = trace.list};
    const int code = view_host_open(&r->host, &r->app, &a->page, &options);
    if (code != EXIT_OK) return code;
    return viewer_start(r->host.viewer) ? EXIT_OK
                                        : app_error(&r->app, EXIT_FAILED, "view: no thread for it");
}

static int loop(struct run *r)
{
    const struct train_args *a = r->a;
    int code = EXIT_OK;
    while (code == EXIT_OK && !app_signal() && !is_finished(r)) {
        const lmn_status status = lmn_trainer_step(r->trainer, &r->stats);
        if (status != LMN_OK) return app_failed(&r->app, status, BLAME_WORK);
        if (is_due(&a->eval_every, r->stats.step, r->eval_step, r->stats.cpu_s, r->eval_cpu_s) ||
            (is_watched(a) && is_finished(r)))
            code = measure(r);
        const char *line = lmn_trainer_metrics_line(r->trainer);
        if (!line) return app_error(&r->app, EXIT_FAILED, "out of memory");
        train_log_add(&r->log, line);
        if (code == EXIT_OK &&
            is_due(&a->checkpoint_every, r->stats.step, r->saved_step, clock_s(), r->saved_clock_s))
            code = save(r);
        show(r);
        if (code == EXIT_OK && r->host.viewer && !serve_pages(r, &code)) break;
    }
    return code;
}

/* An earlier model of that name becomes NAME~, as a run of hours should not vanish by a slip. */
static int keep_backup(struct run *r)
{
    char from[4200], log[4096], backup[4200];
    /* The model first: what is left when this is stopped half-way can be resumed as it was. */
    static const char *const endings[] = {"", ".state"};
    bool is_there = false;
    for (size_t i = 0; i < 2; i++) {
        snprintf(from, sizeof from, "%s%s", r->a->output, endings[i]);
        is_there |= access(from, F_OK) == 0;
    }
    if (!is_there) return EXIT_OK;
    for (size_t i = 0; i < 2; i++) {
        snprintf(from, sizeof from, "%s%s", r->a->output, endings[i]);
        snprintf(backup, sizeof backup, "%s~%s", r->a->output, endings[i]);
        if (rename(from, backup) == 0) continue;
        if (errno != ENOENT)
            return app_error(&r->app, EXIT_FAILED, "%s: cannot rename: %s", from, strerror(errno));
        unlink(backup); /* an older one's half beside this one's other would be no pair */
    }
    app_say(&r->app, "the earlier %s is now %s~ (--resume would continue it)", r->a->output,
            r->a->output);
    train_log_path(r->a->output, log, sizeof log);
    snprintf(backup, sizeof backup, "%s~", log);
    rename(log, backup); /* there may be none */
    return EXIT_OK;
}

/* What --from leaves open is as the model has it. */
static int read_origin(struct run *r, struct train_args *a)
{
    lmn_model_info info;
    if (a->resume)
        return app_error(&r->app, EXIT_USAGE, "--from: --resume goes on with what %s has learnt",
                         a->output ? a->output : "the model");
    const lmn_status status = lmn_model_read_info(r->app.context, a->from, &info);
    if (status != LMN_OK) return app_failed(&r->app, status, BLAME_INPUT);
    if (!a->given.method) a->options.method = LMN_METHOD_IMPROVED;
    if (!a->given.width && info.method == LMN_METHOD_IMPROVED) {
        a->options.width = info.width;
        a->given.width = 1;
    }
    if (!a->given.depth && info.method == LMN_METHOD_IMPROVED) {
        a->options.depth = info.depth;
        a->given.depth = 1;
    }
    lmn_model_info_free(&info);
    return EXIT_OK;
}

static int start_from(struct run *r)
{
    const char *report, *end;
    const lmn_status status = lmn_trainer_start_from(r->trainer, r->a->from, &report);
    if (status != LMN_OK) return app_failed(&r->app, status, BLAME_INPUT);
    for (; *report; report = *end ? end + 1 : end) {
        end = strchrnul(report, '\n');
        app_say(&r->app, "%.*s", (int)(end - report), report);
    }
    return EXIT_OK;
}

static int begin(struct run *r)
{
    const struct train_args *a = r->a;
    lmn_train_options used;
    lmn_status status;
    bool needs_header;
    int code;
    if (a->resume)
        status = lmn_trainer_resume(r->app.context, r->scene, a->output, a->force != 0,
                                    &r->trainer);
    else
        status = lmn_trainer_new(r->app.context, r->scene, &a->options, &r->trainer);
    if (status != LMN_OK) return app_failed(&r->app, status, a->resume ? BLAME_INPUT : BLAME_USER);
    if (a->from && (code = start_from(r)) != EXIT_OK) return code;
    lmn_trainer_get_options(r->trainer, &used);
    const char *conflict = a->resume ? train_args_conflict(a, &used) : NULL;
    if (conflict)
        return app_error(&r->app, EXIT_USAGE,
                         "--%s: %s was trained with another value, which --resume keeps", conflict,
                         a->output);
    if (!a->resume && (code = keep_backup(r)) != EXIT_OK) return code;
    lmn_trainer_get_stats(r->trainer, &r->stats);
    code = train_log_open(&r->log, &r->app, a->output, r->stats.step, !a->resume, &needs_header);
    if (code != EXIT_OK) return code;
    const char *header = lmn_trainer_metrics_line(r->trainer);
    if (!header) return app_error(&r->app, EXIT_FAILED, "out of memory");
    if (needs_header) train_log_add(&r->log, header);
    r->first_step = r->saved_step = r->eval_step = r->stats.step;
    r->first_cpu_s = r->eval_cpu_s = r->stats.cpu_s;
    r->saved_clock_s = clock_s();
    return EXIT_OK;
}

static void print_json(const struct run *r, bool is_interrupted)
{
    struct json_out j = {.f = stdout};
    const lmn_train_stats *s = &r->stats;
    jo_object(&j, NULL);
    jo_string(&j, "command", "train");
    jo_string(&j, "scene", r->a->common.operands[0]);
    jo_string(&j, "model", r->a->output);
    jo_string(&j, "metrics", r->log.path);
    jo_count(&j, "steps", s->step);
    jo_count(&j, "steps_this_run", s->step - r->first_step);
    jo_number(&j, "cpu_s", s->cpu_s);
    jo_number(&j, "trace_s", s->trace_s);
    jo_number(&j, "network_s", s->network_s);
    jo_number(&j, "loss", s->loss);
    jo_number(&j, "acceptance", s->acceptance);
    jo_number(&j, "reuse_probability", s->reuse_probability);
    jo_count(&j, "resolution", s->resolution);
    jo_count(&j, "patches_traced", s->n_traced);
    jo_count(&j, "memory_bytes", s->memory_bytes);
    jo_count(&j, "peak_memory_bytes", app_peak_memory());
    jo_bool(&j, "interrupted", is_interrupted);
    if (r->has_eval) {
        jo_metrics(&j, "eval", &r->eval);
        jo_count(&j, "eval_step", r->eval_step);
    }
    jo_end(&j);
}

static void report(struct run *r)
{
    const lmn_train_stats *s = &r->stats;
    char memory[32];
    const double all = s->cpu_s > 0.0 ? s->cpu_s : 1.0;
    format_bytes(app_peak_memory(), memory);
    app_say(&r->app,
            "%s: step %llu after %.1f s of processor time per thread (tracing %.0f %%, network "
            "%.0f %%), peak memory %s",
            r->a->output, (unsigned long long)s->step, s->cpu_s, 100.0 * s->trace_s / all,
            100.0 * s->network_s / all, memory);
    if (r->has_eval)
        app_say(&r->app, "test set at step %llu: MAPE %.4f, relMSE %.4f, FLIP %.4f",
                (unsigned long long)r->eval_step, r->eval.mape, r->eval.relmse, r->eval.flip);
    app_say(&r->app, "metrics: %s; to go on: lumenaut train %s -o %s --resume", r->log.path,
            r->a->common.operands[0], r->a->output);
}

static int run(void *args)
{
    const struct train_args *a = args;
    struct run r = {.a = a, .time_s = a->time_s};
    int code = app_open(&r.app, &a->common);
    if (code == EXIT_OK) code = view_args_check(&r.app, &a->page);
    if (code == EXIT_OK && a->from) code = read_origin(&r, args);
    const char *foreign = train_args_finish(args);
    if (code == EXIT_OK && foreign)
        code = app_error(&r.app, EXIT_USAGE,
                         "--%s: the improved method, the default, has no such option: it is of "
                         "--method faithful",
                         foreign);
    if (code == EXIT_OK && !a->output)
        code = app_error(&r.app, EXIT_USAGE, "no output: give -o FILE.lmn");
    if (code == EXIT_OK && strcmp(a->output, "-") == 0)
        code = app_error(&r.app, EXIT_USAGE, "-o -: a checkpoint needs a file");
    if (code == EXIT_OK) code = app_check_output(&r.app, a->output);
    if (code == EXIT_OK && a->target && !train_target_parse(a->target, &r.target))
        code = app_error(&r.app, EXIT_USAGE,
                         "--target %s: expected METRIC=X, as mape=0.1 (mape, mae, relmse, mse, "
                         "psnr, dssim, flip, flip_hdr)",
                         a->target);
    if (code == EXIT_OK) code = load_scene(&r.app, a->common.operands[0], &a->scene, &r.scene);
    if (code == EXIT_OK) code = begin(&r);
    if (code != EXIT_OK) goto done;
    if (a->steps == 0 && a->time_s <= 0.0 && !a->target) {
        r.time_s = default_time_s;
        app_say(&r.app, "stops at 15 minutes; --time, --steps and --target change that");
    }
    char memory[32];
    format_bytes(r.stats.memory_bytes, memory);
    app_detail(&r.app, "workspace %s; step %llu", memory, (unsigned long long)r.stats.step);
    if (a->view && (code = open_page(&r)) != EXIT_OK) goto done;
    r.app.ignore_signal = true;
    app_begin(&r.app, "train", "steps", 1.0);
    code = loop(&r);
    const bool is_interrupted = app_signal() != 0;
    app_end(&r.app);
    view_host_close(&r.host);
    /* Also after a failed step: the weights are as they were before it. */
    const int saved = r.saved_step != r.stats.step || r.stats.step == r.first_step ? save(&r)
                                                                                   : EXIT_OK;
    if (code == EXIT_OK) code = saved;
    if (code != EXIT_OK) goto done;
    report(&r);
    if (a->json) print_json(&r, is_interrupted);
    if (is_interrupted) {
        app_say(&r.app, "interrupted; all %llu steps are saved", (unsigned long long)r.stats.step);
        code = 128 + app_signal();
    }
done:
    view_host_close(&r.host);
    train_log_close(&r.log);
    lmn_trainer_free(r.trainer);
    lmn_scene_free(r.scene);
    app_close(&r.app);
    return app_flush(code);
}

const struct command command_train = {
    .name = "train",
    .operands = "SCENE",
    .summary = "Train a network on the configurations of a scene",
    .groups = train_groups,
    .n_groups = 9,
    .args_size = sizeof(struct train_args),
    .init = train_args_init,
    .run = run,
    .min_operands = 1,
    .max_operands = 1,
};
