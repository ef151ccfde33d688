/* SPDX-License-Identifier: Apache-2.0 */
#include "train/sight.h"

#include <math.h>
#include <string.h>

#include "base/cpu.h"
#include "base/mem.h"
#include "scene/binding.h"
#include "scene/bounds.h"
#include "scene/light_groups.h"
#include "train/inputs.h"
#include "train/sight_inside.h"

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

/* Does any surface or light depend on it, in other ways than by a light's power? */
static bool is_learnt(const struct sight *s, uint32_t variable)
{
    if (powers_has(&s->powers, variable)) return false;
    for (uint32_t i = 0; i < s->scene->n_bindings; i++) {
        const struct binding *b = &s->scene->bindings[i];
        if (b->array != STATE_SENSOR && binding_follows(b, variable)) return true;
    }
    return false;
}

lmn_status sight_init(struct sight *s, const struct scene *scene, uint32_t without,
                      struct error *err)
{
    lmn_status status = LMN_OK;
    *s = (struct sight){.scene = scene,
                        .max_depth = scene->settings.max_depth,
                        .ignores_albedo = (without & LMN_WITHOUT_ALBEDO) != 0};
    s->follows_delta = !(without & LMN_WITHOUT_CHAINS) && view_has_chains(scene);
    TRY(powers_init(&s->powers, scene, (without & LMN_WITHOUT_POWERS) != 0, err));
    TRY(scene_frames_init(scene, &s->frames, err));
    s->n_frames = s->frames.n < SIGHT_FRAMES ? s->frames.n : SIGHT_FRAMES;
    if (without & LMN_WITHOUT_FRAMES) s->n_frames = 0;
    if (!(without & LMN_WITHOUT_LIGHTS)) find_lights(s);
    s->n_positions = 1 + s->n_frames;
    s->n_features = SURFACE_FEATURES + s->n_frames * FRAME_FEATURES +
                    s->n_lights * (LIGHT_FEATURES + s->n_frames * PASSAGE_FEATURES) +
                    DEPTH_FEATURES;
    s->variables = mem_new((size_t)scene->n_variables + 1, sizeof *s->variables);
    if (!s->variables) {
        status = fail_memory(err, "the network's inputs");
        goto done;
    }
    for (uint32_t i = 0; i < scene->n_variables; i++)
        if (is_learnt(s, i)) s->variables[s->n_variables++] = i;
done:
    if (status != LMN_OK) sight_release(s);
    return status;
}

void sight_release(struct sight *s)
{
    scene_frames_release(&s->frames);
    powers_release(&s->powers);
    mem_free(s->variables);
    *s = (struct sight){0};
}

struct field_config sight_field(const struct sight *s)
{
    return (struct field_config){.n_grids = s->n_positions,
                                 .n_features = s->n_features,
                                 .n_variables = s->n_variables,
                                 .n_lights = s->powers.n};
}

/* The name of what moves: that of its first shape, or of the emitter. */
static void name_frame(const struct sight *s, uint32_t k, struct str *to)
{
    const struct scene *scene = s->scene;
    struct scene_frame frame;
    scene_frame_at(&s->frames, &scene->defaults, k, &frame);
    if (frame.kind != FRAME_OBJECT) {
        emitter_name(to, scene, frame.index);
        return;
    }
    const struct group *g = &scene->groups[scene->defaults.instances[frame.index].group];
    str_add(to, "%s", g->n_shapes > 0 ? scene->shapes[g->first_shape].name : g->name);
}

static void name_light(const struct sight *s, uint32_t l, struct str *to)
{
    if (s->lights[l].shape != SCENE_NONE)
        str_add(to, "%s", s->scene->shapes[s->lights[l].shape].name);
    else
        emitter_name(to, s->scene, s->lights[l].emitter);
}

lmn_status sight_describe(const struct sight *s, struct meaning *out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct str frames[SIGHT_FRAMES] = {0}, lights[SIGHT_LIGHTS] = {0};
    *out = (struct meaning){.box_min = s->scene->bounds.min, .box_max = s->scene->bounds.max};
    for (uint32_t k = 0; k < s->n_frames; k++) name_frame(s, k, &frames[k]);
    for (uint32_t l = 0; l < s->n_lights; l++) name_light(s, l, &lights[l]);
    for (uint32_t k = 0; k < s->n_frames; k++) out->failed |= frames[k].failed;
    for (uint32_t l = 0; l < s->n_lights; l++) out->failed |= lights[l].failed;
    if (out->failed) {
        status = fail_memory(err, "the network's inputs");
        goto done;
    }
    /* In the order of sight_look(). */
    meaning_add(out, MEANING_GRID, 3, "the scene");
    for (uint32_t k = 0; k < s->n_frames; k++)
        meaning_add(out, MEANING_GRID, 3, "%s", frames[k].text);
    meaning_add(out, MEANING_FEATURES, SURFACE_FEATURES, "the surface");
    for (uint32_t k = 0; k < s->n_frames; k++)
        meaning_add(out, MEANING_FEATURES, FRAME_FEATURES, "%s", frames[k].text);
    for (uint32_t l = 0; l < s->n_lights; l++) {
        meaning_add(out, MEANING_FEATURES, LIGHT_FEATURES, "light from %s", lights[l].text);
        for (uint32_t k = 0; k < s->n_frames; k++)
            meaning_add(out, MEANING_FEATURES, PASSAGE_FEATURES, "light from %s past %s",
                        lights[l].text, frames[k].text);
    }
    meaning_add(out, MEANING_FEATURES, DEPTH_FEATURES, "bounces");
    for (uint32_t i = 0; i < s->n_variables; i++)
        meaning_add(out, MEANING_VARIABLE, 1, "%s", s->scene->variables[s->variables[i]].name);
    for (uint32_t g = 0; g < s->powers.n; g++) {
        struct str name = {0};
        if (s->powers.first[g] == SCENE_NONE)
            str_add(&name, "fixed power");
        else
            emitter_name(&name, s->scene, s->powers.first[g]);
        meaning_add(out, MEANING_LIGHT, 3, "%s", name.failed ? "" : name.text);
        out->failed |= name.failed;
        str_release(&name);
    }
    if (out->failed) status = fail_memory(err, "the network's inputs");
done:
    for (uint32_t k = 0; k < s->n_frames; k++) str_release(&frames[k]);
    for (uint32_t l = 0; l < s->n_lights; l++) str_release(&lights[l]);
    if (status != LMN_OK) meaning_release(out);
    return status;
}

void sight_variables(const struct sight *s, const float *u, float *v)
{
    for (uint32_t i = 0; i < s->n_variables; i++)
        v[i] = inputs_variable(s->scene, s->variables[i], u[s->variables[i]]);
}

/* ---- What pixels show ----------------------------------------------------------------------- */

static void find_moment(const struct sight *s, const struct scene_state *state,
                        struct sight_moment *m)
{
    const struct bounds *box = &s->scene->bounds;
    const struct vec3 size = vec3_sub(box->max, box->min);
    *m = (struct sight_moment){
        .n_frames = s->n_frames,
        .n_lights = s->n_lights,
        .n_features = s->n_features,
        .corner = box->min,
        .size = {max_float(size.x, 1e-20f), max_float(size.y, 1e-20f), max_float(size.z, 1e-20f)},
        .light_scale = 8.0f / max_float(vec3_length(size), 1e-20f)};
    for (uint32_t k = 0; k < s->n_frames; k++) scene_frame_at(&s->frames, state, k, &m->frames[k]);
    for (uint32_t l = 0; l < s->n_lights; l++) {
        uint32_t i = s->lights[l].instance;
        const struct transform *t = i == SCENE_NONE
                                        ? &state->emitters[s->lights[l].emitter].to_world
                                        : &state->instances[i].to_world;
        m->lights[l] = transform_point(t, s->lights[l].center);
        for (uint32_t k = 0; k < s->n_frames; k++)
            m->local_lights[l][k] = transform_point(&m->frames[k].to_local, m->lights[l]);
    }
}

void sight_look(const struct sight *s, const struct scene_state *state, const float *buffers,
                uint32_t n, float *positions, float *features, float *scale)
{
    struct sight_moment moment;
    const struct sight_job job = {&moment, buffers, n, positions, features, scale};
    find_moment(s, state, &moment);
    if (s->cpu & CPU_AVX512)
        sight_look_avx512(&job);
    else if (s->cpu & CPU_AVX2)
        sight_look_avx2(&job);
    else
        sight_look_plain(&job);
    for (size_t i = 0; s->ignores_albedo && i < n; i++)
        for (size_t c = 0; c < 3; c++)
            scale[3 * i + c] = buffers[i * BUFFER_CHANNELS + BUFFER_DEPTH] > 0.0f ? 1.0f : 0.0f;
}

float sight_bounces(const struct sight *s, int32_t max_depth)
{
    return s->max_depth < 0 ? 1.0f : (float)max_depth / (float)s->max_depth;
}

void sight_set_bounces(const struct sight *s, const float *bounces, uint32_t n, float *features)
{
    for (size_t i = 0; i < n; i++) features[(i + 1) * s->n_features - 1] = bounces[i];
}

/* ---- To keep ---- */

static const struct {
    uint8_t from, to, n;
} kept_parts[] = {{BUFFER_POSITION, 0, 3},
                  {BUFFER_NORMAL, 3, 3},
                  {BUFFER_ALBEDO, 6, 3},
                  {BUFFER_WO, 9, 3},
                  {BUFFER_ROUGHNESS, 12, 1}};

enum { KEPT_BOUNCES = 13 }; /* less than 0 on glossy surfaces, 0 where nothing was hit */

void sight_keep(const float *buffers, const float *bounces, uint32_t n, float *kept)
{
    for (uint32_t i = 0; i < n; i++, buffers += BUFFER_CHANNELS, kept += SIGHT_KEPT) {
        for (size_t k = 0; k < sizeof kept_parts / sizeof *kept_parts; k++)
            memcpy(kept + kept_parts[k].to, buffers + kept_parts[k].from,
                   kept_parts[k].n * sizeof *kept);
        const float *geo = buffers + BUFFER_GEO_NORMAL, *wo = buffers + BUFFER_WO;
        if (geo[0] * wo[0] + geo[1] * wo[1] + geo[2] * wo[2] < 0.0f)
            for (uint32_t k = 3; k < 6; k++) kept[k] = -kept[k]; /* the side that is looked at */
        const float *wi = buffers + BUFFER_WI;                   /* zero on diffuse surfaces */
        const bool is_glossy = wi[0] != 0.0f || wi[1] != 0.0f || wi[2] != 0.0f;
        kept[KEPT_BOUNCES] = !(buffers[BUFFER_DEPTH] > 0.0f) ? 0.0f
                             : is_glossy                     ? -bounces[i]
                                                             : bounces[i];
    }
}

void sight_recall(const float *kept, uint32_t n, float *buffers, float *bounces)
{
    for (uint32_t i = 0; i < n; i++, buffers += BUFFER_CHANNELS, kept += SIGHT_KEPT) {
        memset(buffers, 0, BUFFER_CHANNELS * sizeof *buffers);
        for (size_t k = 0; k < sizeof kept_parts / sizeof *kept_parts; k++)
            memcpy(buffers + kept_parts[k].from, kept + kept_parts[k].to,
                   kept_parts[k].n * sizeof *kept);
        memcpy(buffers + BUFFER_GEO_NORMAL, buffers + BUFFER_WO, 3 * sizeof *buffers);
        buffers[BUFFER_DEPTH] = kept[KEPT_BOUNCES] != 0.0f ? 1.0f : 0.0f;
        buffers[BUFFER_WI] = kept[KEPT_BOUNCES] < 0.0f ? 1.0f : 0.0f;
        bounces[i] = fabsf(kept[KEPT_BOUNCES]);
    }
}

/* ---- What learning takes ---- */

static float finite_or_zero(float x)
{
    return isfinite(x) ? x : 0.0f;
}

void sight_targets(const float *color, const float *buffers, uint32_t n, float *targets)
{
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++) {
            float y = color[3 * i + c] - buffers[i * BUFFER_CHANNELS + BUFFER_EMISSION + c];
            targets[3 * i + c] = y > 0.0f && isfinite(y) ? y : 0.0f;
        }
}

void sight_split_targets(const float *groups, const float *buffers, uint32_t n, uint32_t n_lights,
                         float *targets)
{
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++) {
            /* What surfaces emit is known over all groups: it is shared out as what is seen. */
            float seen = 0.0f, emitted = buffers[i * BUFFER_CHANNELS + BUFFER_EMISSION + c];
            for (size_t g = 0; g < n_lights; g++) seen += groups[((n_lights + g) * n + i) * 3 + c];
            const float rest = seen > 0.0f ? max_float(1.0f - emitted / seen, 0.0f) : 0.0f;
            for (size_t g = 0; g < n_lights; g++) {
                float y = groups[(g * n + i) * 3 + c] +
                          rest * groups[((n_lights + g) * n + i) * 3 + c];
                targets[(i * n_lights + g) * 3 + c] = y > 0.0f && isfinite(y) ? y : 0.0f;
            }
        }
}

void sight_add_emission(const float *buffers, uint32_t n, float *color)
{
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++)
            color[3 * i + c] += finite_or_zero(buffers[i * BUFFER_CHANNELS + BUFFER_EMISSION + c]);
}

void sight_add_chain(const float *chain, uint32_t n, float *color)
{
    for (size_t i = 0; i < n; i++, chain += CHAIN_CHANNELS)
        for (size_t c = 0; c < 3; c++) {
            const float through = finite_or_zero(chain[CHAIN_THROUGHPUT + c]);
            color[3 * i + c] = color[3 * i + c] * through +
                               finite_or_zero(chain[CHAIN_EMISSION + c]);
        }
}
