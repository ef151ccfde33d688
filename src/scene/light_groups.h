/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_LIGHT_GROUPS_H
#define SCENE_LIGHT_GROUPS_H

#include "base/str.h"
#include "scene/scene.h"

/*
 * Which emitters share a picture of their light. An emitter is in the group that `text` puts it in,
 * else in the one that the scene file names (scene->light_groups), else by itself. Groups are in
 * the order of their first emitters. Owned.
 */
enum { LIGHT_GROUP_NAME = 40 }; /* characters of a name: channels are NAME.R */

struct light_groups {
    uint32_t n;
    uint32_t *of;       /* [n_emitters] */
    const char **names; /* [n], into text */
    struct str text;
};

/* Adds the name of an emitter to `text`, as its parameters begin: "lamp.emitter", "sky". */
void emitter_name(struct str *text, const struct scene *s, uint32_t emitter);

/* text: "ceiling=lamp_1,lamp_2;outside=sky", NULL or "": nothing. Emitters are named as their
 * parameters are ("lamp.emitter"), or by the shape that they are on ("lamp"). */
lmn_status light_groups_init(struct light_groups *g, const struct scene *s, const char *text,
                             struct error *err);
void light_groups_release(struct light_groups *g);

#endif
