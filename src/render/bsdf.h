/* SPDX-License-Identifier: Apache-2.0 */
#ifndef RENDER_BSDF_H
#define RENDER_BSDF_H

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
    float specular_weight;     /* plastic: preference for the coat when sampling */
    float internal_reflection; /* plastic: diffuse Fresnel reflectance from inside */
    bool has_uv;               /* some texture varies */
    bool has_direction;        /* anisotropic: the shading frame must follow dp/du */
    /* Diffuse of one colour, perhaps the same from both sides: needs no bsdf_point. */
    bool is_plain, is_twosided;
    struct vec3 reflectance;
};

struct bsdf_point {
    enum bsdf_kind kind; /* never BSDF_TWOSIDED or BSDF_MASK */
    uint32_t lobes;
    bool is_mirrored; /* two-sided, seen from behind: z of wi and wo changes sign */
    bool is_nonlinear;
    bool has_specular_reflectance; /* the scene gives one */
    float opacity;                 /* 1 unless masked */
    struct vec3 reflectance;
    struct vec3 specular_reflectance, specular_transmittance;
    struct vec3 eta_rgb, k_rgb; /* conductors */
    struct microfacet facets;   /* rough ones */
    float eta;                  /* dielectrics, plastic */
    float specular_weight, internal_reflection;
};

struct bsdf_sample {
    struct vec3 wo;
    struct vec3 weight; /* value / pdf; zero: nothing was sampled */
    float pdf;          /* of wo; of choosing the lobe for delta lobes */
    float eta;          /* relative index of the medium entered; 1 for reflection */
    enum lobe lobe;
};

/* Fills materials [n_bsdfs] from a state's bsdfs. */
void material_init(struct material *materials, const struct bsdf *bsdfs, uint32_t n_bsdfs,
                   const struct texture_set *textures);

/* The material at a point with texture coordinates (u, v) seen from the side of wi_z. */
void bsdf_point_init(struct bsdf_point *p, const struct material *materials, uint32_t index,
                     const struct texture_set *textures, float u, float v, float wi_z);

/* Value (with cosine) and density of the smooth lobes. */
void bsdf_eval(const struct bsdf_point *p, struct vec3 wi, struct vec3 wo, struct vec3 *value,
               float *pdf);

/* u1 chooses the lobe, (u2, v2) the direction. */
struct bsdf_sample bsdf_sample(const struct bsdf_point *p, struct vec3 wi, float u1, float u2,
                               float v2);

/* What the first-hit buffers show. */
struct vec3 bsdf_albedo(const struct bsdf_point *p);
float bsdf_roughness(const struct bsdf_point *p);

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

#endif
