/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>

#include "scene/authors_private.h"

static const char *const AXES[3] = {"x", "y", "z"};

/* 5 parameters: where the camera stands (3), and where it looks (2). */
lmn_status authors_declare_sensor(struct declaring *d)
{
    lmn_status status = LMN_OK;
    struct builder *b = d->b;
    struct ranges r;
    TRY(authors_read_ranges(d->object, &r, d->err));
    if (r.n_bounds == 0) goto done;
    d->group = "camera";
    d->kind = "camera";
    struct binding_camera *camera = arena_new(b->arena, 1, sizeof *camera);
    if (!camera) {
        status = fail_memory(d->err, "the variables");
        goto done;
    }
    camera->up = vec3(0.0f, 1.0f, 0.0f);
    bool is_inside = true;
    for (int i = 0; i < 3; i++) {
        double at = (double)b->sensor.to_world.m[i][3];
        is_inside &= at >= r.min[i] && at <= r.min[i] + r.range[i];
    }
    for (int i = 0; i < 3; i++) {
        if (r.range[i] == 0) {
            camera->origin[i] = authors_constant(r.min[i]);
            continue;
        }
        double at = is_inside ? (double)b->sensor.to_world.m[i][3] : (double)NAN;
        TRY(authors_add_range(d, AXES[i], "", r.min[i], r.range[i], at, &camera->origin[i]));
    }
    /* variables_resolve() puts in the ranges, which are those of the finished scene. */
    TRY(authors_add_range(d, "target_x", "", 0, 1, 0.5, &camera->target[0]));
    camera->target[1] = authors_constant(0);
    TRY(authors_add_range(d, "target_z", "", 0, 1, 0.5, &camera->target[2]));
    struct write w = authors_new_write(
        d, authors_field(b, d->object->id, "to_world", BUILDER_SENSOR, 0,
                         offsetof(struct sensor, to_world), PARAM_TRANSFORM));
    w.kind = BINDING_CAMERA;
    w.camera = camera;
    w.aims_at_middle = true;
    TRY(variable_set_write(b, &w, d->err));
done:
    return status;
}

/* 1 to 3 parameters: a translation along each axis of range > 0; one left over is a rotation. */
lmn_status authors_declare_placement(struct declaring *d, enum builder_kind owner, uint32_t index,
                                     const struct transform *declared)
{
    lmn_status status = LMN_OK;
    struct ranges r;
    struct drive move[3], turn = {0};
    TRY(authors_read_ranges(d->object, &r, d->err));
    uint32_t n = 0, first = d->first;
    bool is_declared = declared &&
                       (declared->m[0][3] != 0 || declared->m[1][3] != 0 || declared->m[2][3] != 0);
    for (int i = 0; i < 3; i++) n += r.range[i] > 0;
    bool turns = r.has_rotation && r.n_parameters > n;
    if (n == 0 && !turns) goto done; /* nothing varies */

    d->kind = "translate";
    n = 0;
    for (int i = 0; i < 3; i++) {
        move[i] = authors_constant(r.min[i]);
        if (!(r.range[i] > 0) || n == r.n_parameters) continue;
        double at = is_declared ? (double)declared->m[i][3] : (double)NAN;
        TRY(authors_add_range(d, AXES[i], "", r.min[i], r.range[i], at, &move[i]));
        n++;
    }
    if (turns) {
        d->kind = "rotate";
        TRY(authors_add_range(d, n ? "angle" : NULL, "deg", r.min_angle, r.range_angle, (double)NAN,
                              &turn));
    }
    struct target target = {
        .path = authors_path(d->b, target_name(d->b, d->object->id), "to_world"),
        .type = PARAM_TRANSFORM,
        .owner = owner,
        .index = index,
        .part = PART_TO_WORLD};
    struct write w = authors_new_write(d, target);
    w.first = first;
    w.kind = BINDING_TRANSFORM;
    w.replaces_base = owner == BUILDER_INSTANCE;
    w.step = (struct binding_step){.kind = STEP_TRANSLATE, .drive = {move[0], move[1], move[2]}};
    TRY(variable_set_write(d->b, &w, d->err));
    if (turns) {
        w.step = (struct binding_step){.kind = STEP_ROTATE, .drive = {turn}, .axis = r.axis};
        TRY(variable_set_write(d->b, &w, d->err));
    }
done:
    return status;
}

/* 1 parameter scales min + u * range as a whole, 3 are the channels. A variable envmap turns. */
lmn_status authors_declare_emitter(struct declaring *d, uint32_t index)
{
    lmn_status status = LMN_OK;
    struct builder *b = d->b;
    const struct emitter *e = &b->emitters[index].emitter;
    struct ranges r;
    TRY(authors_read_ranges(d->object, &r, d->err));
    if (e->kind == EMITTER_ENVMAP) {
        struct binding_step step = {.kind = STEP_ROTATE, .axis = vec3(0.0f, 1.0f, 0.0f)};
        d->kind = "envmap";
        TRY(authors_add_range(d, NULL, "deg", 100, 40, (double)NAN, &step.drive[0]));
        struct write w = authors_new_write(
            d, authors_field(b, d->object->id, "to_world", BUILDER_EMITTER, index,
                             offsetof(struct emitter, to_world), PARAM_TRANSFORM));
        w.kind = BINDING_TRANSFORM;
        w.replaces_base = true;
        w.step = step;
        TRY(variable_set_write(b, &w, d->err));
        goto done;
    }
    if (r.n_bounds == 0 || (r.range[0] == 0 && r.range[1] == 0 && r.range[2] == 0)) goto done;
    uint32_t slot = e->radiance;
    struct vec3 now = slot == SCENE_NONE ? vec3_splat(1.0f) : b->textures[slot].texture.value;
    TRY(authors_own_texture(b, &slot, d->err));
    b->emitters[index].emitter.radiance = slot;
    char path[24];
    snprintf(path, sizeof path, "%s.value", emitter_radiance_name(e->kind));
    struct write w = authors_new_write(d,
                                       authors_field(b, d->object->id, path, BUILDER_TEXTURE, slot,
                                                     offsetof(struct texture, value), PARAM_RGB));
    w.kind = BINDING_RGB;
    if (r.n_parameters == 1) {
        struct drive whole;
        d->kind = "intensity";
        TRY(authors_add_range(d, "intensity", "", 0, 1, (double)NAN, &whole));
        for (int i = 0; i < 3; i++)
            w.drive[i] = (struct drive){whole.variable, (float)r.min[i],
                                        (float)(r.min[i] + r.range[i])};
    } else {
        d->kind = "color";
        TRY(authors_add_channels(d, &r, now, w.drive));
    }
    TRY(variable_set_write(b, &w, d->err));
done:
    return status;
}

/* 1 parameter: which of its shapes is there. */
lmn_status authors_declare_group(struct declaring *d, uint32_t index)
{
    lmn_status status = LMN_OK;
    struct builder *b = d->b;
    uint32_t n = 0, variable;
    for (uint32_t i = 0; i < b->n_shapes; i++) n += b->shapes[i].group == index;
    if (n < 2) goto done;
    const char **names = arena_new(b->arena, n, sizeof *names);
    if (!names) {
        status = fail_memory(d->err, "the variables");
        goto done;
    }
    n = 0;
    for (uint32_t i = 0; i < b->n_shapes; i++)
        if (b->shapes[i].group == index) names[n++] = b->shapes[i].name;
    d->kind = "choice";
    TRY(authors_add_choice(d, "shape", names, n, &variable));
    n = 0;
    for (uint32_t i = 0; i < b->n_shapes; i++) {
        if (b->shapes[i].group != index) continue;
        struct target target = {.path = authors_path(b, b->shapes[i].name, "visible"),
                                .type = PARAM_BOOL,
                                .owner = BUILDER_SHAPE,
                                .index = i,
                                .part = PART_VISIBLE};
        struct write w = authors_new_write(d, target);
        w.kind = BINDING_VISIBLE;
        w.condition = (struct binding_condition){variable, n++};
        TRY(variable_set_write(b, &w, d->err));
    }
done:
    return status;
}
