/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_NN_STORED_H
#define TESTS_NN_STORED_H

#include <stddef.h>
#include <stdint.h>

#include <jansson.h>

/* Arrays that scripts/references/ wrote down: tests/nn/data/NAME.json and NAME.bin;
 * LMN_REFERENCES=PARENT reads PARENT/nn instead. What is not there fails the test. */
struct stored {
    json_t *json;
    float *floats;
    size_t n_floats;
};

void stored_load(struct stored *r, const char *name);
void stored_release(struct stored *r);

uint32_t stored_number(const struct stored *r, const char *name);

/* The n values called `name`. */
const float *stored_values(const struct stored *r, const char *name, size_t n);

/* |got - want| <= relative * the largest of want. */
void check_close(const char *what, const float *got, const float *want, size_t n, double relative);

#endif
