/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BASE_ERROR_H
#define BASE_ERROR_H

#include <stdarg.h>

#include <lumenaut/lumenaut.h> /* lmn_status */

/*
 * The text that goes with a failed lmn_status. The caller owns the struct (usually on its stack or
 * in the context); functions that can fail take it as their last argument and fill it once, where
 * the failure is first seen. Text reads like a compiler's: `file:line:column: what; did you mean`.
 */
struct error {
    char text[1024];
};

/* Writes the text and returns `status`, so that a failing branch is one line. `err` may be NULL. */
__attribute__((format(printf, 3, 4))) lmn_status fail(struct error *err, lmn_status status,
                                                      const char *format, ...);

/* fail() for memory: `what` names the thing that did not fit. */
lmn_status fail_memory(struct error *err, const char *what);

/* Leaves through `done` with `status` set when the call fails. */
#define TRY(call)                                   \
    do {                                            \
        if ((status = (call)) != LMN_OK) goto done; \
    } while (0)

#endif
