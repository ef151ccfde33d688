/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut plot: the curves of a training run, or of several together, as SVG. */
#include "cli_options.h"

struct plot_args {
    struct common_args common;
    const char *output;
};

static const struct arg_option plot_options[] = {
    {.name = "output",
     .letter = 'o',
     .type = ARG_FILE,
     .argument = "FILE",
     .help = "the SVG file to write; - is standard output",
     .offset = offsetof(struct plot_args, output)},
};

static const struct arg_group groups[] = {
    {"Output", plot_options, COUNT_OF(plot_options), 0},
    COMMON_GROUP,
};

static int run(void *args)
{
    const struct plot_args *a = args;
    struct app app;
    int code = app_open(&app, &a->common);
    if (code == EXIT_OK && !a->output)
        code = app_error(&app, EXIT_USAGE, "no output: give -o FILE.svg");
    if (code == EXIT_OK) code = app_check_output(&app, a->output);
    if (code == EXIT_OK) {
        const lmn_status status = lmn_plot(app.context, (const char *const *)a->common.operands,
                                           a->common.n_operands, a->output);
        if (status != LMN_OK) code = app_failed(&app, status, BLAME_INPUT);
    }
    app_close(&app);
    return app_flush(code);
}

const struct command command_plot = {
    .name = "plot",
    .operands = "MODEL|METRICS...",
    .summary = "Draw the curves of a training run, or of several, as SVG",
    .groups = groups,
    .n_groups = COUNT_OF(groups),
    .args_size = sizeof(struct plot_args),
    .run = run,
    .min_operands = 1,
    .max_operands = 64,
};
