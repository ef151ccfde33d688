/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/sun_position.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

/* Days from noon of 1 January 2000 to the midnight that a Gregorian date begins with. */
static double days_since_2000(int year, int month, int day)
{
    /* Years that begin in March have their leap day at their end. */
    long y = month > 2 ? year : year - 1L, m = month > 2 ? month - 3 : month + 9;
    long leaps = (long)floor((double)y / 4.0) - (long)floor((double)y / 100.0) +
                 (long)floor((double)y / 400.0);
    long n = 365 * y + leaps + (153 * m + 2) / 5 + day - 1;
    return (double)(n - 730425) - 0.5; /* that many to 1 January 2000 */
}

void sun_position(const struct sun_time *t, double *elevation, double *azimuth)
{
    double hours = t->hour - t->timezone + (t->minute + t->second / 60.0) / 60.0; /* UT */
    double n = days_since_2000(t->year, t->month, t->day) + hours / 24.0;

    double omega = 2.1429 - 0.0010394594 * n;
    double mean_longitude = 4.8950630 + 0.017202791698 * n;
    double anomaly = 6.2400600 + 0.0172019699 * n;
    double longitude = mean_longitude + 0.03341607 * sin(anomaly) + 0.00034894 * sin(2 * anomaly) -
                       0.0001134 - 0.0000203 * sin(omega);
    double obliquity = 0.4090928 - 6.2140e-9 * n + 0.0000396 * cos(omega);
    double ascension = atan2(cos(obliquity) * sin(longitude), cos(longitude));
    double declination = asin(sin(obliquity) * sin(longitude));

    double sidereal = 6.6974243242 + 0.0657098283 * n + hours;
    double hour_angle = (sidereal * 15.0 + t->longitude) * (pi / 180.0) - ascension;
    double latitude = t->latitude * (pi / 180.0);
    double zenith = acos(cos(latitude) * cos(hour_angle) * cos(declination) +
                         sin(declination) * sin(latitude));
    double angle = atan2(-sin(hour_angle),
                         tan(declination) * cos(latitude) - sin(latitude) * cos(hour_angle));
    zenith += 6371.01 / 149597890.0 * sin(zenith); /* parallax: seen from the surface */
    *elevation = 90.0 - zenith * (180.0 / pi);
    *azimuth = (angle < 0.0 ? angle + 2.0 * pi : angle) * (180.0 / pi);
}
