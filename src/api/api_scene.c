/* SPDX-License-Identifier: Apache-2.0 */
/* Public scenes: loading, what they hold, their parameters as text. */
#include "api/handles.h"

#include <string.h>

#include "base/mem.h"
#include "render/view.h"

/* Texts are made when asked for: a scene can have thousands of parameters. */
struct parameter_texts {
    struct arena arena;
    const char **values; /* [n_params], NULL: not asked yet; in the arena */
};

/* Keeps what a model file will say of its scene. */
static lmn_status keep_origin(lmn_scene *s, const char *path, const lmn_scene_options *o,
                              struct error *err)
{
    s->path = mem_strdup(path);
    s->variables_path = mem_strdup(o->variables_path ? o->variables_path : "");
    s->defines = mem_new(o->n_defines + 1u, sizeof *s->defines);
    if (!s->path || !s->variables_path || !s->defines) return fail_memory(err, "the scene");
    for (; s->n_defines < o->n_defines; s->n_defines++) {
        s->defines[s->n_defines] = mem_strdup(o->defines[s->n_defines]);
        if (!s->defines[s->n_defines]) return fail_memory(err, "the scene");
    }
    return LMN_OK;
}

lmn_status lmn_scene_load(lmn_context *context, const char *path, const lmn_scene_options *options,
                          lmn_scene **out)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    lmn_scene_options o;
    lmn_scene *s = NULL;
    *out = NULL;
    TRY(options_copy("lmn_scene_options", options, &o, sizeof o, err));
    const struct scene_load_options load = {.defines = o.defines,
                                            .n_defines = o.n_defines,
                                            .variables_path = o.variables_path,
                                            .note = context->note,
                                            .note_user = context->note_user};
    s = mem_new(1, sizeof *s);
    if (s) s->cache = mem_new(1, sizeof *s->cache);
    if (s) s->texts = mem_new(1, sizeof *s->texts);
    if (!s || !s->cache || !s->texts) {
        status = fail_memory(err, "the scene");
        goto done;
    }
    TRY(keep_origin(s, path, &o, err));
    TRY(scene_load(path, &load, &s->scene, err));
    s->cache->u = mem_new(s->scene->n_variables + 1u, sizeof *s->cache->u);
    if (!s->cache->u) {
        status = fail_memory(err, "the scene");
        goto done;
    }
    *out = s;
    s = NULL;
done:
    lmn_scene_free(s);
    return status;
}

void lmn_scene_free(lmn_scene *scene)
{
    if (!scene) return;
    if (scene->cache) {
        view_free(scene->cache->view);
        world_free(scene->cache->world);
        mem_free(scene->cache->u);
    }
    if (scene->texts) arena_release(&scene->texts->arena);
    scene_free(scene->scene);
    for (uint32_t i = 0; i < scene->n_defines; i++) mem_free(scene->defines[i]);
    mem_free(scene->defines);
    mem_free(scene->path);
    mem_free(scene->variables_path);
    mem_free(scene->cache);
    mem_free(scene->texts);
    mem_free(scene);
}

lmn_status scene_world(const lmn_scene *scene, struct error *err)
{
    if (scene->cache->world) return LMN_OK;
    return world_new(scene->scene, &scene->cache->world, err);
}

lmn_status scene_view(const lmn_scene *scene, struct error *err)
{
    lmn_status status = LMN_OK;
    struct scene_cache *c = scene->cache;
    TRY(scene_world(scene, err));
    if (!c->view) TRY(view_new(c->world, &c->view, err));
done:
    return status;
}

void lmn_scene_get_info(const lmn_scene *scene, lmn_scene_info *out)
{
    const struct scene *s = scene->scene;
    *out = (lmn_scene_info){.path = scene->path,
                            .n_variables = s->n_variables,
                            .n_parameters = s->n_params,
                            .n_shapes = s->n_shapes,
                            .n_instances = s->n_instances,
                            .n_bsdfs = s->n_bsdfs,
                            .n_textures = s->n_textures,
                            .n_emitters = s->n_emitters,
                            .width = s->settings.width,
                            .height = s->settings.height,
                            .spp = s->settings.spp,
                            .max_depth = s->settings.max_depth,
                            .rr_depth = s->settings.rr_depth,
                            .bounds_min = {s->bounds.min.x, s->bounds.min.y, s->bounds.min.z},
                            .bounds_max = {s->bounds.max.x, s->bounds.max.y, s->bounds.max.z},
                            .hash = s->hash};
    for (uint32_t i = 0; i < s->n_meshes; i++) out->n_triangles += s->meshes[i].n_triangles;
}

lmn_status lmn_scene_get_variable(const lmn_scene *scene, uint32_t index, lmn_variable_info *out)
{
    if (index >= scene->scene->n_variables) return LMN_ERR_ARGUMENT;
    const struct variable *v = &scene->scene->variables[index];
    *out = (lmn_variable_info){.name = v->name,
                               .group = v->group,
                               .kind = v->kind,
                               .unit = v->unit ? v->unit : "",
                               .min = v->min,
                               .max = v->max,
                               .value = v->value,
                               .n_choices = v->n_choices,
                               .choices = v->choices,
                               .targets = v->targets ? v->targets : ""};
    return LMN_OK;
}

static const char *type_name(enum param_type type)
{
    switch (type) {
    case PARAM_FLOAT:
        return "float";
    case PARAM_RGB:
        return "rgb";
    case PARAM_TRANSFORM:
        return "transform";
    case PARAM_TEXTURE:
        return "texture";
    case PARAM_BSDF:
        return "bsdf";
    case PARAM_BOOL:
        return "bool";
    }
    return "";
}

static void write_texture(struct str *s, const struct scene *scene, uint32_t index)
{
    if (index >= scene->n_textures) {
        str_add(s, "none");
        return;
    }
    const struct texture *t = &scene->defaults.textures[index];
    switch (t->kind) {
    case TEXTURE_CONSTANT:
        str_add(s, "%g %g %g", t->value.x, t->value.y, t->value.z);
        break;
    case TEXTURE_BITMAP: {
        const struct bitmap *b = &scene->bitmaps[t->bitmap];
        str_add(s, "bitmap %ux%u", b->width, b->height);
        break;
    }
    case TEXTURE_CHECKERBOARD:
        str_add(s, "checkerboard (%g %g %g) (%g %g %g)", t->color0.x, t->color0.y, t->color0.z,
                t->color1.x, t->color1.y, t->color1.z);
        break;
    }
}

static void write_value(struct str *s, const struct scene *scene, const struct param *p)
{
    /* param_in() gives a writable place; here it is only read. */
    struct scene_state state = scene->defaults;
    const void *place = param_in(p, &state);
    switch (p->type) {
    case PARAM_FLOAT:
        str_add(s, "%g", *(const float *)place);
        break;
    case PARAM_BOOL:
        str_add(s, *(const bool *)place ? "true" : "false");
        break;
    case PARAM_BSDF:
        str_add(s, "%u", *(const uint32_t *)place);
        break;
    case PARAM_RGB: {
        const float *c = place;
        str_add(s, "%g %g %g", c[0], c[1], c[2]);
        break;
    }
    case PARAM_TRANSFORM: {
        const struct transform *t = place;
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 4; c++) str_add(s, "%s%g", r + c ? " " : "", t->m[r][c]);
        break;
    }
    case PARAM_TEXTURE:
        write_texture(s, scene, p->array == STATE_TEXTURES ? p->index : *(const uint32_t *)place);
        break;
    }
}

lmn_status lmn_scene_get_parameter(const lmn_scene *scene, uint32_t index, lmn_parameter_info *out)
{
    const struct scene *s = scene->scene;
    struct parameter_texts *t = scene->texts;
    if (index >= s->n_params) return LMN_ERR_ARGUMENT;
    if (!t->values) t->values = arena_new(&t->arena, s->n_params, sizeof *t->values);
    if (!t->values) return LMN_ERR_MEMORY;
    if (!t->values[index]) {
        struct str text = {0};
        write_value(&text, s, &s->params[index]);
        if (!text.failed && text.text) t->values[index] = arena_strdup(&t->arena, text.text);
        str_release(&text);
    }
    if (!t->values[index]) return LMN_ERR_MEMORY;
    *out = (lmn_parameter_info){.path = s->params[index].path,
                                .type = type_name(s->params[index].type),
                                .value = t->values[index]};
    return LMN_OK;
}
