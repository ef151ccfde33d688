/* SPDX-License-Identifier: Apache-2.0 */
/* Methods that bench learn compares, by name and options. */
#include "learn.h"

#include <ctype.h>
#include <string.h>

void learn_uniform_options(lmn_train_options *o)
{
    lmn_train_options_init_method(o, LMN_METHOD_IMPROVED);
    o->explore = LMN_EXPLORE_UNIFORM;
}

static int set_method(struct app *app, const struct learn_args *a, const char *name,
                      lmn_train_options *o)
{
    static const char *const names[] = {"faithful", "uniform", "improved"};
    char hint[128];
    if (strcmp(name, "faithful") == 0) {
        lmn_train_options_init(o);
        o->width = a->width_faithful;
    } else if (strcmp(name, "improved") == 0) {
        lmn_train_options_init_method(o, LMN_METHOD_IMPROVED);
    } else if (strcmp(name, "uniform") == 0) {
        learn_uniform_options(o);
    } else {
        suggest(hint, sizeof hint, name, "", names, COUNT_OF(names));
        return app_error(app, EXIT_USAGE,
                         "--methods: unknown method \"%s\" (faithful, uniform, improved)%s", name,
                         hint);
    }
    return EXIT_OK;
}

/* One item of the list: NAME, then options after colons. */
static int parse_method(struct app *app, const struct learn_args *a, const char *text,
                        struct learn_method *m)
{
    char words[LEARN_NAME], assignment[LEARN_NAME + 8], *rest = NULL;
    const char *json;
    snprintf(words, sizeof words, "%s", text);
    snprintf(m->label, sizeof m->label, "%s", text);
    const char *word = strtok_r(words, ":", &rest);
    int code = set_method(app, a, word ? word : "", &m->options);
    while (code == EXIT_OK && (word = strtok_r(NULL, ":", &rest))) {
        const bool is_width = strspn(word, "0123456789") == strlen(word);
        snprintf(assignment, sizeof assignment, "%s%s", is_width ? "width=" : "", word);
        const lmn_status status = lmn_train_options_set(app->context, &m->options, assignment);
        if (status != LMN_OK) code = app_failed(app, status, BLAME_USER);
    }
    if (code != EXIT_OK) return code;
    const lmn_status status = lmn_train_options_json(app->context, &m->options, &json);
    if (status != LMN_OK) return app_failed(app, status, BLAME_USER);
    snprintf(m->file, sizeof m->file, "%s", m->label);
    for (char *c = m->file; *c; c++)
        if (!isalnum((unsigned char)*c) && !strchr("=_.", *c)) *c = '-';
    return EXIT_OK;
}

int learn_parse_methods(struct app *app, const struct learn_args *a, struct learn_method *out,
                        uint32_t *n)
{
    char item[LEARN_NAME];
    *n = 0;
    for (const char *at = a->methods;; at++) {
        const size_t length = strcspn(at, ",");
        if (length >= sizeof item)
            return app_error(app, EXIT_USAGE, "--methods: %.40s...: too long", at);
        if (*n == LEARN_MAX_METHODS)
            return app_error(app, EXIT_USAGE, "--methods: more than %d", (int)LEARN_MAX_METHODS);
        memcpy(item, at, length);
        item[length] = '\0';
        const int code = parse_method(app, a, item, &out[*n]);
        if (code != EXIT_OK) return code;
        for (uint32_t i = 0; i < *n; i++)
            if (strcmp(out[i].file, out[*n].file) == 0)
                return app_error(app, EXIT_USAGE, "--methods: \"%s\" is there twice", item);
        ++*n;
        at += length;
        if (*at == '\0') return EXIT_OK;
    }
}
