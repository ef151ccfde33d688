/* SPDX-License-Identifier: Apache-2.0 */
#include "train/scout.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"
#include "base/pool.h"
#include "base/rng.h"
#include "scene/assign.h"

/* Keep the random numbers of one seed apart. */
enum {
    STREAM_PIXELS = 0x70697865,
    STREAM_LOOK = 0x6c6f6f6b,
    STREAM_DRAW = 0x64726177,
    STREAM_CHILD = 0x6368696c
};

/* Part of the mean rate that each pixel with a surface, or without, gets in any case: what is
 * expected may be wrong. */
#define FLOOR_SURFACE 0.2f
#define FLOOR_NOTHING 0.02f

struct scout {
    struct scout_options options;
    const struct workplace *place;
    const struct sight *sight;
    struct field *field;
    uint64_t memory_size;

    float *u;                /* [n_fresh][n_variables] */
    struct pixel_at *pixels; /* [n_fresh][n_pixels] */
    float *weights;          /* [n_fresh][n_pixels] */

    /* Of what is looked at; exploration only. */
    struct pixel_at *looks;              /* [n_fresh][n_looks] */
    float *buffers;                      /* [workers][n_looks][BUFFER_CHANNELS] */
    float *positions, *features, *scale; /* [n_fresh][n_looks].. */
    float *v, *expected;                 /* [n_fresh][sight n_variables], [n_fresh][n_looks] */
    struct field_run *runs;              /* [n_fresh] */

    double *errors; /* [memory's capacity]: running sums, to draw parents */
    /* Of the step under way. */
    struct view *const *views;
    const struct memory *memory;
    uint64_t serial;
    double sum_errors;
};

static void *take(struct scout *s, size_t count, size_t size, bool *is_short)
{
    void *block = mem_new(count > 0 ? count : 1, size);
    if (block)
        s->memory_size += (uint64_t)count * size;
    else
        *is_short = true;
    return block;
}

lmn_status scout_new(const struct workplace *place, const struct sight *sight, struct field *field,
                     const struct scout_options *options, struct scout **out, struct error *err)
{
    struct scout *s = mem_new(1, sizeof *s);
    *out = NULL;
    if (!s) return fail_memory(err, "exploration");
    s->options = *options;
    s->place = place;
    s->sight = sight;
    s->field = field;
    const size_t n = options->n_fresh, n_traced = n * options->n_pixels;
    bool is_short = false;
    s->u = take(s, n * place->scene->n_variables, sizeof *s->u, &is_short);
    s->pixels = take(s, n_traced, sizeof *s->pixels, &is_short);
    s->weights = take(s, n_traced, sizeof *s->weights, &is_short);
    if (options->n_looks > 0) {
        const size_t n_looks = n * options->n_looks;
        s->looks = take(s, n_looks, sizeof *s->looks, &is_short);
        s->buffers = take(s, (size_t)pool_n_workers(place->pool) * options->n_looks,
                          sizeof(float[BUFFER_CHANNELS]), &is_short);
        s->positions = take(s, n_looks * sight->n_positions, sizeof(float[3]), &is_short);
        s->features = take(s, n_looks * sight->n_features, sizeof(float), &is_short);
        s->scale = take(s, n_looks, sizeof(float[3]), &is_short);
        s->v = take(s, n * sight->n_variables, sizeof(float), &is_short);
        s->expected = take(s, n_looks, sizeof(float), &is_short);
        s->runs = take(s, n, sizeof *s->runs, &is_short);
    }
    if (is_short) {
        scout_free(s);
        return fail_memory(err, "exploration");
    }
    *out = s;
    return LMN_OK;
}

void scout_free(struct scout *s)
{
    if (!s) return;
    void *const blocks[] = {s->u,       s->pixels,    s->weights,  s->looks,
                            s->buffers, s->positions, s->features, s->scale,
                            s->v,       s->expected,  s->runs,     s->errors};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) mem_free(blocks[i]);
    mem_free(s);
}

uint64_t scout_memory_size(const struct scout *s)
{
    return s->memory_size;
}

/* ---- Configurations -------------------------------------------------------------------------- */

static void draw_configuration(const struct scout *s, uint32_t item, float *u)
{
    const struct scene *scene = s->place->scene;
    scene_random_units(scene, s->options.seed, s->serial + item, u);
    if (s->sum_errors > 0) {
        struct rng r = rng_keyed(s->options.seed ^ STREAM_CHILD, s->serial + item, 0);
        if (rng_float(&r) < (float)s->options.children) {
            const uint32_t n_held = memory_n_held(s->memory);
            const double at = (double)rng_float(&r) * s->sum_errors;
            uint32_t low = 0, high = n_held - 1;
            while (low < high) {
                uint32_t middle = (low + high) / 2;
                if (s->errors[middle] > at)
                    high = middle;
                else
                    low = middle + 1;
            }
            const float *parent = s->memory->u + (size_t)low * scene->n_variables;
            const float share = fminf(1.0f, 4.0f / (float)scene->n_variables);
            for (uint32_t k = 0; k < scene->n_variables; k++) {
                if (rng_float(&r) >= share) {
                    u[k] = parent[k];
                    continue;
                }
                float step = 0.1f * (rng_float(&r) + rng_float(&r) + rng_float(&r) - 1.5f);
                float x = fabsf(parent[k] + step);
                x = x > 1.0f ? 2.0f - x : x;
                u[k] = fminf(fmaxf(x, 0.0f), 0x1.fffffep-1f);
            }
        }
    }
    powers_set_reference(&s->sight->powers, u);
}

/* ---- Pixels ---------------------------------------------------------------------------------- */

static void draw_pixels(const struct scout *s, uint64_t serial, struct pixel_at *pixels, uint32_t n)
{
    struct rng r = rng_keyed(s->options.seed ^ STREAM_PIXELS, serial, 0);
    for (uint32_t i = 0; i < n; i++)
        pixels[i] = (struct pixel_at){rng_below(&r, s->options.width),
                                      rng_below(&r, s->options.height)};
}

static void plain_item(void *ctx, uint32_t item, uint32_t worker)
{
    struct scout *s = ctx;
    const uint32_t n = s->options.n_pixels;
    (void)worker;
    draw_configuration(s, item, s->u + (size_t)item * s->place->scene->n_variables);
    draw_pixels(s, s->serial + item, s->pixels + (size_t)item * n, n);
    for (uint32_t i = 0; i < n; i++) s->weights[(size_t)item * n + i] = 1.0f;
}

static void look_item(void *ctx, uint32_t item, uint32_t worker)
{
    struct scout *s = ctx;
    const struct sight *sight = s->sight;
    const uint32_t n = s->options.n_looks;
    const size_t first = (size_t)item * n;
    float *u = s->u + (size_t)item * s->place->scene->n_variables;
    float *v = s->v + (size_t)item * sight->n_variables;
    float *buffers = s->buffers + (size_t)worker * n * BUFFER_CHANNELS;
    struct trace_output output = {.buffers = buffers};
    struct trace_settings t;
    draw_configuration(s, item, u);
    draw_pixels(s, s->serial + item, s->looks + first, n);
    trace_settings_init(&t, s->place->scene);
    t.spp = 1;
    t.splats = false;
    t.follows_delta = sight->follows_delta;
    t.seed = rng_keyed(s->options.seed ^ STREAM_LOOK, s->serial + item, 0).state;
    view_set(s->views[worker], u);
    view_trace_pixels(s->views[worker], &t, s->options.width, s->options.height, s->looks + first,
                      n, &output);
    s->runs[item] = (struct field_run){.n = n,
                                       .positions = s->positions + first * sight->n_positions * 3,
                                       .features = s->features + first * sight->n_features,
                                       .scale = s->scale + 3 * first,
                                       .v = v};
    sight_look(sight, view_state(s->views[worker]), buffers, n,
               s->positions + first * sight->n_positions * 3,
               s->features + first * sight->n_features, s->scale + 3 * first);
    sight_variables(sight, u, v);
}

/* Systematic resampling: pixels of those looked at, in proportion to the root of the expected
 * loss. */
static void choose_item(void *ctx, uint32_t item, uint32_t worker)
{
    struct scout *s = ctx;
    const uint32_t n_looks = s->options.n_looks, n = s->options.n_pixels;
    const size_t first = (size_t)item * n_looks;
    float *rates = s->expected + first;
    double sum = 0, passed = 0;
    uint32_t n_surfaces = 0;
    (void)worker;
    for (uint32_t i = 0; i < n_looks; i++) {
        const bool is_surface = s->scale[3 * (first + i)] > 0.0f;
        rates[i] = is_surface ? sqrtf(rates[i]) : 0.0f;
        sum += (double)rates[i];
        n_surfaces += is_surface;
    }
    const float mean = n_surfaces > 0 ? (float)(sum / n_surfaces) : 1.0f;
    sum = 0;
    for (uint32_t i = 0; i < n_looks; i++) {
        rates[i] += mean * (rates[i] > 0.0f ? FLOOR_SURFACE : FLOOR_NOTHING);
        sum += (double)rates[i];
    }
    struct rng r = rng_keyed(s->options.seed ^ STREAM_DRAW, s->serial + item, 0);
    const double stride = sum / n, start = (double)rng_float(&r) * stride;
    for (uint32_t i = 0, k = 0; k < n; k++) {
        const double at = start + k * stride;
        while (i + 1 < n_looks && passed + (double)rates[i] <= at) passed += (double)rates[i++];
        s->pixels[(size_t)item * n + k] = s->looks[first + i];
        s->weights[(size_t)item * n + k] = (float)(sum / n_looks) / rates[i];
    }
}

/* Running sums of errors, where they are known. */
static void sum_errors(struct scout *s)
{
    const uint32_t n = memory_n_held(s->memory);
    s->sum_errors = 0;
    if (s->options.children <= 0) return;
    if (!s->errors) s->errors = mem_new(s->memory->capacity, sizeof *s->errors);
    if (!s->errors) return;
    for (uint32_t i = 0; i < n; i++) {
        s->sum_errors += fmax((double)s->memory->errors[i], 0.0);
        s->errors[i] = s->sum_errors;
    }
}

void scout_go(struct scout *s, struct view *const *views, const struct memory *memory,
              uint64_t serial)
{
    const uint32_t n = s->options.n_fresh;
    s->views = views;
    s->memory = memory;
    s->serial = serial;
    sum_errors(s);
    if (s->options.n_looks == 0) {
        pool_run(s->place->pool, n, plain_item, s);
        return;
    }
    pool_run(s->place->pool, n, look_item, s);
    field_expect(s->field, s->runs, n, s->expected);
    pool_run(s->place->pool, n, choose_item, s);
}

const float *scout_u(const struct scout *s, uint32_t i)
{
    return s->u + (size_t)i * s->place->scene->n_variables;
}

const struct pixel_at *scout_pixels(const struct scout *s, uint32_t i)
{
    return s->pixels + (size_t)i * s->options.n_pixels;
}

const float *scout_weights(const struct scout *s, uint32_t i)
{
    return s->weights + (size_t)i * s->options.n_pixels;
}
