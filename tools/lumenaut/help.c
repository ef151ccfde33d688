/* SPDX-License-Identifier: Apache-2.0 */
/* Help texts and shell completion, made from the option tables of args.h. */
#include "args.h"

#include <stdlib.h>
#include <string.h>

enum { HELP_COLUMN = 30, HELP_WIDTH = 100 };

/* The default in words: from the table, or the value that init() left in the struct. */
static void default_text(const struct arg_option *o, const char *place, char *text, size_t size)
{
    text[0] = '\0';
    if (o->fallback) {
        snprintf(text, size, "%s", o->fallback);
        return;
    }
    switch (o->type) {
    case ARG_COUNT:
        snprintf(text, size, "%u", *(const uint32_t *)(const void *)place);
        break;
    case ARG_INTEGER:
        snprintf(text, size, "%d", *(const int32_t *)(const void *)place);
        break;
    case ARG_NUMBER:
        snprintf(text, size, "%g", *(const double *)(const void *)place);
        break;
    case ARG_WHOLE:
        snprintf(text, size, "%llu", (unsigned long long)*(const uint64_t *)(const void *)place);
        break;
    case ARG_CHOICE: {
        const char *c = o->choices;
        for (uint32_t i = *(const uint32_t *)(const void *)place; i > 0; i--)
            c += strcspn(c, " ") + 1;
        snprintf(text, size, "%.*s", (int)strcspn(c, " "), c);
        break;
    }
    default:
        break;
    }
}

/* Writes text word by word from column HELP_COLUMN on. */
static void print_wrapped(FILE *f, const char *text)
{
    int column = HELP_COLUMN;
    while (*text) {
        const int n = (int)strcspn(text, " ");
        if (column > HELP_COLUMN && column + 1 + n > HELP_WIDTH) {
            fprintf(f, "\n%*s", HELP_COLUMN, "");
            column = HELP_COLUMN;
        } else if (column > HELP_COLUMN) {
            fputc(' ', f);
            column++;
        }
        fwrite(text, 1, (size_t)n, f);
        column += n;
        text += n;
        while (*text == ' ') text++;
    }
    fputc('\n', f);
}

static void print_option(FILE *f, const struct arg_option *o, const char *base)
{
    char left[128], fallback[128], text[512];
    int n = 0;
    if (o->letter)
        n = snprintf(left, sizeof left, "  -%c, --%s", o->letter, o->name);
    else
        n = snprintf(left, sizeof left, "      --%s", o->name);
    if (o->type != ARG_FLAG)
        n += snprintf(left + n, sizeof left - (size_t)n, o->type == ARG_MAYBE ? "[=%s]" : " %s",
                      o->argument ? o->argument : "X");
    if (n >= HELP_COLUMN)
        fprintf(f, "%s\n%*s", left, HELP_COLUMN, "");
    else
        fprintf(f, "%-*s", HELP_COLUMN, left);
    default_text(o, base + o->offset, fallback, sizeof fallback);
    n = snprintf(text, sizeof text, "%s", o->help);
    if (o->choices && n < (int)sizeof text)
        n += snprintf(text + n, sizeof text - (size_t)n, ": %s", o->choices);
    if (fallback[0] && n < (int)sizeof text)
        snprintf(text + n, sizeof text - (size_t)n, " [%s]", fallback);
    print_wrapped(f, text);
}

void help_command(FILE *f, const struct command *c)
{
    char *args = calloc(1, c->args_size);
    if (!args) return;
    if (c->init) c->init(args);
    fprintf(f, "Usage: lumenaut %s [OPTION]...%s%s\n%s.\n", c->name, c->operands[0] ? " " : "",
            c->operands, c->summary);
    for (size_t g = 0; g < c->n_groups; g++) {
        fprintf(f, "\n%s:\n", c->groups[g].heading);
        for (size_t i = 0; i < c->groups[g].n; i++)
            print_option(f, &c->groups[g].options[i], args + c->groups[g].base);
    }
    fprintf(f, "\nDefaults are in brackets. See lumenaut-%s(1).\n", c->name);
    free(args);
}

void help_overview(FILE *f)
{
    fputs("Usage: lumenaut COMMAND [OPTION]... [ARGUMENT]...\n"
          "Path-traces variable scenes and learns to show any of their configurations at once.\n"
          "\nCommands:\n",
          f);
    for (size_t i = 0; commands[i]; i++)
        fprintf(f, "  %-10s %s\n", commands[i]->name, commands[i]->summary);
    fputs("\nOptions:\n"
          "      --help      show this text; lumenaut COMMAND --help shows a command's options\n"
          "      --version   show the version\n"
          "\nExit status: 0 done, 1 failed, 2 wrong usage, 3 bad input file, 4 device, 130 "
          "interrupted.\nSee lumenaut(1).\n",
          f);
}

/* How many words of the line a completion function must skip is bash's business: each command's
 * options are one word list, and values of file options complete to file names. */
void help_completions(FILE *f)
{
    fputs("# bash completion for lumenaut; made by `lumenaut --completions`\n"
          "_lumenaut()\n{\n"
          "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} words='' "
          "values=''\n"
          "    if ((COMP_CWORD == 1)); then\n"
          "        COMPREPLY=($(compgen -W '--help --version",
          f);
    for (size_t i = 0; commands[i]; i++) fprintf(f, " %s", commands[i]->name);
    fputs("' -- \"$cur\"))\n        return\n    fi\n    case ${COMP_WORDS[1]} in\n", f);
    for (size_t i = 0; commands[i]; i++) {
        const struct command *c = commands[i];
        fprintf(f, "    %s)\n        words='", c->name);
        for (size_t g = 0; g < c->n_groups; g++)
            for (size_t k = 0; k < c->groups[g].n; k++)
                fprintf(f, "%s--%s", g + k ? " " : "", c->groups[g].options[k].name);
        fputs("'\n        case $prev in\n", f);
        for (size_t g = 0; g < c->n_groups; g++) {
            for (size_t k = 0; k < c->groups[g].n; k++) {
                const struct arg_option *o = &c->groups[g].options[k];
                if (o->choices) fprintf(f, "        --%s) values='%s' ;;\n", o->name, o->choices);
            }
        }
        fputs("        esac ;;\n", f);
    }
    fputs("    esac\n"
          "    if [[ -n $values ]]; then\n"
          "        COMPREPLY=($(compgen -W \"$values\" -- \"$cur\"))\n"
          "    elif [[ $cur == -* ]]; then\n"
          "        COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n"
          "    else\n"
          "        COMPREPLY=($(compgen -f -- \"$cur\"))\n"
          "    fi\n}\n"
          "complete -o filenames -F _lumenaut lumenaut\n",
          f);
}
