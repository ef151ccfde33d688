/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_OPTIONS_H
#define TRAIN_OPTIONS_H

#include "base/error.h"
#include "base/json.h"

/*
 * What a training is told: lmn_train_options (meanings in lumenaut.h) with the paper's values as
 * defaults. One table of fields serves defaults, checks, writing and reading.
 */

void options_init(lmn_train_options *o);

/* The defaults of a method, LMN_METHOD_*. */
void options_init_method(lmn_train_options *o, uint32_t method);

/* "spp=4": a field by its name, as options_write() calls it; the message says what is wrong. What
 * goes together is left to options_check(). */
lmn_status options_assign(lmn_train_options *o, const char *assignment, struct error *err);

/* Every value within its range, and values that go together; the message names the option. */
lmn_status options_check(const lmn_train_options *o, struct error *err);

/* Appends one member per option to the open object, in a fixed order. */
void options_write(const lmn_train_options *o, struct json *j);

/* Reads what options_write() wrote, from the text of one JSON object: unknown names, missing ones
 * and values out of range are errors. `where` starts messages. */
lmn_status options_read(const char *text, const char *where, lmn_train_options *o,
                        struct error *err);

#endif
