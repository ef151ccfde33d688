/* SPDX-License-Identifier: Apache-2.0 */
/* What bench learn found: read from the files of its trainings, summed up, written and printed. */
#include "learn.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const metric_names[N_LEARN_METRICS] = {"mape", "relmse", "flip"};

/* ---- Curves --------------------------------------------------------------------------------- */

double learn_number(const char *from, const char *key)
{
    char quoted[64], *end;
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *at = strstr(from, quoted);
    if (!at) return NAN;
    at += strlen(quoted);
    const double value = strtod(at, &end);
    return end == at ? NAN : value;
}

static bool read_point(const char *line, size_t length, struct learn_point *p)
{
    char key[32];
    p->line = strndup(line, length);
    if (!p->line) return false;
    p->step = learn_number(p->line, "step");
    p->cpu_s = learn_number(p->line, "cpu_s");
    for (int k = 0; k < N_LEARN_SETS; k++) {
        snprintf(key, sizeof key, "\"%s\":{\"mae\"", learn_set_names[k]);
        const char *at = strstr(p->line, key);
        for (int m = 0; m < N_LEARN_METRICS; m++)
            p->error[k][m] = at ? learn_number(at, metric_names[m]) : NAN;
    }
    return true;
}

int learn_curve_read(struct learn_curve *c, const struct learn_job *job)
{
    char path[LEARN_PATH];
    int code = EXIT_OK;
    *c = (struct learn_curve){0};
    learn_path(path, "%s.jsonl", job->base);
    char *text = learn_load_text(path);
    if (!text) return EXIT_OK;
    const char *line = strchr(text, '\n'); /* the header says what was checked already */
    bool is_over = false;
    for (const char *end; line && !is_over && (end = strchr(line + 1, '\n')); line = end) {
        const char *failed = strstr(line + 1, LEARN_FAILED);
        if (failed && failed < end) {
            c->failure = strndup(line + 1, (size_t)(end - line - 1));
            if (!c->failure) code = app_error(job->app, EXIT_FAILED, "out of memory");
            break;
        }
        struct learn_point *more = realloc(c->points, (c->n + 1) * sizeof *more);
        if (more) c->points = more;
        if (!more || !read_point(line + 1, (size_t)(end - line - 1), &c->points[c->n])) {
            code = app_error(job->app, EXIT_FAILED, "out of memory");
            break;
        }
        const struct learn_point *p = &c->points[c->n++];
        is_over = job->steps ? p->step >= (double)job->steps : p->cpu_s >= 60.0 * job->minutes;
    }
    free(text);
    return code;
}

void learn_curve_release(struct learn_curve *c)
{
    for (uint32_t i = 0; i < c->n; i++) free(c->points[i].line);
    free(c->points);
    free(c->failure);
    *c = (struct learn_curve){0};
}

/* ---- Sums over seeds ------------------------------------------------------------------------ */

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts `values`; NAN of none. */
static double median(double *values, uint32_t n)
{
    if (n == 0) return NAN;
    qsort(values, n, sizeof *values, compare_doubles);
    return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

static const struct learn_curve *curves_of(const struct learn_results *r,
                                           const struct learn_scene *s, uint32_t method)
{
    return s->curves + (size_t)method * r->args->seeds;
}

/* The k-th evaluation of a method, seeds taken together: as many as all seeds have that have any.
 */
static uint32_t n_common(const struct learn_results *r, const struct learn_curve *c)
{
    uint32_t n = UINT32_MAX;
    for (uint32_t i = 0; i < r->args->seeds; i++)
        if (c[i].n > 0 && c[i].n < n) n = c[i].n;
    return n == UINT32_MAX ? 0 : n;
}

/* Median over the seeds' k-th evaluations; k UINT32_MAX: their last. range (may be NULL): the
 * smallest and largest. One that came apart counts as infinite. */
static double error_at(const struct learn_results *r, const struct learn_curve *c, uint32_t k,
                       int set, int metric, double range[2])
{
    double values[LEARN_MAX_SEEDS];
    uint32_t n = 0;
    for (uint32_t i = 0; i < r->args->seeds; i++) {
        if (c[i].failure && k >= c[i].n)
            values[n++] = INFINITY;
        else if (c[i].n > 0)
            values[n++] = c[i].points[k < c[i].n ? k : c[i].n - 1].error[set][metric];
    }
    const double middle = median(values, n);
    if (range) {
        range[0] = n ? values[0] : NAN;
        range[1] = n ? values[n - 1] : NAN;
    }
    return middle;
}

static double time_at(const struct learn_results *r, const struct learn_curve *c, uint32_t k)
{
    double values[LEARN_MAX_SEEDS];
    uint32_t n = 0;
    for (uint32_t i = 0; i < r->args->seeds; i++)
        if (c[i].n > 0) values[n++] = c[i].points[k < c[i].n ? k : c[i].n - 1].cpu_s;
    return median(values, n);
}

/* When the error first falls to `target`: between two evaluations straight on logarithmic axes.
 * NAN: never. *is_bound: at the first evaluation already, so that it may have been earlier. */
static double reach_time(const struct learn_results *r, const struct learn_curve *c, int set,
                         int metric, double target, bool *is_bound)
{
    const uint32_t n = n_common(r, c);
    double last_error = NAN, last_time = NAN;
    *is_bound = false;
    for (uint32_t k = 0; k < n; k++) {
        const double error = error_at(r, c, k, set, metric, NULL), at = time_at(r, c, k);
        if (error <= target) {
            *is_bound = k == 0;
            if (k == 0 || !(last_error > error) || !(error > 0.0)) return at;
            const double share = log(last_error / target) / log(last_error / error);
            return last_time * pow(at / last_time, share);
        }
        last_error = error;
        last_time = at;
    }
    return NAN;
}

/* What is said of a method on a set by a metric. */
struct verdict {
    double error, range[2], cpu_s;
    double reach_s, speedup; /* against the best faithful network; NAN: never, or it is one */
    bool is_bound;
    double uniform_ratio; /* the error of `uniform` / this one's; NAN without */
};

/* The faithful method with the least final error; UINT32_MAX: none. */
static uint32_t best_faithful(const struct learn_results *r, const struct learn_scene *s, int set,
                              int metric)
{
    uint32_t best = UINT32_MAX;
    double least = INFINITY;
    for (uint32_t m = 0; m < r->n_methods; m++) {
        if (r->methods[m].options.method != LMN_METHOD_FAITHFUL) continue;
        const double error = error_at(r, curves_of(r, s, m), UINT32_MAX, set, metric, NULL);
        if (!(error < least)) continue;
        least = error;
        best = m;
    }
    return best;
}

/* The first of that name; UINT32_MAX: none. */
static uint32_t uniform_method(const struct learn_results *r)
{
    for (uint32_t m = 0; m < r->n_methods; m++)
        if (strcspn(r->methods[m].label, ":") == 7 && !strncmp(r->methods[m].label, "uniform", 7))
            return m;
    return UINT32_MAX;
}

static struct verdict judge(const struct learn_results *r, const struct learn_scene *s,
                            uint32_t method, int set, int metric)
{
    const struct learn_curve *c = curves_of(r, s, method);
    struct verdict v = {.reach_s = NAN, .speedup = NAN, .uniform_ratio = NAN};
    v.error = error_at(r, c, UINT32_MAX, set, metric, v.range);
    v.cpu_s = time_at(r, c, UINT32_MAX);
    const uint32_t best = best_faithful(r, s, set, metric);
    if (best != UINT32_MAX && r->methods[method].options.method != LMN_METHOD_FAITHFUL) {
        const struct learn_curve *f = curves_of(r, s, best);
        const double target = error_at(r, f, UINT32_MAX, set, metric, NULL);
        v.reach_s = reach_time(r, c, set, metric, target, &v.is_bound);
        v.speedup = time_at(r, f, UINT32_MAX) / v.reach_s;
    }
    const uint32_t uniform = uniform_method(r);
    if (uniform != UINT32_MAX && uniform != method)
        v.uniform_ratio = error_at(r, curves_of(r, s, uniform), UINT32_MAX, set, metric, NULL) /
                          v.error;
    return v;
}

/* ---- JSON ----------------------------------------------------------------------------------- */

static void write_summary(const struct learn_results *r, const struct learn_scene *s,
                          struct json_out *j)
{
    static const size_t offsets[N_LEARN_METRICS] = {
        offsetof(lmn_metrics, mape), offsetof(lmn_metrics, relmse), offsetof(lmn_metrics, flip)};
    jo_array(j, "summary");
    for (int set = 0; set < N_LEARN_SETS; set++) {
        for (int k = 0; k < N_LEARN_METRICS; k++) {
            const uint32_t best = best_faithful(r, s, set, k);
            double noise;
            memcpy(&noise, (const char *)&s->tests.sets[set].noise + offsets[k], sizeof noise);
            jo_object(j, NULL);
            jo_string(j, "set", learn_set_names[set]);
            jo_string(j, "metric", metric_names[k]);
            jo_number(j, "noise", noise);
            jo_string(j, "best_faithful", best == UINT32_MAX ? NULL : r->methods[best].label);
            jo_array(j, "methods");
            for (uint32_t m = 0; m < r->n_methods; m++) {
                const struct verdict v = judge(r, s, m, set, k);
                jo_object(j, NULL);
                jo_string(j, "method", r->methods[m].label);
                jo_number(j, "error", v.error);
                jo_number(j, "error_min", v.range[0]);
                jo_number(j, "error_max", v.range[1]);
                jo_number(j, "cpu_s", v.cpu_s);
                jo_number(j, "reach_faithful_s", v.reach_s);
                jo_number(j, "speedup", v.speedup);
                jo_bool(j, "speedup_is_bound", v.is_bound);
                jo_number(j, "uniform_ratio", v.uniform_ratio);
                jo_end(j);
            }
            jo_end(j);
            jo_end(j);
        }
    }
    jo_end(j);
}

static void write_scene(const struct learn_results *r, const struct learn_scene *s,
                        struct json_out *j)
{
    char hash[24];
    lmn_scene_info info;
    lmn_scene_get_info(s->scene, &info);
    snprintf(hash, sizeof hash, "%016llx", (unsigned long long)info.hash);
    jo_object(j, NULL);
    jo_string(j, "name", s->name);
    jo_string(j, "path", s->path);
    jo_string(j, "hash", hash);
    jo_count(j, "variables", info.n_variables);
    jo_string(j, "tests", s->tests.folder);
    jo_object(j, "noise");
    for (int k = 0; k < N_LEARN_SETS; k++)
        jo_metrics(j, learn_set_names[k], &s->tests.sets[k].noise);
    jo_end(j);
    jo_array(j, "runs");
    for (uint32_t m = 0; m < r->n_methods; m++) {
        for (uint32_t i = 0; i < r->args->seeds; i++) {
            const struct learn_curve *c = &curves_of(r, s, m)[i];
            jo_object(j, NULL);
            jo_string(j, "method", r->methods[m].label);
            jo_count(j, "seed", i + 1);
            jo_array(j, "evaluations");
            for (uint32_t p = 0; p < c->n; p++) jo_raw(j, NULL, c->points[p].line);
            jo_end(j);
            if (c->failure) jo_raw(j, "failure", c->failure);
            jo_end(j);
        }
    }
    jo_end(j);
    write_summary(r, s, j);
    jo_end(j);
}

/* "Intel(R) Xeon(R) ..." as Linux tells it; "" where it does not. */
static void processor_name(char *out, size_t size)
{
    char line[256];
    FILE *f = fopen("/proc/cpuinfo", "r");
    out[0] = '\0';
    while (f && !out[0] && fgets(line, sizeof line, f)) {
        const char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) != 0 || !colon || colon[1] == '\0') continue;
        snprintf(out, size, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
    }
    if (f) fclose(f);
}

void learn_results_write(const struct learn_results *r, FILE *f)
{
    static const char *const integrators[] = {"path", "path+photons", "auto"};
    const struct learn_args *a = r->args;
    struct json_out j = {.f = f};
    lmn_info info;
    char processor[256];
    const char *options;
    lmn_context_info(r->app->context, &info);
    processor_name(processor, sizeof processor);
    jo_object(&j, NULL);
    jo_string(&j, "bench", "learn");
    jo_string(&j, "version", info.version);
    jo_string(&j, "processor", processor);
    jo_string(&j, "cpu", info.cpu_used);
    jo_count(&j, "threads", info.threads);
    if (a->steps)
        jo_count(&j, "steps", a->steps);
    else
        jo_number(&j, "minutes", a->minutes);
    jo_count(&j, "seeds", a->seeds);
    jo_count(&j, "n", a->n);
    jo_count(&j, "candidates", a->n_candidates);
    jo_count(&j, "resolution", a->resolution);
    jo_count(&j, "reference_spp", a->reference_spp);
    jo_string(&j, "integrator", integrators[a->integrator]);
    jo_array(&j, "methods");
    for (uint32_t m = 0; m < r->n_methods; m++) {
        jo_object(&j, NULL);
        jo_string(&j, "method", r->methods[m].label);
        if (lmn_train_options_json(r->app->context, &r->methods[m].options, &options) == LMN_OK)
            jo_raw(&j, "options", options);
        jo_end(&j);
    }
    jo_end(&j);
    jo_array(&j, "scenes");
    for (uint32_t i = 0; i < r->n_scenes; i++)
        if (r->scenes[i].has_curves) write_scene(r, &r->scenes[i], &j);
    jo_end(&j);
    jo_end(&j);
}

/* ---- For people ----------------------------------------------------------------------------- */

/* "35s/17x", "never", "-" */
static void format_reach(const struct verdict *v, bool is_faithful, char text[24])
{
    if (is_faithful)
        snprintf(text, 24, "-");
    else if (!(v->reach_s > 0.0))
        snprintf(text, 24, "never");
    else
        snprintf(text, 24, "%s%.3gs/%.3gx", v->is_bound ? "<" : "", v->reach_s, v->speedup);
}

static const char noise_label[] = "the references' own noise";

static void print_set(const struct learn_results *r, const struct learn_scene *s, int set, FILE *f)
{
    const lmn_metrics *noise = &s->tests.sets[set].noise;
    const bool has_faithful = best_faithful(r, s, set, 0) != UINT32_MAX;
    int width = (int)strlen(noise_label);
    for (uint32_t m = 0; m < r->n_methods; m++)
        if ((int)strlen(r->methods[m].label) > width) width = (int)strlen(r->methods[m].label);
    fprintf(f, "%s, %u %s configurations, median of %u seed%s\n", s->name, r->args->n,
            learn_set_names[set], r->args->seeds, r->args->seeds > 1 ? "s" : "");
    fprintf(f, "%-*s %8s %8s %8s   %-35s   %s\n", width, "method", "MAPE", "relMSE", "FLIP",
            has_faithful ? "as good as faithful's end after" : "",
            uniform_method(r) == UINT32_MAX ? "" : "uniform's error / its own");
    for (uint32_t m = 0; m < r->n_methods; m++) {
        const bool is_faithful = r->methods[m].options.method == LMN_METHOD_FAITHFUL;
        struct verdict v[N_LEARN_METRICS];
        char text[24];
        for (int k = 0; k < N_LEARN_METRICS; k++) v[k] = judge(r, s, m, set, k);
        fprintf(f, "%-*s %8.5f %8.5f %8.5f  ", width, r->methods[m].label, v[0].error, v[1].error,
                v[2].error);
        for (int k = 0; k < N_LEARN_METRICS; k++) {
            format_reach(&v[k], is_faithful, text);
            fprintf(f, " %11s", has_faithful ? text : "");
        }
        fprintf(f, "  ");
        for (int k = 0; k < N_LEARN_METRICS; k++)
            if (!is_faithful && isfinite(v[k].uniform_ratio))
                fprintf(f, " %6.3f", v[k].uniform_ratio);
        fprintf(f, "\n");
    }
    fprintf(f, "%-*s %8.5f %8.5f %8.5f\n\n", width, noise_label, noise->mape, noise->relmse,
            noise->flip);
}

void learn_results_print(const struct learn_results *r, FILE *f)
{
    for (uint32_t i = 0; i < r->n_scenes; i++)
        for (int set = 0; r->scenes[i].has_curves && set < N_LEARN_SETS; set++)
            print_set(r, &r->scenes[i], set, f);
}

/* ---- Files ---------------------------------------------------------------------------------- */

static int save(const struct learn_results *r, const char *name,
                void (*write)(const struct learn_results *, FILE *))
{
    char path[LEARN_PATH], *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f) return app_error(r->app, EXIT_FAILED, "out of memory");
    write(r, f);
    learn_path(path, "%s/%s", r->args->out, name);
    int code = fclose(f) == 0 ? EXIT_OK : app_error(r->app, EXIT_FAILED, "out of memory");
    if (code == EXIT_OK) code = learn_save_text(r->app, path, text, size);
    free(text);
    return code;
}

int learn_results_save(const struct learn_results *r)
{
    const int code = save(r, "results.json", learn_results_write);
    return code == EXIT_OK ? save(r, "table.txt", learn_results_print) : code;
}
