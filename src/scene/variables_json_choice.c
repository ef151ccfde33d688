/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "base/str.h"
#include "scene/variables_json_private.h"

enum { CHOICES_MAX = 4096, SHAPES_MAX = 1024 };

static const char *const BSDF[] = {".bsdf"};
static const char *const VISIBLE[] = {".visible"};

/* Which of the choices the default names. */
static lmn_status read_default_choice(struct entry *e, const char *const *choices, uint32_t n,
                                      double *value)
{
    const json_t *def = entry_get(e, "default");
    const char *text;
    if (!def) return LMN_OK;
    json_reader_enter(e->r, "default", 0);
    lmn_status status = json_read_string(e->r, def, &text);
    if (status != LMN_OK) return status;
    for (uint32_t i = 0; i < n; i++) {
        if (strcmp(choices[i], text) != 0) continue;
        *value = i;
        json_reader_leave(e->r);
        return LMN_OK;
    }
    const char *closest = str_closest(text, choices, n);
    return json_reader_fail(e->r, "\"%.200s\" is not among the choices%s%.200s%s", text,
                            DID_YOU_MEAN(closest));
}

/* Names of choices, without doubles; "name" of an object. */
static lmn_status read_choices(struct entry *e, bool is_of_shapes, const char ***out, uint32_t *n)
{
    static const char *const keys[] = {"name", "shapes"};
    lmn_status status = LMN_OK;
    const json_t *json = entry_get(e, "choices");
    json_reader_enter(e->r, "choices", 0);
    if (!json_is_array(json) || json_array_size(json) < 2 || json_array_size(json) > CHOICES_MAX) {
        status = json_reader_fail(e->r, "this must be a list of 2 to %d choices", CHOICES_MAX);
        goto done;
    }
    *n = (uint32_t)json_array_size(json);
    *out = arena_new(e->b->arena, *n, sizeof **out);
    if (!*out) {
        status = entry_no_memory(e);
        goto done;
    }
    for (uint32_t i = 0; i < *n; i++) {
        const json_t *item = json_array_get(json, i);
        const char *text;
        json_reader_enter(e->r, NULL, i);
        if (is_of_shapes && json_is_object(item)) {
            TRY(json_check_keys(e->r, item, keys, 2));
            json_reader_enter(e->r, "name", 0);
            TRY(json_read_string(e->r, json_object_get(item, "name"), &text));
            json_reader_leave(e->r);
        } else {
            TRY(json_read_string(e->r, item, &text));
        }
        for (uint32_t k = 0; k < i; k++) {
            if (strcmp((*out)[k], text) != 0) continue;
            status = json_reader_fail(e->r, "the choice \"%.200s\" is given twice", text);
            goto done;
        }
        (*out)[i] = arena_strdup(e->b->arena, text);
        if (!(*out)[i]) {
            status = entry_no_memory(e);
            goto done;
        }
        json_reader_leave(e->r);
    }
    json_reader_leave(e->r);
done:
    return status;
}

/* One of several textures or materials. */
static lmn_status read_choice_of_objects(struct entry *e)
{
    lmn_status status = LMN_OK;
    const char **choices;
    struct variable v = {0};
    struct write w = {.kind = BINDING_CHOICE};
    const json_t *json = entry_get(e, "targets");
    const char *text = json_string_value(json_is_array(json) ? json_array_get(json, 0) : json);
    const struct target *t = text ? target_find(&e->b->variables->targets, text, "", PARAM_TEXTURE)
                                  : NULL;
    bool is_texture = t && t->type == PARAM_TEXTURE;
    TRY(entry_read_targets(e, is_texture ? PARAM_TEXTURE : PARAM_BSDF, BSDF, 1));
    TRY(read_choices(e, false, &choices, &v.n_choices));
    w.options = arena_new(e->b->arena, v.n_choices, sizeof *w.options);
    if (!w.options) {
        status = entry_no_memory(e);
        goto done;
    }
    uint32_t present;
    memcpy(&present, target_in(e->targets[0], e->b), sizeof present);
    json_reader_enter(e->r, "choices", 0);
    for (uint32_t i = 0; i < v.n_choices; i++) {
        enum builder_kind kind;
        json_reader_enter(e->r, NULL, i);
        if (!builder_find(e->b, choices[i], &kind, &w.options[i])) {
            const char *closest = builder_closest(e->b, choices[i]);
            status = json_reader_fail(e->r, "the scene has no %s \"%.200s\"%s%.200s%s",
                                      is_texture ? "texture" : "bsdf", choices[i],
                                      DID_YOU_MEAN(closest));
            goto done;
        }
        if (kind != (is_texture ? BUILDER_TEXTURE : BUILDER_BSDF)) {
            status = json_reader_fail(e->r, "\"%.200s\" is not a %s", choices[i],
                                      is_texture ? "texture" : "bsdf");
            goto done;
        }
        if (w.options[i] == present) v.value = i;
        json_reader_leave(e->r);
    }
    json_reader_leave(e->r);
    TRY(read_default_choice(e, choices, v.n_choices, &v.value));
    v.max = v.n_choices - 1.0;
    v.choices = choices;
    TRY(entry_add_variable(e, NULL, v, &w.variable));
    TRY(entry_write_targets(e, w));
    for (size_t i = 0; i < e->n_targets; i++) {
        /* One "alpha" stands for both directions. */
        const struct target *a = e->targets[i];
        if (a->owner != BUILDER_BSDF || a->offset != offsetof(struct bsdf, alpha_u)) continue;
        const struct bsdf *f = &e->b->bsdfs[a->index].bsdf;
        if (f->alpha_u != f->alpha_v) continue;
        struct target both = *a;
        both.offset = offsetof(struct bsdf, alpha_v);
        w.target = both;
        w.place = e->place;
        w.first = e->first;
        w.count = 1;
        TRY(variable_set_write(e->b, &w, e->r->err));
    }
done:
    return status;
}

/* Shows the shape or instance `name` when the variable takes this choice. */
static lmn_status write_alternative(struct entry *e, const char *name, uint32_t variable,
                                    uint32_t choice)
{
    enum builder_kind kind;
    uint32_t index;
    if (!builder_find(e->b, name, &kind, &index)) {
        const char *closest = builder_closest(e->b, name);
        return json_reader_fail(e->r, "the scene has no shape \"%.200s\"%s%.200s%s", name,
                                DID_YOU_MEAN(closest));
    }
    if (kind != BUILDER_SHAPE && kind != BUILDER_INSTANCE)
        return json_reader_fail(e->r, "\"%.200s\" is not a shape or an instance", name);
    for (size_t i = 0; i < e->b->variables->n_writes; i++) {
        const struct write *w = &e->b->variables->writes[i];
        if (w->first == e->first && w->target.owner == kind && w->target.index == index)
            return json_reader_fail(e->r, "\"%.200s\" is in two choices", name);
    }
    const struct target *t;
    lmn_status status = entry_find_target(e, name, PARAM_BOOL, VISIBLE, 1, &t);
    if (status != LMN_OK) return status;
    struct write w = {.target = *t,
                      .place = e->place,
                      .first = e->first,
                      .count = 1,
                      .kind = BINDING_VISIBLE,
                      .condition = {variable, choice}};
    return variable_set_write(e->b, &w, e->r->err);
}

/* One of several shapes or sets of shapes. */
static lmn_status read_choice_of_shapes(struct entry *e)
{
    lmn_status status = LMN_OK;
    const char **choices;
    struct variable v = {0};
    uint32_t variable;
    TRY(read_choices(e, true, &choices, &v.n_choices));
    TRY(read_default_choice(e, choices, v.n_choices, &v.value));
    v.max = v.n_choices - 1.0;
    v.choices = choices;
    TRY(entry_add_variable(e, NULL, v, &variable));
    json_reader_enter(e->r, "choices", 0);
    for (uint32_t i = 0; i < v.n_choices; i++) {
        const json_t *item = json_array_get(entry_get(e, "choices"), i);
        const json_t *shapes = json_object_get(item, "shapes");
        json_reader_enter(e->r, NULL, i);
        if (!json_is_object(item)) {
            TRY(write_alternative(e, choices[i], variable, i));
        } else {
            json_reader_enter(e->r, "shapes", 0);
            if (!json_is_array(shapes) || json_array_size(shapes) > SHAPES_MAX) {
                status = json_reader_fail(e->r, "this must be a list of names of shapes");
                goto done;
            }
            for (size_t k = 0; k < json_array_size(shapes); k++) {
                const char *text;
                json_reader_enter(e->r, NULL, k);
                TRY(json_read_string(e->r, json_array_get(shapes, k), &text));
                TRY(write_alternative(e, text, variable, i));
                json_reader_leave(e->r);
            }
            json_reader_leave(e->r);
        }
        json_reader_leave(e->r);
    }
    json_reader_leave(e->r);
done:
    return status;
}

lmn_status entry_read_choice(struct entry *e)
{
    return entry_get(e, "targets") ? read_choice_of_objects(e) : read_choice_of_shapes(e);
}
