/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_SKY_MODEL_H
#define RENDER_SKY_MODEL_H

#include "math/vec.h"

/*
 * The clear sky of Preetham, Shirley & Smits (1999), "A practical analytic model for daylight",
 * appendices A.1 and A.2: luminance and chromaticity by Perez' formula with coefficients that are
 * linear in turbidity. Results are linear sRGB in W / (m^2 sr nm), weighted by the luminous
 * efficiency: equal energy at all wavelengths has luminance 1, as in Mitsuba 3's sunsky.
 */
struct sky_model {
    double perez[3][5]; /* of Y, x, y: A .. E */
    double zenith[3];   /* Y, x, y, divided by Perez' function there */
};

/* The fits hold for turbidities from 2 (very clear) to 10 (haze), which are the limits taken, and
 * for a sun above the horizon: one below it counts as on it. `elevation` in radians. */
void sky_model_init(struct sky_model *m, double turbidity, double elevation);

/* Radiance from a direction at an angle of cosine cos_theta > 0 to the zenith and cos_gamma to the
 * sun; not negative. */
struct vec3 sky_model_radiance(const struct sky_model *m, float cos_theta, float cos_gamma);

/* What the sun sends to a surface that faces it: W / (m^2 nm), as above. A black body of 5778 K of
 * the sun's size, through air (Rayleigh), haze (Angstrom) and ozone, the first two as in appendix
 * A.3 of the same paper; ozone's Chappuis bands are one Gaussian. Zero below the horizon. */
struct vec3 sky_model_sun(double turbidity, double elevation);

/* The sun's diameter, degrees. */
#define SKY_SUN_APERTURE 0.5358

#endif
