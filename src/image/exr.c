/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR through its C core, from and to memory. The core reports errors through a callback, and
 * would print them without one. */
#include "image/codecs.h"

#include <math.h>
#include <string.h>

#include <OpenEXR/openexr.h>

#include "base/mem.h"

/* What the core's callbacks see: the file being read or written, and the first error. */
struct stream {
    const char *path;  /* reading: starts the messages */
    const char *bytes; /* reading */
    size_t size;
    struct str *out; /* writing */
    char message[256];
};

/* The core may call on_error() with its context locked, and exr_get_user_data() takes that lock:
 * asking the context for its stream would wait for ever. */
static _Thread_local struct stream *current;

static void on_error(exr_const_context_t ctx, exr_result_t code, const char *message)
{
    (void)ctx;
    (void)code;
    struct stream *s = current;
    if (!s || s->message[0]) return; /* what went wrong first is what helps */
    size_t n = 0;
    for (const char *m = message; *m && n + 1 < sizeof s->message; m++)
        s->message[n++] = (unsigned char)*m < 0x20 ? ' ' : *m;
    while (n > 0 && s->message[n - 1] == ' ') n--;
    s->message[n] = '\0';
}

static int64_t on_read(exr_const_context_t ctx, void *user, void *buffer, uint64_t size,
                       uint64_t offset, exr_stream_error_func_ptr_t error)
{
    (void)ctx;
    (void)error;
    const struct stream *s = user;
    if (offset >= s->size) return 0;
    if (size > s->size - offset) size = s->size - offset;
    memcpy(buffer, s->bytes + offset, size);
    return (int64_t)size;
}

static int64_t on_size(exr_const_context_t ctx, void *user)
{
    (void)ctx;
    return (int64_t)((const struct stream *)user)->size;
}

/* The chunk table is written last, into the room left for it at the start. */
static int64_t on_write(exr_const_context_t ctx, void *user, const void *buffer, uint64_t size,
                        uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct str *out = ((struct stream *)user)->out;
    static const char zeros[4096];
    while (!out->failed && out->length < offset) {
        uint64_t gap = offset - out->length;
        str_add_bytes(out, zeros, gap < sizeof zeros ? gap : sizeof zeros);
    }
    uint64_t inside = out->length - offset < size ? out->length - offset : size;
    if (!out->failed && inside) memcpy(out->text + offset, buffer, inside);
    str_add_bytes(out, (const char *)buffer + inside, size - inside);
    if (out->failed) return error(ctx, EXR_ERR_OUT_OF_MEMORY, "not enough memory");
    return (int64_t)size;
}

static void *allocate(size_t size)
{
    return mem_new(size, 1);
}

static exr_context_initializer_t initializer(struct stream *s)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = on_error;
    init.alloc_fn = allocate;
    init.free_fn = mem_free;
    init.user_data = s;
    init.read_fn = on_read;
    init.size_fn = on_size;
    init.write_fn = on_write;
    init.max_image_width = init.max_image_height = IMAGE_MAX_SIDE;
    init.max_tile_width = init.max_tile_height = IMAGE_MAX_SIDE;
    init.zip_level = 4; /* twice as fast as 6, a percent larger */
    return init;
}

static lmn_status fail_exr(const struct stream *s, exr_result_t code, struct error *err)
{
    lmn_status status = code == EXR_ERR_OUT_OF_MEMORY ? LMN_ERR_MEMORY : LMN_ERR_PARSE;
    return fail(err, status, "%s%sOpenEXR: %s", s->path ? s->path : "", s->path ? ": " : "",
                s->message[0] ? s->message : exr_get_default_error_message(code));
}

/* Leaves through `done` with `err` filled when a call of the core fails. */
#define TRY_EXR(call)                              \
    do {                                           \
        exr_result_t code = (call);                \
        if (code != EXR_ERR_SUCCESS) {             \
            status = fail_exr(&stream, code, err); \
            goto done;                             \
        }                                          \
    } while (0)

bool exr_is(const void *bytes, size_t size)
{
    return size >= 4 && memcmp(bytes, "\x76\x2f\x31\x01", 4) == 0;
}

/* ---- Reading ------------------------------------------------------------------------------ */

/* One flat part of a file, and where its channels go. */
struct part {
    int index;
    bool is_tiled;
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *channels;
    int to[IMAGE_MAX_CHANNELS]; /* the image's channel for each of the file's; -1: left out */
};

/* Names sort first by layer, in file order, then R G B X Y Z A. */
static uint32_t letter_rank(const char *name)
{
    static const char letters[] = "RGBXYZA";
    const char *dot = strrchr(name, '.');
    const char *last = dot ? dot + 1 : name;
    const char *letter = last[0] && !last[1] ? strchr(letters, last[0]) : NULL;
    return letter ? (uint32_t)(letter - letters) : (uint32_t)sizeof letters;
}

static size_t layer_length(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot ? (size_t)(dot - name) : 0;
}

static bool comes_before(const char *a, const char *b)
{
    size_t n = layer_length(a), m = layer_length(b);
    if (n == m && memcmp(a, b, n) == 0) return letter_rank(a) < letter_rank(b);
    if (n == 0 || m == 0) return n == 0;
    return false; /* different layers keep the file's order */
}

static bool is_colour(const char *name)
{
    return name[0] && strchr("RGBYA", name[0]) && !name[1];
}

/* Chooses the channels, orders them, and makes the image. */
static lmn_status plan_channels(const char *path, size_t file_size, bool colour_only,
                                struct part *part, struct image *im, struct error *err)
{
    const char *names[IMAGE_MAX_CHANNELS];
    int from[IMAGE_MAX_CHANNELS];
    uint32_t n = 0;
    uint64_t pixel_size = 0;
    int n_all = part->channels->num_channels;
    bool has_colour = false;
    if (n_all > IMAGE_MAX_CHANNELS)
        return fail(err, LMN_ERR_PARSE, "%s: %d channels; can read %d at most", path, n_all,
                    IMAGE_MAX_CHANNELS);
    for (int c = 0; c < n_all; c++) {
        const exr_attr_chlist_entry_t *entry = &part->channels->entries[c];
        has_colour |= is_colour(entry->name.str) && entry->name.str[0] != 'A';
    }
    for (int c = 0; c < n_all; c++) {
        const exr_attr_chlist_entry_t *entry = &part->channels->entries[c];
        const char *name = entry->name.str;
        pixel_size += entry->pixel_type == EXR_PIXEL_HALF ? 2 : 4;
        part->to[c] = -1;
        if (colour_only && has_colour && !is_colour(name)) continue;
        if (strlen(name) >= IMAGE_NAME_SIZE)
            return fail(err, LMN_ERR_PARSE, "%s: channel name \"%.60s\" is longer than %d letters",
                        path, name, IMAGE_NAME_SIZE - 1);
        if (entry->x_sampling != 1 || entry->y_sampling != 1)
            return fail(err, LMN_ERR_PARSE,
                        "%s: channel \"%s\" is sub-sampled, which is not supported", path, name);
        uint32_t at = n++;
        for (; at > 0 && comes_before(name, names[at - 1]); at--) {
            names[at] = names[at - 1];
            from[at] = from[at - 1];
        }
        names[at] = name;
        from[at] = c;
    }
    for (uint32_t i = 0; i < n; i++) part->to[from[i]] = (int)i;

    const exr_attr_box2i_t *win = &part->window;
    int64_t width = (int64_t)win->max.x - win->min.x + 1;
    int64_t height = (int64_t)win->max.y - win->min.y + 1;
    if (width < 0 || height < 0) width = height = 0;
    lmn_status status = codec_check_size(path, (uint64_t)width, (uint64_t)height, n, 4, UINT32_MAX,
                                         err);
    /* Channels that are left out take room in the file, too. */
    if (status == LMN_OK)
        status = codec_check_size(path, (uint64_t)width, (uint64_t)height, 1, pixel_size, file_size,
                                  err);
    if (status != LMN_OK) return status;
    status = image_init(im, (uint32_t)width, (uint32_t)height, n, names, err);
    if (status == LMN_ERR_ARGUMENT)
        status = fail(err, LMN_ERR_PARSE, "%s: bad channel names", path);
    return status;
}

/* Decodes one chunk, whose top left pixel is (x, y) of the image. */
static exr_result_t decode_chunk(exr_context_t ctx, const struct part *part,
                                 const exr_chunk_info_t *chunk, exr_decode_pipeline_t *pipe,
                                 bool *is_ready, int64_t x, int64_t y, struct image *im)
{
    if (x < 0 || y < 0 || chunk->width < 1 || chunk->height < 1 ||
        x + chunk->width > (int64_t)im->width || y + chunk->height > (int64_t)im->height)
        return EXR_ERR_BAD_CHUNK_LEADER;
    exr_result_t code = *is_ready ? exr_decoding_update(ctx, part->index, chunk, pipe)
                                  : exr_decoding_initialize(ctx, part->index, chunk, pipe);
    if (code != EXR_ERR_SUCCESS) return code;
    float *corner = im->data + ((size_t)y * im->width + (size_t)x) * im->n_channels;
    for (int c = 0; c < pipe->channel_count; c++) {
        exr_coding_channel_info_t *to = &pipe->channels[c];
        to->decode_to_ptr = part->to[c] < 0 ? NULL : (uint8_t *)(corner + part->to[c]);
        to->user_bytes_per_element = sizeof(float);
        to->user_data_type = EXR_PIXEL_FLOAT;
        to->user_pixel_stride = (int32_t)(im->n_channels * sizeof(float));
        to->user_line_stride = (int32_t)(im->width * im->n_channels * sizeof(float));
    }
    if (!*is_ready) code = exr_decoding_choose_default_routines(ctx, part->index, pipe);
    *is_ready = true;
    return code == EXR_ERR_SUCCESS ? exr_decoding_run(ctx, part->index, pipe) : code;
}

static exr_result_t decode_scan_lines(exr_context_t ctx, const struct part *part,
                                      exr_decode_pipeline_t *pipe, struct image *im)
{
    int32_t n_lines = 0;
    bool is_ready = false;
    exr_result_t code = exr_get_scanlines_per_chunk(ctx, part->index, &n_lines);
    if (code == EXR_ERR_SUCCESS && n_lines < 1) code = EXR_ERR_BAD_CHUNK_LEADER;
    for (int64_t y = 0; code == EXR_ERR_SUCCESS && y < (int64_t)im->height; y += n_lines) {
        exr_chunk_info_t chunk = {0};
        code = exr_read_scanline_chunk_info(ctx, part->index, (int)(part->window.min.y + y),
                                            &chunk);
        if (code == EXR_ERR_SUCCESS)
            code = decode_chunk(ctx, part, &chunk, pipe, &is_ready, 0, y, im);
    }
    return code;
}

static exr_result_t decode_tiles(exr_context_t ctx, const struct part *part,
                                 exr_decode_pipeline_t *pipe, struct image *im)
{
    int32_t w = 0, h = 0;
    bool is_ready = false;
    exr_result_t code = exr_get_tile_sizes(ctx, part->index, 0, 0, &w, &h);
    if (code == EXR_ERR_SUCCESS && (w < 1 || h < 1)) code = EXR_ERR_INVALID_ATTR;
    for (int64_t y = 0; code == EXR_ERR_SUCCESS && y < (int64_t)im->height; y += h) {
        for (int64_t x = 0; code == EXR_ERR_SUCCESS && x < (int64_t)im->width; x += w) {
            exr_chunk_info_t chunk = {0};
            code = exr_read_tile_chunk_info(ctx, part->index, (int)(x / w), (int)(y / h), 0, 0,
                                            &chunk);
            if (code == EXR_ERR_SUCCESS)
                code = decode_chunk(ctx, part, &chunk, pipe, &is_ready, x, y, im);
        }
    }
    return code;
}

static lmn_status copy_attributes(exr_context_t ctx, int part, struct image *im, struct error *err)
{
    int32_t n = 0;
    if (exr_get_attribute_count(ctx, part, &n) != EXR_ERR_SUCCESS) return LMN_OK;
    for (int32_t i = 0; i < n; i++) {
        const exr_attribute_t *a = NULL;
        exr_result_t code = exr_get_attribute_by_index(ctx, part, EXR_ATTR_LIST_FILE_ORDER, i, &a);
        /* "name" and "type" are the part's own */
        if (code != EXR_ERR_SUCCESS || a->type != EXR_ATTR_STRING || !a->string->str ||
            strcmp(a->name, "name") == 0 || strcmp(a->name, "type") == 0)
            continue;
        lmn_status status = image_set_attribute(im, a->name, a->string->str, err);
        if (status != LMN_OK) return status;
    }
    return LMN_OK;
}

lmn_status exr_decode(const char *path, const void *bytes, size_t size, bool colour_only,
                      struct image *out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct stream stream = {.path = path, .bytes = bytes, .size = size};
    exr_context_initializer_t init = initializer(&stream);
    exr_context_t ctx = NULL;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    struct part part = {.index = -1};
    struct image im = {0};
    int n_parts = 0;

    current = &stream;
    TRY_EXR(exr_start_read(&ctx, path, &init));
    TRY_EXR(exr_get_count(ctx, &n_parts));
    for (int i = 0; i < n_parts && part.index < 0; i++) {
        exr_storage_t storage;
        TRY_EXR(exr_get_storage(ctx, i, &storage));
        if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED) continue;
        part.index = i;
        part.is_tiled = storage == EXR_STORAGE_TILED;
    }
    if (part.index < 0) {
        status = fail(err, LMN_ERR_PARSE, "%s: holds only deep data, which is not supported", path);
        goto done;
    }
    TRY_EXR(exr_get_channels(ctx, part.index, &part.channels));
    TRY_EXR(exr_get_data_window(ctx, part.index, &part.window));
    TRY(plan_channels(path, size, colour_only, &part, &im, err));
    TRY_EXR(part.is_tiled ? decode_tiles(ctx, &part, &pipe, &im)
                          : decode_scan_lines(ctx, &part, &pipe, &im));
    if (!colour_only) TRY(copy_attributes(ctx, part.index, &im, err));
    *out = im;
    im = (struct image){0}; /* ownership moved to the caller */
done:
    if (ctx) {
        exr_decoding_destroy(ctx, &pipe);
        exr_finish(&ctx);
    }
    current = NULL;
    image_release(&im);
    return status;
}

/* ---- Writing ------------------------------------------------------------------------------ */

/* Colours are stored as half floats; data that is computed with (normals, halves of the samples,
 * depth) stays float. */
static bool is_half(const char *name)
{
    if (strlen(name) == 1) return strchr("RGBA", name[0]) != NULL;
    size_t n = layer_length(name);
    bool is_layer = (n == 6 && memcmp(name, "albedo", n) == 0) ||
                    (n == 8 && memcmp(name, "emission", n) == 0);
    return is_layer && letter_rank(name) < 3;
}

/* Whether all values that would be stored as half floats fit: beyond 65504 they would be infinite.
 */
static bool halves_suffice(const struct image *im)
{
    size_t n_pixels = (size_t)im->width * im->height;
    for (uint32_t c = 0; c < im->n_channels; c++) {
        if (!is_half(im->names[c])) continue;
        for (size_t i = 0; i < n_pixels; i++) {
            float v = im->data[i * im->n_channels + c];
            if (isfinite(v) && fabsf(v) > 65504) return false;
        }
    }
    return true;
}

static exr_result_t encode_chunk(exr_context_t ctx, int part, uint32_t y, bool is_first,
                                 exr_encode_pipeline_t *pipe, const struct image *im)
{
    exr_chunk_info_t chunk = {0};
    exr_result_t code = exr_write_scanline_chunk_info(ctx, part, (int)y, &chunk);
    if (code != EXR_ERR_SUCCESS) return code;
    code = is_first ? exr_encoding_initialize(ctx, part, &chunk, pipe)
                    : exr_encoding_update(ctx, part, &chunk, pipe);
    if (code != EXR_ERR_SUCCESS) return code;
    const float *row = im->data + (size_t)y * im->width * im->n_channels;
    for (int c = 0; c < pipe->channel_count; c++) {
        exr_coding_channel_info_t *from = &pipe->channels[c];
        int index = image_channel(im, from->channel_name);
        from->encode_from_ptr = (const uint8_t *)(row + index);
        from->user_bytes_per_element = sizeof(float);
        from->user_data_type = EXR_PIXEL_FLOAT;
        from->user_pixel_stride = (int32_t)(im->n_channels * sizeof(float));
        from->user_line_stride = (int32_t)(im->width * im->n_channels * sizeof(float));
    }
    if (is_first) code = exr_encoding_choose_default_routines(ctx, part, pipe);
    return code == EXR_ERR_SUCCESS ? exr_encoding_run(ctx, part, pipe) : code;
}

lmn_status exr_encode(const struct image *im, struct str *out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct stream stream = {.out = out};
    exr_context_initializer_t init = initializer(&stream);
    exr_context_t ctx = NULL;
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    bool use_half = halves_suffice(im);
    int part = 0;
    int32_t n_lines = 0;

    current = &stream;
    TRY_EXR(exr_start_write(&ctx, "image", EXR_WRITE_FILE_DIRECTLY, &init));
    TRY_EXR(exr_set_longname_support(ctx, 1));
    TRY_EXR(exr_add_part(ctx, "", EXR_STORAGE_SCANLINE, &part));
    TRY_EXR(exr_initialize_required_attr_simple(ctx, part, (int32_t)im->width, (int32_t)im->height,
                                                EXR_COMPRESSION_ZIP));
    for (uint32_t c = 0; c < im->n_channels; c++) {
        bool half = use_half && is_half(im->names[c]);
        TRY_EXR(exr_add_channel(ctx, part, im->names[c], half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                                EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    }
    for (uint32_t i = 0; i < im->n_attributes; i++)
        TRY_EXR(exr_attr_set_string(ctx, part, im->attributes[i].name, im->attributes[i].value));
    TRY_EXR(exr_write_header(ctx));
    TRY_EXR(exr_get_scanlines_per_chunk(ctx, part, &n_lines));
    for (uint32_t y = 0; y < im->height; y += (uint32_t)n_lines)
        TRY_EXR(encode_chunk(ctx, part, y, y == 0, &pipe, im));
    exr_encoding_destroy(ctx, &pipe);
    TRY_EXR(exr_finish(&ctx));
    ctx = NULL;
done:
    if (ctx) {
        exr_encoding_destroy(ctx, &pipe);
        exr_finish(&ctx);
    }
    current = NULL;
    return status;
}
