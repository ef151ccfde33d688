/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_STREAM_H
#define RENDER_STREAM_H

#include "render/camera.h"
#include "render/filter.h"
#include "render/path.h"

/*
 * Many light paths in step: all arrive, all connect to lights, all scatter. The state of the paths
 * lies in arrays, one lane per path, so that the arithmetic of most lanes (triangles, all common
 * lights, diffuse and rough surfaces, scenes of few primitives) runs in loops that compilers turn
 * into vector code (stream_kernels.h and its parts, one translation unit per instruction set);
 * other lights and materials take their lanes one by one through the functions that the plain loop
 * calls, path_radiance(). The arithmetic is the same everywhere, operation by operation, so that
 * results do not depend on the instruction set.
 *
 * Rays go to Embree in packets, those of later bounces too: that is a fifth faster even in scenes
 * of many triangles. A packet holds samples of one pixel only: what Embree finds can depend on a
 * packet's other rays in the last bit, so this keeps a pixel's bytes the same in whatever window it
 * is traced, if the same samples of it always share a stream.
 *
 * STREAM_VECTOR: lanes of the longest vectors; STREAM_ALIGNMENT: their bytes.
 */
enum { STREAM_SIZE = 128, STREAM_PACKET = 16, STREAM_VECTOR = 16, STREAM_ALIGNMENT = 64 };

/* Lanes of as many vectors as n lanes begin. */
static inline uint32_t stream_whole(uint32_t n)
{
    return (n + STREAM_VECTOR - 1) / STREAM_VECTOR * STREAM_VECTOR;
}

struct lanes3 {
    float x[STREAM_SIZE], y[STREAM_SIZE], z[STREAM_SIZE];
};

static inline struct vec3 lanes3_get(const struct lanes3 *a, uint32_t i)
{
    return vec3(a->x[i], a->y[i], a->z[i]);
}

static inline void lanes3_set(struct lanes3 *a, uint32_t i, struct vec3 v)
{
    a->x[i] = v.x;
    a->y[i] = v.y;
    a->z[i] = v.z;
}

/* Materials that have vector code of their own, by the kind of their facets. */
enum facet_list {
    FACET_CONDUCTOR_GGX,
    FACET_CONDUCTOR_BECKMANN,
    FACET_PLASTIC_GGX,
    FACET_PLASTIC_BECKMANN,
    FACET_DIELECTRIC_GGX,
    FACET_DIELECTRIC_BECKMANN,
    FACET_LISTS_N
};

static inline bool facet_list_is_plastic(enum facet_list list)
{
    return list == FACET_PLASTIC_GGX || list == FACET_PLASTIC_BECKMANN;
}

static inline bool facet_list_is_dielectric(enum facet_list list)
{
    return list >= FACET_DIELECTRIC_GGX;
}

static inline enum microfacet_kind facet_list_kind(enum facet_list list)
{
    return list % 2 == 0 ? MICROFACET_GGX : MICROFACET_BECKMANN;
}

/* Lanes of a list brought together: what vector code wants to know of them. */
struct facet_block {
    uint32_t n, n_filled; /* the last vector is filled: the rest of a loop would go lane by lane */
    _Alignas(STREAM_ALIGNMENT) float alpha_u[STREAM_SIZE];
    float alpha_v[STREAM_SIZE];
    struct lanes3 wi, wo, specular, value;
    float pdf[STREAM_SIZE];
    struct lanes3 eta, k;                          /* conductors */
    float index[STREAM_SIZE], wo_eta[STREAM_SIZE]; /* wo_eta, for dielectrics: of the sample */
    struct lanes3 base; /* plastics: of what is below; dielectrics: of what passes */
    /* Plastics. */
    float specular_weight[STREAM_SIZE];
    float internal[STREAM_SIZE], nonlinear[STREAM_SIZE];
    float t_i[STREAM_SIZE], t_o[STREAM_SIZE]; /* what the coat lets through */
    float u1[STREAM_SIZE], u2[STREAM_SIZE], v2[STREAM_SIZE];
};

/* Random numbers that not every bounce uses. */
enum stream_numbers { STREAM_LOBE = 1, STREAM_ROULETTE = 2 };

struct stream {
    uint64_t ray_ticks; /* sums up what casting takes */
    uint32_t n;         /* lanes in use; those of dead paths compute nothing that matters */
    uint32_t n_facets[FACET_LISTS_N]; /* lanes of rough conductors, plastics, dielectrics */
    uint32_t n_scalar;                /* of materials that no vector code knows */

    /* Arrays lie on whole vectors: compilers would have loops begin lane by lane. */
    _Alignas(STREAM_ALIGNMENT) uint32_t is_alive[STREAM_SIZE];

    /* Where a path starts: the centre of its pixel in the full picture. */
    float center_x[STREAM_SIZE], center_y[STREAM_SIZE];
    uint32_t sample[STREAM_SIZE];
    uint64_t pixel[STREAM_SIZE];
    float offset[STREAM_SIZE]; /* from the pinhole to the ray's start */

    /* What a path carries from bounce to bounce. */
    uint32_t path[STREAM_SIZE];  /* its number: the lane it started in */
    uint32_t owner[STREAM_SIZE]; /* whose packets it goes with: the first lane of its pixel */
    struct lanes3 o, d;          /* the ray, from t = 0 */
    float t_max[STREAM_SIZE];
    struct lanes3 throughput;
    struct lanes3 last_p; /* as in struct path */
    float last_pdf[STREAM_SIZE];
    uint32_t last_is_delta[STREAM_SIZE];
    float eta[STREAM_SIZE];
    uint32_t met[STREAM_SIZE];
    uint32_t seed[STREAM_SIZE], index[STREAM_SIZE];           /* of the sampler: sobol */
    uint64_t rng_state[STREAM_SIZE], rng_stream[STREAM_SIZE]; /* independent */

    /* Where the ray has arrived: a surface as in struct surface. In scenes of few primitives t and
     * face say what it has hit, as few_hit() reads it, and hit follows for those who ask. */
    float t[STREAM_SIZE];
    int32_t face[STREAM_SIZE];
    uint32_t is_special[STREAM_SIZE]; /* alive, and no even face */
    struct hit hit[STREAM_SIZE];
    const struct world_shape *shape[STREAM_SIZE];
    struct lanes3 p, normal, frame_s, frame_t, frame_n, wi;
    float texture_u[STREAM_SIZE], texture_v[STREAM_SIZE];

    /* Its material. Diffuse ones are left to kernels. */
    uint32_t bsdf_is_smooth[STREAM_SIZE];   /* light samples can find it */
    uint32_t receiver[STREAM_SIZE];         /* with photons: enum photon_receiver_kind */
    uint32_t bsdf_is_twosided[STREAM_SIZE]; /* and plain */
    float bsdf_side[STREAM_SIZE];           /* -1 where seen from behind and two-sided, else 1 */
    struct lanes3 reflectance; /* also of rough plastics below their coat, and of rough metals */
    uint32_t facets[FACET_LISTS_N][STREAM_SIZE], scalar[STREAM_SIZE];
    struct facet_block facet_blocks[FACET_LISTS_N];
    const struct bsdf_point *bsdf[STREAM_SIZE]; /* all but plain ones */
    struct bsdf_point own_bsdf[STREAM_SIZE];    /* of those that are looked up lane by lane */

    /* Random numbers of the bounce: light 2, direction 2, lobe, roulette. The last two are drawn
     * where some lane uses them. */
    float u[6][STREAM_SIZE];

    /* The light sample. */
    uint32_t has_light[STREAM_SIZE];                        /* one is wanted; one was found */
    int32_t light_index[STREAM_SIZE], element[STREAM_SIZE]; /* element: of the table */
    float light_left[STREAM_SIZE], light_choice[STREAM_SIZE];
    struct lanes3 light_p, light_d, light_weight, light_wo; /* light_wo: d in the shading frame */
    float light_pdf[STREAM_SIZE];
    uint32_t light_is_delta[STREAM_SIZE], light_is_infinite[STREAM_SIZE];
    struct lanes3 value; /* of the bsdf towards the light */
    float value_pdf[STREAM_SIZE];
    struct lanes3 shadow_o, shadow_d;
    float shadow_t_max[STREAM_SIZE];
    struct lanes3 light; /* what arrives if nothing is in the way */
    uint32_t is_connected[STREAM_SIZE];
    uint32_t is_free[STREAM_SIZE]; /* of those: nothing is in the way */

    /* The next direction. */
    struct lanes3 wo, weight;
    float wo_pdf[STREAM_SIZE], wo_eta[STREAM_SIZE];
    uint32_t wo_is_delta[STREAM_SIZE];
    uint32_t is_aimed[STREAM_SIZE]; /* at something that may shine */

    struct lanes3 radiance; /* the result, by number of path */

    /* Sums by light group, where they are wanted: of path k at groups + group * group_stride +
     * place[k]. */
    float *groups;
    const uint32_t *group_of; /* [n_emitters] */
    uint32_t chain_group;     /* added for what is seen along delta chains; 0: nothing to split */
    uint32_t is_chain[STREAM_SIZE]; /* carried: the path is still on its chain */
    size_t group_stride, place[STREAM_SIZE];

    struct path_ends *ends;       /* NULL: paths are not cut */
    struct path_lengths *lengths; /* NULL: nobody counts */
    uint32_t first_sample;
};

/* What all primary rays share. */
struct stream_film {
    struct camera camera;
    struct filter filter;
    uint32_t margin; /* of splats; 0: the filter is importance-sampled */
    uint32_t width, height;
    enum sampler_kind sampler;
    uint64_t seed;
};

struct first_hits;
struct light_around;

/* Steps over all lanes of a stream, alive or not. */
struct stream_kernels {
    const char *name;
    /* Samplers, and u[0], u[1]: the film's. */
    void (*start)(struct stream *s, enum sampler_kind sampler, uint64_t seed);
    /* Primary rays through the points u[0], u[1] of the picture. */
    void (*look)(struct stream *s, const struct camera *camera);
    /* Random numbers u of a bounce, from this dimension on; `wanted`: of enum stream_numbers. */
    void (*draw)(struct stream *s, enum sampler_kind sampler, uint32_t dimension, uint32_t wanted);
    /* Normals at any length -> unit normals, frame, wi; bsdf_side. */
    void (*surface)(struct stream *s);
    /* The light that each lane samples: light_index, light_choice, light_left. */
    void (*choose_light)(struct stream *s, const struct light_guide *g);
    /* Light samples from a table, for lanes that want one: has_light. */
    void (*light)(struct stream *s, const struct light_table *t);
    /* The same from an environment, for these lanes. */
    void (*light_around)(struct stream *s, const struct light_around *a, const uint32_t *lanes,
                         uint32_t n_lanes);
    /* light_wo, and value and value_pdf of diffuse lanes. */
    void (*eval)(struct stream *s);
    /* Brings together the lanes that have facets. */
    void (*facets_gather)(struct stream *s);
    /* The same of these; their next directions. */
    void (*facets_eval)(struct stream *s);
    void (*facets_sample)(struct stream *s);
    /* What connects: is_connected, light, shadow rays. */
    void (*connect)(struct stream *s, enum mis_kind mis, bool saves_rays);
    /* wo, weight, wo_pdf, ... of diffuse lanes. */
    void (*sample)(struct stream *s);
    /* The next rays; paths whose throughput is zero, or that lose at roulette, die. The chance to
     * survive is at least `least_survival`: 1 where roulette is not yet played. */
    void (*scatter)(struct stream *s, float least_survival);
    /* Adds light samples that are connected and free. */
    void (*add_lights)(struct stream *s);
    /* Paths whose ray misses all boxes die. */
    void (*aim)(struct stream *s, const struct bounds *boxes, uint32_t n_boxes);
    /* Buffers (buffers.h): primary rays of a pinhole, but at the picture's border; then normals,
     * directions and depth. */
    void (*look_at)(struct first_hits *f, const struct stream_film *film);
    void (*describe)(struct first_hits *f);
    /* Rays into few primitives: t and face; what they find where faces are even (struct
     * few_look), for surface(), and is_special; which of the connected are free. Paths that hit
     * nothing die if nothing surrounds the scene. */
    void (*few_cast)(struct stream *s, const struct few *few);
    void (*few_arrive)(struct stream *s, const struct few *few, bool is_surrounded);
    void (*few_shade)(struct stream *s, const struct few *few, uint32_t *is_free);
};

extern const struct stream_kernels stream_kernels_baseline, stream_kernels_avx2,
    stream_kernels_avx512;

/* The best that `cpu`, a mask of enum cpu_flag, allows. */
const struct stream_kernels *stream_kernels_for(uint32_t cpu);

/* Adds sample number `sample` of pixel (x, y) to a stream that has room. Samples of one pixel that
 * share packets follow each other, in rising order; a pixel that comes again stands for itself. */
void stream_add(struct stream *s, const struct stream_film *f, uint32_t x, uint32_t y,
                uint32_t sample);

/* Makes the primary rays of what was added. */
void stream_start(struct stream *s, const struct view *v, const struct stream_film *f);

/* Casts all rays: stream_find_hits() can then fill in s->hit. is_first: primary rays, whose packets
 * go about together. */
void stream_cast(struct stream *s, const struct view *v, bool is_first);

/* Fills in s->hit of living lanes. */
void stream_find_hits(struct stream *s, const struct view *v);

/* Follows all paths from the hits of their primary rays to their ends: s->radiance. */
void stream_trace(struct stream *s, const struct view *v, const struct trace_settings *t);

#endif
