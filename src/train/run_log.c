/* SPDX-License-Identifier: Apache-2.0 */
/* metrics.jsonl: what a run tells of itself while it trains, and evaluation on the way. */
#include "train/trainer_inside.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/json.h"
#include "base/mem.h"
#include "train/checkpoint.h"
#include "train/options.h"

/* A line carries the chains when so many steps went by since the last that did: enough for a plot,
 * small enough for a long run without reuse. */
enum { CHAINS_EVERY = 20 };

/* ---- Writing -------------------------------------------------------------------------------- */

static void write_run(const struct trainer *t, struct json *j)
{
    const struct scene *s = t->place.scene;
    json_begin_object(j, "run");
    json_put_string(j, "scene", t->place.scene_path);
    json_put_string(j, "method", t->learner ? "improved" : "faithful");
    json_begin_array(j, "variables"); /* faithful: with the other dimensions of the chains */
    for (uint32_t i = 0; i < s->n_variables; i++) json_put_string(j, NULL, s->variables[i].name);
    if (!t->learner) {
        json_put_string(j, NULL, "patch.x");
        json_put_string(j, NULL, "patch.y");
    }
    json_end(j);
    json_put_integer(j, "seed", (int64_t)t->options.seed);
    json_put_integer(j, "n_weights", (int64_t)trainer_n_weights(t));
    json_put_integer(j, "memory_bytes", (int64_t)t->memory_size);
    json_begin_object(j, "options");
    options_write(&t->options, j);
    json_end(j);
    json_end(j);
}

static void write_eval(const struct trainer *t, struct json *j)
{
    const lmn_metrics *m = &t->eval;
    json_begin_object(j, "eval");
    json_put_integer(j, "n", t->eval_options.n);
    json_put_integer(j, "resolution", t->eval_options.resolution);
    json_put_integer(j, "spp", t->eval_options.spp);
    json_put_integer(j, "seed", (int64_t)t->eval_options.seed);
    json_put_number(j, "mae", m->mae);
    json_put_number(j, "mape", m->mape);
    json_put_number(j, "relmse", m->relmse);
    json_put_number(j, "mse", m->mse);
    json_put_number(j, "psnr", m->psnr);
    json_put_number(j, "dssim", m->dssim);
    json_put_number(j, "dssim_log", m->dssim_log);
    json_put_number(j, "dssim_legacy", m->dssim_legacy);
    json_put_number(j, "flip", m->flip);
    json_put_number(j, "flip_hdr", m->flip_hdr);
    json_end(j);
}

static void write_chains(const struct trainer *t, struct json *j)
{
    const struct explorer *e = &t->explorer;
    json_begin_array(j, "chains");
    for (uint32_t i = 0; i < e->options.n_chains; i++) {
        json_begin_array(j, NULL);
        for (uint32_t k = 0; k < e->options.dim; k++)
            json_put_float(j, NULL, e->u[(size_t)i * e->options.dim + k]);
        json_end(j);
    }
    json_end(j);
}

static void write_step(const struct trainer *t, bool with_chains, struct json *j)
{
    lmn_train_stats s;
    trainer_get_stats(t, &s);
    json_put_integer(j, "step", (int64_t)s.step);
    json_put_number(j, "cpu_s", s.cpu_s);
    json_put_number(j, "loss", s.loss);
    json_put_bool(j, "fresh", s.fresh != 0);
    json_put_integer(j, "batch", s.batch);
    json_put_number(j, "loss_fresh", s.loss_fresh); /* null during warm-up */
    json_put_number(j, "loss_replayed", s.loss_replayed);
    json_put_number(j, "reuse_probability", s.reuse_probability);
    json_put_number(j, "acceptance", s.acceptance);
    json_put_integer(j, "resolution", s.resolution);
    json_put_integer(j, "traced", (int64_t)s.n_traced);
    json_put_number(j, "trace_s", s.trace_s);
    json_put_number(j, "network_s", s.network_s);
    if (with_chains) write_chains(t, j);
    if (t->has_eval) write_eval(t, j);
}

const char *trainer_metrics_line(struct trainer *t)
{
    struct json j = {.out = &t->line};
    str_release(&t->line);
    json_begin_object(&j, NULL);
    if (!t->has_stepped) {
        write_run(t, &j);
    } else {
        bool with_chains = !t->learner && t->is_fresh &&
                           (t->chains_told_step == 0 ||
                            t->step >= t->chains_told_step + CHAINS_EVERY);
        write_step(t, with_chains, &j);
        if (with_chains) t->chains_told_step = t->step;
        t->has_eval = false;
    }
    json_end(&j);
    return t->line.failed ? NULL : t->line.text;
}

/* ---- Evaluation on the way ------------------------------------------------------------------ */

static bool same_test(const lmn_eval_options *a, const lmn_eval_options *b)
{
    return a->n == b->n && a->resolution == b->resolution && a->spp == b->spp && a->seed == b->seed;
}

static lmn_status make_painter(struct trainer *t, struct error *err)
{
    if (t->has_painter) return LMN_OK;
    const struct painter_network network = t->learner ? learner_network(t->learner)
                                                      : (struct painter_network){
                                                            .generator = t->generator};
    const lmn_status status = painter_init(&t->painter, &t->place, &network, err);
    t->has_painter = status == LMN_OK;
    return status;
}

lmn_status trainer_render(struct trainer *t, const float *u,
                          const struct model_render_options *options, struct image *out,
                          double *render_s, lmn_progress_fn *progress, void *progress_user,
                          struct error *err)
{
    lmn_status status = make_painter(t, err);
    if (status != LMN_OK) return status;
    if (t->learner) learner_show_average(t->learner, true);
    status = painter_render(&t->painter, u, options, out, render_s, progress, progress_user, err);
    if (t->learner) learner_show_average(t->learner, false);
    return status;
}

lmn_status trainer_eval(struct trainer *t, const lmn_eval_options *options,
                        lmn_progress_fn *progress, void *progress_user, lmn_metrics *out,
                        struct error *err)
{
    lmn_status status = LMN_OK;
    lmn_eval_result result;
    TRY(make_painter(t, err));
    if (!t->tests.u || !same_test(options, &t->eval_options)) {
        test_set_release(&t->tests);
        TRY(test_set_init(&t->tests, t->place.scene, options, &t->trace, err));
        t->tests.has_photons = t->has_photons;
        t->eval_options = *options;
    }
    TRY(test_set_trace(&t->tests, &t->place, progress, progress_user, err));
    if (t->learner) learner_show_average(t->learner, true);
    status = test_set_evaluate(&t->tests, &t->painter, &result, NULL, NULL, err);
    if (t->learner) learner_show_average(t->learner, false);
    if (status != LMN_OK) goto done;
    t->eval = result.mean;
    t->has_eval = true;
    if (out) *out = result.mean;
done:
    return status;
}

/* ---- Reading back --------------------------------------------------------------------------- */

char *metrics_path(const char *model_path)
{
    struct str s = {0};
    const char *slash = strrchr(model_path, '/'), *dot = strrchr(model_path, '.');
    bool has_extension = dot && dot != model_path && (!slash || dot > slash + 1);
    str_add_bytes(&s, model_path, has_extension ? (size_t)(dot - model_path) : strlen(model_path));
    str_add(&s, ".metrics.jsonl");
    if (!s.failed) return s.text;
    str_release(&s);
    return NULL;
}

static double number_of(const json_t *line, const char *key)
{
    return json_number_value(json_object_get(line, key));
}

/* The line that ends at *end, which goes to its start. False at the start of the file, and where it
 * cannot be read. */
static bool previous_line(FILE *f, off_t *end, struct str *line)
{
    char piece[4096];
    off_t start = *end - 1; /* before its newline */
    const char *newline = NULL;
    line->length = 0;
    while (start > 0 && !newline) {
        const size_t n = start < (off_t)sizeof piece ? (size_t)start : sizeof piece;
        if (fseeko(f, start - (off_t)n, SEEK_SET) != 0 || fread(piece, 1, n, f) != n) return false;
        newline = memrchr(piece, '\n', n);
        start -= newline ? piece + n - (newline + 1) : (ptrdiff_t)n;
    }
    if (start < 0 || fseeko(f, start, SEEK_SET) != 0) return false;
    for (off_t rest = *end - start; rest > 0;) {
        const size_t n = rest < (off_t)sizeof piece ? (size_t)rest : sizeof piece;
        if (fread(piece, 1, n, f) != n) return false;
        str_add_bytes(line, piece, n);
        rest -= (off_t)n;
    }
    *end = start;
    return !line->failed;
}

void metrics_times(const char *path, uint64_t step, double *cpu_s, double *trace_s,
                   double *network_s)
{
    double found[3] = {0};
    struct str text = {0};
    FILE *f = fopen(path, "rb");
    off_t end = f && fseeko(f, 0, SEEK_END) == 0 ? ftello(f) : 0;
    /* From the end: a long training has hundreds of thousands of lines. */
    for (bool is_found = false; f && !is_found && previous_line(f, &end, &text);) {
        json_t *line = json_loads(text.text, JSON_REJECT_DUPLICATES, NULL);
        const json_t *at = json_object_get(line, "step");
        if (json_is_integer(at) && json_integer_value(at) >= 0 &&
            (uint64_t)json_integer_value(at) <= step) {
            found[0] = number_of(line, "cpu_s");
            found[1] = number_of(line, "trace_s");
            found[2] = number_of(line, "network_s");
            is_found = true;
        }
        json_decref(line);
    }
    str_release(&text);
    if (f) fclose(f);
    if (cpu_s) *cpu_s = found[0];
    if (trace_s) *trace_s = found[1];
    if (network_s) *network_s = found[2];
}
