/* SPDX-License-Identifier: Apache-2.0 */
/* Values of variables: defaults, draws, and what users write after -P. */
#include "api/handles.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"

void lmn_scene_default_values(const lmn_scene *scene, double *values)
{
    for (uint32_t i = 0; i < scene->scene->n_variables; i++)
        values[i] = scene->scene->variables[i].value;
}

/* The names of variables and of groups of several, for suggestions. */
static const char *closest_name(const struct scene *s, const char *word)
{
    const char *best = NULL;
    const char **names = mem_new(2 * (size_t)s->n_variables + 1, sizeof *names);
    if (!names) return NULL;
    for (uint32_t i = 0; i < s->n_variables; i++) {
        names[2 * i] = s->variables[i].name;
        names[2 * i + 1] = s->variables[i].group;
    }
    best = str_closest(word, names, 2 * (size_t)s->n_variables);
    mem_free(names);
    return best;
}

static lmn_status fail_unknown(const struct scene *s, const char *name, struct error *err)
{
    const char *near = closest_name(s, name);
    if (s->n_variables == 0)
        return fail(err, LMN_ERR_ARGUMENT, "%s: the scene has no variables", name);
    if (near)
        return fail(err, LMN_ERR_ARGUMENT, "%s: no such variable; did you mean \"%s\"?", name,
                    near);
    return fail(err, LMN_ERR_ARGUMENT, "%s: no such variable (`lumenaut params` lists them)", name);
}

/* A discrete variable takes the name of a choice or its number. */
static lmn_status parse_choice(const struct variable *v, const char *text, double *out,
                               struct error *err)
{
    double number;
    for (uint32_t i = 0; i < v->n_choices; i++) {
        if (strcmp(v->choices[i], text) == 0) {
            *out = i;
            return LMN_OK;
        }
    }
    if (str_to_double(text, &number) && number >= 0.0 && number < v->n_choices &&
        number == floor(number)) {
        *out = number;
        return LMN_OK;
    }
    const char *near = str_closest(text, v->choices, v->n_choices);
    return fail(err, LMN_ERR_ARGUMENT, "%s=%s: no such choice%s%s%s", v->name, text,
                near ? "; did you mean \"" : " (`lumenaut params` lists them)", near ? near : "",
                near ? "\"?" : "");
}

static lmn_status parse_number(const struct variable *v, const char *text, double *out,
                               struct error *err)
{
    char number[64];
    double x;
    const size_t n = strlen(text);
    const bool is_share = n > 0 && text[n - 1] == '%';
    if (n == 0 || n >= sizeof number)
        return fail(err, LMN_ERR_ARGUMENT, "%s=%s: not a number", v->name, text);
    memcpy(number, text, n + 1);
    if (is_share) number[n - 1] = '\0';
    if (!str_to_double(number, &x))
        return fail(err, LMN_ERR_ARGUMENT, "%s=%s: not a number", v->name, text);
    if (is_share) {
        if (x < 0.0 || x > 100.0)
            return fail(err, LMN_ERR_ARGUMENT, "%s=%s: a share is 0%% to 100%%", v->name, text);
        x = v->min + (v->max - v->min) * (x / 100.0);
    }
    /* What was printed with few digits must be accepted again. */
    const double slack = 1e-6 * fmax(fabs(v->min), fabs(v->max));
    if (x < v->min - slack || x > v->max + slack)
        return fail(err, LMN_ERR_ARGUMENT, "%s=%s: out of range; %g to %g%s%s", v->name, text,
                    v->min, v->max, v->unit && *v->unit ? " " : "", v->unit ? v->unit : "");
    *out = fmin(fmax(x, v->min), v->max);
    return LMN_OK;
}

static lmn_status parse_one(const struct variable *v, const char *text, double *out,
                            struct error *err)
{
    return v->n_choices > 0 ? parse_choice(v, text, out, err) : parse_number(v, text, out, err);
}

/* "a,b,c" for the variables of a group, in declaration order; all are checked before any is set. */
static lmn_status parse_group(const struct scene *s, const char *group, char *list, double *values,
                              struct error *err)
{
    uint32_t n_members = 0, n_items = 1;
    for (uint32_t i = 0; i < s->n_variables; i++)
        n_members += strcmp(s->variables[i].group, group) == 0;
    for (const char *c = list; *c; c++) n_items += *c == ',';
    if (n_items != n_members)
        return fail(err, LMN_ERR_ARGUMENT, "%s: %u values for a group of %u variables", group,
                    n_items, n_members);
    for (int pass = 0; pass < 2; pass++) {
        char *item = list;
        for (uint32_t i = 0; i < s->n_variables; i++) {
            double x;
            if (strcmp(s->variables[i].group, group) != 0) continue;
            char *comma = strchr(item, ',');
            if (comma) *comma = '\0';
            const lmn_status status = parse_one(&s->variables[i], item, &x, err);
            if (comma) *comma = ',';
            if (status != LMN_OK) return status;
            if (pass == 1) values[i] = x;
            item = comma ? comma + 1 : item;
        }
    }
    return LMN_OK;
}

lmn_status lmn_scene_parse_value(lmn_context *context, const lmn_scene *scene,
                                 const char *assignment, double *values)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    const struct scene *s = scene->scene;
    char *name = mem_strdup(assignment);
    if (!name) {
        status = fail_memory(err, "a value");
        goto done;
    }
    char *equals = strchr(name, '=');
    if (!equals || equals == name) {
        status = fail(err, LMN_ERR_ARGUMENT, "%s: expected NAME=VALUE", assignment);
        goto done;
    }
    *equals = '\0';
    for (uint32_t i = 0; i < s->n_variables; i++) {
        if (strcmp(s->variables[i].name, name) == 0) {
            status = parse_one(&s->variables[i], equals + 1, &values[i], err);
            goto done;
        }
    }
    for (uint32_t i = 0; i < s->n_variables; i++) {
        if (strcmp(s->variables[i].group, name) == 0) {
            status = parse_group(s, name, equals + 1, values, err);
            goto done;
        }
    }
    status = fail_unknown(s, name, err);
done:
    mem_free(name);
    return status;
}

lmn_status scene_units(const lmn_scene *scene, const double *values, float *u, struct error *err)
{
    const struct scene *s = scene->scene;
    for (uint32_t i = 0; i < s->n_variables; i++) {
        const struct variable *v = &s->variables[i];
        const double x = values ? values[i] : v->value;
        const double low = v->n_choices ? 0.0 : v->min;
        const double high = v->n_choices ? v->n_choices - 1.0 : v->max;
        if (!(x >= low && x <= high))
            return fail(err, LMN_ERR_ARGUMENT, "%s=%g: out of range; %g to %g", v->name, x, low,
                        high);
        u[i] = variable_to_unit(v, x);
    }
    return LMN_OK;
}
