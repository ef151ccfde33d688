/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/binding.h"

#include <math.h>
#include <string.h>

/* ---- States --------------------------------------------------------------------------------- */

static void *copy_array(const void *from, uint32_t count, size_t size)
{
    void *to = mem_new(count, size);
    if (to && count) memcpy(to, from, count * size);
    return to;
}

lmn_status scene_state_init(const struct scene *s, struct scene_state *state, struct error *err)
{
    const struct scene_state *d = &s->defaults;
    *state = (struct scene_state){
        .textures = copy_array(d->textures, s->n_textures, sizeof *d->textures),
        .bsdfs = copy_array(d->bsdfs, s->n_bsdfs, sizeof *d->bsdfs),
        .emitters = copy_array(d->emitters, s->n_emitters, sizeof *d->emitters),
        .instances = copy_array(d->instances, s->n_instances, sizeof *d->instances),
        .shape_bsdfs = copy_array(d->shape_bsdfs, s->n_shapes, sizeof *d->shape_bsdfs),
        .sensor = d->sensor,
    };
    if (state->textures && state->bsdfs && state->emitters && state->instances &&
        state->shape_bsdfs)
        return LMN_OK;
    scene_state_release(state);
    return fail_memory(err, "the state of a scene");
}

void scene_state_release(struct scene_state *state)
{
    mem_free(state->textures);
    mem_free(state->bsdfs);
    mem_free(state->emitters);
    mem_free(state->instances);
    mem_free(state->shape_bsdfs);
    *state = (struct scene_state){0};
}

static void *place(const struct scene_state *state, enum state_array array, uint32_t index,
                   uint32_t offset)
{
    char *element = NULL;
    switch (array) {
    case STATE_TEXTURES:
        element = (char *)&state->textures[index];
        break;
    case STATE_BSDFS:
        element = (char *)&state->bsdfs[index];
        break;
    case STATE_EMITTERS:
        element = (char *)&state->emitters[index];
        break;
    case STATE_INSTANCES:
        element = (char *)&state->instances[index];
        break;
    case STATE_SHAPE_BSDFS:
        element = (char *)&state->shape_bsdfs[index];
        break;
    case STATE_SENSOR:
        element = (char *)&state->sensor;
        break;
    case STATE_NOWHERE:
        return NULL;
    }
    return element + offset;
}

void *param_in(const struct param *p, struct scene_state *state)
{
    return place(state, p->array, p->index, p->offset);
}

/* ---- Units ---------------------------------------------------------------------------------- */

/* NaN becomes 0. */
static float clamp_unit(float u)
{
    return fminf(fmaxf(u, 0.0f), 1.0f);
}

static uint32_t choice_of(const struct variable *v, float u)
{
    uint32_t k = (uint32_t)(clamp_unit(u) * (float)v->n_choices);
    return k < v->n_choices ? k : v->n_choices - 1;
}

/* A choice is placed in the middle of its interval, so that rounding cannot change it. */
float variable_to_unit(const struct variable *v, double value)
{
    if (v->n_choices) return clamp_unit((float)((value + 0.5) / v->n_choices));
    return clamp_unit((float)((value - v->min) / (v->max - v->min)));
}

double variable_from_unit(const struct variable *v, float u)
{
    if (v->n_choices) return choice_of(v, u);
    return v->min + (double)clamp_unit(u) * (v->max - v->min);
}

/* ---- Applying a configuration ---------------------------------------------------------------- */

static float driven(const struct drive *d, const float *u)
{
    if (d->variable == SCENE_NONE) return d->at_0;
    float x = clamp_unit(u[d->variable]);
    return (1.0f - x) * d->at_0 + x * d->at_1; /* exact at both ends */
}

static struct vec3 driven3(const struct drive d[3], const float *u)
{
    return vec3(driven(&d[0], u), driven(&d[1], u), driven(&d[2], u));
}

/* The linear map `t` around `pivot` instead of the origin. */
static struct transform around(struct vec3 pivot, struct transform t)
{
    struct transform there = transform_translate(pivot);
    struct transform back = transform_translate(vec3_neg(pivot));
    t = transform_mul(&t, &back);
    return transform_mul(&there, &t);
}

static struct transform step_transform(const struct binding_step *step, const float *u)
{
    switch (step->kind) {
    case STEP_TRANSLATE:
        return transform_translate(driven3(step->drive, u));
    case STEP_ROTATE:
        return around(step->pivot, transform_rotate(step->axis, driven(&step->drive[0], u)));
    case STEP_SCALE:
        return around(step->pivot, transform_scale(driven3(step->drive, u)));
    case STEP_FIXED:
        return step->fixed;
    }
    return transform_identity();
}

static struct transform compose(const struct binding *b, const float *u)
{
    struct transform t = step_transform(&b->steps[0], u);
    for (uint32_t i = 1; i < b->n_steps; i++) {
        struct transform factor = step_transform(&b->steps[i], u);
        t = transform_mul(&t, &factor);
    }
    return t;
}

/* Looking along `up`, or from a point at itself, has no answer: take the nearest that has one. */
static struct transform aim(const struct binding_camera *c, const float *u)
{
    struct vec3 origin = driven3(c->origin, u), target = driven3(c->target, u), up = c->up;
    struct vec3 dir = vec3_sub(target, origin);
    float size = fmaxf(1.0f, vec3_length(origin));
    if (!(vec3_length(dir) > 1e-6f * size)) {
        dir = vec3_scale(frame_from_normal(vec3_normalize(up)).s, size);
        target = vec3_add(origin, dir);
    }
    struct vec3 side = vec3_cross(vec3_normalize(up), vec3_normalize(dir));
    if (!(vec3_length(side) > 1e-5f)) up = frame_from_normal(vec3_normalize(dir)).s;
    return transform_look_at(origin, target, up);
}

static bool holds(const struct binding *b, const struct scene *s, const float *u)
{
    for (uint32_t i = 0; i < b->n_conditions; i++) {
        const struct binding_condition *c = &b->conditions[i];
        if (choice_of(&s->variables[c->variable], u[c->variable]) != c->choice) return false;
    }
    return true;
}

void scene_apply(const struct scene *s, const float *u, struct scene_state *state)
{
    for (uint32_t i = 0; i < s->n_bindings; i++) {
        const struct binding *b = &s->bindings[i];
        void *to = place(state, b->array, b->index, b->offset);
        float x;
        struct vec3 rgb;
        struct transform t;
        bool shown;
        switch (b->kind) {
        case BINDING_NUMBER:
            x = driven(&b->drive[0], u);
            memcpy(to, &x, sizeof x);
            break;
        case BINDING_SPLAT:
            rgb = vec3_splat(driven(&b->drive[0], u));
            memcpy(to, &rgb, sizeof rgb);
            break;
        case BINDING_RGB:
            rgb = driven3(b->drive, u);
            memcpy(to, &rgb, sizeof rgb);
            break;
        case BINDING_TRANSFORM:
            t = compose(b, u);
            memcpy(to, &t, sizeof t);
            break;
        case BINDING_CAMERA:
            t = aim(b->camera, u);
            memcpy(to, &t, sizeof t);
            break;
        case BINDING_CHOICE:
            memcpy(to, &b->options[choice_of(&s->variables[b->variable], u[b->variable])],
                   sizeof *b->options);
            break;
        case BINDING_VISIBLE:
            shown = holds(b, s, u);
            memcpy(to, &shown, sizeof shown);
            break;
        }
    }
}

static bool any_follows(const struct drive *drives, int n, uint32_t variable)
{
    for (int i = 0; i < n; i++)
        if (drives[i].variable == variable) return true;
    return false;
}

bool binding_follows(const struct binding *b, uint32_t variable)
{
    switch (b->kind) {
    case BINDING_NUMBER:
    case BINDING_SPLAT:
        return any_follows(b->drive, 1, variable);
    case BINDING_RGB:
        return any_follows(b->drive, 3, variable);
    case BINDING_TRANSFORM:
        for (uint32_t i = 0; i < b->n_steps; i++)
            if (any_follows(b->steps[i].drive, 3, variable)) return true;
        return false;
    case BINDING_CAMERA:
        return any_follows(b->camera->origin, 3, variable) ||
               any_follows(b->camera->target, 3, variable);
    case BINDING_CHOICE:
        return b->variable == variable;
    case BINDING_VISIBLE:
        for (uint32_t i = 0; i < b->n_conditions; i++)
            if (b->conditions[i].variable == variable) return true;
        return false;
    }
    return false;
}
