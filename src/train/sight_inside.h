/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TRAIN_SIGHT_INSIDE_H
#define TRAIN_SIGHT_INSIDE_H

#include "train/sight.h"

/* The inside of sight_look(): the plain version and those of instruction sets. */

enum {
    SURFACE_FEATURES = 14, /* normal 3, direction 3, mirrored 3, roughness, albedo 3, glossy */
    FRAME_FEATURES = 4,    /* direction 3, nearness */
    LIGHT_FEATURES = 5,    /* direction 3, nearness, cosine */
    PASSAGE_FEATURES = 4,  /* closest approach 3, nearness */
    DEPTH_FEATURES = 1,    /* share of the bounces that count */
    SIGHT_MOST_FEATURES = SURFACE_FEATURES + SIGHT_FRAMES * FRAME_FEATURES +
                          SIGHT_LIGHTS * (LIGHT_FEATURES + SIGHT_FRAMES * PASSAGE_FEATURES) +
                          DEPTH_FEATURES
};

/* Of glossy surfaces, which may have no albedo (metals, glass) or little. */
#define LEAST_SCALE 0.1f

/* What is the same for all pixels of a configuration. */
struct sight_moment {
    uint32_t n_frames, n_lights, n_features;
    struct vec3 corner, size; /* of the scene's box */
    float light_scale;        /* of the way to a light, for its nearness: 8 / diagonal */
    struct scene_frame frames[SIGHT_FRAMES];
    struct vec3 lights[SIGHT_LIGHTS];
    struct vec3 local_lights[SIGHT_LIGHTS][SIGHT_FRAMES]; /* in the frames */
};

/* The arguments of sight_look(). */
struct sight_job {
    const struct sight_moment *moment;
    const float *buffers;
    uint32_t n;
    float *positions, *features, *scale;
};

void sight_look_plain(const struct sight_job *j);
void sight_look_avx2(const struct sight_job *j);
void sight_look_avx512(const struct sight_job *j);

#endif
