/* SPDX-License-Identifier: Apache-2.0 */
#include "image/image.h"

#include <math.h>
#include <string.h>

#include "base/mem.h"

static const char *const default_names[4][4] = {
    {"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};

lmn_status image_init(struct image *im, uint32_t width, uint32_t height, uint32_t n_channels,
                      const char *const *names, struct error *err)
{
    *im = (struct image){0};
    if (width < 1 || height < 1 || width > IMAGE_MAX_SIDE || height > IMAGE_MAX_SIDE)
        return fail(err, LMN_ERR_ARGUMENT, "image of %ux%u pixels: sides must be 1 to %d", width,
                    height, IMAGE_MAX_SIDE);
    if (n_channels < 1 || n_channels > IMAGE_MAX_CHANNELS)
        return fail(err, LMN_ERR_ARGUMENT, "image of %u channels: must be 1 to %d", n_channels,
                    IMAGE_MAX_CHANNELS);
    if (!names && n_channels > 4)
        return fail(err, LMN_ERR_ARGUMENT, "image of %u channels needs their names", n_channels);
    if (!names) names = default_names[n_channels - 1];
    for (uint32_t c = 0; c < n_channels; c++) {
        size_t length = strlen(names[c]);
        if (length < 1 || length >= IMAGE_NAME_SIZE)
            return fail(err, LMN_ERR_ARGUMENT,
                        "image channel name \"%.60s\": must have 1 to %d letters", names[c],
                        IMAGE_NAME_SIZE - 1);
        for (uint32_t d = 0; d < c; d++)
            if (strcmp(names[c], names[d]) == 0)
                return fail(err, LMN_ERR_ARGUMENT, "image has two channels named \"%s\"", names[c]);
    }
    im->names = mem_new(n_channels, sizeof *im->names);
    im->data = mem_new((size_t)width * height * n_channels, sizeof *im->data);
    if (!im->names || !im->data) {
        image_release(im);
        return fail(err, LMN_ERR_MEMORY, "not enough memory for an image of %ux%u pixels", width,
                    height);
    }
    im->width = width;
    im->height = height;
    im->n_channels = n_channels;
    for (uint32_t c = 0; c < n_channels; c++) strcpy(im->names[c], names[c]);
    return LMN_OK;
}

void image_release(struct image *im)
{
    for (uint32_t i = 0; i < im->n_attributes; i++) {
        mem_free(im->attributes[i].name);
        mem_free(im->attributes[i].value);
    }
    mem_free(im->attributes);
    mem_free(im->names);
    mem_free(im->data);
    *im = (struct image){0};
}

lmn_status image_set_attribute(struct image *im, const char *name, const char *value,
                               struct error *err)
{
    uint32_t i = 0, n = im->n_attributes;
    while (i < n && strcmp(im->attributes[i].name, name) != 0) i++;
    char *copy = mem_strdup(value);
    if (!copy) return fail_memory(err, "an image attribute");
    if (i < n) {
        mem_free(im->attributes[i].value);
        im->attributes[i].value = copy;
        return LMN_OK;
    }
    /* Few and rarely added: one block of exactly n + 1 keeps the struct small. */
    struct image_attribute *more = mem_new(n + 1, sizeof *more);
    char *key = mem_strdup(name);
    if (!more || !key) {
        mem_free(more);
        mem_free(key);
        mem_free(copy);
        return fail_memory(err, "an image attribute");
    }
    if (n) memcpy(more, im->attributes, n * sizeof *more);
    more[n] = (struct image_attribute){key, copy};
    mem_free(im->attributes);
    im->attributes = more;
    im->n_attributes = n + 1;
    return LMN_OK;
}

int image_channel(const struct image *im, const char *name)
{
    for (uint32_t c = 0; c < im->n_channels; c++)
        if (strcmp(im->names[c], name) == 0) return (int)c;
    return -1;
}
