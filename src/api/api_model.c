/* SPDX-License-Identifier: Apache-2.0 */
/* Public models. */
#include "api/handles.h"

#include "base/mem.h"
#include "train/checkpoint.h"
#include "train/model.h"

struct lmn_model {
    struct model *model;
    const lmn_scene *scene;
};

lmn_status scene_workplace(lmn_context *context, const lmn_scene *scene, struct workplace *out,
                           struct error *err)
{
    const lmn_status status = scene_world(scene, err);
    if (status != LMN_OK) return status;
    *out = (struct workplace){.scene = scene->scene,
                              .world = scene->cache->world,
                              .pool = context->pool,
                              .cpu = context->cpu,
                              .scene_path = scene->path,
                              .variables_path = scene->variables_path,
                              .defines = (const char *const *)scene->defines,
                              .n_defines = scene->n_defines};
    return LMN_OK;
}

lmn_status lmn_model_load(lmn_context *context, const lmn_scene *scene, const char *path, int force,
                          lmn_model **out)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    struct workplace place;
    lmn_model *m = NULL;
    *out = NULL;
    TRY(scene_workplace(context, scene, &place, err));
    m = mem_new(1, sizeof *m);
    if (!m) {
        status = fail_memory(err, "the model");
        goto done;
    }
    m->scene = scene;
    TRY(model_load(&place, path, force != 0, &m->model, err));
    *out = m;
    m = NULL;
done:
    lmn_model_free(m);
    return status;
}

void lmn_model_free(lmn_model *model)
{
    if (!model) return;
    model_free(model->model);
    mem_free(model);
}

lmn_status lmn_model_read_info(lmn_context *context, const char *path, lmn_model_info *out)
{
    *out = (lmn_model_info){0};
    return checkpoint_read_info(path, out, context_begin(context));
}

void lmn_model_info_free(lmn_model_info *info)
{
    if (info) checkpoint_info_release(info);
}

lmn_status scene_render_options(const lmn_scene *scene, const double *values,
                                const lmn_render_options *options, struct model_render_options *out,
                                struct error *err)
{
    lmn_status status = LMN_OK;
    lmn_render_options o;
    TRY(options_copy("lmn_render_options", options, &o, sizeof o, err));
    *out = (struct model_render_options){.buffer_spp = o.buffer_spp,
                                         .seed = o.seed,
                                         .first_sample = o.first_sample,
                                         .with_buffers = o.buffers != 0};
    if (o.camera) {
        TRY(scene_pose(scene, o.camera, &scene->cache->pose, err));
        out->pose = &scene->cache->pose;
    }
    TRY(scene_window(scene, (uint32_t[2]){o.width, o.height},
                     (uint32_t[4]){o.crop_x, o.crop_y, o.crop_width, o.crop_height}, &out->window,
                     err));
    TRY(scene_units(scene, values, scene->cache->u, err));
done:
    return status;
}

lmn_status lmn_model_render(lmn_context *context, const lmn_model *model, const double *values,
                            const lmn_render_options *options, lmn_image **out, double *render_s)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    struct model_render_options render;
    struct image image = {0};
    const float *u = model->scene->cache->u;
    *out = NULL;
    TRY(scene_render_options(model->scene, values, options, &render, err));
    TRY(model_render(model->model, u, &render, &image, render_s, context->progress,
                     context->progress_user, err));
    TRY(describe_image(&image, model->scene, u, render.pose, render.seed,
                       render.buffer_spp ? render.buffer_spp : 16, err));
    TRY(image_handle(&image, out, err));
done:
    image_release(&image);
    return status;
}

void lmn_model_get_times(const lmn_model *model, double *buffers_s, double *network_s)
{
    model_times(model->model, buffers_s, network_s);
}

lmn_status lmn_model_eval(lmn_context *context, const lmn_model *model,
                          const lmn_eval_options *options, lmn_eval_result *out, lmn_metrics *each,
                          lmn_image **sheet)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    lmn_eval_options o;
    struct image image = {0};
    if (sheet) *sheet = NULL;
    TRY(options_copy("lmn_eval_options", options, &o, sizeof o, err));
    TRY(model_eval(model->model, &o, context->progress, context->progress_user, out, each,
                   sheet ? &image : NULL, err));
    if (sheet) TRY(image_handle(&image, sheet, err));
done:
    image_release(&image);
    return status;
}
