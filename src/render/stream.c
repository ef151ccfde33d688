/* SPDX-License-Identifier: Apache-2.0 */
#include "render/stream.h"

#include <string.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "render/chain.h"
#include "render/light.h"
#include "render/photon.h"

const struct stream_kernels *stream_kernels_for(uint32_t cpu)
{
    if (cpu & CPU_AVX512) return &stream_kernels_avx512;
    return cpu & CPU_AVX2 ? &stream_kernels_avx2 : &stream_kernels_baseline;
}

/* ---- Starting -------------------------------------------------------------------------------- */

void stream_add(struct stream *s, const struct stream_film *f, uint32_t x, uint32_t y,
                uint32_t sample)
{
    uint32_t i = s->n++;
    s->center_x[i] = (float)x + 0.5f;
    s->center_y[i] = (float)y + 0.5f;
    s->sample[i] = sample;
    s->is_alive[i] = true;
    s->path[i] = i;
    s->pixel[i] = (uint64_t)y * f->width + x;
    lanes3_set(&s->throughput, i, vec3_splat(1.0f));
    s->last_pdf[i] = s->eta[i] = 1.0f;
    s->last_is_delta[i] = true;
    s->met[i] = 0;
    s->is_chain[i] = true;
    lanes3_set(&s->radiance, i, vec3_splat(0.0f));
}

/* Cameras that are no pinholes. */
static void look_one_by_one(struct stream *s, const struct stream_film *f)
{
    for (uint32_t i = 0; i < s->n; i++) {
        struct sampler r = {.kind = f->sampler, .seed = s->seed[i], .index = s->index[i]};
        r.rng = (struct rng){s->rng_state[i], s->rng_stream[i]};
        struct ray ray = path_start(&f->camera, s->u[0][i], s->u[1][i], &r, &s->offset[i]);
        if (f->sampler == SAMPLER_INDEPENDENT) s->rng_state[i] = r.rng.state;
        lanes3_set(&s->o, i, ray.o);
        lanes3_set(&s->d, i, ray.d);
        s->t_max[i] = ray.t_max;
    }
}

void stream_start(struct stream *s, const struct view *v, const struct stream_film *f)
{
    v->world->kernels->start(s, f->sampler, f->seed);
    for (uint32_t i = 0; f->margin > 0 && i < s->n; i++) {
        s->u[0][i] += s->center_x[i] - 0.5f;
        s->u[1][i] += s->center_y[i] - 0.5f;
    }
    for (uint32_t i = 0; f->margin == 0 && i < s->n; i++) {
        float x = s->center_x[i], y = s->center_y[i];
        s->u[0][i] = x + filter_sample(&f->filter, s->u[0][i], -x, (float)f->width - x);
        s->u[1][i] = y + filter_sample(&f->filter, s->u[1][i], -y, (float)f->height - y);
    }
    if (f->camera.kind == SENSOR_PERSPECTIVE)
        v->world->kernels->look(s, &f->camera);
    else
        look_one_by_one(s, f);
}

/* Adds light that comes from `emitter`; is_seen: the path itself has met it. */
static void add_radiance(struct stream *s, uint32_t i, uint32_t emitter, bool is_seen,
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

/* ---- Rays ------------------------------------------------------------------------------------ */

static struct ray lane_ray(const struct stream *s, uint32_t i)
{
    return (struct ray){lanes3_get(&s->o, i), 0.0f, lanes3_get(&s->d, i), s->t_max[i]};
}

/* The next lanes from *first on that have their flag set and are samples of one pixel: at most
 * STREAM_PACKET. *first becomes the lane to go on from. */
static uint32_t next_packet(const struct stream *s, const uint32_t *flags, uint32_t *first,
                            uint32_t *lanes)
{
    uint32_t n = 0, i = *first;
    while (i < s->n && !flags[i]) i++;
    for (uint64_t pixel = i < s->n ? s->pixel[i] : 0; i < s->n && n < STREAM_PACKET; i++) {
        if (!flags[i]) continue;
        if (s->pixel[i] != pixel) break;
        lanes[n++] = i;
    }
    *first = i;
    return n;
}

static void cast(struct stream *s, const struct view *v, bool is_first)
{
    if (few_is_used(&v->few)) {
        v->world->kernels->few_cast(s, &v->few);
        return;
    }
    const struct accel_rays rays = {{s->o.x, s->o.y, s->o.z}, {s->d.x, s->d.y, s->d.z}, s->t_max};
    for (uint32_t first = 0; first < s->n;) {
        uint32_t lanes[STREAM_PACKET], n = next_packet(s, s->is_alive, &first, lanes);
        accel_intersect_packet(v->top, &rays, lanes, n, is_first, s->hit);
    }
}

void stream_cast(struct stream *s, const struct view *v, bool is_first)
{
    const uint64_t start = clock_ticks();
    cast(s, v, is_first);
    s->ray_ticks += clock_ticks() - start;
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

static void cast_shadows(struct stream *s, const struct view *v)
{
    const struct lanes3 *o = &s->shadow_o, *d = &s->shadow_d;
    const struct accel_rays rays = {{o->x, o->y, o->z}, {d->x, d->y, d->z}, s->shadow_t_max};
    bool is_occluded[STREAM_SIZE];
    for (uint32_t first = 0; first < s->n;) {
        uint32_t lanes[STREAM_PACKET], n = next_packet(s, s->is_connected, &first, lanes);
        accel_occluded_packet(v->top, &rays, lanes, n, is_occluded);
        for (uint32_t k = 0; k < n; k++) s->is_free[lanes[k]] = !is_occluded[lanes[k]];
    }
}

/* Adds the light samples that nothing hides. */
static void add_lights(struct stream *s, const struct view *v)
{
    const uint64_t start = clock_ticks();
    if (few_is_used(&v->few))
        v->world->kernels->few_shade(s, &v->few, s->is_free);
    else
        cast_shadows(s, v);
    s->ray_ticks += clock_ticks() - start;
    if (!s->groups) {
        v->world->kernels->add_lights(s);
        return;
    }
    for (uint32_t i = 0; i < s->n; i++)
        if (s->is_connected[i] && s->is_free[i])
            add_radiance(s, i, v->lights[s->light_index[i]].emitter, false,
                         lanes3_get(&s->light, i));
}

/* ---- Arriving -------------------------------------------------------------------------------- */

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
        add_radiance(s, i, l->emitter, true, vec3_mul(lanes3_get(&s->throughput, i), around));
    }
}

/* What is left to do where a ray has arrived. */
enum arrival { ARRIVAL_DONE, ARRIVAL_TEXTURED, ARRIVAL_SPECIAL };

/* Reads what the ray has hit; the kernel makes a surface of it. Special is where something shines,
 * or the material is not plain. */
static enum arrival fetch(struct stream *s, const struct view *v, uint32_t i)
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
    if (m->picture != SCENE_NONE)
        texture_prefetch(&v->textures, &v->textures.textures[m->picture], surface.u, surface.v);
    if (m->is_plain) {
        s->bsdf_is_smooth[i] = true;
        bool shines = surface.shape->emitter != SCENE_NONE;
        if (m->texture == SCENE_NONE) {
            lanes3_set(&s->reflectance, i, m->reflectance);
            return shines ? ARRIVAL_SPECIAL : ARRIVAL_DONE;
        }
        return shines ? ARRIVAL_SPECIAL : ARRIVAL_TEXTURED;
    }
    /* Tangents wait in lanes that are used later. */
    if (m->has_direction) lanes3_set(&s->wo, i, surface.frame.s);
    if (m->has_tangents) {
        lanes3_set(&s->wo, i, surface.dp_du);
        lanes3_set(&s->weight, i, surface.dp_dv);
    }
    return ARRIVAL_SPECIAL;
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
    add_radiance(s, i, s->shape[i]->emitter, true,
                 vec3_mul(lanes3_get(&s->throughput, i), emission));
}

/* A plain one that has a texture. */
static void look_up_texture(struct stream *s, const struct view *v, uint32_t i,
                            const struct material *m)
{
    lanes3_set(&s->reflectance, i,
               texture_eval(&v->textures, m->texture, s->texture_u[i], s->texture_v[i]));
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
    bool is_known = b->kind == BSDF_ROUGH_CONDUCTOR || b->kind == BSDF_ROUGH_PLASTIC;
    return is_known && b->opacity == 1.0f && !b->is_turned;
}

/* The material of a lane that is not plain. Photons ask lane by lane which lobe a path took. */
static void look_up_material(struct stream *s, const struct view *v, uint32_t i, uint32_t bsdf,
                             bool has_photons)
{
    const struct material *m = &v->materials[bsdf];
    if (m->ready)
        s->bsdf[i] = &m->ready[s->wi.z[i] < 0.0f];
    else
        look_up_point(s, v, i, bsdf);
    const struct bsdf_point *b = s->bsdf[i];
    s->bsdf_is_smooth[i] = (b->lobes & LOBE_SMOOTH) != 0;
    if (bsdf_is_diffuse(b)) {
        s->bsdf_side[i] = b->is_mirrored ? -1.0f : 1.0f;
        lanes3_set(&s->reflectance, i, b->reflectance);
    } else if (has_kernel(b) && !has_photons) {
        bool is_plastic = b->kind == BSDF_ROUGH_PLASTIC, is_ggx = b->facets.kind == MICROFACET_GGX;
        enum facet_list list = is_plastic
                                   ? (is_ggx ? FACET_PLASTIC_GGX : FACET_PLASTIC_BECKMANN)
                                   : (is_ggx ? FACET_CONDUCTOR_GGX : FACET_CONDUCTOR_BECKMANN);
        s->facets[list][s->n_facets[list]++] = i;
    } else {
        s->scalar[s->n_scalar++] = i;
    }
}

/* The photons of the sample that a lane belongs to; NULL: none. */
static const struct photon_map *lane_photons(const struct stream *s, const struct trace_settings *t,
                                             uint32_t i)
{
    return t->photons[s->sample[s->path[i]] & 1];
}

/* Adds caustics, where the surface receives them. */
static void gather(struct stream *s, const struct view *v, const struct trace_settings *t,
                   uint32_t i, int32_t depth)
{
    const struct bsdf_point *b = s->bsdf[i];
    const bool is_plain = v->materials[v->state.shape_bsdfs[s->shape[i]->index]].is_plain;
    const bool is_diffuse = is_plain || bsdf_is_diffuse(b);
    uint32_t path = s->path[i];
    s->is_caster[i] = !is_diffuse && photon_is_caster(b);
    if (s->is_caster[i]) return;
    if (is_diffuse) s->met[i] = PATH_RECEIVER; /* where the path has been is told already */
    const struct photon_receiver at = {.p = lanes3_get(&s->p, i),
                                       .n = lanes3_get(&s->normal, i),
                                       .frame = {lanes3_get(&s->frame_s, i),
                                                 lanes3_get(&s->frame_t, i),
                                                 lanes3_get(&s->frame_n, i)},
                                       .wi = lanes3_get(&s->wi, i),
                                       .bsdf = is_diffuse ? NULL : b,
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

/* Asks memory for what fetch() will read of meshes: vertices are known once their numbers are. */
static void prefetch(const struct stream *s, const struct view *v)
{
    const uint32_t *corners[STREAM_SIZE];
    const struct world_shape *shapes[STREAM_SIZE];
    uint32_t n = 0;
    for (uint32_t i = 0; i < s->n; i++) {
        const struct hit *hit = &s->hit[i];
        if (!s->is_alive[i] || hit->shape == SCENE_NONE) continue;
        const struct world_shape *shape = &v->instances[hit->instance].shapes[hit->shape];
        if (shape->kind != SHAPE_MESH || (!shape->normals && !shape->uvs)) continue;
        shapes[n] = shape;
        corners[n] = shape->indices + 3 * (size_t)hit->primitive;
        __builtin_prefetch(corners[n++]);
    }
    for (uint32_t k = 0; k < n; k++) {
        for (int c = 0; c < 3; c++) {
            size_t vertex = corners[k][c];
            if (shapes[k]->normals) __builtin_prefetch(shapes[k]->normals + 3 * vertex);
            if (shapes[k]->uvs) __builtin_prefetch(shapes[k]->uvs + 2 * vertex);
        }
    }
}

/* Adds what shines at the ends of the rays and works out the points there. False when no path goes
 * on. */
static bool arrive(struct stream *s, const struct view *v, const struct trace_settings *t,
                   int32_t depth)
{
    bool shows_emitters = depth > 0 || !t->hide_emitters;
    bool is_last = t->max_depth >= 0 && depth + 1 >= t->max_depth;
    bool has_photons = t->photons[0] != NULL;
    uint32_t n_alive = 0, n_lanes = 0, lanes[STREAM_SIZE], n_special = 0, special[STREAM_SIZE];
    uint32_t n_textured = 0, textured[STREAM_SIZE];
    const bool is_few = few_is_used(&v->few);
    const uint32_t *takes_part = s->is_alive;
    s->n_scalar = 0;
    memset(s->n_facets, 0, sizeof s->n_facets);
    if (is_few) {
        bool is_surrounded = v->first_environment < v->n_lights;
        v->world->kernels->few_arrive(s, &v->few, is_surrounded);
        if (!has_photons) takes_part = s->is_special;
    } else {
        prefetch(s, v);
    }
    for (uint32_t i = 0; i < s->n; i++) {
        lanes[n_lanes] = i;
        n_lanes += takes_part[i];
        n_alive += s->is_alive[i];
    }
    for (uint32_t k = 0; k < n_lanes; k++) {
        uint32_t i = lanes[k];
        if (is_few ? s->face[i] < 0 : s->hit[i].shape == SCENE_NONE) {
            n_alive--;
            miss(s, v, t, i, shows_emitters);
            continue;
        }
        find_hit(s, v, i);
        enum arrival arrival = fetch(s, v, i);
        if (arrival == ARRIVAL_SPECIAL || (has_photons && arrival == ARRIVAL_DONE))
            special[n_special++] = i;
        else if (arrival == ARRIVAL_TEXTURED)
            textured[n_textured++] = i;
    }
    if (n_alive == 0) return false;
    v->world->kernels->surface(s);
    for (uint32_t k = 0; !is_last && k < n_textured; k++) {
        uint32_t i = textured[k];
        look_up_texture(s, v, i, &v->materials[v->state.shape_bsdfs[s->shape[i]->index]]);
        if (has_photons) gather(s, v, t, i, depth);
    }
    for (uint32_t k = 0; k < n_special; k++) {
        uint32_t i = special[k];
        const struct world_shape *shape = s->shape[i];
        uint32_t bsdf = v->state.shape_bsdfs[shape->index];
        if (v->materials[bsdf].has_direction) turn_frame(s, i);
        if (shape->emitter != SCENE_NONE && shows_emitters && s->met[i] != PATH_CAUSTIC)
            emit(s, v, t, i);
        const struct material *m = &v->materials[bsdf];
        if (!is_last && !m->is_plain) look_up_material(s, v, i, bsdf, has_photons);
        if (!is_last && m->is_plain && m->texture != SCENE_NONE) look_up_texture(s, v, i, m);
        if (!is_last && has_photons) gather(s, v, t, i, depth);
    }
    return !is_last;
}

/* ---- Connecting to lights -------------------------------------------------------------------- */

static void sample_light(struct stream *s, const struct view *v, uint32_t i)
{
    struct light_sample l;
    s->has_light[i] = light_sample(v, lanes3_get(&s->p, i), s->u[0][i], s->u[1][i], &l);
    if (!s->has_light[i]) return;
    lanes3_set(&s->light_p, i, l.p);
    lanes3_set(&s->light_d, i, l.d);
    lanes3_set(&s->light_weight, i, l.weight);
    s->light_pdf[i] = l.pdf;
    s->light_is_delta[i] = l.is_delta;
    s->light_is_infinite[i] = l.is_infinite;
    s->light_index[i] = (int32_t)l.light;
}

/* Samples a light for every path and adds it where nothing is in the way. */
static void connect(struct stream *s, const struct view *v, const struct trace_settings *t)
{
    const struct stream_kernels *kernels = v->world->kernels;
    if (v->n_lights == 0) return;
    for (uint32_t i = 0; i < s->n; i++) s->has_light[i] = s->is_alive[i] & s->bsdf_is_smooth[i];
    for (uint32_t i = 0; t->photons[0] && i < s->n; i++)
        if (s->is_caster[i] && (s->met[i] & PATH_RECEIVER)) s->has_light[i] = false;
    for (uint32_t i = 0; v->table.n == 0 && i < s->n; i++)
        if (s->has_light[i]) sample_light(s, v, i);
    if (v->table.n > 0) kernels->light(s, &v->guide, &v->table);
    kernels->eval(s);
    kernels->facets_eval(s);
    for (uint32_t k = 0; k < s->n_scalar; k++) {
        uint32_t i = s->scalar[k];
        struct vec3 value;
        if (!s->has_light[i]) continue;
        bsdf_eval(s->bsdf[i], lanes3_get(&s->wi, i), lanes3_get(&s->light_wo, i), &value,
                  &s->value_pdf[i]);
        lanes3_set(&s->value, i, value);
    }
    kernels->connect(s, t->mis, view_saves_rays(v));
    add_lights(s, v);
}

/* ---- Going on -------------------------------------------------------------------------------- */

/* Moves the paths that are alive together, in order, when a good part of the lanes is dead. Dead
 * ones fill the last vector: the rest of a loop would go lane by lane. */
static void compact(struct stream *s)
{
    uint32_t n = 0, n_alive = 0;
    for (uint32_t i = 0; i < s->n; i++) n_alive += s->is_alive[i];
    if (4 * n_alive > 3 * s->n) return;
    for (uint32_t i = 0; i < s->n; i++) {
        if (!s->is_alive[i]) continue;
        uint32_t k = n++;
        s->is_alive[k] = true;
        s->path[k] = s->path[i];
        s->pixel[k] = s->pixel[i];
        lanes3_set(&s->o, k, lanes3_get(&s->o, i));
        lanes3_set(&s->d, k, lanes3_get(&s->d, i));
        s->t_max[k] = s->t_max[i];
        lanes3_set(&s->throughput, k, lanes3_get(&s->throughput, i));
        lanes3_set(&s->last_p, k, lanes3_get(&s->last_p, i));
        s->last_pdf[k] = s->last_pdf[i];
        s->last_is_delta[k] = s->last_is_delta[i];
        s->eta[k] = s->eta[i];
        s->met[k] = s->met[i];
        s->is_chain[k] = s->is_chain[i];
        s->seed[k] = s->seed[i];
        s->index[k] = s->index[i];
        s->rng_state[k] = s->rng_state[i];
        s->rng_stream[k] = s->rng_stream[i];
    }
    s->n = (n + STREAM_VECTOR - 1) / STREAM_VECTOR * STREAM_VECTOR;
    for (uint32_t i = n; i < s->n; i++) s->is_alive[i] = false;
}

static void scatter(struct stream *s, const struct view *v, const struct trace_settings *t,
                    int32_t depth)
{
    v->world->kernels->sample(s);
    v->world->kernels->facets_sample(s);
    bool goes_on[STREAM_SIZE] = {false};
    for (uint32_t k = 0; k < s->n_scalar; k++) {
        uint32_t i = s->scalar[k];
        struct bsdf_sample b = bsdf_sample(s->bsdf[i], lanes3_get(&s->wi, i), s->u[4][i],
                                           s->u[2][i], s->u[3][i]);
        lanes3_set(&s->wo, i, b.wo);
        lanes3_set(&s->weight, i, b.weight);
        s->wo_pdf[i] = b.pdf;
        s->wo_eta[i] = b.eta;
        s->wo_is_delta[i] = (b.lobe & LOBE_DELTA) != 0;
        goes_on[i] = chain_goes_on(s->bsdf[i], &b);
        if (t->photons[0]) s->met[i] = photon_path_after(s->met[i], s->is_caster[i], b.lobe);
    }
    for (uint32_t i = 0; s->chain_group && i < s->n; i++) s->is_chain[i] &= goes_on[i];
    v->world->kernels->scatter(s, depth + 1 >= t->rr_depth ? 0.0f : 1.0f);
    /* The last ray of a path can only add what it hits emits: where that is nothing for sure, it
     * need not be cast. */
    bool is_last = t->max_depth >= 0 && depth + 2 >= t->max_depth;
    if (is_last && v->n_boxes != VIEW_NO_BOXES) v->world->kernels->aim(s, v->boxes, v->n_boxes);
    compact(s);
}

void stream_trace(struct stream *s, const struct view *v, const struct trace_settings *t)
{
    if (t->max_depth == 0) return;
    for (int32_t depth = 0; arrive(s, v, t, depth); depth++) {
        v->world->kernels->draw(s, t->sampler, path_dimension(depth));
        connect(s, v, t);
        scatter(s, v, t, depth);
        stream_cast(s, v, false);
    }
}
