/* SPDX-License-Identifier: Apache-2.0 */
/* Public scenes: loading, and what they hold. */
#include "api/handles.h"

#include "base/mem.h"
#include "render/view.h"
#include "scene/params.h"

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
    if (!s || !s->cache) {
        status = fail_memory(err, "the scene");
        goto done;
    }
    s->cache->cpu = context->cpu;
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
    scene_free(scene->scene);
    for (uint32_t i = 0; i < scene->n_defines; i++) mem_free(scene->defines[i]);
    mem_free(scene->defines);
    mem_free(scene->path);
    mem_free(scene->variables_path);
    mem_free(scene->cache);
    mem_free(scene);
}

lmn_status scene_world(const lmn_scene *scene, struct error *err)
{
    if (scene->cache->world) return LMN_OK;
    return world_new(scene->scene, scene->cache->cpu, &scene->cache->world, err);
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
                            .orthographic = s->defaults.sensor.kind == SENSOR_ORTHOGRAPHIC,
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
                               .targets = v->targets ? v->targets : "",
                               .description = v->description ? v->description : ""};
    return LMN_OK;
}

lmn_status lmn_scene_get_parameter(const lmn_scene *scene, uint32_t index, lmn_parameter_info *out)
{
    if (index >= scene->scene->n_params) return LMN_ERR_ARGUMENT;
    const struct param *p = &scene->scene->params[index];
    *out = (lmn_parameter_info){
        .path = p->path, .type = param_type_name(p->type), .value = p->value ? p->value : ""};
    return LMN_OK;
}
