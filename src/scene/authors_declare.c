/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/authors_private.h"

static const char *const CHANNELS[3] = {"r", "g", "b"};

/* ---- What an object says -------------------------------------------------------------------- */

static const struct extra *find_extra(const struct builder_object *o, const char *name)
{
    for (uint32_t i = 0; i < o->n_extras; i++)
        if (strcmp(o->extras[i].name, name) == 0 && o->extras[i].n_values > 0) return &o->extras[i];
    return NULL;
}

static lmn_status read_bounds(const struct extra *e, double out[4], struct error *err)
{
    for (uint32_t i = 0; i < e->n_values && i < 4; i++) {
        if (!(fabs(e->values[i]) <= 1e30))
            return fail_at(err, e->place, "%s: not a number that can be used", e->name);
        out[i] = e->values[i];
    }
    return LMN_OK;
}

lmn_status authors_read_ranges(const struct builder_object *o, struct ranges *out,
                               struct error *err)
{
    lmn_status status = LMN_OK;
    const struct extra *n = find_extra(o, "num_parameters"), *min = find_extra(o, "min_bounds"),
                       *range = find_extra(o, "range_bounds"),
                       *axis = find_extra(o, "rotation_axis"), *angle = find_extra(o, "min_angle"),
                       *turn = find_extra(o, "range_angle");
    *out = (struct ranges){.n_parameters = 3, .axis = {0.0f, 1.0f, 0.0f}};
    if (n) {
        if (!(n->values[0] >= 1 && n->values[0] <= 5) || n->values[0] != floor(n->values[0])) {
            status = fail_at(err, n->place, "num_parameters is %g; it must be 1 to 5",
                             n->values[0]);
            goto done;
        }
        out->n_parameters = (uint32_t)n->values[0];
    }
    if (min && !range) {
        status = fail_at(err, min->place, "min_bounds without range_bounds");
        goto done;
    }
    if (min) TRY(read_bounds(min, out->min, err));
    if (range) {
        TRY(read_bounds(range, out->range, err));
        out->n_bounds = range->n_values < 4 ? range->n_values : 4;
    }
    if (axis) {
        double values[4] = {0};
        TRY(read_bounds(axis, values, err));
        out->axis = vec3((float)values[0], (float)values[1], (float)values[2]);
        if (!(vec3_length(out->axis) > 1e-20f)) {
            status = fail_at(err, axis->place, "rotation_axis has no direction");
            goto done;
        }
    }
    double value[4] = {0};
    if (angle) TRY(read_bounds(angle, value, err));
    out->min_angle = value[0];
    value[0] = 0;
    if (turn) TRY(read_bounds(turn, value, err));
    out->range_angle = value[0];
    out->has_rotation = out->range_angle != 0;
done:
    return status;
}

void authors_default_to_unit(struct ranges *r)
{
    if (r->n_bounds > 0) return;
    for (int i = 0; i < 4; i++) r->range[i] = 1.0;
    r->n_bounds = 4;
}

/* ---- Declaring ------------------------------------------------------------------------------ */

const char *authors_path(struct builder *b, const char *group, const char *suffix)
{
    size_t size = strlen(group) + strlen(suffix) + 2;
    char *name = arena_new(b->arena, size, 1);
    if (name) snprintf(name, size, "%s.%s", group, suffix);
    return name;
}

lmn_status authors_add_range(struct declaring *d, const char *suffix, const char *unit, double min,
                             double range, double value, struct drive *drive)
{
    struct variable v = {.group = d->group, .kind = d->kind, .unit = unit};
    v.name = suffix ? authors_path(d->b, d->group, suffix) : d->group;
    if (!v.name) return fail_memory(d->err, "the variables");
    v.min = min;
    v.max = min + range;
    *drive = (struct drive){.at_0 = (float)v.min, .at_1 = (float)v.max};
    if (range < 0) { /* ranges are told from low to high; u runs with them */
        v.min = min + range;
        v.max = min;
        *drive = (struct drive){.at_0 = (float)v.min, .at_1 = (float)v.max};
    }
    v.value = variable_default(value, v.min, v.max);
    return variable_set_add(d->b, d->object->place, &v, &drive->variable, d->err);
}

struct drive authors_constant(double value)
{
    return (struct drive){.variable = SCENE_NONE, .at_0 = (float)value, .at_1 = (float)value};
}

lmn_status authors_add_choice(struct declaring *d, const char *suffix, const char *const *choices,
                              uint32_t n, uint32_t *index)
{
    struct variable v = {.group = d->group, .kind = d->kind, .unit = ""};
    v.name = authors_path(d->b, d->group, suffix);
    if (!v.name) return fail_memory(d->err, "the variables");
    v.max = (double)n - 1.0;
    v.n_choices = n;
    v.choices = choices;
    return variable_set_add(d->b, d->object->place, &v, index, d->err);
}

struct write authors_new_write(const struct declaring *d, struct target target)
{
    return (struct write){
        .target = target, .place = d->object->place, .first = d->first, .count = 1};
}

struct target authors_field(struct builder *b, const char *id, const char *property,
                            enum builder_kind owner, uint32_t index, size_t offset,
                            enum param_type type)
{
    return (struct target){.path = authors_path(b, target_name(b, id), property),
                           .type = type,
                           .owner = owner,
                           .index = index,
                           .offset = (uint32_t)offset};
}

lmn_status authors_own_texture(struct builder *b, uint32_t *slot, struct error *err)
{
    if (*slot == SCENE_NONE)
        return builder_add_constant(b, (struct place){0}, vec3_splat(1.0f), slot, err);
    struct texture copy = b->textures[*slot].texture;
    struct builder_object nameless = {.place = b->textures[*slot].object.place};
    return builder_add_texture(b, &nameless, &copy, slot, err);
}

lmn_status authors_add_channels(struct declaring *d, const struct ranges *r, struct vec3 declared,
                                struct drive drive[3])
{
    const float now[3] = {declared.x, declared.y, declared.z};
    for (int i = 0; i < 3; i++) {
        if (r->range[i] == 0) {
            drive[i] = authors_constant(r->min[i]);
            continue;
        }
        lmn_status status = authors_add_range(d, CHANNELS[i], "", r->min[i], r->range[i],
                                              (double)now[i], &drive[i]);
        if (status != LMN_OK) return status;
    }
    return LMN_OK;
}
