/* SPDX-License-Identifier: Apache-2.0 */
#include "train/painter.h"

#include <string.h>

#include "base/clock.h"
#include "base/mem.h"
#include "train/inputs.h"

lmn_status painter_init(struct painter *p, const struct workplace *place,
                        const struct painter_network *network, struct error *err)
{
    const size_t n = PAINTER_PIXELS;
    const struct sight *sight = network->sight;
    *p = (struct painter){.place = place, .network = *network};
    p->v = mem_new(place->scene->n_variables, sizeof *p->v);
    p->buffers = mem_new(n, sizeof(float[BUFFER_CHANNELS]));
    p->color = mem_new(n, sizeof(float[3]));
    bool has_inputs;
    if (network->field) {
        const size_t n_each = 3 * (size_t)sight->n_positions + sight->n_features + 3;
        p->positions = mem_new(n * sight->n_positions, sizeof(float[3]));
        p->features = mem_new(n * sight->n_features, sizeof(float));
        p->scale = mem_new(n, sizeof(float[3]));
        p->memory_size = n * n_each * sizeof(float);
        has_inputs = p->positions && p->features && p->scale;
    } else {
        p->inputs = mem_new(n, sizeof(float[GENERATOR_INPUTS]));
        p->memory_size = n * sizeof(float[GENERATOR_INPUTS]);
        has_inputs = p->inputs != NULL;
    }
    lmn_status status = LMN_OK;
    if (p->v && p->buffers && has_inputs && p->color)
        status = view_new(place->world, &p->view, err);
    else
        status = fail_memory(err, "rendering by the network");
    if (status != LMN_OK) painter_release(p);
    p->memory_size += n * sizeof(float[BUFFER_CHANNELS + 3]);
    return status;
}

void painter_release(struct painter *p)
{
    view_free(p->view);
    mem_free(p->v);
    mem_free(p->buffers);
    mem_free(p->inputs);
    mem_free(p->color);
    mem_free(p->positions);
    mem_free(p->features);
    mem_free(p->scale);
    *p = (struct painter){0};
}

static lmn_status new_image(const struct model_render_options *options, struct image *out,
                            struct error *err)
{
    const char *names[3 + BUFFER_CHANNELS] = {"R", "G", "B"};
    for (int i = 0; i < BUFFER_CHANNELS; i++) names[3 + i] = buffer_channel_names[i];
    const struct window *w = &options->window;
    return image_init(out, w->width, w->height, options->with_buffers ? 3 + BUFFER_CHANNELS : 3,
                      names, err);
}

/* color [n][3] from the strip's buffers. */
static void paint_pixels(struct painter *p, size_t n, float *color)
{
    if (p->network.generator) {
        inputs_from_buffers(p->place->scene, p->buffers, n, p->inputs);
        generator_render(p->network.generator, p->inputs, p->v, n, color);
        return;
    }
    const struct field_run run = {.n = (uint32_t)n,
                                  .positions = p->positions,
                                  .features = p->features,
                                  .scale = p->scale,
                                  .v = p->v};
    sight_look_parallel(p->network.sight, p->place->pool, view_state(p->view), p->buffers, run.n,
                        p->positions, p->features, p->scale);
    field_render(p->network.field, &run, color);
    sight_add_emission(p->buffers, run.n, color);
}

/* One strip of the window, into its rows of the image. */
static lmn_status paint_strip(struct painter *p, const struct trace_settings *settings,
                              const struct window *strip, float *rows, uint32_t n_channels,
                              struct error *err)
{
    size_t n = (size_t)strip->width * strip->height;
    struct trace_output output = {.buffers = p->buffers};
    lmn_status status = view_trace_parallel(p->view, p->place->pool, settings, strip, &output, NULL,
                                            NULL, err);
    if (status != LMN_OK) return status;
    if (n_channels == 3) {
        paint_pixels(p, n, rows);
        return LMN_OK;
    }
    paint_pixels(p, n, p->color);
    for (size_t i = 0; i < n; i++) {
        memcpy(rows + i * n_channels, p->color + 3 * i, sizeof(float[3]));
        memcpy(rows + i * n_channels + 3, p->buffers + i * BUFFER_CHANNELS,
               sizeof(float[BUFFER_CHANNELS]));
    }
    return LMN_OK;
}

lmn_status painter_render(struct painter *p, const float *u,
                          const struct model_render_options *options, struct image *out,
                          double *render_s, lmn_progress_fn *progress, void *progress_user,
                          struct error *err)
{
    lmn_status status = LMN_OK;
    struct image im = {0};
    const struct window *w = &options->window;
    double start = clock_wall_s();
    if (w->width == 0 || w->height == 0 || w->width > PAINTER_PIXELS || w->width > w->full_width ||
        w->x > w->full_width - w->width || w->height > w->full_height ||
        w->y > w->full_height - w->height) {
        status = fail(err, LMN_ERR_ARGUMENT,
                      "cannot render %ux%u pixels at (%u, %u) of a picture of %ux%u", w->width,
                      w->height, w->x, w->y, w->full_width, w->full_height);
        goto done;
    }
    TRY(new_image(options, &im, err));

    struct trace_settings settings;
    trace_settings_init(&settings, p->place->scene);
    settings.spp = options->buffer_spp > 0 ? options->buffer_spp : PAINTER_BUFFER_SPP;
    settings.seed = options->seed;
    view_set(p->view, u);
    if (p->network.generator)
        inputs_variables(p->place->scene, u, p->v);
    else
        sight_variables(p->network.sight, u, p->v);

    uint32_t most = PAINTER_PIXELS / w->width;
    for (uint32_t y = 0; y < w->height;) {
        struct window strip = *w;
        strip.y = w->y + y;
        strip.height = w->height - y < most ? w->height - y : most;
        float *rows = im.data + (size_t)y * w->width * im.n_channels;
        TRY(paint_strip(p, &settings, &strip, rows, im.n_channels, err));
        y += strip.height;
        if (progress && progress(progress_user, y, w->height) != 0) {
            status = fail(err, LMN_ERR_CANCELLED, "rendering was stopped");
            goto done;
        }
    }
    if (render_s) *render_s = clock_wall_s() - start;
    *out = im;
    im = (struct image){0};
done:
    image_release(&im);
    return status;
}
