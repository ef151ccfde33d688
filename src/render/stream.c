/* SPDX-License-Identifier: Apache-2.0 */
#include "render/stream.h"

#include "base/clock.h"
#include "base/cpu.h"
#include "render/buffers.h"
#include "render/chain.h"
#include "render/light_around.h"
#include "render/light_table.h"
#include "render/photon.h"
#include "render/stream_arrive.h"

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
    const bool goes_on = i > 0 && s->pixel[i] == s->pixel[i - 1] && sample > s->sample[i - 1];
    s->owner[i] = goes_on ? s->owner[i - 1] : i;
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

/* ---- Rays ------------------------------------------------------------------------------------ */

/* The next lanes from *first on that have their flag set and are samples of one pixel: at most
 * STREAM_PACKET. *first becomes the lane to go on from. */
static uint32_t next_packet(const struct stream *s, const uint32_t *flags, uint32_t *first,
                            uint32_t *lanes)
{
    uint32_t n = 0, i = *first;
    while (i < s->n && !flags[i]) i++;
    for (uint32_t owner = i < s->n ? s->owner[i] : 0; i < s->n && n < STREAM_PACKET; i++) {
        if (!flags[i]) continue;
        if (s->owner[i] != owner) break;
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
            stream_add_radiance(s, i, v->lights[s->light_index[i]].emitter, false,
                                lanes3_get(&s->light, i));
}

/* ---- Connecting to lights -------------------------------------------------------------------- */

/* For a lane whose light no vector code knows. */
static void sample_light(struct stream *s, const struct view *v, uint32_t i)
{
    struct light_sample l;
    struct vec3 p = lanes3_get(&s->p, i);
    if (light_is_guided(v))
        s->has_light[i] = light_sample_chosen(v, (uint32_t)s->light_index[i], p, s->light_left[i],
                                              s->u[1][i], s->light_choice[i], &l);
    else
        s->has_light[i] = light_sample(v, p, s->u[0][i], s->u[1][i], &l);
    if (!s->has_light[i]) return;
    lanes3_set(&s->light_p, i, l.p);
    lanes3_set(&s->light_d, i, l.d);
    lanes3_set(&s->light_weight, i, l.weight);
    s->light_pdf[i] = l.pdf;
    s->light_is_delta[i] = l.is_delta;
    s->light_is_infinite[i] = l.is_infinite;
    s->light_index[i] = (int32_t)l.light;
}

/* For the lanes that have chosen an environment. */
static void sample_environment(struct stream *s, const struct view *v, uint32_t light)
{
    uint32_t n = 0, lanes[STREAM_SIZE];
    struct light_around a;
    for (uint32_t i = 0; i < s->n; i++) { /* a branch would be mispredicted */
        lanes[n] = i;
        n += (s->has_light[i] != 0) & (s->light_index[i] == (int32_t)light);
    }
    if (n == 0) return;
    light_around_init(&a, v, &v->lights[light]);
    if (light_around_is_small(&a))
        v->world->kernels->light_around(s, &a, lanes, n);
    else
        for (uint32_t k = 0; k < n; k++) sample_light(s, v, lanes[k]);
}

/* Light samples of the lanes that want one. */
static void sample_lights(struct stream *s, const struct view *v)
{
    const struct stream_kernels *kernels = v->world->kernels;
    if (light_is_guided(v)) kernels->choose_light(s, &v->guide);
    if (v->table.n > 0) kernels->light(s, &v->table);
    if (light_table_is_whole(v)) return;
    bool is_all_around = light_is_guided(v) && v->first_environment == 0;
    for (uint32_t i = 0; !is_all_around && i < s->n; i++) {
        uint32_t light = (uint32_t)s->light_index[i];
        bool is_known = light_is_guided(v) &&
                        (light >= v->first_environment || light_table_has(&v->table, light));
        if (s->has_light[i] && !is_known) sample_light(s, v, i);
    }
    for (uint32_t k = v->first_environment; light_is_guided(v) && k < v->n_lights; k++)
        sample_environment(s, v, k);
}

/* Samples a light for every path and adds it where nothing is in the way. */
static void connect(struct stream *s, const struct view *v, const struct trace_settings *t)
{
    const struct stream_kernels *kernels = v->world->kernels;
    if (v->n_lights == 0) return;
    for (uint32_t i = 0; i < s->n; i++) s->has_light[i] = s->is_alive[i] & s->bsdf_is_smooth[i];
    for (uint32_t i = 0; t->photons[0] && i < s->n; i++)
        if (s->receiver[i] == RECEIVER_NONE && (s->met[i] & PATH_RECEIVER)) s->has_light[i] = false;
    sample_lights(s, v);
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

static void move_words(uint32_t *a, const uint32_t *from, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++) a[k] = a[from[k]];
}

static void move_longs(uint64_t *a, const uint32_t *from, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++) a[k] = a[from[k]];
}

static void move_floats(float *a, const uint32_t *from, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++) a[k] = a[from[k]];
}

static void move_lanes3(struct lanes3 *a, const uint32_t *from, uint32_t n)
{
    move_floats(a->x, from, n);
    move_floats(a->y, from, n);
    move_floats(a->z, from, n);
}

/* Moves the paths that are alive together, in order, when a good part of the lanes is dead. Dead
 * ones fill the last vector: the rest of a loop would go lane by lane. Rays have just been made:
 * t_max is the same for all. */
static void compact(struct stream *s, const struct trace_settings *t)
{
    uint32_t n = 0, from[STREAM_SIZE + 1];
    for (uint32_t i = 0; i < s->n; i++) {
        from[n] = i;
        n += s->is_alive[i];
    }
    if (4 * n > 3 * s->n) return;
    move_words(s->path, from, n);
    move_words(s->owner, from, n);
    move_lanes3(&s->o, from, n);
    move_lanes3(&s->d, from, n);
    move_lanes3(&s->throughput, from, n);
    move_lanes3(&s->last_p, from, n);
    move_floats(s->last_pdf, from, n);
    move_words(s->last_is_delta, from, n);
    move_floats(s->eta, from, n);
    if (t->photons[0]) move_words(s->met, from, n);
    if (s->chain_group) move_words(s->is_chain, from, n);
    if (t->sampler == SAMPLER_INDEPENDENT) {
        move_longs(s->rng_state, from, n);
        move_longs(s->rng_stream, from, n);
    } else {
        move_words(s->seed, from, n);
        move_words(s->index, from, n);
    }
    if (stream_whole(n) < s->n) s->n = stream_whole(n); /* beyond, lanes were never started */
    for (uint32_t i = 0; i < s->n; i++) s->is_alive[i] = i < n;
}

static void scatter(struct stream *s, const struct view *v, const struct trace_settings *t,
                    int32_t depth)
{
    v->world->kernels->sample(s);
    v->world->kernels->facets_sample(s);
    bool goes_on[STREAM_SIZE] = {false}, passes[STREAM_SIZE] = {false};
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
        passes[i] = (b.lobe & LOBE_NULL) != 0;
    }
    for (uint32_t i = 0; t->photons[0] && i < s->n; i++)
        s->met[i] = photon_path_after(s->met[i], s->receiver[i] == RECEIVER_NONE,
                                      passes[i] ? LOBE_NULL : 0);
    for (uint32_t i = 0; s->chain_group && i < s->n; i++) s->is_chain[i] &= goes_on[i];
    v->world->kernels->scatter(s, depth + 1 >= t->rr_depth ? 0.0f : 1.0f);
    /* The last ray of a path can only add what it hits emits: where that is nothing for sure, it
     * need not be cast. */
    bool is_last = t->max_depth >= 0 && depth + 2 >= t->max_depth;
    if (is_last && v->n_boxes != VIEW_NO_BOXES) v->world->kernels->aim(s, v->boxes, v->n_boxes);
    compact(s, t);
}

/* Which random numbers of a bounce are used; drawing is a tenth of the time in simple scenes. */
static uint32_t wanted_numbers(const struct stream *s, const struct view *v,
                               const struct trace_settings *t, int32_t depth)
{
    bool has_lobes = s->n_scalar > 0, has_roulette = depth + 1 >= t->rr_depth || view_saves_rays(v);
    for (int k = 0; k < FACET_LISTS_N; k++) has_lobes |= s->n_facets[k] > 0;
    return (has_lobes ? STREAM_LOBE : 0) | (has_roulette ? STREAM_ROULETTE : 0);
}

static void count(const struct stream *s, int32_t depth)
{
    uint64_t n = 0;
    for (uint32_t i = 0; i < s->n; i++) n += s->is_alive[i];
    if (depth == 1) s->lengths->second += n;
    if (depth > 1) s->lengths->later += n;
}

void stream_trace(struct stream *s, const struct view *v, const struct trace_settings *t)
{
    if (t->max_depth == 0) return;
    for (int32_t depth = 0; stream_arrive(s, v, t, depth); depth++) {
        if (s->lengths) count(s, depth);
        if (s->ends && depth > 0 && !buffers_cut_paths(v, t, s, depth)) return;
        if (t->photons[0]) stream_gather(s, t, depth);
        v->world->kernels->draw(s, t->sampler, path_dimension(depth),
                                wanted_numbers(s, v, t, depth));
        v->world->kernels->facets_gather(s);
        connect(s, v, t);
        scatter(s, v, t, depth);
        stream_cast(s, v, false);
    }
}
