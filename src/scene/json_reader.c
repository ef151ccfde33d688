/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/json_reader.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/file.h"
#include "base/mem.h"
#include "base/str.h"

enum { MAX_FILE_SIZE = 16 << 20 };

/* A file name or a key must not break a message into lines. */
static void make_one_line(struct error *err)
{
    if (!err) return;
    for (char *c = err->text; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 0x7F) *c = '?';
}

lmn_status json_reader_init(struct json_reader *r, const char *file, struct error *err)
{
    lmn_status status = LMN_OK;
    size_t size;
    json_error_t problem;
    *r = (struct json_reader){.file = file, .err = err};
    TRY(file_read(file, MAX_FILE_SIZE, &r->text, &size, err));
    r->root = json_loadb(r->text, size, JSON_REJECT_DUPLICATES, &problem);
    if (r->root) goto done;
    /* jansson's column is that of the last character read; its texts start in lower case. */
    if (problem.line > 0)
        status = fail(err, LMN_ERR_PARSE, "%s:%d:%d: %s", file, problem.line,
                      problem.column > 0 ? problem.column : 1, problem.text);
    else
        status = fail(err, LMN_ERR_PARSE, "%s: %s", file, problem.text);
    make_one_line(err);
done:
    if (status != LMN_OK) json_reader_release(r);
    return status;
}

void json_reader_release(struct json_reader *r)
{
    if (r->root) json_decref(r->root);
    mem_free(r->text);
    *r = (struct json_reader){0};
}

void json_reader_enter(struct json_reader *r, const char *key, size_t index)
{
    if (r->depth < JSON_READER_DEPTH) r->path[r->depth] = (struct json_step){key, index};
    r->depth++;
}

void json_reader_leave(struct json_reader *r)
{
    r->depth--;
}

/* ---- Finding a path in the text ------------------------------------------------------------- */

static const char *skip_space(const char *c)
{
    return c + strspn(c, " \t\r\n");
}

/* c is at the opening quote; returns what follows the closing one. */
static const char *skip_string(const char *c)
{
    for (c++; *c && *c != '"'; c++)
        if (*c == '\\' && c[1]) c++;
    return *c ? c + 1 : c;
}

/* The text is known to be JSON, so counting brackets is enough. */
static const char *skip_value(const char *c)
{
    size_t depth = 0;
    do {
        c = skip_space(c);
        if (*c == '"') {
            c = skip_string(c);
        } else if (*c == '[' || *c == '{') {
            depth++;
            c++;
        } else if (*c == ']' || *c == '}') {
            depth--;
            c++;
        } else if (*c == ',' || *c == ':') {
            c++;
        } else {
            size_t n = strcspn(c, ",:]}[{\" \t\r\n");
            if (n == 0) return c; /* the end */
            c += n;
        }
    } while (depth > 0 && *c);
    return c;
}

/* The value that a step leads to, or NULL. c is at the container. */
static const char *follow(const char *c, const struct json_step *step)
{
    char opener = *c, closer = opener == '{' ? '}' : ']';
    if (opener != (step->key ? '{' : '[')) return NULL;
    c = skip_space(c + 1);
    for (size_t i = 0; *c && *c != closer; i++) {
        bool found = !step->key && i == step->index;
        if (step->key) {
            const char *end = skip_string(c);
            size_t n = strlen(step->key);
            found = (size_t)(end - c) == n + 2 && memcmp(c + 1, step->key, n) == 0;
            c = skip_space(end);
            if (*c == ':') c = skip_space(c + 1);
        }
        if (found) return c;
        c = skip_space(skip_value(c));
        if (*c == ',') c = skip_space(c + 1);
    }
    return NULL;
}

struct place json_reader_place(const struct json_reader *r)
{
    struct place place = {.file = r->file, .line = 1, .column = 1};
    const char *at = skip_space(r->text), *next = at;
    for (size_t i = 0; i < r->depth && i < JSON_READER_DEPTH && next; i++) {
        next = follow(at, &r->path[i]);
        if (next) at = next;
    }
    for (const char *c = r->text; c < at; c++) {
        place.column++;
        if (*c == '\n') {
            place.line++;
            place.column = 1;
        }
    }
    return place;
}

lmn_status json_reader_fail(const struct json_reader *r, const char *format, ...)
{
    struct str path = {0};
    char what[768];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    for (size_t i = 0; i < r->depth && i < JSON_READER_DEPTH; i++) {
        if (r->path[i].key)
            str_add(&path, "%s%s", i ? "." : "", r->path[i].key);
        else
            str_add(&path, "[%zu]", r->path[i].index);
    }
    lmn_status status = path.length && !path.failed
                            ? fail_at(r->err, json_reader_place(r), "%.120s: %s", path.text, what)
                            : fail_at(r->err, json_reader_place(r), "%s", what);
    str_release(&path);
    make_one_line(r->err);
    return status;
}

/* ---- Values --------------------------------------------------------------------------------- */

static lmn_status wrong_type(const struct json_reader *r, const json_t *value, const char *wanted)
{
    return json_reader_fail(r, value ? "this must be %s" : "%s is missing here", wanted);
}

lmn_status json_read_number(struct json_reader *r, const json_t *value, double *out)
{
    if (!json_is_number(value)) return wrong_type(r, value, "a number");
    *out = json_number_value(value);
    /* Everything is kept in floats later; this leaves room for products. */
    if (!(fabs(*out) <= 1e30)) return json_reader_fail(r, "%g is too large", *out);
    return LMN_OK;
}

lmn_status json_read_string(struct json_reader *r, const json_t *value, const char **out)
{
    if (!json_is_string(value)) return wrong_type(r, value, "a string");
    *out = json_string_value(value);
    return LMN_OK;
}

lmn_status json_read_numbers(struct json_reader *r, const json_t *value, size_t n, double *out)
{
    if (!json_is_array(value) || json_array_size(value) != n)
        return json_reader_fail(r,
                                value ? "this must be %zu numbers in brackets"
                                      : "%zu numbers in brackets are missing here",
                                n);
    for (size_t i = 0; i < n; i++) {
        json_reader_enter(r, NULL, i);
        lmn_status status = json_read_number(r, json_array_get(value, i), &out[i]);
        if (status != LMN_OK) return status;
        json_reader_leave(r);
    }
    return LMN_OK;
}

lmn_status json_read_range(struct json_reader *r, const json_t *value, double out[2])
{
    if (!json_is_array(value) || json_array_size(value) != 2)
        return wrong_type(r, value, "a range [min, max]");
    lmn_status status = json_read_numbers(r, value, 2, out);
    if (status != LMN_OK) return status;
    if (!((float)out[0] < (float)out[1]))
        return json_reader_fail(r, "min %g is not below max %g", out[0], out[1]);
    return LMN_OK;
}

lmn_status json_read_box(struct json_reader *r, const json_t *value, double min[3], double max[3])
{
    static const char *const keys[] = {"min", "max"};
    double *const corners[2] = {min, max};
    lmn_status status;
    if (!json_is_object(value))
        return wrong_type(r, value, "a box {\"min\": [x, y, z], \"max\": [x, y, z]}");
    status = json_check_keys(r, value, keys, 2);
    for (int i = 0; i < 2 && status == LMN_OK; i++) {
        json_reader_enter(r, keys[i], 0);
        status = json_read_numbers(r, json_object_get(value, keys[i]), 3, corners[i]);
        if (status == LMN_OK) json_reader_leave(r);
    }
    if (status != LMN_OK) return status;
    for (int i = 0; i < 3; i++) {
        if (!(min[i] <= max[i]))
            return json_reader_fail(r, "min %g is above max %g in component %c", min[i], max[i],
                                    "xyz"[i]);
    }
    return LMN_OK;
}

lmn_status json_check_keys(struct json_reader *r, const json_t *object, const char *const *keys,
                           size_t n)
{
    void *i = json_object_iter((json_t *)object);
    for (; i; i = json_object_iter_next((json_t *)object, i)) {
        const char *key = json_object_iter_key(i);
        bool is_known = false;
        for (size_t k = 0; k < n; k++) is_known |= strcmp(key, keys[k]) == 0;
        if (is_known) continue;
        const char *closest = str_closest(key, keys, n);
        json_reader_enter(r, key, 0);
        return json_reader_fail(r, "unknown key%s%s%s", closest ? "; did you mean \"" : "",
                                closest ? closest : "", closest ? "\"?" : "");
    }
    return LMN_OK;
}
