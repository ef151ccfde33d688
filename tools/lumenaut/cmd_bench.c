/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut bench: what this machine does. */
#include "learn.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct bench_args {
    struct common_args common;
    uint32_t runs, width, depth, has_depth, patches, method;
    uint32_t size[2], has_size;
    uint32_t spp;
    int32_t max_depth, rr_depth;
    uint32_t has_max_depth, has_rr_depth;
    struct arg_list values;
    const char *peers;
    uint32_t json;
    struct learn_args learn;
    struct scene_args scene;
};

static const struct arg_option bench_options[] = {
    {.name = "runs",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "measurements of each kind; the median counts",
     .min = 1,
     .max = 1000,
     .offset = offsetof(struct bench_args, runs)},
    {.name = "width",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "features per layer of the network (kernels, train, frame)",
     .fallback = "512; frame, improved: 64",
     .min = 1,
     .max = 1024,
     .offset = offsetof(struct bench_args, width)},
    {.name = "depth",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "hidden layers after the first two; improved: hidden layers (kernels, train, frame)",
     .fallback = "8; frame, improved: 3",
     .min = 0,
     .max = 32,
     .offset = offsetof(struct bench_args, depth),
     .given = offsetof(struct bench_args, has_depth)},
    {.name = "method",
     .type = ARG_CHOICE,
     .argument = "NAME",
     .help = "whose network makes the frames",
     .choices = "improved faithful",
     .offset = offsetof(struct bench_args, method)},
    {.name = "patches",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "patches of 32x32 in a step (train)",
     .min = 1,
     .max = 4096,
     .offset = offsetof(struct bench_args, patches)},
    {.name = "size",
     .type = ARG_SIZE,
     .argument = "WxH",
     .help = "size of the picture",
     .fallback = "trace: 256x256; buffers, frame: 900x900",
     .offset = offsetof(struct bench_args, size),
     .given = offsetof(struct bench_args, has_size)},
    {.name = "spp",
     .type = ARG_COUNT,
     .argument = "N",
     .help = "samples per pixel; those of the buffers in a frame",
     .fallback = "trace: 32; buffers, frame: 1",
     .min = 1,
     .max = 1 << 20,
     .offset = offsetof(struct bench_args, spp)},
    {.name = "max-depth",
     .type = ARG_INTEGER,
     .argument = "N",
     .help = "longest path (trace)",
     .fallback = "the scene's",
     .min = -1,
     .max = 1 << 20,
     .offset = offsetof(struct bench_args, max_depth),
     .given = offsetof(struct bench_args, has_max_depth)},
    {.name = "rr-depth",
     .type = ARG_INTEGER,
     .argument = "N",
     .help = "path length from which Russian roulette plays (trace)",
     .fallback = "the scene's",
     .min = 1,
     .max = 1 << 20,
     .offset = offsetof(struct bench_args, rr_depth),
     .given = offsetof(struct bench_args, has_rr_depth)},
    {.name = "set",
     .letter = 'P',
     .type = ARG_LIST,
     .argument = "NAME=VALUE",
     .help = "set a variable, as for trace (buffers, frame); may be repeated",
     .fallback = "buffers: the defaults; frame: random values",
     .offset = offsetof(struct bench_args, values)},
    {.name = "peers",
     .type = ARG_FILE,
     .argument = "PYTHON",
     .help = "measure PyTorch (train) or Mitsuba 3 (trace) beside it, by turns, with this Python; "
             "from the source folder",
     .fallback = "none",
     .offset = offsetof(struct bench_args, peers)},
    {.name = "json",
     .type = ARG_FLAG,
     .help = "print one JSON document on stdout",
     .offset = offsetof(struct bench_args, json)},
};

static const struct arg_group groups[] = {
    {"Measurement", bench_options, COUNT_OF(bench_options), 0},
    {"Learning (learn)", learn_options, N_LEARN_OPTIONS, offsetof(struct bench_args, learn)},
    {"Scenes (learn)", scene_options, COUNT_OF(scene_options), offsetof(struct bench_args, scene)},
    COMMON_GROUP,
};

static void init(void *args)
{
    struct bench_args *a = args;
    a->runs = 5;
    a->patches = 32;
    learn_args_init(&a->learn);
}

/* Shows a JSON document to people: a line per member, indented, without quotes and braces. */
static void print_plain(const char *json)
{
    int depth = 0;
    bool in_string = false, at_start = true;
    for (const char *c = json; *c; c++) {
        if (in_string && *c == '\\' && c[1]) {
            putchar(*++c);
            continue;
        }
        if (*c == '"') {
            in_string = !in_string;
            continue;
        }
        const bool opens = !in_string && strchr("{[", *c), closes = !in_string && strchr("}]", *c);
        if (opens || closes || (!in_string && *c == ',')) {
            depth += opens - closes;
            if (!at_start) putchar('\n');
            at_start = true;
            continue;
        }
        if (at_start && strchr(" \n", *c)) continue;
        if (at_start) printf("%*s", depth > 1 ? 2 * (depth - 1) : 0, "");
        at_start = false;
        putchar(*c);
        if (!in_string && *c == ':') putchar(' ');
    }
    if (!at_start) putchar('\n');
}

/* What is measured when no file is named: the scene that comes with the program, seen from its
 * source folder, and outside scenes where there are some. */
static void add_default_files(struct json_out *j)
{
    static const char *const outside[] = {"official/sphere-caustic/scene.xml",
                                          "official/veach-ajar/scene.xml",
                                          "bitterli/cornell-box/scene.xml"};
    const char *folder = getenv("LUMENAUT_SCENES");
    char path[4096];
    if (access("scenes/demo/scene.xml", R_OK) == 0) jo_string(j, NULL, "scenes/demo/scene.xml");
    for (size_t i = 0; i < COUNT_OF(outside); i++) {
        snprintf(path, sizeof path, "%s/%s", folder ? folder : "../shared/scenes", outside[i]);
        if (access(path, R_OK) == 0) jo_string(j, NULL, path);
    }
}

/* The options of lmn_bench() as JSON; free() it. */
static char *make_options(const struct bench_args *a, uint32_t first_file)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f) return NULL;
    struct json_out j = {.f = f};
    jo_object(&j, NULL);
    jo_count(&j, "runs", a->runs);
    if (a->width) jo_count(&j, "width", a->width);
    if (a->has_depth) jo_count(&j, "depth", a->depth);
    jo_count(&j, "patches", a->patches);
    jo_string(&j, "method", a->method ? "faithful" : "improved");
    if (a->spp) jo_count(&j, "spp", a->spp);
    if (a->has_max_depth) jo_number(&j, "max_depth", a->max_depth);
    if (a->has_rr_depth) jo_number(&j, "rr_depth", a->rr_depth);
    if (a->has_size) {
        jo_array(&j, "size");
        jo_count(&j, NULL, a->size[0]);
        jo_count(&j, NULL, a->size[1]);
        jo_end(&j);
    }
    jo_array(&j, "set");
    for (uint32_t i = 0; i < a->values.n; i++) jo_string(&j, NULL, a->values.items[i]);
    jo_end(&j);
    jo_array(&j, "files");
    for (uint32_t i = first_file; i < a->common.n_operands; i++)
        jo_string(&j, NULL, a->common.operands[i]);
    if (first_file >= a->common.n_operands) add_default_files(&j);
    jo_end(&j);
    jo_end(&j);
    if (fclose(f) == 0) return text;
    free(text);
    return NULL;
}

static int run_learn(const struct bench_args *a)
{
    struct app app;
    int code = app_open(&app, &a->common);
    if (code == EXIT_OK)
        code = learn_bench(&app, &a->learn, &a->scene, a->common.operands + 1,
                           a->common.n_operands - 1, a->json != 0);
    app_close(&app);
    return app_flush(code);
}

/* The comparison itself is a script beside the peers' own; this process becomes it. */
static int run_peers(const struct bench_args *a, const char *wanted)
{
    char runs[16], script[64];
    if (!wanted || (strcmp(wanted, "train") != 0 && strcmp(wanted, "trace") != 0))
        return usage_error("--peers: for bench train and bench trace");
    snprintf(script, sizeof script, "scripts/peers/bench_%s.py", wanted);
    snprintf(runs, sizeof runs, "%u", a->runs);
    if (access(script, R_OK) != 0)
        return usage_error("--peers: %s: %s (run it from the source folder)", script,
                           strerror(errno));
    execlp(a->peers, a->peers, script, "--runs", runs, a->json ? "--json" : (char *)NULL,
           (char *)NULL);
    return usage_error("--peers %s: %s (see make peers)", a->peers, strerror(errno));
}

static int run(void *args)
{
    static const char *const kinds[] = {"kernels", "train", "trace", "buffers", "frame"};
    static const char *const names[] = {"kernels", "train", "trace", "buffers", "frame", "learn"};
    const struct bench_args *a = args;
    const char *wanted = a->common.n_operands > 0 ? a->common.operands[0] : NULL;
    struct app app;
    char hint[128], *options = NULL;
    bool is_known = !wanted;
    if (a->peers) return run_peers(a, wanted);
    if (wanted && strcmp(wanted, "learn") == 0) return run_learn(a);
    int code = app_open(&app, &a->common);
    for (size_t i = 0; i < COUNT_OF(kinds); i++) is_known |= wanted && !strcmp(wanted, kinds[i]);
    if (code == EXIT_OK && !is_known) {
        suggest(hint, sizeof hint, wanted, "", names, COUNT_OF(names));
        code = app_error(
            &app, EXIT_USAGE,
            "bench \"%s\": nothing of that name (kernels, trace, train, buffers, frame, learn)%s",
            wanted, hint);
    }
    if (code == EXIT_OK) options = make_options(a, wanted ? 1 : 0);
    if (code == EXIT_OK && !options) code = app_error(&app, EXIT_FAILED, "out of memory");
    if (code == EXIT_OK && a->json && !wanted) putchar('[');
    for (size_t i = 0; i < COUNT_OF(kinds) && code == EXIT_OK; i++) {
        const char *json = NULL;
        if (wanted && strcmp(wanted, kinds[i]) != 0) continue;
        app_begin(&app, kinds[i], NULL, 1.0);
        if (strcmp(kinds[i], "kernels") != 0 && strcmp(kinds[i], "train") != 0)
            app_detail(&app, "%s: %s", kinds[i], options);
        const lmn_status status = lmn_bench(app.context, kinds[i], options, &json);
        if (status != LMN_OK) {
            code = app_failed(&app, status, BLAME_INPUT);
            break;
        }
        app_end(&app);
        if (a->json)
            printf("%s%s\n", !wanted && i > 0 ? "," : "", json);
        else
            print_plain(json);
    }
    if (code == EXIT_OK && a->json && !wanted) puts("]");
    free(options);
    app_close(&app);
    return app_flush(code);
}

const struct command command_bench = {
    .name = "bench",
    .operands = "[kernels|trace|train|buffers|frame|learn] [FILE]...",
    .summary = "Measure kernels, path tracing, training steps, buffers, frames and learning",
    .groups = groups,
    .n_groups = COUNT_OF(groups),
    .args_size = sizeof(struct bench_args),
    .init = init,
    .run = run,
    .max_operands = 64,
};
