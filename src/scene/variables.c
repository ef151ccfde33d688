/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/variables.h"

#include <math.h>
#include <string.h>
#include <sys/stat.h>

#include "base/hash.h"
#include "base/str.h"
#include "scene/authors_variables.h"
#include "scene/variable_set.h"
#include "scene/variables_json.h"

/* ---- Declaring ------------------------------------------------------------------------------ */

/* scene.xml -> scene.variables.json */
static void default_path(const char *scene_path, struct str *out)
{
    size_t n = strlen(scene_path);
    if (str_ends(scene_path, ".xml")) n -= 4;
    str_add(out, "%.*s.variables.json", (int)n, scene_path);
}

lmn_status variables_declare(struct builder *b, const char *variables_path, struct error *err)
{
    lmn_status status = LMN_OK;
    struct str beside = {0};
    if (!variables_path) {
        struct stat info;
        default_path(b->path, &beside);
        if (beside.failed) {
            status = fail_memory(err, "a path");
            goto done;
        }
        if (stat(beside.text, &info) == 0) variables_path = beside.text;
    }
    if (variables_path)
        TRY(variables_read_json(b, variables_path, err));
    else
        TRY(variables_read_authors(b, err));
done:
    if (b->variables) target_list_release(&b->variables->targets);
    str_release(&beside);
    return status;
}

/* ---- Resolving ------------------------------------------------------------------------------ */

struct resolving {
    const struct builder *b;
    struct scene *s;
    const struct variable_set *set;
    size_t capacity; /* of s->bindings */
};

static struct binding *new_binding(struct resolving *r)
{
    struct scene *s = r->s;
    if (s->n_bindings == r->capacity) {
        size_t capacity = r->capacity ? 2 * r->capacity : 16;
        struct binding *bigger = arena_new(&s->arena, capacity, sizeof *bigger);
        if (!bigger) return NULL;
        if (s->n_bindings) memcpy(bigger, s->bindings, s->n_bindings * sizeof *bigger);
        s->bindings = bigger;
        r->capacity = capacity;
    }
    return &s->bindings[s->n_bindings++];
}

static bool writes_to(const struct write *w, enum binding_kind kind, enum builder_kind owner,
                      uint32_t index)
{
    return w->kind == kind && w->target.owner == owner && w->target.index == index;
}

static uint32_t count_writes(const struct resolving *r, enum binding_kind kind,
                             enum builder_kind owner, uint32_t index)
{
    uint32_t n = 0;
    if (index == SCENE_NONE) return 0;
    for (size_t i = 0; i < r->set->n_writes; i++)
        n += writes_to(&r->set->writes[i], kind, owner, index);
    return n;
}

/* Appends translate * rotate * scale of everything that moves one object. */
static void append_steps(const struct resolving *r, struct binding *to, enum builder_kind owner,
                         uint32_t index, bool *replaces_base)
{
    if (index == SCENE_NONE) return;
    for (int kind = STEP_TRANSLATE; kind <= STEP_SCALE; kind++) {
        for (size_t i = 0; i < r->set->n_writes; i++) {
            const struct write *w = &r->set->writes[i];
            if (!writes_to(w, BINDING_TRANSFORM, owner, index) || (int)w->step.kind != kind)
                continue;
            to->steps[to->n_steps++] = w->step;
            *replaces_base |= w->replaces_base;
        }
    }
}

static void append_base(struct binding *to, const struct transform *base)
{
    to->steps[to->n_steps++] = (struct binding_step){.kind = STEP_FIXED, .fixed = *base};
}

/* A transform of an emitter or the sensor. */
static bool resolve_transform(struct resolving *r, enum builder_kind owner, uint32_t index,
                              enum state_array array, size_t offset, const struct transform *base)
{
    uint32_t n = count_writes(r, BINDING_TRANSFORM, owner, index);
    if (n == 0) return true;
    struct binding *to = new_binding(r);
    if (!to) return false;
    *to = (struct binding){.kind = BINDING_TRANSFORM,
                           .array = array,
                           .index = index,
                           .offset = (uint32_t)offset,
                           .steps = arena_new(&r->s->arena, n + 1, sizeof *to->steps)};
    if (!to->steps) return false;
    bool replaces_base = false;
    append_steps(r, to, owner, index, &replaces_base);
    if (!replaces_base) append_base(to, base);
    return true;
}

/* A final instance: it moves with the builder instance that placed it and, within the space of its
 * shapegroup, with the shape that is alone in it. */
static bool resolve_instance(struct resolving *r, uint32_t i)
{
    const struct builder_placement *p = &r->b->placements[i];
    struct arena *arena = &r->s->arena;
    uint32_t n = count_writes(r, BINDING_TRANSFORM, BUILDER_INSTANCE, p->instance) +
                 count_writes(r, BINDING_TRANSFORM, BUILDER_SHAPE, p->shape);
    if (n > 0) {
        struct binding *to = new_binding(r);
        if (!to) return false;
        *to = (struct binding){.kind = BINDING_TRANSFORM,
                               .array = STATE_INSTANCES,
                               .index = i,
                               .offset = offsetof(struct instance, to_world),
                               .steps = arena_new(arena, n + 1, sizeof *to->steps)};
        if (!to->steps) return false;
        bool replaces_base = false, unused = false;
        append_steps(r, to, BUILDER_INSTANCE, p->instance, &replaces_base);
        if (p->instance != SCENE_NONE && !replaces_base)
            append_base(to, &r->s->defaults.instances[i].to_world);
        append_steps(r, to, BUILDER_SHAPE, p->shape, &unused);
    }

    uint32_t n_conditions = count_writes(r, BINDING_VISIBLE, BUILDER_INSTANCE, p->instance) +
                            count_writes(r, BINDING_VISIBLE, BUILDER_SHAPE, p->shape);
    if (n_conditions == 0) return true;
    struct binding *to = new_binding(r);
    if (!to) return false;
    *to = (struct binding){.kind = BINDING_VISIBLE,
                           .array = STATE_INSTANCES,
                           .index = i,
                           .offset = offsetof(struct instance, is_visible),
                           .conditions = arena_new(arena, n_conditions, sizeof *to->conditions)};
    if (!to->conditions) return false;
    for (size_t k = 0; k < r->set->n_writes; k++) {
        const struct write *w = &r->set->writes[k];
        if (writes_to(w, BINDING_VISIBLE, BUILDER_INSTANCE, p->instance) ||
            writes_to(w, BINDING_VISIBLE, BUILDER_SHAPE, p->shape))
            to->conditions[to->n_conditions++] = w->condition;
    }
    return true;
}

/* Ranges of the authors' camera that only the finished scene can tell. */
static void aim_at_middle(struct resolving *r, const struct write *w)
{
    const struct bounds *box = &r->s->bounds;
    const float low[3] = {box->min.x, box->min.y, box->min.z};
    const float high[3] = {box->max.x, box->max.y, box->max.z};
    for (int i = 0; i < 3; i++) {
        struct drive *d = &w->camera->target[i];
        float third = (high[i] - low[i]) / 3.0f;
        d->at_0 = low[i] + third;
        d->at_1 = i == 1 ? d->at_0 : high[i] - third;
        if (d->variable == SCENE_NONE) {
            if (i != 1) d->at_0 = 0.5f * (d->at_0 + d->at_1); /* no extent: nothing to choose */
            continue;
        }
        struct variable *v = &r->s->variables[d->variable];
        v->min = (double)d->at_0;
        v->max = (double)d->at_1;
        v->value = 0.5 * (v->min + v->max);
    }
}

/* The default target is where the declared camera looks, if that is within reach. */
static void aim_at_declared(struct resolving *r, const struct write *w)
{
    const struct transform *t = &r->s->defaults.sensor.to_world;
    float y = w->camera->target[1].at_0;
    float distance = (y - t->m[1][3]) / t->m[1][2]; /* the camera looks along +z */
    if (!(distance > 0.0f) || !isfinite(distance)) return;
    const double at[3] = {(double)(t->m[0][3] + distance * t->m[0][2]), (double)y,
                          (double)(t->m[2][3] + distance * t->m[2][2])};
    for (int i = 0; i < 3; i++) {
        uint32_t k = w->camera->target[i].variable;
        if (k == SCENE_NONE) continue;
        const struct variable *v = &r->s->variables[k];
        if (!(at[i] >= v->min && at[i] <= v->max)) return;
    }
    for (int i = 0; i < 3; i++) {
        uint32_t k = w->camera->target[i].variable;
        if (k != SCENE_NONE) r->s->variables[k].value = at[i];
    }
}

static bool resolve_plain(struct resolving *r, const struct write *w)
{
    if (w->kind == BINDING_TRANSFORM || w->kind == BINDING_VISIBLE) return true;
    if (w->aims_at_middle) {
        aim_at_middle(r, w);
        aim_at_declared(r, w);
    }
    struct param at;
    target_lower(&w->target, r->b, &at);
    struct binding *to = new_binding(r);
    if (!to) return false;
    *to = (struct binding){.kind = w->kind,
                           .array = at.array,
                           .index = at.index,
                           .offset = at.offset,
                           .drive = {w->drive[0], w->drive[1], w->drive[2]},
                           .camera = w->camera,
                           .variable = w->variable,
                           .options = w->options};
    return true;
}

/* Two scenes that differ in what u means are different. The structs hashed whole have no padding.
 */
static void hash_bindings(struct scene *s)
{
    uint64_t h = s->hash;
    for (uint32_t i = 0; i < s->n_bindings; i++) {
        const struct binding *to = &s->bindings[i];
        const uint32_t words[5] = {to->kind, to->array, to->index, to->offset, to->variable};
        h = hash_bytes(h, words, sizeof words);
        h = hash_bytes(h, to->drive, sizeof to->drive);
        if (to->n_steps) h = hash_bytes(h, to->steps, to->n_steps * sizeof *to->steps);
        if (to->camera) h = hash_bytes(h, to->camera, sizeof *to->camera);
        if (to->options)
            h = hash_bytes(h, to->options,
                           s->variables[to->variable].n_choices * sizeof *to->options);
        if (to->n_conditions)
            h = hash_bytes(h, to->conditions, to->n_conditions * sizeof *to->conditions);
    }
    h = hash_bytes(h, &s->n_variables, sizeof s->n_variables);
    s->hash = h;
}

static bool resolve_all(struct resolving *r)
{
    struct scene *s = r->s;
    const struct builder *b = r->b;
    for (size_t i = 0; i < r->set->n_writes; i++)
        if (!resolve_plain(r, &r->set->writes[i])) return false;
    for (uint32_t i = 0; i < s->n_emitters; i++)
        if (!resolve_transform(r, BUILDER_EMITTER, i, STATE_EMITTERS,
                               offsetof(struct emitter, to_world),
                               &b->emitters[i].emitter.to_world))
            return false;
    if (!resolve_transform(r, BUILDER_SENSOR, 0, STATE_SENSOR, offsetof(struct sensor, to_world),
                           &b->sensor.to_world))
        return false;
    for (uint32_t i = 0; i < s->n_instances; i++)
        if (!resolve_instance(r, i)) return false;
    return true;
}

/* The default state is the one at the variables' defaults. */
static void apply_defaults(struct scene *s)
{
    float u[VARIABLES_MAX];
    for (uint32_t i = 0; i < s->n_variables; i++)
        u[i] = variable_to_unit(&s->variables[i], s->variables[i].value);
    scene_apply(s, u, &s->defaults);
    s->bounds = scene_bounds(s, &s->defaults);
}

lmn_status variables_resolve(const struct builder *b, struct scene *s, struct error *err)
{
    const struct variable_set *set = b->variables;
    if (set && set->n_variables > 0) {
        struct resolving r = {.b = b, .s = s, .set = set};
        s->variables = arena_new(&s->arena, set->n_variables, sizeof *s->variables);
        if (!s->variables) return fail_memory(err, "the variables");
        memcpy(s->variables, set->variables, set->n_variables * sizeof *s->variables);
        s->n_variables = set->n_variables;
        if (!resolve_all(&r)) return fail_memory(err, "the variables");
        hash_bindings(s);
        apply_defaults(s);
    }
    return params_resolve(b, s, err);
}
