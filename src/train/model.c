/* SPDX-License-Identifier: Apache-2.0 */
#include "train/model.h"

#include "base/mem.h"
#include "train/evaluate.h"
#include "train/learner.h"
#include "train/model_file.h"
#include "train/painter.h"
#include "train/tracing.h"

struct model {
    struct workplace place;
    lmn_train_options options;
    struct generator *generator; /* one of the networks; the other is NULL */
    struct field *field;
    struct sight sight; /* of the field */
    struct painter painter;
    bool has_painter;
};

static lmn_status load_generator(struct model *m, const struct model_file *file, struct error *err)
{
    lmn_status status = LMN_OK;
    struct generator_config network = model_file_network(file); /* patch_size 0: no training */
    TRY(generator_new(&network, m->place.pool, m->place.cpu, &m->generator, err));
    TRY(model_file_read_weights(file, generator_weights(m->generator), err));
    generator_weights_changed(m->generator);
done:
    return status;
}

static lmn_status load_field(struct model *m, const struct model_file *file, struct error *err)
{
    lmn_status status = LMN_OK;
    TRY(sight_init(&m->sight, m->place.scene, m->options.without, err));
    m->sight.cpu = m->place.cpu;
    if (m->options.has_max_depth) m->sight.max_depth = m->options.max_depth;
    const struct field_config want = sight_field(&m->sight);
    TRY(model_file_check_field(file, &want, err));
    TRY(field_new(&file->field, m->place.pool, m->place.cpu, &m->field, err));
    TRY(model_file_read_weights(file, field_weights(m->field), err));
    field_weights_changed(m->field);
done:
    return status;
}

lmn_status model_load(const struct workplace *place, const char *path, bool force,
                      struct model **out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct model_file file = {0};
    struct model *m = mem_new(1, sizeof *m);
    if (!m) {
        status = fail_memory(err, path);
        goto done;
    }
    m->place = *place;
    TRY(model_file_open(&file, path, err));
    TRY(model_file_check_scene(&file, place->scene, force, err));
    TRY(model_file_check_weights(&file, err));
    m->options = file.options;
    if (m->options.method == LMN_METHOD_IMPROVED)
        TRY(load_field(m, &file, err));
    else
        TRY(load_generator(m, &file, err));
    const struct painter_network network = {m->generator, m->field, &m->sight};
    TRY(painter_init(&m->painter, &m->place, &network, err));
    m->has_painter = true;
    *out = m;
    m = NULL;
done:
    model_free(m);
    model_file_release(&file);
    return status;
}

void model_free(struct model *m)
{
    if (!m) return;
    if (m->has_painter) painter_release(&m->painter);
    generator_free(m->generator);
    field_free(m->field);
    sight_release(&m->sight);
    mem_free(m);
}

const struct scene *model_scene(const struct model *m)
{
    return m->place.scene;
}

lmn_status model_render(struct model *m, const float *u, const struct model_render_options *options,
                        struct image *out, double *render_s, lmn_progress_fn *progress,
                        void *progress_user, struct error *err)
{
    return painter_render(&m->painter, u, options, out, render_s, progress, progress_user, err);
}

void model_times(const struct model *m, double *buffers_s, double *network_s)
{
    painter_times(&m->painter, buffers_s, network_s);
}

lmn_status model_eval(struct model *m, const lmn_eval_options *options, lmn_progress_fn *progress,
                      void *progress_user, lmn_eval_result *out, lmn_metrics *each,
                      struct image *sheet, struct error *err)
{
    lmn_status status = LMN_OK;
    struct test_set set = {0};
    struct trace_settings trace;
    trace_settings_init(&trace, m->place.scene);
    if (m->options.has_max_depth) trace.max_depth = m->options.max_depth;
    if (m->options.has_rr_depth) trace.rr_depth = m->options.rr_depth;
    TRY(test_set_init(&set, m->place.scene, options, &trace, err));
    TRY(tracing_has_photons(m->options.integrator, &m->place, &trace, &set.has_photons, err));
    TRY(test_set_trace(&set, &m->place, progress, progress_user, err));
    TRY(test_set_evaluate(&set, &m->painter, out, each, sheet, err));
done:
    test_set_release(&set);
    return status;
}
