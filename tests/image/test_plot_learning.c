/* SPDX-License-Identifier: Apache-2.0 */
/* Plots of bench learn: what is drawn of results.json, and what is refused. */
#include "train/plot_learning.h"

#include "cmocka_all.h"
#include "temp.h"

#include "base/file.h"
#include "base/mem.h"
#include "base/str.h"

#define NOISE            "\"noise\":{\"uniform\":{\"mape\":0.01},\"hard\":{\"mape\":0.02}}"
#define UNIFORM(e)       "\"uniform\":{\"mape\":" #e ",\"relmse\":" #e ",\"flip\":" #e "}"
#define HARD(e)          "\"hard\":{\"mape\":" #e ",\"relmse\":1e300,\"flip\":0}"
#define AT(time, e)      "{\"cpu_s\":" #time "," UNIFORM(e) "," HARD(e) "}"
#define RUN(method, ...) "{\"method\":\"" method "\",\"evaluations\":[" __VA_ARGS__ "]}"
#define METHOD(m)        "{\"method\":\"" m "\"}"
#define METHODS          "\"methods\":[" METHOD("a<b&c") "," METHOD("b") "," METHOD("none") "]"
#define FIRST            "{" METHODS ",\"scenes\":[{\"name\":\"other\"},{\"name\":\"x\"," NOISE
#define SCENE(runs)      FIRST ",\"runs\":[" runs "]}]}"

static lmn_status draw(const char *text, const char *scene, char **svg, struct error *err)
{
    const char *path = temp_write("results.json", text, strlen(text));
    struct str out = {0};
    size_t size;
    str_add(&out, "%s/x.svg", temp_folder);
    *svg = NULL;
    lmn_status status = plot_learning_svg(path, scene, out.text, err);
    if (status == LMN_OK) assert_int_equal(file_read(out.text, 1 << 20, svg, &size, err), LMN_OK);
    unlink(path);
    unlink(out.text);
    str_release(&out);
    return status;
}

static size_t count(const char *text, const char *piece)
{
    size_t n = 0;
    while ((text = strstr(text, piece))) text += strlen(piece), n++;
    return n;
}

static void test_draws(void **state)
{
    (void)state;
    struct error err = {0};
    char *svg;
    assert_int_equal(draw(SCENE(RUN("a<b&c", AT(1, 0.5) "," AT(2, 0.25) "," AT(4, 0.125)) "," RUN(
                              "b", AT(1, 0.5) "," AT(2, 0.2)) "," RUN("b", AT(1, 0.6))),
                          "x", &svg, &err),
                     LMN_OK);
    assert_non_null(strstr(svg, "a&lt;b&amp;c"));
    assert_null(strstr(svg, "nan"));
    assert_null(strstr(svg, "inf"));
    assert_int_equal(count(svg, "configurations</text>"), 6);
    /* bands where there are two points: of a only, as one of b's seeds has one */
    assert_int_equal(count(svg, "opacity=\"0.15\""), 6);
    assert_int_equal(count(svg, "stroke-dasharray=\"3 4\""), 2); /* the noise, where it is told */
    mem_free(svg);
    /* nothing yet, and a scene without anything */
    assert_int_equal(draw(SCENE(RUN("b", "")), "x", &svg, &err), LMN_OK);
    mem_free(svg);
    assert_int_equal(draw(SCENE(""), "other", &svg, &err), LMN_OK);
    mem_free(svg);
}

static void test_strange(void **state)
{
    static const char *const good[] = {
        "{\"scenes\":[{\"name\":\"x\"}]}",
        "{\"methods\":7,\"scenes\":[3,{\"name\":4},{\"name\":\"x\",\"runs\":{}}]}",
        SCENE("5,{\"method\":\"b\"},{\"method\":\"b\",\"evaluations\":[null,1]}"),
        SCENE(RUN("b", "{\"cpu_s\":-1},{\"cpu_s\":\"x\",\"uniform\":[]}")),
        SCENE(RUN("b", AT(2, 1e-300) "," AT(1, -5))),
    };
    static const char *const bad[] = {"", "[]", "{", "{\"scenes\":{}}", "{\"scenes\":[]}", "\"x\""};
    (void)state;
    char *svg;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        struct error err = {0};
        assert_int_equal(draw(good[i], "x", &svg, &err), LMN_OK);
        mem_free(svg);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct error err = {0};
        assert_int_not_equal(draw(bad[i], "x", &svg, &err), LMN_OK);
        assert_true(str_starts(err.text, temp_folder));
        assert_null(strchr(err.text, '\n'));
    }
    struct error err = {0};
    assert_int_equal(plot_learning_svg("/nowhere/results.json", "x", "/nowhere/x.svg", &err),
                     LMN_ERR_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_draws),
                                       cmocka_unit_test(test_strange)};
    return cmocka_run_group_tests(tests, temp_setup, temp_teardown);
}
