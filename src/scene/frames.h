/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_FRAMES_H
#define SCENE_FRAMES_H

#include "scene/scene.h"

/*
 * The frames that variables move: light near a movable thing follows the thing, so that a network
 * which sees positions in its frame need not learn the same again for every place of it.
 *
 * A frame comes from each instance whose transform some variable writes, and from each emitter
 * without a shape whose position or direction some variable writes. Instances that move by the same
 * steps stay together as they are and share a frame. What is only shown or hidden, and an instance
 * without extent, has none. The order is fixed by the scene: objects by their first instance, then
 * emitters by their index.
 */
enum frame_kind {
    FRAME_OBJECT, /* instances: their bounds, at the default if they are several, fill the cube */
    FRAME_LIGHT,  /* point, spot, projector: the cube's half side is a quarter of the diagonal of
                     the scene's bounds */
    FRAME_AROUND  /* directional, envmap, sky: from infinity. The cube's half side is half the
                     diagonal, around the scene's centre */
};

/* An object is at least so thick in its frame, of its longest side: a sheet is no abyss. */
#define FRAME_MIN_SIDE 0.125f

/* Of one configuration. */
struct scene_frame {
    enum frame_kind kind;
    uint32_t index;  /* of the first instance, or of the emitter */
    bool is_visible; /* some instance is, and has not shrunk to nothing; lights: always */
    bool shines;     /* a light, or an object with one on it */
    /* World to local: the cube [-1,1]^3 is what is said at kind. Of lights a similarity, with local
     * +z where the light goes (sky: away from the sun); of point lights the world's axes. Always
     * finite: what has shrunk to nothing gets the scene's own cube. */
    struct transform to_local;
    struct vec3 center; /* world: of the cube */
    struct vec3 axis;   /* world, unit: local +z */
};

struct frame_source;

struct scene_frames {
    const struct scene *scene;
    struct frame_source *sources; /* [n] */
    uint32_t *members;            /* instances, source by source */
    uint32_t n;
};

/* The scene must outlive it. A scene without movable things has n = 0. Fails for want of memory
 * only. */
lmn_status scene_frames_init(const struct scene *s, struct scene_frames *out, struct error *err);
void scene_frames_release(struct scene_frames *f);

/* Frame k < n of a configuration; allocates nothing. */
void scene_frame_at(const struct scene_frames *f, const struct scene_state *state, uint32_t k,
                    struct scene_frame *out);

#endif
