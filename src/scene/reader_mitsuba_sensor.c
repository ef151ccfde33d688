/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/reader_mitsuba_private.h"

/* The sensor with its sampler and film. Defaults are Mitsuba 3's. */

/* ---- Film --------------------------------------------------------------------------------- */

static lmn_status read_rfilter(struct reader *r, struct xml_node *node, struct render_settings *s)
{
    static const char *const words[] = {"box",      "tent",       "gaussian",
                                        "mitchell", "catmullrom", "lanczos"};
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_object object;
    if (strcmp(p.type, "box") == 0) {
        s->filter = FILTER_BOX;
        s->filter_radius = 0.5f;
        TRY(props_positive(&p, "radius", &s->filter_radius));
    } else if (strcmp(p.type, "tent") == 0) {
        s->filter = FILTER_TENT;
        s->filter_radius = 1.0f;
        TRY(props_positive(&p, "radius", &s->filter_radius));
    } else if (strcmp(p.type, "gaussian") == 0) {
        s->filter = FILTER_GAUSSIAN;
        s->filter_stddev = 0.5f;
        TRY(props_positive(&p, "stddev", &s->filter_stddev));
        s->filter_radius = 4.0f * s->filter_stddev;
    } else {
        size_t i = 3, n = sizeof words / sizeof *words;
        while (i < n && strcmp(p.type, words[i]) != 0) i++;
        if (i == n) return fail_unknown(r, node, "unknown rfilter", p.type, words, n);
        /* These have negative lobes; the builder's default stands in for them. */
        char what[80];
        snprintf(what, sizeof what, "rfilter \"%s\": taken as gaussian", p.type);
        note_ignored(r, node, what);
        props_ignore_rest(&p);
    }
    if (s->filter_radius > 16.0f) return fail_node(r, node, "the filter is wider than 16 pixels");
    TRY(props_finish(&p, &object));
done:
    return status;
}

/* The part of the film that is rendered: it becomes the picture. */
static lmn_status read_crop(struct props *p, struct render_settings *s, struct sensor *sensor)
{
    lmn_status status = LMN_OK;
    const int32_t film[2] = {(int32_t)s->width, (int32_t)s->height};
    int32_t x = 0, y = 0;
    TRY(props_integer(p, "crop_offset_x", 0, film[0] - 1, &x));
    TRY(props_integer(p, "crop_offset_y", 0, film[1] - 1, &y));
    int32_t width = film[0] - x, height = film[1] - y;
    TRY(props_integer(p, "crop_width", 1, film[0] - x, &width));
    TRY(props_integer(p, "crop_height", 1, film[1] - y, &height));
    s->width = (uint32_t)width;
    s->height = (uint32_t)height;
    sensor->crop.left = (float)x / (float)film[0];
    sensor->crop.top = (float)y / (float)film[1];
    sensor->crop.right = (float)(film[0] - x - width) / (float)film[0];
    sensor->crop.bottom = (float)(film[1] - y - height) / (float)film[1];
done:
    return status;
}

static lmn_status read_film(struct reader *r, struct xml_node *node, struct render_settings *s,
                            struct sensor *sensor)
{
    static const char *const words[] = {"hdrfilm", "ldrfilm", "mfilm", "tiledhdrfilm"};
    static const char *const ignored[] = {"file_format",   "pixel_format", "component_format",
                                          "sample_border", "compensate",   "high_quality_edges",
                                          "banner",        "gamma",        "filename",
                                          "attach_log"};
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_object object;
    struct xml_node *child;
    int32_t width = (int32_t)s->width, height = (int32_t)s->height;
    if (strcmp(p.type, "specfilm") == 0) return fail_unsupported(r, node);
    size_t i = 0, n = sizeof words / sizeof *words;
    while (i < n && strcmp(p.type, words[i]) != 0) i++;
    if (i == n) return fail_unknown(r, node, "unknown film", p.type, words, n);
    if (i > 0) { /* of 0.x: other files to write, with a tone mapping */
        char what[80];
        snprintf(what, sizeof what, "%s: taken as hdrfilm", p.type);
        note_ignored(r, node, what);
    }
    TRY(props_integer(&p, "width", 1, IMAGE_MAX_SIDE, &width));
    TRY(props_integer(&p, "height", 1, IMAGE_MAX_SIDE, &height));
    s->width = (uint32_t)width;
    s->height = (uint32_t)height;
    TRY(read_crop(&p, s, sensor));
    TRY(props_object(&p, EL_RFILTER, &child));
    if (child) TRY(read_rfilter(r, child, s));
    for (size_t k = 0; k < sizeof ignored / sizeof *ignored; k++) props_ignore(&p, ignored[k]);
    if (node->is_legacy) props_ignore_rest(&p);
    TRY(props_finish(&p, &object));
done:
    return status;
}

/* ---- Sampler ------------------------------------------------------------------------------ */

static lmn_status read_sampler(struct reader *r, struct xml_node *node, struct render_settings *s)
{
    static const char *const words[] = {"independent", "multijitter", "stratified", "orthogonal",
                                        "ldsampler",   "sobol",       "halton",     "hammersley"};
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_object object;
    int32_t spp = (int32_t)s->spp, seed = 0;
    size_t i = 0;
    while (i < sizeof words / sizeof *words && strcmp(p.type, words[i]) != 0) i++;
    if (i == sizeof words / sizeof *words)
        return fail_unknown(r, node, "unknown sampler", p.type, words, i);
    s->sampler = i == 0 ? SAMPLER_INDEPENDENT : SAMPLER_SOBOL;
    if (i > 0) {
        char what[80];
        snprintf(what, sizeof what, "sampler \"%s\": taken as a scrambled Sobol sequence",
                 words[i]);
        note_ignored(r, node, what);
    }
    TRY(props_integer(&p, "sample_count", 1, 1 << 30, &spp));
    TRY(props_integer(&p, "seed", 0, INT32_MAX, &seed));
    s->spp = (uint32_t)spp;
    s->seed = (uint64_t)seed;
    props_ignore(&p, "jitter");
    props_ignore(&p, "strength");
    props_ignore(&p, "scramble");
    if (node->is_legacy) props_ignore_rest(&p);
    TRY(props_finish(&p, &object));
done:
    return status;
}

/* ---- Sensor ------------------------------------------------------------------------------- */

static bool is_rigid(const struct transform *t)
{
    for (int i = 0; i < 3; i++) {
        struct vec3 a = vec3(t->m[0][i], t->m[1][i], t->m[2][i]);
        struct vec3 b = vec3(t->m[0][(i + 1) % 3], t->m[1][(i + 1) % 3], t->m[2][(i + 1) % 3]);
        if (fabsf(vec3_dot(a, a) - 1.0f) > 2e-3f || fabsf(vec3_dot(a, b)) > 2e-3f) return false;
    }
    return true;
}

lmn_status read_fov(struct props *p, float *fov, enum fov_axis *fov_axis)
{
    static const char *const axes[] = {"x", "y", "diagonal", "smaller", "larger"};
    lmn_status status = LMN_OK;
    uint32_t axis = FOV_X;
    if (props_has(p, "fov")) {
        if (props_has(p, "focal_length"))
            return fail_node(p->r, p->node, "either \"fov\" or \"focal_length\"");
        TRY(props_positive(p, "fov", fov));
        TRY(props_choice(p, "fov_axis", axes, 5, &axis));
        if (*fov >= 180.0f) return fail_node(p->r, p->node, "\"fov\" must be below 180 degrees");
        *fov_axis = (enum fov_axis)axis;
    } else {
        const char *text = "50mm";
        TRY(props_string(p, "focal_length", &text));
        char number[32];
        double mm;
        size_t n = strlen(text);
        if (n > 2 && strcmp(text + n - 2, "mm") == 0) n -= 2;
        snprintf(number, sizeof number, "%.*s", n < sizeof number ? (int)n : 0, text);
        if (!str_to_double(number, &mm) || !(mm > 0.0))
            return fail_node(p->r, p->node, "focal_length \"%.40s\" is not like \"50mm\"", text);
        *fov = (float)(2.0 * atan(sqrt(36.0 * 36.0 + 24.0 * 24.0) / (2.0 * mm)) * 180.0 /
                       3.14159265358979323846);
        *fov_axis = FOV_DIAGONAL;
    }
done:
    return status;
}

/* An orthographic sensor is as large as its to_world makes it: the scale becomes a value of its
 * own, so that what drives the place leaves it alone. */
static lmn_status take_scale(struct reader *r, struct xml_node *node, struct sensor *s)
{
    struct vec3 axes[3], o = transform_point(&s->to_world, vec3(0, 0, 0));
    float lengths[3];
    for (int i = 0; i < 3; i++) {
        axes[i] = vec3(s->to_world.m[0][i], s->to_world.m[1][i], s->to_world.m[2][i]);
        lengths[i] = vec3_length(axes[i]);
        axes[i] = vec3_scale(axes[i], 1.0f / lengths[i]);
    }
    double rigid[16] = {(double)axes[0].x,
                        (double)axes[1].x,
                        (double)axes[2].x,
                        (double)o.x,
                        (double)axes[0].y,
                        (double)axes[1].y,
                        (double)axes[2].y,
                        (double)o.y,
                        (double)axes[0].z,
                        (double)axes[1].z,
                        (double)axes[2].z,
                        (double)o.z,
                        0.0,
                        0.0,
                        0.0,
                        1.0};
    if (!transform_from_matrix(rigid, &s->to_world) || !is_rigid(&s->to_world))
        return fail_node(r, node, "the sensor's to_world must not shear");
    s->scale_x = lengths[0];
    s->scale_y = lengths[1];
    return LMN_OK;
}

static lmn_status read_optics(struct props *p, struct sensor *s)
{
    lmn_status status = LMN_OK;
    if (s->kind == SENSOR_ORTHOGRAPHIC) {
        TRY(take_scale(p->r, p->node, s));
        props_ignore(p, "focus_distance");
        goto done;
    }
    if (!is_rigid(&s->to_world))
        return fail_node(p->r, p->node, "the sensor's to_world must not scale or shear");
    TRY(read_fov(p, &s->fov, &s->fov_axis));
    TRY(props_float(p, "principal_point_offset_x", &s->shift_x));
    TRY(props_float(p, "principal_point_offset_y", &s->shift_y));
    if (!(fabsf(s->shift_x) <= SENSOR_MAX_SHIFT && fabsf(s->shift_y) <= SENSOR_MAX_SHIFT))
        return fail_node(p->r, p->node, "the principal point is more than %g films aside",
                         SENSOR_MAX_SHIFT);
    if (s->kind != SENSOR_THINLENS) {
        props_ignore(p, "focus_distance");
        props_ignore(p, "aperture_radius");
        goto done;
    }
    if (!props_has(p, "aperture_radius"))
        return fail_node(p->r, p->node, "thinlens needs an \"aperture_radius\"");
    TRY(props_float(p, "aperture_radius", &s->aperture_radius));
    if (!(s->aperture_radius >= 0.0f && s->aperture_radius <= SENSOR_MAX_APERTURE))
        return fail_node(p->r, p->node, "\"aperture_radius\" must be from 0 to %g",
                         SENSOR_MAX_APERTURE);
    s->focus_distance = fminf(s->far_clip, SENSOR_MAX_FOCUS);
    TRY(props_positive(p, "focus_distance", &s->focus_distance));
    if (!(s->focus_distance >= SENSOR_MIN_FOCUS && s->focus_distance <= SENSOR_MAX_FOCUS))
        return fail_node(p->r, p->node, "\"focus_distance\" must be from %g to %g",
                         SENSOR_MIN_FOCUS, SENSOR_MAX_FOCUS);
done:
    return status;
}

lmn_status load_sensor(struct reader *r, struct xml_node *node)
{
    static const char *const words[] = {"perspective",   "thinlens",        "orthographic",
                                        "radiancemeter", "irradiancemeter", "distant",
                                        "batch"};
    static const char *const ignored[] = {"shutter_open", "shutter_close"};
    lmn_status status = LMN_OK;
    struct props p = props_of(r, node);
    struct builder_object object;
    struct render_settings *settings = &r->b->settings;
    struct sensor s = {.to_world = transform_identity(), .near_clip = 0.01f, .far_clip = 1e4f};
    struct xml_node *child;
    const size_t n = sizeof words / sizeof *words;
    size_t kind = 0;
    while (kind < n && strcmp(p.type, words[kind]) != 0) kind++;
    if (kind == n) return fail_unknown(r, node, "unknown sensor", p.type, words, n);
    if (kind > SENSOR_ORTHOGRAPHIC) return fail_unsupported(r, node);
    s.kind = (enum sensor_kind)kind;
    TRY(props_transform(&p, "to_world", &s.to_world));
    TRY(props_positive(&p, "near_clip", &s.near_clip));
    TRY(props_positive(&p, "far_clip", &s.far_clip));
    if (!(s.near_clip <= SENSOR_MAX_NEAR))
        return fail_node(r, node, "\"near_clip\" must not be above %g", SENSOR_MAX_NEAR);
    if (!(s.near_clip < s.far_clip))
        return fail_node(r, node, "\"near_clip\" must be below \"far_clip\"");
    TRY(read_optics(&p, &s));
    TRY(props_object(&p, EL_SAMPLER, &child));
    if (child) TRY(read_sampler(r, child, settings));
    TRY(props_object(&p, EL_FILM, &child));
    if (child) TRY(read_film(r, child, settings, &s));
    for (size_t i = 0; i < sizeof ignored / sizeof *ignored; i++) props_ignore(&p, ignored[i]);
    TRY(props_finish(&p, &object));
    TRY(builder_set_sensor(r->b, &object, &s, r->err));
done:
    return status;
}
