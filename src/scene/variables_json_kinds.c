/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "scene/variables_json_private.h"

static const char *const AXES[3] = {"x", "y", "z"};
static const char *const CHANNELS[3] = {"r", "g", "b"};

/* What the scene has at a target, as up to three numbers. */
static void present_value(const struct entry *e, size_t i, double out[3])
{
    const float *value = target_in(e->targets[i], e->b);
    int n = e->targets[i]->type == PARAM_RGB ? 3 : 1;
    for (int k = 0; k < 3; k++) out[k] = (double)value[k < n ? k : 0];
}

/* Refuses a range that leaves what a target can be. */
static lmn_status check_limits(struct entry *e, const char *key, double min, double max)
{
    for (size_t i = 0; i < e->n_targets; i++) {
        const struct target *t = e->targets[i];
        if (min >= t->low && max <= t->high) continue;
        json_reader_enter(e->r, key, 0);
        return json_reader_fail(e->r, "\"%.200s\" can only be from %g to %g", t->path, t->low,
                                t->high);
    }
    return LMN_OK;
}

static const char *const TO_WORLD[] = {".to_world"};
static const char *const SCALE[] = {".scale", ".emitter.scale"};
static const char *const VISIBLE[] = {".visible"};

/* A direction that is not zero; `def` when it is not given. */
static lmn_status read_direction(struct entry *e, const char *key, struct vec3 def,
                                 bool is_required, struct vec3 *out)
{
    const json_t *json = entry_get(e, key);
    double d[3];
    *out = def;
    if (!json && !is_required) return LMN_OK;
    json_reader_enter(e->r, key, 0);
    lmn_status status = json_read_numbers(e->r, json, 3, d);
    if (status != LMN_OK) return status;
    *out = vec3((float)d[0], (float)d[1], (float)d[2]);
    float length = vec3_length(*out);
    if (!(length > 1e-12f) || !isfinite(length))
        return json_reader_fail(e->r, "this has no direction");
    json_reader_leave(e->r);
    return LMN_OK;
}

/* The point that a rotation or a scale leaves where it is: by default each target's own origin. */
static lmn_status read_pivot(struct entry *e, struct vec3 *out, bool *is_given)
{
    double d[3] = {0};
    const json_t *json = entry_get(e, "pivot");
    *is_given = json != NULL;
    json_reader_enter(e->r, "pivot", 0);
    lmn_status status = json ? json_read_numbers(e->r, json, 3, d) : LMN_OK;
    if (status == LMN_OK) json_reader_leave(e->r);
    *out = vec3((float)d[0], (float)d[1], (float)d[2]);
    return status;
}

static struct vec3 origin_of(const struct entry *e, const struct target *t)
{
    const struct transform *to_world = target_in(t, e->b);
    return vec3(to_world->m[0][3], to_world->m[1][3], to_world->m[2][3]);
}

/* Moves every target; rotations and scales without a pivot take each target's own. */
static lmn_status write_steps(struct entry *e, struct binding_step step, bool has_pivot)
{
    size_t n = e->n_targets;
    lmn_status status = LMN_OK;
    const struct target **all = e->targets;
    for (size_t i = 0; i < n && status == LMN_OK; i++) {
        if (!has_pivot && step.kind != STEP_TRANSLATE) step.pivot = origin_of(e, all[i]);
        e->targets = &all[i];
        e->n_targets = 1;
        status = entry_write_targets(e, (struct write){.kind = BINDING_TRANSFORM, .step = step});
    }
    e->targets = all;
    e->n_targets = n;
    return status;
}

/* A box, or a point that does not vary. */
static lmn_status read_box_or_point(struct entry *e, const char *key, double min[3], double max[3])
{
    const json_t *json = entry_get(e, key);
    json_reader_enter(e->r, key, 0);
    lmn_status status;
    if (json_is_array(json)) {
        status = json_read_numbers(e->r, json, 3, min);
        memcpy(max, min, 3 * sizeof *max);
    } else {
        status = json_read_box(e->r, json, min, max);
    }
    if (status == LMN_OK) json_reader_leave(e->r);
    return status;
}

lmn_status entry_read_camera(struct entry *e)
{
    lmn_status status = LMN_OK;
    static const char *const targets[3] = {"target_x", "target_y", "target_z"};
    static const char *const keys[2] = {"origin", "target"};
    struct binding_camera *camera = arena_new(e->b->arena, 1, sizeof *camera);
    double origin[2][3], target[2][3], now[2][3], at[2][3];
    const json_t *def = entry_get(e, "default");
    if (!camera) return entry_no_memory(e);
    TRY(read_box_or_point(e, "origin", origin[0], origin[1]));
    TRY(read_box_or_point(e, "target", target[0], target[1]));
    TRY(read_direction(e, "up", vec3(0.0f, 1.0f, 0.0f), false, &camera->up));

    json_reader_enter(e->r, "default", 0);
    if (def && !json_is_object(def)) {
        status = json_reader_fail(e->r, "this must be {\"origin\": [x, y, z], \"target\": [...]}");
        goto done;
    }
    if (def) TRY(json_check_keys(e->r, def, keys, 2));
    /* The scene's own camera is the default where it fits: its ray meets the plane through the
     * middle of the target box nearest to that middle. */
    const struct transform *t = &e->b->sensor.to_world;
    double distance = 0;
    for (int i = 0; i < 3; i++)
        distance += (0.5 * (target[0][i] + target[1][i]) - (double)t->m[i][3]) * (double)t->m[i][2];
    for (int i = 0; i < 3; i++) {
        now[0][i] = (double)t->m[i][3];
        now[1][i] = now[0][i] + distance * (double)t->m[i][2];
    }
    TRY(entry_read_default3(e, json_object_get(def, keys[0]), keys[0], origin[0], origin[1], now[0],
                            at[0]));
    TRY(entry_read_default3(e, json_object_get(def, keys[1]), keys[1], target[0], target[1], now[1],
                            at[1]));
    json_reader_leave(e->r);

    TRY(entry_add_box(e, AXES, origin[0], origin[1], at[0], camera->origin));
    TRY(entry_add_box(e, targets, target[0], target[1], at[1], camera->target));
    TRY(entry_check_varies(e, "origin"));
    e->targets = arena_new(e->b->arena, 1, sizeof *e->targets);
    if (!e->targets) {
        status = entry_no_memory(e);
        goto done;
    }
    const char *id = e->b->sensor_object.id;
    TRY(entry_find_target(e, id ? id : "sensor", PARAM_TRANSFORM, TO_WORLD, 1, &e->targets[0]));
    e->n_targets = 1;
    TRY(entry_write_targets(e, (struct write){.kind = BINDING_CAMERA, .camera = camera}));
done:
    return status;
}

lmn_status entry_read_translate(struct entry *e)
{
    lmn_status status = LMN_OK;
    struct binding_step step = {.kind = STEP_TRANSLATE};
    const double zero[3] = {0};
    double min[3], max[3], value[3];
    TRY(entry_read_targets(e, PARAM_TRANSFORM, TO_WORLD, 1));
    if (entry_get(e, "direction")) {
        struct vec3 along;
        TRY(read_direction(e, "direction", vec3_splat(0.0f), true, &along));
        json_reader_enter(e->r, "range", 0);
        TRY(json_read_range(e->r, entry_get(e, "range"), min));
        json_reader_leave(e->r);
        TRY(entry_read_default(e, min, 0, &value[0]));
        struct drive d;
        TRY(entry_add_range(e, NULL, min[0], min[1], value[0], &d));
        const float direction[3] = {along.x, along.y, along.z};
        for (int i = 0; i < 3; i++)
            step.drive[i] = (struct drive){d.variable, d.at_0 * direction[i],
                                           d.at_1 * direction[i]};
    } else {
        json_reader_enter(e->r, "range", 0);
        TRY(json_read_box(e->r, entry_get(e, "range"), min, max));
        json_reader_leave(e->r);
        TRY(entry_read_default3(e, entry_get(e, "default"), "default", min, max, zero, value));
        TRY(entry_add_box(e, AXES, min, max, value, step.drive));
        TRY(entry_check_varies(e, "range"));
    }
    TRY(write_steps(e, step, true));
done:
    return status;
}

lmn_status entry_read_rotate(struct entry *e)
{
    lmn_status status = LMN_OK;
    struct binding_step step = {.kind = STEP_ROTATE};
    bool has_pivot;
    double range[2], value;
    TRY(entry_read_targets(e, PARAM_TRANSFORM, TO_WORLD, 1));
    TRY(read_direction(e, "axis", vec3_splat(0.0f), true, &step.axis));
    TRY(read_pivot(e, &step.pivot, &has_pivot));
    json_reader_enter(e->r, "range", 0);
    TRY(json_read_range(e->r, entry_get(e, "range"), range));
    json_reader_leave(e->r);
    TRY(entry_read_default(e, range, 0, &value));
    TRY(entry_add_range(e, NULL, range[0], range[1], value, &step.drive[0]));
    TRY(write_steps(e, step, has_pivot));
done:
    return status;
}

lmn_status entry_read_scale(struct entry *e)
{
    lmn_status status = LMN_OK;
    struct binding_step step = {.kind = STEP_SCALE};
    const double one[3] = {1, 1, 1};
    bool has_pivot;
    double min[3], max[3], value[3];
    TRY(entry_read_targets(e, PARAM_TRANSFORM, TO_WORLD, 1));
    TRY(read_pivot(e, &step.pivot, &has_pivot));
    bool is_uniform = json_is_array(entry_get(e, "range"));
    json_reader_enter(e->r, "range", 0);
    if (is_uniform) {
        double both[2];
        TRY(json_read_range(e->r, entry_get(e, "range"), both));
        for (int i = 0; i < 3; i++) {
            min[i] = both[0];
            max[i] = both[1];
        }
    } else {
        TRY(json_read_box(e->r, entry_get(e, "range"), min, max));
    }
    for (int i = 0; i < 3; i++) {
        if (min[i] >= 1e-6) continue;
        status = json_reader_fail(e->r, "a scale must be positive");
        goto done;
    }
    json_reader_leave(e->r);
    if (is_uniform) {
        const double range[2] = {min[0], max[0]};
        TRY(entry_read_default(e, range, 1, &value[0]));
        TRY(entry_add_range(e, NULL, min[0], max[0], value[0], &step.drive[0]));
        step.drive[1] = step.drive[2] = step.drive[0];
    } else {
        TRY(entry_read_default3(e, entry_get(e, "default"), "default", min, max, one, value));
        TRY(entry_add_box(e, AXES, min, max, value, step.drive));
        TRY(entry_check_varies(e, "range"));
    }
    TRY(write_steps(e, step, has_pivot));
done:
    return status;
}

/* One variable that goes from one colour to another. */
static lmn_status read_color_blend(struct entry *e)
{
    lmn_status status = LMN_OK;
    struct write w = {.kind = BINDING_RGB};
    static const char *const keys[2] = {"from", "to"};
    const double unit[2] = {0, 1};
    double colors[2][3], value;
    for (int k = 0; k < 2; k++) {
        json_reader_enter(e->r, keys[k], 0);
        TRY(json_read_numbers(e->r, entry_get(e, keys[k]), 3, colors[k]));
        json_reader_leave(e->r);
        for (int i = 0; i < 3; i++) TRY(check_limits(e, keys[k], colors[k][i], colors[k][i]));
    }
    if (entry_get(e, "range")) {
        json_reader_enter(e->r, "range", 0);
        status = json_reader_fail(e->r, "a colour has either a range, or from and to");
        goto done;
    }
    TRY(entry_read_default(e, unit, 0.5, &value));
    struct drive d;
    TRY(entry_add_range(e, NULL, 0, 1, value, &d));
    for (int i = 0; i < 3; i++)
        w.drive[i] = (struct drive){d.variable, (float)colors[0][i], (float)colors[1][i]};
    TRY(entry_write_targets(e, w));
done:
    return status;
}

lmn_status entry_read_color(struct entry *e)
{
    lmn_status status = LMN_OK;
    struct write w = {.kind = BINDING_RGB};
    double min[3], max[3], now[3], value[3];
    TRY(entry_read_targets(e, PARAM_RGB, NULL, 0));
    if (entry_get(e, "from") || entry_get(e, "to")) return read_color_blend(e);
    const json_t *range = entry_get(e, "range");
    json_reader_enter(e->r, "range", 0);
    if (json_is_object(range)) {
        TRY(json_read_box(e->r, range, min, max));
    } else {
        double both[2];
        TRY(json_read_range(e->r, range, both));
        for (int i = 0; i < 3; i++) {
            min[i] = both[0];
            max[i] = both[1];
        }
    }
    json_reader_leave(e->r);
    for (int i = 0; i < 3; i++) TRY(check_limits(e, "range", min[i], max[i]));
    present_value(e, 0, now);
    TRY(entry_read_default3(e, entry_get(e, "default"), "default", min, max, now, value));
    TRY(entry_add_box(e, CHANNELS, min, max, value, w.drive));
    TRY(entry_check_varies(e, "range"));
    TRY(entry_write_targets(e, w));
done:
    return status;
}

/* A number; a colour's three channels get it alike. */
lmn_status entry_read_float(struct entry *e)
{
    lmn_status status = LMN_OK;
    struct write w = {0};
    double range[2], now[3], value;
    const json_t *json = entry_get(e, "targets");
    const char *text = json_string_value(json_is_array(json) ? json_array_get(json, 0) : json);
    const struct target *t = text ? target_find(&e->b->variables->targets, text, "", PARAM_FLOAT)
                                  : NULL;
    TRY(entry_read_targets(e, t && t->type == PARAM_RGB ? PARAM_RGB : PARAM_FLOAT, NULL, 0));
    json_reader_enter(e->r, "range", 0);
    TRY(json_read_range(e->r, entry_get(e, "range"), range));
    json_reader_leave(e->r);
    TRY(check_limits(e, "range", range[0], range[1]));
    present_value(e, 0, now);
    TRY(entry_read_default(e, range, now[0], &value));
    TRY(entry_add_range(e, NULL, range[0], range[1], value, &w.drive[0]));
    size_t n = e->n_targets;
    const struct target **all = e->targets;
    for (size_t i = 0; i < n; i++) {
        e->targets = &all[i];
        e->n_targets = 1;
        w.kind = all[i]->owner == BUILDER_TEXTURE ? BINDING_SPLAT : BINDING_NUMBER;
        TRY(entry_write_targets(e, w));
    }
done:
    return status;
}

/* What an emitter is multiplied by; "lamp.radiance" may stand for "lamp.scale". */
lmn_status entry_read_intensity(struct entry *e)
{
    lmn_status status = LMN_OK;
    double range[2], value;
    TRY(entry_read_targets(e, PARAM_FLOAT, SCALE, 2));
    json_reader_enter(e->r, "targets", 0);
    for (size_t i = 0; i < e->n_targets; i++) {
        const struct target *t = e->targets[i];
        if (t->owner == BUILDER_EMITTER && t->offset == offsetof(struct emitter, scale)) continue;
        status = json_reader_fail(e->r, "\"%.200s\" is not the scale of an emitter", t->path);
        goto done;
    }
    json_reader_leave(e->r);
    json_reader_enter(e->r, "range", 0);
    TRY(json_read_range(e->r, entry_get(e, "range"), range));
    if (!(range[0] >= 0)) {
        status = json_reader_fail(e->r, "light cannot be negative");
        goto done;
    }
    json_reader_leave(e->r);
    TRY(entry_read_default(e, range, 1, &value));
    struct drive d;
    TRY(entry_add_range(e, NULL, range[0], range[1], value, &d));
    size_t n = e->n_targets;
    const struct target **all = e->targets;
    for (size_t i = 0; i < n; i++) {
        double now[3];
        e->targets = &all[i];
        e->n_targets = 1;
        present_value(e, 0, now);
        struct write w = {.kind = BINDING_NUMBER};
        w.drive[0] = (struct drive){d.variable, (float)(range[0] * now[0]),
                                    (float)(range[1] * now[0])};
        TRY(entry_write_targets(e, w));
    }
done:
    return status;
}

/* Around the scene, and not the same everywhere. */
static bool can_turn(const struct entry *e, const struct target *t)
{
    if (t->owner != BUILDER_EMITTER) return false;
    enum emitter_kind kind = e->b->emitters[t->index].emitter.kind;
    return kind == EMITTER_ENVMAP || kind == EMITTER_SKY;
}

lmn_status entry_read_envmap(struct entry *e)
{
    lmn_status status = LMN_OK;
    struct binding_step step = {.kind = STEP_ROTATE};
    double range[2], value;
    if (entry_get(e, "targets")) {
        TRY(entry_read_targets(e, PARAM_TRANSFORM, TO_WORLD, 1));
    } else {
        const struct target_list *list = &e->b->variables->targets;
        e->targets = arena_new(e->b->arena, 1, sizeof *e->targets);
        if (!e->targets) return entry_no_memory(e);
        for (size_t i = 0; i < list->n && e->n_targets == 0; i++) {
            const struct target *t = &list->items[i];
            if (can_turn(e, t) && t->type == PARAM_TRANSFORM && !t->is_alias)
                e->targets[e->n_targets++] = t;
        }
        if (e->n_targets == 0) return json_reader_fail(e->r, "the scene has no envmap");
    }
    json_reader_enter(e->r, "targets", 0);
    for (size_t i = 0; i < e->n_targets; i++) {
        const struct target *t = e->targets[i];
        if (can_turn(e, t)) continue;
        status = json_reader_fail(e->r, "\"%.200s\" is not an envmap's", t->path);
        goto done;
    }
    json_reader_leave(e->r);
    TRY(read_direction(e, "axis", vec3(0.0f, 1.0f, 0.0f), false, &step.axis));
    json_reader_enter(e->r, "range", 0);
    TRY(json_read_range(e->r, entry_get(e, "range"), range));
    json_reader_leave(e->r);
    TRY(entry_read_default(e, range, 0, &value));
    TRY(entry_add_range(e, NULL, range[0], range[1], value, &step.drive[0]));
    TRY(write_steps(e, step, true));
done:
    return status;
}

lmn_status entry_read_visible(struct entry *e)
{
    lmn_status status = LMN_OK;
    static const char *const choices[2] = {"off", "on"};
    struct variable v = {.max = 1, .value = 1, .n_choices = 2, .choices = choices};
    struct write w = {.kind = BINDING_VISIBLE, .condition = {.choice = 1}};
    const json_t *def = entry_get(e, "default");
    TRY(entry_read_targets(e, PARAM_BOOL, VISIBLE, 1));
    if (def && !json_is_boolean(def)) {
        json_reader_enter(e->r, "default", 0);
        status = json_reader_fail(e->r, "this must be true or false");
        goto done;
    }
    if (def) v.value = json_is_true(def) ? 1 : 0;
    TRY(entry_add_variable(e, NULL, v, &w.condition.variable));
    TRY(entry_write_targets(e, w));
done:
    return status;
}
