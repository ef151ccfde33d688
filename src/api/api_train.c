/* SPDX-License-Identifier: Apache-2.0 */
/* Public training. */
#include "api/handles.h"

#include <string.h>

#include "base/mem.h"
#include "train/model.h"
#include "train/options.h"
#include "train/trainer.h"

struct lmn_trainer {
    lmn_context *context;
    const lmn_scene *scene;
    struct trainer *trainer;
};

void lmn_train_options_init(lmn_train_options *options)
{
    options_init(options);
    options->struct_size = sizeof *options;
}

void lmn_train_options_init_method(lmn_train_options *options, uint32_t method)
{
    options_init_method(options, method);
    options->struct_size = sizeof *options;
}

/* With the defaults for what a smaller struct of an older caller lacks. */
static lmn_status read_options(const lmn_train_options *options, lmn_train_options *out,
                               struct error *err)
{
    lmn_status status = LMN_OK;
    lmn_train_options_init(out);
    if (!options) return LMN_OK;
    lmn_train_options full = *out;
    TRY(options_copy("lmn_train_options", options, &full, sizeof full, err));
    const size_t given = options->struct_size;
    memcpy(out, &full, given < sizeof full ? given : sizeof full);
    out->struct_size = sizeof *out;
done:
    return status;
}

lmn_status lmn_train_options_set(lmn_context *context, lmn_train_options *options,
                                 const char *assignment)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    lmn_train_options o;
    TRY(read_options(options, &o, err));
    TRY(options_assign(&o, assignment, err));
    o.struct_size = options->struct_size;
    memcpy(options, &o, o.struct_size < sizeof o ? o.struct_size : sizeof o);
done:
    return status;
}

lmn_status lmn_train_options_json(lmn_context *context, const lmn_train_options *options,
                                  const char **json)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    lmn_train_options o;
    struct json j = {.out = &context->json};
    *json = NULL;
    TRY(read_options(options, &o, err));
    TRY(options_check(&o, err));
    str_release(&context->json);
    json_begin_object(&j, NULL);
    options_write(&o, &j);
    json_end(&j);
    if (context->json.failed) status = fail_memory(err, "the training options");
    if (status == LMN_OK) *json = context->json.text;
done:
    return status;
}

static lmn_trainer *trainer_handle(lmn_context *context, const lmn_scene *scene)
{
    lmn_trainer *t = mem_new(1, sizeof *t);
    if (t) {
        t->context = context;
        t->scene = scene;
    }
    return t;
}

lmn_status lmn_trainer_new(lmn_context *context, const lmn_scene *scene,
                           const lmn_train_options *options, lmn_trainer **out)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    lmn_train_options o;
    struct workplace place;
    lmn_trainer *t = NULL;
    *out = NULL;
    TRY(read_options(options, &o, err));
    TRY(scene_workplace(context, scene, &place, err));
    t = trainer_handle(context, scene);
    if (!t) {
        status = fail_memory(err, "the trainer");
        goto done;
    }
    TRY(trainer_new(&place, &o, &t->trainer, err));
    *out = t;
    t = NULL;
done:
    lmn_trainer_free(t);
    return status;
}

lmn_status lmn_trainer_resume(lmn_context *context, const lmn_scene *scene, const char *path,
                              int force, lmn_trainer **out)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    struct workplace place;
    lmn_trainer *t = NULL;
    *out = NULL;
    TRY(scene_workplace(context, scene, &place, err));
    t = trainer_handle(context, scene);
    if (!t) {
        status = fail_memory(err, "the trainer");
        goto done;
    }
    TRY(trainer_resume(&place, path, force != 0, &t->trainer, err));
    *out = t;
    t = NULL;
done:
    lmn_trainer_free(t);
    return status;
}

lmn_status lmn_trainer_start_from(lmn_trainer *trainer, const char *path, const char **report)
{
    return trainer_start_from(trainer->trainer, path, report, context_begin(trainer->context));
}

void lmn_trainer_free(lmn_trainer *trainer)
{
    if (!trainer) return;
    trainer_free(trainer->trainer);
    mem_free(trainer);
}

lmn_status lmn_trainer_step(lmn_trainer *trainer, lmn_train_stats *stats)
{
    return trainer_step(trainer->trainer, stats, context_begin(trainer->context));
}

void lmn_trainer_get_stats(const lmn_trainer *trainer, lmn_train_stats *out)
{
    trainer_get_stats(trainer->trainer, out);
}

void lmn_trainer_get_options(const lmn_trainer *trainer, lmn_train_options *out)
{
    *out = *trainer_options(trainer->trainer);
    out->struct_size = sizeof *out;
}

uint32_t lmn_trainer_get_states(const lmn_trainer *trainer, uint32_t most, double *values)
{
    const struct scene *s = trainer->scene->scene;
    float *u = trainer->scene->cache->u;
    for (uint32_t k = 0; k < most; k++) {
        if (!trainer_state(trainer->trainer, k, u)) return k;
        for (uint32_t i = 0; i < s->n_variables; i++)
            values[(size_t)k * s->n_variables + i] = variable_from_unit(&s->variables[i], u[i]);
    }
    return most;
}

lmn_status lmn_trainer_save(lmn_trainer *trainer, const char *path)
{
    return trainer_save(trainer->trainer, path, context_begin(trainer->context));
}

lmn_status lmn_trainer_eval(lmn_trainer *trainer, uint32_t n, uint32_t resolution, uint32_t spp,
                            uint64_t seed, lmn_metrics *out)
{
    lmn_context *context = trainer->context;
    const lmn_eval_options options = {
        .struct_size = sizeof options, .n = n, .resolution = resolution, .spp = spp, .seed = seed};
    return trainer_eval(trainer->trainer, &options, context->progress, context->progress_user, out,
                        context_begin(context));
}

lmn_status lmn_trainer_render(lmn_trainer *trainer, const double *values,
                              const lmn_render_options *options, lmn_image **out, double *render_s)
{
    lmn_status status = LMN_OK;
    lmn_context *context = trainer->context;
    struct error *err = context_begin(context);
    struct model_render_options render;
    struct image image = {0};
    const float *u = trainer->scene->cache->u;
    *out = NULL;
    TRY(scene_render_options(trainer->scene, values, options, &render, err));
    TRY(trainer_render(trainer->trainer, u, &render, &image, render_s, context->progress,
                       context->progress_user, err));
    TRY(describe_image(&image, trainer->scene, u, render.pose, render.seed,
                       render.buffer_spp ? render.buffer_spp : 16, err));
    TRY(image_handle(&image, out, err));
done:
    image_release(&image);
    return status;
}

const char *lmn_trainer_metrics_line(lmn_trainer *trainer)
{
    return trainer_metrics_line(trainer->trainer);
}
