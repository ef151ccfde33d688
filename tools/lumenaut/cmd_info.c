/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut info: what a bug report needs. */
#include "cli_options.h"

#include <sys/utsname.h>

struct info_args {
    struct common_args common;
    uint32_t json;
};

static const struct arg_option info_options[] = {
    {.name = "json",
     .type = ARG_FLAG,
     .help = "print one JSON document on stdout",
     .offset = offsetof(struct info_args, json)},
};

static const struct arg_group groups[] = {
    {"Output", info_options, COUNT_OF(info_options), 0},
    COMMON_GROUP,
};

static int run(void *args)
{
    const struct info_args *a = args;
    struct app app;
    lmn_info info;
    struct utsname system = {0};
    const int code = app_open(&app, &a->common);
    if (code != EXIT_OK) return code;
    lmn_context_info(app.context, &info);
    uname(&system);
    if (a->json) {
        struct json_out j = {.f = stdout};
        jo_object(&j, NULL);
        jo_string(&j, "command", "info");
        jo_string(&j, "version", info.version);
        jo_string(&j, "cpu_detected", info.cpu_detected);
        jo_string(&j, "cpu_used", info.cpu_used);
        jo_count(&j, "threads", info.threads);
        jo_string(&j, "embree", info.embree);
        jo_string(&j, "system", system.sysname);
        jo_string(&j, "machine", system.machine);
        jo_end(&j);
    } else {
        printf("lumenaut  %s\n", info.version);
        printf("cpu       %s (best found: %s)\n", info.cpu_used, info.cpu_detected);
        printf("threads   %u\n", info.threads);
        printf("embree    %s\n", info.embree);
        printf("system    %s %s\n", system.sysname, system.machine);
    }
    app_close(&app);
    return app_flush(EXIT_OK);
}

const struct command command_info = {
    .name = "info",
    .operands = "",
    .summary = "Show version, instruction set, threads and libraries",
    .groups = groups,
    .n_groups = COUNT_OF(groups),
    .args_size = sizeof(struct info_args),
    .run = run,
};
