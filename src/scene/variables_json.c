/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/variables_json.h"

#include <string.h>

#include "base/str.h"
#include "scene/variables_json_private.h"

enum { KEYS_MAX = 12 };

static const struct kind {
    const char *name, *unit;
    lmn_status (*read)(struct entry *e);
    const char *keys[KEYS_MAX]; /* besides those of every kind */
} KINDS[] = {
    {"camera", "", entry_read_camera, {"origin", "target", "up"}},
    {"translate", "", entry_read_translate, {"targets", "range", "direction"}},
    {"rotate", "deg", entry_read_rotate, {"targets", "range", "axis", "pivot"}},
    {"scale", "", entry_read_scale, {"targets", "range", "pivot"}},
    {"color", "", entry_read_color, {"targets", "range", "from", "to"}},
    {"float", "", entry_read_float, {"targets", "range"}},
    {"choice", "", entry_read_choice, {"targets", "choices"}},
    {"visible", "", entry_read_visible, {"targets"}},
    {"envmap", "deg", entry_read_envmap, {"targets", "range", "axis"}},
    {"intensity", "", entry_read_intensity, {"targets", "range"}},
};
enum { N_KINDS = sizeof KINDS / sizeof *KINDS };

static lmn_status read_kind(struct entry *e, const struct kind **kind)
{
    const char *text;
    const char *names[N_KINDS];
    json_reader_enter(e->r, "kind", 0);
    lmn_status status = json_read_string(e->r, entry_get(e, "kind"), &text);
    if (status != LMN_OK) return status;
    for (size_t i = 0; i < N_KINDS; i++) {
        names[i] = KINDS[i].name;
        if (strcmp(text, names[i]) == 0) *kind = &KINDS[i];
    }
    if (!*kind) {
        const char *closest = str_closest(text, names, N_KINDS);
        return json_reader_fail(e->r, "there is no kind \"%.200s\"%s%s%s", text,
                                DID_YOU_MEAN(closest));
    }
    json_reader_leave(e->r);
    return LMN_OK;
}

/* "name", "unit" and "description", which every kind has. */
static lmn_status read_names(struct entry *e, const struct kind *kind)
{
    lmn_status status = LMN_OK;
    const char *text;
    const struct variable_set *set = e->b->variables;
    json_reader_enter(e->r, "name", 0);
    TRY(json_read_string(e->r, entry_get(e, "name"), &text));
    e->place = json_reader_place(e->r);
    for (uint32_t i = 0; i < set->n_variables; i++) {
        if (strcmp(set->variables[i].group, text) != 0) continue;
        status = json_reader_fail(e->r, "there is a variable \"%.200s\" already", text);
        goto done;
    }
    e->name = arena_strdup(e->b->arena, text);
    json_reader_leave(e->r);
    text = kind->unit;
    if (entry_get(e, "unit")) {
        json_reader_enter(e->r, "unit", 0);
        TRY(json_read_string(e->r, entry_get(e, "unit"), &text));
        json_reader_leave(e->r);
    }
    e->unit = arena_strdup(e->b->arena, text);
    text = "";
    if (entry_get(e, "description")) {
        json_reader_enter(e->r, "description", 0);
        TRY(json_read_string(e->r, entry_get(e, "description"), &text));
        json_reader_leave(e->r);
    }
    e->description = arena_strdup(e->b->arena, text);
    if (!e->name || !e->unit || !e->description) status = entry_no_memory(e);
done:
    return status;
}

static lmn_status read_entry(struct json_reader *r, struct builder *b, const json_t *json)
{
    static const char *const common[] = {"name", "kind", "description", "default", "unit"};
    const char *keys[KEYS_MAX + sizeof common / sizeof *common];
    size_t n = sizeof common / sizeof *common;
    lmn_status status = LMN_OK;
    const struct kind *kind = NULL;
    struct entry e = {.r = r, .b = b, .json = json, .first = b->variables->n_variables};
    if (!json_is_object(json)) {
        status = json_reader_fail(r, "a variable must be an object {\"name\": ..., \"kind\": ...}");
        goto done;
    }
    TRY(read_kind(&e, &kind));
    e.kind = kind->name;
    memcpy(keys, common, sizeof common);
    for (size_t i = 0; i < KEYS_MAX && kind->keys[i]; i++) keys[n++] = kind->keys[i];
    TRY(json_check_keys(r, json, keys, n));
    TRY(read_names(&e, kind));
    TRY(kind->read(&e));
    TRY(variable_set_name_targets(b, e.first, b->variables->n_variables - e.first, r->err));
done:
    return status;
}

lmn_status variables_read_json(struct builder *b, const char *path, struct error *err)
{
    static const char *const keys[] = {"variables", "$schema", "description"};
    lmn_status status = LMN_OK;
    struct json_reader r;
    TRY(json_reader_init(&r, path, err));
    TRY(variable_set_new(b, err));
    if (!json_is_object(r.root)) {
        status = json_reader_fail(&r, "this must be an object {\"variables\": [...]}");
        goto done;
    }
    TRY(json_check_keys(&r, r.root, keys, sizeof keys / sizeof *keys));
    const json_t *list = json_object_get(r.root, "variables");
    json_reader_enter(&r, "variables", 0);
    if (!json_is_array(list)) {
        status = json_reader_fail(&r, list ? "this must be a list" : "a list is missing here");
        goto done;
    }
    for (size_t i = 0; i < json_array_size(list); i++) {
        json_reader_enter(&r, NULL, i);
        TRY(read_entry(&r, b, json_array_get(list, i)));
        json_reader_leave(&r);
    }
done:
    json_reader_release(&r);
    return status;
}
