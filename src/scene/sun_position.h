/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_SUN_POSITION_H
#define SCENE_SUN_POSITION_H

/* A place on earth and a time there; degrees, north and east positive, and hours. */
struct sun_time {
    double latitude, longitude, timezone;
    int year, month, day;
    double hour, minute, second;
};

/* Where the sun stands, in degrees: elevation above the horizon, azimuth clockwise from north. The
 * algorithm of Blanco-Muriel et al. (2001), "Computing the solar vector": within a minute of arc
 * from 1999 to 2015, and good for pictures a century around. */
void sun_position(const struct sun_time *t, double *elevation, double *azimuth);

#endif
