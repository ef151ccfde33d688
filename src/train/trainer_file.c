/* SPDX-License-Identifier: Apache-2.0 */
/* trainer_save() and trainer_resume(): one list of tensors serves both. */
#include "train/trainer_inside.h"

#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/json.h"
#include "base/mem.h"
#include "train/checkpoint.h"
#include "train/layout.h"
#include "train/model_file.h"
#include "train/options.h"

enum { MAX_NETWORK_TENSORS = 2 * (32 + 3), MAX_TENSORS = MAX_NETWORK_TENSORS + 32 };

struct tensor_list {
    struct tensor items[MAX_TENSORS];
    struct layout_tensor network[MAX_NETWORK_TENSORS]; /* holds the names */
    uint32_t n, n_network;
};

static void add(struct tensor_list *l, const char *name, enum tensor_type type, uint32_t rank,
                const uint64_t shape[3], void *data)
{
    struct tensor *t = &l->items[l->n++];
    *t = (struct tensor){.name = name, .type = type, .rank = rank, .data = data};
    memcpy(t->shape, shape, rank * sizeof *shape);
}

static void list_network(struct tensor_list *l, const struct trainer *t)
{
    const struct field_config *field = t->learner ? learner_field_config(t->learner) : NULL;
    float *weights = trainer_weights(t);
    l->n_network = field ? layout_field_n_tensors(field) : layout_n_tensors(&t->config);
    for (uint32_t i = 0; i < l->n_network; i++) {
        struct layout_tensor *n = &l->network[i];
        if (field)
            layout_field_get(field, i, n);
        else
            layout_get(&t->config, i, n);
        add(l, n->name, TENSOR_F32, n->n_in > 0 ? 2 : 1, (uint64_t[3]){n->n_out, n->n_in},
            weights + n->at);
    }
}

/* All but the network, the history and the counters. */
static void list_training(struct tensor_list *l, const struct trainer *t)
{
    if (t->learner) {
        l->n += learner_tensors(t->learner, l->items + l->n);
        return;
    }
    const uint64_t n_weights = t->adam.n, p = t->n_pixels, d = t->config.n_variables;
    const uint64_t chains = t->options.n_chains, held = t->replay.n;
    add(l, "adam.m", TENSOR_F32, 1, (uint64_t[3]){n_weights}, t->adam.m);
    add(l, "adam.v", TENSOR_F32, 1, (uint64_t[3]){n_weights}, t->adam.v);
    add(l, "chains.u", TENSOR_F32, 2, (uint64_t[3]){chains, d + 2}, t->explorer.u);
    add(l, "chains.serials", TENSOR_I64, 1, (uint64_t[3]){chains}, t->serials);
    add(l, "chains.inputs", TENSOR_F32, 3, (uint64_t[3]){chains, p, GENERATOR_INPUTS},
        t->states.inputs);
    add(l, "chains.targets", TENSOR_F32, 3, (uint64_t[3]){chains, p, 3}, t->states.targets);
    add(l, "chains.v", TENSOR_F32, 2, (uint64_t[3]){chains, d}, t->states.v);
    add(l, "replay.inputs", TENSOR_F32, 3, (uint64_t[3]){held, p, GENERATOR_INPUTS},
        t->replay.inputs);
    add(l, "replay.targets", TENSOR_F32, 3, (uint64_t[3]){held, p, 3}, t->replay.targets);
    add(l, "replay.v", TENSOR_F32, 2, (uint64_t[3]){held, d}, t->replay.v);
    add(l, "replay.losses", TENSOR_F32, 1, (uint64_t[3]){held}, t->replay.losses);
    add(l, "replay.is_large", TENSOR_U8, 1, (uint64_t[3]){held}, t->replay.is_large);
}

static void list_history(struct tensor_list *l, const struct history *h)
{
    add(l, "history.rows", TENSOR_F64, 2, (uint64_t[3]){h->n_rows, HISTORY_COLUMNS}, h->rows);
    add(l, "history.pending", TENSOR_F64, 1, (uint64_t[3]){HISTORY_COLUMNS}, (void *)h->pending);
    add(l, "history.snapshot_steps", TENSOR_F64, 1, (uint64_t[3]){h->n_snapshots},
        h->snapshot_steps);
    add(l, "history.snapshots", TENSOR_F32, 3, (uint64_t[3]){h->n_snapshots, h->n_chains, h->dim},
        h->snapshots);
}

/* ---- Saving --------------------------------------------------------------------------------- */

static void get_counters(const struct trainer *t, int64_t c[N_COUNTERS], double a[N_AVERAGES])
{
    c[COUNTER_STEP] = (int64_t)t->step;
    c[COUNTER_TRACED] = (int64_t)t->n_traced;
    c[COUNTER_ADAM] = (int64_t)t->adam.t;
    c[COUNTER_GENERATION] = (int64_t)t->explorer.generation;
    c[COUNTER_REUSE_EVENTS] = (int64_t)t->reuse.n_events;
    c[COUNTER_REPLAY_ADDED] = (int64_t)t->replay.n_added;
    c[COUNTER_HISTORY_STRIDE] = (int64_t)t->history.stride;
    c[COUNTER_HISTORY_PENDING] = (int64_t)t->history.n_pending;
    c[COUNTER_SNAPSHOT_STRIDE] = (int64_t)t->history.snapshot_stride;
    a[AVERAGE_LOSS_NEW] = t->reuse.loss_new;
    a[AVERAGE_LOSS_EXIST] = t->reuse.loss_exist;
    a[AVERAGE_ACCEPTANCE] = t->acceptance;
}

/* Of the improved method: what the scene gives the network. */
static lmn_status write_network(const struct trainer *t, struct str *to, struct error *err)
{
    struct meaning meaning;
    struct json j = {.out = to};
    lmn_status status = sight_describe(learner_network(t->learner).sight, &meaning, err);
    if (status != LMN_OK) return status;
    meaning_write(&meaning, &j);
    meaning_release(&meaning);
    return LMN_OK;
}

/* The lists in the metadata, as JSON texts. */
static void write_texts(const struct trainer *t, struct str *options, struct str *defines,
                        struct str *variables)
{
    struct json o = {.out = options}, d = {.out = defines}, v = {.out = variables};
    json_begin_object(&o, NULL);
    options_write(&t->options, &o);
    json_end(&o);
    json_begin_array(&d, NULL);
    for (uint32_t i = 0; i < t->place.n_defines; i++)
        json_put_string(&d, NULL, t->place.defines[i]);
    json_end(&d);
    json_begin_array(&v, NULL);
    for (uint32_t i = 0; i < t->config.n_variables; i++)
        json_put_string(&v, NULL, t->place.scene->variables[i].name);
    json_end(&v);
}

/* One of the two files. */
static lmn_status save_part(const struct trainer *t, const char *path, bool is_state,
                            struct error *err)
{
    lmn_status status = LMN_OK;
    int64_t counters[N_COUNTERS];
    double averages[N_AVERAGES];
    struct str options = {0}, defines = {0}, variables = {0}, hash = {0}, step = {0};
    struct str network = {0}, training = {0}, version = {0};
    struct tensor_list *l = mem_new(1, sizeof *l);
    get_counters(t, counters, averages);
    write_texts(t, &options, &defines, &variables);
    str_add(&hash, "%016llx", (unsigned long long)t->place.scene->hash);
    str_add(&step, "%llu", (unsigned long long)t->step);
    str_add(&training, "%016llx", (unsigned long long)t->training);
    str_add(&version, "%d", MODEL_VERSION);
    if (t->learner) TRY(write_network(t, &network, err));
    if (!l || network.failed || options.failed || defines.failed || variables.failed ||
        hash.failed || step.failed || training.failed || version.failed) {
        status = fail_memory(err, path);
        goto done;
    }
    const char *scene_path = t->place.scene_path, *variables_path = t->place.variables_path;
    const struct tensor_text texts[] = {
        {"format", "lumenaut-model"},
        {"version", version.text},
        {"method", t->learner ? "improved" : "faithful"},
        {"contents", is_state ? "training" : "weights"},
        {"training", training.text},
        {"step", step.text},
        {"scene_path", scene_path ? scene_path : ""},
        {"variables_path", variables_path ? variables_path : ""},
        {"defines", defines.text},
        {"scene_hash", hash.text},
        {"variables", variables.text},
        {"options", options.text},
        {"network", network.text}, /* last: the improved method only */
    };
    const uint32_t n_texts = sizeof texts / sizeof *texts - (t->learner ? 0 : 1);
    list_network(l, t);
    add(l, "state.counters", TENSOR_I64, 1, (uint64_t[3]){N_COUNTERS}, counters);
    add(l, "state.averages", TENSOR_F64, 1, (uint64_t[3]){N_AVERAGES}, averages);
    list_history(l, &t->history);
    if (is_state) list_training(l, t);
    TRY(safetensors_save(path, texts, n_texts, l->items, l->n, err));
done:
    mem_free(l);
    str_release(&options);
    str_release(&defines);
    str_release(&variables);
    str_release(&hash);
    str_release(&step);
    str_release(&network);
    str_release(&training);
    str_release(&version);
    return status;
}

/* The state comes first: until the model is there too, the training goes on from the newer state
 * as well as it would with the newer model. */
lmn_status trainer_save(const struct trainer *t, const char *path, struct error *err)
{
    lmn_status status = LMN_OK;
    char *state = state_path(path);
    if (!state) {
        status = fail_memory(err, path);
        goto done;
    }
    if (strcmp(path, "-") == 0) {
        status = fail(err, LMN_ERR_ARGUMENT, "a checkpoint is two files: it needs a name");
        goto done;
    }
    file_remove_leftovers(state);
    file_remove_leftovers(path);
    TRY(save_part(t, state, true, err));
    TRY(save_part(t, path, false, err));
done:
    mem_free(state);
    return status;
}

/* ---- Resuming ------------------------------------------------------------------------------- */

static void set_counters(struct trainer *t, const int64_t c[N_COUNTERS], const double a[N_AVERAGES])
{
    t->step = (uint64_t)c[COUNTER_STEP];
    t->n_traced = (uint64_t)c[COUNTER_TRACED];
    t->adam.t = (uint64_t)c[COUNTER_ADAM];
    t->explorer.generation = (uint64_t)c[COUNTER_GENERATION];
    t->reuse.n_events = (uint64_t)c[COUNTER_REUSE_EVENTS];
    t->replay.n_added = (uint64_t)c[COUNTER_REPLAY_ADDED];
    t->replay.n = t->replay.n_added < t->replay.capacity ? (uint32_t)t->replay.n_added
                                                         : t->replay.capacity;
    t->reuse.loss_new = a[AVERAGE_LOSS_NEW];
    t->reuse.loss_exist = a[AVERAGE_LOSS_EXIST];
    t->acceptance = a[AVERAGE_ACCEPTANCE];
}

/* What tensors' types and shapes do not say yet. */
static lmn_status check_training(const struct trainer *t, const char *path, struct error *err)
{
    if (t->learner) return learner_restore(t->learner, path, err);
    size_t n_u = (size_t)t->options.n_chains * t->explorer.options.dim;
    for (size_t i = 0; i < n_u; i++)
        if (!(t->explorer.u[i] >= 0 && t->explorer.u[i] < 1))
            return fail(err, LMN_ERR_PARSE, "%s: a chain in \"chains.u\" has left [0, 1)", path);
    for (size_t i = 0; i < t->adam.n; i++)
        if (t->adam.v[i] < 0)
            return fail(err, LMN_ERR_PARSE, "%s: \"adam.v\" is negative somewhere", path);
    const unsigned char *is_large = (const unsigned char *)t->replay.is_large;
    for (uint32_t i = 0; i < t->replay.n; i++)
        if (t->replay.losses[i] < 0 || is_large[i] > 1)
            return fail(err, LMN_ERR_PARSE, "%s: \"replay\" holds impossible values", path);
    /* A step is at least an event or a replayed batch, and replaying needs something to replay. */
    bool is_good = t->reuse.n_events == t->explorer.generation && t->step == t->adam.t &&
                   t->explorer.generation <= t->step &&
                   t->replay.n_added == t->explorer.generation * t->options.n_chains &&
                   t->n_traced == t->replay.n_added;
    if (!is_good) return fail(err, LMN_ERR_PARSE, "%s: its counters contradict each other", path);
    return LMN_OK;
}

/* Before memory is taken on the word of the options: the file must hold as much. */
static lmn_status check_sizes(const struct model_file *m, struct error *err)
{
    if (m->options.method == LMN_METHOD_IMPROVED) return model_file_check_weights(m, err);
    uint64_t p = (uint64_t)m->options.patch_size * m->options.patch_size;
    const struct tensor inputs = {
        "chains.inputs", TENSOR_F32, 3, {m->options.n_chains, p, GENERATOR_INPUTS}, NULL};
    lmn_status status = safetensors_check(&m->st, &inputs, err);
    return status == LMN_OK ? model_file_check_weights(m, err) : status;
}

/* Opens the state of the model at `path` and compares it with the model, if that is there: a
 * training that was stopped while it wrote its first checkpoint has none. */
static lmn_status open_state(const char *path, struct model_file *out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct model_file model = {0};
    char *state = state_path(path);
    if (!state) {
        status = fail_memory(err, path);
        goto done;
    }
    const bool has_model = access(path, F_OK) == 0, has_state = access(state, F_OK) == 0;
    if (has_model) TRY(model_file_open(&model, path, err));
    if (has_model && !has_state) {
        status = fail(err, LMN_ERR_IO, "%s: training cannot go on from it without %s: no such file",
                      path, state);
        goto done;
    }
    TRY(model_file_open(out, has_state ? state : path, err)); /* neither: says so of the model */
    if (!out->has_training) {
        status = fail(err, LMN_ERR_ARGUMENT, "%s: holds a model, no state of a training", state);
        goto done;
    }
    if (!has_model) goto done;
    if (out->training != model.training || strcmp(out->config, model.config) != 0)
        status = fail(err, LMN_ERR_ARGUMENT, "%s: the state of another training than that of %s",
                      state, path);
    else if (model.step > out->step)
        status = fail(err, LMN_ERR_ARGUMENT, "%s: an older state, of step %llu; %s is at step %llu",
                      state, (unsigned long long)out->step, path, (unsigned long long)model.step);
done:
    model_file_release(&model);
    mem_free(state);
    return status;
}

lmn_status trainer_resume(const struct workplace *place, const char *path, bool force,
                          struct trainer **out, struct error *err)
{
    lmn_status status = LMN_OK;
    int64_t counters[N_COUNTERS];
    double averages[N_AVERAGES];
    struct model_file m = {0};
    struct history history = {0};
    struct trainer *t = NULL;
    char *metrics = NULL;
    struct tensor_list *l = mem_new(1, sizeof *l);
    if (!l) {
        status = fail_memory(err, path);
        goto done;
    }
    TRY(open_state(path, &m, err));
    TRY(model_file_check_scene(&m, place->scene, force, err));
    TRY(check_sizes(&m, err));
    TRY(model_file_read_counters(&m, counters, averages, err));
    TRY(model_file_read_history(&m, &history, err));
    TRY(trainer_new(place, &m.options, &t, err));
    if (t->learner) TRY(model_file_check_field(&m, learner_field_config(t->learner), err));
    t->training = m.training;
    set_counters(t, counters, averages);
    if (t->learner && !learner_set_progress(t->learner, t->step, t->n_traced)) {
        status = fail(err, LMN_ERR_PARSE, "%s: its counters contradict each other", m.st.path);
        goto done;
    }
    history_release(&t->history);
    t->history = history;
    history = (struct history){0};

    list_network(l, t);
    list_training(l, t);
    for (uint32_t i = 0; i < l->n; i++) TRY(safetensors_read(&m.st, &l->items[i], false, err));
    TRY(check_training(t, m.st.path, err));
    if (!t->learner) {
        generator_weights_changed(t->generator);
        replay_rebuild(&t->replay);
    }

    metrics = metrics_path(path);
    if (metrics) metrics_times(metrics, t->step, &t->cpu_s, &t->trace_s, &t->network_s);
    *out = t;
    t = NULL;
done:
    trainer_free(t);
    history_release(&history);
    model_file_release(&m);
    mem_free(metrics);
    mem_free(l);
    return status;
}
