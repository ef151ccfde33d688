/* SPDX-License-Identifier: Apache-2.0 */
#include "image/image.h"

#include <math.h>

float srgb_encode(float linear)
{
    if (!(linear > 0)) return 0; /* NaN too */
    if (linear >= 1) return 1;
    if (linear <= 0.0031308f) return 12.92f * linear;
    return 1.055f * powf(linear, 1 / 2.4f) - 0.055f;
}

float srgb_decode(float encoded)
{
    if (!(encoded > 0)) return 0;
    if (encoded >= 1) return 1;
    if (encoded <= 0.04045f) return encoded / 12.92f;
    return powf((encoded + 0.055f) / 1.055f, 2.4f);
}
