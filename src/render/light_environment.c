/* SPDX-License-Identifier: Apache-2.0 */
/* Lights all around the scene, and the sun, which is a small part of that. */
#include "render/light_around.h"

#include "base/mem.h"
#include "render/sky_model.h"

/* ---- Sky and sun ----------------------------------------------------------------------------- */

static const double degrees = 3.14159265358979323846 / 180.0;

/* The table of a sky covers the upper half, with the sun above its first column's left edge: it
 * only depends on turbidity and the sun's elevation. */
enum { SKY_WIDTH = 256, SKY_HEIGHT = 65 };

bool sky_init(struct sky *s)
{
    *s = (struct sky){.turbidity = -1.0f};
    s->weights = mem_new((size_t)SKY_WIDTH * (SKY_HEIGHT - 1), sizeof *s->weights);
    if (s->weights && envmap_alloc(&s->map, SKY_WIDTH, SKY_HEIGHT, 0.5f * MATH_PI)) return true;
    sky_release(s);
    return false;
}

void sky_release(struct sky *s)
{
    envmap_release(&s->map);
    mem_free(s->weights);
    *s = (struct sky){0};
}

static void fill(struct sky *s)
{
    struct sky_model model;
    double elevation = (double)s->elevation * degrees, high = fmax(elevation, 0.0);
    sky_model_init(&model, (double)s->turbidity, elevation);
    float sin_sun = (float)sin(high), cos_sun = (float)cos(high);
    for (int y = 0; y < SKY_HEIGHT; y++) {
        float theta = 0.5f * MATH_PI * (float)y / (float)(SKY_HEIGHT - 1);
        float sine = sinf(theta), cosine = cosf(theta);
        float *row = s->map.rgb + 3 * (size_t)SKY_WIDTH * (size_t)y;
        for (int x = 0; x < SKY_WIDTH / 2; x++) { /* both sides of the sun are alike */
            float phi = 2.0f * MATH_PI * ((float)x + 0.5f) / (float)SKY_WIDTH;
            float cos_gamma = cosine * sin_sun + sine * cos_sun * cosf(phi);
            struct vec3 c = sky_model_radiance(&model, cosine, cos_gamma);
            float *left = row + 3 * x, *right = row + 3 * (SKY_WIDTH - 1 - x);
            left[0] = right[0] = c.x;
            left[1] = right[1] = c.y;
            left[2] = right[2] = c.z;
        }
    }
    envmap_weigh(&s->map, s->weights);
    s->sun = sky_model_sun((double)s->turbidity, elevation);
}

void sky_refresh(struct sky *s, const struct emitter *e)
{
    double azimuth = (double)e->sun_azimuth * degrees;
    double elevation = (double)e->sun_elevation * degrees;
    s->sin_azimuth = (float)sin(azimuth);
    s->cos_azimuth = (float)cos(azimuth);
    struct vec3 d = vec3((float)(cos(elevation) * cos(azimuth)),
                         (float)(cos(elevation) * sin(azimuth)), (float)sin(elevation));
    s->to_sun = vec3_normalize(transform_vector(&e->to_world, d));
    s->up = vec3_normalize(transform_vector(&e->to_world, vec3(0.0f, 0.0f, 1.0f)));
    double half = sin(0.25 * (double)e->sun_aperture * degrees);
    s->sun_height = (float)(2.0 * half * half);
    if (s->turbidity == e->turbidity && s->elevation == e->sun_elevation) return;
    s->turbidity = e->turbidity;
    s->elevation = e->sun_elevation;
    fill(s);
}

/* Between the emitter's space, where +z is up, and the table's. */
static struct vec3 to_table(const struct sky *s, const struct emitter *e, struct vec3 d)
{
    struct vec3 l = vec3_normalize(transform_vector_inverse(&e->to_world, d));
    float x = s->cos_azimuth * l.x + s->sin_azimuth * l.y;
    return vec3(s->cos_azimuth * l.y - s->sin_azimuth * l.x, l.z, -x);
}

/* Radiance of the sun's disk, which sends the same light whatever its size. */
static struct vec3 sun_radiance(const struct sky *s, const struct emitter *e)
{
    return vec3_scale(s->sun, e->scale * e->sun_scale / (2.0f * MATH_PI * s->sun_height));
}

/* |d - sun|^2 = 2 (1 - cos): exact for small disks, too. */
static bool is_in_sun(const struct sky *s, struct vec3 d)
{
    struct vec3 off = vec3_sub(d, s->to_sun);
    return vec3_dot(off, off) <= 2.0f * s->sun_height;
}

/* ---- All kinds ------------------------------------------------------------------------------- */

/* In the map's space. */
static struct vec3 to_map(const struct emitter *e, struct vec3 d)
{
    return vec3_normalize(transform_vector_inverse(&e->to_world, d));
}

struct vec3 light_environment_radiance(const struct view *v, const struct light *l, struct vec3 d)
{
    const struct emitter *e = &v->state.emitters[l->emitter];
    const struct sky *s = l->sky;
    if (l->kind == EMITTER_CONSTANT)
        return vec3_scale(texture_eval(&v->textures, e->radiance, 0.0f, 0.0f), e->scale);
    if (l->kind == EMITTER_SKY)
        return vec3_scale(envmap_eval(&s->map, to_table(s, e, d)), e->scale * e->sky_scale);
    if (l->kind == EMITTER_SUN) {
        bool is_seen = is_in_sun(s, d) && vec3_dot(d, s->up) >= 0.0f;
        return is_seen ? sun_radiance(s, e) : vec3_splat(0.0f);
    }
    return vec3_scale(envmap_eval(&v->world->envmaps[e->bitmap], to_map(e, d)), e->scale);
}

float light_environment_power(const struct view *v, const struct light *l)
{
    const struct emitter *e = &v->state.emitters[l->emitter];
    const struct sky *s = l->sky;
    if (l->kind == EMITTER_CONSTANT)
        return MATH_PI * texture_mean(&v->textures, e->radiance) * e->scale;
    if (l->kind == EMITTER_SKY) return MATH_PI * s->map.mean * e->scale * e->sky_scale;
    if (l->kind == EMITTER_SUN) return vec3_luminance(s->sun) * e->scale * e->sun_scale;
    return MATH_PI * v->world->envmaps[e->bitmap].mean * e->scale;
}

static float density(const struct view *v, const struct light *l, struct vec3 d)
{
    const struct emitter *e = &v->state.emitters[l->emitter];
    const struct sky *s = l->sky;
    if (l->kind == EMITTER_CONSTANT) return WARP_SPHERE_PDF;
    if (l->kind == EMITTER_SKY) return envmap_pdf(&s->map, to_table(s, e, d));
    if (l->kind == EMITTER_SUN) return is_in_sun(s, d) ? 0.5f * MATH_INV_PI / s->sun_height : 0.0f;
    return envmap_pdf(&v->world->envmaps[e->bitmap], to_map(e, d));
}

float light_environment_pdf(const struct view *v, const struct light *l, struct vec3 reference,
                            struct vec3 d)
{
    return density(v, l, d) * light_probability(v, reference, (uint32_t)(l - v->lights));
}

void light_around_init(struct light_around *a, const struct view *v, const struct light *l)
{
    const struct emitter *e = &v->state.emitters[l->emitter];
    const struct transform *m = &e->to_world;
    const struct sky *s = l->sky;
    *a = (struct light_around){.kind = l->kind, .scale = e->scale};
    switch (l->kind) {
    case EMITTER_CONSTANT:
        a->radiance = vec3_scale(texture_eval(&v->textures, e->radiance, 0.0f, 0.0f), e->scale);
        break;
    case EMITTER_SUN: {
        const struct frame f = frame_from_normal(s->to_sun);
        a->x = f.s;
        a->y = f.t;
        a->z = f.n;
        a->radiance = sun_radiance(s, e);
        a->sun_height = s->sun_height;
        a->up = s->up;
        break;
    }
    case EMITTER_SKY:
        a->map = &s->map;
        a->scale *= e->sky_scale;
        a->x = transform_vector(m, vec3(-s->sin_azimuth, s->cos_azimuth, 0.0f));
        a->y = transform_vector(m, vec3(0.0f, 0.0f, 1.0f));
        a->z = transform_vector(m, vec3(-s->cos_azimuth, -s->sin_azimuth, 0.0f));
        break;
    default:
        a->map = &v->world->envmaps[e->bitmap];
        a->x = transform_vector(m, vec3(1.0f, 0.0f, 0.0f));
        a->y = transform_vector(m, vec3(0.0f, 1.0f, 0.0f));
        a->z = transform_vector(m, vec3(0.0f, 0.0f, 1.0f));
    }
}

bool light_environment_sample(const struct view *v, const struct light *l, float u1, float u2,
                              struct light_sample *s)
{
    struct light_around a;
    light_around_init(&a, v, l);
    s->is_infinite = true;
    if (l->kind == EMITTER_CONSTANT) {
        light_around_constant(&a, u1, u2, s);
    } else if (l->kind == EMITTER_SUN) {
        light_around_sun(&a, u1, u2, s);
    } else {
        uint32_t column, row;
        float density;
        struct vec3 nodes[4];
        distribution2d_choose(&a.map->cells, &u1, &u2, &column, &row, &density);
        envmap_nodes(a.map, column, row, nodes);
        light_around_map(&a, (int32_t)column, (int32_t)row, u1, u2, density, nodes, s);
    }
    return true;
}
