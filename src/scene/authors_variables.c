/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/authors_variables.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/str.h"
#include "scene/variable_set.h"

static const char *const AXES[3] = {"x", "y", "z"};
static const char *const CHANNELS[3] = {"r", "g", "b"};

/* ---- What an object says -------------------------------------------------------------------- */

struct ranges {
    uint32_t n_parameters;
    double min[4], range[4];
    uint32_t n_bounds; /* components given; 0: no bounds */
    bool has_rotation;
    struct vec3 axis;
    double min_angle, range_angle;
};

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

static lmn_status read_ranges(const struct builder_object *o, struct ranges *out, struct error *err)
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

/* Bounds of a colour that are not given are 0 to 1, as in sphere-caustic's walls. */
static void default_to_unit(struct ranges *r)
{
    if (r->n_bounds > 0) return;
    for (int i = 0; i < 4; i++) r->range[i] = 1.0;
    r->n_bounds = 4;
}

/* ---- Declaring ------------------------------------------------------------------------------ */

struct declaring {
    struct builder *b;
    const struct builder_object *object;
    const char *kind;
    const char *group; /* name without "var_" */
    uint32_t first;    /* variables of this object start here */
    struct error *err;
};

/* Ids may hold what names of variables must not. */
static const char *name_without_var(struct builder *b, const char *id)
{
    char *name = arena_strdup(b->arena, id + strlen("var_"));
    for (char *c = name; c && *c; c++)
        if ((unsigned char)*c <= ' ' || *c == '=' || *c == ',' || *c == 0x7F) *c = '_';
    return name;
}

static const char *join(struct builder *b, const char *group, const char *suffix)
{
    size_t size = strlen(group) + strlen(suffix) + 2;
    char *name = arena_new(b->arena, size, 1);
    if (name) snprintf(name, size, "%s.%s", group, suffix);
    return name;
}

/* A continuous variable over min + u * range, and the drive that follows it. suffix NULL: the
 * group's own name. A default that is not inside the range becomes its middle. */
static lmn_status add_range(struct declaring *d, const char *suffix, const char *unit, double min,
                            double range, double value, struct drive *drive)
{
    struct variable v = {.group = d->group, .kind = d->kind, .unit = unit};
    v.name = suffix ? join(d->b, d->group, suffix) : d->group;
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

static struct drive constant(double value)
{
    return (struct drive){.variable = SCENE_NONE, .at_0 = (float)value, .at_1 = (float)value};
}

/* A discrete variable. The names of choices live in the arena. */
static lmn_status add_choice(struct declaring *d, const char *suffix, const char *const *choices,
                             uint32_t n, uint32_t *index)
{
    struct variable v = {.group = d->group, .kind = d->kind, .unit = ""};
    v.name = join(d->b, d->group, suffix);
    if (!v.name) return fail_memory(d->err, "the variables");
    v.max = (double)n - 1.0;
    v.n_choices = n;
    v.choices = choices;
    return variable_set_add(d->b, d->object->place, &v, index, d->err);
}

/* A write of this object's variables; the caller fills the rest. */
static struct write new_write(const struct declaring *d, struct target target)
{
    return (struct write){
        .target = target, .place = d->object->place, .first = d->first, .count = 1};
}

static struct target field(struct builder *b, const char *id, const char *property,
                           enum builder_kind owner, uint32_t index, size_t offset,
                           enum param_type type)
{
    return (struct target){.path = join(b, target_name(b, id), property),
                           .type = type,
                           .owner = owner,
                           .index = index,
                           .offset = (uint32_t)offset};
}

/* A material's texture, which its variable may scale without touching other users of it. */
static lmn_status own_texture(struct builder *b, uint32_t *slot, struct error *err)
{
    if (*slot == SCENE_NONE)
        return builder_add_constant(b, (struct place){0}, vec3_splat(1.0f), slot, err);
    struct texture copy = b->textures[*slot].texture;
    struct builder_object nameless = {.place = b->textures[*slot].object.place};
    return builder_add_texture(b, &nameless, &copy, slot, err);
}

/* ---- Kinds of objects ----------------------------------------------------------------------- */

/* 5 parameters: where the camera stands (3), and where it looks (2). */
static lmn_status declare_sensor(struct declaring *d)
{
    lmn_status status = LMN_OK;
    struct builder *b = d->b;
    struct ranges r;
    TRY(read_ranges(d->object, &r, d->err));
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
            camera->origin[i] = constant(r.min[i]);
            continue;
        }
        double at = is_inside ? (double)b->sensor.to_world.m[i][3] : (double)NAN;
        TRY(add_range(d, AXES[i], "", r.min[i], r.range[i], at, &camera->origin[i]));
    }
    /* variables_resolve() puts in the ranges, which are those of the finished scene. */
    TRY(add_range(d, "target_x", "", 0, 1, 0.5, &camera->target[0]));
    camera->target[1] = constant(0);
    TRY(add_range(d, "target_z", "", 0, 1, 0.5, &camera->target[2]));
    struct write w = new_write(d, field(b, d->object->id, "to_world", BUILDER_SENSOR, 0,
                                        offsetof(struct sensor, to_world), PARAM_TRANSFORM));
    w.kind = BINDING_CAMERA;
    w.camera = camera;
    w.aims_at_middle = true;
    TRY(variable_set_write(b, &w, d->err));
done:
    return status;
}

/* 1 to 3 parameters: a translation along each axis of range > 0; one left over is a rotation. */
static lmn_status declare_placement(struct declaring *d, enum builder_kind owner, uint32_t index,
                                    const struct transform *declared)
{
    lmn_status status = LMN_OK;
    struct ranges r;
    struct drive move[3], turn = {0};
    TRY(read_ranges(d->object, &r, d->err));
    uint32_t n = 0, first = d->first;
    bool is_declared = declared &&
                       (declared->m[0][3] != 0 || declared->m[1][3] != 0 || declared->m[2][3] != 0);
    for (int i = 0; i < 3; i++) n += r.range[i] > 0;
    bool turns = r.has_rotation && r.n_parameters > n;
    if (n == 0 && !turns) goto done; /* nothing varies */

    d->kind = "translate";
    n = 0;
    for (int i = 0; i < 3; i++) {
        move[i] = constant(r.min[i]);
        if (!(r.range[i] > 0) || n == r.n_parameters) continue;
        double at = is_declared ? (double)declared->m[i][3] : (double)NAN;
        TRY(add_range(d, AXES[i], "", r.min[i], r.range[i], at, &move[i]));
        n++;
    }
    if (turns) {
        d->kind = "rotate";
        TRY(add_range(d, n ? "angle" : NULL, "deg", r.min_angle, r.range_angle, (double)NAN,
                      &turn));
    }
    struct target target = {.path = join(d->b, target_name(d->b, d->object->id), "to_world"),
                            .type = PARAM_TRANSFORM,
                            .owner = owner,
                            .index = index,
                            .part = PART_TO_WORLD};
    struct write w = new_write(d, target);
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

/* Three channels, or what is left of them where a range is 0. */
static lmn_status add_channels(struct declaring *d, const struct ranges *r, struct vec3 declared,
                               struct drive drive[3])
{
    const float now[3] = {declared.x, declared.y, declared.z};
    for (int i = 0; i < 3; i++) {
        if (r->range[i] == 0) {
            drive[i] = constant(r->min[i]);
            continue;
        }
        lmn_status status = add_range(d, CHANNELS[i], "", r->min[i], r->range[i], (double)now[i],
                                      &drive[i]);
        if (status != LMN_OK) return status;
    }
    return LMN_OK;
}

/* 1 parameter scales min + u * range as a whole, 3 are the channels. A variable envmap turns. */
static lmn_status declare_emitter(struct declaring *d, uint32_t index)
{
    lmn_status status = LMN_OK;
    struct builder *b = d->b;
    const struct emitter *e = &b->emitters[index].emitter;
    struct ranges r;
    TRY(read_ranges(d->object, &r, d->err));
    if (e->kind == EMITTER_ENVMAP) {
        struct binding_step step = {.kind = STEP_ROTATE, .axis = vec3(0.0f, 1.0f, 0.0f)};
        d->kind = "envmap";
        TRY(add_range(d, NULL, "deg", 100, 40, (double)NAN, &step.drive[0]));
        struct write w = new_write(d, field(b, d->object->id, "to_world", BUILDER_EMITTER, index,
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
    TRY(own_texture(b, &slot, d->err));
    b->emitters[index].emitter.radiance = slot;
    struct write w = new_write(
        d, field(b, d->object->id, e->kind == EMITTER_POINT ? "intensity.value" : "radiance.value",
                 BUILDER_TEXTURE, slot, offsetof(struct texture, value), PARAM_RGB));
    w.kind = BINDING_RGB;
    if (r.n_parameters == 1) {
        struct drive whole;
        d->kind = "intensity";
        TRY(add_range(d, "intensity", "", 0, 1, (double)NAN, &whole));
        for (int i = 0; i < 3; i++)
            w.drive[i] = (struct drive){whole.variable, (float)r.min[i],
                                        (float)(r.min[i] + r.range[i])};
    } else {
        d->kind = "color";
        TRY(add_channels(d, &r, now, w.drive));
    }
    TRY(variable_set_write(b, &w, d->err));
done:
    return status;
}

/* What the wrappers around a material are about: its innermost one, from the front. */
static uint32_t unwrap(const struct builder *b, uint32_t index)
{
    for (int depth = 0; depth < 64; depth++) {
        const struct bsdf *f = &b->bsdfs[index].bsdf;
        if ((f->kind != BSDF_TWOSIDED && f->kind != BSDF_MASK) || f->child[0] >= b->n_bsdfs) break;
        index = f->child[0];
    }
    return index;
}

static uint32_t count_textures(const struct builder_object *o)
{
    uint32_t n = 1; /* the first reflectance is the material's own */
    for (uint32_t i = 0; i < o->n_extras; i++)
        n += strcmp(o->extras[i].name, "reflectance") == 0 && o->extras[i].texture != SCENE_NONE;
    return n;
}

static lmn_status write_color(struct declaring *d, uint32_t slot, const char *property,
                              const struct drive drive[3])
{
    struct write w = new_write(d, field(d->b, d->object->id, property, BUILDER_TEXTURE, slot,
                                        offsetof(struct texture, value), PARAM_RGB));
    w.kind = BINDING_RGB;
    memcpy(w.drive, drive, sizeof w.drive);
    return variable_set_write(d->b, &w, d->err);
}

/* 3: the reflectance, which multiplies a texture; 1: which of several textures; 4: both. */
static lmn_status declare_diffuse(struct declaring *d, uint32_t index,
                                  const struct builder_object *said)
{
    lmn_status status = LMN_OK;
    struct builder *b = d->b;
    struct ranges r;
    struct drive drive[3];
    TRY(read_ranges(said, &r, d->err));
    default_to_unit(&r);
    uint32_t n_textures = count_textures(said), n_options = 0;
    uint32_t *options = arena_new(b->arena, n_textures, sizeof *options);
    const char **names = arena_new(b->arena, n_textures, sizeof *names);
    if (!options || !names) {
        status = fail_memory(d->err, "the variables");
        goto done;
    }
    options[n_options++] = b->bsdfs[index].bsdf.reflectance;
    for (uint32_t i = 0; i < said->n_extras; i++)
        if (strcmp(said->extras[i].name, "reflectance") == 0 &&
            said->extras[i].texture != SCENE_NONE)
            options[n_options++] = said->extras[i].texture;
    bool has_color = r.n_parameters >= 3, has_choice = r.n_parameters != 3 && n_options > 1;
    for (uint32_t i = 0; i < n_options; i++) {
        const char *id = options[i] < b->n_textures ? b->textures[options[i]].object.id : NULL;
        char text[24];
        snprintf(text, sizeof text, "texture_%u", i);
        names[i] = id ? id : arena_strdup(b->arena, text);
        if (!names[i]) {
            status = fail_memory(d->err, "the variables");
            goto done;
        }
    }

    if (has_color) {
        d->kind = "color";
        for (uint32_t i = 0; i < n_options; i++) TRY(own_texture(b, &options[i], d->err));
        b->bsdfs[index].bsdf.reflectance = options[0];
        TRY(add_channels(d, &r, b->textures[options[0]].texture.value, drive));
        uint32_t n_written = has_choice ? n_options : 1;
        bool varies = b->variables->n_variables > d->first;
        for (uint32_t i = 0; i < n_written && varies; i++)
            TRY(write_color(d, options[i], "reflectance.value", drive));
    }
    if (has_choice) {
        struct write w = new_write(d, field(b, d->object->id, "reflectance", BUILDER_BSDF, index,
                                            offsetof(struct bsdf, reflectance), PARAM_TEXTURE));
        d->kind = "choice";
        TRY(add_choice(d, "texture", names, n_options, &w.variable));
        w.kind = BINDING_CHOICE;
        w.options = options;
        TRY(variable_set_write(b, &w, d->err));
    }
done:
    return status;
}

/* 1: alpha, the 4th bound; 3: specular reflectance; 4: both. */
static lmn_status declare_glossy(struct declaring *d, uint32_t index,
                                 const struct builder_object *said)
{
    lmn_status status = LMN_OK;
    struct builder *b = d->b;
    struct ranges r;
    TRY(read_ranges(said, &r, d->err));
    bool has_color = r.n_parameters >= 3, has_alpha = r.n_parameters == 1 || r.n_parameters >= 4;
    if (has_color) {
        struct drive drive[3];
        uint32_t slot = b->bsdfs[index].bsdf.specular_reflectance;
        default_to_unit(&r);
        d->kind = "color";
        TRY(own_texture(b, &slot, d->err));
        b->bsdfs[index].bsdf.specular_reflectance = slot;
        TRY(add_channels(d, &r, b->textures[slot].texture.value, drive));
        if (b->variables->n_variables > d->first)
            TRY(write_color(d, slot, "specular_reflectance.value", drive));
    }
    const struct bsdf *f = &b->bsdfs[index].bsdf;
    bool is_rough = f->kind == BSDF_ROUGH_CONDUCTOR || f->kind == BSDF_ROUGH_DIELECTRIC;
    if (!has_alpha || r.range[3] == 0) goto done;
    if (!is_rough) {
        status = fail_at(d->err, said->place, "\"%s\" has a variable alpha but is not rough",
                         d->object->id);
        goto done;
    }
    if (!(r.min[3] >= 0) || !(r.min[3] + r.range[3] >= 0)) {
        status = fail_at(d->err, said->place, "\"%s\": alpha would be negative", d->object->id);
        goto done;
    }
    uint32_t u = f->alpha_u, v = f->alpha_v;
    d->kind = "float";
    struct write w = new_write(d, field(b, d->object->id, "alpha.value", BUILDER_TEXTURE, u,
                                        offsetof(struct texture, value), PARAM_FLOAT));
    w.kind = BINDING_SPLAT;
    TRY(own_texture(b, &u, d->err));
    v = v == f->alpha_u ? u : v;
    b->bsdfs[index].bsdf.alpha_u = w.target.index = u;
    b->bsdfs[index].bsdf.alpha_v = v;
    TRY(add_range(d, "alpha", "", r.min[3], r.range[3], (double)b->textures[u].texture.value.x,
                  &w.drive[0]));
    TRY(variable_set_write(b, &w, d->err));
    if (v == u) goto done;
    TRY(own_texture(b, &v, d->err));
    b->bsdfs[index].bsdf.alpha_v = w.target.index = v;
    TRY(variable_set_write(b, &w, d->err));
done:
    return status;
}

/* The id may be on the wrapper of the material that varies, and the ranges with either. */
static lmn_status declare_bsdf(struct declaring *d, uint32_t index)
{
    uint32_t inner = unwrap(d->b, index);
    const struct builder_object *said = d->object;
    if (said->n_extras == 0) said = &d->b->bsdfs[inner].object;
    switch (d->b->bsdfs[inner].bsdf.kind) {
    case BSDF_DIFFUSE:
        return declare_diffuse(d, inner, said);
    case BSDF_PLASTIC:
    case BSDF_CONDUCTOR:
    case BSDF_ROUGH_CONDUCTOR:
    case BSDF_DIELECTRIC:
    case BSDF_ROUGH_DIELECTRIC:
        return declare_glossy(d, inner, said);
    case BSDF_TWOSIDED:
    case BSDF_MASK:
        break;
    }
    return LMN_OK;
}

/* 1 parameter: which of its shapes is there. */
static lmn_status declare_group(struct declaring *d, uint32_t index)
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
    TRY(add_choice(d, "shape", names, n, &variable));
    n = 0;
    for (uint32_t i = 0; i < b->n_shapes; i++) {
        if (b->shapes[i].group != index) continue;
        struct target target = {.path = join(b, b->shapes[i].name, "visible"),
                                .type = PARAM_BOOL,
                                .owner = BUILDER_SHAPE,
                                .index = i,
                                .part = PART_VISIBLE};
        struct write w = new_write(d, target);
        w.kind = BINDING_VISIBLE;
        w.condition = (struct binding_condition){variable, n++};
        TRY(variable_set_write(b, &w, d->err));
    }
done:
    return status;
}

/* ---- All objects, in order ------------------------------------------------------------------ */

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
        status = declare_sensor(&d);
        break;
    case BUILDER_SHAPE:
        status = declare_placement(&d, BUILDER_SHAPE, item->index, NULL);
        break;
    case BUILDER_INSTANCE:
        status = declare_placement(&d, BUILDER_INSTANCE, item->index,
                                   &b->instances[item->index].to_world);
        break;
    case BUILDER_EMITTER:
        status = declare_emitter(&d, item->index);
        break;
    case BUILDER_BSDF:
        status = declare_bsdf(&d, item->index);
        break;
    case BUILDER_GROUP:
        status = declare_group(&d, item->index);
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
