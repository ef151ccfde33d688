/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BASE_JSON_H
#define BASE_JSON_H

#include <stdint.h>

#include "base/str.h"

/*
 * Writes JSON into a struct str; commas and quoting are taken care of. `key` is NULL inside an
 * array. Reading is jansson's work.
 *
 *   struct json j = {.out = &s};
 *   json_begin_object(&j, NULL);  json_put_number(&j, "loss", 0.5);  json_end(&j);
 *
 * Numbers are the shortest text that reads back as the same double (float for json_put_float); what
 * is not finite becomes null. Nesting is limited to 32.
 */
struct json {
    struct str *out;
    uint32_t depth;
    uint32_t n_items[33]; /* written so far at each depth */
    char closers[33];     /* ']' or '}' */
};

void json_begin_object(struct json *j, const char *key);
void json_begin_array(struct json *j, const char *key);
void json_end(struct json *j); /* closes the innermost object or array */
void json_put_string(struct json *j, const char *key, const char *value); /* NULL: null */
void json_put_number(struct json *j, const char *key, double value);
void json_put_float(struct json *j, const char *key, float value);
void json_put_integer(struct json *j, const char *key, int64_t value);
void json_put_bool(struct json *j, const char *key, bool value);

#endif
