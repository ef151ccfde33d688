/* SPDX-License-Identifier: Apache-2.0 */
#ifndef ARGS_H
#define ARGS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/*
 * The command line as tables. Each command has a struct of its arguments that begins with struct
 * common_args, and groups of options that say where in that struct a value goes. The same tables
 * drive parsing, `--help` and shell completion, so these cannot disagree.
 */

enum exit_code {
    EXIT_OK = 0,
    EXIT_FAILED = 1,
    EXIT_USAGE = 2,
    EXIT_INPUT = 3,
    EXIT_DEVICE = 4,
    EXIT_INTERRUPTED = 130
};

enum arg_type {
    ARG_FLAG,     /* uint32_t, set to 1 */
    ARG_TEXT,     /* const char *, points into argv */
    ARG_FILE,     /* the same; completion offers file names */
    ARG_MAYBE,    /* the same, but --name alone is the empty text; a value needs --name=VALUE */
    ARG_LIST,     /* struct arg_list; every use adds one */
    ARG_COUNT,    /* uint32_t in [min, max] */
    ARG_INTEGER,  /* int32_t in [min, max] */
    ARG_WHOLE,    /* uint64_t */
    ARG_NUMBER,   /* double in [min, max] */
    ARG_CHOICE,   /* uint32_t, index of a word in `choices` */
    ARG_SIZE,     /* uint32_t[2]: 640x480 */
    ARG_CROP,     /* uint32_t[4]: x,y,width,height */
    ARG_VECTOR,   /* double[3]: x,y,z */
    ARG_DURATION, /* double, seconds: 90, 90s, 15m, 2h */
    ARG_INTERVAL  /* struct arg_interval: 100i, 5m, never */
};

enum { ARG_LIST_MAX = 256 };

struct arg_list {
    const char *items[ARG_LIST_MAX];
    uint32_t n;
};

/* Steps or seconds; both 0: never. */
struct arg_interval {
    uint64_t steps;
    double seconds;
};

struct arg_option {
    const char *name; /* long name without dashes */
    char letter;      /* 0: none */
    enum arg_type type;
    const char *argument; /* what help calls the value: "FILE" */
    const char *help;     /* one sentence without full stop */
    const char *fallback; /* default as help words it; NULL: the value in the initialised struct,
                             "": not shown */
    const char *choices;  /* ARG_CHOICE: words separated by spaces */
    double min, max;      /* max 0: no upper bound */
    size_t offset;        /* of the value in the arguments struct */
    size_t given;         /* of a uint32_t set to 1 when the option is used; 0: none */
};

struct arg_group {
    const char *heading;
    const struct arg_option *options;
    size_t n;
    size_t base; /* added to offsets: options shared by several structs */
};

/* Begins every arguments struct. */
struct common_args {
    uint32_t help;
    uint32_t threads;
    const char *cpu_mask;
    uint32_t progress; /* enum progress_mode */
    uint32_t quiet, verbose;
    char **operands;
    uint32_t n_operands;
};

struct command {
    const char *name, *operands, *summary;
    const struct arg_group *groups;
    size_t n_groups;
    size_t args_size;
    void (*init)(void *args); /* may be NULL: zeros are the defaults */
    int (*run)(void *args);   /* returns the exit code */
    uint32_t min_operands, max_operands;
};

extern const struct command *const commands[]; /* ends with NULL */

/* Fills args from argv[1..]; argv[0] is the command's name. Returns EXIT_OK, or EXIT_USAGE after
 * saying on stderr what is wrong. */
int args_parse(const struct command *c, int argc, char **argv, void *args);

/* `lumenaut COMMAND --help`, and `lumenaut --help`. */
void help_command(FILE *f, const struct command *c);
void help_overview(FILE *f);

/* The bash completion script, made from the tables. */
void help_completions(FILE *f);

/* One line on stderr, "lumenaut: ..."; returns EXIT_USAGE. */
__attribute__((format(printf, 1, 2))) int usage_error(const char *format, ...);

/* Prints "; did you mean "--x"?" or nothing into text. */
void suggest(char *text, size_t size, const char *word, const char *prefix,
             const char *const *candidates, size_t n);

#endif
