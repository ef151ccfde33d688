/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/frames.h"

#include <math.h>
#include <string.h>

#include "scene/binding.h"
#include "scene/bounds.h"

struct frame_source {
    enum frame_kind kind;
    uint32_t index;                   /* as in struct scene_frame */
    const struct binding *binding;    /* OBJECT: what moves it */
    struct bounds bounds;             /* OBJECT: in the space of the first instance */
    uint32_t first_member, n_members; /* OBJECT: its instances */
    bool shines;
};

/* ---- What moves ------------------------------------------------------------------------------ */

static const struct binding *find_binding(const struct scene *s, enum state_array array,
                                          uint32_t index, size_t offset)
{
    for (uint32_t i = 0; i < s->n_bindings; i++) {
        const struct binding *b = &s->bindings[i];
        if (b->array == array && b->index == index && b->offset == offset) return b;
    }
    return NULL;
}

/* Steps that variables drive: without the place of the object itself, which comes last. */
static uint32_t n_driven_steps(const struct binding *b)
{
    const uint32_t n = b->n_steps;
    return n > 0 && b->steps[n - 1].kind == STEP_FIXED ? n - 1 : n;
}

/* Their structs have no padding: variables.c hashes them whole, too. */
static bool move_together(const struct binding *a, const struct binding *b)
{
    const uint32_t n = n_driven_steps(a);
    if (a->kind != BINDING_TRANSFORM || b->kind != BINDING_TRANSFORM) return false;
    return n == n_driven_steps(b) && memcmp(a->steps, b->steps, n * sizeof *a->steps) == 0;
}

static bool is_finite(const struct transform *t)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            if (!isfinite(t->m[i][j]) || !isfinite(t->inv[i][j])) return false;
    return true;
}

static struct transform inverse(const struct transform *t)
{
    struct transform r;
    memcpy(r.m, t->inv, sizeof r.m);
    memcpy(r.inv, t->m, sizeof r.inv);
    return r;
}

/* Adds an instance to an object that moves with it. False when it cannot be placed in its frame. */
static bool join(const struct scene *s, struct frame_source *source, uint32_t instance)
{
    const struct instance *all = s->defaults.instances;
    const struct bounds *g = &s->groups[all[instance].group].bounds;
    const struct transform from_world = inverse(&all[source->index].to_world);
    const struct transform to_first = transform_mul(&from_world, &all[instance].to_world);
    if (!is_finite(&to_first)) return false;
    const struct bounds b = bounds_transform(g, &to_first);
    bounds_add(&source->bounds, b.min);
    bounds_add(&source->bounds, b.max);
    return true;
}

static bool group_shines(const struct scene *s, const struct group *g)
{
    for (uint32_t i = g->first_shape; i < g->first_shape + g->n_shapes; i++)
        if (s->shapes[i].emitter != SCENE_NONE) return true;
    return false;
}

/* Which frame each instance belongs to, into owners [n_instances]; SCENE_NONE: to none. */
static void add_objects(struct scene_frames *f, uint32_t *owners)
{
    const struct scene *s = f->scene;
    for (uint32_t i = 0; i < s->n_instances; i++) {
        const struct group *g = &s->groups[s->defaults.instances[i].group];
        const struct binding *b = find_binding(s, STATE_INSTANCES, i,
                                               offsetof(struct instance, to_world));
        owners[i] = SCENE_NONE;
        if (!b || bounds_is_empty(&g->bounds)) continue;
        for (uint32_t k = 0; k < f->n && owners[i] == SCENE_NONE; k++)
            if (move_together(f->sources[k].binding, b) && join(s, &f->sources[k], i))
                owners[i] = k;
        if (owners[i] == SCENE_NONE) {
            owners[i] = f->n;
            f->sources[f->n++] = (struct frame_source){
                .kind = FRAME_OBJECT, .index = i, .binding = b, .bounds = g->bounds};
        }
        f->sources[owners[i]].n_members++;
        f->sources[owners[i]].shines |= group_shines(s, g);
    }
}

/* Fills in the lists of members. */
static void list_members(struct scene_frames *f, const uint32_t *owners)
{
    uint32_t first = 0;
    for (uint32_t k = 0; k < f->n; k++) {
        f->sources[k].first_member = first;
        first += f->sources[k].n_members;
        f->sources[k].n_members = 0;
    }
    for (uint32_t i = 0; i < f->scene->n_instances; i++) {
        if (owners[i] == SCENE_NONE) continue;
        struct frame_source *source = &f->sources[owners[i]];
        f->members[source->first_member + source->n_members++] = i;
    }
}

static bool emitter_moves(const struct scene *s, uint32_t i)
{
    const enum emitter_kind kind = s->defaults.emitters[i].kind;
    if (emitter_is_surface(kind) || kind == EMITTER_CONSTANT) return false;
    if (find_binding(s, STATE_EMITTERS, i, offsetof(struct emitter, to_world))) return true;
    return kind == EMITTER_SKY &&
           (find_binding(s, STATE_EMITTERS, i, offsetof(struct emitter, sun_elevation)) ||
            find_binding(s, STATE_EMITTERS, i, offsetof(struct emitter, sun_azimuth)));
}

static void add_emitters(struct scene_frames *f)
{
    const struct scene *s = f->scene;
    for (uint32_t i = 0; i < s->n_emitters; i++) {
        const enum emitter_kind kind = s->defaults.emitters[i].kind;
        const bool is_far = emitter_is_environment(kind) || kind == EMITTER_DIRECTIONAL;
        if (!emitter_moves(s, i)) continue;
        f->sources[f->n++] = (struct frame_source){
            .kind = is_far ? FRAME_AROUND : FRAME_LIGHT, .index = i, .shines = true};
    }
}

lmn_status scene_frames_init(const struct scene *s, struct scene_frames *out, struct error *err)
{
    lmn_status status = LMN_OK;
    const size_t n_max = (size_t)s->n_instances + s->n_emitters;
    uint32_t *owners = mem_new(s->n_instances, sizeof *owners);
    *out = (struct scene_frames){
        .scene = s,
        .sources = mem_new(n_max, sizeof *out->sources),
        .members = mem_new(s->n_instances, sizeof *out->members),
    };
    if ((n_max && !out->sources) || (s->n_instances && (!owners || !out->members))) {
        status = fail_memory(err, "the frames of movable objects");
        goto done;
    }
    add_objects(out, owners);
    list_members(out, owners);
    add_emitters(out);
done:
    mem_free(owners);
    if (status) scene_frames_release(out);
    return status;
}

void scene_frames_release(struct scene_frames *f)
{
    mem_free(f->sources);
    mem_free(f->members);
    *f = (struct scene_frames){0};
}

/* ---- Of a configuration ---------------------------------------------------------------------- */

/* A cube of this half side around a point, turned so that its axes are x, y, z: unit and at right
 * angles. */
static struct transform cube(struct vec3 center, const struct vec3 axes[3], float radius)
{
    struct transform t;
    const float c[3] = {center.x, center.y, center.z};
    for (int i = 0; i < 3; i++) {
        const float a[3] = {axes[i].x, axes[i].y, axes[i].z};
        for (int j = 0; j < 3; j++) {
            t.m[i][j] = a[j] / radius;
            t.inv[j][i] = a[j] * radius;
        }
        t.m[i][3] = -vec3_dot(axes[i], center) / radius;
        t.inv[i][3] = c[i];
    }
    return t;
}

static const struct vec3 world_axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* Half the diagonal of the scene; 1 where there is nothing. */
static float scene_radius(const struct scene *s)
{
    const float r = 0.5f * vec3_length(vec3_sub(s->bounds.max, s->bounds.min));
    return r > 0.0f && isfinite(r) ? r : 1.0f;
}

static struct vec3 middle(const struct bounds *b)
{
    return vec3_scale(vec3_add(b->min, b->max), 0.5f);
}

/* From the bounds to the cube. */
static struct transform fill_cube(const struct bounds *b, float least)
{
    const struct vec3 half = vec3_scale(vec3_sub(b->max, b->min), 0.5f);
    least = fmaxf(FRAME_MIN_SIDE * vec3_max(half), least);
    const struct transform back = transform_translate(vec3_neg(middle(b)));
    const struct transform shrink = transform_scale(vec3(
        1.0f / fmaxf(half.x, least), 1.0f / fmaxf(half.y, least), 1.0f / fmaxf(half.z, least)));
    return transform_mul(&shrink, &back);
}

/* The axes of a light whose +z is mapped to z; false when z is no direction. What the map does to
 * +x stays in the plane of x and z. */
static bool light_axes(struct vec3 z, struct vec3 x, bool flips, struct vec3 axes[3])
{
    const float length = vec3_length(z);
    if (!(length > 0.0f) || !isfinite(length)) return false;
    z = vec3_scale(z, 1.0f / length);
    x = vec3_sub(x, vec3_scale(z, vec3_dot(x, z)));
    const float rest = vec3_length(x);
    x = rest > 1e-12f && isfinite(rest) ? vec3_scale(x, 1.0f / rest) : frame_from_normal(z).s;
    axes[0] = x;
    axes[1] = vec3_cross(z, x);
    if (flips) axes[1] = vec3_neg(axes[1]);
    axes[2] = z;
    return true;
}

/* Where the light goes, in the emitter's own space. */
static struct vec3 light_direction(const struct emitter *e)
{
    if (e->kind != EMITTER_SKY) return vec3(0, 0, 1);
    const float degree = 3.14159265f / 180.0f;
    const float up = e->sun_elevation * degree, around = e->sun_azimuth * degree;
    return vec3(-cosf(up) * cosf(around), -cosf(up) * sinf(around), -sinf(up));
}

static void light_frame(const struct scene *s, const struct emitter *e, struct scene_frame *out)
{
    const struct transform *t = &e->to_world;
    const bool is_far = out->kind == FRAME_AROUND;
    struct vec3 axes[3], center = middle(&s->bounds);
    memcpy(axes, world_axes, sizeof axes);
    if (!is_far) {
        const struct vec3 at = transform_point(t, vec3_splat(0.0f));
        if (vec3_is_finite(at)) center = at;
    }
    if (e->kind != EMITTER_POINT)
        light_axes(transform_vector(t, light_direction(e)), transform_vector(t, vec3(1, 0, 0)),
                   transform_flips(t), axes);
    out->to_local = cube(center, axes, scene_radius(s) * (is_far ? 1.0f : 0.5f));
}

static void object_frame(const struct scene_frames *f, const struct scene_state *state,
                         const struct frame_source *source, struct scene_frame *out)
{
    const struct scene *s = f->scene;
    const float radius = scene_radius(s);
    const struct transform fill = fill_cube(&source->bounds, 1e-6f * radius);
    const struct transform from_world = inverse(&state->instances[source->index].to_world);
    out->to_local = transform_mul(&fill, &from_world);
    out->is_visible = false;
    for (uint32_t k = 0; k < source->n_members; k++)
        out->is_visible |= state->instances[f->members[source->first_member + k]].is_visible;
    if (is_finite(&out->to_local)) return;
    out->is_visible = false;
    out->to_local = cube(middle(&s->bounds), world_axes, radius);
}

void scene_frame_at(const struct scene_frames *f, const struct scene_state *state, uint32_t k,
                    struct scene_frame *out)
{
    const struct frame_source *source = &f->sources[k];
    *out = (struct scene_frame){
        .kind = source->kind, .index = source->index, .is_visible = true, .shines = source->shines};
    if (source->kind == FRAME_OBJECT)
        object_frame(f, state, source, out);
    else
        light_frame(f->scene, &state->emitters[source->index], out);
    out->center = transform_point_inverse(&out->to_local, vec3_splat(0.0f));
    out->axis = vec3_normalize(transform_vector_inverse(&out->to_local, vec3(0, 0, 1)));
}
