/* SPDX-License-Identifier: Apache-2.0 */
#include "base/str.h"

#include <ctype.h>
#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/mem.h"

static bool reserve(struct str *s, size_t extra)
{
    if (s->failed) return false;
    void *block = s->text;
    s->failed = extra > (size_t)-1 - s->length - 1 ||
                !mem_grow(&block, &s->capacity, s->length + extra + 1, 1);
    s->text = block;
    return !s->failed;
}

void str_add(struct str *s, const char *format, ...)
{
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    int n = vsnprintf(NULL, 0, format, args);
    va_end(args);
    if (n >= 0 && reserve(s, (size_t)n)) {
        vsnprintf(s->text + s->length, (size_t)n + 1, format, again);
        s->length += (size_t)n;
    }
    va_end(again);
}

void str_add_bytes(struct str *s, const void *bytes, size_t size)
{
    if (!reserve(s, size)) return;
    memcpy(s->text + s->length, bytes, size);
    s->length += size;
    s->text[s->length] = '\0';
}

void str_release(struct str *s)
{
    mem_free(s->text);
    *s = (struct str){0};
}

bool str_starts(const char *text, const char *prefix)
{
    return strncmp(text, prefix, strlen(prefix)) == 0;
}

bool str_ends(const char *text, const char *suffix)
{
    size_t n = strlen(text), m = strlen(suffix);
    return n >= m && strcmp(text + n - m, suffix) == 0;
}

bool str_to_double(const char *text, double *out)
{
    static locale_t c_locale; /* created once, never changed: strtod_l needs a handle */
    locale_t loc = __atomic_load_n(&c_locale, __ATOMIC_ACQUIRE);
    if (!loc) {
        locale_t fresh = newlocale(LC_ALL_MASK, "C", (locale_t)0);
        locale_t none = (locale_t)0;
        if (__atomic_compare_exchange_n(&c_locale, &none, fresh, false, __ATOMIC_ACQ_REL,
                                        __ATOMIC_ACQUIRE)) {
            loc = fresh;
        } else {
            freelocale(fresh);
            loc = none;
        }
    }
    char *end;
    double value = strtod_l(text, &end, loc);
    if (end == text || !isfinite(value)) return false;
    while (isspace((unsigned char)*end)) end++;
    if (*end) return false;
    *out = value;
    return true;
}

/* Damerau-Levenshtein distance (adjacent swaps count as one), for words of up to 63 letters. */
static size_t edit_distance(const char *a, const char *b)
{
    size_t n = strlen(a), m = strlen(b);
    if (n > 63 || m > 63) return (size_t)-1;
    unsigned char d[64][64];
    for (size_t i = 0; i <= n; i++) d[i][0] = (unsigned char)i;
    for (size_t j = 0; j <= m; j++) d[0][j] = (unsigned char)j;
    for (size_t i = 1; i <= n; i++) {
        for (size_t j = 1; j <= m; j++) {
            int same = tolower((unsigned char)a[i - 1]) == tolower((unsigned char)b[j - 1]);
            int best = d[i - 1][j - 1] + !same;
            if (d[i - 1][j] + 1 < best) best = d[i - 1][j] + 1;
            if (d[i][j - 1] + 1 < best) best = d[i][j - 1] + 1;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] &&
                d[i - 2][j - 2] + 1 < best)
                best = d[i - 2][j - 2] + 1;
            d[i][j] = (unsigned char)best;
        }
    }
    return d[n][m];
}

const char *str_closest(const char *word, const char *const *candidates, size_t n)
{
    size_t best = strlen(word) / 3 + 1; /* further away than this is another word */
    const char *closest = NULL;
    for (size_t i = 0; i < n; i++) {
        size_t d = edit_distance(word, candidates[i]);
        if (d < best || (d == best && !closest)) {
            best = d;
            closest = candidates[i];
        }
    }
    return closest;
}
