/* SPDX-License-Identifier: Apache-2.0 */
#include "render/buffers.h"

#include <string.h>
#include <xmmintrin.h>

#include "render/light.h"

/* ---- Lanes ----------------------------------------------------------------------------------- */

static void put(struct first_hits *f, uint32_t channel, uint32_t i, struct vec3 v)
{
    f->values[channel][i] = v.x;
    f->values[channel + 1][i] = v.y;
    f->values[channel + 2][i] = v.z;
}

static struct ray lane_ray(const struct first_hits *f, uint32_t i)
{
    return (struct ray){lanes3_get(&f->o, i), 0.0f, lanes3_get(&f->d, i), f->t_max[i]};
}

/* A material that is not the same everywhere. Of the direction only the side matters. */
static struct look look_up(const struct view *v, const struct surface *s, uint32_t bsdf,
                           struct vec3 d)
{
    struct bsdf_point p;
    struct surface here = *s;
    surface_normals(&here.n, &here.frame.n);
    here.wi = vec3(0.0f, 0.0f, vec3_dot(vec3_neg(d), here.frame.n));
    const struct bsdf_place at = surface_place(&here, &v->materials[bsdf]);
    bsdf_point_init(&p, v->materials, bsdf, &v->textures, &at);
    return buffers_look(&p);
}

static void miss(struct first_hits *f, const struct view *v, const struct trace_settings *t,
                 uint32_t i)
{
    const struct path seen = {.last_is_delta = true};
    struct vec3 around = vec3_splat(0.0f);
    const bool is_shown = chain_shows_emitters(t, f->chain[i].n);
    for (uint32_t k = v->first_environment; is_shown && k < v->n_lights; k++)
        around = vec3_add(around,
                          path_environment(v, t, &seen, &v->lights[k], lanes3_get(&f->d, i)));
    put(f, BUFFER_POSITION, i, vec3_splat(0.0f));
    put(f, BUFFER_ALBEDO, i, vec3_splat(0.0f));
    f->values[BUFFER_ROUGHNESS][i] = 0.0f;
    put(f, BUFFER_EMISSION, i, around);
    f->values[BUFFER_SHAPE_ID][i] = f->values[BUFFER_PRIMITIVE_ID][i] = 0.0f;
}

/* Reads what a lane's ray has hit. False where the reference must describe it. */
static bool fetch(struct first_hits *f, const struct view *v, const struct trace_settings *t,
                  uint32_t i)
{
    struct surface s;
    const struct ray ray = lane_ray(f, i);
    surface_fetch(&s, v, &ray, &f->hit[i]);
    const uint32_t bsdf = v->state.shape_bsdfs[s.shape->index];
    struct look look = v->looks[bsdf];
    f->values[BUFFER_SHAPE_ID][i] = (float)(s.shape->index + 1);
    f->values[BUFFER_PRIMITIVE_ID][i] = (float)s.primitive;
    if (look.kind == LOOK_TURNED) return false;
    if (look.kind == LOOK_TEXTURE) look.albedo = texture_eval(&v->textures, look.texture, s.u, s.v);
    if (look.kind == LOOK_VARIES) look = look_up(v, &s, bsdf, ray.d);
    f->t[i] = s.t;
    lanes3_set(&f->normal, i, s.n);
    lanes3_set(&f->shading, i, s.frame.n);
    f->has_wi[i] = !look.is_diffuse;
    put(f, BUFFER_POSITION, i, s.p);
    put(f, BUFFER_ALBEDO, i, look.albedo);
    f->values[BUFFER_ROUGHNESS][i] = look.roughness;
    struct vec3 emission = vec3_splat(0.0f);
    if (s.shape->emitter != SCENE_NONE && chain_shows_emitters(t, f->chain[i].n)) {
        surface_normals(&s.n, &s.frame.n);
        emission = light_surface_radiance(v, &s, ray.d);
    }
    put(f, BUFFER_EMISSION, i, emission);
    return true;
}

static void describe_plain(struct first_hits *f, const struct view *v,
                           const struct trace_settings *t, uint32_t i)
{
    float one[BUFFER_CHANNELS] = {0}; /* ids are there already */
    const struct ray ray = lane_ray(f, i);
    struct trace_settings settings = *t;
    settings.hide_emitters = !chain_shows_emitters(t, f->chain[i].n);
    path_add_buffers(v, &settings, &ray, f->offset[i], &f->hit[i], one);
    for (uint32_t c = 0; c < BUFFER_SHAPE_ID; c++) f->values[c][i] = one[c];
}

/* The sampler of a lane, as film and lens leave it. */
static struct sampler lane_sampler(const struct first_hits *f, const struct stream_film *film,
                                   uint32_t i)
{
    struct sampler r = sampler_start(film->sampler, film->seed, f->pixel[i], f->sample[i]);
    sampler_next_2d(&r);
    if (film->camera.kind != SENSOR_THINLENS) return r;
    sampler_skip_to(&r, PATH_DIMENSION_LENS);
    sampler_next_2d(&r);
    return r;
}

/* Lanes go on to the ends of their chains, one by one. */
static void follow(struct first_hits *f, const struct view *v, const struct trace_settings *t,
                   const struct stream_film *film, const uint32_t *lanes, uint32_t n_lanes)
{
    for (uint32_t k = 0; k < n_lanes; k++) {
        const uint32_t i = lanes[k];
        f->chain[i] = (struct chain){.throughput = {1, 1, 1}};
        if (!t->follows_delta || !chain_may_start(v, &f->hit[i])) continue;
        struct sampler sampler = lane_sampler(f, film, i);
        struct ray ray = lane_ray(f, i);
        chain_follow(&f->chain[i], v, t, &sampler, &ray, &f->hit[i], &f->offset[i]);
        lanes3_set(&f->o, i, ray.o);
        lanes3_set(&f->d, i, ray.d);
        f->t_max[i] = ray.t_max;
    }
}

/* From hits to values. */
static void describe(struct first_hits *f, const struct view *v, const struct trace_settings *t,
                     const uint32_t *lanes, uint32_t n_lanes)
{
    uint32_t plain[STREAM_SIZE], n_plain = 0;
    for (uint32_t k = 0; k < n_lanes; k++) {
        const uint32_t i = lanes[k];
        f->is_hit[i] = f->hit[i].shape != SCENE_NONE;
        if (!f->is_hit[i])
            miss(f, v, t, i);
        else if (!fetch(f, v, t, i))
            plain[n_plain++] = i;
    }
    v->world->kernels->describe(f);
    for (uint32_t k = 0; k < n_plain; k++) describe_plain(f, v, t, plain[k]);
    for (uint32_t k = 0; t->follows_delta && k < n_lanes; k++) {
        float(*e)[STREAM_SIZE + 16] = &f->values[BUFFER_EMISSION];
        const uint32_t i = lanes[k];
        chain_end(&f->chain[i], vec3(e[0][i], e[1][i], e[2][i]));
    }
}

/* Adds a lane to its pixel, of which the first sample comes first: it has the ids. Adding to 0
 * makes a positive zero of a negative one, as in the reference. */
static void add(const struct first_hits *f, uint32_t i, uint32_t sample, float *to)
{
    if (sample > 0)
        for (uint32_t c = 0; c < BUFFER_SHAPE_ID; c++) to[c] += f->values[c][i];
    else
        for (uint32_t c = 0; c < BUFFER_CHANNELS; c++) to[c] = 0.0f + f->values[c][i];
}

static void add_chain(const struct chain *c, uint32_t sample, float *to)
{
    const float values[CHAIN_CHANNELS] = {c->throughput.x, c->throughput.y, c->throughput.z,
                                          c->emission.x,   c->emission.y,   c->emission.z,
                                          (float)c->n};
    for (uint32_t k = 0; k < CHAIN_CHANNELS; k++) to[k] = (sample > 0 ? to[k] : 0.0f) + values[k];
}

/* The same for the first samples of four pixels that lie side by side: turns lanes and channels
 * four by four. */
static void add_four(const struct first_hits *f, uint32_t i, float *to)
{
    const __m128 zero = _mm_setzero_ps();
    uint32_t c = 0;
    for (; c + 4 <= BUFFER_CHANNELS; c += 4) {
        __m128 v[4];
        for (uint32_t k = 0; k < 4; k++)
            v[k] = _mm_add_ps(_mm_loadu_ps(&f->values[c + k][i]), zero);
        _MM_TRANSPOSE4_PS(v[0], v[1], v[2], v[3]);
        for (uint32_t k = 0; k < 4; k++) _mm_storeu_ps(to + k * BUFFER_CHANNELS + c, v[k]);
    }
    for (; c < BUFFER_CHANNELS; c++)
        for (uint32_t k = 0; k < 4; k++) to[k * BUFFER_CHANNELS + c] = 0.0f + f->values[c][i + k];
}

void buffers_scale(const struct trace_settings *t, const struct buffers_tile *tile)
{
    const float scale = 1.0f / (float)t->spp;
    if (t->spp == 1) return;
    for (uint32_t y = 0; y < tile->height; y++) {
        float *to = tile->to + y * tile->stride * BUFFER_CHANNELS;
        float *chain = tile->chain ? tile->chain + y * tile->stride * CHAIN_CHANNELS : NULL;
        for (uint32_t x = 0; x < tile->width; x++, to += BUFFER_CHANNELS)
            for (uint32_t c = 0; c < BUFFER_SHAPE_ID; c++) to[c] *= scale;
        for (uint32_t x = 0; chain && x < tile->width * CHAIN_CHANNELS; x++) chain[x] *= scale;
    }
}

/* ---- Tracing --------------------------------------------------------------------------------- */

/* A pixel of the tile, counted row by row: where it is in the picture. */
static struct pixel_at pixel_of(const struct buffers_tile *tile, uint32_t pixel)
{
    if (tile->pixels) return tile->pixels[pixel];
    return (struct pixel_at){tile->x + pixel % tile->width, tile->y + pixel / tile->width};
}

/* The same, counted from the tile's first. */
static size_t pixel_place(const struct buffers_tile *tile, uint32_t pixel)
{
    return pixel / tile->width * tile->stride + pixel % tile->width;
}

/* Of a pixel of the picture, which need not be in the tile. */
static size_t place_of(const struct buffers_tile *tile, uint32_t x, uint32_t y)
{
    x -= tile->x; /* wraps around below 0 */
    y -= tile->y;
    return x < tile->width && y < tile->height ? y * tile->stride + x : SIZE_MAX;
}

/* A sample of pixel (x, y), which may be beyond the picture's right or bottom. */
static void add_lane(struct first_hits *f, const struct stream_film *film, uint32_t x, uint32_t y,
                     uint32_t sample, size_t place)
{
    const uint32_t i = f->n++;
    f->place[i] = place;
    f->x[i] = x;
    f->y[i] = y;
    f->sample[i] = sample;
    f->pixel[i] = (uint64_t)y * film->width + x;
    f->center_x[i] = (float)x + 0.5f;
    f->center_y[i] = (float)y + 0.5f;
    f->is_inside[i] = x < film->width && y < film->height;
    f->is_hit[i] = false;
}

/* Whether the pixel's filter is cut by the picture's border. */
static bool is_cut(const struct first_hits *f, const struct stream_film *film, uint32_t i)
{
    const float r = film->filter.radius, x = f->center_x[i], y = f->center_y[i];
    return x < r || y < r || (float)film->width - x < r || (float)film->height - y < r;
}

/* The primary ray of a lane, in plain code. */
static void look_plain(struct first_hits *f, const struct stream_film *film, uint32_t i)
{
    struct sampler r = sampler_start(film->sampler, film->seed, f->pixel[i], f->sample[i]);
    const struct vec2 u = sampler_next_2d(&r);
    const float x = f->center_x[i], y = f->center_y[i];
    const float px = x + filter_sample(&film->filter, u.x, -x, (float)film->width - x);
    const float py = y + filter_sample(&film->filter, u.y, -y, (float)film->height - y);
    const struct ray ray = path_start(&film->camera, px, py, &r, &f->offset[i]);
    lanes3_set(&f->o, i, ray.o);
    lanes3_set(&f->d, i, ray.d);
    f->t_max[i] = ray.t_max;
}

static void look(struct first_hits *f, const struct view *v, const struct stream_film *film)
{
    const bool is_pinhole = film->camera.kind == SENSOR_PERSPECTIVE;
    if (is_pinhole) v->world->kernels->look_at(f, film);
    for (uint32_t i = 0; i < f->n; i++)
        if (f->is_inside[i] && (!is_pinhole || is_cut(f, film, i))) look_plain(f, film, i);
}

/* Packets of the lanes from `first` on. */
static void cast(struct first_hits *f, const struct view *v, uint32_t first, uint32_t n)
{
    const struct accel_rays rays = {{f->o.x, f->o.y, f->o.z}, {f->d.x, f->d.y, f->d.z}, f->t_max};
    uint32_t lanes[STREAM_PACKET] = {0}, n_lanes = 0;
    for (uint32_t i = first; i < first + n; i++)
        if (f->is_inside[i]) lanes[n_lanes++] = i;
    accel_intersect_packet(v->top, &rays, lanes, n_lanes, true, f->hit);
}

static void add_one(const struct first_hits *f, const struct trace_settings *t,
                    const struct buffers_tile *tile, uint32_t i)
{
    const size_t place = f->place[i];
    const uint32_t sample = f->sample[i] - t->first_sample;
    if (place == SIZE_MAX) return;
    add(f, i, sample, tile->to + place * BUFFER_CHANNELS);
    if (tile->chain) add_chain(&f->chain[i], sample, tile->chain + place * CHAIN_CHANNELS);
}

/* Blocks side by side, as rows of pixels before they go to memory. */
struct stage {
    _Alignas(64) float rows[BUFFERS_BLOCK][STREAM_SIZE / BUFFERS_BLOCK * BUFFER_CHANNELS];
    size_t first, n; /* place of the first pixel; pixels in a row */
};

/* Copies past the caches: a picture's buffers are larger, and a line that is written whole need not
 * be read. */
static void stream_floats(float *to, const float *from, size_t n)
{
    for (; n > 0 && (uintptr_t)to % 16 != 0; n--) *to++ = *from++;
    for (; n >= 4; n -= 4, to += 4, from += 4) _mm_stream_ps(to, _mm_loadu_ps(from));
    for (; n > 0; n--) *to++ = *from++;
}

static void stage_flush(struct stage *s, const struct buffers_tile *tile)
{
    for (size_t row = 0; row < BUFFERS_BLOCK; row++)
        stream_floats(tile->to + (s->first + row * tile->stride) * BUFFER_CHANNELS, s->rows[row],
                      s->n * BUFFER_CHANNELS);
    s->n = 0;
}

/* Adds whole blocks. Of a large picture, what is the only sample and cut by nothing goes to memory
 * in long rows. */
static void add_blocks(const struct first_hits *f, const struct trace_settings *t,
                       const struct buffers_tile *tile)
{
    enum { WIDTH = BUFFERS_BLOCK, LANES = WIDTH * WIDTH };
    struct stage s;
    s.first = s.n = 0;
    for (uint32_t i = 0; i < f->n; i += LANES) {
        const size_t place = f->place[i];
        const bool is_whole = place != SIZE_MAX && f->place[i + LANES - 1] != SIZE_MAX;
        if (!is_whole || t->spp > 1 || tile->chain) {
            for (uint32_t k = i; k < i + LANES; k++) add_one(f, t, tile, k);
            continue;
        }
        if (!tile->is_large) { /* read again soon */
            for (uint32_t row = 0; row < WIDTH; row++)
                add_four(f, i + row * WIDTH,
                         tile->to + (place + row * tile->stride) * BUFFER_CHANNELS);
            continue;
        }
        if (s.n > 0 && place != s.first + s.n) stage_flush(&s, tile);
        if (s.n == 0) s.first = place;
        for (uint32_t row = 0; row < WIDTH; row++)
            add_four(f, i + row * WIDTH, s.rows[row] + s.n * BUFFER_CHANNELS);
        s.n += WIDTH;
    }
    if (s.n > 0) stage_flush(&s, tile);
    _mm_sfence(); /* before other threads are told */
}

/* Traces what the lanes hold and adds it; packets are of packet_size lanes or, at the end, less. */
static void flush(struct first_hits *f, const struct view *v, const struct trace_settings *t,
                  const struct stream_film *film, const struct buffers_tile *tile)
{
    uint32_t lanes[STREAM_SIZE] = {0}, n_lanes = 0;
    look(f, v, film);
    for (uint32_t first = 0, n; first < f->n; first += n) {
        n = f->n - first < STREAM_PACKET ? f->n - first : STREAM_PACKET;
        if (t->spp >= BUFFERS_BLOCK_SPP) /* of one pixel only */
            for (uint32_t i = 1; i < n; i++)
                if (f->place[first + i] != f->place[first]) n = i;
        cast(f, v, first, n);
    }
    for (uint32_t i = 0; i < f->n; i++)
        if (f->place[i] != SIZE_MAX) lanes[n_lanes++] = i;
    follow(f, v, t, film, lanes, n_lanes);
    describe(f, v, t, lanes, n_lanes);
    if (t->spp < BUFFERS_BLOCK_SPP)
        add_blocks(f, t, tile);
    else
        for (uint32_t k = 0; k < n_lanes; k++) add_one(f, t, tile, lanes[k]);
    f->n = 0;
}

static void trace_blocks(struct first_hits *f, const struct view *v, const struct trace_settings *t,
                         const struct stream_film *film, const struct buffers_tile *tile)
{
    enum { MASK = BUFFERS_BLOCK - 1, LANES = BUFFERS_BLOCK * BUFFERS_BLOCK };
    for (uint32_t y = tile->y & ~(uint32_t)MASK; y < tile->y + tile->height; y += BUFFERS_BLOCK)
        for (uint32_t x = tile->x & ~(uint32_t)MASK; x < tile->x + tile->width; x += BUFFERS_BLOCK)
            for (uint32_t sample = 0; sample < t->spp; sample++) {
                for (uint32_t k = 0; k < LANES; k++) {
                    const uint32_t column = x + k % BUFFERS_BLOCK, row = y + k / BUFFERS_BLOCK;
                    add_lane(f, film, column, row, t->first_sample + sample,
                             place_of(tile, column, row));
                }
                if (f->n + LANES > STREAM_SIZE) flush(f, v, t, film, tile);
            }
    flush(f, v, t, film, tile);
}

/* The blocks around pixels of a list, of which one lane each counts. */
static void trace_blocks_around(struct first_hits *f, const struct view *v,
                                const struct trace_settings *t, const struct stream_film *film,
                                const struct buffers_tile *tile)
{
    for (uint32_t pixel = 0; pixel < tile->width; pixel++) {
        const struct pixel_at at = tile->pixels[pixel];
        const uint32_t x = at.x - at.x % BUFFERS_BLOCK, y = at.y - at.y % BUFFERS_BLOCK;
        for (uint32_t sample = 0; sample < t->spp; sample++) {
            for (uint32_t row = y; row < y + BUFFERS_BLOCK; row++)
                for (uint32_t column = x; column < x + BUFFERS_BLOCK; column++)
                    add_lane(f, film, column, row, t->first_sample + sample,
                             column == at.x && row == at.y ? pixel : SIZE_MAX);
            if (f->n + BUFFERS_BLOCK * BUFFERS_BLOCK > STREAM_SIZE) flush(f, v, t, film, tile);
        }
    }
    flush(f, v, t, film, tile);
}

/* As trace_streams() of tile.c does: packets hold the same samples as there. */
static void trace_pixels(struct first_hits *f, const struct view *v, const struct trace_settings *t,
                         const struct stream_film *film, const struct buffers_tile *tile)
{
    for (uint32_t pixel = 0; pixel < tile->width * tile->height; pixel++)
        for (uint32_t i = 0; i < t->spp; i++) {
            const uint32_t rest = t->spp - i, need = rest < STREAM_SIZE ? rest : STREAM_SIZE;
            if (i % STREAM_SIZE == 0 && f->n + need > STREAM_SIZE) flush(f, v, t, film, tile);
            const struct pixel_at at = pixel_of(tile, pixel);
            add_lane(f, film, at.x, at.y, t->first_sample + i, pixel_place(tile, pixel));
        }
    flush(f, v, t, film, tile);
}

void buffers_trace(const struct view *v, const struct trace_settings *t,
                   const struct stream_film *film, const struct buffers_tile *tile)
{
    struct first_hits f;
    f.n = 0;
    if (t->spp < BUFFERS_BLOCK_SPP && tile->pixels)
        trace_blocks_around(&f, v, t, film, tile);
    else if (t->spp < BUFFERS_BLOCK_SPP)
        trace_blocks(&f, v, t, film, tile);
    else
        trace_pixels(&f, v, t, film, tile);
}

void buffers_add_stream(const struct view *v, const struct trace_settings *t,
                        const struct stream_film *film, struct stream *s,
                        const struct buffers_tile *tile, const uint32_t *samples,
                        const uint32_t *pixels)
{
    struct first_hits f;
    uint32_t lanes[STREAM_SIZE] = {0};
    f.n = s->n;
    stream_find_hits(s, v);
    memcpy(&f.o, &s->o, sizeof f.o);
    memcpy(&f.d, &s->d, sizeof f.d);
    memcpy(f.t_max, s->t_max, sizeof f.t_max);
    memcpy(f.offset, s->offset, sizeof f.offset);
    memcpy(f.hit, s->hit, sizeof f.hit);
    memcpy(f.pixel, s->pixel, sizeof f.pixel);
    memcpy(f.sample, s->sample, sizeof f.sample);
    for (uint32_t i = 0; i < f.n; i++) lanes[i] = i;
    follow(&f, v, t, film, lanes, f.n);
    describe(&f, v, t, lanes, f.n);
    for (uint32_t i = 0; i < f.n; i++) {
        const size_t place = pixel_place(tile, pixels[i]);
        add(&f, i, samples[i], tile->to + place * BUFFER_CHANNELS);
        if (tile->chain) add_chain(&f.chain[i], samples[i], tile->chain + place * CHAIN_CHANNELS);
    }
}

void buffers_follow(const struct view *v, const struct trace_settings *t,
                    const struct stream_film *film, const struct pixel_at *pixels, uint32_t n,
                    struct chain_end *ends)
{
    struct first_hits f;
    struct trace_settings settings = *t;
    uint32_t lanes[STREAM_SIZE];
    settings.follows_delta = true;
    for (uint32_t i = 0; i < STREAM_SIZE; i++) lanes[i] = i;
    for (uint32_t first = 0; first < n; first += f.n) {
        f.n = 0;
        for (uint32_t i = first; i < n && f.n < STREAM_SIZE; i++)
            add_lane(&f, film, pixels[i].x, pixels[i].y, t->first_sample, i);
        look(&f, v, film);
        for (uint32_t i = 0, size; i < f.n; i += size) {
            size = f.n - i < STREAM_PACKET ? f.n - i : STREAM_PACKET;
            cast(&f, v, i, size);
        }
        follow(&f, v, &settings, film, lanes, f.n);
        for (uint32_t i = 0; i < f.n; i++)
            ends[first + i] = (struct chain_end){lane_ray(&f, i), f.chain[i].n};
    }
}

/* Ends are for a compact network to know: what is smoother shows too much, and what scatters direct
 * light alone is soon traced. */
#define LEAST_END_ROUGHNESS 0.6f
enum { LEAST_END_DEPTH = 3 };

bool buffers_cut_paths(const struct view *v, const struct trace_settings *t, struct stream *s,
                       int32_t depth)
{
    struct first_hits f;
    struct trace_settings settings = *t;
    struct path_ends *to = s->ends;
    uint32_t lanes[STREAM_SIZE] = {0}, n = 0, n_cut = 0;
    if (t->max_depth >= 0 && t->max_depth - depth < LEAST_END_DEPTH) return true;
    settings.follows_delta = false;
    f.n = s->n;
    stream_find_hits(s, v);
    memcpy(&f.o, &s->o, sizeof f.o);
    memcpy(&f.d, &s->d, sizeof f.d);
    memcpy(f.t_max, s->t_max, sizeof f.t_max);
    memcpy(f.hit, s->hit, sizeof f.hit);
    for (uint32_t i = 0; i < f.n; i++) {
        f.offset[i] = 0.0f;
        f.chain[i].n = 1;
        f.is_hit[i] = false;
        lanes[n] = i;
        n += s->is_alive[i];
    }
    describe(&f, v, &settings, lanes, n);
    for (uint32_t k = 0; k < n; k++) {
        const uint32_t i = lanes[k], path = s->path[i];
        if (f.values[BUFFER_ROUGHNESS][i] < LEAST_END_ROUGHNESS || to->n == to->capacity) continue;
        struct path_end *end = &to->ends[to->n];
        end->pixel = (uint32_t)(s->place[path] / 3);
        end->sample = s->sample[path] - s->first_sample;
        end->max_depth = t->max_depth < 0 ? -1 : t->max_depth - depth;
        end->throughput = lanes3_get(&s->throughput, i);
        end->ray = lane_ray(&f, i);
        add(&f, i, 0, to->buffers + (size_t)to->n * BUFFER_CHANNELS);
        to->n++;
        s->is_alive[i] = false;
        n_cut++;
    }
    return n_cut < n;
}

void buffers_add_plain(const struct view *v, const struct trace_settings *t, const struct ray *ray,
                       float offset, const struct hit *hit, const struct sampler *sampler,
                       uint32_t sample, uint32_t pixel, const struct buffers_tile *tile)
{
    const size_t place = pixel_place(tile, pixel);
    float *to = tile->to + place * BUFFER_CHANNELS, one[BUFFER_CHANNELS] = {0};
    struct chain chain = {.throughput = {1, 1, 1}};
    struct sampler drawn = *sampler;
    struct ray last = *ray;
    struct hit end = *hit;
    struct trace_settings settings = *t;
    if (t->follows_delta) chain_follow(&chain, v, t, &drawn, &last, &end, &offset);
    settings.hide_emitters = !chain_shows_emitters(t, chain.n);
    path_add_buffers(v, &settings, &last, offset, &end, one);
    chain_end(&chain, vec3_load(one + BUFFER_EMISSION));
    if (end.shape != SCENE_NONE) {
        const struct view_instance *instance = &v->instances[end.instance];
        one[BUFFER_SHAPE_ID] = (float)(instance->shapes[end.shape].index + 1);
        one[BUFFER_PRIMITIVE_ID] = (float)end.primitive;
    }
    if (sample == 0) memset(to, 0, BUFFER_CHANNELS * sizeof *to);
    for (uint32_t c = 0; c < (sample == 0 ? BUFFER_CHANNELS : BUFFER_SHAPE_ID); c++)
        to[c] += one[c];
    if (tile->chain) add_chain(&chain, sample, tile->chain + place * CHAIN_CHANNELS);
}
