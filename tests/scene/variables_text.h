/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TESTS_SCENE_VARIABLES_TEXT_H
#define TESTS_SCENE_VARIABLES_TEXT_H

#include "scene_text.h"

/* A scene with one of everything that variables can drive. */
#define TEXT_STAGE                                                                               \
    "<sensor type='perspective' id='cam'><float name='fov' value='40'/>"                         \
    "<transform name='to_world'><lookat origin='0,1,5' target='0,1,0' up='0,1,0'/></transform>"  \
    "</sensor>"                                                                                  \
    "<texture type='checkerboard' id='tiles'><rgb name='color0' value='.1 .2 .3'/></texture>"    \
    "<texture type='checkerboard' id='stripes'/>"                                                \
    "<bsdf type='diffuse' id='wall'><rgb name='reflectance' value='.1 .2 .3'/></bsdf>"           \
    "<bsdf type='diffuse' id='floor_mat'><ref name='reflectance' id='tiles'/></bsdf>"            \
    "<bsdf type='twosided' id='metal'><bsdf type='roughconductor'>"                              \
    "<float name='alpha' value='0.2'/></bsdf></bsdf>"                                            \
    "<bsdf type='roughdielectric' id='glass'><float name='alpha' value='0.1'/></bsdf>"           \
    "<shape type='rectangle' id='floor'><ref id='floor_mat'/></shape>"                           \
    "<shape type='cube' id='box'><transform name='to_world'><translate x='3'/></transform>"      \
    "<ref id='wall'/></shape>"                                                                   \
    "<shape type='sphere' id='ball'><point name='center' x='1' y='2' z='3'/><ref id='glass'/>"   \
    "</shape>"                                                                                   \
    "<shape type='shapegroup' id='group'><shape type='cube' id='part'><ref id='metal'/></shape>" \
    "<shape type='disk' id='lid'/></shape>"                                                      \
    "<shape type='instance' id='one'><ref id='group'/><transform name='to_world'>"               \
    "<scale value='2'/><translate x='-3'/></transform></shape>"                                  \
    "<shape type='rectangle' id='lamp'><emitter type='area' id='light'>"                         \
    "<rgb name='radiance' value='4 5 6'/></emitter></shape>"                                     \
    "<emitter type='envmap' id='sky'><string name='filename' value='sky.pfm'/></emitter>"        \
    "<emitter type='point' id='spark'><rgb name='intensity' value='1 1 1'/></emitter>"

/* Loads the stage with `variables`, which stand between the brackets of the list and begin at
 * line 2, column 1 of s.variables.json. */
static inline lmn_status text_load_variables(const char *variables, struct scene **out,
                                             struct error *err)
{
    static const char pfm[] =
        "PF\n2 1\n-1.0\n\0\0\200?\0\0\200?\0\0\200?\0\0\200?\0\0\200?\0\0\200?";
    size_t n = strlen(variables) + 64;
    char *text = malloc(n);
    if (!text) abort();
    snprintf(text, n, "{\"variables\": [\n%s\n]}", variables);
    text_write("sky.pfm", pfm, sizeof pfm - 1);
    text_write_string("s.xml", "<scene version='3.0.0'>" TEXT_STAGE "</scene>");
    text_write_string("s.variables.json", text);
    free(text);
    return text_load_file("s.xml", NULL, out, err);
}

static inline struct scene *text_variables(const char *variables)
{
    struct scene *s;
    struct error err;
    if (text_load_variables(variables, &s, &err) != LMN_OK) fail_msg("%s", err.text);
    return s;
}

static inline const struct param *text_param(const struct scene *s, const char *path)
{
    for (uint32_t i = 0; i < s->n_params; i++)
        if (strcmp(s->params[i].path, path) == 0) return &s->params[i];
    fail_msg("no parameter %s", path);
    return NULL;
}

/* The value at a path of a state. */
static inline const float *text_value(const struct scene *s, struct scene_state *state,
                                      const char *path)
{
    return param_in(text_param(s, path), state);
}

static inline const struct variable *text_variable(const struct scene *s, const char *name)
{
    for (uint32_t i = 0; i < s->n_variables; i++)
        if (strcmp(s->variables[i].name, name) == 0) return &s->variables[i];
    fail_msg("no variable %s", name);
    return NULL;
}

static inline struct scene_state text_state(const struct scene *s)
{
    struct scene_state state;
    struct error err;
    if (scene_state_init(s, &state, &err) != LMN_OK) fail_msg("%s", err.text);
    return state;
}

/* Every byte that variables can reach is equal. */
static inline bool text_is_equal(const struct scene *s, const struct scene_state *a,
                                 const struct scene_state *b)
{
    for (uint32_t i = 0; i < s->n_instances; i++) {
        if (memcmp(&a->instances[i].to_world, &b->instances[i].to_world,
                   sizeof a->instances[i].to_world) != 0 ||
            a->instances[i].is_visible != b->instances[i].is_visible)
            return false;
    }
    for (uint32_t i = 0; i < s->n_textures; i++) {
        const struct texture *p = &a->textures[i], *q = &b->textures[i];
        if (memcmp(&p->value, &q->value, sizeof p->value) != 0 ||
            memcmp(&p->color0, &q->color0, sizeof p->color0) != 0 ||
            memcmp(&p->color1, &q->color1, sizeof p->color1) != 0)
            return false;
    }
    for (uint32_t i = 0; i < s->n_bsdfs; i++) {
        if (a->bsdfs[i].reflectance != b->bsdfs[i].reflectance ||
            a->bsdfs[i].eta != b->bsdfs[i].eta)
            return false;
    }
    for (uint32_t i = 0; i < s->n_emitters; i++) {
        if (a->emitters[i].scale != b->emitters[i].scale ||
            memcmp(&a->emitters[i].to_world, &b->emitters[i].to_world,
                   sizeof a->emitters[i].to_world) != 0)
            return false;
    }
    return memcmp(a->shape_bsdfs, b->shape_bsdfs, s->n_shapes * sizeof *a->shape_bsdfs) == 0 &&
           memcmp(&a->sensor.to_world, &b->sensor.to_world, sizeof a->sensor.to_world) == 0 &&
           a->sensor.fov == b->sensor.fov;
}

#endif
