/* SPDX-License-Identifier: Apache-2.0 */
/* Growing text, numbers, suggestions, the JSON writer (read back by jansson), error texts. */
#include "base/json.h"
#include "base/error.h" /* before cmocka.h, which has a macro fail() */

#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "cmocka_all.h"

#include "base/mem.h"
#include "base/rng.h"

static void test_str(void **state)
{
    (void)state;
    struct str s = {0};
    for (int i = 0; i < 2000; i++) str_add(&s, "%d,", i % 10);
    assert_false(s.failed);
    assert_int_equal(s.length, 4000);
    assert_int_equal(strlen(s.text), 4000);
    assert_true(memcmp(s.text + 3990, "5,6,7,8,9,", 10) == 0);
    str_add_bytes(&s, "a\0b", 3);
    assert_int_equal(s.length, 4003);
    assert_true(s.text[4001] == 0 && s.text[4002] == 'b' && s.text[4003] == 0);
    str_add(&s, "%s", "");
    assert_int_equal(s.length, 4003);
    str_release(&s);
    assert_true(!s.text && s.length == 0);

    /* after a failure the text stays as it was and nothing more is added */
    str_add(&s, "%s", "12345678");
    mem_fail_after(1);
    str_add(&s, "%0200d", 1);
    mem_fail_after(0);
    assert_true(s.failed);
    str_add(&s, "more");
    assert_string_equal(s.text, "12345678");
    str_release(&s);
}

static void test_affixes(void **state)
{
    (void)state;
    assert_true(str_starts("scene.xml", "scene") && str_starts("x", "") && str_starts("", ""));
    assert_false(str_starts("sc", "scene"));
    assert_true(str_ends("scene.xml", ".xml") && str_ends("x", "") && str_ends("", ""));
    assert_false(str_ends("xml", ".xml"));
}

static void test_to_double(void **state)
{
    (void)state;
    double v = 7;
    assert_true(str_to_double("1.5", &v) && v == 1.5);
    assert_true(str_to_double(" -2e3 ", &v) && v == -2000);
    assert_true(str_to_double("0x10", &v) && v == 16);
    assert_true(str_to_double("1e-320", &v) && v > 0);
    static const char *const bad[] = {"",    " ",    "1x",    "x1",  "1 2", "nan",
                                      "inf", "-inf", "1e999", "1,5", "--1", "."};
    v = 7;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        if (str_to_double(bad[i], &v) || v != 7) fail_msg("\"%s\" became %g", bad[i], v);
    /* a decimal comma changes nothing, where the machine has such a locale */
    setlocale(LC_ALL, "de_DE.UTF-8");
    assert_true(str_to_double("1.5", &v) && v == 1.5);
    assert_false(str_to_double("1,5", &v));
    setlocale(LC_ALL, "C");
}

static void test_closest(void **state)
{
    (void)state;
    static const char *const words[] = {"roughness", "reflectance", "radiance", "alpha",
                                        "to_world"};
    static const struct {
        const char *word, *meant;
    } cases[] = {{"roughnes", "roughness"},
                 {"Roughness", "roughness"},
                 {"raidance", "radiance"},
                 {"toworld", "to_world"},
                 {"alhpa", "alpha"},
                 {"reflectanceX", "reflectance"},
                 {"bitmap", NULL},
                 {"", NULL},
                 {"zzzzz", NULL}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *got = str_closest(cases[i].word, words, 5);
        const char *want = cases[i].meant;
        if (want ? !got || strcmp(got, want) != 0 : got != NULL)
            fail_msg("%s: meant %s, got %s", cases[i].word, want ? want : "nothing",
                     got ? got : "nothing");
    }
    assert_null(str_closest("alpha", words, 0));
    char long_word[300];
    memset(long_word, 'x', sizeof long_word);
    long_word[299] = '\0';
    assert_null(str_closest(long_word, words, 5));
}

static void test_json_document(void **state)
{
    (void)state;
    struct str s = {0};
    struct json j = {.out = &s};
    json_begin_object(&j, NULL);
    json_put_string(&j, "text", "a \"quote\", a \\, a\ttab, \x01 and \xc3\xa9");
    json_put_string(&j, "nothing", NULL);
    json_put_integer(&j, "big", INT64_MIN);
    json_put_bool(&j, "yes", true);
    json_put_bool(&j, "no", false);
    json_put_number(&j, "nan", NAN);
    json_put_number(&j, "inf", -INFINITY);
    json_put_float(&j, "tenth", 0.1f);
    json_begin_array(&j, "empty");
    json_end(&j);
    json_begin_array(&j, "nested \"key\"");
    for (int i = 0; i < 3; i++) {
        json_begin_object(&j, NULL);
        json_put_integer(&j, "i", i);
        json_end(&j);
    }
    json_put_number(&j, NULL, 0.5);
    json_end(&j);
    json_end(&j);
    assert_false(s.failed);
    assert_null(strchr(s.text, '\n')); /* one line, as metrics need */
    assert_non_null(strstr(s.text, "\"tenth\":0.1,"));

    json_error_t why;
    json_t *read = json_loads(s.text, JSON_REJECT_DUPLICATES, &why);
    if (!read) fail_msg("%s in %s", why.text, s.text);
    assert_string_equal(json_string_value(json_object_get(read, "text")),
                        "a \"quote\", a \\, a\ttab, \x01 and \xc3\xa9");
    assert_true(json_is_null(json_object_get(read, "nothing")));
    assert_true(json_integer_value(json_object_get(read, "big")) == INT64_MIN);
    assert_true(json_is_true(json_object_get(read, "yes")));
    assert_true(json_is_false(json_object_get(read, "no")));
    assert_true(json_is_null(json_object_get(read, "nan")));
    assert_true(json_is_null(json_object_get(read, "inf")));
    assert_int_equal(json_array_size(json_object_get(read, "empty")), 0);
    assert_int_equal(json_array_size(json_object_get(read, "nested \"key\"")), 4);
    json_decref(read);
    str_release(&s);
}

/* Whatever is written reads back as the same number, and shortly. */
static void test_json_numbers(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 3000; i++) {
        struct rng r = rng_keyed(5, i, 0);
        struct str s = {0};
        struct json j = {.out = &s};
        double d;
        float f;
        uint64_t bits = (uint64_t)rng_u32(&r) << 32 | rng_u32(&r);
        uint32_t bits32 = rng_u32(&r);
        memcpy(&d, &bits, 8);
        memcpy(&f, &bits32, 4);
        if (i < 4) d = (const double[]){0, -0.0, DBL_MIN / 8, DBL_MAX}[i];
        if (!isfinite(d) || !isfinite(f)) continue;
        json_put_number(&j, NULL, d);
        assert_true(strtod(s.text, NULL) == d && s.length < 26);
        size_t at = s.length + 1; /* after a comma */
        json_put_float(&j, NULL, f);
        assert_true(strtof(s.text + at, NULL) == f && s.length - at < 18);
        str_release(&s);
    }
}

static void test_fail(void **state)
{
    (void)state;
    struct error err;
    assert_int_equal((fail)(&err, LMN_ERR_PARSE, "%s:%d: bad", "x.xml", 3), LMN_ERR_PARSE);
    assert_string_equal(err.text, "x.xml:3: bad");
    assert_int_equal((fail)(NULL, LMN_ERR_IO, "nobody asked"), LMN_ERR_IO);
    assert_int_equal(fail_memory(&err, "a scene"), LMN_ERR_MEMORY);
    assert_string_equal(err.text, "not enough memory for a scene");
    assert_int_equal((fail)(&err, LMN_ERR_IO, "%02000d", 1), LMN_ERR_IO); /* cut, not overrun */
    assert_int_equal(strlen(err.text), sizeof err.text - 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_str),           cmocka_unit_test(test_affixes),
        cmocka_unit_test(test_to_double),     cmocka_unit_test(test_closest),
        cmocka_unit_test(test_json_document), cmocka_unit_test(test_json_numbers),
        cmocka_unit_test(test_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
