/* SPDX-License-Identifier: Apache-2.0 */
#include "base/json.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void quote(struct str *s, const char *text)
{
    str_add(s, "\"");
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        if (*c == '"' || *c == '\\')
            str_add(s, "\\%c", *c);
        else if (*c < 0x20)
            str_add(s, "\\u%04x", *c);
        else
            str_add_bytes(s, c, 1);
    }
    str_add(s, "\"");
}

static void begin_item(struct json *j, const char *key)
{
    if (j->n_items[j->depth]++) str_add(j->out, ",");
    if (!key) return;
    quote(j->out, key);
    str_add(j->out, ":");
}

static void open_level(struct json *j, const char *key, const char *opener, char closer)
{
    assert(j->depth < 32);
    begin_item(j, key);
    str_add(j->out, "%s", opener);
    j->depth++;
    j->n_items[j->depth] = 0;
    j->closers[j->depth] = closer;
}

void json_begin_object(struct json *j, const char *key)
{
    open_level(j, key, "{", '}');
}

void json_begin_array(struct json *j, const char *key)
{
    open_level(j, key, "[", ']');
}

void json_end(struct json *j)
{
    assert(j->depth > 0);
    str_add(j->out, "%c", j->closers[j->depth]);
    j->depth--;
}

void json_put_string(struct json *j, const char *key, const char *value)
{
    begin_item(j, key);
    if (value)
        quote(j->out, value);
    else
        str_add(j->out, "null");
}

void json_put_number(struct json *j, const char *key, double value)
{
    begin_item(j, key);
    if (!isfinite(value)) {
        str_add(j->out, "null");
        return;
    }
    char text[40];
    for (int digits = 1; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value) break;
    }
    str_add(j->out, "%s", text);
}

void json_put_float(struct json *j, const char *key, float value)
{
    begin_item(j, key);
    if (!isfinite(value)) {
        str_add(j->out, "null");
        return;
    }
    char text[40];
    for (int digits = 1; digits <= 9; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, (double)value);
        if (strtof(text, NULL) == value) break;
    }
    str_add(j->out, "%s", text);
}

void json_put_integer(struct json *j, const char *key, int64_t value)
{
    begin_item(j, key);
    str_add(j->out, "%lld", (long long)value);
}

void json_put_bool(struct json *j, const char *key, bool value)
{
    begin_item(j, key);
    str_add(j->out, value ? "true" : "false");
}
