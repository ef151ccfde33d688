/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "base/str.h"
#include "scene/variables_json_private.h"

enum { TARGETS_MAX = 1024 };

const json_t *entry_get(const struct entry *e, const char *key)
{
    return json_object_get(e->json, key);
}

lmn_status entry_no_memory(const struct entry *e)
{
    return fail_memory(e->r->err, "the variables");
}

/* ---- Variables ------------------------------------------------------------------------------ */

static struct drive constant(double value)
{
    return (struct drive){SCENE_NONE, (float)value, (float)value};
}

lmn_status entry_add_variable(struct entry *e, const char *suffix, struct variable v,
                              uint32_t *index)
{
    v.group = e->name;
    v.kind = e->kind;
    v.unit = e->unit;
    v.description = e->description;
    v.name = e->name;
    if (suffix) {
        size_t size = strlen(e->name) + strlen(suffix) + 2;
        char *name = arena_new(e->b->arena, size, 1);
        if (!name) return entry_no_memory(e);
        snprintf(name, size, "%s.%s", e->name, suffix);
        v.name = name;
    }
    return variable_set_add(e->b, e->place, &v, index, e->r->err);
}

lmn_status entry_add_range(struct entry *e, const char *suffix, double min, double max,
                           double value, struct drive *drive)
{
    struct variable v = {.min = min, .max = max, .value = value};
    *drive = (struct drive){.at_0 = (float)min, .at_1 = (float)max};
    return entry_add_variable(e, suffix, v, &drive->variable);
}

lmn_status entry_read_default(struct entry *e, const double range[2], double now, double *out)
{
    const json_t *json = entry_get(e, "default");
    *out = variable_default(now, range[0], range[1]);
    if (!json) return LMN_OK;
    json_reader_enter(e->r, "default", 0);
    lmn_status status = json_read_number(e->r, json, out);
    if (status == LMN_OK && !(*out >= range[0] && *out <= range[1]))
        status = json_reader_fail(e->r, "%g is not within the range %g to %g", *out, range[0],
                                  range[1]);
    if (status == LMN_OK) json_reader_leave(e->r);
    return status;
}

lmn_status entry_read_default3(struct entry *e, const json_t *json, const char *key,
                               const double min[3], const double max[3], const double now[3],
                               double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = variable_default(now[i], min[i], max[i]);
    if (!json) return LMN_OK;
    json_reader_enter(e->r, key, 0);
    lmn_status status = json_read_numbers(e->r, json, 3, out);
    if (status != LMN_OK) return status;
    for (int i = 0; i < 3; i++) {
        json_reader_enter(e->r, NULL, (size_t)i);
        if (!(out[i] >= min[i] && out[i] <= max[i]))
            return min[i] < max[i]
                       ? json_reader_fail(e->r, "%g is not within the range %g to %g", out[i],
                                          min[i], max[i])
                       : json_reader_fail(e->r, "this component does not vary: it is %g", min[i]);
        json_reader_leave(e->r);
    }
    json_reader_leave(e->r);
    return LMN_OK;
}

lmn_status entry_add_box(struct entry *e, const char *const suffixes[3], const double min[3],
                         const double max[3], const double value[3], struct drive drive[3])
{
    for (int i = 0; i < 3; i++) {
        if (min[i] == max[i]) {
            drive[i] = constant(min[i]);
            continue;
        }
        lmn_status status = entry_add_range(e, suffixes[i], min[i], max[i], value[i], &drive[i]);
        if (status != LMN_OK) return status;
    }
    return LMN_OK;
}

lmn_status entry_check_varies(struct entry *e, const char *key)
{
    if (e->b->variables->n_variables > e->first) return LMN_OK;
    json_reader_enter(e->r, key, 0);
    return json_reader_fail(e->r, "nothing varies: min and max are equal in every component");
}

/* ---- Targets -------------------------------------------------------------------------------- */

static lmn_status unknown_target(struct entry *e, const char *text)
{
    const char *closest = target_closest(&e->b->variables->targets, text);
    if (!closest) closest = builder_closest(e->b, text);
    return json_reader_fail(e->r, "the scene has no \"%.200s\"%s%.200s%s", text,
                            DID_YOU_MEAN(closest));
}

lmn_status entry_find_target(struct entry *e, const char *text, enum param_type wanted,
                             const char *const *suffixes, size_t n_suffixes,
                             const struct target **out)
{
    const struct target_list *list = &e->b->variables->targets;
    const struct target *t = target_find(list, text, "", wanted);
    const struct target *other = t;
    for (size_t i = 0; i < n_suffixes && (!t || t->type != wanted); i++) {
        t = target_find(list, text, suffixes[i], wanted);
        if (t && !other) other = t;
    }
    if (t && t->type == wanted) {
        *out = t;
        return LMN_OK;
    }
    if (!other) return unknown_target(e, text);
    return json_reader_fail(e->r, "\"%.200s\" is a %s, but the kind \"%s\" drives a %s", text,
                            param_type_name(other->type), e->kind, param_type_name(wanted));
}

lmn_status entry_read_targets(struct entry *e, enum param_type wanted, const char *const *suffixes,
                              size_t n_suffixes)
{
    lmn_status status = LMN_OK;
    const json_t *json = entry_get(e, "targets");
    bool is_list = json_is_array(json);
    size_t n = is_list ? json_array_size(json) : 1;
    json_reader_enter(e->r, "targets", 0);
    if (n == 0 || n > TARGETS_MAX) {
        status = json_reader_fail(e->r, "there must be 1 to %d targets", TARGETS_MAX);
        goto done;
    }
    e->targets = arena_new(e->b->arena, n, sizeof *e->targets);
    if (!e->targets) {
        status = entry_no_memory(e);
        goto done;
    }
    for (size_t i = 0; i < n; i++) {
        const char *text;
        if (is_list) json_reader_enter(e->r, NULL, i);
        TRY(json_read_string(e->r, is_list ? json_array_get(json, i) : json, &text));
        TRY(entry_find_target(e, text, wanted, suffixes, n_suffixes, &e->targets[e->n_targets]));
        e->n_targets++;
        if (is_list) json_reader_leave(e->r);
    }
    json_reader_leave(e->r);
done:
    return status;
}

lmn_status entry_write_targets(struct entry *e, struct write w)
{
    w.place = e->place;
    w.first = e->first;
    w.count = e->b->variables->n_variables - e->first;
    for (size_t i = 0; i < e->n_targets; i++) {
        w.target = *e->targets[i];
        lmn_status status = variable_set_write(e->b, &w, e->r->err);
        if (status != LMN_OK) return status;
    }
    return LMN_OK;
}
