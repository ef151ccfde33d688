/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_SCENE_H
#define SCENE_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/mem.h"
#include "image/image.h"
#include "math/transform.h"

/*
 * A variable scene. What never changes (meshes, bitmaps, names) is in struct scene. Everything that
 * a variable can change is in a struct scene_state: a few small arrays of plain values, so that a
 * worker owns a copy, and changing a configuration writes only the values that are bound.
 *
 *   scene file -> reader -> builder -> struct scene (+ its default state)
 *   u in [0,1]^D -> scene_apply() -> struct scene_state -> renderer
 */

enum { SCENE_NONE = 0x7FFFFFFF }; /* no such index */

/* ---- Never changes ------------------------------------------------------------------------ */

/* Numbers on a mesh by name ("vertex_color"), for the texture `mesh_attribute`. */
struct mesh_attribute {
    const char *name;
    uint64_t key;        /* mesh_attribute_key() of the name */
    float *values;       /* [n_vertices or n_triangles][n_channels] */
    uint32_t n_channels; /* 1 or 3 */
    bool is_of_faces;    /* one value for each triangle, else for each vertex */
};

/* Triangles in the space of the group they belong to. Arrays are padded by 16 bytes for Embree. */
struct mesh {
    float *positions;  /* [n_vertices][3] */
    float *normals;    /* [n_vertices][3] unit length, or NULL: the geometric normal is used */
    float *uvs;        /* [n_vertices][2], or NULL: barycentric coordinates, as Mitsuba */
    uint32_t *indices; /* [n_triangles][3] */
    uint32_t n_vertices, n_triangles;
    struct mesh_attribute *attributes;
    uint32_t n_attributes;
};

enum shape_kind {
    SHAPE_MESH,   /* also rectangle, cube, obj, ply */
    SHAPE_SPHERE, /* unit sphere at the origin under to_group (rotation, uniform scale, translation)
                   */
    SHAPE_DISK,   /* unit disk in z = 0, normal +z, under to_group */
    SHAPE_CYLINDER /* x^2 + y^2 = 1, z in [0,1], open ends, under to_group, which keeps it round */
};

struct shape {
    const char *name; /* id, or a made-up one; unique */
    enum shape_kind kind;
    uint32_t mesh;             /* SHAPE_MESH: into scene->meshes */
    struct transform to_group; /* all but meshes; identity for these (baked in) */
    uint32_t emitter;          /* area light, into state->emitters, or SCENE_NONE */
    bool flip_normals;
};

struct bounds {
    struct vec3 min, max;
};

/* Shapes that move together: one bottom-level acceleration structure. */
struct group {
    const char *name;
    uint32_t first_shape, n_shapes; /* a run of scene->shapes */
    struct bounds bounds;           /* in the group's space; min > max when it is empty */
};

/* ---- Can change: the state ----------------------------------------------------------------- */

enum texture_kind {
    TEXTURE_CONSTANT,
    TEXTURE_BITMAP,
    TEXTURE_CHECKERBOARD,
    TEXTURE_GRID,
    TEXTURE_MESH_ATTRIBUTE
};
enum texture_filter { TEXTURE_BILINEAR, TEXTURE_NEAREST };
enum texture_wrap { TEXTURE_REPEAT, TEXTURE_MIRROR, TEXTURE_CLAMP };

/* Every colour or number that a surface varies over is a texture; most are constant. */
struct texture {
    enum texture_kind kind;
    struct vec3 value;          /* CONSTANT: the value. Others: a factor on the result, usually 1 */
    struct vec3 color0, color1; /* CHECKERBOARD; GRID: between lines, on them */
    float line_width;           /* GRID: half the width of a line; a cell has side 1 */
    float to_uv[2][3];          /* uv' = to_uv [u v 1] */
    uint32_t bitmap;            /* BITMAP: into scene->bitmaps */
    uint64_t attribute;         /* MESH_ATTRIBUTE: mesh_attribute_key() of its name */
    enum texture_filter filter;
    enum texture_wrap wrap;
    bool is_raw; /* no sRGB decoding of 8-bit bitmaps */
};

enum bsdf_kind {
    BSDF_DIFFUSE,
    BSDF_CONDUCTOR,
    BSDF_ROUGH_CONDUCTOR,
    BSDF_DIELECTRIC,
    BSDF_ROUGH_DIELECTRIC,
    BSDF_PLASTIC,
    BSDF_ROUGH_PLASTIC,
    BSDF_THIN_DIELECTRIC,
    BSDF_ROUGH_DIFFUSE, /* Oren & Nayar 1994 */
    BSDF_PRINCIPLED,    /* Burley 2012, 2015 */
    BSDF_PHONG,         /* modified Phong: Lafortune & Willems 1994 */
    BSDF_BLINN_PHONG,
    BSDF_NULL,      /* not there */
    BSDF_TWOSIDED,  /* child[0] seen from the front, child[1] from the back */
    BSDF_MASK,      /* child[0] where opacity, straight through elsewhere */
    BSDF_BLEND,     /* (1 - weight) child[0] + weight child[1] */
    BSDF_BUMPMAP,   /* child[0] under a normal that follows a height */
    BSDF_NORMALMAP, /* child[0] under a normal from a picture */
    BSDF_KINDS
};
enum microfacet_kind { MICROFACET_BECKMANN, MICROFACET_GGX };

/* Textures of BSDF_PRINCIPLED beside reflectance (base_color) and alpha_u (roughness). */
enum principled_slot {
    PRINCIPLED_ANISOTROPIC,
    PRINCIPLED_METALLIC,
    PRINCIPLED_SPEC_TRANS,
    PRINCIPLED_SPEC_TINT,
    PRINCIPLED_SHEEN,
    PRINCIPLED_SHEEN_TINT,
    PRINCIPLED_FLATNESS,
    PRINCIPLED_CLEARCOAT,
    PRINCIPLED_CLEARCOAT_GLOSS,
    PRINCIPLED_SLOTS
};

/* Indices are into state->textures unless said otherwise; unused ones are SCENE_NONE. */
struct bsdf {
    enum bsdf_kind kind;
    enum microfacet_kind distribution;
    uint32_t reflectance; /* diffuse, principled: base_color; plastic, phong: diffuse_reflectance */
    uint32_t specular_reflectance;
    uint32_t specular_transmittance; /* dielectrics */
    uint32_t alpha_u, alpha_v;       /* rough: x channel; principled: roughness = alpha_u */
    uint32_t eta_texture, k_texture; /* conductors: complex index of refraction, RGB */
    float eta;                       /* dielectrics, plastic: int_ior / ext_ior; principled */
    bool is_nonlinear;               /* plastic */
    bool is_approximate;             /* rough diffuse: the short formula, without interreflection */
    uint32_t exponent;               /* phong, blinn-phong */
    uint32_t opacity;                /* mask */
    uint32_t weight;                 /* blend */
    uint32_t normals;                /* bumpmap: height; normalmap: (n + 1) / 2 */
    float scale;                     /* bumpmap: of the height */
    bool flips_normals;              /* bumpmap, normalmap: normals never face away from the eye */
    bool has_shadowing;              /* bumpmap, normalmap: soften the terminator */
    uint32_t principled[PRINCIPLED_SLOTS];
    float diffuse_rate, specular_rate, clearcoat_rate; /* principled: preference in sampling */
    uint32_t child[2];                                 /* into state->bsdfs */
};

enum fov_axis { FOV_X, FOV_Y, FOV_DIAGONAL, FOV_SMALLER, FOV_LARGER };

enum emitter_kind {
    EMITTER_AREA,
    EMITTER_CONSTANT,
    EMITTER_ENVMAP,
    EMITTER_POINT,
    EMITTER_SPOT,             /* at the origin, towards +z */
    EMITTER_DIRECTIONAL,      /* from infinity, towards +z */
    EMITTER_PROJECTOR,        /* a pinhole as the sensor's, that throws a picture */
    EMITTER_DIRECTIONAL_AREA, /* a surface that shines along its normals only */
    EMITTER_SKY,              /* the sky above +z with the sun in it */
    EMITTER_SUN, /* only renderers call it so: the sun of a SKY as a light of its own */
    EMITTER_KINDS
};
/* A bsdf of that kind without textures and children. */
struct bsdf bsdf_blank(enum bsdf_kind kind);

/* How many children it has; a twosided material may have one twice. */
static inline int bsdf_n_children(enum bsdf_kind kind)
{
    if (kind == BSDF_TWOSIDED || kind == BSDF_BLEND) return 2;
    return kind == BSDF_MASK || kind == BSDF_BUMPMAP || kind == BSDF_NORMALMAP;
}

/* Every place of a bsdf that can hold a texture: offsets of its indices. */
enum { BSDF_TEXTURES = 11 + PRINCIPLED_SLOTS };
extern const uint32_t bsdf_texture_offsets[BSDF_TEXTURES];

static inline uint32_t bsdf_texture(const struct bsdf *f, int i)
{
    return *(const uint32_t *)((const char *)f + bsdf_texture_offsets[i]);
}

struct emitter {
    enum emitter_kind kind;
    uint32_t radiance; /* texture; POINT, SPOT: intensity. DIRECTIONAL: irradiance of what faces it.
                          PROJECTOR: the picture, irradiance at distance 1. DIRECTIONAL_AREA: power
                          per area */
    float scale;       /* factor on it; ENVMAP: on the bitmap */
    uint32_t bitmap;   /* ENVMAP: latitude-longitude image, into scene->bitmaps */
    struct transform to_world; /* all but AREA, DIRECTIONAL_AREA */
    uint32_t picture;          /* SPOT: texture, a factor over the cone; or SCENE_NONE */
    float cutoff, beam_width;  /* SPOT: degrees off the axis. Dark beyond, full within */
    float fov;                 /* PROJECTOR: degrees along fov_axis */
    enum fov_axis fov_axis;
    float turbidity;                  /* SKY: 1 (clear) to 10 (haze) */
    float sun_elevation, sun_azimuth; /* degrees above the horizon, and from +x towards +y */
    float sky_scale, sun_scale;       /* factors */
    float sun_aperture;               /* degrees across; its light stays the same */
};

/* Around the whole scene, where rays end that hit nothing. */
static inline bool emitter_is_environment(enum emitter_kind kind)
{
    return kind == EMITTER_CONSTANT || kind == EMITTER_ENVMAP || kind == EMITTER_SKY ||
           kind == EMITTER_SUN;
}

/* Belongs to a shape. */
static inline bool emitter_is_surface(enum emitter_kind kind)
{
    return kind == EMITTER_AREA || kind == EMITTER_DIRECTIONAL_AREA;
}

/* An instance places a group. Instance 0 is the group of everything that stays, at identity. */
struct instance {
    uint32_t group;
    struct transform to_world;
    bool is_visible;
};

/* What keeps rays finite: Embree wants that. */
#define SENSOR_MAX_NEAR     1e6
#define SENSOR_MAX_SHIFT    1e3
#define SENSOR_MAX_APERTURE 1e6
#define SENSOR_MIN_FOCUS    1e-6
#define SENSOR_MAX_FOCUS    1e12

enum sensor_kind { SENSOR_PERSPECTIVE, SENSOR_THINLENS, SENSOR_ORTHOGRAPHIC };

/* Camera space looks along +z, +x is left, +y up. What is 0 unless said otherwise is off. */
struct sensor {
    enum sensor_kind kind;
    struct transform to_world; /* rigid, mirrored perhaps */
    float fov;                 /* degrees along fov_axis; not ORTHOGRAPHIC */
    enum fov_axis fov_axis;
    float near_clip, far_clip;
    float aperture_radius, focus_distance; /* THINLENS */
    float scale_x, scale_y;                /* ORTHOGRAPHIC: half the film's width, and the same
                                              for its height, but for the film's proportions */
    float shift_x, shift_y; /* of the principal point, in widths and heights of the film */
    struct {
        float left, top, right, bottom; /* parts of the film that the picture does not show */
    } crop;
};

struct scene_state {
    struct texture *textures;   /* [scene->n_textures] */
    struct bsdf *bsdfs;         /* [scene->n_bsdfs] */
    struct emitter *emitters;   /* [scene->n_emitters] */
    struct instance *instances; /* [scene->n_instances] */
    uint32_t *shape_bsdfs;      /* [scene->n_shapes] -> bsdfs */
    struct sensor sensor;
};

/* ---- Film and integrator, as declared ------------------------------------------------------- */

enum filter_kind { FILTER_BOX, FILTER_TENT, FILTER_GAUSSIAN };
enum sampler_kind { SAMPLER_INDEPENDENT, SAMPLER_SOBOL };
enum integrator_kind {
    INTEGRATOR_AUTO, /* by what the configuration holds: view_wants_photons() */
    INTEGRATOR_PATH,
    INTEGRATOR_PHOTONS
};

struct render_settings {
    uint32_t width, height, spp;
    int32_t max_depth; /* Mitsuba's `path`: 1 = emission only, -1 = no limit */
    int32_t rr_depth;
    bool hide_emitters;
    enum filter_kind filter;
    float filter_radius; /* box .5; tent 1; gaussian: cut off at 4 sigma */
    float filter_stddev; /* gaussian */
    enum sampler_kind sampler;
    enum integrator_kind integrator; /* PHOTONS where the file asks for a photon mapper */
    uint64_t seed;
};

/* ---- Parameters and variables ---------------------------------------------------------------- */

enum param_type { PARAM_FLOAT, PARAM_RGB, PARAM_TRANSFORM, PARAM_TEXTURE, PARAM_BSDF, PARAM_BOOL };
enum state_array {
    STATE_TEXTURES,
    STATE_BSDFS,
    STATE_EMITTERS,
    STATE_INSTANCES,
    STATE_SHAPE_BSDFS,
    STATE_SENSOR,
    STATE_NOWHERE /* fixed while no variable drives it: baked into the geometry */
};

/* A path and the place in the state that it names. */
struct param {
    const char *path;
    enum param_type type;
    enum state_array array;
    uint32_t index;    /* element of the array */
    uint32_t offset;   /* bytes into the element */
    const char *value; /* the default, as text */
};

/* NULL for STATE_NOWHERE. */
void *param_in(const struct param *p, struct scene_state *state);

/* One dimension of the space of configurations; public meaning in struct lmn_variable_info. */
struct variable {
    const char *name, *group, *kind, *unit, *targets, *description; /* the last may be NULL */
    double min, max, value;                                         /* scene units */
    uint32_t n_choices; /* > 0: discrete, values 0 .. n_choices-1 */
    const char *const *choices;
};

struct binding; /* how variables write into the state; src/scene/binding.h */

struct scene {
    struct arena arena; /* owns all below but bitmaps' pixels */
    const char *path;
    uint64_t hash;        /* of everything that changes an image */
    struct bounds bounds; /* of the default state */

    struct mesh *meshes;
    struct shape *shapes;
    struct group *groups;
    struct bitmap *bitmaps;
    uint32_t n_meshes, n_shapes, n_groups, n_bitmaps;

    struct scene_state defaults;
    uint32_t n_textures, n_bsdfs, n_emitters, n_instances;

    struct render_settings settings;
    const char **light_groups; /* [n_emitters], NULL where the file names none; or NULL */

    struct param *params;
    struct variable *variables;
    struct binding *bindings;
    uint32_t n_params, n_variables, n_bindings;
};

struct scene_load_options {
    const char *const *defines; /* "name=value" */
    uint32_t n_defines;
    const char *variables_path; /* NULL: SCENE.variables.json when it is there */
    lmn_note_fn *note;          /* told what was ignored; may be NULL */
    void *note_user;
};

lmn_status scene_load(const char *path, const struct scene_load_options *options,
                      struct scene **out, struct error *err);
void scene_free(struct scene *s);

/* Of all that is visible in a configuration; infinite spans are left out, an empty scene is a
 * point.
 */
struct bounds scene_bounds(const struct scene *s, const struct scene_state *state);

/* A state of its own, equal to the defaults. Release with scene_state_release(). */
lmn_status scene_state_init(const struct scene *s, struct scene_state *state, struct error *err);
void scene_state_release(struct scene_state *state);

/* Sets the configuration u [n_variables], each in [0,1] (a discrete variable takes
 * min(floor(u * n), n - 1)). `state` must come from scene_state_init() of this scene. Writes only
 * what is bound; allocates nothing. */
void scene_apply(const struct scene *s, const float *u, struct scene_state *state);

/* Scene units to u and back. */
float variable_to_unit(const struct variable *v, double value);
double variable_from_unit(const struct variable *v, float u);

#endif
