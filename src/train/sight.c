/* SPDX-License-Identifier: Apache-2.0 */
#include "train/sight.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "base/pool.h"
#include "scene/binding.h"
#include "scene/bounds.h"
#include "train/inputs.h"

enum {
    SURFACE_FEATURES = 14, /* normal 3, direction 3, mirrored 3, roughness, albedo 3, glossy */
    FRAME_FEATURES = 4,    /* direction 3, nearness */
    LIGHT_FEATURES = 5,    /* direction 3, nearness, cosine */
    PASSAGE_FEATURES = 4   /* closest approach 3, nearness */
};

/* Of what has no albedo (metals, glass) or little: the scale must not jump where a pixel shows a
 * bit of another surface. */
#define LEAST_SCALE 0.1f

/* ---- What the scene has --------------------------------------------------------------------- */

static void add_light(struct sight *s, uint32_t instance, uint32_t shape, uint32_t emitter,
                      struct vec3 center)
{
    if (s->n_lights == SIGHT_LIGHTS) return;
    s->lights[s->n_lights].instance = instance;
    s->lights[s->n_lights].shape = shape;
    s->lights[s->n_lights].emitter = emitter;
    s->lights[s->n_lights++].center = center;
}

/* Those that have a place, in the scene's order. */
static void find_lights(struct sight *s)
{
    const struct scene *scene = s->scene;
    for (uint32_t i = 0; i < scene->n_instances; i++) {
        const struct group *g = &scene->groups[scene->defaults.instances[i].group];
        for (uint32_t k = 0; k < g->n_shapes; k++) {
            const struct shape *shape = &scene->shapes[g->first_shape + k];
            if (shape->emitter == SCENE_NONE) continue;
            const struct bounds b = shape_bounds(scene, shape);
            struct vec3 center = vec3_scale(vec3_add(b.min, b.max), 0.5f);
            add_light(s, i, g->first_shape + k, shape->emitter, center);
        }
    }
    for (uint32_t i = 0; i < scene->n_emitters; i++) {
        enum emitter_kind kind = scene->defaults.emitters[i].kind;
        if (kind == EMITTER_POINT || kind == EMITTER_SPOT || kind == EMITTER_PROJECTOR)
            add_light(s, SCENE_NONE, SCENE_NONE, i, vec3_splat(0.0f));
    }
}

static void use_drives(const struct drive *drives, int n, bool *is_used)
{
    for (int i = 0; i < n; i++)
        if (drives[i].variable != SCENE_NONE) is_used[drives[i].variable] = true;
}

/* Marks the variables that a binding follows. */
static void use_binding(const struct binding *b, bool *is_used)
{
    switch (b->kind) {
    case BINDING_NUMBER:
    case BINDING_SPLAT:
        use_drives(b->drive, 1, is_used);
        break;
    case BINDING_RGB:
        use_drives(b->drive, 3, is_used);
        break;
    case BINDING_TRANSFORM:
        for (uint32_t i = 0; i < b->n_steps; i++) use_drives(b->steps[i].drive, 3, is_used);
        break;
    case BINDING_CAMERA:
        use_drives(b->camera->origin, 3, is_used);
        use_drives(b->camera->target, 3, is_used);
        break;
    case BINDING_CHOICE:
        is_used[b->variable] = true;
        break;
    case BINDING_VISIBLE:
        for (uint32_t i = 0; i < b->n_conditions; i++) is_used[b->conditions[i].variable] = true;
        break;
    }
}

lmn_status sight_init(struct sight *s, const struct scene *scene, struct error *err)
{
    lmn_status status = LMN_OK;
    bool *is_used = NULL;
    *s = (struct sight){.scene = scene};
    TRY(scene_frames_init(scene, &s->frames, err));
    s->n_frames = s->frames.n < SIGHT_FRAMES ? s->frames.n : SIGHT_FRAMES;
    find_lights(s);
    s->n_positions = 1 + s->n_frames;
    s->n_features = SURFACE_FEATURES + s->n_frames * FRAME_FEATURES +
                    s->n_lights * (LIGHT_FEATURES + s->n_frames * PASSAGE_FEATURES);
    is_used = mem_new((size_t)scene->n_variables + 1, sizeof *is_used);
    s->variables = mem_new((size_t)scene->n_variables + 1, sizeof *s->variables);
    if (!is_used || !s->variables) {
        status = fail_memory(err, "the network's inputs");
        goto done;
    }
    for (uint32_t i = 0; i < scene->n_bindings; i++)
        if (scene->bindings[i].array != STATE_SENSOR) use_binding(&scene->bindings[i], is_used);
    for (uint32_t i = 0; i < scene->n_variables; i++)
        if (is_used[i]) s->variables[s->n_variables++] = i;
done:
    mem_free(is_used);
    if (status != LMN_OK) sight_release(s);
    return status;
}

void sight_release(struct sight *s)
{
    scene_frames_release(&s->frames);
    mem_free(s->variables);
    *s = (struct sight){0};
}

struct field_config sight_field(const struct sight *s)
{
    return (struct field_config){
        .n_grids = s->n_positions, .n_features = s->n_features, .n_variables = s->n_variables};
}

void sight_variables(const struct sight *s, const float *u, float *v)
{
    for (uint32_t i = 0; i < s->n_variables; i++)
        v[i] = inputs_variable(s->scene, s->variables[i], u[s->variables[i]]);
}

/* ---- What a pixel shows --------------------------------------------------------------------- */

static float finite_or_zero(float x)
{
    return isfinite(x) ? x : 0.0f;
}

static struct vec3 load(const float *b, int channel)
{
    return vec3(finite_or_zero(b[channel]), finite_or_zero(b[channel + 1]),
                finite_or_zero(b[channel + 2]));
}

static float *put(float *to, struct vec3 v)
{
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
    return to + 3;
}

/* Direction, and how near what lies at v from the origin is: 1 there, 0 far away. */
static float *put_direction(float *to, struct vec3 v)
{
    float length = vec3_length(v);
    to = put(to, vec3_scale(v, length > 0.0f ? 1.0f / length : 0.0f));
    *to++ = 1.0f / (1.0f + length);
    return to;
}

static float *surface(const float *b, float *to)
{
    struct vec3 n = load(b, BUFFER_NORMAL), wo = load(b, BUFFER_WO);
    bool is_glossy = !vec3_is_zero(load(b, BUFFER_WI)); /* that buffer is zero on diffuse ones */
    const struct vec3 none = {0, 0, 0};
    struct vec3 mirrored = vec3_sub(vec3_scale(n, 2.0f * vec3_dot(n, wo)), wo);
    to = put(to, n);
    to = put(to, is_glossy ? wo : none);
    to = put(to, is_glossy ? mirrored : none);
    *to++ = finite_or_zero(b[BUFFER_ROUGHNESS]);
    to = put(to, load(b, BUFFER_ALBEDO));
    *to++ = is_glossy ? 1.0f : 0.0f;
    return to;
}

/* The point of the segment from p to q that is closest to the origin. */
static struct vec3 closest(struct vec3 p, struct vec3 q)
{
    struct vec3 d = vec3_sub(q, p);
    float length2 = vec3_dot(d, d);
    float t = length2 > 0.0f ? -vec3_dot(p, d) / length2 : 0.0f;
    return vec3_madd(p, d, min_float(max_float(t, 0.0f), 1.0f));
}

static void scale_of(const float *b, float *to)
{
    const bool is_hit = b[BUFFER_DEPTH] > 0.0f;
    for (int c = 0; c < 3; c++) {
        float albedo = finite_or_zero(b[BUFFER_ALBEDO + c]);
        to[c] = is_hit ? max_float(albedo, LEAST_SCALE) : 0.0f;
    }
}

void sight_look(const struct sight *s, const struct scene_state *state, const float *buffers,
                uint32_t n, float *positions, float *features, float *scale)
{
    const struct bounds *box = &s->scene->bounds;
    const struct vec3 size = vec3_sub(box->max, box->min);
    const float per_diagonal = 1.0f / max_float(vec3_length(size), 1e-20f);
    struct scene_frame frames[SIGHT_FRAMES] = {0};
    struct vec3 lights[SIGHT_LIGHTS];
    for (uint32_t k = 0; k < s->n_frames; k++) scene_frame_at(&s->frames, state, k, &frames[k]);
    for (uint32_t l = 0; l < s->n_lights; l++) {
        uint32_t i = s->lights[l].instance;
        const struct transform *t = i == SCENE_NONE
                                        ? &state->emitters[s->lights[l].emitter].to_world
                                        : &state->instances[i].to_world;
        lights[l] = transform_point(t, s->lights[l].center);
    }
    for (uint32_t i = 0; i < n; i++) {
        const float *b = buffers + (size_t)i * BUFFER_CHANNELS;
        float *x = positions + (size_t)i * s->n_positions * 3;
        float *f = features + (size_t)i * s->n_features;
        const struct vec3 p = load(b, BUFFER_POSITION), normal = load(b, BUFFER_NORMAL);
        struct vec3 local[SIGHT_FRAMES] = {0};
        struct vec3 in_box = vec3_sub(p, box->min);
        x = put(x, vec3(in_box.x / max_float(size.x, 1e-20f), in_box.y / max_float(size.y, 1e-20f),
                        in_box.z / max_float(size.z, 1e-20f)));
        f = surface(b, f);
        for (uint32_t k = 0; k < s->n_frames; k++) {
            if (!frames[k].is_visible) {
                x = put(x, vec3_splat(0.5f));
                f = put(f, vec3_splat(0.0f));
                *f++ = 0.0f;
                continue;
            }
            local[k] = transform_point(&frames[k].to_local, p);
            float scale_to_cube = 0.5f / (1.0f + vec3_length(local[k]));
            x = put(x, vec3_madd(vec3_splat(0.5f), local[k], scale_to_cube));
            f = put_direction(f, local[k]);
        }
        for (uint32_t l = 0; l < s->n_lights; l++) {
            struct vec3 to_light = vec3_sub(lights[l], p);
            f = put_direction(f, vec3_scale(to_light, 8.0f * per_diagonal));
            *f = vec3_dot(vec3(f[-4], f[-3], f[-2]), normal);
            f++;
            for (uint32_t k = 0; k < s->n_frames; k++) {
                if (!frames[k].is_visible) {
                    f = put(f, vec3_splat(0.0f));
                    *f++ = 0.0f;
                    continue;
                }
                struct vec3 light = transform_point(&frames[k].to_local, lights[l]);
                struct vec3 at = closest(local[k], light);
                float nearness = 1.0f / (1.0f + vec3_length(at));
                f = put(f, vec3_scale(at, nearness));
                *f++ = nearness;
            }
        }
        scale_of(b, scale + 3 * (size_t)i);
    }
}

enum { LOOK_CHUNK = 1 << 10 };

struct look_job {
    const struct sight *sight;
    const struct scene_state *state;
    const float *buffers;
    uint32_t n;
    float *positions, *features, *scale;
};

static void look_chunk(void *ctx, uint32_t item, uint32_t worker)
{
    const struct look_job *j = ctx;
    const uint32_t at = item * LOOK_CHUNK, n = j->n - at < LOOK_CHUNK ? j->n - at : LOOK_CHUNK;
    const size_t first = at;
    (void)worker;
    sight_look(j->sight, j->state, j->buffers + first * BUFFER_CHANNELS, n,
               j->positions + first * j->sight->n_positions * 3,
               j->features + first * j->sight->n_features, j->scale + first * 3);
}

void sight_look_parallel(const struct sight *s, struct pool *pool, const struct scene_state *state,
                         const float *buffers, uint32_t n, float *positions, float *features,
                         float *scale)
{
    struct look_job job = {s, state, buffers, n, positions, features, scale};
    pool_run(pool, (n + LOOK_CHUNK - 1) / LOOK_CHUNK, look_chunk, &job);
}

void sight_targets(const float *color, const float *buffers, uint32_t n, float *targets)
{
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++) {
            float y = color[3 * i + c] - buffers[i * BUFFER_CHANNELS + BUFFER_EMISSION + c];
            targets[3 * i + c] = y > 0.0f && isfinite(y) ? y : 0.0f;
        }
}

void sight_add_emission(const float *buffers, uint32_t n, float *color)
{
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++)
            color[3 * i + c] += finite_or_zero(buffers[i * BUFFER_CHANNELS + BUFFER_EMISSION + c]);
}
