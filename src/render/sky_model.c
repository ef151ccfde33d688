/* SPDX-License-Identifier: Apache-2.0 */
#include "render/sky_model.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

/* The integral of the CIE 1931 luminous efficiency over wavelength, nm. */
static const double efficiency_integral = 106.857;

static struct vec3 srgb_from_xyz(double x, double y, double z)
{
    return vec3((float)(3.2404542 * x - 1.5371385 * y - 0.4985314 * z),
                (float)(-0.9692660 * x + 1.8760108 * y + 0.0415560 * z),
                (float)(0.0556434 * x - 0.2040259 * y + 1.0572252 * z));
}

/* Colours outside of sRGB have negative parts, which lights cannot have. */
static struct vec3 positive(struct vec3 c)
{
    return vec3(max_float(c.x, 0.0f), max_float(c.y, 0.0f), max_float(c.z, 0.0f));
}

static double perez(const double c[5], double cos_theta, double gamma, double cos_gamma)
{
    return (1.0 + c[0] * exp(c[1] / fmax(cos_theta, 1e-3))) *
           (1.0 + c[2] * exp(c[3] * gamma) + c[4] * cos_gamma * cos_gamma);
}

/* Appendix A.2: a cubic in the sun's angle to the zenith whose factors are quadratic in turbidity.
 */
static double zenith_chromaticity(const double f[3][4], double turbidity, double angle)
{
    double t[3] = {turbidity * turbidity, turbidity, 1.0}, sum = 0.0;
    for (int i = 0; i < 3; i++)
        sum += t[i] * (((f[i][0] * angle + f[i][1]) * angle + f[i][2]) * angle + f[i][3]);
    return sum;
}

void sky_model_init(struct sky_model *m, double turbidity, double elevation)
{
    static const double slope[3][5] = {{0.1787, -0.3554, -0.0227, 0.1206, -0.0670},
                                       {-0.0193, -0.0665, -0.0004, -0.0641, -0.0033},
                                       {-0.0167, -0.0950, -0.0079, -0.0441, -0.0109}};
    static const double offset[3][5] = {{-1.4630, 0.4275, 5.3251, -2.5771, 0.3703},
                                        {-0.2592, 0.0008, 0.2125, -0.8989, 0.0452},
                                        {-0.2608, 0.0092, 0.2102, -1.6537, 0.0529}};
    static const double x[3][4] = {{0.00166, -0.00375, 0.00209, 0.0},
                                   {-0.02903, 0.06377, -0.03202, 0.00394},
                                   {0.11693, -0.21196, 0.06052, 0.25886}};
    static const double y[3][4] = {{0.00275, -0.00610, 0.00317, 0.0},
                                   {-0.04214, 0.08970, -0.04153, 0.00516},
                                   {0.15346, -0.26756, 0.06670, 0.26688}};
    double t = fmin(fmax(turbidity, 2.0), 10.0);
    double angle = 0.5 * pi - fmin(fmax(elevation, 0.0), 0.5 * pi);
    double chi = (4.0 / 9.0 - t / 120.0) * (pi - 2.0 * angle);
    double kcd = (4.0453 * t - 4.9710) * tan(chi) - 0.2155 * t + 2.4192;
    /* 683 lm / W */
    m->zenith[0] = fmax(kcd, 0.0) * 1000.0 / (683.0 * efficiency_integral);
    m->zenith[1] = zenith_chromaticity(x, t, angle);
    m->zenith[2] = zenith_chromaticity(y, t, angle);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 5; k++) m->perez[i][k] = slope[i][k] * t + offset[i][k];
        m->zenith[i] /= perez(m->perez[i], 1.0, angle, cos(angle));
    }
}

struct vec3 sky_model_radiance(const struct sky_model *m, float cos_theta, float cos_gamma)
{
    double c = fmin(fmax((double)cos_gamma, -1.0), 1.0), gamma = acos(c), v[3];
    for (int i = 0; i < 3; i++)
        v[i] = m->zenith[i] * perez(m->perez[i], (double)cos_theta, gamma, c);
    if (!(v[0] > 0.0 && v[2] > 1e-3)) return vec3_splat(0.0f);
    double scale = v[0] / v[2];
    return positive(srgb_from_xyz(v[1] * scale, v[0], (1.0 - v[1] - v[2]) * scale));
}

/* One lobe of the fits to the CIE 1931 colour matching functions of Wyman, Sloan & Shirley (2013):
 * a Gaussian whose width differs on both sides. */
static double lobe(double nm, double middle, double below, double above)
{
    double x = (nm - middle) * (nm < middle ? below : above);
    return exp(-0.5 * x * x);
}

/* Black body, W / (m^2 sr nm). */
static double planck(double nm, double kelvin)
{
    const double h = 6.62607015e-34, c = 299792458.0, k = 1.380649e-23;
    double m = nm * 1e-9;
    return 2e-9 * h * c * c / (pow(m, 5.0) * expm1(h * c / (m * k * kelvin)));
}

struct vec3 sky_model_sun(double turbidity, double elevation)
{
    if (!(elevation > 0.0)) return vec3_splat(0.0f);
    const double step = 5.0, half = 0.5 * SKY_SUN_APERTURE * pi / 180.0;
    double degrees = elevation * 180.0 / pi, sum[3] = {0};
    /* Relative optical mass (Kasten 1965); haze after Angstrom with wavelength exponent 1.3. */
    double mass = 1.0 / (sin(elevation) + 0.15 * pow(degrees + 3.885, -1.253));
    double haze = fmax(0.04608 * turbidity - 0.04586, 0.0);
    for (double nm = 380.0; nm <= 780.0; nm += step) {
        double um = nm * 1e-3, band = (um - 0.6) / 0.06;
        double depth = 0.008735 * pow(um, -4.08) + haze * pow(um, -1.3) +
                       0.35 * 0.12 * exp(-band * band);
        double light = planck(nm, 5778.0) * exp(-depth * mass);
        sum[0] += light * (1.056 * lobe(nm, 599.8, 0.0264, 0.0323) +
                           0.362 * lobe(nm, 442.0, 0.0624, 0.0374) -
                           0.065 * lobe(nm, 501.1, 0.0490, 0.0382));
        sum[1] += light * (0.821 * lobe(nm, 568.8, 0.0213, 0.0247) +
                           0.286 * lobe(nm, 530.9, 0.0613, 0.0322));
        sum[2] += light * (1.217 * lobe(nm, 437.0, 0.0845, 0.0278) +
                           0.681 * lobe(nm, 459.0, 0.0385, 0.0725));
    }
    double scale = step / efficiency_integral * 2.0 * pi * (1.0 - cos(half));
    return positive(srgb_from_xyz(sum[0] * scale, sum[1] * scale, sum[2] * scale));
}
