/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BASE_STR_H
#define BASE_STR_H

#include <stdbool.h>
#include <stddef.h>

/*
 * A growing text. Always NUL-terminated once something was added; `text` may be read directly.
 * A failed allocation sets `failed` and later calls do nothing, so that a long run of adds needs
 * one check at its end.
 *
 *   struct str s = {0};  str_add(&s, "%d", 3);  if (s.failed) ...  str_release(&s);
 */
struct str {
    char *text;
    size_t length, capacity;
    bool failed;
};

__attribute__((format(printf, 2, 3))) void str_add(struct str *s, const char *format, ...);
void str_add_bytes(struct str *s, const void *bytes, size_t size);
void str_release(struct str *s);

bool str_starts(const char *text, const char *prefix);
bool str_ends(const char *text, const char *suffix);

/* The whole of `text` as a finite number; false when it is anything else ("1x", "", "nan").
 * Independent of the locale. */
bool str_to_double(const char *text, double *out);

/* The candidate closest to `word` by edit distance, or NULL when none is close enough to be what
 * was meant. */
const char *str_closest(const char *word, const char *const *candidates, size_t n);

#endif
