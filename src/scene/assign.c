/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/assign.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

#include "base/rng.h"
#include "base/str.h"

/* Keeps these numbers apart from others drawn with the same seed. */
static const uint64_t STREAM = 0x7661726961626c65u;

/* ---- Whole configurations ------------------------------------------------------------------- */

void scene_default_values(const struct scene *s, double *values)
{
    for (uint32_t i = 0; i < s->n_variables; i++) values[i] = s->variables[i].value;
}

void scene_random_units(const struct scene *s, uint64_t seed, uint64_t index, float *u)
{
    struct rng rng = rng_keyed(seed, STREAM, index);
    for (uint32_t i = 0; i < s->n_variables; i++) u[i] = rng_float(&rng);
}

void scene_random_values(const struct scene *s, uint64_t seed, uint64_t index, double *values)
{
    struct rng rng = rng_keyed(seed, STREAM, index);
    for (uint32_t i = 0; i < s->n_variables; i++)
        values[i] = variable_from_unit(&s->variables[i], rng_float(&rng));
}

void scene_values_to_units(const struct scene *s, const double *values, float *u)
{
    for (uint32_t i = 0; i < s->n_variables; i++) {
        const struct variable *v = &s->variables[i];
        u[i] = variable_to_unit(v, values ? values[i] : v->value);
    }
}

/* ---- Assignments ---------------------------------------------------------------------------- */

/* The names that an assignment may have: variables and groups. */
static lmn_status unknown_name(const struct scene *s, const char *name, struct error *err)
{
    if (s->n_variables == 0)
        return fail(err, LMN_ERR_ARGUMENT, "%s: the scene has no variables", name);
    const char **names = mem_new(2 * (size_t)s->n_variables, sizeof *names);
    if (!names) return fail_memory(err, "names of variables");
    for (uint32_t i = 0; i < s->n_variables; i++) {
        names[2 * i] = s->variables[i].name;
        names[2 * i + 1] = s->variables[i].group;
    }
    const char *closest = str_closest(name, names, 2 * (size_t)s->n_variables);
    mem_free(names);
    if (closest)
        return fail(err, LMN_ERR_ARGUMENT, "unknown variable \"%.200s\"; did you mean \"%.200s\"?",
                    name, closest);
    return fail(err, LMN_ERR_ARGUMENT,
                "unknown variable \"%.200s\"; the first of this scene is \"%.200s\"", name,
                s->variables[0].name);
}

static lmn_status parse_choice(const struct variable *v, const char *text, double *out,
                               struct error *err)
{
    static const char *const words[3][2] = {{"false", "true"}, {"no", "yes"}, {"hidden", "shown"}};
    double number;
    for (uint32_t k = 0; k < v->n_choices; k++) {
        if (strcmp(v->choices[k], text) != 0) continue;
        *out = k;
        return LMN_OK;
    }
    for (int k = 0; k < 6 && strcmp(v->kind, "visible") == 0; k++) {
        if (strcmp(words[k / 2][k % 2], text) != 0) continue;
        *out = k % 2;
        return LMN_OK;
    }
    if (str_to_double(text, &number) && number == floor(number) && number >= 0 &&
        number < v->n_choices) {
        *out = number;
        return LMN_OK;
    }
    const char *closest = str_closest(text, v->choices, v->n_choices);
    return fail(err, LMN_ERR_ARGUMENT,
                "%s: \"%.200s\" is not among its choices; did you mean \"%.200s\"?", v->name, text,
                closest ? closest : v->choices[0]);
}

/* `text` without blanks around it; it is cut in place. */
static char *trim(char *text)
{
    while (isspace((unsigned char)*text)) text++;
    size_t n = strlen(text);
    while (n > 0 && isspace((unsigned char)text[n - 1])) text[--n] = '\0';
    return text;
}

/* text is changed. */
static lmn_status parse_one(const struct variable *v, char *text, double *out, struct error *err)
{
    double x;
    text = trim(text);
    size_t n = strlen(text);
    if (n > 1 && text[n - 1] == '%') {
        text[n - 1] = '\0';
        if (!str_to_double(text, &x))
            return fail(err, LMN_ERR_ARGUMENT, "%s: \"%.200s%%\" is not a number", v->name, text);
        if (!(x >= 0 && x <= 100))
            return fail(err, LMN_ERR_ARGUMENT, "%s: %g%% is outside 0%% .. 100%%", v->name, x);
        *out = v->n_choices ? fmin(floor(x / 100 * v->n_choices), v->max)
                            : v->min + x / 100 * (v->max - v->min);
        return LMN_OK;
    }
    if (v->n_choices) return parse_choice(v, text, out, err);
    if (*v->unit && str_ends(text, v->unit)) {
        text[n - strlen(v->unit)] = '\0';
        text = trim(text);
    }
    if (!str_to_double(text, &x))
        return fail(err, LMN_ERR_ARGUMENT,
                    "%s: \"%.200s\" is not a number; give %g to %g, or 0%% to 100%%", v->name, text,
                    v->min, v->max);
    /* What prints as the limit is the limit. */
    double slack = 1e-6 * fmax(fabs(v->min), fabs(v->max));
    if (!(x >= v->min - slack && x <= v->max + slack))
        return fail(err, LMN_ERR_ARGUMENT,
                    "%s: %g is outside its range %g .. %g%s%s; did you mean %g?", v->name, x,
                    v->min, v->max, *v->unit ? " " : "", v->unit, x < v->min ? v->min : v->max);
    *out = fmin(fmax(x, v->min), v->max);
    return LMN_OK;
}

/* The run of variables that `name` means. */
static bool find_run(const struct scene *s, const char *name, uint32_t *first, uint32_t *n)
{
    *n = 0;
    for (uint32_t i = 0; i < s->n_variables; i++) {
        if (strcmp(s->variables[i].name, name) == 0) {
            *first = i;
            *n = 1;
            return true;
        }
    }
    for (uint32_t i = 0; i < s->n_variables; i++) {
        if (strcmp(s->variables[i].group, name) != 0) continue;
        if ((*n)++ == 0) *first = i;
    }
    return *n > 0;
}

static lmn_status wrong_count(const struct scene *s, const char *name, uint32_t first, uint32_t n,
                              uint32_t given, struct error *err)
{
    struct str members = {0};
    for (uint32_t i = 0; i < n; i++)
        str_add(&members, "%s%s", i ? "," : "", s->variables[first + i].name);
    lmn_status status = n == 1
                            ? fail(err, LMN_ERR_ARGUMENT, "%s takes one value, not %u", name, given)
                            : fail(err, LMN_ERR_ARGUMENT, "%s takes %u values (%.300s), not %u",
                                   name, n, members.failed ? "" : members.text, given);
    str_release(&members);
    return status;
}

lmn_status scene_parse_value(const struct scene *s, const char *assignment, double *values,
                             struct error *err)
{
    lmn_status status = LMN_OK;
    uint32_t first = 0, n, given = 1;
    double *parsed = NULL;
    char *copy = mem_strdup(assignment);
    if (!copy) return fail_memory(err, "a value");
    char *equals = strchr(copy, '=');
    if (!equals) {
        status = fail(err, LMN_ERR_ARGUMENT, "\"%.200s\" is not NAME=VALUE", assignment);
        goto done;
    }
    *equals = '\0';
    char *name = trim(copy), *rest = equals + 1;
    if (!find_run(s, name, &first, &n)) {
        status = unknown_name(s, name, err);
        goto done;
    }
    for (const char *c = rest; *c; c++) given += *c == ',';
    if (given != n) {
        status = wrong_count(s, name, first, n, given, err);
        goto done;
    }
    parsed = mem_new(n, sizeof *parsed);
    if (!parsed) {
        status = fail_memory(err, "a value");
        goto done;
    }
    for (uint32_t i = 0; i < n; i++) {
        char *comma = strchr(rest, ',');
        if (comma) *comma = '\0';
        TRY(parse_one(&s->variables[first + i], rest, &parsed[i], err));
        if (comma) rest = comma + 1;
    }
    memcpy(&values[first], parsed, n * sizeof *parsed);
done:
    mem_free(parsed);
    mem_free(copy);
    return status;
}
