/* SPDX-License-Identifier: Apache-2.0 */
/* Public images. */
#include "api/handles.h"

#include <string.h>

#include "base/mem.h"
#include "image/draw.h"
#include "image/metrics.h"
#include "image/tone.h"

lmn_status image_handle(struct image *image, lmn_image **out, struct error *err)
{
    lmn_image *handle = mem_new(1, sizeof *handle);
    if (!handle) return fail_memory(err, "an image");
    handle->image = *image;
    *image = (struct image){0};
    *out = handle;
    return LMN_OK;
}

lmn_status lmn_image_new(lmn_context *context, uint32_t width, uint32_t height, uint32_t n_channels,
                         const char *const *names, lmn_image **out)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    struct image image = {0};
    *out = NULL;
    TRY(image_init(&image, width, height, n_channels, names, err));
    TRY(image_handle(&image, out, err));
done:
    image_release(&image);
    return status;
}

void lmn_image_free(lmn_image *image)
{
    if (!image) return;
    image_release(&image->image);
    mem_free(image);
}

uint32_t lmn_image_width(const lmn_image *image)
{
    return image->image.width;
}

uint32_t lmn_image_height(const lmn_image *image)
{
    return image->image.height;
}

uint32_t lmn_image_n_channels(const lmn_image *image)
{
    return image->image.n_channels;
}

const char *lmn_image_channel_name(const lmn_image *image, uint32_t channel)
{
    return channel < image->image.n_channels ? image->image.names[channel] : NULL;
}

float *lmn_image_data(lmn_image *image)
{
    return image->image.data;
}

lmn_status lmn_image_set_attribute(lmn_context *context, lmn_image *image, const char *name,
                                   const char *value)
{
    return image_set_attribute(&image->image, name, value, context_begin(context));
}

const char *lmn_image_attribute(const lmn_image *image, const char *name)
{
    for (uint32_t i = 0; i < image->image.n_attributes; i++)
        if (strcmp(image->image.attributes[i].name, name) == 0)
            return image->image.attributes[i].value;
    return NULL;
}

lmn_status lmn_image_load(lmn_context *context, const char *path, lmn_image **out)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    struct image image = {0};
    *out = NULL;
    TRY(image_load(path, &image, err));
    TRY(image_handle(&image, out, err));
done:
    image_release(&image);
    return status;
}

lmn_status lmn_image_save(lmn_context *context, const lmn_image *image, const char *path,
                          const char *format, double exposure)
{
    return image_save(&image->image, path, format, exposure, context_begin(context));
}

lmn_status lmn_image_compare(lmn_context *context, const lmn_image *test,
                             const lmn_image *reference, lmn_metrics *out, lmn_image **error_map)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    struct image map = {0};
    if (error_map) *error_map = NULL;
    TRY(metrics_compare(&test->image, &reference->image, out, error_map ? &map : NULL, err));
    if (error_map) TRY(image_handle(&map, error_map, err));
done:
    image_release(&map);
    return status;
}

/* Many comparisons for the pool's workers. */
struct comparisons {
    const lmn_image *const *tests, *const *references;
    lmn_metrics *out;
    lmn_status *statuses; /* [n] */
    struct error *errors; /* [n] */
};

static void compare_one(void *ctx, uint32_t i, uint32_t worker)
{
    const struct comparisons *c = ctx;
    (void)worker;
    c->statuses[i] = metrics_compare(&c->tests[i]->image, &c->references[i]->image, &c->out[i],
                                     NULL, &c->errors[i]);
}

lmn_status lmn_image_compare_all(lmn_context *context, uint32_t n, const lmn_image *const *tests,
                                 const lmn_image *const *references, lmn_metrics *out)
{
    struct error *err = context_begin(context);
    lmn_status status = LMN_OK;
    struct comparisons c = {.tests = tests,
                            .references = references,
                            .out = out,
                            .statuses = mem_new(n, sizeof *c.statuses),
                            .errors = mem_new(n, sizeof *c.errors)};
    if (!c.statuses || !c.errors) {
        status = fail_memory(err, "comparing images");
        goto done;
    }
    pool_run(context->pool, n, compare_one, &c);
    for (uint32_t i = 0; i < n && status == LMN_OK; i++) {
        status = c.statuses[i];
        if (status != LMN_OK) *err = c.errors[i];
    }
done:
    mem_free(c.statuses);
    mem_free(c.errors);
    return status;
}

lmn_status lmn_image_sheet(lmn_context *context, const lmn_sheet *sheet, lmn_image **out)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    struct image drawn = {0};
    lmn_sheet s;
    const struct image **images = NULL;
    struct draw_sheet_row *rows = NULL;
    *out = NULL;
    TRY(options_copy("lmn_sheet", sheet, &s, sizeof s, err));
    if (s.n_rows == 0 || s.n_columns == 0 || s.n_pictures > s.n_columns) {
        status = fail(err, LMN_ERR_ARGUMENT, "a sheet of %u rows and %u columns, %u of pictures",
                      s.n_rows, s.n_columns, s.n_pictures);
        goto done;
    }
    images = mem_new((size_t)s.n_rows * s.n_columns, sizeof *images);
    rows = mem_new(s.n_rows, sizeof *rows);
    if (!images || !rows) {
        status = fail_memory(err, "the contact sheet");
        goto done;
    }
    for (uint32_t r = 0; r < s.n_rows; r++) {
        const size_t first = (size_t)r * s.n_columns;
        for (uint32_t c = 0; c < s.n_columns; c++) images[first + c] = &s.images[first + c]->image;
        rows[r] = (struct draw_sheet_row){
            .images = images + first, .exposure = s.exposures[r], .caption = s.captions[r]};
    }
    const struct draw_sheet inside = {.rows = rows,
                                      .n_rows = s.n_rows,
                                      .n_columns = s.n_columns,
                                      .n_pictures = s.n_pictures,
                                      .headings = s.headings};
    TRY(draw_sheet(&inside, &drawn, err));
    TRY(image_handle(&drawn, out, err));
done:
    image_release(&drawn);
    mem_free(images);
    mem_free(rows);
    return status;
}

lmn_status lmn_image_tone(lmn_context *context, const lmn_image *image, double exposure,
                          uint32_t tone, uint8_t *rgb)
{
    struct error *err = context_begin(context);
    const struct image *im = &image->image;
    struct tone table;
    if (im->n_channels < 3)
        return fail(err, LMN_ERR_ARGUMENT, "tone: %u channels; three or more are needed",
                    im->n_channels);
    if (tone > LMN_TONE_ACES) return fail(err, LMN_ERR_ARGUMENT, "tone %u: 0 or 1", tone);
    if (!(exposure >= 0.0 && exposure <= 1e9))
        return fail(err, LMN_ERR_ARGUMENT, "exposure %g: 0 to 1e9", exposure);
    tone_init(&table);
    tone_apply(&table, context->pool, im->data, (size_t)im->width * im->height, im->n_channels,
               (float)exposure, tone == LMN_TONE_ACES ? TONE_ACES : TONE_SRGB, rgb);
    return LMN_OK;
}
