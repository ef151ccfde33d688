/* SPDX-License-Identifier: Apache-2.0 */
#include "app.h"

#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

static volatile sig_atomic_t caught;

static void on_signal(int number)
{
    if (caught) _exit(128 + number);
    caught = number;
}

int app_signal(void)
{
    return caught;
}

static int on_progress(void *user, double done, double total)
{
    struct app *app = user;
    if (total > 0.0 && !app->is_silent) {
        double share = done / total;
        if (app->part_size > 0.0) share = app->part_start + app->part_size * share;
        progress_update(&app->progress, share, app->units * share, NULL, NULL);
    }
    if (app->is_stale && app->is_stale(app->stale_user)) return 1;
    return caught && !app->ignore_signal;
}

static void on_note(void *user, const char *text)
{
    struct app *app = user;
    app_say(app, "note: %s", text);
}

int app_open(struct app *app, const struct common_args *common)
{
    *app = (struct app){.common = common};
    progress_init(&app->progress, (enum progress_mode)common->progress, common->quiet != 0);
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    const char *cpu = common->cpu_mask ? common->cpu_mask : getenv("LMN_CPU_MASK");
    char message[256] = "";
    const lmn_context_options options = {.struct_size = sizeof options,
                                         .threads = common->threads,
                                         .cpu = cpu && *cpu ? cpu : NULL,
                                         .progress = on_progress,
                                         .progress_user = app,
                                         .note = on_note,
                                         .note_user = app};
    const lmn_status status = lmn_context_new(&options, &app->context, message, sizeof message);
    if (status == LMN_OK) return EXIT_OK;
    fprintf(stderr, "lumenaut: %s\n", message);
    return status == LMN_ERR_ARGUMENT ? EXIT_USAGE
           : status == LMN_ERR_DEVICE ? EXIT_DEVICE
                                      : EXIT_FAILED;
}

void app_close(struct app *app)
{
    lmn_context_free(app->context);
    app->context = NULL;
}

int app_failed(struct app *app, lmn_status status, enum blame blame)
{
    progress_end(&app->progress);
    if (status == LMN_ERR_CANCELLED) {
        fputs("lumenaut: interrupted\n", stderr);
        return caught ? 128 + caught : EXIT_INTERRUPTED;
    }
    fprintf(stderr, "lumenaut: %s\n", lmn_context_message(app->context));
    switch (status) {
    case LMN_ERR_DEVICE:
        return EXIT_DEVICE;
    case LMN_ERR_MEMORY:
        return EXIT_FAILED;
    case LMN_ERR_PARSE:
        return EXIT_INPUT;
    case LMN_ERR_ARGUMENT:
        return blame == BLAME_INPUT ? EXIT_INPUT : EXIT_USAGE;
    default:
        return blame == BLAME_INPUT ? EXIT_INPUT : blame == BLAME_USER ? EXIT_USAGE : EXIT_FAILED;
    }
}

int app_error(struct app *app, int code, const char *format, ...)
{
    char text[1400];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    progress_end(&app->progress);
    fprintf(stderr, "lumenaut: %s\n", text);
    return code;
}

void app_say(struct app *app, const char *format, ...)
{
    char text[1400];
    va_list list;
    if (app->common->quiet) return;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    progress_say(&app->progress, text);
}

void app_detail(struct app *app, const char *format, ...)
{
    char text[1400];
    va_list list;
    if (app->common->quiet || !app->common->verbose) return;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    progress_say(&app->progress, text);
}

void app_begin(struct app *app, const char *phase, const char *unit, double units)
{
    app->units = units;
    progress_begin(&app->progress, phase, unit);
}

void app_end(struct app *app)
{
    progress_end(&app->progress);
}

int app_flush(int code)
{
    if (fflush(stdout) == 0 && !ferror(stdout)) return code;
    fprintf(stderr, "lumenaut: standard output: %s\n", strerror(errno));
    return code == EXIT_OK ? EXIT_FAILED : code;
}

uint64_t app_peak_memory(void)
{
    struct rusage usage;
    if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
    return (uint64_t)usage.ru_maxrss * 1024u;
}

int app_check_output(struct app *app, const char *path)
{
    char folder[4096];
    struct stat s;
    if (strcmp(path, "-") == 0) return EXIT_OK;
    if (stat(path, &s) == 0 && S_ISDIR(s.st_mode))
        return app_error(app, EXIT_FAILED, "%s: cannot write: is a directory", path);
    const char *slash = strrchr(path, '/');
    const size_t n = slash ? (size_t)(slash - path) + 1 : 0;
    if (n >= sizeof folder) return app_error(app, EXIT_FAILED, "%.64s...: name too long", path);
    memcpy(folder, path, n);
    folder[n] = '\0';
    if (access(n ? folder : ".", W_OK) != 0)
        return app_error(app, EXIT_FAILED, "%s: cannot write: %s", path, strerror(errno));
    return EXIT_OK;
}

int app_check_image(struct app *app, const char *path, const char *format)
{
    static const char *const formats[] = {"exr", "png", "pfm"};
    char hint[128];
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash : path, '.');
    const bool is_stream = strcmp(path, "-") == 0;
    const char *name = format ? format : !is_stream && dot ? dot + 1 : NULL;
    if (!name && is_stream)
        return app_error(app, EXIT_USAGE, "-o - needs --format exr, png or pfm");
    if (!name)
        return app_error(app, EXIT_USAGE, "%s: which format? give .exr, .png, .pfm or --format",
                         path);
    for (size_t i = 0; i < 3; i++)
        if (strcasecmp(name, formats[i]) == 0) return app_check_output(app, path);
    suggest(hint, sizeof hint, name, "", formats, 3);
    return app_error(app, EXIT_USAGE, "%s: unknown image format \"%s\" (exr, png, pfm)%s", path,
                     name, hint);
}
