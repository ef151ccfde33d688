/* SPDX-License-Identifier: Apache-2.0 */
#include "json_out.h"

#include <math.h>
#include <stdlib.h>

static void quote(FILE *f, const char *text)
{
    fputc('"', f);
    for (; *text; text++) {
        const unsigned char c = (unsigned char)*text;
        if (c == '"' || c == '\\')
            fprintf(f, "\\%c", c);
        else if (c < 0x20)
            fprintf(f, "\\u%04x", c);
        else
            fputc(c, f);
    }
    fputc('"', f);
}

static void start(struct json_out *j, const char *key)
{
    if (j->n_items[j->depth]++ > 0) fputc(',', j->f);
    if (key) {
        quote(j->f, key);
        fputc(':', j->f);
    }
}

static void open_level(struct json_out *j, const char *key, char opener, char closer)
{
    start(j, key);
    fputc(opener, j->f);
    if (j->depth < 16) j->depth++;
    j->n_items[j->depth] = 0;
    j->closers[j->depth] = closer;
}

void jo_object(struct json_out *j, const char *key)
{
    open_level(j, key, '{', '}');
}

void jo_array(struct json_out *j, const char *key)
{
    open_level(j, key, '[', ']');
}

void jo_end(struct json_out *j)
{
    if (j->depth == 0) return;
    fputc(j->closers[j->depth--], j->f);
    if (j->depth == 0) fputc('\n', j->f);
}

void jo_string(struct json_out *j, const char *key, const char *value)
{
    start(j, key);
    if (value)
        quote(j->f, value);
    else
        fputs("null", j->f);
}

void jo_number(struct json_out *j, const char *key, double value)
{
    char text[40];
    start(j, key);
    if (!isfinite(value)) {
        fputs("null", j->f);
        return;
    }
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value) break;
    }
    fputs(text, j->f);
}

void jo_count(struct json_out *j, const char *key, uint64_t value)
{
    start(j, key);
    fprintf(j->f, "%llu", (unsigned long long)value);
}

void jo_bool(struct json_out *j, const char *key, bool value)
{
    start(j, key);
    fputs(value ? "true" : "false", j->f);
}

void jo_raw(struct json_out *j, const char *key, const char *json)
{
    start(j, key);
    fputs(json, j->f);
}
