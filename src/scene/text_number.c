/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/text_number.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "base/str.h"

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* The rare numbers that the short way would not round correctly. */
static bool slow_float(const char *start, const char *end, float *out)
{
    char token[512];
    double value;
    size_t n = (size_t)(end - start);
    if (n >= sizeof token) return false;
    memcpy(token, start, n);
    token[n] = '\0';
    if (!str_to_double(token, &value)) return false;
    *out = (float)value;
    return isfinite(*out);
}

bool text_to_float(const char **text, float *out)
{
    /* Powers of ten that a double holds exactly (Clinger 1990): with a mantissa below 2^53 one
     * multiplication or division is correctly rounded. */
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                    1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                    1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const char *p = *text, *start = p;
    bool is_negative = *p == '-';
    uint64_t mantissa = 0;
    int exponent = 0, n_digits = 0, n_significant = 0;
    if (*p == '-' || *p == '+') p++;
    for (; is_digit(*p); p++, n_digits++) {
        if (n_significant < 18) {
            mantissa = 10 * mantissa + (uint64_t)(*p - '0');
            n_significant += mantissa != 0;
        } else {
            n_significant = 19; /* too many: the slow way */
        }
    }
    if (*p == '.') {
        for (p++; is_digit(*p); p++, n_digits++) {
            if (n_significant < 18) {
                mantissa = 10 * mantissa + (uint64_t)(*p - '0');
                n_significant += mantissa != 0;
                exponent--;
            } else {
                n_significant = 19;
            }
        }
    }
    if (n_digits == 0) return false;
    if ((*p == 'e' || *p == 'E') &&
        (is_digit(p[1]) || ((p[1] == '-' || p[1] == '+') && is_digit(p[2])))) {
        bool is_below = p[1] == '-';
        int e = 0;
        for (p += is_digit(p[1]) ? 1 : 2; is_digit(*p); p++) {
            if (e < 10000) e = 10 * e + (*p - '0');
        }
        exponent += is_below ? -e : e;
    }
    if (n_significant > 18 || mantissa >= (UINT64_C(1) << 53) || exponent < -22 || exponent > 22) {
        if (!slow_float(start, p, out)) return false;
    } else {
        double value = (double)mantissa;
        value = exponent < 0 ? value / powers[-exponent] : value * powers[exponent];
        *out = (float)(is_negative ? -value : value);
        if (!isfinite(*out)) return false;
    }
    *text = p;
    return true;
}

bool text_to_int(const char **text, int *out)
{
    const char *p = *text;
    bool is_negative = *p == '-';
    int value = 0, n = 0;
    if (*p == '-' || *p == '+') p++;
    for (; is_digit(*p); p++, n++) {
        if (n == 9) return false;
        value = 10 * value + (*p - '0');
    }
    if (n == 0) return false;
    *out = is_negative ? -value : value;
    *text = p;
    return true;
}
