/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_SIGHT_H
#define TRAIN_SIGHT_H

#include "nn/field.h"
#include "render/view.h"
#include "scene/frames.h"
#include "train/meaning.h"
#include "train/powers.h"

/*
 * What the compact network sees of a pixel (nn/field.h): from the buffers of its first hit and the
 * state of the scene to positions, features and scale. All of it follows from the scene and its
 * variables; nothing is picked by hand.
 *
 *   positions   in the scene's box, and in the frame of each movable thing: without the latter
 *               shadows and caustics smear (method 5b). Frames reach to infinity: a local position
 *               q, the thing's own bounds being [-1,1]^3, becomes 1/2 + q / (2 + 2 |q|).
 *   features    normal, roughness, albedo; where the surface is glossy the direction to the camera
 *               and its mirror image; per frame direction and nearness; per light direction,
 *               nearness and cosine; per light and frame how closely the segment to the light
 *               passes the thing, in its frame: shadows. What is hidden gives zeros
 *   bounces     a feature: the share of training's bounces that count. What a pixel shows has all
 *               of them, what is behind mirrors and glass (render/chain.h) less, and so has what
 *               tails.h asks
 *   scale       albedo, to which radiance of diffuse surfaces is proportional: what is black
 *               needs no learning; of glossy ones at least a tenth
 *   lights      the powers of groups of lights (powers.h)
 *   v           the other variables, but those that only the camera follows: radiance of a surface
 *               does not depend on who looks
 */
enum { SIGHT_FRAMES = 6, SIGHT_LIGHTS = 3 };

struct sight {
    const struct scene *scene;
    struct scene_frames frames;
    struct powers powers;
    uint32_t n_frames, n_lights;
    struct {
        uint32_t instance, shape; /* SCENE_NONE: an emitter without shape */
        uint32_t emitter;
        struct vec3 center; /* in the instance's space */
    } lights[SIGHT_LIGHTS];
    uint32_t n_positions, n_features;
    int32_t max_depth;    /* bounces of training, -1: no bound; the scene's until the owner says */
    bool ignores_albedo;  /* LMN_WITHOUT_ALBEDO: scale is 1 */
    bool follows_delta;   /* mirrors and glass are looked through, where the scene has them */
    uint32_t n_variables; /* of v */
    uint32_t *variables;  /* [n_variables], into scene->variables */
    uint32_t cpu; /* flags of base/cpu.h that sight_look() may use: 0 until the owner sets them */
};

/* `without`: of LMN_WITHOUT_*. */
lmn_status sight_init(struct sight *s, const struct scene *scene, uint32_t without,
                      struct error *err);
void sight_release(struct sight *s);

/* What the scene asks of a network: grids, features, variables; the rest is 0. */
struct field_config sight_field(const struct sight *s);

/* What they stand for; release with meaning_release(). */
lmn_status sight_describe(const struct sight *s, struct meaning *out, struct error *err);

/* v [n_variables] of the configuration u. */
void sight_variables(const struct sight *s, const float *u, float *v);

/* The same bytes for any `cpu`.
 *
 * buffers [n][BUFFER_CHANNELS] -> positions [n][n_positions][3], features [n][n_features],
 * scale [n][3] (all 0 where nothing was hit). What is not finite becomes 0. */
void sight_look(const struct sight *s, const struct scene_state *state, const float *buffers,
                uint32_t n, float *positions, float *features, float *scale);

/* Features are those of all bounces: now of a share [n] of them. */
void sight_set_bounces(const struct sight *s, const float *bounces, uint32_t n, float *features);

/* The share that counts with this depth. */
float sight_bounces(const struct sight *s, int32_t max_depth);

/* What of the buffers sight_look() reads, and bounces [n], to keep and to look at again:
 * [n][SIGHT_KEPT]. */
enum { SIGHT_KEPT = 14 };
void sight_keep(const float *buffers, const float *bounces, uint32_t n, float *kept);
void sight_recall(const float *kept, uint32_t n, float *buffers, float *bounces);

/* The targets of learning: what surfaces scatter, that is color [n][3] without what they emit
 * themselves. What is not finite, or below 0, becomes 0. */
void sight_targets(const float *color, const float *buffers, uint32_t n, float *targets);

/* The same by group of lights: groups [2 n_lights][n][3], those after the first half being what is
 * seen directly or along mirrors and glass (trace_output.chain_group); targets [n][n_lights][3]. */
void sight_split_targets(const float *groups, const float *buffers, uint32_t n, uint32_t n_lights,
                         float *targets);

/* And back: adds to color [n][3] what is emitted. */
void sight_add_emission(const float *buffers, uint32_t n, float *color);

/* The same behind mirrors and glass, of chain [n][CHAIN_CHANNELS]. */
void sight_add_chain(const float *chain, uint32_t n, float *color);

#endif
