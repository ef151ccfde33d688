/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Whether photons are worth their time in a configuration. First what it holds: without a hard
 * caster (smooth or nearly so, and turning light) and a hard light (small or from one direction),
 * path tracing does well. Where it holds both, a pilot tells: a few photons and a small picture
 * with them. Photons are used when enough of them land, and when caustics would bring paths more
 * noise than all other light does, over the pixels of the picture.
 */
#include <math.h>

#include "base/mem.h"
#include "render/camera.h"
#include "render/light.h"
#include "render/photon.h"
#include "render/photon_targets.h"
#include "render/surface.h"
#include "scene/bounds.h"

/* A hard caster's largest alpha; the largest part of the sphere of directions that a hard light
 * fills, seen from the middle of the casters. */
#define HARD_ALPHA 0.2f
#define HARD_LIGHT 0.05f

/* One photon of PILOT_LANDED must land. */
enum {
    PILOT_SIDE = 32,
    PILOT_SPP = 16,
    PILOT_RAYS = 2,
    PILOT_PHOTONS = 1 << 14,
    PILOT_LANDED = 25
};

/* What one pixel counts for at most: a few bright dots must not decide. */
#define PILOT_MOST 20.0

/* The part of the picture's light that no path can find, from which on photons are used. */
#define PILOT_LOST 0.005

/* The noise of caustics in that of all else, from which on photons are used. */
#define PILOT_GAIN 1.0

static bool is_hard_caster(const struct view *v, uint32_t index)
{
    const struct bsdf_place at = {.u = 0.5f, .v = 0.5f, .wi = {0, 0, 1}, .n = {0, 0, 1}};
    struct bsdf_point p;
    if (v->materials[index].lobes & LOBE_DIFFUSE || v->materials[index].has_attributes)
        return false;
    bsdf_point_init(&p, v->materials, index, &v->textures, &at);
    if (!photon_is_caster(&p) || p.kind == BSDF_THIN_DIELECTRIC) return false;
    bool is_glass = p.kind == BSDF_DIELECTRIC || p.kind == BSDF_ROUGH_DIELECTRIC;
    if (is_glass && fabsf(p.eta - 1.0f) < 0.02f) return false;
    return !(p.lobes & LOBE_GLOSSY) || bsdf_roughness(&p) <= HARD_ALPHA;
}

static bool has_hard_caster(const struct view *v)
{
    const struct scene *s = v->world->scene;
    for (uint32_t i = 0; i < s->n_instances; i++) {
        const struct group *g = &s->groups[v->state.instances[i].group];
        if (!v->state.instances[i].is_visible) continue;
        for (uint32_t k = 0; k < g->n_shapes; k++)
            if (is_hard_caster(v, v->state.shape_bsdfs[g->first_shape + k])) return true;
    }
    return false;
}

/* The part of all directions that a light fills at p, roughly. */
static float extent_of(const struct view *v, const struct light *l, struct vec3 p)
{
    if (l->kind == EMITTER_AREA) {
        struct light_point at;
        light_point_sample(v, l, 0.5f, 0.5f, &at);
        struct vec3 d = vec3_sub(at.p, p);
        return 0.25f * MATH_INV_PI / (at.pdf * max_float(vec3_dot(d, d), 1e-12f));
    }
    if (l->kind == EMITTER_SUN) return 0.5f * l->sky->sun_height;
    return emitter_is_environment(l->kind) && l->kind != EMITTER_ENVMAP ? 1.0f : 0.0f;
}

static float scene_radius(const struct view *v)
{
    const struct bounds b = scene_bounds(v->world->scene, &v->state);
    return 0.5f * vec3_length(vec3_sub(b.max, b.min));
}

static bool has_hard_light(const struct view *v)
{
    struct photon_targets t;
    photon_targets_init(&t, v);
    for (uint32_t i = 0; i < v->n_lights; i++)
        for (uint32_t k = 0; k < t.n; k++)
            if (extent_of(v, &v->lights[i], t.center[k]) <= HARD_LIGHT) return true;
    return false;
}

/* ---- Pilot ----------------------------------------------------------------------------------- */

/*
 * A path finds caustic light c of a point by chance: it scatters towards a caster and from there
 * happens to hit the light, whose radiance L it then carries; else it carries nothing. So the
 * variance is c times the reflectance times L, whatever the optics: photons that land near tell it,
 * when they are weighed by that L.
 */
static float gather_at(const struct view *v, const struct photon_map *m,
                       const struct trace_settings *t, const struct ray *ray)
{
    struct hit hit;
    struct surface s;
    struct bsdf_point b;
    accel_intersect(v->top, ray, &hit);
    if (hit.shape == SCENE_NONE) return 0.0f;
    surface_init(&s, v, ray, &hit);
    surface_bsdf(&s, v, &b);
    if (photon_is_caster(&b)) return 0.0f;
    const struct photon_receiver r = {.p = s.p, .n = s.n, .frame = s.frame, .wi = s.wi, .bsdf = &b};
    struct vec3 light = photon_map_gather(m, &r, t->max_depth - 2, NULL);
    return vec3_max(vec3_mul(light, bsdf_albedo(&b)));
}

/* The mean over a pixel. */
static double pixel_mean(const struct view *v, const struct photon_map *m,
                         const struct trace_settings *t, const struct camera *camera, int i)
{
    double sum = 0;
    for (int k = 0; k < PILOT_RAYS * PILOT_RAYS; k++) {
        float offset, x = (float)(i % PILOT_SIDE), y = (float)(i / PILOT_SIDE);
        x += ((float)(k % PILOT_RAYS) + 0.5f) / (float)PILOT_RAYS;
        y += ((float)(k / PILOT_RAYS) + 0.5f) / (float)PILOT_RAYS;
        struct ray ray = camera_ray_any(camera, x, y, 0.5f, 0.5f, &offset);
        sum += (double)gather_at(v, m, t, &ray);
    }
    return sum / (PILOT_RAYS * PILOT_RAYS);
}

/* Is there caustic light that no path can find: of lights without extent over smooth casters? Takes
 * the power of all other photons. */
static bool has_lost_light(const struct view *v, struct photon_map *m,
                           const struct trace_settings *t, const struct camera *camera, double mean)
{
    double sum = 0;
    bool is_any = false;
    for (uint32_t i = 0; i < m->n; i++) {
        bool is_lost = !isfinite(m->photons[i].peak);
        is_any = is_any || is_lost;
        if (!is_lost) m->photons[i].power = vec3_splat(0.0f);
    }
    for (int i = 0; is_any && i < PILOT_SIDE * PILOT_SIDE; i++)
        sum += pixel_mean(v, m, t, camera, i);
    return sum > PILOT_LOST * mean * PILOT_SIDE * PILOT_SIDE;
}

/* The means of half-pictures a and b of pixel i, and the variance of a sample. */
static double pixel_square(const float *a, const float *b, int i, double *variance)
{
    double square = 0;
    *variance = 0;
    for (int c = 3 * i; c < 3 * i + 3; c++) {
        double d = (double)a[c] - (double)b[c], sum = (double)a[c] + (double)b[c];
        *variance += d * d * PILOT_SPP / 12;
        square += sum * sum / 12;
    }
    return square;
}

/* Compares the variance of caustics with that of all else in half-pictures a and b. */
static bool judge(const struct view *v, struct photon_map *m, const struct trace_settings *t,
                  const float *a, const float *b)
{
    struct camera camera;
    double mean = 0, caustics = 0, others = 0, variance;
    const int n = PILOT_SIDE * PILOT_SIDE;
    camera_init(&camera, &v->state.sensor, PILOT_SIDE, PILOT_SIDE);
    for (int i = 0; i < 3 * n; i++) mean += 0.5 * ((double)a[i] + (double)b[i]) / (3 * n);
    if (has_lost_light(v, m, t, &camera, mean)) return true;
    photon_map_build(m, m->radius);
    for (uint32_t i = 0; i < m->n; i++) {
        struct photon *p = &m->photons[i];
        p->power = isfinite(p->peak) ? vec3_scale(p->power, p->peak) : vec3_splat(0.0f);
    }
    for (int i = 0; i < n; i++) {
        double square = pixel_square(a, b, i, &variance) + 0.01 * mean * mean;
        others += fmin(variance / square, PILOT_MOST);
        caustics += fmin(pixel_mean(v, m, t, &camera, i) / square, PILOT_MOST);
    }
    return caustics > PILOT_GAIN * others;
}

lmn_status view_wants_photons(const struct view *v, struct pool *pool,
                              const struct trace_settings *t, bool *out, struct error *err)
{
    lmn_status status = LMN_OK;
    const struct window w = {PILOT_SIDE, PILOT_SIDE, 0, 0, PILOT_SIDE, PILOT_SIDE};
    const size_t n = 3 * PILOT_SIDE * PILOT_SIDE;
    struct trace_settings s = *t;
    struct photon_map *m = NULL;
    float *halves = NULL;
    *out = false;
    if (t->max_depth >= 0 && t->max_depth < 3) return LMN_OK;
    if (v->n_lights == 0 || !has_hard_caster(v) || !has_hard_light(v)) return LMN_OK;
    TRY(photon_map_new(PILOT_PHOTONS, &m, err));
    halves = mem_new(2 * n, sizeof *halves);
    if (!halves) {
        status = fail_memory(err, "photons");
        goto done;
    }
    struct trace_output output = {.half_a = halves, .half_b = halves + n};
    s.spp = PILOT_SPP;
    s.seed = 0;
    s.splats = false;
    photon_map_trace(m, v, pool, &s, 0);
    float radius = photon_map_typical_radius(m, scene_radius(v));
    if (m->n < PILOT_PHOTONS / PILOT_LANDED || !(radius > 0.0f)) goto done;
    photon_map_build(m, radius);
    s.photons[0] = s.photons[1] = m;
    TRY(view_trace_parallel(v, pool, &s, &w, &output, NULL, NULL, err));
    *out = judge(v, m, t, halves, halves + n);
done:
    photon_map_free(m);
    mem_free(halves);
    return status;
}
