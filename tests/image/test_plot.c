/* SPDX-License-Identifier: Apache-2.0 */
/* Plots of training runs: what is tolerated, what is refused and where, and what is drawn. */
#include "train/plot.h"

#include <math.h>
#include <locale.h>

#include "cmocka_all.h"
#include "temp.h"

#include "base/file.h"
#include "base/mem.h"
#include "base/str.h"
#include "train/plot_data.h"

#define RUN "{\"run\":{\"variables\":[\"door\",\"a<b&\\\"c\\\"\"],\"scene\":\"x.xml\"}}\n"

/* Reads a run from text. */
static lmn_status read_text(const char *text, struct plot_run *run, struct error *err)
{
    const char *path = temp_write("run.jsonl", text, strlen(text));
    lmn_status status = plot_run_read(path, run, err);
    unlink(path);
    return status;
}

static void check_refused(const char *text, const char *message)
{
    struct plot_run run;
    struct error err = {0};
    assert_int_equal(read_text(text, &run, &err), LMN_ERR_PARSE);
    plot_run_release(&run);
    if (!strstr(err.text, message)) fail_msg("\"%s\" lacks \"%s\"", err.text, message);
    assert_true(str_starts(err.text, temp_folder));
    assert_null(strchr(err.text, '\n'));
}

static void test_reads(void **state)
{
    (void)state;
    struct plot_run run;
    struct error err = {0};
    assert_int_equal(
        read_text(RUN "{\"step\":1,\"loss\":0.5,\"fresh\":true,\"acceptance\":0.25,\"cpu_s\":2}\n"
                      "\n"
                      "{\"step\":2,\"loss\":0.25,\"fresh\":false,\"loss_fresh\":null,"
                      "\"chains\":[[0,1],[0.5,0.25]],\"eval\":{\"mape\":0.1,\"psnr\":30}}\n"
                      "{\"step\":3,\"lo",
                  &run, &err),
        LMN_OK);
    assert_int_equal(run.n_names, 2);
    assert_string_equal(run.names[0], "door");
    assert_string_equal(run.title, "x.xml");
    assert_true(run.first_step == 1 && run.last_step == 2);
    assert_int_equal(run.curves[PLOT_LOSS_FRESH_BATCH].n, 1);
    assert_int_equal(run.curves[PLOT_LOSS_REPLAYED_BATCH].n, 1);
    assert_true(run.curves[PLOT_LOSS_REPLAYED_BATCH].y[0] == 0.25);
    assert_int_equal(run.curves[PLOT_LOSS_FRESH].n, 0);
    assert_int_equal(run.curves[PLOT_MAPE].n, 1);
    assert_int_equal(run.chains[1].n, 2);
    assert_true(run.chains[1].y[1] == 0.25 && run.chains[1].x[1] == 2);
    plot_run_release(&run);
}

/* Killed after step 4, resumed from a checkpoint of step 2. */
static void test_resumed(void **state)
{
    (void)state;
    struct plot_run run;
    struct error err = {0};
    assert_int_equal(read_text(RUN "{\"step\":1,\"loss\":1}\n{\"step\":2,\"loss\":2}\n"
                                   "{\"step\":3,\"loss\":3,\"chains\":[[0,0]]}\n"
                                   "{\"step\":4,\"loss\":4}\n" RUN "{\"step\":3,\"loss\":30}\n",
                               &run, &err),
                     LMN_OK);
    const struct series *c = &run.curves[PLOT_LOSS_FRESH_BATCH];
    assert_int_equal(c->n, 3);
    assert_true(c->y[1] == 2 && c->y[2] == 30 && run.last_step == 3);
    assert_int_equal(run.chains[0].n, 0);
    plot_run_release(&run);
}

static void test_refusals(void **state)
{
    (void)state;
    check_refused("", "no training steps");
    check_refused(RUN, "no training steps");
    check_refused("{\"step\":1", "run.jsonl:1:");
    check_refused("not json\n", "run.jsonl:1:");
    check_refused(RUN "{\"step\":1}\n{\"step\":2,}\n{\"step\":3}\n", "run.jsonl:3:");
    check_refused(RUN "[1]\n", "run.jsonl:2:1: not an object");
    check_refused(RUN "{\"loss\":1}\n", "run.jsonl:2: line has no \"step\"");
    check_refused(RUN "{\"step\":\"1\"}\n", "\"step\" is not a number");
    check_refused(RUN "{\"step\":-1}\n", "line has no \"step\"");
    check_refused(RUN "{\"step\":1,\"loss\":[]}\n", "\"loss\" is not a number");
    check_refused("{\"run\":3}\n", "run.jsonl:1: \"run\" has no array \"variables\"");
    check_refused("{\"run\":{\"variables\":[3]}}\n", "variable 0 has no name");
    check_refused(RUN "{\"run\":{\"variables\":[\"x\"]}}\n", "run.jsonl:2: the run had 2");
    check_refused(RUN "{\"step\":1,\"chains\":[[0.5]]}\n", "chain 0 is not an array of 2");
    check_refused(RUN "{\"step\":1,\"chains\":[[0.5,1.5]]}\n", "of chain 0 is not in [0,1]");
    check_refused(RUN "{\"step\":1,\"chains\":3}\n", "\"chains\" is not an array");
}

static void test_thinning(void **state)
{
    (void)state;
    struct series s = {0}, thin;
    for (int i = 0; i < 5000; i++)
        assert_true(series_add(&s, i, i % 10 == 3 ? 1e6 : 2.0 * i)); /* spikes */
    assert_int_equal(series_thin(&s, 100, &thin, NULL), LMN_OK);
    assert_int_equal(thin.n, 100);
    for (size_t i = 0; i < thin.n; i++) {
        assert_true(fabs(thin.y[i] - 2 * thin.x[i]) <= 100);
        assert_true(i == 0 || thin.x[i] > thin.x[i - 1]);
    }
    series_release(&thin);
    assert_int_equal(series_thin(&s, 5000, &thin, NULL), LMN_OK);
    assert_int_equal(thin.n, 5000);
    series_release(&thin);
    series_release(&s);
    for (int i = 0; i < 300; i++) assert_true(series_add(&s, 7, i)); /* no width at all */
    assert_int_equal(series_thin(&s, 100, &thin, NULL), LMN_OK);
    assert_int_equal(thin.n, 1);
    series_release(&thin);
    series_release(&s);
}

static char *draw(const char *text, struct error *err)
{
    char svg[128], *out = NULL;
    size_t size;
    const char *path = temp_write("run.jsonl", text, strlen(text));
    snprintf(svg, sizeof svg, "%s/run.svg", temp_folder);
    if (plot_svg(&path, 1, svg, err) == LMN_OK)
        assert_int_equal(file_read(svg, 1 << 24, &out, &size, err), LMN_OK);
    unlink(svg);
    snprintf(svg, sizeof svg, "%s/run.jsonl", temp_folder);
    unlink(svg);
    return out;
}

static void test_history(void **state)
{
    (void)state;
    struct history h;
    struct plot_run run;
    char *names[] = {"door", "patch.x", "patch.y"};
    struct error err = {0};
    assert_int_equal(history_init(&h, 2, 3, &err), LMN_OK);
    assert_int_equal(plot_run_from_history(&h, names, "m.lmn", &run, &err), LMN_ERR_PARSE);
    assert_string_equal(err.text, "m.lmn: no training steps in this model");
    plot_run_release(&run);
    for (int i = 1; i <= 5000; i++) {
        double row[HISTORY_COLUMNS] = {[HISTORY_STEP] = i,
                                       [HISTORY_LOSS] = 0.5,
                                       [HISTORY_LOSS_REPLAYED] = NAN,
                                       [HISTORY_ACCEPTANCE] = 0.25};
        history_add(&h, row);
        history_add_chains(&h, (uint64_t)i - 1, (uint64_t)i,
                           (const float[]){0, 0.5f, 1, 0.1f, 0.6f, 0.9f});
    }
    assert_int_equal(plot_run_from_history(&h, names, "m.lmn", &run, &err), LMN_OK);
    assert_true(run.n_names == 3 && strcmp(run.names[2], "patch.y") == 0);
    assert_true(run.first_step >= 1 && run.last_step > 4900 && run.last_step <= 5000);
    assert_true(run.curves[PLOT_LOSS_ALL].n > 1000 && run.curves[PLOT_LOSS_ALL].y[7] == 0.5);
    assert_int_equal(run.curves[PLOT_LOSS_REPLAYED].n, 0);
    assert_true(run.chains[1].n > 100 && run.chains[1].y[0] == 0.5);
    assert_true(run.chains[1].y[1] == (double)0.6f && run.chains[2].y[0] == 1);
    plot_run_release(&run);
    history_release(&h);
}

/* Every tag that opens closes. */
static void check_tags(const char *svg)
{
    int depth = 0;
    for (const char *c = svg; (c = strchr(c, '<')); c++) {
        const char *end = strchr(c, '>');
        assert_non_null(end);
        if (c[1] == '/')
            depth--;
        else if (end[-1] != '/')
            depth++;
        assert_true(depth > 0 || str_starts(c, "</svg>"));
    }
    assert_int_equal(depth, 0);
}

static void test_draws(void **state)
{
    (void)state;
    struct error err = {0};
    struct str text = {0};
    str_add(&text, RUN);
    for (int i = 1; i <= 3000; i++)
        str_add(&text,
                "{\"step\":%d,\"loss\":0.%d,\"fresh\":%s,\"acceptance\":0.5,\"cpu_s\":%d,"
                "\"chains\":[[0.1,0.%d],[1,0]]%s}\n",
                i, 1 + i % 9, i % 3 ? "true" : "false", i, i % 10,
                i % 1000 ? "" : ",\"eval\":{\"mape\":0.1,\"flip\":1e-9,\"dssim\":0}");
    setlocale(LC_ALL, "de_DE.UTF-8"); /* a decimal comma, where there is this locale */
    char *svg = draw(text.text, &err);
    if (!svg) fail_msg("%s", err.text);
    assert_true(str_starts(svg, "<svg "));
    check_tags(svg);
    assert_non_null(strstr(svg, "a&lt;b&amp;&quot;c&quot;"));
    static const char *const panels[] = {"Loss",        "Exploration",
                                         "Error on",    "Where the chains are",
                                         "MAPE 0.1000", "3000 steps in 50 min"};
    for (size_t i = 0; i < sizeof panels / sizeof *panels; i++)
        assert_non_null(strstr(svg, panels[i]));
    assert_null(strstr(svg, "nan"));
    assert_null(strstr(svg, "inf"));
    assert_true(strlen(svg) < 300000);
    mem_free(svg);
    str_release(&text);
}

/* Numbers at the ends of what a double can hold still draw something. */
static void test_extremes(void **state)
{
    (void)state;
    static const char *const runs[] = {
        "{\"step\":0,\"loss\":0}\n",
        "{\"step\":1,\"loss\":1e308,\"cpu_s\":1e308}\n{\"step\":2,\"loss\":1e-308}\n",
        "{\"step\":1,\"loss\":-1,\"acceptance\":-1e300}\n{\"step\":1e15,\"loss\":1e-300}\n",
        "{\"step\":0.1,\"loss\":1}\n{\"step\":0.2,\"loss\":1.0000000001}\n",
        "{\"step\":5,\"eval\":{\"mape\":1e300}}\n{\"step\":5,\"cpu_s\":-3}\n",
    };
    for (size_t i = 0; i < sizeof runs / sizeof *runs; i++) {
        struct error err = {0};
        char *svg = draw(runs[i], &err);
        if (!svg) fail_msg("run %zu: %s", i, err.text);
        check_tags(svg);
        assert_null(strstr(svg, "nan"));
        assert_null(strstr(svg, "inf"));
        assert_true(strlen(svg) < 30000);
        mem_free(svg);
    }
}

/* How often a text occurs. */
static int count(const char *text, const char *what)
{
    int n = 0;
    for (; (text = strstr(text, what)); text += strlen(what)) n++;
    return n;
}

/* Draws two runs over each other. */
static char *compare(const char *a, const char *b, struct error *err)
{
    char path_a[128], path_b[128], svg[128], *out = NULL;
    size_t size;
    snprintf(path_a, sizeof path_a, "%s", temp_write("a.metrics.jsonl", a, strlen(a)));
    snprintf(path_b, sizeof path_b, "%s", temp_write("b<1.jsonl", b, strlen(b)));
    snprintf(svg, sizeof svg, "%s/ab.svg", temp_folder);
    if (plot_svg((const char *[]){path_a, path_b}, 2, svg, err) == LMN_OK)
        assert_int_equal(file_read(svg, 1 << 24, &out, &size, err), LMN_OK);
    unlink(svg);
    unlink(path_a);
    unlink(path_b);
    return out;
}

static void test_compares(void **state)
{
    (void)state;
    static const char *const panels[] = {"MAPE on",  "relMSE on", "FLIP on",   "Loss of fresh",
                                         "Share of", ">Steps<",   ">a</text>", ">b&lt;1</text>"};
    struct error err = {0};
    struct str a = {0}, b = {0};
    for (int i = 1; i <= 400; i++) {
        const char *eval = i % 100 ? "" : ",\"eval\":{\"mape\":0.5,\"relmse\":0.2,\"flip\":0.1}";
        str_add(&a, "{\"step\":%d,\"loss\":1,\"fresh\":%s,\"loss_fresh\":0.5,\"cpu_s\":%d%s}\n", i,
                i % 4 ? "false" : "true", i, eval);
        str_add(&b, "{\"step\":%d,\"loss\":1,\"fresh\":true,\"loss_fresh\":0.7,\"cpu_s\":%d%s}\n",
                i, i * 2, eval);
    }
    char *svg = compare(a.text, b.text, &err);
    if (!svg) fail_msg("%s", err.text);
    check_tags(svg);
    for (size_t i = 0; i < sizeof panels / sizeof *panels; i++)
        if (!strstr(svg, panels[i])) fail_msg("no %s", panels[i]);
    assert_int_equal(count(svg, "stroke-dasharray"), 7); /* b's: its legend and six panels */
    assert_int_equal(count(svg, "<circle"), 2 * 3 * 4);
    /* a took 400 of 800 s: its last MAPE is in the middle, b's first of four at a quarter */
    assert_non_null(strstr(svg, "fill=\"#0072b2\" cx=\"540.0\""));
    assert_non_null(strstr(svg, "fill=\"#d55e00\" cx=\"345.0\""));
    assert_null(strstr(svg, "nan"));
    mem_free(svg);

    svg = compare(a.text, "{\"step\":800,\"loss_fresh\":1}\n", &err); /* no times: over steps */
    assert_non_null(svg);
    assert_non_null(strstr(svg, "over steps, as not all"));
    assert_null(strstr(svg, ">Steps<"));
    assert_non_null(strstr(svg, "fill=\"#0072b2\" cx=\"540.0\""));
    mem_free(svg);

    svg = compare("{\"step\":1,\"cpu_s\":1e308,\"eval\":{\"mape\":1.7e308,\"flip\":1.7e308}}\n",
                  "{\"step\":0,\"cpu_s\":-1e308,\"eval\":{\"relmse\":1e-320,\"flip\":-1}}\n", &err);
    assert_non_null(svg);
    check_tags(svg);
    assert_null(strstr(svg, "nan"));
    assert_true(strlen(svg) < 30000);
    mem_free(svg);

    assert_null(compare(a.text, "{\"step\":1}\n[1]\n", &err));
    assert_non_null(strstr(err.text, "b<1.jsonl:2:1: not an object"));
    assert_int_equal(plot_svg(NULL, 0, "-", &err), LMN_ERR_ARGUMENT);
    str_release(&a);
    str_release(&b);
}

/* Short memory anywhere is an error without a leak or a file; n_runs of the same log. */
static void check_memory(uint32_t n_runs)
{
    const char *text = RUN "{\"step\":1,\"loss\":1,\"cpu_s\":1,\"chains\":[[0,0],[1,1]],"
                           "\"eval\":{\"flip\":1}}\n";
    char svg[128], jsonl[128];
    snprintf(svg, sizeof svg, "%s/run.svg", temp_folder);
    snprintf(jsonl, sizeof jsonl, "%s", temp_write("run.jsonl", text, strlen(text)));
    lmn_status status = LMN_ERR_MEMORY;
    for (uint64_t n = 1; status != LMN_OK && n < 1000; n++) {
        struct error err = {0};
        mem_fail_after(n);
        status = plot_svg((const char *[]){jsonl, jsonl}, n_runs, svg, &err);
        mem_fail_after(0);
        if (status != LMN_OK) {
            assert_int_equal(status, LMN_ERR_MEMORY);
            assert_int_not_equal(access(svg, F_OK), 0);
        }
    }
    assert_int_equal(status, LMN_OK);
    unlink(svg);
    unlink(jsonl);
}

static void test_memory(void **state)
{
    (void)state;
    check_memory(1);
    check_memory(2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reads),    cmocka_unit_test(test_resumed),
        cmocka_unit_test(test_refusals), cmocka_unit_test(test_thinning),
        cmocka_unit_test(test_draws),    cmocka_unit_test(test_extremes),
        cmocka_unit_test(test_compares), cmocka_unit_test(test_memory),
        cmocka_unit_test(test_history),
    };
    return cmocka_run_group_tests(tests, temp_setup, temp_teardown);
}
