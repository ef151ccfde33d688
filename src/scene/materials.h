/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_MATERIALS_H
#define SCENE_MATERIALS_H

#include <stdbool.h>
#include <stddef.h>

#include "math/vec.h"

/* Optical constants by name. */

struct named_ior {
    const char *name;
    float ior;
};

struct named_conductor {
    const char *name;
    struct vec3 eta, k; /* complex index of refraction eta + i k at R, G, B */
};

bool find_ior(const char *name, float *ior);
bool find_conductor(const char *name, struct vec3 *eta, struct vec3 *k);

enum { MAX_MATERIAL_NAMES = 64 };

/* All names, for "did you mean"; return how many. */
size_t ior_names(const char **names, size_t max);
size_t conductor_names(const char **names, size_t max);

#endif
