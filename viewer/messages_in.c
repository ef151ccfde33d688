/* SPDX-License-Identifier: Apache-2.0 */
/* Messages of the page: everything in them is checked, as anybody may have written it. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "messages.h"

/* What is being read, and where a reason goes. */
struct reader {
    const struct message_rules *rules;
    const json_t *root;
    char *why;
};

__attribute__((format(printf, 2, 3))) static bool refuse(struct reader *r, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vsnprintf(r->why, MESSAGE_WHY, format, list);
    va_end(list);
    return false;
}

/* A number that is one, within [low, high]. */
static bool read_number(struct reader *r, const json_t *from, const char *name, double low,
                        double high, double *out)
{
    if (!json_is_number(from)) return refuse(r, "\"%s\" must be a number", name);
    *out = json_number_value(from);
    if (!(*out >= low && *out <= high))
        return refuse(r, "\"%s\" must be from %g to %g", name, low, high);
    return true;
}

static bool get_number(struct reader *r, const char *name, double low, double high, double *out)
{
    return read_number(r, json_object_get(r->root, name), name, low, high, out);
}

static bool get_whole(struct reader *r, const char *name, double low, double high, uint32_t *out)
{
    const json_t *from = json_object_get(r->root, name);
    double x;
    if (!json_is_integer(from)) return refuse(r, "\"%s\" must be a whole number", name);
    if (!read_number(r, from, name, low, high, &x)) return false;
    *out = (uint32_t)x;
    return true;
}

static bool get_text(struct reader *r, const char *name, const char **out)
{
    *out = json_string_value(json_object_get(r->root, name));
    return *out || refuse(r, "\"%s\" must be a text", name);
}

/* The index of a word in a list. */
static bool choose(struct reader *r, const char *name, const char *word, const char *const *words,
                   uint32_t n, uint32_t *out)
{
    for (uint32_t i = 0; i < n; i++)
        if (strcmp(word, words[i]) == 0) {
            *out = i;
            return true;
        }
    return refuse(r, "\"%s\": \"%.40s\" is none of those there are", name, word);
}

static bool read_vector(struct reader *r, const json_t *from, const char *name, double out[3])
{
    const json_t *list = json_object_get(from, name);
    if (!json_is_array(list) || json_array_size(list) != 3)
        return refuse(r, "\"camera\": \"%s\" must be three numbers", name);
    for (size_t i = 0; i < 3; i++)
        if (!read_number(r, json_array_get(list, i), name, -1e18, 1e18, &out[i])) return false;
    return true;
}

static bool read_camera(struct reader *r, struct wish *w)
{
    const json_t *from = json_object_get(r->root, "camera");
    if (json_is_null(from)) return true;
    if (!json_is_object(from)) return refuse(r, "\"camera\" must be an object or null");
    const double most = r->rules->is_orthographic ? 1e12 : 179.999;
    w->has_camera = true;
    return read_vector(r, from, "origin", w->camera.origin) &&
           read_vector(r, from, "target", w->camera.target) &&
           read_vector(r, from, "up", w->camera.up) &&
           read_number(r, json_object_get(from, "fov"), "fov", 0.0, most, &w->camera.fov);
}

static bool add_layer(struct reader *r, const char *word, struct wish *w)
{
    static const char *const names[LAYER_BUFFER] = {"neural", "traced", "error"};
    uint32_t index = 0;
    enum layer layer = LAYER_BUFFER;
    for (uint32_t i = 0; i < LAYER_BUFFER; i++)
        if (strcmp(word, names[i]) == 0) layer = (enum layer)i;
    if (layer == LAYER_BUFFER) {
        if (!choose(r, "layers", word, shown_buffer_names, SHOWN_BUFFERS, &index)) return false;
        w->buffer = (enum shown_buffer)index;
    }
    if ((layer == LAYER_NEURAL || layer == LAYER_ERROR) && !r->rules->has_network)
        return refuse(r, "\"layers\": there is no network to show \"%s\"", word);
    for (uint32_t i = 0; i < w->n_layers; i++)
        if (w->layers[i] == layer) return refuse(r, "\"layers\": two of one kind");
    w->layers[w->n_layers++] = layer; /* four kinds at most: there is room */
    return true;
}

static bool read_layers(struct reader *r, struct wish *w)
{
    const json_t *list = json_object_get(r->root, "layers"), *item;
    size_t i;
    if (!json_is_array(list) || json_array_size(list) == 0 || json_array_size(list) > LAYERS)
        return refuse(r, "\"layers\" must be a list of one to four names");
    json_array_foreach(list, i, item)
    {
        const char *word = json_string_value(item);
        if (!word) return refuse(r, "\"layers\" must hold texts");
        if (!add_layer(r, word, w)) return false;
    }
    return true;
}

static bool read_values(struct reader *r, struct wish *w)
{
    const json_t *list = json_object_get(r->root, "values"), *item;
    const uint32_t n = r->rules->n_variables;
    size_t i;
    if (!json_is_array(list) || json_array_size(list) != n)
        return refuse(r, "\"values\" must be a list of %u numbers", n);
    w->values = calloc(n + 1u, sizeof *w->values);
    if (!w->values) return refuse(r, "out of memory");
    json_array_foreach(list, i, item)
    {
        if (!read_number(r, item, "values", -1e30, 1e30, &w->values[i])) return false;
    }
    return true;
}

static bool read_state(struct reader *r, struct wish *w)
{
    static const char *const tones[] = {"srgb", "aces"};
    const char *tone;
    const json_t *moving = json_object_get(r->root, "moving");
    if (!json_is_boolean(moving)) return refuse(r, "\"moving\" must be true or false");
    w->is_moving = json_is_true(moving);
    return get_whole(r, "version", 1, UINT32_MAX, &w->version) && read_values(r, w) &&
           read_camera(r, w) && read_layers(r, w) &&
           get_whole(r, "width", HALL_SIDE_MIN, HALL_SIDE_MAX, &w->width) &&
           get_whole(r, "height", HALL_SIDE_MIN, HALL_SIDE_MAX, &w->height) &&
           get_number(r, "exposure", 1e-9, 1e9, &w->exposure) && get_text(r, "tone", &tone) &&
           choose(r, "tone", tone, tones, 2, &w->tone) && get_number(r, "rate", 1, 60, &w->rate) &&
           get_number(r, "least", 0.1, 1, &w->least);
}

static bool read_capture(struct reader *r, struct message *m)
{
    static const char *const layers[] = {"neural", "traced"}, *const formats[] = {"png", "exr"};
    const char *layer, *format;
    uint32_t l = 0, f = 0;
    if (!get_whole(r, "id", 0, UINT32_MAX, &m->id) || !get_text(r, "layer", &layer) ||
        !get_text(r, "format", &format) || !choose(r, "layer", layer, layers, 2, &l) ||
        !choose(r, "format", format, formats, 2, &f))
        return false;
    m->layer = (enum layer)l;
    m->format = (enum capture_format)f;
    return m->layer != LAYER_NEURAL || r->rules->has_network ||
           refuse(r, "\"layer\": there is no network");
}

static bool read_train(struct reader *r, struct message *m)
{
    static const char *const actions[] = {"start", "pause", "save", "stop"};
    const char *action;
    uint32_t index = 0;
    if (!r->rules->can_train) return refuse(r, "nothing is being trained here");
    if (!get_text(r, "action", &action) || !choose(r, "action", action, actions, 4, &index))
        return false;
    m->action = (enum train_action)index;
    return m->action == TRAIN_START || r->rules->is_training ||
           refuse(r, "no training is under way");
}

static bool read_kind(struct reader *r, struct message *m)
{
    static const char *const kinds[] = {"state", "ack", "pixel", "capture", "train"};
    const char *type;
    uint32_t kind = 0;
    if (!json_is_object(r->root)) return refuse(r, "a message must be an object");
    if (!get_text(r, "type", &type) || !choose(r, "type", type, kinds, 5, &kind)) return false;
    m->kind = (enum message_kind)kind;
    switch (m->kind) {
    case MESSAGE_STATE:
        return read_state(r, &m->wish);
    case MESSAGE_ACK:
        return get_whole(r, "frame", 0, UINT32_MAX, &m->frame);
    case MESSAGE_PIXEL:
        return get_whole(r, "id", 0, UINT32_MAX, &m->id) &&
               get_whole(r, "x", 0, HALL_SIDE_MAX - 1, &m->x) &&
               get_whole(r, "y", 0, HALL_SIDE_MAX - 1, &m->y);
    case MESSAGE_CAPTURE:
        return read_capture(r, m);
    case MESSAGE_TRAIN:
        return read_train(r, m);
    }
    return false;
}

bool message_read(const char *text, size_t size, const struct message_rules *rules,
                  struct message *out, char why[MESSAGE_WHY])
{
    json_error_t error;
    json_t *root = json_loadb(text, size, JSON_REJECT_DUPLICATES, &error);
    struct reader r = {rules, root, why};
    *out = (struct message){0};
    if (!root) {
        snprintf(why, MESSAGE_WHY, "not JSON: %.100s", error.text);
        return false;
    }
    const bool is_read = read_kind(&r, out);
    json_decref(root);
    if (!is_read) {
        free(out->wish.values);
        out->wish.values = NULL;
    }
    return is_read;
}
