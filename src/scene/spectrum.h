/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_SPECTRUM_H
#define SCENE_SPECTRUM_H

#include <stdbool.h>
#include <stddef.h>

#include "math/vec.h"

/* Colours given by wavelength, as linear sRGB. */

struct spectrum_sample {
    double nm, value;
};

/*
 * The curve through s [n], wavelengths increasing, linear between them and 0 outside; n below 2
 * gives black. Light is seen as it is (equal energy at all wavelengths is slightly red in sRGB),
 * anything else under D65, so that a constant curve of 1 is white. Channels can be negative and
 * above 1. This is what the RGB variants of Mitsuba 3 do.
 */
struct vec3 spectrum_to_rgb(const struct spectrum_sample *s, size_t n, bool is_light);

/* Radiance of a black body, W / (m^2 sr nm), averaged by the observer. */
struct vec3 spectrum_blackbody(double kelvin);

#endif
