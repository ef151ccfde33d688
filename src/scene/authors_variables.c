/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/authors_variables.h"

#include <stdlib.h>
#include <string.h>

#include "base/str.h"
#include "scene/authors_private.h"

/* Ids may hold what names of variables must not. */
static const char *name_without_var(struct builder *b, const char *id)
{
    char *name = arena_strdup(b->arena, id + strlen("var_"));
    for (char *c = name; c && *c; c++)
        if ((unsigned char)*c <= ' ' || *c == '=' || *c == ',' || *c == 0x7F) *c = '_';
    return name;
}

struct item {
    enum builder_kind kind;
    uint32_t index;
    struct place place;
    bool is_included; /* from another file than the scene's own */
};

static int compare_items(const void *pa, const void *pb)
{
    const struct item *a = pa, *b = pb;
    bool a_first = a->kind == BUILDER_SENSOR, b_first = b->kind == BUILDER_SENSOR;
    if (a_first != b_first) return a_first ? -1 : 1;
    if (a->is_included != b->is_included) return a->is_included ? 1 : -1;
    int files = a->is_included ? strcmp(a->place.file, b->place.file) : 0;
    if (files) return files;
    if (a->place.line != b->place.line) return a->place.line < b->place.line ? -1 : 1;
    if (a->place.column != b->place.column) return a->place.column < b->place.column ? -1 : 1;
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

static size_t list_items(struct builder *b, struct item *items)
{
    size_t n = 0;
    for (int kind = BUILDER_TEXTURE; kind <= BUILDER_SENSOR; kind++) {
        uint32_t count = builder_count(b, (enum builder_kind)kind);
        for (uint32_t i = 0; i < count; i++) {
            const struct builder_object *o = builder_object(b, (enum builder_kind)kind, i);
            if (!o->id || !str_starts(o->id, "var_")) continue;
            if (items)
                items[n] = (struct item){(enum builder_kind)kind, i, o->place,
                                         o->place.file && strcmp(o->place.file, b->path) != 0};
            n++;
        }
    }
    return n;
}

static lmn_status declare(struct builder *b, const struct item *item, struct error *err)
{
    /* Arrays of the builder grow while variables are declared: keep a copy. */
    struct builder_object object = *builder_object(b, item->kind, item->index);
    struct declaring d = {.b = b, .object = &object, .err = err, .kind = ""};
    d.first = b->variables->n_variables;
    d.group = name_without_var(b, object.id);
    if (!d.group) return fail_memory(err, "the variables");
    lmn_status status = LMN_OK;
    switch (item->kind) {
    case BUILDER_SENSOR:
        status = authors_declare_sensor(&d);
        break;
    case BUILDER_SHAPE:
        status = authors_declare_placement(&d, BUILDER_SHAPE, item->index, NULL);
        break;
    case BUILDER_INSTANCE:
        status = authors_declare_placement(&d, BUILDER_INSTANCE, item->index,
                                           &b->instances[item->index].to_world);
        break;
    case BUILDER_EMITTER:
        status = authors_declare_emitter(&d, item->index);
        break;
    case BUILDER_BSDF:
        status = authors_declare_bsdf(&d, item->index);
        break;
    case BUILDER_GROUP:
        status = authors_declare_group(&d, item->index);
        break;
    case BUILDER_TEXTURE:
        break;
    }
    if (status != LMN_OK) return status;
    return variable_set_name_targets(b, d.first, b->variables->n_variables - d.first, err);
}

lmn_status variables_read_authors(struct builder *b, struct error *err)
{
    lmn_status status = LMN_OK;
    size_t n = list_items(b, NULL);
    struct item *items = NULL;
    if (n == 0) return LMN_OK;
    items = mem_new(n, sizeof *items);
    if (!items) return fail_memory(err, "the variables");
    list_items(b, items);
    qsort(items, n, sizeof *items, compare_items);
    TRY(variable_set_new(b, err));
    for (size_t i = 0; i < n; i++) TRY(declare(b, &items[i], err));
done:
    mem_free(items);
    return status;
}
