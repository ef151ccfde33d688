/* SPDX-License-Identifier: Apache-2.0 */
#include "args.h"

#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

int usage_error(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    fputs("lumenaut: ", stderr);
    vfprintf(stderr, format, list);
    fputc('\n', stderr);
    va_end(list);
    return EXIT_USAGE;
}

/* Levenshtein distance of short words; long ones count as far away. */
static size_t edit_distance(const char *a, const char *b)
{
    size_t row[64];
    const size_t n = strlen(a), m = strlen(b);
    if (n >= 64 || m >= 64) return SIZE_MAX;
    for (size_t j = 0; j <= m; j++) row[j] = j;
    for (size_t i = 1; i <= n; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= m; j++) {
            const size_t above = row[j];
            size_t best = diagonal + (a[i - 1] != b[j - 1]);
            if (above + 1 < best) best = above + 1;
            if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
            row[j] = best;
            diagonal = above;
        }
    }
    return row[m];
}

void suggest(char *text, size_t size, const char *word, const char *prefix,
             const char *const *candidates, size_t n)
{
    size_t best = SIZE_MAX, which = 0;
    for (size_t i = 0; i < n; i++) {
        const size_t d = edit_distance(word, candidates[i]);
        if (d < best) {
            best = d;
            which = i;
        }
    }
    text[0] = '\0';
    if (best <= 1 + strlen(word) / 3)
        snprintf(text, size, "; did you mean \"%s%s\"?", prefix, candidates[which]);
}

/* The whole of text as a finite number in [min, max]. */
static bool parse_number(const char *text, double min, double max, double *out)
{
    char *end;
    if (*text == '\0' || strchr(" \t\n", *text)) return false;
    const double x = strtod(text, &end);
    if (*end != '\0' || !isfinite(x) || x < min || (max > min && x > max)) return false;
    *out = x;
    return true;
}

static bool parse_whole(const char *text, uint64_t *out)
{
    char *end;
    if (*text < '0' || *text > '9') return false;
    errno = 0;
    const unsigned long long x = strtoull(text, &end, 0);
    if (*end != '\0' || errno != 0) return false;
    *out = x;
    return true;
}

/* "90", "90s", "15m", "2h" in seconds. */
static bool parse_duration(const char *text, double *out)
{
    char number[64];
    double factor = 1.0, x;
    size_t n = strlen(text);
    if (n == 0 || n >= sizeof number) return false;
    memcpy(number, text, n + 1);
    const char *unit = strchr("smh", number[n - 1]);
    if (unit) {
        factor = *unit == 's' ? 1.0 : *unit == 'm' ? 60.0 : 3600.0;
        number[n - 1] = '\0';
    }
    if (!parse_number(number, 0.0, 1e9, &x) || x == 0.0) return false;
    *out = x * factor;
    return true;
}

static bool parse_interval(const char *text, struct arg_interval *out)
{
    const size_t n = strlen(text);
    *out = (struct arg_interval){0};
    if (strcmp(text, "never") == 0) return true;
    if (n > 1 && n < 24 && text[n - 1] == 'i') {
        char number[24];
        memcpy(number, text, n - 1);
        number[n - 1] = '\0';
        return parse_whole(number, &out->steps) && out->steps > 0;
    }
    return parse_duration(text, &out->seconds);
}

/* n whole numbers between single separators. */
static bool parse_list(const char *text, char separator, uint32_t n, uint32_t *out)
{
    for (uint32_t i = 0; i < n; i++) {
        char *end;
        if (*text < '0' || *text > '9') return false;
        errno = 0;
        const unsigned long x = strtoul(text, &end, 10);
        if (errno != 0 || x > 1u << 20) return false;
        if (*end != (i + 1 < n ? separator : '\0')) return false;
        out[i] = (uint32_t)x;
        text = end + 1;
    }
    return true;
}

static bool parse_vector(const char *text, double out[3])
{
    for (uint32_t i = 0; i < 3; i++) {
        char *end;
        if (*text == '\0' || strchr(" \t\n,", *text)) return false;
        out[i] = strtod(text, &end);
        if (end == text || !isfinite(out[i]) || *end != (i < 2 ? ',' : '\0')) return false;
        text = end + 1;
    }
    return true;
}

static bool parse_choice(const char *text, const char *choices, uint32_t *out)
{
    const size_t n = strlen(text);
    uint32_t index = 0;
    for (const char *c = choices; *c; index++) {
        const size_t length = strcspn(c, " ");
        if (length == n && strncmp(c, text, n) == 0) {
            *out = index;
            return true;
        }
        c += length;
        if (*c == ' ') c++;
    }
    return false;
}

/* What a value of this type looks like, for the message that refuses another. */
static void describe(const struct arg_option *o, char *text, size_t size)
{
    switch (o->type) {
    case ARG_COUNT:
    case ARG_INTEGER:
    case ARG_NUMBER:
        if (o->max > o->min)
            snprintf(text, size, "a %snumber from %.10g to %.10g",
                     o->type == ARG_NUMBER ? "" : "whole ", o->min, o->max);
        else
            snprintf(text, size, "a %snumber of at least %.10g",
                     o->type == ARG_NUMBER ? "" : "whole ", o->min);
        break;
    case ARG_WHOLE:
        snprintf(text, size, "a whole number of at least 0");
        break;
    case ARG_CHOICE:
        snprintf(text, size, "one of: %s", o->choices);
        break;
    case ARG_SIZE:
        snprintf(text, size, "WIDTHxHEIGHT, as 640x480");
        break;
    case ARG_CROP:
        snprintf(text, size, "X,Y,WIDTH,HEIGHT, as 0,0,64,64");
        break;
    case ARG_VECTOR:
        snprintf(text, size, "X,Y,Z, as 0,1.5,-2");
        break;
    case ARG_DURATION:
        snprintf(text, size, "a time, as 90s, 15m or 2h");
        break;
    case ARG_INTERVAL:
        snprintf(text, size, "steps or a time, as 100i or 5m, or never");
        break;
    default:
        snprintf(text, size, "a value");
        break;
    }
}

static bool store(const struct arg_option *o, void *place, const char *text)
{
    double x;
    switch (o->type) {
    case ARG_FLAG:
        *(uint32_t *)place = 1;
        return true;
    case ARG_TEXT:
    case ARG_FILE:
        *(const char **)place = text;
        return true;
    case ARG_MAYBE:
        *(const char **)place = text ? text : "";
        return true;
    case ARG_LIST: {
        struct arg_list *list = place;
        if (list->n == ARG_LIST_MAX) return false;
        list->items[list->n++] = text;
        return true;
    }
    case ARG_COUNT:
        if (!parse_number(text, o->min, o->max > 0 ? o->max : (double)UINT32_MAX, &x)) return false;
        *(uint32_t *)place = (uint32_t)x;
        return x == floor(x);
    case ARG_INTEGER:
        if (!parse_number(text, o->min, o->max > 0 ? o->max : INT32_MAX, &x)) return false;
        *(int32_t *)place = (int32_t)x;
        return x == floor(x);
    case ARG_NUMBER:
        return parse_number(text, o->min, o->max, place);
    case ARG_WHOLE:
        return parse_whole(text, place);
    case ARG_CHOICE:
        return parse_choice(text, o->choices, place);
    case ARG_SIZE: {
        uint32_t *size = place;
        return parse_list(text, 'x', 2, size) && size[0] > 0 && size[1] > 0;
    }
    case ARG_CROP: {
        uint32_t *crop = place;
        return parse_list(text, ',', 4, crop) && crop[2] > 0 && crop[3] > 0;
    }
    case ARG_VECTOR:
        return parse_vector(text, place);
    case ARG_DURATION:
        return parse_duration(text, place);
    case ARG_INTERVAL:
        return parse_interval(text, place);
    }
    return false;
}

enum { MAX_OPTIONS = 96 };

/* The tables of a command, flattened for getopt_long(); its `val` is 256 + index. */
struct flat {
    const struct arg_option *options[MAX_OPTIONS];
    size_t bases[MAX_OPTIONS];
    const char *names[MAX_OPTIONS];
    struct option longs[MAX_OPTIONS + 1];
    char shorts[2 * MAX_OPTIONS + 2];
    int n;
};

static void flatten(const struct command *c, struct flat *f)
{
    size_t k = 0;
    f->n = 0;
    f->shorts[k++] = ':'; /* tells a missing value from an unknown option */
    for (size_t g = 0; g < c->n_groups; g++) {
        for (size_t i = 0; i < c->groups[g].n && f->n < MAX_OPTIONS; i++) {
            const struct arg_option *o = &c->groups[g].options[i];
            f->options[f->n] = o;
            f->bases[f->n] = c->groups[g].base;
            f->names[f->n] = o->name;
            int value = o->type == ARG_FLAG    ? no_argument
                        : o->type == ARG_MAYBE ? optional_argument
                                               : required_argument;
            f->longs[f->n] = (struct option){o->name, value, NULL, 256 + f->n};
            if (o->letter) {
                f->shorts[k++] = o->letter;
                if (o->type != ARG_FLAG) f->shorts[k++] = ':';
            }
            f->n++;
        }
    }
    f->shorts[k] = '\0';
    f->longs[f->n] = (struct option){0};
}

static int find_letter(const struct flat *f, int letter)
{
    for (int i = 0; i < f->n; i++)
        if (f->options[i]->letter == letter) return i;
    return -1;
}

/* getopt_long() said '?': an unknown option, or a value given to a flag. */
static int bad_option(const struct command *c, const struct flat *f, const char *word)
{
    char hint[160], name[64];
    if (optopt >= 256)
        return usage_error("option --%s takes no value", f->options[optopt - 256]->name);
    if (optopt != 0)
        return usage_error("unknown option -%c; see lumenaut %s --help", optopt, c->name);
    snprintf(name, sizeof name, "%.*s", (int)strcspn(word + 2, "="), word + 2);
    suggest(hint, sizeof hint, name, "--", f->names, (size_t)f->n);
    if (hint[0]) return usage_error("unknown option --%s%s", name, hint);
    return usage_error("unknown option --%s; see lumenaut %s --help", name, c->name);
}

int args_parse(const struct command *c, int argc, char **argv, void *args)
{
    struct common_args *common = args;
    struct flat f;
    int got;
    flatten(c, &f);
    if (c->init) c->init(args);
    opterr = 0;
    optind = 1;
    while ((got = getopt_long(argc, argv, f.shorts, f.longs, NULL)) != -1) {
        if (got == '?') return bad_option(c, &f, argv[optind - 1]);
        if (got == ':') {
            const int i = optopt >= 256 ? optopt - 256 : find_letter(&f, optopt);
            return usage_error("option --%s needs %s%s", f.options[i]->name,
                               f.options[i]->argument ? "a value: " : "a value",
                               f.options[i]->argument ? f.options[i]->argument : "");
        }
        const int i = got >= 256 ? got - 256 : find_letter(&f, got);
        const struct arg_option *o = f.options[i];
        char *base = (char *)args + f.bases[i];
        if (!store(o, base + o->offset, optarg)) {
            char expected[256];
            describe(o, expected, sizeof expected);
            return usage_error("--%s %s: expected %s", o->name, optarg, expected);
        }
        if (o->given) *(uint32_t *)(base + o->given) = 1;
    }
    common->operands = argv + optind;
    common->n_operands = (uint32_t)(argc - optind);
    if (common->help) return EXIT_OK;
    if (common->n_operands < c->min_operands)
        return usage_error("%s needs %s; see lumenaut %s --help", c->name, c->operands, c->name);
    if (common->n_operands > c->max_operands)
        return usage_error("%s: unexpected argument \"%s\"; see lumenaut %s --help", c->name,
                           common->operands[c->max_operands], c->name);
    return EXIT_OK;
}
