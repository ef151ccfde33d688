/* SPDX-License-Identifier: Apache-2.0 */
/* trainer_start_from(): the weights of another training, taken over by what they stand for. */
#include "train/trainer_inside.h"

#include <string.h>

#include "base/mem.h"
#include "train/model_file.h"

/* A network on its way from one meaning to another. */
struct move {
    const struct meaning *from_meaning, *to_meaning;
    const struct field_config *from_config, *to_config;
    const float *from;
    float *to;
    struct layout_tensor from_first, to_first; /* the first layer's weights */
    struct layout_tensor from_last, to_last;   /* the last layer's */
};

static const struct meaning_part *source_of(const struct move *m, const struct meaning_part *part)
{
    return meaning_find(m->from_meaning, m->to_meaning, part);
}

/* How many columns of the first layer read a part. */
static uint32_t n_columns(const struct meaning_part *part, const struct field_config *c)
{
    if (part->kind == MEANING_LIGHT) return 0;
    return part->kind == MEANING_GRID ? c->grid.n_levels * GRID_FEATURES : part->n;
}

/* Of a part of `meaning`: the first of its columns. */
static uint32_t column_of(const struct meaning *meaning, const struct meaning_part *part,
                          const struct field_config *c)
{
    uint32_t at = 0;
    for (const struct meaning_part *p = meaning->parts; p < part; p++) at += n_columns(p, c);
    return at;
}

static void move_table(const struct move *m, const struct meaning_part *to,
                       const struct meaning_part *from)
{
    struct layout_tensor source, target;
    layout_field_get(m->from_config, (uint32_t)(from - m->from_meaning->parts), &source);
    layout_field_get(m->to_config, (uint32_t)(to - m->to_meaning->parts), &target);
    memcpy(m->to + target.at, m->from + source.at, target.size * sizeof(float));
}

static void move_columns(const struct move *m, const struct meaning_part *to,
                         const struct meaning_part *from)
{
    const uint32_t at = column_of(m->to_meaning, to, m->to_config);
    const uint32_t from_at = column_of(m->from_meaning, from, m->from_config);
    const size_t size = n_columns(to, m->to_config) * sizeof(float);
    for (size_t row = 0; row < m->to_first.n_out; row++)
        memcpy(m->to + m->to_first.at + row * m->to_first.n_in + at,
               m->from + m->from_first.at + row * m->from_first.n_in + from_at, size);
}

/* `n` outputs from `at` on: rows of the last layer's weights, and biases behind them. */
static void move_outputs(const struct move *m, size_t at, size_t from_at, size_t n)
{
    const struct layout_tensor *to = &m->to_last, *from = &m->from_last;
    memcpy(m->to + to->at + at * to->n_in, m->from + from->at + from_at * from->n_in,
           n * to->n_in * sizeof(float));
    memcpy(m->to + to->at + to->size + at, m->from + from->at + from->size + from_at,
           n * sizeof(float));
}

/* From the first layer's biases to the last layer, which have the same shape on both sides, and
 * what is expected. */
static void move_layers(const struct move *m)
{
    struct layout_tensor source, target;
    layout_field_get(m->from_config, m->from_config->n_grids + 1, &source);
    layout_field_get(m->to_config, m->to_config->n_grids + 1, &target);
    memcpy(m->to + target.at, m->from + source.at, (m->to_last.at - target.at) * sizeof(float));
    move_outputs(m, m->to_last.n_out - 1, m->from_last.n_out - 1, 1);
}

/* Of a light of `meaning`: its first output. */
static size_t output_of(const struct meaning *meaning, const struct meaning_part *part)
{
    size_t at = 0;
    for (const struct meaning_part *p = meaning->parts; p < part; p++)
        if (p->kind == MEANING_LIGHT) at += p->n;
    return at;
}

static void move_all(const struct move *m, struct str *report)
{
    for (size_t i = 0; i < m->to_meaning->n_parts; i++) {
        const struct meaning_part *to = &m->to_meaning->parts[i], *from = source_of(m, to);
        str_add(report, from ? "taken over: " : "new: ");
        meaning_tell(to, report);
        str_add(report, "\n");
        if (!from) continue;
        if (to->kind == MEANING_GRID) move_table(m, to, from);
        if (to->kind == MEANING_LIGHT)
            move_outputs(m, output_of(m->to_meaning, to), output_of(m->from_meaning, from), to->n);
        else
            move_columns(m, to, from);
    }
    for (size_t i = 0; i < m->from_meaning->n_parts; i++) {
        const struct meaning_part *from = &m->from_meaning->parts[i];
        if (meaning_find(m->to_meaning, m->from_meaning, from)) continue;
        str_add(report, "dropped: ");
        meaning_tell(from, report);
        str_add(report, "\n");
    }
    move_layers(m);
    str_add(report, "taken over: %u layers of %u", m->to_config->depth, m->to_config->width);
}

lmn_status trainer_start_from(struct trainer *t, const char *path, const char **report,
                              struct error *err)
{
    lmn_status status = LMN_OK;
    struct model_file file = {0};
    struct meaning meaning = {0};
    struct move m = {0};
    float *from = NULL;
    if (!t->learner || t->step > 0) {
        status = fail(err, LMN_ERR_ARGUMENT,
                      "%s: only a new training by the improved method can start from a model",
                      path);
        goto done;
    }
    TRY(model_file_open(&file, path, err));
    if (file.options.method != LMN_METHOD_IMPROVED) {
        status = fail(err, LMN_ERR_ARGUMENT,
                      "%s: trained by the faithful method, whose network has no parts to take over",
                      path);
        goto done;
    }
    if (file.options.width != t->options.width || file.options.depth != t->options.depth) {
        status = fail(err, LMN_ERR_ARGUMENT,
                      "%s: its network has width %u and depth %u, not %u and %u", path,
                      file.options.width, file.options.depth, t->options.width, t->options.depth);
        goto done;
    }
    TRY(model_file_check_weights(&file, err));
    TRY(sight_describe(learner_network(t->learner).sight, &meaning, err));
    from = mem_new(model_file_n_weights(&file), sizeof *from);
    if (!from) {
        status = fail_memory(err, path);
        goto done;
    }
    TRY(model_file_read_weights(&file, from, err));
    m = (struct move){.from_meaning = &file.meaning,
                      .to_meaning = &meaning,
                      .from_config = &file.field,
                      .to_config = learner_field_config(t->learner),
                      .from = from,
                      .to = field_weights(learner_network(t->learner).field)};
    layout_field_get(m.from_config, m.from_config->n_grids, &m.from_first);
    layout_field_get(m.to_config, m.to_config->n_grids, &m.to_first);
    layout_field_get(m.from_config, m.from_config->n_grids + 2 * m.from_config->depth,
                     &m.from_last);
    layout_field_get(m.to_config, m.to_config->n_grids + 2 * m.to_config->depth, &m.to_last);
    str_release(&t->start_report);
    move_all(&m, &t->start_report);
    if (t->start_report.failed) {
        status = fail_memory(err, path);
        goto done;
    }
    learner_start(t->learner);
    trainer_identify(t);
    if (report) *report = t->start_report.text;
done:
    mem_free(from);
    meaning_release(&meaning);
    model_file_release(&file);
    return status;
}
