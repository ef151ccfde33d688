/* SPDX-License-Identifier: Apache-2.0 */
#include "train/painter.h"

#include <string.h>

#include "base/clock.h"
#include "base/mem.h"
#include "train/inputs.h"

lmn_status painter_init(struct painter *p, const struct workplace *place,
                        struct generator *generator, struct error *err)
{
    const size_t n = PAINTER_PIXELS;
    *p = (struct painter){.place = place, .generator = generator};
    p->v = mem_new(place->scene->n_variables, sizeof *p->v);
    p->buffers = mem_new(n, sizeof(float[BUFFER_CHANNELS]));
    p->inputs = mem_new(n, sizeof(float[GENERATOR_INPUTS]));
    p->color = mem_new(n, sizeof(float[3]));
    lmn_status status = LMN_OK;
    if (p->v && p->buffers && p->inputs && p->color)
        status = view_new(place->world, &p->view, err);
    else
        status = fail_memory(err, "rendering by the network");
    if (status != LMN_OK) painter_release(p);
    p->memory_size = n * sizeof(float[BUFFER_CHANNELS + GENERATOR_INPUTS + 3]);
    return status;
}

void painter_release(struct painter *p)
{
    view_free(p->view);
    mem_free(p->v);
    mem_free(p->buffers);
    mem_free(p->inputs);
    mem_free(p->color);
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
    inputs_from_buffers(p->place->scene, p->buffers, n, p->inputs);
    if (n_channels == 3) {
        generator_render(p->generator, p->inputs, p->v, n, rows);
        return LMN_OK;
    }
    generator_render(p->generator, p->inputs, p->v, n, p->color);
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
    inputs_variables(p->place->scene, u, p->v);

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
