/* SPDX-License-Identifier: Apache-2.0 */
#include "train/safetensors.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/json.h"
#include "base/mem.h"

enum {
    MAX_HEADER_SIZE = 16 << 20,
    MAX_TENSORS = 4096,
    ALIGNMENT = 64 /* of the data: mapped files can be used as tensors */
};

static const struct {
    const char *name;
    size_t size;
} types[] = {[TENSOR_F32] = {"F32", 4},
             [TENSOR_F64] = {"F64", 8},
             [TENSOR_I64] = {"I64", 8},
             [TENSOR_U8] = {"U8", 1}};

/* False when it does not fit 63 bits. */
static bool byte_size(enum tensor_type type, uint32_t rank, const uint64_t *shape, uint64_t *out)
{
    uint64_t size = types[type].size;
    for (uint32_t i = 0; i < rank; i++)
        if (__builtin_mul_overflow(size, shape[i], &size)) return false;
    *out = size;
    return size <= INT64_MAX;
}

/* ---- Writing ------------------------------------------------------------------------------- */

static void write_header(struct str *out, const struct tensor_text *texts, uint32_t n_texts,
                         const struct tensor *tensors, uint32_t n_tensors)
{
    struct json j = {.out = out};
    json_begin_object(&j, NULL);
    json_begin_object(&j, "__metadata__");
    for (uint32_t i = 0; i < n_texts; i++) json_put_string(&j, texts[i].key, texts[i].value);
    json_end(&j);
    uint64_t at = 0;
    for (uint32_t i = 0; i < n_tensors; i++) {
        const struct tensor *t = &tensors[i];
        uint64_t size = 0;
        byte_size(t->type, t->rank, t->shape, &size); /* in memory already: it fits */
        json_begin_object(&j, t->name);
        json_put_string(&j, "dtype", types[t->type].name);
        json_begin_array(&j, "shape");
        for (uint32_t k = 0; k < t->rank; k++) json_put_integer(&j, NULL, (int64_t)t->shape[k]);
        json_end(&j);
        json_begin_array(&j, "data_offsets");
        json_put_integer(&j, NULL, (int64_t)at);
        json_put_integer(&j, NULL, (int64_t)(at + size));
        json_end(&j);
        json_end(&j);
        at += size;
    }
    json_end(&j);
    while ((out->length + 8) % ALIGNMENT != 0 && !out->failed) str_add(out, " ");
}

lmn_status safetensors_save(const char *path, const struct tensor_text *texts, uint32_t n_texts,
                            const struct tensor *tensors, uint32_t n_tensors, struct error *err)
{
    lmn_status status = LMN_OK;
    struct file_writer w = {0};
    struct str header = {0};
    unsigned char length[8];
    write_header(&header, texts, n_texts, tensors, n_tensors);
    if (header.failed) {
        status = fail_memory(err, path);
        goto done;
    }
    for (int i = 0; i < 8; i++) length[i] = (unsigned char)((uint64_t)header.length >> (8 * i));

    TRY(file_writer_open(&w, path, err));
    fwrite(length, 1, sizeof length, w.f); /* file_writer_commit() sees what went wrong */
    fwrite(header.text, 1, header.length, w.f);
    for (uint32_t i = 0; i < n_tensors; i++) {
        uint64_t size = 0;
        byte_size(tensors[i].type, tensors[i].rank, tensors[i].shape, &size);
        if (size > 0) fwrite(tensors[i].data, 1, size, w.f);
    }
    TRY(file_writer_commit(&w, err));
done:
    file_writer_release(&w);
    str_release(&header);
    return status;
}

/* ---- Reading ------------------------------------------------------------------------------- */

struct range {
    uint64_t begin, end;
};

static int compare_ranges(const void *a, const void *b)
{
    const struct range *x = a, *y = b;
    if (x->begin != y->begin) return x->begin < y->begin ? -1 : 1;
    return x->end < y->end ? -1 : x->end > y->end;
}

static bool get_u64(const json_t *v, uint64_t *out)
{
    if (!json_is_integer(v) || json_integer_value(v) < 0) return false;
    *out = (uint64_t)json_integer_value(v);
    return true;
}

/* One tensor of the header -> type, shape, byte range; checks that they fit each other. */
static lmn_status read_entry(const char *path, const char *name, const json_t *entry,
                             struct tensor *out, struct range *range, struct error *err)
{
    const json_t *shape = json_object_get(entry, "shape");
    const json_t *offsets = json_object_get(entry, "data_offsets");
    const char *dtype = json_string_value(json_object_get(entry, "dtype"));
    uint64_t size;
    *out = (struct tensor){.name = name};
    while (dtype && out->type <= TENSOR_U8 && strcmp(dtype, types[out->type].name) != 0)
        out->type++;
    if (!dtype || out->type > TENSOR_U8)
        return fail(err, LMN_ERR_PARSE, "%s: tensor \"%.60s\" has the type \"%.20s\"", path, name,
                    dtype ? dtype : "none");
    if (!json_is_array(shape) || json_array_size(shape) > TENSOR_MAX_RANK)
        return fail(err, LMN_ERR_PARSE, "%s: tensor \"%.60s\" has no shape of at most %d numbers",
                    path, name, TENSOR_MAX_RANK);
    out->rank = (uint32_t)json_array_size(shape);
    for (uint32_t i = 0; i < out->rank; i++)
        if (!get_u64(json_array_get(shape, i), &out->shape[i]))
            return fail(err, LMN_ERR_PARSE, "%s: tensor \"%.60s\" has a bad shape", path, name);
    if (json_array_size(offsets) != 2 || !get_u64(json_array_get(offsets, 0), &range->begin) ||
        !get_u64(json_array_get(offsets, 1), &range->end) || range->begin > range->end)
        return fail(err, LMN_ERR_PARSE, "%s: tensor \"%.60s\" has bad data_offsets", path, name);
    if (!byte_size(out->type, out->rank, out->shape, &size) || size != range->end - range->begin)
        return fail(err, LMN_ERR_PARSE, "%s: tensor \"%.60s\": shape and data_offsets do not match",
                    path, name);
    return LMN_OK;
}

static lmn_status check_header(const struct safetensors *st, uint64_t data_size, struct error *err)
{
    lmn_status status = LMN_OK;
    size_t n = json_object_size(st->header), n_ranges = 0;
    struct range *ranges = NULL;
    const char *name;
    json_t *entry;
    uint64_t at = 0;
    if (!json_is_object(st->header) || n > MAX_TENSORS) {
        status = fail(err, LMN_ERR_PARSE, "%s: the header is no object of at most %d tensors",
                      st->path, MAX_TENSORS);
        goto done;
    }
    ranges = mem_new(n, sizeof *ranges);
    if (!ranges) {
        status = fail_memory(err, st->path);
        goto done;
    }
    json_object_foreach(st->header, name, entry)
    {
        struct tensor t;
        if (strcmp(name, "__metadata__") == 0) continue;
        TRY(read_entry(st->path, name, entry, &t, &ranges[n_ranges], err));
        n_ranges++;
    }
    qsort(ranges, n_ranges, sizeof *ranges, compare_ranges);
    for (size_t i = 0; i < n_ranges; i++) {
        if (ranges[i].begin != at) {
            status = fail(err, LMN_ERR_PARSE, "%s: tensors overlap or leave gaps", st->path);
            goto done;
        }
        at = ranges[i].end;
    }
    if (at != data_size)
        status = fail(err, LMN_ERR_PARSE, "%s: %s: the header tells of %llu bytes, there are %llu",
                      st->path, at > data_size ? "truncated" : "too long", (unsigned long long)at,
                      (unsigned long long)data_size);
done:
    mem_free(ranges);
    return status;
}

static lmn_status read_header(struct safetensors *st, struct error *err)
{
    lmn_status status = LMN_OK;
    char *text = NULL;
    unsigned char length[8];
    uint64_t size = 0;
    json_error_t why;
    struct stat file;
    if (fstat(fileno(st->f), &file) != 0 || !S_ISREG(file.st_mode)) {
        status = fail(err, LMN_ERR_IO, "%s: not a regular file", st->path);
        goto done;
    }
    if (fread(length, 1, 8, st->f) != 8) {
        status = fail(err, LMN_ERR_PARSE, "%s: not a model file: shorter than 8 bytes", st->path);
        goto done;
    }
    for (int i = 0; i < 8; i++) size |= (uint64_t)length[i] << (8 * i);
    if (size > MAX_HEADER_SIZE || size > (uint64_t)file.st_size - 8) {
        status = fail(err, LMN_ERR_PARSE,
                      "%s: not a model file, or truncated: its header would have %llu bytes",
                      st->path, (unsigned long long)size);
        goto done;
    }
    text = mem_new(size + 1, 1);
    if (!text) {
        status = fail_memory(err, st->path);
        goto done;
    }
    if (fread(text, 1, size, st->f) != size) {
        status = fail(err, LMN_ERR_IO, "%s: cannot read: %s", st->path, strerror(errno));
        goto done;
    }
    st->header = json_loadb(text, size, JSON_REJECT_DUPLICATES, &why);
    if (!st->header) {
        status = fail(err, LMN_ERR_PARSE, "%s: not a model file: header:%d:%d: %s", st->path,
                      why.line, why.column, why.text);
        goto done;
    }
    st->data_at = 8 + size;
    TRY(check_header(st, (uint64_t)file.st_size - st->data_at, err));
done:
    mem_free(text);
    return status;
}

lmn_status safetensors_open(struct safetensors *st, const char *path, struct error *err)
{
    lmn_status status = LMN_OK;
    *st = (struct safetensors){.path = mem_strdup(path)};
    if (!st->path) {
        status = fail_memory(err, path);
        goto done;
    }
    st->f = fopen(path, "rb");
    if (!st->f) {
        status = fail(err, LMN_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
        goto done;
    }
    TRY(read_header(st, err));
done:
    if (status != LMN_OK) safetensors_release(st);
    return status;
}

void safetensors_release(struct safetensors *st)
{
    if (st->f) fclose(st->f);
    json_decref(st->header);
    mem_free(st->path);
    *st = (struct safetensors){0};
}

const char *safetensors_text(const struct safetensors *st, const char *key)
{
    return json_string_value(json_object_get(json_object_get(st->header, "__metadata__"), key));
}

uint64_t safetensors_n_rows(const struct safetensors *st, const char *name)
{
    const json_t *shape = json_object_get(json_object_get(st->header, name), "shape");
    return (uint64_t)json_integer_value(json_array_get(shape, 0));
}

static bool all_finite(const struct tensor *t, uint64_t size)
{
    uint64_t n = size / types[t->type].size;
    const float *f32 = t->data;
    const double *f64 = t->data;
    if (t->type == TENSOR_F32)
        for (uint64_t i = 0; i < n; i++)
            if (!isfinite(f32[i])) return false;
    if (t->type == TENSOR_F64)
        for (uint64_t i = 0; i < n; i++)
            if (!isfinite(f64[i])) return false;
    return true;
}

/* Compares with what is asked for; *range gets where the bytes are. */
static lmn_status find(const struct safetensors *st, const struct tensor *t, struct range *range,
                       struct error *err)
{
    struct tensor found;
    const json_t *entry = json_object_get(st->header, t->name);
    if (!entry) return fail(err, LMN_ERR_PARSE, "%s: tensor \"%s\" is missing", st->path, t->name);
    lmn_status status = read_entry(st->path, t->name, entry, &found, range, err);
    if (status != LMN_OK) return status;
    if (found.type != t->type)
        return fail(err, LMN_ERR_PARSE, "%s: tensor \"%s\" is of type %s, not %s", st->path,
                    t->name, types[found.type].name, types[t->type].name);
    bool is_same = found.rank == t->rank;
    for (uint32_t i = 0; is_same && i < t->rank; i++) is_same = found.shape[i] == t->shape[i];
    if (!is_same)
        return fail(err, LMN_ERR_PARSE, "%s: tensor \"%s\" has another shape than its model needs",
                    st->path, t->name);
    return LMN_OK;
}

lmn_status safetensors_check(const struct safetensors *st, const struct tensor *t,
                             struct error *err)
{
    struct range range;
    return find(st, t, &range, err);
}

lmn_status safetensors_read(const struct safetensors *st, const struct tensor *t, bool may_be_nan,
                            struct error *err)
{
    struct range range;
    lmn_status status = find(st, t, &range, err);
    if (status != LMN_OK) return status;
    uint64_t size = range.end - range.begin;
    if (fseeko(st->f, (off_t)(st->data_at + range.begin), SEEK_SET) != 0 ||
        fread(t->data, 1, size, st->f) != size)
        return fail(err, LMN_ERR_IO, "%s: cannot read tensor \"%s\"", st->path, t->name);
    if (!may_be_nan && !all_finite(t, size))
        return fail(err, LMN_ERR_PARSE, "%s: tensor \"%s\" holds values that are not finite",
                    st->path, t->name);
    return LMN_OK;
}
