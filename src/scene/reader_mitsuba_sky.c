/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "scene/reader_mitsuba_private.h"
#include "scene/sun_position.h"

static const double degrees = 180.0 / 3.14159265358979323846;

static lmn_status read_double(struct props *p, const char *name, double *out)
{
    float x = (float)*out;
    lmn_status status = LMN_OK;
    if (!props_has(p, name)) return status;
    status = props_float(p, name, &x);
    *out = (double)x;
    return status;
}

static lmn_status read_whole(struct props *p, const char *name, int32_t low, int32_t high, int *out)
{
    int32_t x = *out;
    lmn_status status = props_integer(p, name, low, high, &x);
    *out = x;
    return status;
}

/* Date and place, which are Tokyo's on a summer afternoon unless given. */
static lmn_status read_time(struct props *p, struct sun_time *t)
{
    lmn_status status = LMN_OK;
    *t = (struct sun_time){.latitude = 35.689,
                           .longitude = 139.6917,
                           .timezone = 9,
                           .year = 2010,
                           .month = 7,
                           .day = 10,
                           .hour = 15};
    TRY(read_double(p, "latitude", &t->latitude));
    TRY(read_double(p, "longitude", &t->longitude));
    TRY(read_double(p, "timezone", &t->timezone));
    TRY(read_whole(p, "year", -10000, 10000, &t->year));
    TRY(read_whole(p, "month", 1, 12, &t->month));
    TRY(read_whole(p, "day", 1, 31, &t->day));
    TRY(read_double(p, "hour", &t->hour));
    TRY(read_double(p, "minute", &t->minute));
    TRY(read_double(p, "second", &t->second));
done:
    return status;
}

/* Either a direction in world space, or date and place. In the emitter's space +x is south and +y
 * is west, as Mitsuba has it. */
static lmn_status read_sun(struct props *p, struct emitter *e)
{
    lmn_status status = LMN_OK;
    struct sun_time time;
    double elevation, azimuth;
    struct vec3 d;
    TRY(read_time(p, &time));
    if (props_has(p, "sun_direction")) {
        TRY(props_point(p, "sun_direction", &d));
        d = transform_vector_inverse(&e->to_world, d);
        float length = vec3_length(d);
        if (!(length > 0.0f) || !isfinite(length))
            return fail_node(p->r, p->node, "\"sun_direction\" has no length");
        elevation = asin(fmin(fmax((double)(d.z / length), -1.0), 1.0)) * degrees;
        azimuth = atan2((double)d.y, (double)d.x) * degrees;
    } else {
        sun_position(&time, &elevation, &azimuth);
        azimuth -= 180.0;
    }
    if (elevation < 0.0)
        note_ignored(p->r, p->node,
                     "the sun: it is below the horizon, so the sky has the light of "
                     "one that sets");
    e->sun_elevation = (float)elevation;
    e->sun_azimuth = (float)azimuth;
done:
    return status;
}

lmn_status read_sky(struct props *p, struct emitter *e)
{
    static const char *const ignored[] = {"albedo", "complex_sun", "stretch", "resolution",
                                          "extend"};
    lmn_status status = LMN_OK;
    bool is_sun = strcmp(p->type, "sun") == 0, is_sky = strcmp(p->type, "sky") == 0;
    float radius = 1.0f, scale = 1.0f;
    e->kind = EMITTER_SKY;
    e->turbidity = 3.0f;
    e->sun_aperture = 0.5358f;
    TRY(props_transform(p, "to_world", &e->to_world));
    if (p->node->is_legacy) { /* up was +y, south +z and west -x */
        static const double axes[16] = {0, -1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 1};
        struct transform t;
        if (transform_from_matrix(axes, &t)) e->to_world = transform_mul(&e->to_world, &t);
    }
    TRY(read_sun(p, e));
    TRY(props_float(p, "turbidity", &e->turbidity));
    if (!(e->turbidity >= 1.0f && e->turbidity <= 10.0f))
        return fail_node(p->r, p->node, "\"turbidity\" must be from 1 to 10");
    TRY(props_float(p, "scale", &scale)); /* of 0.x: for those of the other two that are absent */
    e->sky_scale = is_sun ? 0.0f : scale;
    e->sun_scale = is_sky ? 0.0f : scale;
    if (!is_sun) TRY(props_float(p, "sky_scale", &e->sky_scale));
    if (!is_sky) TRY(props_float(p, "sun_scale", &e->sun_scale));
    if (!(e->sky_scale >= 0.0f && e->sun_scale >= 0.0f))
        return fail_node(p->r, p->node, "a scale must not be negative");
    TRY(props_positive(p, "sun_aperture", &e->sun_aperture));
    TRY(props_float(p, "sun_radius_scale", &radius)); /* of 0.x, where 0 is a direction */
    e->sun_aperture = fmaxf(e->sun_aperture * radius, 1e-3f);
    if (!(radius >= 0.0f && e->sun_aperture < 180.0f))
        return fail_node(p->r, p->node, "the sun's aperture must be from 0 to 180 degrees");
    for (size_t i = 0; i < sizeof ignored / sizeof *ignored; i++) props_ignore(p, ignored[i]);
done:
    return status;
}
