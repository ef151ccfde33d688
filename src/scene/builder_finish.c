/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "scene/bounds.h"
#include "scene/builder_private.h"

/* A copy of an array in the arena; never NULL unless memory is short. */
static void *arena_copy(struct arena *a, const void *from, size_t n, size_t size)
{
    void *to = arena_new(a, n, size);
    if (to && n) memcpy(to, from, n * size);
    return to;
}

/* ---- Checks that need the whole ------------------------------------------------------------ */

enum { MAX_BSDF_DEPTH = 12, MAX_INSTANCES = 1 << 22 };

static bool is_zero(const struct texture *t)
{
    return t->kind == TEXTURE_CONSTANT && vec3_is_zero(t->value);
}

static bool transmits_itself(const struct builder *b, const struct bsdf *f)
{
    if (f->kind == BSDF_PRINCIPLED) {
        uint32_t t = f->principled[PRINCIPLED_SPEC_TRANS];
        return t < b->n_textures && !is_zero(&b->textures[t].texture);
    }
    return f->kind == BSDF_DIELECTRIC || f->kind == BSDF_ROUGH_DIELECTRIC ||
           f->kind == BSDF_THIN_DIELECTRIC || f->kind == BSDF_NULL || f->kind == BSDF_MASK;
}

/* Nested materials are added before what holds them, so one pass in order sees children first. */
static lmn_status check_bsdfs(const struct builder *b, struct error *err)
{
    lmn_status status = LMN_OK;
    uint8_t *depths = mem_new(b->n_bsdfs, 1);
    bool *transmits = mem_new(b->n_bsdfs, sizeof *transmits);
    if (!depths || !transmits) {
        status = fail_memory(err, "the scene");
        goto done;
    }
    for (uint32_t i = 0; i < b->n_bsdfs; i++) {
        const struct builder_bsdf *f = &b->bsdfs[i];
        transmits[i] = transmits_itself(b, &f->bsdf);
        for (int c = 0; c < 2; c++) {
            uint32_t child = f->bsdf.child[c];
            if (child == SCENE_NONE) continue;
            if (depths[child] >= depths[i]) depths[i] = (uint8_t)(depths[child] + 1);
            transmits[i] |= transmits[child];
        }
        if (depths[i] > MAX_BSDF_DEPTH) {
            status = fail_at(err, f->object.place, "materials are nested deeper than %d",
                             MAX_BSDF_DEPTH);
            goto done;
        }
        if (f->bsdf.kind == BSDF_TWOSIDED && transmits[i]) {
            status = fail_at(err, f->object.place,
                             "twosided: only materials without transmission can be nested in it");
            goto done;
        }
    }
done:
    mem_free(depths);
    mem_free(transmits);
    return status;
}

static lmn_status check_shapes(const struct builder *b, struct error *err)
{
    for (size_t i = 0; i < b->n_shapes; i++) {
        const struct builder_shape *s = &b->shapes[i];
        if (s->emitter == SCENE_NONE) continue;
        if (!emitter_is_surface(b->emitters[s->emitter].emitter.kind))
            return fail_at(err, s->object.place, "shape \"%s\": only an area emitter can be on it",
                           s->name);
    }
    for (size_t i = 0; i < b->n_instances; i++) {
        if (b->instances[i].group >= b->n_groups)
            return fail_at(err, b->instances[i].object.place, "instance \"%s\" has no shapegroup",
                           b->instances[i].name);
    }
    return LMN_OK;
}

/* ---- Lowering ------------------------------------------------------------------------------ */

/* What the passes below fill. Builder groups have their shapes in a list, so that the passes take
 * time linear in what they make; the top level is the list n_groups. */
struct lowering {
    struct builder *b;
    struct scene *s;
    uint32_t *first;          /* [n_groups + 1] first builder shape of the list, or SCENE_NONE */
    uint32_t *next;           /* [n_shapes] */
    uint32_t *n_movable;      /* [n_groups + 1] */
    uint32_t *group_of_shape; /* [n_shapes] final group of a movable shape */
    uint32_t *rest_of_group;  /* [n_groups + 1] final group of what is left of it, or SCENE_NONE */
};

static uint32_t list_of(const struct builder *b, uint32_t group)
{
    return group == SCENE_NONE ? (uint32_t)b->n_groups : group;
}

static void list_shapes(struct lowering *l)
{
    const struct builder *b = l->b;
    for (size_t g = 0; g <= b->n_groups; g++) l->first[g] = SCENE_NONE;
    for (size_t i = b->n_shapes; i-- > 0;) {
        uint32_t g = list_of(b, b->shapes[i].group);
        l->next[i] = l->first[g];
        l->first[g] = (uint32_t)i;
        l->n_movable[g] += b->shapes[i].is_movable;
    }
}

static void append_shape(struct lowering *l, size_t i)
{
    struct scene *s = l->s;
    struct builder_shape *from = &l->b->shapes[i];
    from->final_shape = s->n_shapes;
    s->defaults.shape_bsdfs[s->n_shapes] = from->bsdf;
    s->shapes[s->n_shapes++] = (struct shape){
        .name = from->name,
        .kind = from->kind,
        .mesh = from->kind == SHAPE_MESH ? from->mesh : SCENE_NONE,
        .to_group = from->kind == SHAPE_MESH ? transform_identity() : from->to_world,
        .emitter = from->emitter,
        .flip_normals = from->flip_normals,
    };
}

static void begin_group(struct lowering *l, const char *name)
{
    struct scene *s = l->s;
    s->groups[s->n_groups++] = (struct group){.name = name, .first_shape = s->n_shapes};
}

static void end_group(struct lowering *l)
{
    struct group *g = &l->s->groups[l->s->n_groups - 1];
    g->n_shapes = l->s->n_shapes - g->first_shape;
    g->bounds = group_bounds(l->s, g);
}

/* The group of all shapes of a list that stay together. */
static void append_rest(struct lowering *l, uint32_t list, const char *name)
{
    struct builder *b = l->b;
    begin_group(l, name);
    for (uint32_t i = l->first[list]; i != SCENE_NONE; i = l->next[i]) {
        if (!b->shapes[i].is_movable) append_shape(l, i);
    }
    end_group(l);
    if (list < b->n_groups && l->s->groups[l->s->n_groups - 1].n_shapes == 0) {
        l->s->n_groups--; /* everything in it moves by itself */
        l->rest_of_group[list] = SCENE_NONE;
    } else {
        l->rest_of_group[list] = l->s->n_groups - 1;
    }
}

static void append_instance(struct lowering *l, uint32_t group, const struct transform *to_world,
                            uint32_t shape, uint32_t instance)
{
    struct scene *s = l->s;
    l->b->placements[s->n_instances] = (struct builder_placement){shape, instance};
    s->defaults.instances[s->n_instances++] = (struct instance){
        .group = group, .to_world = *to_world, .is_visible = true};
}

/* Final instances of a list, as placed by one builder instance (SCENE_NONE: top level). */
static void append_instances(struct lowering *l, uint32_t list, const struct transform *to_world,
                             uint32_t instance)
{
    if (l->rest_of_group[list] != SCENE_NONE)
        append_instance(l, l->rest_of_group[list], to_world, SCENE_NONE, instance);
    if (l->n_movable[list] == 0) return;
    for (uint32_t i = l->first[list]; i != SCENE_NONE; i = l->next[i]) {
        if (l->b->shapes[i].is_movable)
            append_instance(l, l->group_of_shape[i], to_world, i, instance);
    }
}

static void lower(struct lowering *l)
{
    struct builder *b = l->b;
    uint32_t top = (uint32_t)b->n_groups;
    append_rest(l, top, "scene");
    for (uint32_t g = 0; g < top; g++) {
        const char *id = b->groups[g].object.id;
        append_rest(l, g, id ? id : "shapegroup");
    }
    for (uint32_t i = 0; i < b->n_shapes; i++) {
        if (!b->shapes[i].is_movable) continue;
        begin_group(l, b->shapes[i].name);
        append_shape(l, i);
        end_group(l);
        l->group_of_shape[i] = l->s->n_groups - 1;
    }
    struct transform identity = transform_identity();
    append_instances(l, top, &identity, SCENE_NONE);
    for (uint32_t k = 0; k < b->n_instances; k++)
        append_instances(l, b->instances[k].group, &b->instances[k].to_world, k);
}

/* Bound of the number of final instances, or false when it is absurd. */
static bool count_instances(const struct lowering *l, size_t *out)
{
    const struct builder *b = l->b;
    size_t n = 1 + (size_t)l->n_movable[b->n_groups];
    for (size_t k = 0; k < b->n_instances; k++)
        n += 1 + (size_t)l->n_movable[b->instances[k].group];
    *out = n;
    return n < MAX_INSTANCES;
}

lmn_status builder_finish(struct builder *b, struct scene **out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct scene *s = b->scene;
    struct scene_state *d = &s->defaults;
    struct lowering l = {.b = b, .s = s};
    size_t max_instances;

    if (!b->private->has_sensor)
        return fail_at(err, (struct place){b->path, 0, 0}, "the scene has no sensor");
    TRY(check_bsdfs(b, err));
    TRY(check_shapes(b, err));

    l.first = mem_new(b->n_groups + 1, sizeof *l.first);
    l.next = mem_new(b->n_shapes, sizeof *l.next);
    l.n_movable = mem_new(b->n_groups + 1, sizeof *l.n_movable);
    l.group_of_shape = mem_new(b->n_shapes, sizeof *l.group_of_shape);
    l.rest_of_group = mem_new(b->n_groups + 1, sizeof *l.rest_of_group);
    if (!l.first || !l.next || !l.n_movable || !l.group_of_shape || !l.rest_of_group) {
        status = fail_memory(err, "the scene");
        goto done;
    }
    list_shapes(&l);
    if (!count_instances(&l, &max_instances)) {
        status = fail_at(err, (struct place){b->path, 0, 0}, "more than %d instances",
                         MAX_INSTANCES);
        goto done;
    }
    size_t max_groups = 1 + b->n_groups + b->n_shapes;
    s->shapes = arena_new(b->arena, b->n_shapes, sizeof *s->shapes);
    s->groups = arena_new(b->arena, max_groups, sizeof *s->groups);
    s->meshes = arena_copy(b->arena, b->meshes, b->n_meshes, sizeof *s->meshes);
    s->bitmaps = arena_copy(b->arena, b->bitmaps, b->n_bitmaps, sizeof *s->bitmaps);
    d->textures = arena_new(b->arena, b->n_textures, sizeof *d->textures);
    d->bsdfs = arena_new(b->arena, b->n_bsdfs, sizeof *d->bsdfs);
    d->emitters = arena_new(b->arena, b->n_emitters, sizeof *d->emitters);
    s->light_groups = arena_new(b->arena, b->n_emitters, sizeof *s->light_groups);
    d->instances = arena_new(b->arena, max_instances, sizeof *d->instances);
    d->shape_bsdfs = arena_new(b->arena, b->n_shapes, sizeof *d->shape_bsdfs);
    b->placements = mem_new(max_instances, sizeof *b->placements);
    if (!s->shapes || !s->groups || !s->meshes || !s->bitmaps || !d->textures || !d->bsdfs ||
        !d->emitters || !s->light_groups || !d->instances || !d->shape_bsdfs || !b->placements) {
        status = fail_memory(err, "the scene");
        goto done;
    }
    s->n_meshes = (uint32_t)b->n_meshes;
    s->n_bitmaps = (uint32_t)b->n_bitmaps;
    s->n_textures = (uint32_t)b->n_textures;
    s->n_bsdfs = (uint32_t)b->n_bsdfs;
    s->n_emitters = (uint32_t)b->n_emitters;
    for (size_t i = 0; i < b->n_textures; i++) d->textures[i] = b->textures[i].texture;
    for (size_t i = 0; i < b->n_bsdfs; i++) d->bsdfs[i] = b->bsdfs[i].bsdf;
    for (size_t i = 0; i < b->n_emitters; i++) {
        d->emitters[i] = b->emitters[i].emitter;
        s->light_groups[i] = b->emitters[i].light_group;
    }
    d->sensor = b->sensor;
    s->settings = b->settings;
    s->hash = b->hash;
    lower(&l);
    s->bounds = scene_bounds(s, d);
    b->private->owns_scene = false;
    *out = s;
done:
    mem_free(l.first);
    mem_free(l.next);
    mem_free(l.n_movable);
    mem_free(l.group_of_shape);
    mem_free(l.rest_of_group);
    return status;
}
