/* SPDX-License-Identifier: Apache-2.0 */
#include "base/error.h"

#include <stdio.h>

lmn_status fail(struct error *err, lmn_status status, const char *format, ...)
{
    if (!err) return status;
    va_list args;
    va_start(args, format);
    vsnprintf(err->text, sizeof err->text, format, args);
    va_end(args);
    /* Names from files may hold line breaks; a message is one line whatever they hold. */
    for (char *c = err->text; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7F) *c = ' ';
    return status;
}

lmn_status fail_memory(struct error *err, const char *what)
{
    return fail(err, LMN_ERR_MEMORY, "not enough memory for %s", what);
}
