/* SPDX-License-Identifier: Apache-2.0 */
/* lumenaut: finds the command, parses its arguments, runs it. */
#include "cli_options.h"

#include <stdlib.h>
#include <string.h>

const struct command *const commands[] = {
    &command_trace,
    &command_train,
    &command_render,
    &command_eval,
    &command_compare,
    &command_params,
    &command_plot,
    &command_view,
    &command_bench,
    &command_info,
    NULL,
};

static int show_version(void)
{
    printf("lumenaut %s\n", LMN_TOOL_VERSION);
    return app_flush(EXIT_OK);
}

static int unknown(const char *word)
{
    const char *names[COUNT_OF(commands) + 2];
    char hint[128];
    size_t n = 0;
    const bool is_option = word[0] == '-';
    if (is_option) {
        names[n++] = "--help";
        names[n++] = "--version";
    } else {
        while (commands[n]) {
            names[n] = commands[n]->name;
            n++;
        }
    }
    suggest(hint, sizeof hint, word, "", names, n);
    return usage_error("unknown %s \"%s\"%s", is_option ? "option" : "command", word,
                       hint[0] ? hint : "; see lumenaut --help");
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        help_overview(stderr);
        return EXIT_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "help") == 0) {
        help_overview(stdout);
        return app_flush(EXIT_OK);
    }
    if (strcmp(argv[1], "--version") == 0) return show_version();
    if (strcmp(argv[1], "--completions") == 0) {
        help_completions(stdout);
        return app_flush(EXIT_OK);
    }
    for (size_t i = 0; commands[i]; i++) {
        const struct command *c = commands[i];
        if (strcmp(argv[1], c->name) != 0) continue;
        struct common_args *args = calloc(1, c->args_size);
        if (!args) return usage_error("out of memory"), EXIT_FAILED;
        int code = args_parse(c, argc - 1, argv + 1, args);
        if (code == EXIT_OK && args->help) {
            help_command(stdout, c);
            code = app_flush(EXIT_OK);
        } else if (code == EXIT_OK) {
            code = c->run(args);
        }
        free(args);
        return code;
    }
    return unknown(argv[1]);
}
