/* SPDX-License-Identifier: Apache-2.0 */
#include "easel.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "encode.h"

/* Samples per pixel at which pictures are left alone. */
enum { NEURAL_SPP = 64, TRACED_SPP = 4096, BUFFER_SPP = 4 };

/* A pass of path tracing at rest takes about so long; so does the first look at a new state. */
#define PASS_S 0.1

/* What a pixel costs before any was measured, in seconds. */
#define GUESS_NEURAL 2e-7
#define GUESS_TRACED 1e-6

enum { STATS_KEPT = 15 };

/* A picture at rest: the mean of its samples so far. */
struct canvas {
    lmn_image *image; /* owned, of the full size; NULL: no sample */
    uint32_t spp;
};

struct easel {
    const struct studio_options *options;
    struct wish wish; /* owned values */
    bool has_wish;
    struct canvas neural, traced;
    uint64_t step;         /* of the training whose network `neural` shows */
    bool is_shown[LAYERS]; /* some picture of this version has been made */
    bool is_done[LAYERS];
    uint32_t compared_spp;           /* of the traced picture in the last comparison */
    double cost_neural, cost_traced; /* seconds per pixel and sample */
    uint8_t *rgb;                    /* owned, [rgb_pixels][3] */
    size_t rgb_pixels;
    struct view_stats stats;
    double frame_s[STATS_KEPT], render_ms[STATS_KEPT], encode_ms[STATS_KEPT];
    uint32_t n_timed;
};

struct easel *easel_new(const struct studio_options *options)
{
    struct easel *e = calloc(1, sizeof *e);
    if (!e) return NULL;
    e->options = options;
    e->cost_neural = GUESS_NEURAL;
    e->cost_traced = GUESS_TRACED;
    e->wish.values = calloc(options->rules.n_variables + 1u, sizeof *e->wish.values);
    if (e->wish.values) return e;
    free(e);
    return NULL;
}

static void canvas_clear(struct canvas *c)
{
    lmn_image_free(c->image);
    *c = (struct canvas){0};
}

void easel_free(struct easel *e)
{
    if (!e) return;
    canvas_clear(&e->neural);
    canvas_clear(&e->traced);
    free(e->wish.values);
    free(e->rgb);
    free(e);
}

/* ---- States ---------------------------------------------------------------------------------- */

static bool is_same_camera(const struct wish *a, const struct wish *b)
{
    const lmn_camera *p = &a->camera, *q = &b->camera;
    if (a->has_camera != b->has_camera) return false;
    if (!a->has_camera) return true;
    for (int i = 0; i < 3; i++)
        if (p->origin[i] != q->origin[i] || p->target[i] != q->target[i] || p->up[i] != q->up[i])
            return false;
    return p->fov == q->fov;
}

/* Whether the samples of one picture are those of the other. */
static bool is_same_picture(const struct easel *e, const struct wish *b)
{
    const struct wish *a = &e->wish;
    return e->has_wish && a->width == b->width && a->height == b->height && is_same_camera(a, b) &&
           memcmp(a->values, b->values, e->options->rules.n_variables * sizeof *a->values) == 0;
}

void easel_set(struct easel *e, const struct wish *wish)
{
    double *values = e->wish.values;
    if (!is_same_picture(e, wish)) {
        canvas_clear(&e->neural);
        canvas_clear(&e->traced);
        e->compared_spp = 0;
    }
    memcpy(values, wish->values, e->options->rules.n_variables * sizeof *values);
    e->wish = *wish;
    e->wish.values = values;
    e->has_wish = true;
    for (int k = 0; k < LAYERS; k++) e->is_shown[k] = e->is_done[k] = false;
}

uint32_t easel_version(const struct easel *e)
{
    return e->has_wish ? e->wish.version : 0;
}

/* Comparing takes a while: not of pictures that are gone at once. */
static bool is_wanted_now(const struct easel *e, enum layer layer)
{
    return layer != LAYER_ERROR || !e->wish.is_moving;
}

bool easel_is_new(const struct easel *e)
{
    for (uint32_t i = 0; i < e->wish.n_layers; i++) {
        const enum layer layer = e->wish.layers[i];
        if (layer != LAYER_ERROR && !e->is_shown[layer]) return true;
    }
    return false;
}

static bool is_wished(const struct easel *e, enum layer layer)
{
    for (uint32_t i = 0; i < e->wish.n_layers; i++)
        if (e->wish.layers[i] == layer) return true;
    return false;
}

/* The error needs both pictures, wanted or not. */
static bool is_needed(const struct easel *e, enum layer layer)
{
    return is_wished(e, layer) ||
           (layer != LAYER_BUFFER && is_wished(e, LAYER_ERROR) && !e->wish.is_moving);
}

/* The network has learnt since it was shown. */
static bool is_outdated(const struct easel *e)
{
    lmn_train_stats stats;
    if (!e->options->trainer) return false;
    lmn_trainer_get_stats(e->options->trainer, &stats);
    return stats.step != e->step;
}

bool easel_is_done(const struct easel *e)
{
    if (is_needed(e, LAYER_NEURAL) && is_outdated(e)) return false;
    for (int k = 0; k < LAYERS; k++)
        if (is_needed(e, (enum layer)k) && is_wanted_now(e, (enum layer)k) && !e->is_done[k])
            return false;
    return true;
}

/* ---- Pictures -------------------------------------------------------------------------------- */

/* What is drawn: a size, and samples from a number on. */
struct stroke {
    uint32_t width, height, spp, first_sample;
};

/* Half of what it was, half of what was measured: sizes must not flutter. */
static void note_cost(double *cost, const struct stroke *s, double seconds)
{
    *cost = 0.5 * *cost + 0.5 * seconds / ((double)s->width * s->height * s->spp);
}

static lmn_status draw_neural(struct easel *e, const struct stroke *s, lmn_image **out,
                              double *seconds)
{
    const lmn_render_options o = {.struct_size = sizeof o,
                                  .width = s->width,
                                  .height = s->height,
                                  .buffer_spp = s->spp,
                                  .camera = e->wish.has_camera ? &e->wish.camera : NULL,
                                  .first_sample = s->first_sample};
    const lmn_status status = e->options->trainer
                                  ? lmn_trainer_render(e->options->trainer, e->wish.values, &o, out,
                                                       seconds)
                                  : lmn_model_render(e->options->context, e->options->model,
                                                     e->wish.values, &o, out, seconds);
    if (status == LMN_OK) note_cost(&e->cost_neural, s, *seconds);
    return status;
}

static lmn_status draw_traced(struct easel *e, const struct stroke *s, lmn_image **out,
                              double *seconds)
{
    const lmn_trace_options o = {.struct_size = sizeof o,
                                 .width = s->width,
                                 .height = s->height,
                                 .spp = s->spp,
                                 .integrator = "path",
                                 .camera = e->wish.has_camera ? &e->wish.camera : NULL,
                                 .first_sample = s->first_sample};
    const lmn_status status = lmn_scene_trace(e->options->context, e->options->scene,
                                              e->wish.values, &o, out, seconds);
    if (status == LMN_OK) note_cost(&e->cost_traced, s, *seconds);
    return status;
}

/* First hits: light ends at its source, so that no path is followed. */
static lmn_status draw_buffers(struct easel *e, const struct stroke *s, const uint32_t crop[2],
                               lmn_image **out, double *seconds)
{
    lmn_trace_options o = {.struct_size = sizeof o,
                           .width = s->width,
                           .height = s->height,
                           .spp = s->spp,
                           .has_max_depth = 1,
                           .max_depth = 1,
                           .buffers = 1,
                           .integrator = "path",
                           .camera = e->wish.has_camera ? &e->wish.camera : NULL};
    if (crop) {
        o.crop_x = crop[0];
        o.crop_y = crop[1];
        o.crop_width = o.crop_height = 1;
    }
    return lmn_scene_trace(e->options->context, e->options->scene, e->wish.values, &o, out,
                           seconds);
}

/* Adds an image's samples to the mean; takes it over. */
static void canvas_add(struct canvas *c, lmn_image *image, uint32_t spp)
{
    if (!c->image) {
        *c = (struct canvas){image, spp};
        return;
    }
    const size_t n = (size_t)lmn_image_width(image) * lmn_image_height(image) * 3;
    const float share = (float)spp / (float)(c->spp + spp), rest = 1.0f - share;
    float *mean = lmn_image_data(c->image);
    const float *more = lmn_image_data(image);
    for (size_t i = 0; i < n; i++) mean[i] = rest * mean[i] + share * more[i];
    c->spp += spp;
    lmn_image_free(image);
}

/* The size of a moving picture, so large that it takes the seconds given. */
static struct stroke moving_size(const struct wish *w, double cost, double seconds)
{
    const double whole = cost * w->width * w->height;
    double scale = sqrt(seconds / fmax(whole, 1e-9));
    scale = fmin(fmax(scale, w->least), 1.0);
    struct stroke s = {(uint32_t)lround(scale * w->width), (uint32_t)lround(scale * w->height), 1,
                       0};
    if (s.width < HALL_SIDE_MIN) s.width = HALL_SIDE_MIN;
    if (s.height < HALL_SIDE_MIN) s.height = HALL_SIDE_MIN;
    return s;
}

/* ---- Showing --------------------------------------------------------------------------------- */

static bool need_rgb(struct easel *e, size_t n_pixels)
{
    if (n_pixels <= e->rgb_pixels) return true;
    free(e->rgb);
    e->rgb = malloc(n_pixels * 3);
    e->rgb_pixels = e->rgb ? n_pixels : 0;
    return e->rgb != NULL;
}

static double median(const double *x, uint32_t n)
{
    double sorted[STATS_KEPT];
    if (n == 0) return 0;
    for (uint32_t i = 0; i < n; i++) {
        uint32_t k = i;
        for (; k > 0 && sorted[k - 1] > x[i]; k--) sorted[k] = sorted[k - 1];
        sorted[k] = x[i];
    }
    return sorted[n / 2];
}

static void note_times(struct easel *e, const struct picture_header *h)
{
    const uint32_t at = e->n_timed++ % STATS_KEPT;
    e->frame_s[at] = hall_clock_s();
    e->render_ms[at] = h->render_ms;
    e->encode_ms[at] = h->encode_ms;
    e->stats.version = h->version;
    e->stats.width = h->width;
    e->stats.height = h->height;
}

/* An image as a frame of a layer. `tone` and exposure are the page's, or those of data. */
static void show(struct easel *e, const lmn_image *image, struct picture_header h, double exposure,
                 uint32_t tone, struct easel_result *out)
{
    const double start = hall_clock_s();
    h.version = e->wish.version;
    h.width = lmn_image_width(image);
    h.height = lmn_image_height(image);
    h.full_width = e->wish.width;
    h.full_height = e->wish.height;
    h.encoding = ENCODING_JPEG;
    if (!need_rgb(e, (size_t)h.width * h.height) ||
        lmn_image_tone(e->options->context, image, exposure, tone, e->rgb) != LMN_OK)
        return;
    out->parcel = encode_jpeg(&h, e->rgb, e->wish.is_moving);
    if (!out->parcel.memory) return;
    h.encode_ms = 1e3 * (hall_clock_s() - start);
    picture_header_write(&h, out->parcel.memory + PARCEL_ROOM);
    out->has_frame = true;
    out->layer = (enum layer)h.layer;
    note_times(e, &h);
}

/* ---- One call's work ------------------------------------------------------------------------- */

/* A smaller picture for now: moving ones, and the first of a state that takes long. */
static lmn_status draw_small(struct easel *e, enum layer layer, double seconds, uint32_t frame,
                             struct easel_result *out)
{
    const bool is_neural = layer == LAYER_NEURAL;
    lmn_image *image = NULL;
    double render_s = 0;
    struct stroke s = moving_size(&e->wish, is_neural ? e->cost_neural : 2 * e->cost_traced,
                                  seconds);
    if (!is_neural) s.spp = 2;
    const lmn_status status = (is_neural ? draw_neural : draw_traced)(e, &s, &image, &render_s);
    if (status != LMN_OK) return status;
    const struct picture_header h = {
        .layer = (uint8_t)layer, .frame = frame, .spp = s.spp, .render_ms = 1e3 * render_s};
    show(e, image, h, e->wish.exposure, e->wish.tone, out);
    lmn_image_free(image);
    e->is_shown[layer] = true;
    e->is_done[layer] = e->wish.is_moving;
    return LMN_OK;
}

/* More samples of a picture at rest. It is shown when it has doubled, or nearly enough. */
static lmn_status refine(struct easel *e, enum layer layer, uint32_t frame,
                         struct easel_result *out)
{
    const bool is_neural = layer == LAYER_NEURAL;
    struct canvas *c = is_neural ? &e->neural : &e->traced;
    const uint32_t most = is_neural ? NEURAL_SPP : TRACED_SPP;
    const double n_pixels = (double)e->wish.width * e->wish.height;
    double render_s = 0;
    lmn_image *image = NULL;
    if (is_neural && is_outdated(e)) {
        lmn_train_stats stats;
        lmn_trainer_get_stats(e->options->trainer, &stats);
        canvas_clear(c);
        e->step = stats.step;
    }
    if (c->spp < most) {
        const double per_sample = n_pixels * (is_neural ? e->cost_neural : e->cost_traced);
        double spp = fmin(fmax(floor(PASS_S / fmax(per_sample, 1e-9)), 1), most - c->spp);
        if (!is_neural) spp = fmax(2 * floor(spp / 2), 2); /* parts begin at even numbers */
        if (c->spp == 0 && is_neural) spp = 1;
        const struct stroke s = {e->wish.width, e->wish.height, (uint32_t)spp, c->spp};
        const lmn_status status = (is_neural ? draw_neural : draw_traced)(e, &s, &image, &render_s);
        if (status != LMN_OK) return status;
        canvas_add(c, image, s.spp);
    }
    struct picture_header h = {.layer = (uint8_t)layer,
                               .frame = frame,
                               .spp = c->spp,
                               .is_final = c->spp >= most,
                               .render_ms = 1e3 * render_s};
    e->is_done[layer] = h.is_final;
    e->is_shown[layer] = true;
    if (is_wished(e, layer)) show(e, c->image, h, e->wish.exposure, e->wish.tone, out);
    return LMN_OK;
}

/* Values as colours: normals and positions from their ranges to [0,1], depth by the scene's size.
 */
static void color_buffer(const struct easel *e, lmn_image *image)
{
    static const uint32_t firsts[SHOWN_BUFFERS] = {12, 6, 3, 15, 25, 22};
    const enum shown_buffer shown = e->wish.buffer;
    const size_t n = (size_t)lmn_image_width(image) * lmn_image_height(image);
    const uint32_t stride = lmn_image_n_channels(image), first = firsts[shown];
    lmn_scene_info info;
    float size = 0;
    lmn_scene_get_info(e->options->scene, &info);
    for (int c = 0; c < 3; c++) size = fmaxf(size, info.bounds_max[c] - info.bounds_min[c]);
    float *p = lmn_image_data(image);
    for (size_t i = 0; i < n; i++, p += stride)
        for (uint32_t c = 0; c < 3; c++) {
            const bool is_one = shown == SHOWN_ROUGHNESS || shown == SHOWN_DEPTH;
            float x = p[first + (is_one ? 0 : c)];
            if (shown == SHOWN_NORMAL) x = 0.5f + 0.5f * x;
            if (shown == SHOWN_POSITION) x = (x - info.bounds_min[c]) / fmaxf(size, 1e-20f);
            if (shown == SHOWN_DEPTH) x /= fmaxf(size, 1e-20f);
            p[c] = x;
        }
}

static lmn_status draw_buffer(struct easel *e, uint32_t frame, struct easel_result *out)
{
    const bool is_light = e->wish.buffer == SHOWN_EMISSION;
    lmn_image *image = NULL;
    double render_s = 0;
    struct stroke s = {e->wish.width, e->wish.height, BUFFER_SPP, 0};
    if (e->wish.is_moving) s = moving_size(&e->wish, 0.2 * e->cost_neural, 1 / e->wish.rate);
    const lmn_status status = draw_buffers(e, &s, NULL, &image, &render_s);
    if (status != LMN_OK) return status;
    color_buffer(e, image);
    const struct picture_header h = {.layer = LAYER_BUFFER,
                                     .frame = frame,
                                     .spp = s.spp,
                                     .is_final = !e->wish.is_moving,
                                     .render_ms = 1e3 * render_s};
    show(e, image, h, is_light ? e->wish.exposure : 1.0, is_light ? e->wish.tone : LMN_TONE_SRGB,
         out);
    lmn_image_free(image);
    e->is_shown[LAYER_BUFFER] = e->is_done[LAYER_BUFFER] = true;
    return LMN_OK;
}

static lmn_status compare(struct easel *e, uint32_t frame, struct easel_result *out)
{
    lmn_image *map = NULL;
    lmn_metrics metrics;
    const double start = hall_clock_s();
    const lmn_status status = lmn_image_compare(e->options->context, e->neural.image,
                                                e->traced.image, &metrics, &map);
    if (status != LMN_OK) return status;
    const struct picture_header h = {.layer = LAYER_ERROR,
                                     .frame = frame,
                                     .spp = e->traced.spp,
                                     .is_final = e->traced.spp >= TRACED_SPP,
                                     .render_ms = 1e3 * (hall_clock_s() - start)};
    e->compared_spp = e->traced.spp;
    e->is_shown[LAYER_ERROR] = true;
    e->is_done[LAYER_ERROR] = h.is_final;
    show(e, map, h, 1.0, LMN_TONE_SRGB, out);
    out->metrics = message_metrics(e->wish.version, e->neural.spp, e->traced.spp, &metrics);
    lmn_image_free(map);
    return LMN_OK;
}

/* What is most wanted: new layers in the page's order; then the picture with fewer samples. */
static lmn_status draw_next(struct easel *e, uint32_t frame, struct easel_result *out)
{
    const struct wish *w = &e->wish;
    uint32_t n_pictures = 0;
    for (uint32_t i = 0; i < w->n_layers; i++) n_pictures += w->layers[i] != LAYER_ERROR;
    const double share_s = 1 / w->rate / (n_pictures > 0 ? n_pictures : 1);
    for (uint32_t i = 0; i < w->n_layers; i++) {
        const enum layer layer = w->layers[i];
        const double first_s = e->cost_traced * 2 * w->width * w->height;
        if (e->is_shown[layer] || layer == LAYER_ERROR) continue;
        if (layer == LAYER_BUFFER) return draw_buffer(e, frame, out);
        if (w->is_moving) return draw_small(e, layer, share_s, frame, out);
        if (layer == LAYER_TRACED && !e->traced.image && first_s > PASS_S)
            return draw_small(e, layer, PASS_S, frame, out);
        return refine(e, layer, frame, out);
    }
    if (is_needed(e, LAYER_ERROR) && is_wanted_now(e, LAYER_ERROR) && e->neural.spp >= 4 &&
        e->traced.spp >= 2 * e->compared_spp + 2)
        return compare(e, frame, out);
    const bool neural = is_needed(e, LAYER_NEURAL) && (!e->is_done[LAYER_NEURAL] || is_outdated(e));
    const bool traced = is_needed(e, LAYER_TRACED) && !e->is_done[LAYER_TRACED];
    if (neural && (!traced || e->neural.spp <= e->traced.spp))
        return refine(e, LAYER_NEURAL, frame, out);
    if (traced) return refine(e, LAYER_TRACED, frame, out);
    if (is_needed(e, LAYER_ERROR) && !e->is_done[LAYER_ERROR]) return compare(e, frame, out);
    return LMN_OK;
}

void easel_draw(struct easel *e, uint32_t frame, struct easel_result *out)
{
    *out = (struct easel_result){0};
    const lmn_status status = draw_next(e, frame, out);
    if (status == LMN_OK || status == LMN_ERR_CANCELLED) return;
    /* Nothing more can come of this state. */
    out->error = message_error(lmn_context_message(e->options->context));
    for (int k = 0; k < LAYERS; k++) e->is_shown[k] = e->is_done[k] = true;
}

void easel_get_stats(const struct easel *e, struct view_stats *out)
{
    const uint32_t n = e->n_timed < STATS_KEPT ? e->n_timed : STATS_KEPT;
    const double now = hall_clock_s();
    double first = now;
    uint32_t n_late = 0;
    *out = e->stats;
    for (uint32_t i = 0; i < n; i++)
        if (now - e->frame_s[i] < 2) {
            n_late++;
            first = fmin(first, e->frame_s[i]);
        }
    out->fps = now - first > 0.05 ? n_late / (now - first) : 0;
    out->render_ms = median(e->render_ms, n);
    out->encode_ms = median(e->encode_ms, n);
    out->has_camera = e->has_wish && !e->wish.has_camera &&
                      lmn_scene_get_camera(e->options->context, e->options->scene, e->wish.values,
                                           &out->camera) == LMN_OK;
    out->neural_spp = e->neural.spp;
    out->traced_spp = e->traced.spp;
    if (e->options->model) {
        lmn_model_get_times(e->options->model, &out->buffers_ms, &out->network_ms);
        out->buffers_ms *= 1e3;
        out->network_ms *= 1e3;
    }
}

/* ---- What pages ask for once ----------------------------------------------------------------- */

static void add_readout(struct readout *list, uint32_t *n, const char *name, const float *values,
                        uint32_t n_values)
{
    struct readout *r = &list[(*n)++];
    r->name = name;
    r->n = n_values;
    memcpy(r->values, values, n_values * sizeof *values);
}

static const float *pixel_of(const struct canvas *c, uint32_t x, uint32_t y)
{
    return lmn_image_data(c->image) + ((size_t)y * lmn_image_width(c->image) + x) * 3;
}

char *easel_read_pixel(struct easel *e, uint32_t id, uint32_t x, uint32_t y)
{
    const struct wish *w = &e->wish;
    struct readout list[10];
    uint32_t n = 0;
    lmn_image *image = NULL;
    if (!e->has_wish || x >= w->width || y >= w->height)
        return message_error("\"pixel\": outside the picture");
    const struct stroke s = {w->width, w->height, 16, 0};
    if (draw_buffers(e, &s, (uint32_t[2]){x, y}, &image, NULL) != LMN_OK)
        return message_error(lmn_context_message(e->options->context));
    const float *b = lmn_image_data(image);
    if (e->neural.image) add_readout(list, &n, "neural", pixel_of(&e->neural, x, y), 3);
    if (e->traced.image) add_readout(list, &n, "traced", pixel_of(&e->traced, x, y), 3);
    add_readout(list, &n, "position", b + 3, 3);
    add_readout(list, &n, "normal", b + 6, 3);
    add_readout(list, &n, "albedo", b + 12, 3);
    add_readout(list, &n, "roughness", b + 15, 1);
    add_readout(list, &n, "wo", b + 16, 3);
    add_readout(list, &n, "depth", b + 25, 1);
    add_readout(list, &n, "shape", b + 26, 1);
    char *text = message_pixel(id, w->version, x, y, list, n);
    lmn_image_free(image);
    return text;
}

/* The network's file is that of `lumenaut render`; a traced one is what the page shows. */
char *easel_capture(struct easel *e, uint32_t id, enum layer layer, enum capture_format format,
                    struct parcel *file)
{
    static const char *const names[2][2] = {{"neural.png", "neural.exr"},
                                            {"traced.png", "traced.exr"}};
    const bool is_neural = layer == LAYER_NEURAL;
    const lmn_render_options o = {.struct_size = sizeof o,
                                  .width = e->wish.width,
                                  .height = e->wish.height,
                                  .camera = e->wish.has_camera ? &e->wish.camera : NULL};
    lmn_image *image = NULL;
    if (!e->has_wish) return message_capture(id, 0, NULL, "there is no picture yet");
    if (!is_neural && !e->traced.image)
        return message_capture(id, 0, NULL, "no path-traced picture at rest to save yet");
    if (is_neural &&
        (e->options->trainer
             ? lmn_trainer_render(e->options->trainer, e->wish.values, &o, &image, NULL)
             : lmn_model_render(e->options->context, e->options->model, e->wish.values, &o, &image,
                                NULL)) != LMN_OK)
        return message_capture(id, 0, NULL, lmn_context_message(e->options->context));
    const struct picture_header h = {.layer = LAYER_FILE,
                                     .encoding = format == CAPTURE_PNG ? ENCODING_PNG
                                                                       : ENCODING_EXR,
                                     .is_final = true,
                                     .frame = id,
                                     .version = e->wish.version,
                                     .width = e->wish.width,
                                     .height = e->wish.height,
                                     .full_width = e->wish.width,
                                     .full_height = e->wish.height,
                                     .spp = is_neural ? 16 : e->traced.spp};
    *file = encode_file(e->options->context, is_neural ? image : e->traced.image, e->wish.exposure,
                        format, &h);
    lmn_image_free(image);
    if (!file->memory) return message_capture(id, 0, NULL, "the file could not be made");
    return message_capture(id, file->size - HALL_HEADER, names[!is_neural][format], NULL);
}
