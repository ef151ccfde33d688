/* SPDX-License-Identifier: Apache-2.0 */
#include "viewer.h"

#include <stdio.h>
#include <stdlib.h>

#include "server.h"
#include "studio.h"

struct viewer {
    struct viewer_options options;
    struct hall hall;
    struct studio studio;
    struct server *server;
    bool has_hall;
};

static struct message_rules rules_of(const struct viewer_options *o)
{
    lmn_scene_info info;
    lmn_camera camera = {.fov = 1};
    lmn_scene_get_info(o->scene, &info);
    lmn_scene_get_camera(o->context, o->scene, NULL, &camera);
    return (struct message_rules){.n_variables = info.n_variables,
                                  .has_network = o->model != NULL,
                                  .is_orthographic = camera.fov == 0.0};
}

bool viewer_new(const struct viewer_options *options, struct viewer **out, char why[VIEWER_WHY])
{
    struct viewer *v = calloc(1, sizeof *v);
    const struct message_rules rules = rules_of(options);
    char *text = NULL;
    bool is_made = false;
    *out = NULL;
    snprintf(why, VIEWER_WHY, "out of memory");
    if (!v) return false;
    v->options = *options;
    v->has_hall = hall_init(&v->hall, rules.n_variables);
    const struct hello hello = {.context = options->context,
                                .scene = options->scene,
                                .scene_path = options->scene_path,
                                .model_path = options->model_path,
                                .render = options->render,
                                .trace = options->trace,
                                .program = options->program};
    const struct studio_options studio = {.context = options->context,
                                          .scene = options->scene,
                                          .model = options->model,
                                          .rules = rules};
    if (v->has_hall) text = message_hello(&hello, &rules);
    if (text && server_new(&v->options, &rules, text, &v->hall, &v->server, why)) {
        is_made = studio_start(&v->studio, &studio, &v->hall);
        if (!is_made) snprintf(why, VIEWER_WHY, "cannot start a thread");
    }
    free(text);
    if (is_made)
        *out = v;
    else
        viewer_free(v);
    return is_made;
}

void viewer_free(struct viewer *v)
{
    if (!v) return;
    if (v->has_hall) hall_close(&v->hall);
    studio_stop(&v->studio);
    server_free(v->server);
    if (v->has_hall) hall_release(&v->hall);
    free(v);
}

bool viewer_run(struct viewer *v)
{
    const struct viewer_options *o = &v->options;
    const uint16_t port = server_port(v->server);
    char url[400];
    snprintf(url, sizeof url, "http://%s:%u/%s%s", o->bind, port, o->token ? "?token=" : "",
             o->token ? o->token : "");
    if (o->on_open) o->on_open(o->user, url, port);
    return server_run(v->server, o->must_stop, o->user);
}

bool viewer_is_stale(const struct viewer *v)
{
    return v && studio_is_stale(&v->studio);
}
