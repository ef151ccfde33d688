/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_TEXT_NUMBER_H
#define SCENE_TEXT_NUMBER_H

#include <stdbool.h>

/*
 * Reads a decimal number ("-1", ".5", "9.6e-008") at *text, which ends with a NUL somewhere, and
 * moves *text behind it. Independent of the locale and several times faster than strtod. False,
 * with *text unmoved, when there is no number or it is too large for a float.
 */
bool text_to_float(const char **text, float *out);

/* The same for a whole number of at most nine digits with sign. */
bool text_to_int(const char **text, int *out);

#endif
