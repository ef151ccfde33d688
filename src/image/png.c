/* SPDX-License-Identifier: Apache-2.0 */
/* PNG through libpng, from and to memory. libpng leaves by longjmp on errors, so each direction
 * keeps its state in a struct outside the frame that calls setjmp. */
#include "image/codecs.h"

#include <setjmp.h>
#include <string.h>

#include <png.h>

#include "base/mem.h"
#include "image/tone.h"

bool png_is(const void *bytes, size_t size)
{
    return size >= 8 && memcmp(bytes, "\x89PNG\r\n\x1a\n", 8) == 0;
}

struct codec {
    jmp_buf leave;
    char message[128];
    png_structp png;
    png_infop info;
    uint8_t *samples; /* rows top first; native 16 bit when reading those */
    png_bytepp rows;
    /* reading */
    const char *bytes;
    size_t size, at;
    /* writing */
    struct str *out;
};

static void on_error(png_structp png, png_const_charp message)
{
    struct codec *c = png_get_error_ptr(png);
    strncpy(c->message, message, sizeof c->message - 1);
    longjmp(c->leave, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

static png_voidp allocate(png_structp png, png_alloc_size_t size)
{
    (void)png;
    return mem_new(size, 1);
}

static void release(png_structp png, png_voidp block)
{
    (void)png;
    mem_free(block);
}

static void on_read(png_structp png, png_bytep to, size_t size)
{
    struct codec *c = png_get_io_ptr(png);
    if (size > c->size - c->at) png_error(png, "file is truncated");
    memcpy(to, c->bytes + c->at, size);
    c->at += size;
}

static void on_write(png_structp png, png_bytep from, size_t size)
{
    struct codec *c = png_get_io_ptr(png);
    str_add_bytes(c->out, from, size);
    if (c->out->failed) png_error(png, "not enough memory");
}

static void on_flush(png_structp png)
{
    (void)png;
}

/* rows[y] = start of row y. */
static bool make_rows(struct codec *c, uint32_t height, size_t row_size)
{
    c->samples = mem_new(height, row_size);
    c->rows = mem_new(height, sizeof *c->rows);
    if (!c->samples || !c->rows) return false;
    for (uint32_t y = 0; y < height; y++) c->rows[y] = c->samples + y * row_size;
    return true;
}

static void release_codec(struct codec *c)
{
    mem_free(c->samples);
    mem_free(c->rows);
}

/* ---- Reading ------------------------------------------------------------------------------ */

/* Reads up to the pixels. False: libpng failed. */
static bool read_header(struct codec *c)
{
    if (setjmp(c->leave)) return false;
    png_set_read_fn(c->png, c, on_read);
    png_set_user_limits(c->png, 0x7fffffff, 0x7fffffff); /* codec_check_size() is who refuses */
    png_set_chunk_malloc_max(c->png, 1 << 20);
    png_set_chunk_cache_max(c->png, 256);
    png_read_info(c->png, c->info);
    return true;
}

/* Asks for 1 to 4 channels of 8 or 16 bits. */
static bool set_transforms(struct codec *c)
{
    if (setjmp(c->leave)) return false;
    png_set_expand(c->png); /* palette to RGB, 1 2 4 bits to 8, transparency to alpha */
    if (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__) png_set_swap(c->png);
    png_set_interlace_handling(c->png);
    png_read_update_info(c->png, c->info);
    return true;
}

static bool read_rows(struct codec *c)
{
    if (setjmp(c->leave)) return false;
    png_read_image(c->png, c->rows);
    png_read_end(c->png, c->info);
    return true;
}

static lmn_status copy_text(struct codec *c, struct image *im, struct error *err)
{
    png_textp text = NULL;
    int n = 0;
    png_get_text(c->png, c->info, &text, &n);
    for (int i = 0; i < n; i++) {
        const char *value = text[i].text ? text[i].text : "";
        lmn_status status = image_set_attribute(im, text[i].key, value, err);
        if (status != LMN_OK) return status;
    }
    return LMN_OK;
}

lmn_status png_decode(const char *path, const void *bytes, size_t size, struct bitmap *out,
                      struct image *text, struct error *err)
{
    lmn_status status = LMN_OK;
    struct codec c = {.bytes = bytes, .size = size};
    struct bitmap b = {.is_srgb = true};
    c.png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &c, on_error, on_warning, NULL,
                                     allocate, release);
    c.info = c.png ? png_create_info_struct(c.png) : NULL;
    if (!c.info) {
        status = fail_memory(err, path);
        goto done;
    }
    if (!read_header(&c)) goto failed;
    b.width = png_get_image_width(c.png, c.info);
    b.height = png_get_image_height(c.png, c.info);
    TRY(codec_check_size(path, b.width, b.height, png_get_channels(c.png, c.info), 1,
                         size * 8 / png_get_bit_depth(c.png, c.info), err));
    if (!set_transforms(&c)) goto failed;
    b.n_channels = png_get_channels(c.png, c.info);
    TRY(codec_check_size(path, b.width, b.height, b.n_channels, 1, UINT32_MAX, err));
    if (!make_rows(&c, b.height, png_get_rowbytes(c.png, c.info))) {
        status = fail_memory(err, path);
        goto done;
    }
    if (!read_rows(&c)) goto failed;
    if (png_get_bit_depth(c.png, c.info) == 16) {
        size_t n = (size_t)b.width * b.height * b.n_channels;
        const uint16_t *from = (const uint16_t *)c.samples;
        b.f32 = mem_new(n, sizeof *b.f32);
        if (!b.f32) {
            status = fail_memory(err, path);
            goto done;
        }
        for (size_t i = 0; i < n; i++) b.f32[i] = (float)from[i] / 65535;
    } else {
        b.u8 = c.samples;
        c.samples = NULL; /* ownership moved to the bitmap */
    }
    if (text) TRY(copy_text(&c, text, err));
    *out = b;
    b = (struct bitmap){0}; /* ownership moved to the caller */
done:
    if (c.png) png_destroy_read_struct(&c.png, &c.info, NULL);
    bitmap_release(&b);
    release_codec(&c);
    return status;
failed:
    status = fail(err, LMN_ERR_PARSE, "%s: PNG: %s", path, c.message);
    goto done;
}

/* ---- Writing ------------------------------------------------------------------------------ */

static bool is_ascii(const char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text > 126) return false;
    return true;
}

static bool write_all(struct codec *c, const struct image *im, png_textp text, int color_type)
{
    if (setjmp(c->leave)) return false;
    png_set_write_fn(c->png, c, on_write, on_flush);
    png_set_compression_level(c->png, 6);
    png_set_IHDR(c->png, c->info, im->width, im->height, 8, color_type, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(c->png, c->info, PNG_sRGB_INTENT_PERCEPTUAL);
    if (im->n_attributes) png_set_text(c->png, c->info, text, (int)im->n_attributes);
    png_write_info(c->png, c->info);
    png_write_image(c->png, c->rows);
    png_write_end(c->png, c->info);
    return true;
}

lmn_status png_encode(const struct image *im, double exposure, struct str *out, struct error *err)
{
    static const int color_types[5] = {0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA,
                                       PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
    lmn_status status = LMN_OK;
    struct codec c = {.out = out};
    png_textp text = NULL;
    struct tone tone;
    int channels[4];
    uint32_t n = codec_colour_channels(im, channels);
    if (n == 0) return fail(err, LMN_ERR_ARGUMENT, "no channels R, G, B or Y to write as PNG");
    text = mem_new(im->n_attributes, sizeof *text);
    c.png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, &c, on_error, on_warning, NULL,
                                      allocate, release);
    c.info = c.png ? png_create_info_struct(c.png) : NULL;
    if (!text || !c.info || !make_rows(&c, im->height, (size_t)im->width * n)) {
        status = fail_memory(err, "a PNG image");
        goto done;
    }
    for (uint32_t i = 0; i < im->n_attributes; i++) {
        const struct image_attribute *a = &im->attributes[i];
        text[i].key = a->name;
        text[i].text = a->value;
        /* tEXt holds Latin-1; what is more goes into iTXt as UTF-8. */
        text[i].compression = is_ascii(a->value) ? PNG_TEXT_COMPRESSION_NONE
                                                 : PNG_ITXT_COMPRESSION_NONE;
    }
    tone_init(&tone);
    size_t n_pixels = (size_t)im->width * im->height;
    for (size_t i = 0; i < n_pixels; i++) {
        for (uint32_t k = 0; k < n; k++) {
            float v = im->data[i * im->n_channels + (uint32_t)channels[k]];
            bool is_alpha = n % 2 == 0 && k == n - 1;
            c.samples[i * n + k] = is_alpha ? tone_byte(v) : tone_of(&tone, (float)exposure * v);
        }
    }
    if (!write_all(&c, im, text, color_types[n]))
        status = fail(err, out->failed ? LMN_ERR_MEMORY : LMN_ERR_ARGUMENT, "PNG: %s", c.message);
done:
    if (c.png) png_destroy_write_struct(&c.png, &c.info);
    mem_free(text);
    release_codec(&c);
    return status;
}
