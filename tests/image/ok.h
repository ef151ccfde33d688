/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_IMAGE_OK_H
#define TESTS_IMAGE_OK_H

#include "cmocka_all.h"

#include "base/error.h"

/* Where the calls of a test put their text. */
static struct error err;

/* Fails the test with that text unless the call succeeds. */
#define OK(call)                                        \
    do {                                                \
        if ((call) != LMN_OK) fail_msg("%s", err.text); \
    } while (0)

#endif
