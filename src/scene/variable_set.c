/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/variable_set.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

#include "base/str.h"

lmn_status variable_set_new(struct builder *b, struct error *err)
{
    b->variables = arena_new(b->arena, 1, sizeof *b->variables);
    if (!b->variables) return fail_memory(err, "the variables");
    return target_list_init(&b->variables->targets, b, err);
}

/* Names are typed on command lines as NAME=VALUE, and stand in lists. */
static bool is_usable_name(const char *name)
{
    if (!*name) return false;
    for (const unsigned char *c = (const unsigned char *)name; *c; c++)
        if (*c <= ' ' || *c == '=' || *c == ',' || *c == 0x7F) return false;
    return true;
}

double variable_default(double value, double min, double max)
{
    double slack = 1e-6 * fmax(fabs(min), fabs(max));
    return value >= min - slack && value <= max + slack ? fmin(fmax(value, min), max)
                                                        : 0.5 * (min + max);
}

lmn_status variable_set_add(struct builder *b, struct place place, const struct variable *v,
                            uint32_t *index, struct error *err)
{
    struct variable_set *set = b->variables;
    if (!is_usable_name(v->name))
        return fail_at(err, place,
                       "\"%s\" is no name for a variable: it must not be empty or hold "
                       "spaces, \"=\" or \",\"",
                       v->name);
    for (uint32_t i = 0; i < set->n_variables; i++) {
        const struct variable *other = &set->variables[i];
        if (strcmp(other->name, v->name) == 0)
            return fail_at(err, place, "there is a variable \"%s\" already", v->name);
        if (strcmp(other->group, v->name) == 0 || strcmp(other->name, v->group) == 0)
            return fail_at(err, place, "\"%s\" is the name of a variable and of a group",
                           strcmp(other->group, v->name) == 0 ? v->name : v->group);
    }
    if (set->n_variables == VARIABLES_MAX)
        return fail_at(err, place, "more than %d variables", VARIABLES_MAX);
    *index = set->n_variables++;
    set->places[*index] = place;
    set->variables[*index] = *v;
    struct variable *added = &set->variables[*index];
    added->value = fmin(fmax(v->value, v->min), v->max);
    if (!added->targets) added->targets = "";
    return LMN_OK;
}

static bool is_same_place(const struct target *a, const struct target *b)
{
    return a->owner == b->owner && a->index == b->index && a->part == b->part &&
           a->offset == b->offset;
}

/* Moves and conditions of several variables add up, and a variable may be several steps of a move;
 * all else has one writer. */
static bool is_compatible(const struct write *a, const struct write *b)
{
    if (a->kind != b->kind || (a->kind != BINDING_TRANSFORM && a->kind != BINDING_VISIBLE))
        return false;
    return a->first != b->first || (a->kind == BINDING_TRANSFORM && a->step.kind != b->step.kind);
}

lmn_status variable_set_write(struct builder *b, const struct write *w, struct error *err)
{
    struct variable_set *set = b->variables;
    if (!w->target.path) return fail_memory(err, "the variables");
    for (size_t i = 0; i < set->n_writes; i++) {
        const struct write *other = &set->writes[i];
        if (!is_same_place(&other->target, &w->target) || is_compatible(other, w)) continue;
        if (other->first == w->first)
            return fail_at(err, w->place, "\"%s\" is given twice", w->target.path);
        return fail_at(err, w->place, "\"%s\" is driven by the variable \"%s\" already",
                       w->target.path, set->variables[other->first].group);
    }
    if (set->n_writes == set->capacity) {
        size_t capacity = set->capacity ? 2 * set->capacity : 16;
        struct write *bigger = arena_new(b->arena, capacity, sizeof *bigger);
        if (!bigger) return fail_memory(err, "the variables");
        if (set->n_writes) memcpy(bigger, set->writes, set->n_writes * sizeof *bigger);
        set->writes = bigger;
        set->capacity = capacity;
    }
    set->writes[set->n_writes++] = *w;
    if (w->target.owner == BUILDER_SHAPE && w->target.part != PART_BSDF)
        builder_make_movable(b, w->target.index);
    return LMN_OK;
}

lmn_status variable_set_name_targets(struct builder *b, uint32_t first, uint32_t count,
                                     struct error *err)
{
    struct variable_set *set = b->variables;
    struct str text = {0};
    for (size_t i = 0; i < set->n_writes; i++) {
        const struct write *w = &set->writes[i];
        /* Several steps that move one target follow each other. */
        if (w->first != first || (i > 0 && w->target.path == w[-1].target.path)) continue;
        str_add(&text, "%s%s", text.length ? " " : "", w->target.path);
    }
    const char *copy = text.failed ? NULL : arena_strdup(b->arena, text.length ? text.text : "");
    str_release(&text);
    if (!copy) return fail_memory(err, "the variables");
    for (uint32_t i = first; i < first + count; i++) set->variables[i].targets = copy;
    return LMN_OK;
}
