/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_BSDF_H
#define RENDER_BSDF_H

#include "render/coat.h"
#include "render/microfacet.h"
#include "render/texture.h"
#include "scene/scene.h"

/*
 * Materials. Work is split in two, so that what comes after needs no scene:
 *
 *   material     what a bsdf of the state says, with constants worked out once per configuration
 *   bsdf_point   the same at one surface point: textures looked up, nesting resolved
 *
 * Directions wi (to the viewer) and wo are unit vectors in the shading frame, z along the shading
 * normal. Values include the cosine |wo.z|. Models are those of Mitsuba 3, radiance transport:
 * transmitted light is scaled by 1/eta^2.
 */

enum lobe {                     /* kinds of scattering, as a mask */
            LOBE_NULL = 1u,     /* straight through, as if there were no surface */
            LOBE_DIFFUSE = 2u,  /* smooth in wo */
            LOBE_GLOSSY = 4u,   /* smooth in wo, peaked */
            LOBE_SPECULAR = 8u, /* a mirror direction: a delta function */
            LOBE_SMOOTH = LOBE_DIFFUSE | LOBE_GLOSSY,
            LOBE_DELTA = LOBE_NULL | LOBE_SPECULAR
};

struct material {
    const struct bsdf *bsdf;   /* in the view's state */
    uint32_t lobes;            /* all that it or its children can have */
    float specular_weight;     /* plastic, phong: preference for the coat when sampling */
    float internal_reflection; /* plastic: diffuse Fresnel reflectance from inside */
    struct coat *coat;         /* rough plastic */
    bool has_uv;               /* some texture varies */
    uint32_t picture;          /* the first texture that is a bitmap; SCENE_NONE: none */
    bool has_direction;        /* the shading frame must follow dp/du: anisotropy, normal maps */
    bool has_attributes;       /* mesh attributes: struct bsdf_place needs `mesh` */
    bool has_tangents;         /* bump maps: struct bsdf_place needs dp/du and dp/dv */
    /* Diffuse, perhaps the same from both sides: needs no bsdf_point. */
    bool is_plain, is_twosided;
    uint32_t texture; /* of its colour, here and for `tinted`; SCENE_NONE: the same everywhere */
    struct vec3 reflectance;
    /* [2], seen from the front and from behind; NULL: not the same everywhere. */
    const struct bsdf_point *ready;
    /* The same of rough plastics and conductors that only vary in the colour of what is below the
     * coat, or of the metal; colours are to be looked up. NULL: not so. */
    const struct bsdf_point *tinted;
};

/* Where a material is asked for; vectors in the shading frame. */
struct bsdf_place {
    float u, v;               /* texture coordinates */
    struct vec3 wi;           /* to the viewer */
    struct vec3 n;            /* geometric normal; it and what follows for has_tangents only */
    struct vec3 dp_du, dp_dv; /* change of position with u and v, scene units */
    struct mesh_place mesh;   /* for has_attributes only */
};

/* Principled: weights and colours of its lobes at a point. */
struct principled {
    float anisotropic, roughness, metallic, spec_trans, spec_tint, sheen, sheen_tint, flatness;
    float clearcoat, clearcoat_gloss;
    float diffuse_rate, specular_rate, clearcoat_rate;
};

struct bsdf_point {
    enum bsdf_kind kind; /* never BSDF_TWOSIDED, BSDF_MASK, BSDF_BUMPMAP or BSDF_NORMALMAP */
    uint32_t lobes;
    bool is_mirrored; /* two-sided, seen from behind: z of wi and wo changes sign */
    bool is_turned;   /* bump or normal map: `turn` applies, mirroring included */
    bool is_nonlinear, is_approximate;
    bool has_specular_reflectance; /* the scene gives one */
    float opacity;                 /* 1 unless masked */
    struct vec3 reflectance;
    struct vec3 specular_reflectance, specular_transmittance;
    struct vec3 eta_rgb, k_rgb; /* conductors */
    struct microfacet facets;   /* rough ones */
    float eta;                  /* dielectrics, plastic, principled */
    float specular_weight, internal_reflection;
    struct coat_at coat; /* rough plastic */
    float exponent;      /* phong */
    struct principled principled;

    /* Bump and normal maps: axes of the material's own frame in the shading frame. */
    struct frame turn;
    float shadow; /* squared roughness of the terminator's softening, of the innermost; 0: none */

    /* Blend: children are looked up when they are asked for. */
    const struct material *materials;
    const struct texture_set *textures;
    uint32_t child[2];
    float weight; /* of the second */
    struct bsdf_place place;
};

/* Whether it is Lambert's law in the shading frame, perhaps mirrored. */
static inline bool bsdf_is_diffuse(const struct bsdf_point *p)
{
    return p->kind == BSDF_DIFFUSE && p->opacity == 1.0f && !p->is_turned;
}

struct bsdf_sample {
    struct vec3 wo;
    struct vec3 weight; /* value / pdf; zero: nothing was sampled */
    float pdf;          /* of wo; of choosing the lobe for delta lobes */
    float eta;          /* relative index of the medium entered; 1 for reflection */
    enum lobe lobe;
};

/* Fills materials [n_bsdfs] from a state's bsdfs. `coats` has room for every rough plastic; what is
 * in it already is used again. `ready` [2 * n_bsdfs] is where they keep their points. */
void material_init(struct material *materials, const struct bsdf *bsdfs, uint32_t n_bsdfs,
                   const struct texture_set *textures, struct coat *coats,
                   struct bsdf_point *ready);

/* How many of the bsdfs are rough plastic. */
uint32_t material_count_coats(const struct bsdf *bsdfs, uint32_t n_bsdfs);

/* The material at a point. */
void bsdf_point_init(struct bsdf_point *p, const struct material *materials, uint32_t index,
                     const struct texture_set *textures, const struct bsdf_place *at);

/* Value (with cosine) and density of the smooth lobes. */
void bsdf_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
               float *pdf);

/* u1 chooses the lobe, (u2, v2) the direction. */
struct bsdf_sample bsdf_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2,
                               float v2);

/* What the first-hit buffers show; the normal is in the shading frame. */
struct vec3 bsdf_albedo(const struct bsdf_point *p);
float bsdf_roughness(const struct bsdf_point *p);
struct vec3 bsdf_normal(const struct bsdf_point *p);

/* One family each, behind bsdf_eval() and bsdf_sample(): wi and wo are already mirrored, opacity is
 * dealt with, *value, *pdf and the sample come zeroed. */
void diffuse_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
                  float *pdf);
void diffuse_sample(const struct bsdf_point *p, struct vec3 wi, float u2, float v2,
                    struct bsdf_sample *s);
void conductor_sample(const struct bsdf_point *p, struct vec3 wi, struct bsdf_sample *s);
void rough_conductor_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo,
                          struct vec3 *value, float *pdf);
void rough_conductor_sample(const struct bsdf_point *p, struct vec3 wi, float u2, float v2,
                            struct bsdf_sample *s);
void dielectric_sample(const struct bsdf_point *p, struct vec3 wi, float u1, struct bsdf_sample *s);
void rough_dielectric_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo,
                           struct vec3 *value, float *pdf);
void rough_dielectric_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2,
                             float v2, struct bsdf_sample *s);
void plastic_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
                  float *pdf);
void plastic_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2, float v2,
                    struct bsdf_sample *s);
void rough_plastic_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo,
                        struct vec3 *value, float *pdf);
void rough_plastic_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2, float v2,
                          struct bsdf_sample *s);
void thin_dielectric_sample(const struct bsdf_point *p, struct vec3 wi, float u1,
                            struct bsdf_sample *s);
void rough_diffuse_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo,
                        struct vec3 *value, float *pdf);
void rough_diffuse_sample(const struct bsdf_point *p, struct vec3 wi, float u2, float v2,
                          struct bsdf_sample *s);
void phong_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
                float *pdf);
void phong_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2, float v2,
                  struct bsdf_sample *s);
void principled_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
                     float *pdf);
void principled_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2, float v2,
                       struct bsdf_sample *s);
void blend_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
                float *pdf);
void blend_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2, float v2,
                  struct bsdf_sample *s);

#endif
