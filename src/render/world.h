/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_WORLD_H
#define RENDER_WORLD_H

#include "math/distribution.h"
#include "render/bsdf.h"
#include "render/embree.h"
#include "render/few.h"
#include "render/texture.h"
#include "render/view.h"

/* The insides of struct world and struct view, for the files of src/render/ only. */

/* What tracing needs of a shape, in one place. Pointers are into the scene. */
struct world_shape {
    enum shape_kind kind;
    bool is_flipped;
    uint32_t emitter;        /* SCENE_NONE: none */
    const struct mesh *mesh; /* NULL: none */
    const float *positions, *normals, *uvs;
    const uint32_t *indices;
    const struct transform *to_group; /* all but meshes */
    struct vec3 center;               /* group space; of emissive meshes, by area */
    float extent;                     /* emissive meshes: farthest vertex from center */
    float radius;                     /* spheres, cylinders, group space */
    uint32_t index;                   /* into scene->shapes */
    struct distribution area;         /* emissive meshes: triangles by area in group space */
    float total_area;                 /* emissive meshes, cylinders: in group space */
    struct bounds bounds;             /* in group space */
    float reach;                      /* from the middle of bounds to the farthest point */
    uint32_t light;                   /* emissive shapes: number among those of the group */
    float flat_side; /* emissive meshes whose shading normals are those of the faces: 1;
                        opposite to them: -1; otherwise 0 */
};

/* An image of radiance around the scene, ready for sampling. The picture's texel centres are nodes
 * of a periodic grid; radiance is bilinear between them and a cell (between four nodes) is chosen
 * by its mean luminance and solid angle. */
struct world_envmap {
    uint32_t width, height;      /* nodes */
    float span;                  /* from the pole +y to the last row: pi, or pi / 2 for half a map,
                                    which is black and never chosen beyond */
    float *rgb;                  /* [height][width][3] */
    struct distribution2d cells; /* width x (height - 1) */
    float mean;                  /* luminance, over all directions */
};

/* The tables of a sky and its sun, for one configuration. */
struct sky {
    float turbidity, elevation; /* what they are for */
    struct world_envmap map;
    float *weights;                 /* scratch */
    float sin_azimuth, cos_azimuth; /* of the sun, in the emitter's space */
    struct vec3 to_sun, up;         /* in world space, unit */
    float sun_height;               /* 1 - cos of half its aperture */
    struct vec3 sun;                /* what it sends to a surface that faces it */
};

struct world {
    const struct scene *scene;
    const struct stream_kernels *kernels;
    struct accel *accel;
    struct world_shape *shapes;   /* [n_shapes] */
    uint32_t *group_n_lights;     /* [n_groups] */
    struct world_envmap *envmaps; /* [n_bitmaps], unused for others */
    uint32_t n_lights_max;        /* of any configuration */
    uint32_t n_skies;
    float decode[2][256];
};

/* What the ends of rays ask of most shapes, in one line of memory. */
struct view_shape {
    const struct world_shape *shape;
    const uint32_t *indices;
    const float *normals, *uvs;    /* NULL: none, or not needed */
    const struct texture *picture; /* that the material looks up; NULL: none */
    struct vec3 reflectance;       /* plain materials */
    float side;                    /* of normals: -1 to turn them */
    bool is_simple;                /* a mesh, and no tangents: what is here suffices */
    bool is_twosided;              /* and plain (bsdf.h) */
    bool is_textured;              /* plain or tinted, and the colour is a texture */
    bool is_special;               /* it shines, or the material is not plain */
};

/* An instance as hits see it. */
struct view_instance {
    const struct world_shape *shapes; /* of its group */
    const struct view_shape *views;   /* the same */
    const struct transform *to_world;
    uint32_t first_light; /* of its lights */
    bool is_identity;
    float determinant; /* of to_world */
    float scale;       /* of lengths, when it is the same in all directions; else 0 */
};

/* One thing that shines: an emissive shape of a visible instance, or an emitter without shape. */
struct light {
    enum emitter_kind kind;
    uint32_t emitter; /* into state->emitters */
    uint32_t instance;
    const struct world_shape *shape;        /* EMITTER_AREA */
    const struct sky *sky;                  /* EMITTER_SKY, EMITTER_SUN */
    float cos_cutoff, cos_beam, transition; /* SPOT; transition in radians */
    float tan_x, tan_y; /* SPOT, PROJECTOR: half the picture's width and height at z = 1 */
};

/*
 * What few lights may send to a point, roughly, to choose among them by: power over squared
 * distance to the middle, less at grazing angles of flat ones. A share of LIGHT_EVEN goes to all
 * alike, so that no light is ever missed.
 */
enum { LIGHT_GUIDES = 32 };
#define LIGHT_EVEN 0.1f

struct light_hint {
    struct vec3 center, normal; /* normal 0: not flat */
    float power;                /* irradiance at distance 1, or of what is far away */
    float radius2;              /* distances below count as this */
    float near;                 /* 0: so far away that distance does not matter; else 1 */
    float base, slope;          /* factor: base + slope * cosine */
};

struct light_guide {
    uint32_t n; /* 0: one light, or more than fit */
    struct light_hint hints[LIGHT_GUIDES];
};

/*
 * The elements of lights in world space, ready for sampling: of meshes, disks and spheres that
 * shine the same everywhere. Vector code chooses among them and looks up what it needs; halves of a
 * parallelogram are one element. light_table.h has the rest.
 */
enum { LIGHT_TABLE_MAX = 1 << 16, LIGHT_TABLE_FEW = 32, LIGHT_FIELDS = 24 };

/* Kinds of elements in a table, for each of these sets of which there is vector code of its own. */
enum light_kinds {
    LIGHT_FACES = 1, /* triangles, parallelograms */
    LIGHT_TURNS = 2, /* their normals turn */
    LIGHT_DISKS = 4,
    LIGHT_SPHERES = 8,
    LIGHT_SMOOTH = LIGHT_FACES | LIGHT_TURNS,
    LIGHT_ALL = 15
};

struct light_table {
    uint32_t capacity; /* elements of all instances; 0: too many */
    float *memory;     /* of what follows */
    int32_t n;         /* 0: no table */
    enum light_kinds kinds;
    uint32_t holds; /* bit k: light k is in it */
    /* Of a light: its elements, and where its part of `parts` begins. Those of another light, for
     * lights that are not in the table: then any lane can look. */
    int32_t first[LIGHT_GUIDES], count[LIGHT_GUIDES], first_part[LIGHT_GUIDES];
    float radiance[3][LIGHT_TABLE_FEW];
    float *rows; /* [n][LIGHT_FIELDS]: struct light_element */
    float *cdf;  /* [n], of those */
    /* Where to search: the first element of a light that can lie in each of as many equal parts of
     * [0,1) as it has elements, and of its end. */
    int32_t *parts;
    int32_t n_widest;                             /* elements to search in a part, at most */
    float columns[LIGHT_FIELDS][LIGHT_TABLE_FEW]; /* rows turned over, where they are few */
};

struct look;

enum { VIEW_BOXES = 32, VIEW_NO_BOXES = VIEW_BOXES + 1 };

struct view {
    const struct world *world;
    struct scene_state state;
    struct accel_top *top;
    struct few few;
    struct texture_set textures;
    struct material *materials;      /* [n_bsdfs] */
    struct bsdf_point *ready;        /* [2 n_bsdfs] */
    struct look *looks;              /* [n_bsdfs] */
    struct coat *coats;              /* one for each rough plastic */
    struct view_shape *shapes;       /* [n_shapes] */
    struct view_instance *instances; /* [n_instances] */
    struct instance *committed;      /* [n_instances]: as the top level has them */
    struct light *lights;            /* [world->n_lights_max] */
    struct sky *skies;               /* [world->n_skies], in the order of the emitters */
    float
        *light_cdf; /* [world->n_lights_max + 1]: by power, where they are more than LIGHT_GUIDES */
    struct light_guide guide;
    struct light_table table;
    /* [n_boxes] around all that shines; VIEW_NO_BOXES where that is too many, or everywhere. */
    struct bounds boxes[VIEW_BOXES];
    uint32_t n_boxes;
    uint32_t n_lights;
    uint32_t first_environment; /* lights from here on surround the scene */
};

/* Whether shadow rays cost enough to leave some to chance. */
static inline bool view_saves_rays(const struct view *v)
{
    return !few_is_used(&v->few);
}

/* Brings what is derived from the state up to date: instances that moved, lights, materials. */
void view_refresh(struct view *v, bool is_first);

#endif
