/* SPDX-License-Identifier: Apache-2.0 */
#ifndef JSON_OUT_H
#define JSON_OUT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/*
 * Writes one JSON document to a stream, compactly; commas and quoting are taken care of. `key` is
 * NULL inside an array and for the outermost value.
 *
 *   struct json_out j = {.f = stdout};
 *   jo_object(&j, NULL);  jo_number(&j, "loss", 0.5);  jo_end(&j);
 *
 * Numbers are the shortest text that reads back as the same double; what is not finite is null.
 * The outermost end writes a newline. Nesting is limited to 16.
 */
struct json_out {
    FILE *f;
    uint32_t depth;
    uint32_t n_items[17];
    char closers[17];
};

void jo_object(struct json_out *j, const char *key);
void jo_array(struct json_out *j, const char *key);
void jo_end(struct json_out *j);
void jo_string(struct json_out *j, const char *key, const char *value);
void jo_number(struct json_out *j, const char *key, double value);
void jo_count(struct json_out *j, const char *key, uint64_t value);
void jo_bool(struct json_out *j, const char *key, bool value);
void jo_raw(struct json_out *j, const char *key, const char *json); /* ready-made JSON */

#endif
