/* SPDX-License-Identifier: Apache-2.0 */
#include "camera_path.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

enum { MOST_KEYS = 10000, MOST_FRAMES = 1000000 };

/* Curves may swing out. */
#define LEAST_FOV 1e-3

/* A file being read. */
struct reader {
    struct app *app;
    const lmn_scene *scene;
    const char *file;
    uint32_t key; /* the one at hand */
    struct camera_path *path;
};

__attribute__((format(printf, 2, 3))) static int refuse(const struct reader *r, const char *format,
                                                        ...)
{
    char text[400];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return app_error(r->app, EXIT_INPUT, "%s: %s", r->file, text);
}

static int refuse_key(const struct reader *r, const char *what)
{
    return refuse(r, "keys[%u]: %s", r->key, what);
}

static bool read_vector(const json_t *from, double out[3])
{
    if (!json_is_array(from) || json_array_size(from) != 3) return false;
    for (size_t i = 0; i < 3; i++) {
        const json_t *x = json_array_get(from, i);
        if (!json_is_number(x)) return false;
        out[i] = json_number_value(x);
    }
    return true;
}

static int read_camera(const struct reader *r, const json_t *from, struct path_key *key)
{
    const json_t *fov = json_object_get(from, "fov");
    if (!from || json_is_null(from)) return EXIT_OK;
    key->has_camera = true;
    key->camera.fov = json_number_value(fov);
    if (!json_is_number(fov) || !read_vector(json_object_get(from, "origin"), key->camera.origin) ||
        !read_vector(json_object_get(from, "target"), key->camera.target) ||
        !read_vector(json_object_get(from, "up"), key->camera.up))
        return refuse_key(r, "\"camera\" must be null or have origin, target, up and fov");
    return EXIT_OK;
}

static int read_values(const struct reader *r, json_t *from, struct path_key *key)
{
    const char *name;
    json_t *value;
    key->values = calloc(r->path->n_variables + 1u, sizeof *key->values);
    if (!key->values) return app_error(r->app, EXIT_FAILED, "out of memory");
    lmn_scene_default_values(r->scene, key->values);
    if (from && !json_is_object(from)) return refuse_key(r, "\"values\" must be an object");
    json_object_foreach(from, name, value)
    {
        char assignment[400];
        if (!json_is_number(value)) return refuse_key(r, "values must be numbers");
        snprintf(assignment, sizeof assignment, "%s=%.17g", name, json_number_value(value));
        if (lmn_scene_parse_value(r->app->context, r->scene, assignment, key->values) != LMN_OK)
            return refuse_key(r, lmn_context_message(r->app->context));
    }
    return EXIT_OK;
}

static int read_key(const struct reader *r, const json_t *from)
{
    struct path_key *key = &r->path->keys[r->path->n_keys++];
    const json_t *time = json_object_get(from, "time");
    key->time = json_number_value(time);
    if (!json_is_number(time) || !(key->time >= 0.0 && key->time <= 1e6))
        return refuse_key(r, "\"time\" must be a number from 0");
    const int code = read_values(r, json_object_get(from, "values"), key);
    return code == EXIT_OK ? read_camera(r, json_object_get(from, "camera"), key) : code;
}

static int compare_keys(const void *a, const void *b)
{
    const struct path_key *p = a, *q = b;
    return (p->time > q->time) - (p->time < q->time);
}

static int read_keys(struct reader *r, const json_t *list)
{
    const size_t n = json_array_size(list);
    int code = EXIT_OK;
    if (!json_is_array(list) || n < 2 || n > MOST_KEYS)
        return refuse(r, "\"keys\" must be a list of 2 to %d key frames", MOST_KEYS);
    r->path->keys = calloc(n, sizeof *r->path->keys);
    if (!r->path->keys) return app_error(r->app, EXIT_FAILED, "out of memory");
    for (; r->key < n && code == EXIT_OK; r->key++)
        code = read_key(r, json_array_get(list, r->key));
    if (code != EXIT_OK) return code;
    qsort(r->path->keys, n, sizeof *r->path->keys, compare_keys);
    for (size_t i = 0; i < n; i++) r->path->has_cameras |= r->path->keys[i].has_camera;
    for (size_t i = 0; r->path->has_cameras && i < n; i++) {
        struct path_key *key = &r->path->keys[i];
        if (!key->has_camera &&
            lmn_scene_get_camera(r->app->context, r->scene, key->values, &key->camera) != LMN_OK)
            return refuse(r, "%s", lmn_context_message(r->app->context));
    }
    return EXIT_OK;
}

int camera_path_load(struct camera_path *p, struct app *app, const lmn_scene *scene,
                     const char *file)
{
    json_error_t error;
    lmn_scene_info info;
    int code = EXIT_OK;
    lmn_scene_get_info(scene, &info);
    *p = (struct camera_path){
        .n_variables = info.n_variables, .fps = 24.0, .most_fov = info.orthographic ? 1e12 : 179.0};
    struct reader r = {.app = app, .scene = scene, .file = file, .path = p};
    FILE *f = fopen(file, "rb");
    if (!f) return refuse(&r, "cannot open: %s", strerror(errno));
    json_t *root = json_loadf(f, JSON_REJECT_DUPLICATES, &error);
    fclose(f);
    if (!root)
        return error.line > 0 ? app_error(app, EXIT_INPUT, "%s:%d:%d: %s", file, error.line,
                                          error.column, error.text)
                              : app_error(app, EXIT_INPUT, "%s: %s", file, error.text);
    const json_t *fps = json_object_get(root, "fps");
    if (json_integer_value(json_object_get(root, "lumenaut_path")) != 1)
        code = refuse(&r, "this is no path of version 1 (\"lumenaut_path\": 1 is missing)");
    if (code == EXIT_OK && fps) {
        p->fps = json_number_value(fps);
        if (!json_is_number(fps) || !(p->fps >= 1.0 && p->fps <= 240.0))
            code = refuse(&r, "\"fps\" must be a number from 1 to 240");
    }
    if (code == EXIT_OK) code = read_keys(&r, json_object_get(root, "keys"));
    if (code == EXIT_OK && p->keys[p->n_keys - 1].time * p->fps >= MOST_FRAMES)
        code = refuse(&r, "%d frames and more", MOST_FRAMES);
    json_decref(root);
    if (code != EXIT_OK) camera_path_release(p);
    return code;
}

void camera_path_release(struct camera_path *p)
{
    for (uint32_t i = 0; i < p->n_keys; i++) free(p->keys[i].values);
    free(p->keys);
    *p = (struct camera_path){0};
}

uint32_t camera_path_n_frames(const struct camera_path *p)
{
    return (uint32_t)floor(p->keys[p->n_keys - 1].time * p->fps + 1e-9) + 1;
}

/* ---- Between keys ---------------------------------------------------------------------------- */

/* Where a time is: between keys i and i + 1, and how far, 0 to 1. */
struct place {
    uint32_t i;
    double u;
};

static struct place find(const struct camera_path *p, double time)
{
    struct place at = {0, 1.0};
    while (at.i + 2 < p->n_keys && p->keys[at.i + 1].time <= time) at.i++;
    const double span = p->keys[at.i + 1].time - p->keys[at.i].time;
    if (span > 0.0) at.u = fmin(fmax((time - p->keys[at.i].time) / span, 0.0), 1.0);
    return at;
}

/* A number of a key's camera, counted in doubles. */
static double camera_number(const struct path_key *key, size_t index)
{
    const lmn_camera *c = &key->camera;
    if (index < 9) return (index < 3 ? c->origin : index < 6 ? c->target : c->up)[index % 3];
    return c->fov;
}

static double tangent(const struct camera_path *p, uint32_t k, size_t index)
{
    const struct path_key *a = &p->keys[k > 0 ? k - 1 : 0];
    const struct path_key *b = &p->keys[k + 1 < p->n_keys ? k + 1 : k];
    if (!(b->time > a->time)) return 0.0;
    return (camera_number(b, index) - camera_number(a, index)) / (b->time - a->time);
}

static double along(const struct camera_path *p, struct place at, size_t index)
{
    const struct path_key *a = &p->keys[at.i], *b = a + 1;
    const double u = at.u, u2 = u * u, u3 = u2 * u, span = b->time - a->time;
    return (2 * u3 - 3 * u2 + 1) * camera_number(a, index) +
           (u3 - 2 * u2 + u) * span * tangent(p, at.i, index) +
           (3 * u2 - 2 * u3) * camera_number(b, index) +
           (u3 - u2) * span * tangent(p, at.i + 1, index);
}

const lmn_camera *camera_path_at(const struct camera_path *p, const lmn_scene *scene,
                                 uint32_t frame, double *values, lmn_camera *camera)
{
    const struct place at = find(p, frame / p->fps);
    const struct path_key *a = &p->keys[at.i], *b = a + 1;
    for (uint32_t i = 0; i < p->n_variables; i++) {
        lmn_variable_info v = {0};
        lmn_scene_get_variable(scene, i, &v);
        values[i] = a->values[i] + (b->values[i] - a->values[i]) * at.u;
        if (v.n_choices > 0) values[i] = at.u < 1.0 ? a->values[i] : b->values[i];
    }
    if (!p->has_cameras) return NULL;
    for (size_t k = 0; k < 3; k++) {
        camera->origin[k] = along(p, at, k);
        camera->target[k] = along(p, at, 3 + k);
        camera->up[k] = along(p, at, 6 + k);
    }
    camera->fov = fmin(fmax(along(p, at, 9), LEAST_FOV), p->most_fov);
    return camera;
}
