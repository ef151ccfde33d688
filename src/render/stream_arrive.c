/* SPDX-License-Identifier: Apache-2.0 */
#include "render/stream_arrive.h"

#include <string.h>

#include "render/chain.h"
#include "render/light.h"
#include "render/photon.h"

void stream_add_radiance(struct stream *s, uint32_t i, uint32_t emitter, bool is_seen,
                         struct vec3 value)
{
    uint32_t path = s->path[i];
    lanes3_set(&s->radiance, path, vec3_add(lanes3_get(&s->radiance, path), value));
    if (!s->groups || !vec3_is_finite(value)) return;
    uint32_t group = s->group_of[emitter] + (is_seen && s->is_chain[i] ? s->chain_group : 0);
    float *to = s->groups + group * s->group_stride + s->place[path];
    to[0] += value.x;
    to[1] += value.y;
    to[2] += value.z;
}

static struct ray lane_ray(const struct stream *s, uint32_t i)
{
    return (struct ray){lanes3_get(&s->o, i), 0.0f, lanes3_get(&s->d, i), s->t_max[i]};
}

static void find_hit(struct stream *s, const struct view *v, uint32_t i)
{
    if (few_is_used(&v->few))
        few_hit(&v->few, s->face[i], lanes3_get(&s->o, i), lanes3_get(&s->d, i), s->t[i],
                &s->hit[i]);
}

void stream_find_hits(struct stream *s, const struct view *v)
{
    for (uint32_t i = 0; i < s->n; i++)
        if (s->is_alive[i]) find_hit(s, v, i);
}

/* What a scalar function wants to know of a path. */
static struct path lane_path(const struct stream *s, uint32_t i)
{
    return (struct path){.last_p = lanes3_get(&s->last_p, i),
                         .last_pdf = s->last_pdf[i],
                         .last_is_delta = s->last_is_delta[i] != 0,
                         .met = s->met[i]};
}

static void miss(struct stream *s, const struct view *v, const struct trace_settings *t, uint32_t i,
                 bool shows_emitters)
{
    s->is_alive[i] = false;
    if (!shows_emitters || s->met[i] == PATH_CAUSTIC) return;
    const struct path path = lane_path(s, i);
    for (uint32_t k = v->first_environment; k < v->n_lights; k++) {
        const struct light *l = &v->lights[k];
        struct vec3 around = path_environment(v, t, &path, l, lanes3_get(&s->d, i));
        stream_add_radiance(s, i, l->emitter, true,
                            vec3_mul(lanes3_get(&s->throughput, i), around));
    }
}

/* Reads what the ray has hit; the kernel makes a surface of it. */
static void fetch(struct stream *s, const struct view *v, uint32_t i)
{
    struct surface surface;
    struct ray ray = lane_ray(s, i);
    surface_fetch(&surface, v, &ray, &s->hit[i]);
    s->shape[i] = surface.shape;
    lanes3_set(&s->p, i, surface.p);
    lanes3_set(&s->normal, i, surface.n);
    lanes3_set(&s->frame_n, i, surface.frame.n);
    const struct material *m = &v->materials[v->state.shape_bsdfs[surface.shape->index]];
    s->bsdf_is_twosided[i] = m->is_plain && m->is_twosided;
    s->texture_u[i] = surface.u;
    s->texture_v[i] = surface.v;
    s->bsdf_is_smooth[i] = true;
    lanes3_set(&s->reflectance, i, m->reflectance);
    /* Tangents wait in lanes that are used later. */
    if (m->has_direction) lanes3_set(&s->wo, i, surface.frame.s);
    if (m->has_tangents) {
        lanes3_set(&s->wo, i, surface.dp_du);
        lanes3_set(&s->weight, i, surface.dp_dv);
    }
}

/* The same where it is simple. */
static void fetch_simple(struct stream *s, uint32_t i, const struct view_shape *a)
{
    const struct hit *hit = &s->hit[i];
    const uint32_t *at = a->indices + 3 * (size_t)hit->primitive;
    struct vec3 shading = hit->ng;
    struct vec2 uv = {hit->u, hit->v};
    if (a->normals) shading = surface_interpolate(a->normals, at, hit->u, hit->v);
    if (a->uvs) uv = surface_uv(a->uvs, at, hit->u, hit->v);
    s->shape[i] = a->shape;
    lanes3_set(&s->p, i, vec3_madd(lanes3_get(&s->o, i), lanes3_get(&s->d, i), hit->t));
    lanes3_set(&s->normal, i, vec3_scale(hit->ng, a->side));
    lanes3_set(&s->frame_n, i, vec3_scale(shading, a->side));
    lanes3_set(&s->reflectance, i, a->reflectance);
    s->bsdf_is_twosided[i] = a->is_twosided;
    s->bsdf_is_smooth[i] = true;
    s->texture_u[i] = uv.x;
    s->texture_v[i] = uv.y;
}

static void turn_frame(struct stream *s, uint32_t i)
{
    struct frame f = surface_frame_along(lanes3_get(&s->frame_n, i), lanes3_get(&s->wo, i));
    lanes3_set(&s->frame_s, i, f.s);
    lanes3_set(&s->frame_t, i, f.t);
    lanes3_set(&s->frame_n, i, f.n);
    lanes3_set(&s->wi, i, frame_to_local(&f, vec3_neg(lanes3_get(&s->d, i))));
}

static void emit(struct stream *s, const struct view *v, const struct trace_settings *t, uint32_t i)
{
    const struct path path = lane_path(s, i);
    const struct surface surface = {.p = lanes3_get(&s->p, i),
                                    .n = lanes3_get(&s->normal, i),
                                    .frame.n = lanes3_get(&s->frame_n, i),
                                    .u = s->texture_u[i],
                                    .v = s->texture_v[i],
                                    .shape = s->shape[i],
                                    .instance = s->hit[i].instance};
    struct vec3 emission = path_emission(v, t, &path, &surface, lanes3_get(&s->d, i));
    stream_add_radiance(s, i, s->shape[i]->emitter, true,
                        vec3_mul(lanes3_get(&s->throughput, i), emission));
}

static void look_up_point(struct stream *s, const struct view *v, uint32_t i, uint32_t bsdf)
{
    const struct material *m = &v->materials[bsdf];
    struct surface surface = {
        .u = s->texture_u[i], .v = s->texture_v[i], .wi = lanes3_get(&s->wi, i)};
    if (m->has_attributes) {
        surface.shape = s->shape[i];
        surface.primitive = s->hit[i].primitive;
        surface.b1 = s->hit[i].u;
        surface.b2 = s->hit[i].v;
    }
    if (m->has_tangents) {
        surface.n = lanes3_get(&s->normal, i);
        surface.frame = (struct frame){lanes3_get(&s->frame_s, i), lanes3_get(&s->frame_t, i),
                                       lanes3_get(&s->frame_n, i)};
        surface.dp_du = lanes3_get(&s->wo, i);
        surface.dp_dv = lanes3_get(&s->weight, i);
    }
    const struct bsdf_place at = surface_place(&surface, m);
    bsdf_point_init(&s->own_bsdf[i], v->materials, bsdf, &v->textures, &at);
    s->bsdf[i] = &s->own_bsdf[i];
}

/* Whether vector code knows the material. */
static bool has_kernel(const struct bsdf_point *b)
{
    bool is_known = b->kind == BSDF_ROUGH_CONDUCTOR || b->kind == BSDF_ROUGH_PLASTIC ||
                    b->kind == BSDF_ROUGH_DIELECTRIC;
    return is_known && b->opacity == 1.0f && !b->is_turned;
}

/* Whether the material without its colour, which lanes hold, says enough. Photons that land ask for
 * all of it. */
static bool is_tinted(const struct material *m, bool has_photons)
{
    return m->tinted && (!has_photons || photon_is_caster(&m->tinted[0]));
}

/* The material of a lane that is not plain. */
static void look_up_material(struct stream *s, const struct view *v, uint32_t i, uint32_t bsdf,
                             bool has_photons)
{
    const struct material *m = &v->materials[bsdf];
    if (m->ready)
        s->bsdf[i] = &m->ready[s->wi.z[i] < 0.0f];
    else if (is_tinted(m, has_photons))
        s->bsdf[i] = &m->tinted[s->wi.z[i] < 0.0f];
    else
        look_up_point(s, v, i, bsdf);
    const struct bsdf_point *b = s->bsdf[i];
    s->bsdf_is_smooth[i] = (b->lobes & LOBE_SMOOTH) != 0;
    if (bsdf_is_diffuse(b)) {
        s->bsdf_side[i] = b->is_mirrored ? -1.0f : 1.0f;
        lanes3_set(&s->reflectance, i, b->reflectance);
    } else if (has_kernel(b)) {
        bool is_plastic = b->kind == BSDF_ROUGH_PLASTIC;
        enum facet_list list = is_plastic                         ? FACET_PLASTIC_GGX
                               : b->kind == BSDF_ROUGH_DIELECTRIC ? FACET_DIELECTRIC_GGX
                                                                  : FACET_CONDUCTOR_GGX;
        if (b->facets.kind != MICROFACET_GGX) list++; /* Beckmann follows */
        s->facets[list][s->n_facets[list]++] = i;
        if (!m->tinted)
            lanes3_set(&s->reflectance, i, is_plastic ? b->reflectance : b->specular_reflectance);
    } else {
        s->scalar[s->n_scalar++] = i;
    }
    if (has_photons) s->receiver[i] = photon_receiver_kind(b);
}

/* The photons of the sample that a lane belongs to; NULL: none. */
static const struct photon_map *lane_photons(const struct stream *s, const struct trace_settings *t,
                                             uint32_t i)
{
    return t->photons[s->sample[s->path[i]] & 1];
}

/* Adds caustics, where the surface receives them. */
static void gather(struct stream *s, const struct trace_settings *t, uint32_t i, int32_t depth)
{
    const bool is_diffuse = s->receiver[i] == RECEIVER_DIFFUSE;
    const uint32_t path = s->path[i];
    if (s->receiver[i] == RECEIVER_NONE) return;
    const struct photon_receiver at = {.p = lanes3_get(&s->p, i),
                                       .n = lanes3_get(&s->normal, i),
                                       .frame = {lanes3_get(&s->frame_s, i),
                                                 lanes3_get(&s->frame_t, i),
                                                 lanes3_get(&s->frame_n, i)},
                                       .wi = lanes3_get(&s->wi, i),
                                       .bsdf = is_diffuse ? NULL : s->bsdf[i],
                                       .reflectance = lanes3_get(&s->reflectance, i),
                                       .side = s->bsdf_side[i]};
    const struct photon_split split = {.to = s->groups ? s->groups + s->place[path] : NULL,
                                       .stride = s->group_stride,
                                       .group_of = s->group_of,
                                       .throughput = lanes3_get(&s->throughput, i)};
    struct vec3 caustic = photon_map_gather(lane_photons(s, t, i), &at, t->max_depth - depth - 2,
                                            s->groups ? &split : NULL);
    caustic = vec3_mul(split.throughput, caustic);
    lanes3_set(&s->radiance, path, vec3_add(lanes3_get(&s->radiance, path), caustic));
}

void stream_gather(struct stream *s, const struct trace_settings *t, int32_t depth)
{
    for (uint32_t i = 0; i < s->n; i++)
        if (s->is_alive[i]) gather(s, t, i, depth);
}

/* Memory is asked for what a lane will read while lanes before it are worked on: the numbers of its
 * triangle's corners, then the corners, then the texels. */
enum { STEP_AHEAD = 12 };

struct arrivals {
    uint32_t n, lane[STREAM_SIZE]; /* that have hit something */
    const struct view_shape *shape[STREAM_SIZE];
    uint32_t n_textured, textured[STREAM_SIZE]; /* colours to look up */
    struct texture_spot spot[STREAM_SIZE];      /* of those that look into a picture */
    uint32_t n_special, special[STREAM_SIZE];   /* something shines, or the material is not plain */
};

static void prefetch_indices(struct arrivals *a, const struct stream *s, const struct view *v,
                             uint32_t k)
{
    const struct hit *hit = &s->hit[a->lane[k]];
    a->shape[k] = &v->instances[hit->instance].views[hit->shape];
    if (a->shape[k]->normals || a->shape[k]->uvs)
        __builtin_prefetch(a->shape[k]->indices + 3 * (size_t)hit->primitive);
}

static void prefetch_corners(const struct arrivals *a, const struct stream *s, uint32_t k)
{
    const struct view_shape *shape = a->shape[k];
    if (!shape->normals && !shape->uvs) return;
    const uint32_t *at = shape->indices + 3 * (size_t)s->hit[a->lane[k]].primitive;
    for (int c = 0; c < 3; c++) {
        if (shape->normals) __builtin_prefetch(shape->normals + 3 * (size_t)at[c]);
        if (shape->uvs) __builtin_prefetch(shape->uvs + 2 * (size_t)at[c]);
    }
}

static void arrive_lane(struct arrivals *a, struct stream *s, const struct view *v, uint32_t k)
{
    const struct view_shape *shape = a->shape[k];
    uint32_t i = a->lane[k];
    if (shape->is_simple && v->instances[s->hit[i].instance].is_identity)
        fetch_simple(s, i, shape);
    else
        fetch(s, v, i);
    if (shape->picture) {
        struct texture_spot *spot = &a->spot[a->n_textured];
        texture_locate(spot, &v->textures, shape->picture, s->texture_u[i], s->texture_v[i]);
        texture_prefetch(&v->textures, spot);
    }
    if (shape->is_textured) a->textured[a->n_textured++] = i;
    if (shape->is_special) a->special[a->n_special++] = i;
}

/* Looks up the k-th of the colours. */
static void color_lane(const struct arrivals *a, struct stream *s, const struct view *v, uint32_t k)
{
    uint32_t i = a->textured[k], shape = s->shape[i]->index;
    struct vec3 color;
    if (v->shapes[shape].picture)
        color = texture_read(&v->textures, &a->spot[k]);
    else
        color = texture_eval(&v->textures, v->materials[v->state.shape_bsdfs[shape]].texture,
                             s->texture_u[i], s->texture_v[i]);
    lanes3_set(&s->reflectance, i, color);
}

/* Finds the lanes that something is left to do for, and lets go those that have hit nothing. The
 * number of lanes that are alive. */
static uint32_t find_arrivals(struct arrivals *a, struct stream *s, const struct view *v,
                              const struct trace_settings *t, bool shows_emitters)
{
    const bool is_few = few_is_used(&v->few);
    uint32_t n_alive = 0, n = 0, lanes[STREAM_SIZE];
    const uint32_t *takes_part = s->is_alive;
    if (is_few) {
        bool is_surrounded = v->first_environment < v->n_lights;
        v->world->kernels->few_arrive(s, &v->few, is_surrounded);
        takes_part = s->is_special;
    }
    for (uint32_t i = 0; i < s->n; i++) {
        lanes[n] = i;
        n += takes_part[i];
        n_alive += s->is_alive[i];
    }
    for (uint32_t k = 0; k < n; k++) {
        uint32_t i = lanes[k];
        if (is_few) find_hit(s, v, i);
        if (s->hit[i].shape == SCENE_NONE) {
            miss(s, v, t, i, shows_emitters);
            n_alive--;
        } else {
            a->lane[a->n++] = i;
        }
    }
    return n_alive;
}

bool stream_arrive(struct stream *s, const struct view *v, const struct trace_settings *t,
                   int32_t depth)
{
    bool shows_emitters = depth > 0 || !t->hide_emitters;
    bool is_last = t->max_depth >= 0 && depth + 1 >= t->max_depth;
    bool has_photons = t->photons[0] != NULL;
    struct arrivals a;
    a.n = a.n_textured = a.n_special = 0;
    s->n_scalar = 0;
    memset(s->n_facets, 0, sizeof s->n_facets);
    if (has_photons) memset(s->receiver, RECEIVER_DIFFUSE, sizeof s->receiver);
    if (find_arrivals(&a, s, v, t, shows_emitters) == 0) return false;
    uint32_t n_looked_up = 0;
    for (uint32_t k = 0; k < a.n + 2 * STEP_AHEAD; k++) {
        if (k < a.n) prefetch_indices(&a, s, v, k);
        if (k >= STEP_AHEAD && k - STEP_AHEAD < a.n) prefetch_corners(&a, s, k - STEP_AHEAD);
        if (k >= 2 * STEP_AHEAD) arrive_lane(&a, s, v, k - 2 * STEP_AHEAD);
        if (!is_last && n_looked_up + STEP_AHEAD < a.n_textured)
            color_lane(&a, s, v, n_looked_up++);
    }
    while (!is_last && n_looked_up < a.n_textured) color_lane(&a, s, v, n_looked_up++);
    v->world->kernels->surface(s);
    for (uint32_t k = 0; k < a.n_special; k++) {
        uint32_t i = a.special[k];
        const struct world_shape *shape = s->shape[i];
        uint32_t bsdf = v->state.shape_bsdfs[shape->index];
        const struct material *m = &v->materials[bsdf];
        if (m->has_direction) turn_frame(s, i);
        if (shape->emitter != SCENE_NONE && shows_emitters && s->met[i] != PATH_CAUSTIC)
            emit(s, v, t, i);
        if (is_last) continue;
        if (!m->is_plain) look_up_material(s, v, i, bsdf, has_photons);
    }
    return !is_last;
}
