/* SPDX-License-Identifier: Apache-2.0 */
#include "train/model_file.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "base/mem.h"
#include "base/str.h"
#include "train/learner.h"
#include "train/options.h"

/* ---- Texts ---------------------------------------------------------------------------------- */

static lmn_status get_text(const struct model_file *m, const char *key, const char **out,
                           struct error *err)
{
    *out = safetensors_text(&m->st, key);
    if (*out) return LMN_OK;
    return fail(err, LMN_ERR_PARSE, "%s: not a Lumenaut model: \"%s\" is missing in its metadata",
                m->st.path, key);
}

static lmn_status get_number(const struct model_file *m, const char *key, int base, uint64_t *out,
                             struct error *err)
{
    const char *text;
    char *end;
    lmn_status status = get_text(m, key, &text, err);
    if (status != LMN_OK) return status;
    *out = strtoull(text, &end, base);
    if (end == text || *end || *text == '-')
        return fail(err, LMN_ERR_PARSE, "%s: \"%s\" is no number in its metadata", m->st.path, key);
    return LMN_OK;
}

/* A JSON array of strings -> pointers and bytes in one block. */
static lmn_status get_list(const struct model_file *m, const char *key, char ***out, uint32_t *n,
                           struct error *err)
{
    lmn_status status = LMN_OK;
    const char *text;
    json_t *list = NULL, *item;
    size_t i, size = 1;
    TRY(get_text(m, key, &text, err));
    list = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    bool is_good = json_is_array(list);
    json_array_foreach(list, i, item)
    {
        is_good &= json_is_string(item);
        size += sizeof(char *) + json_string_length(item) + 1;
    }
    if (!is_good) {
        status = fail(err, LMN_ERR_PARSE, "%s: \"%s\" is no list of texts in its metadata",
                      m->st.path, key);
        goto done;
    }
    *out = mem_new(size, 1);
    if (!*out) {
        status = fail_memory(err, m->st.path);
        goto done;
    }
    *n = (uint32_t)json_array_size(list);
    char *bytes = (char *)(*out + *n);
    json_array_foreach(list, i, item)
    {
        size_t length = json_string_length(item);
        memcpy(bytes, json_string_value(item), length);
        (*out)[i] = bytes;
        bytes += length + 1;
    }
done:
    json_decref(list);
    return status;
}

/* "network": what the scene gave it. */
static lmn_status get_field(struct model_file *m, struct error *err)
{
    lmn_status status = LMN_OK;
    const char *text;
    TRY(get_text(m, "network", &text, err));
    TRY(meaning_read(&m->meaning, text, m->st.path, err));
    m->field = meaning_field(&m->meaning);
    m->field.grid = learner_grid();
    m->field.width = m->options.width;
    m->field.depth = m->options.depth;
done:
    return status;
}

lmn_status model_file_open(struct model_file *m, const char *path, struct error *err)
{
    lmn_status status = LMN_OK;
    const char *format, *contents;
    uint64_t version;
    *m = (struct model_file){0};
    TRY(safetensors_open(&m->st, path, err));
    TRY(get_text(m, "format", &format, err));
    if (strcmp(format, "lumenaut-model") != 0) {
        status = fail(err, LMN_ERR_PARSE, "%s: not a Lumenaut model but \"%.40s\"", path, format);
        goto done;
    }
    TRY(get_number(m, "version", 10, &version, err));
    if (version != MODEL_VERSION) {
        status = fail(err, LMN_ERR_PARSE, "%s: model of version %llu, this program reads %d", path,
                      (unsigned long long)version, MODEL_VERSION);
        goto done;
    }
    TRY(get_text(m, "contents", &contents, err));
    m->has_training = strcmp(contents, "training") == 0;
    TRY(get_text(m, "scene_path", &m->scene_path, err));
    TRY(get_text(m, "variables_path", &m->variables_path, err));
    TRY(get_text(m, "options", &m->config, err));
    TRY(get_number(m, "scene_hash", 16, &m->scene_hash, err));
    TRY(get_number(m, "training", 16, &m->training, err));
    TRY(get_number(m, "step", 10, &m->step, err));
    TRY(get_list(m, "defines", &m->defines, &m->n_defines, err));
    TRY(get_list(m, "variables", &m->names, &m->n_names, err));
    TRY(options_read(m->config, path, &m->options, err));
    if (m->options.method == LMN_METHOD_IMPROVED) TRY(get_field(m, err));
done:
    if (status != LMN_OK) model_file_release(m);
    return status;
}

void model_file_release(struct model_file *m)
{
    safetensors_release(&m->st);
    mem_free(m->defines);
    mem_free(m->names);
    meaning_release(&m->meaning);
    *m = (struct model_file){0};
}

lmn_status model_file_check_scene(const struct model_file *m, const struct scene *s, bool force,
                                  struct error *err)
{
    if (m->n_names != s->n_variables)
        return fail(err, LMN_ERR_ARGUMENT,
                    "%s: trained on %u variables, but the scene has %u: not the same scene",
                    m->st.path, m->n_names, s->n_variables);
    for (uint32_t i = 0; i < s->n_variables && !force; i++)
        if (strcmp(m->names[i], s->variables[i].name) != 0)
            return fail(err, LMN_ERR_ARGUMENT,
                        "%s: trained on a scene whose variable %u is \"%.60s\", here it is "
                        "\"%.60s\"; force to use it nevertheless",
                        m->st.path, i + 1, m->names[i], s->variables[i].name);
    if (m->scene_hash != s->hash && !force)
        return fail(err, LMN_ERR_ARGUMENT,
                    "%s: the scene has changed since this was trained; force to use it "
                    "nevertheless",
                    m->st.path);
    return LMN_OK;
}

/* ---- Tensors -------------------------------------------------------------------------------- */

struct generator_config model_file_network(const struct model_file *m)
{
    return (struct generator_config){
        .n_variables = m->n_names, .width = m->options.width, .depth = m->options.depth};
}

static struct tensor network_tensor(const struct layout_tensor *l, float *weights)
{
    return (struct tensor){.name = l->name,
                           .type = TENSOR_F32,
                           .rank = l->n_in > 0 ? 2 : 1,
                           .shape = {l->n_out, l->n_in},
                           .data = weights ? weights + l->at : NULL};
}

static uint32_t n_network_tensors(const struct model_file *m)
{
    struct generator_config c = model_file_network(m);
    return m->options.method == LMN_METHOD_IMPROVED ? layout_field_n_tensors(&m->field)
                                                    : layout_n_tensors(&c);
}

static void get_network_tensor(const struct model_file *m, uint32_t i, struct layout_tensor *out)
{
    struct generator_config c = model_file_network(m);
    if (m->options.method == LMN_METHOD_IMPROVED)
        layout_field_get(&m->field, i, out);
    else
        layout_get(&c, i, out);
}

size_t model_file_n_weights(const struct model_file *m)
{
    struct layout_tensor last;
    get_network_tensor(m, n_network_tensors(m) - 1, &last);
    return last.at + last.size;
}

lmn_status model_file_check_field(const struct model_file *m, const struct field_config *want,
                                  struct error *err)
{
    const struct field_config *c = &m->field;
    if (c->n_grids == want->n_grids && c->n_features == want->n_features &&
        c->n_variables == want->n_variables && c->n_lights == want->n_lights)
        return LMN_OK;
    return fail(
        err, LMN_ERR_ARGUMENT,
        "%s: its network is for a scene in which other things move: %u frames, %u features, "
        "%u variables and %u groups of lights, not %u, %u, %u and %u",
        m->st.path, c->n_grids, c->n_features, c->n_variables, c->n_lights, want->n_grids,
        want->n_features, want->n_variables, want->n_lights);
}

lmn_status model_file_check_weights(const struct model_file *m, struct error *err)
{
    for (uint32_t i = 0; i < n_network_tensors(m); i++) {
        struct layout_tensor l;
        get_network_tensor(m, i, &l);
        struct tensor t = network_tensor(&l, NULL);
        lmn_status status = safetensors_check(&m->st, &t, err);
        if (status != LMN_OK) return status;
    }
    return LMN_OK;
}

lmn_status model_file_read_weights(const struct model_file *m, float *weights, struct error *err)
{
    for (uint32_t i = 0; i < n_network_tensors(m); i++) {
        struct layout_tensor l;
        get_network_tensor(m, i, &l);
        struct tensor t = network_tensor(&l, weights);
        lmn_status status = safetensors_read(&m->st, &t, false, err);
        if (status != LMN_OK) return status;
    }
    return LMN_OK;
}

lmn_status model_file_read_counters(const struct model_file *m, int64_t counters[N_COUNTERS],
                                    double averages[N_AVERAGES], struct error *err)
{
    lmn_status status = LMN_OK;
    const struct tensor whole = {"state.counters", TENSOR_I64, 1, {N_COUNTERS}, counters};
    const struct tensor real = {"state.averages", TENSOR_F64, 1, {N_AVERAGES}, averages};
    TRY(safetensors_read(&m->st, &whole, false, err));
    TRY(safetensors_read(&m->st, &real, false, err));
    bool is_good = (uint64_t)counters[COUNTER_STEP] == m->step;
    for (int i = 0; i < N_COUNTERS; i++) is_good &= counters[i] >= 0 && counters[i] < 1LL << 53;
    int64_t stride = counters[COUNTER_HISTORY_STRIDE], thin = counters[COUNTER_SNAPSHOT_STRIDE];
    is_good &= stride > 0 && (stride & (stride - 1)) == 0 && thin > 0 && (thin & (thin - 1)) == 0;
    is_good &= counters[COUNTER_HISTORY_PENDING] < stride;
    if (!is_good)
        status = fail(err, LMN_ERR_PARSE, "%s: tensor \"state.counters\" holds impossible values",
                      m->st.path);
done:
    return status;
}

lmn_status model_file_read_history(const struct model_file *m, struct history *out,
                                   struct error *err)
{
    lmn_status status = LMN_OK;
    int64_t counters[N_COUNTERS];
    double averages[N_AVERAGES];
    uint32_t dim = m->n_names + 2, n_chains = m->options.n_chains;
    uint64_t n_rows = safetensors_n_rows(&m->st, "history.rows");
    uint64_t n_snapshots = safetensors_n_rows(&m->st, "history.snapshots");
    *out = (struct history){0};
    if (n_rows > HISTORY_ROWS || n_snapshots > HISTORY_SNAPSHOTS) {
        status = fail(err, LMN_ERR_PARSE, "%s: its history is too long", m->st.path);
        goto done;
    }
    TRY(model_file_read_counters(m, counters, averages, err));
    TRY(history_init(out, n_chains, dim, err));
    out->stride = (uint64_t)counters[COUNTER_HISTORY_STRIDE];
    out->n_pending = (uint32_t)counters[COUNTER_HISTORY_PENDING];
    out->snapshot_stride = (uint64_t)counters[COUNTER_SNAPSHOT_STRIDE];
    out->n_rows = (uint32_t)n_rows;
    out->n_snapshots = (uint32_t)n_snapshots;
    const struct tensor tensors[] = {
        {"history.rows", TENSOR_F64, 2, {n_rows, HISTORY_COLUMNS}, out->rows},
        {"history.pending", TENSOR_F64, 1, {HISTORY_COLUMNS}, out->pending},
        {"history.snapshot_steps", TENSOR_F64, 1, {n_snapshots}, out->snapshot_steps},
        {"history.snapshots", TENSOR_F32, 3, {n_snapshots, n_chains, dim}, out->snapshots},
    };
    for (size_t i = 0; i < sizeof tensors / sizeof *tensors; i++) {
        bool has_gaps = i < 2; /* before the averages begin there are none */
        TRY(safetensors_read(&m->st, &tensors[i], has_gaps, err));
    }
done:
    if (status != LMN_OK) history_release(out);
    return status;
}
