/* SPDX-License-Identifier: Apache-2.0 */
/* Messages to the page. */
#include <math.h>
#include <string.h>

#include <jansson.h>

#include "messages.h"

/* The text of a value, which is let go. */
static char *finish(json_t *value)
{
    char *text = value ? json_dumps(value, JSON_COMPACT | JSON_REAL_PRECISION(9)) : NULL;
    json_decref(value);
    return text;
}

/* What is no number is null. */
static json_t *number(double x)
{
    return isfinite(x) ? json_real(x) : json_null();
}

static json_t *numbers(const double *x, uint32_t n)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < n; i++) json_array_append_new(list, number(x[i]));
    return list;
}

/* Paths need not be UTF-8, which JSON must be. */
static json_t *text(const char *s)
{
    json_t *value = s ? json_string(s) : json_null();
    return value ? value : json_string("?");
}

static json_t *words(const char *const *list)
{
    json_t *out = list ? json_array() : json_null();
    for (; list && *list; list++) json_array_append_new(out, text(*list));
    return out;
}

char *message_error(const char *why)
{
    json_t *j = json_object();
    json_object_set_new(j, "type", json_string("error"));
    json_object_set_new(j, "message", text(why));
    return finish(j);
}

static json_t *camera_of(const lmn_camera *c)
{
    json_t *j = json_object();
    json_object_set_new(j, "origin", numbers(c->origin, 3));
    json_object_set_new(j, "target", numbers(c->target, 3));
    json_object_set_new(j, "up", numbers(c->up, 3));
    json_object_set_new(j, "fov", number(c->fov));
    return j;
}

static json_t *variable_of(const lmn_variable_info *v)
{
    json_t *j = json_object(), *choices = v->n_choices ? json_array() : json_null();
    json_object_set_new(j, "name", text(v->name));
    json_object_set_new(j, "group", text(v->group));
    json_object_set_new(j, "kind", text(v->kind));
    json_object_set_new(j, "unit", text(v->unit));
    json_object_set_new(j, "min", number(v->n_choices ? 0 : v->min));
    json_object_set_new(j, "max", number(v->n_choices ? v->n_choices - 1.0 : v->max));
    json_object_set_new(j, "value", number(v->value));
    for (uint32_t i = 0; i < v->n_choices; i++) json_array_append_new(choices, text(v->choices[i]));
    json_object_set_new(j, "choices", choices);
    json_object_set_new(j, "description", text(v->description));
    return j;
}

static json_t *bounds_of(const lmn_scene_info *info)
{
    const double low[3] = {(double)info->bounds_min[0], (double)info->bounds_min[1],
                           (double)info->bounds_min[2]};
    const double high[3] = {(double)info->bounds_max[0], (double)info->bounds_max[1],
                            (double)info->bounds_max[2]};
    json_t *j = json_object();
    json_object_set_new(j, "min", numbers(low, 3));
    json_object_set_new(j, "max", numbers(high, 3));
    return j;
}

static json_t *point_of(const double *p)
{
    return numbers(p, 2);
}

static json_t *training_of(const struct training_state *t, bool is_whole)
{
    json_t *j = json_object(), *list;
    json_object_set_new(j, "running", json_boolean(t->is_running));
    json_object_set_new(j, "step", json_integer((json_int_t)t->step));
    json_object_set_new(j, "loss", number(t->loss));
    json_object_set_new(j, "seconds", number(t->seconds));
    json_object_set_new(j, "configurations", json_integer((json_int_t)t->n_configurations));
    json_object_set_new(j, "steps_per_s", number(t->steps_per_s));
    json_object_set_new(j, "view_share", number(t->view_share));
    json_object_set_new(j, "acceptance", number(t->acceptance));
    json_object_set_new(j, "reuse", number(t->reuse));
    json_object_set_new(j, "message", json_null());
    if (is_whole) {
        list = json_array();
        for (uint32_t i = 0; i < t->n_points; i++)
            json_array_append_new(list, point_of(t->points[i]));
        json_object_set_new(j, "history", list);
    } else if (t->n_points > 0) {
        json_object_set_new(j, "point", point_of(t->points[t->n_points - 1]));
    }
    list = json_array();
    for (uint32_t i = 0; i < t->n_states; i++)
        json_array_append_new(list,
                              numbers(t->states + (size_t)i * t->n_variables, t->n_variables));
    json_object_set_new(j, "states", list);
    return j;
}

char *message_training(const struct training_state *t, bool is_whole)
{
    json_t *j = training_of(t, is_whole);
    json_object_set_new(j, "type", json_string("training"));
    return finish(j);
}

char *message_hello(const struct hello *h, const struct message_rules *rules)
{
    static const char *const layers[] = {"neural", "error", "traced"};
    lmn_scene_info info;
    lmn_camera camera = {0};
    json_t *j = json_object(), *list = json_array();
    lmn_scene_get_info(h->scene, &info);
    lmn_scene_get_camera(h->context, h->scene, NULL, &camera);
    json_object_set_new(j, "type", json_string("hello"));
    json_object_set_new(j, "protocol", json_integer(1));
    json_object_set_new(j, "program", text(h->program));
    json_object_set_new(j, "scene", text(h->scene_path));
    json_object_set_new(j, "model", text(h->model_path));
    for (uint32_t i = 0; i < info.n_variables; i++) {
        lmn_variable_info v;
        if (lmn_scene_get_variable(h->scene, i, &v) == LMN_OK)
            json_array_append_new(list, variable_of(&v));
    }
    json_object_set_new(j, "variables", list);
    json_object_set_new(j, "camera", camera_of(&camera));
    json_object_set_new(j, "orthographic", json_boolean(rules->is_orthographic));
    json_object_set_new(j, "bounds", bounds_of(&info));
    json_object_set_new(j, "size", json_pack("[i,i]", (int)info.width, (int)info.height));
    list = json_array();
    for (uint32_t i = rules->has_network ? 0 : 2; i < 3; i++)
        json_array_append_new(list, json_string(layers[i]));
    for (uint32_t i = 0; i < SHOWN_BUFFERS; i++)
        json_array_append_new(list, json_string(shown_buffer_names[i]));
    json_object_set_new(j, "layers", list);
    list = json_object();
    json_object_set_new(list, "render", words(h->render));
    json_object_set_new(list, "trace", words(h->trace));
    json_object_set_new(list, "train", words(h->train));
    json_object_set_new(j, "commands", list);
    json_object_set_new(j, "can_train", json_boolean(rules->can_train));
    json_object_set_new(j, "training", json_null());
    json_object_set_new(j, "notice", text(h->notice));
    return finish(j);
}

char *message_stats(const struct view_stats *s)
{
    json_t *j = json_object();
    json_object_set_new(j, "type", json_string("stats"));
    json_object_set_new(j, "version", json_integer(s->version));
    json_object_set_new(j, "fps", number(s->fps));
    json_object_set_new(j, "size", json_pack("[i,i]", (int)s->width, (int)s->height));
    json_object_set_new(j, "spp", json_integer(s->neural_spp));
    json_object_set_new(j, "traced_spp", json_integer(s->traced_spp));
    json_object_set_new(j, "render_ms", number(s->render_ms));
    json_object_set_new(j, "buffers_ms", number(s->buffers_ms));
    json_object_set_new(j, "network_ms", number(s->network_ms));
    json_object_set_new(j, "encode_ms", number(s->encode_ms));
    json_object_set_new(j, "sessions", json_integer(s->n_sessions));
    json_object_set_new(j, "camera", s->has_camera ? camera_of(&s->camera) : json_null());
    return finish(j);
}

char *message_metrics(uint32_t version, uint32_t neural_spp, uint32_t traced_spp,
                      const lmn_metrics *m)
{
    json_t *j = json_object();
    json_object_set_new(j, "type", json_string("metrics"));
    json_object_set_new(j, "version", json_integer(version));
    json_object_set_new(j, "neural_spp", json_integer(neural_spp));
    json_object_set_new(j, "traced_spp", json_integer(traced_spp));
    json_object_set_new(j, "mape", number(m->mape));
    json_object_set_new(j, "relmse", number(m->relmse));
    json_object_set_new(j, "flip", number(m->flip));
    json_object_set_new(j, "psnr", number(m->psnr));
    return finish(j);
}

char *message_pixel(uint32_t id, uint32_t version, uint32_t x, uint32_t y,
                    const struct readout *list, uint32_t n)
{
    json_t *j = json_object(), *values = json_object();
    for (uint32_t i = 0; i < n; i++) {
        json_t *three = json_array();
        for (uint32_t c = 0; c < list[i].n; c++)
            json_array_append_new(three, number((double)list[i].values[c]));
        json_object_set_new(values, list[i].name, three);
    }
    json_object_set_new(j, "type", json_string("pixel"));
    json_object_set_new(j, "id", json_integer(id));
    json_object_set_new(j, "version", json_integer(version));
    json_object_set_new(j, "x", json_integer(x));
    json_object_set_new(j, "y", json_integer(y));
    json_object_set_new(j, "values", values);
    return finish(j);
}

char *message_capture(uint32_t id, size_t size, const char *name, const char *why)
{
    json_t *j = json_object();
    json_object_set_new(j, "type", json_string("capture"));
    json_object_set_new(j, "id", json_integer(id));
    if (size > 0) {
        json_object_set_new(j, "size", json_integer((json_int_t)size));
        json_object_set_new(j, "name", text(name));
    } else {
        json_object_set_new(j, "message", text(why));
    }
    return finish(j);
}

static uint8_t *put(uint8_t *to, uint32_t x, int n_bytes)
{
    for (int i = 0; i < n_bytes; i++) *to++ = (uint8_t)(x >> (8 * i));
    return to;
}

static uint8_t *put_float(uint8_t *to, double x)
{
    const float f = (float)x;
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    return put(to, bits, 4);
}

void picture_header_write(const struct picture_header *h, uint8_t *to)
{
    memcpy(to, "LMNF", 4);
    to += 4;
    to = put(to, h->layer, 1);
    to = put(to, h->encoding, 1);
    to = put(to, h->is_final, 2);
    to = put(to, h->frame, 4);
    to = put(to, h->version, 4);
    to = put(to, h->width, 2);
    to = put(to, h->height, 2);
    to = put(to, h->full_width, 2);
    to = put(to, h->full_height, 2);
    to = put(to, h->spp, 4);
    to = put_float(to, h->render_ms);
    to = put_float(to, h->encode_ms);
    put(to, 0, 4);
}
