/* SPDX-License-Identifier: Apache-2.0 */
/* Lights that reach a point from one direction only: points, spots, projectors and directional
 * light, all as Mitsuba 3 defines them. */
#include "render/camera.h"
#include "render/light.h"

static const float radians = MATH_PI / 180.0f;

void light_init_delta(struct light *l, const struct view *v)
{
    const struct emitter *e = &v->state.emitters[l->emitter];
    if (e->kind == EMITTER_SPOT) {
        float beam = min_float(e->beam_width, e->cutoff);
        l->cos_cutoff = cosf(e->cutoff * radians);
        l->cos_beam = cosf(beam * radians);
        l->transition = (e->cutoff - beam) * radians;
        l->tan_x = l->tan_y = tanf(e->cutoff * radians);
    } else if (e->kind == EMITTER_PROJECTOR) {
        double aspect = texture_aspect(&v->textures, e->radiance);
        double x = camera_half_width((double)e->fov, e->fov_axis, aspect);
        l->tan_x = (float)x;
        l->tan_y = (float)(x / aspect);
    }
}

/* The distance to a light at a point: s->d, and its square. */
static bool look_at_point(struct light_sample *s, const struct emitter *e, struct vec3 reference,
                          float *distance2)
{
    s->p = transform_point(&e->to_world, vec3_splat(0.0f));
    struct vec3 d = vec3_sub(s->p, reference);
    *distance2 = vec3_dot(d, d);
    if (!(*distance2 > 0.0f)) return false;
    s->d = vec3_scale(d, 1.0f / sqrtf(*distance2));
    return true;
}

/* Full within the beam, then falling with the angle to nothing at the cutoff. */
static float spot_falloff(const struct light *l, const struct emitter *e, float cosine)
{
    if (!(cosine > l->cos_cutoff)) return 0.0f;
    if (cosine >= l->cos_beam || !(l->transition > 0.0f)) return 1.0f;
    float angle = acosf(min_float(cosine, 1.0f));
    return max_float(0.0f, (e->cutoff * radians - angle) / l->transition);
}

static bool sample_spot(const struct view *v, const struct light *l, const struct emitter *e,
                        struct light_sample *s)
{
    struct vec3 d = vec3_normalize(transform_vector_inverse(&e->to_world, vec3_neg(s->d)));
    float falloff = spot_falloff(l, e, d.z);
    if (!(falloff > 0.0f)) return false;
    s->weight = vec3_scale(texture_eval(&v->textures, e->radiance, 0.0f, 0.0f), falloff);
    if (e->picture == SCENE_NONE) return true;
    struct vec3 factor = texture_eval(&v->textures, e->picture,
                                      0.5f + 0.5f * d.x / (d.z * l->tan_x),
                                      0.5f + 0.5f * d.y / (d.z * l->tan_y));
    s->weight = vec3_mul(s->weight, factor);
    return true;
}

/* Intensity falls with the cube of the cosine, so that a picture of one colour lights a wall that
 * faces the projector evenly: pi times the picture at distance 1. */
static bool sample_projector(const struct view *v, const struct light *l, const struct emitter *e,
                             struct vec3 reference, struct light_sample *s)
{
    struct vec3 q = transform_point_inverse(&e->to_world, reference);
    float x = 0.5f - 0.5f * q.x / (q.z * l->tan_x), y = 0.5f - 0.5f * q.y / (q.z * l->tan_y);
    if (!(q.z > 0.0f && x >= 0.0f && x <= 1.0f && y >= 0.0f && y <= 1.0f)) return false;
    struct vec3 axis = vec3_normalize(transform_vector(&e->to_world, vec3(0.0f, 0.0f, 1.0f)));
    float cosine = -vec3_dot(axis, s->d);
    if (!(cosine > 0.0f)) return false;
    s->weight = vec3_scale(texture_eval(&v->textures, e->radiance, x, y),
                           MATH_PI / (q.z * q.z * cosine));
    s->pdf = 1.0f;
    return true;
}

bool light_sample_delta(const struct view *v, const struct light *l, struct vec3 reference,
                        struct light_sample *s)
{
    const struct emitter *e = &v->state.emitters[l->emitter];
    bool is_found = true;
    s->is_delta = true;
    s->pdf = 1.0f;
    if (e->kind == EMITTER_DIRECTIONAL) {
        struct vec3 d = transform_vector(&e->to_world, vec3(0.0f, 0.0f, -1.0f));
        s->d = vec3_normalize(d);
        s->is_infinite = true;
        s->weight = texture_eval(&v->textures, e->radiance, 0.0f, 0.0f);
    } else {
        /* A "density" of distance^2 makes weight / pdf intensity / distance^2. */
        if (!look_at_point(s, e, reference, &s->pdf)) return false;
        if (e->kind == EMITTER_SPOT)
            is_found = sample_spot(v, l, e, s);
        else if (e->kind == EMITTER_PROJECTOR)
            is_found = sample_projector(v, l, e, reference, s);
        else
            s->weight = texture_eval(&v->textures, e->radiance, 0.0f, 0.0f);
    }
    s->weight = vec3_scale(s->weight, e->scale);
    return is_found;
}
