/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_VIEW_H
#define RENDER_VIEW_H

#include "render/embree.h"

struct photon_map;
struct pool;

/*
 * A world holds what all configurations share: one Embree bottom-level structure per group, light
 * tables of meshes. A view is one configuration, ready to trace: a state, a small top level over
 * the instances, tables for choosing lights. Views of one world are independent: each worker may
 * own one and set it to another configuration; one view may be traced by many threads at once.
 */
struct world;
struct view;

/* `cpu`: instruction sets that may be used, a mask of enum cpu_flag. Results do not depend on it,
 * but for the last bits of what Embree finds. */
lmn_status world_new(const struct scene *scene, uint32_t cpu, struct world **out,
                     struct error *err);
void world_free(struct world *w);

/* The view starts at the scene's defaults. The world must outlive it. */
lmn_status view_new(const struct world *w, struct view **out, struct error *err);
void view_free(struct view *v);

/* Sets the configuration u [n_variables] and gets ready to trace. Costs what changed; rebuilds only
 * the top level, and only when an instance moved; allocates nothing. */
void view_set(struct view *v, const float *u);

/* Looks from elsewhere until the next view_set(). */
struct pose;
void view_look_from(struct view *v, const struct pose *p);

const struct scene *view_scene(const struct view *v);
const struct scene_state *view_state(const struct view *v);

enum mis_kind { MIS_POWER, MIS_BALANCE };

/* What to trace with; start from trace_settings_init(), which takes the scene's. */
struct trace_settings {
    uint32_t spp; /* rounded up to even when half-buffers are asked for */
    int32_t max_depth, rr_depth;
    bool hide_emitters;
    enum mis_kind mis;
    enum sampler_kind sampler;
    enum filter_kind filter;
    float filter_radius, filter_stddev;
    bool splats; /* a sample counts in all pixels whose filter it falls under; with groups and chain
                    splits never */
    uint64_t seed;
    uint32_t first_sample; /* number of the first of the spp samples: even; 0 but in passes */
    /* Buffers beside light come from its rays at few samples, too, unless it is splatted: a
     * fraction of the time for scattered pixels, but in the last bits they are not those of buffers
     * alone. */
    bool shares_rays;
    bool follows_delta; /* buffers show what is behind mirrors and glass: chain.h */
    /* Photons for even and odd samples: caustics come from them. NULL: paths alone. */
    const struct photon_map *photons[2];
};

void trace_settings_init(struct trace_settings *t, const struct scene *s);

/* A window (x, y, width, height) of a picture of full_width x full_height pixels. A window's pixels
 * are the same bytes as those of the whole picture: filters are importance-sampled per pixel
 * (Ernst et al. 2006), or splatted in an order that windows do not change (film.h), where the
 * pixels around a window are traced as well. */
struct window {
    uint32_t full_width, full_height;
    uint32_t x, y, width, height;
};

/* A pixel of a picture. */
struct pixel_at {
    uint32_t x, y;
};

/* Per-pixel buffers of the first hit, averaged over samples by the pixel filter (ids: first
 * sample). */
enum buffer_channel {
    BUFFER_POSITION = 0,   /* xyz, scene units */
    BUFFER_NORMAL = 3,     /* shading normal, after bump and normal maps */
    BUFFER_GEO_NORMAL = 6, /* geometric normal */
    BUFFER_ALBEDO =
        9, /* as the paper's: diffuse reflectance or base colour; of conductors and dielectrics the
              specular reflectance if the scene gives one, else 0; phong: both; blends: the mean */
    BUFFER_ROUGHNESS = 12, /* alpha; 1 for diffuse, 0 for perfectly smooth; blends: the mean */
    BUFFER_WO = 13,        /* towards the camera, world space, zero where nothing was hit */
    BUFFER_WI = 16,        /* the paper's encoding of it: in the shading frame with fixed tangent,
                              ((x+1)/2, (y+1)/2, |z|); zero on diffuse surfaces */
    BUFFER_EMISSION = 19,  /* radiance */
    BUFFER_DEPTH = 22,     /* distance from the camera; 0 where nothing was hit */
    BUFFER_SHAPE_ID = 23,  /* index into scene->shapes + 1; 0: nothing */
    BUFFER_PRIMITIVE_ID = 24,
    BUFFER_CHANNELS = 25
};
extern const char *const buffer_channel_names[BUFFER_CHANNELS]; /* "position.X", ... */

/* What mirrors and glass on the way to that surface do, when they are followed. */
enum chain_channel {
    CHAIN_THROUGHPUT = 0, /* rgb: radiance = emission + throughput * what the surface scatters */
    CHAIN_EMISSION = 3,   /* rgb, radiance: along the way and of the surface itself */
    CHAIN_LENGTH = 6,     /* surfaces on the way */
    CHAIN_CHANNELS = 7
};
extern const char *const chain_channel_names[CHAIN_CHANNELS];

/* Where the time of light paths goes: ticks of clock_ticks(), of all threads together. */
struct trace_clock {
    _Atomic uint64_t rays, all; /* finding what rays meet; everything */
};

/* Where a light path is cut: at the first rough surface that its ray meets after the first hit. */
struct path_end {
    uint32_t pixel, sample; /* whose: of the list, and of the samples of the call */
    int32_t max_depth;      /* what it had left, as of a path that starts with this ray; -1: any */
    struct vec3 throughput; /* radiance that the surface scatters along the ray counts by this */
    struct ray ray;         /* the one that met it */
};

/* Memory for them, of the caller. */
struct path_ends {
    uint32_t n, capacity; /* n: counts on; capacity: samples of all pixels at least */
    struct path_end *ends;
    float *buffers; /* [capacity][BUFFER_CHANNELS], as if the ray came from a camera */
};

/* How many surfaces light paths scatter at beyond their first, which pixels see. */
struct path_lengths {
    uint64_t second, later; /* second ones, and all after those */
};

/* Where results go; row-major over the window. Any pointer may be NULL: that part is not computed
 * (with color, half_a and half_b all NULL no light path is traced: buffers only). */
struct trace_output {
    float *color;           /* [height][width][3], mean of all samples: radiance */
    float *half_a, *half_b; /* the same from the even and the odd samples; with splats each is
                               weighed by itself, so that colour is near their mean, not it */
    float *buffers;         /* [height][width][BUFFER_CHANNELS] */
    float *chain; /* [height][width][CHAIN_CHANNELS], for follows_delta and buffers only */
    /* [n_groups][height][width][3], zeroed by the caller: the part of colour that comes from each
     * group of emitters; their sum, in this order, is colour exactly. group_of: [n_emitters]. */
    float *groups;
    uint32_t n_groups;
    const uint32_t *group_of;
    /* What is seen along delta chains alone (chain.h) goes to group_of[] + chain_group instead: 0
     * where it stays with the rest. */
    uint32_t chain_group;
    /* Not NULL: paths are cut, what lies beyond their ends is left out of all light, and the ends
     * are appended here, in an order of no meaning. On one thread. */
    struct path_ends *ends;
    struct path_lengths *lengths; /* NULL, or what to add to; on one thread, paths not cut */
    struct trace_clock *clock;    /* NULL, or what to add to */
};

/* Traces a window on the calling thread. The picture is a function of (state, settings, pixel). */
void view_trace(const struct view *v, const struct trace_settings *t, const struct window *w,
                struct trace_output *out);

/* Traces pixels of a picture of full_width x full_height anywhere in it, in any order, some more
 * than once perhaps. Results lie in the order of the list: out's arrays are those of a window of
 * n x 1 pixels. A pixel's bytes are those that view_trace() without splats gives it. */
void view_trace_pixels(const struct view *v, const struct trace_settings *t, uint32_t full_width,
                       uint32_t full_height, const struct pixel_at *pixels, uint32_t n,
                       struct trace_output *out);

/* The same for rays in place of pixels: all samples of a pixel start with its ray. */
void view_trace_rays(const struct view *v, const struct trace_settings *t, const struct ray *rays,
                     uint32_t n, struct trace_output *out);

/* What a pixel's ray meets behind mirrors and glass (chain.h), to trace on from there. */
struct chain_end {
    struct ray ray; /* the one that met it */
    uint32_t n;     /* surfaces on the way, of which the settings' max_depth counts each */
};

/* Fills ends [n]: each pixel's sample number first_sample. */
void view_follow_pixels(const struct view *v, const struct trace_settings *t, uint32_t full_width,
                        uint32_t full_height, const struct pixel_at *pixels, uint32_t n,
                        struct chain_end *ends);

/* Whether some material of the scene may be followed. */
bool view_has_chains(const struct scene *s);

/* The plain reference: the same picture, one path after another by path_radiance(), without packets
 * or streams. Slower; tests compare view_trace() with it. */
void view_trace_plain(const struct view *v, const struct trace_settings *t, const struct window *w,
                      struct trace_output *out);

/* In passes of a few samples, each with photons of its own: see photon.h. Buffers as well. */
lmn_status view_trace_photons(const struct view *v, struct pool *pool,
                              const struct trace_settings *t, const struct window *w,
                              struct trace_output *out, lmn_progress_fn *progress,
                              void *progress_user, struct error *err);

/* The same with all workers of the pool, in tiles of 32x32. `progress` may be NULL; returns
 * LMN_ERR_CANCELLED when it asks to stop. */
lmn_status view_trace_parallel(const struct view *v, struct pool *pool,
                               const struct trace_settings *t, const struct window *w,
                               struct trace_output *out, lmn_progress_fn *progress,
                               void *progress_user, struct error *err);

/* Whether the configuration holds caustics that path tracing samples hopelessly and photons bring
 * (photon_choice.c has the rule): a function of the view and the settings' depth alone. */
lmn_status view_wants_photons(const struct view *v, struct pool *pool,
                              const struct trace_settings *t, bool *out, struct error *err);

const char *embree_version(void);

#endif
