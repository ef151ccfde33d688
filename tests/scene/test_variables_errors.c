/* SPDX-License-Identifier: Apache-2.0 */
#include "variables_text.h"

#include "base/rng.h"
#include "base/str.h"

/* What is wrong with a file of variables is said in one line with its place; nothing that a file
 * holds crashes or leaks. */

static int n_wrong;

/* Loading fails with a message that ends in `message`, after "FILE:". */
static void refuse(const char *variables, const char *message)
{
    struct scene *s;
    struct error err;
    lmn_status status = text_load_variables(variables, &s, &err);
    if (status != LMN_ERR_PARSE) fail_msg("status %d for %s", status, variables);
    assert_null(s);
    if (!str_ends(err.text, message)) {
        print_error("\"%s\" instead of \"%s\"\n", err.text, message);
        n_wrong++;
    }
    assert_non_null(strstr(err.text, "s.variables.json:"));
    assert_null(strchr(err.text, '\n'));
}

static void tells_what_is_wrong(void **unused)
{
    static const struct {
        const char *variables, *message;
    } cases[] = {
        /* the file */
        {"{", ":3:1: string or '}' expected near ']'"},
        {"{\"name\": \"a\", \"name\": \"b\"}", ":2:20: duplicate object key near '\"name\"'"},
        {"3", ":2:1: variables[0]: a variable must be an object {\"name\": ..., \"kind\": ...}"},
        {"{}", ":2:1: variables[0].kind: a string is missing here"},
        {"{\"kind\": 3}", ":2:10: variables[0].kind: this must be a string"},
        {"{\"kind\": \"rotat\"}",
         ":2:10: variables[0].kind: there is no kind \"rotat\"; did you mean \"rotate\"?"},
        {"{\"kind\": \"colour\"}",
         ":2:10: variables[0].kind: there is no kind \"colour\"; did you mean \"color\"?"},
        {"{\"kind\": \"visible\", \"target\": \"box\"}",
         ":2:31: variables[0].target: unknown key; did you mean \"targets\"?"},
        {"{\"kind\": \"visible\", \"range\": [0, 1]}", ":2:30: variables[0].range: unknown key"},
        /* names */
        {"{\"kind\": \"visible\", \"targets\": \"box\"}",
         ":2:1: variables[0].name: a string is missing here"},
        {"{\"kind\": \"visible\", \"name\": \"a b\", \"targets\": \"box\"}",
         ":2:29: \"a b\" is no name for a variable: it must not be empty or hold spaces, \"=\" or "
         "\",\""},
        {"{\"kind\": \"visible\", \"name\": \"\", \"targets\": \"box\"}",
         ":2:29: \"\" is no name for a variable: it must not be empty or hold spaces, \"=\" or "
         "\",\""},
        {"{\"kind\": \"visible\", \"name\": \"a=b\", \"targets\": \"box\"}",
         ":2:29: \"a=b\" is no name for a variable: it must not be empty or hold spaces, \"=\" or "
         "\",\""},
        {"{\"kind\": \"visible\", \"name\": \"a\", \"targets\": \"box\"},\n"
         "{\"kind\": \"visible\", \"name\": \"a\", \"targets\": \"ball\"}",
         ":3:29: variables[1].name: there is a variable \"a\" already"},
        {"{\"kind\": \"visible\", \"name\": \"c.r\", \"targets\": \"box\"},\n"
         "{\"kind\": \"color\", \"name\": \"c\", \"targets\": \"wall.reflectance\","
         " \"range\": [0, 1]}",
         ":3:27: there is a variable \"c.r\" already"},
        /* targets */
        {"{\"kind\": \"visible\", \"name\": \"a\"}",
         ":2:1: variables[0].targets: a string is missing here"},
        {"{\"kind\": \"visible\", \"name\": \"a\", \"targets\": []}",
         ":2:45: variables[0].targets: there must be 1 to 1024 targets"},
        {"{\"kind\": \"visible\", \"name\": \"a\", \"targets\": [\"box\", 3]}",
         ":2:53: variables[0].targets[1]: this must be a string"},
        {"{\"kind\": \"visible\", \"name\": \"a\", \"targets\": \"boxx\"}",
         ":2:45: variables[0].targets: the scene has no \"boxx\"; did you mean \"box\"?"},
        {"{\"kind\": \"float\", \"name\": \"a\", \"targets\": \"glas.alpha\", \"range\": [0, 1]}",
         ":2:43: variables[0].targets: the scene has no \"glas.alpha\"; did you mean "
         "\"glass.alpha\"?"},
        {"{\"kind\": \"visible\", \"name\": \"a\", \"targets\": \"quite something else\"}",
         ":2:45: variables[0].targets: the scene has no \"quite something else\""},
        {"{\"kind\": \"float\", \"name\": \"a\", \"targets\": \"box.to_world\", \"range\": [0, 1]}",
         ":2:43: variables[0].targets: \"box.to_world\" is a transform, but the kind \"float\" "
         "drives a float"},
        {"{\"kind\": \"color\", \"name\": \"a\", \"targets\": \"glass.alpha\", \"range\": [0, 1]}",
         ":2:43: variables[0].targets: \"glass.alpha\" is a float, but the kind \"color\" drives a "
         "rgb"},
        {"{\"kind\": \"visible\", \"name\": \"a\", \"targets\": [\"box\", \"box\"]}",
         ":2:29: \"box.visible\" is given twice"},
        {"{\"kind\": \"float\", \"name\": \"a\", \"targets\": \"cam.fov\", \"range\": [20, 30]},\n"
         "{\"kind\": \"float\", \"name\": \"b\", \"targets\": \"cam.fov\", \"range\": [20, 30]}",
         ":3:27: \"cam.fov\" is driven by the variable \"a\" already"},
        {"{\"kind\": \"camera\", \"name\": \"a\", \"target\": [0, 0, 0],"
         " \"origin\": {\"min\": [0, 0, 1], \"max\": [0, 0, 2]}},\n"
         "{\"kind\": \"translate\", \"name\": \"b\", \"targets\": \"cam\","
         " \"direction\": [0, 0, 1], \"range\": [0, 1]}",
         ":3:31: \"cam.to_world\" is driven by the variable \"a\" already"},
        /* ranges */
        {"{\"kind\": \"float\", \"name\": \"a\", \"targets\": \"cam.fov\"}",
         ":2:1: variables[0].range: a range [min, max] is missing here"},
        {"{\"kind\": \"float\", \"name\": \"a\", \"targets\": \"cam.fov\", \"range\": [30]}",
         ":2:63: variables[0].range: this must be a range [min, max]"},
        {"{\"kind\": \"float\", \"name\": \"a\", \"targets\": \"cam.fov\", \"range\": [30, \"x\"]}",
         ":2:68: variables[0].range[1]: this must be a number"},
        {"{\"kind\": \"float\", \"name\": \"a\", \"targets\": \"cam.fov\", \"range\": [30, 30]}",
         ":2:63: variables[0].range: min 30 is not below max 30"},
        {"{\"kind\": \"float\", \"name\": \"a\", \"targets\": \"cam.fov\", \"range\": [30, 1e300]}",
         ":2:68: variables[0].range[1]: 1e+300 is too large"},
        {"{\"kind\": \"float\", \"name\": \"a\", \"targets\": \"cam.fov\", \"range\": [20, 180]}",
         ":2:63: variables[0].range: \"cam.fov\" can only be from 0.01 to 179.9"},
        {"{\"kind\": \"float\", \"name\": \"a\", \"targets\": \"glass.alpha\", \"range\": [0, 1]}",
         ":2:67: variables[0].range: \"glass.alpha.value\" can only be from 0.0001 to 1"},
        {"{\"kind\": \"color\", \"name\": \"a\", \"targets\": \"wall.reflectance\","
         " \"range\": {\"min\": [0, 0, 0], \"max\": [1, 2, 1]}}",
         ":2:72: variables[0].range: \"wall.reflectance.value\" can only be from 0 to 1"},
        {"{\"kind\": \"translate\", \"name\": \"a\", \"targets\": \"box\", \"range\": [0, 1]}",
         ":2:63: variables[0].range: this must be a box {\"min\": [x, y, z], \"max\": [x, y, z]}"},
        {"{\"kind\": \"translate\", \"name\": \"a\", \"targets\": \"box\","
         " \"range\": {\"min\": [0, 0], \"max\": [1, 1, 1]}}",
         ":2:71: variables[0].range.min: this must be 3 numbers in brackets"},
        {"{\"kind\": \"translate\", \"name\": \"a\", \"targets\": \"box\","
         " \"range\": {\"min\": [0, 0, 0]}}",
         ":2:63: variables[0].range.max: 3 numbers in brackets are missing here"},
        {"{\"kind\": \"translate\", \"name\": \"a\", \"targets\": \"box\","
         " \"range\": {\"min\": [0, 5, 0], \"max\": [1, 1, 1]}}",
         ":2:63: variables[0].range: min 5 is above max 1 in component y"},
        {"{\"kind\": \"translate\", \"name\": \"a\", \"targets\": \"box\","
         " \"range\": {\"min\": [0, 5, 0], \"max\": [0, 5, 0]}}",
         ":2:63: variables[0].range: nothing varies: min and max are equal in every component"},
        {"{\"kind\": \"scale\", \"name\": \"a\", \"targets\": \"box\", \"range\": [0, 1]}",
         ":2:59: variables[0].range: a scale must be positive"},
        {"{\"kind\": \"intensity\", \"name\": \"a\", \"targets\": \"light\", \"range\": [-1, 1]}",
         ":2:65: variables[0].range: light cannot be negative"},
        {"{\"kind\": \"intensity\", \"name\": \"a\", \"targets\": \"cam.fov\", \"range\": [0, 1]}",
         ":2:47: variables[0].targets: \"cam.fov\" is not the scale of an emitter"},
        {"{\"kind\": \"envmap\", \"name\": \"a\", \"targets\": \"box\", \"range\": [0, 1]}",
         ":2:44: variables[0].targets: \"box.to_world\" is not an envmap's"},
        {"{\"kind\": \"rotate\", \"name\": \"a\", \"targets\": \"box\", \"range\": [0, 1]}",
         ":2:1: variables[0].axis: 3 numbers in brackets are missing here"},
        {"{\"kind\": \"rotate\", \"name\": \"a\", \"targets\": \"box\", \"range\": [0, 1],"
         " \"axis\": [0, 0, 0]}",
         ":2:76: variables[0].axis: this has no direction"},
        {"{\"kind\": \"color\", \"name\": \"a\", \"targets\": \"wall.reflectance\","
         " \"from\": [0, 0, 0]}",
         ":2:1: variables[0].to: 3 numbers in brackets are missing here"},
        {"{\"kind\": \"color\", \"name\": \"a\", \"targets\": \"wall.reflectance\","
         " \"from\": [0, 0, 0], \"to\": [1, 1, 1], \"range\": [0, 1]}",
         ":2:108: variables[0].range: a colour has either a range, or from and to"},
        /* defaults */
        {"{\"kind\": \"float\", \"name\": \"a\", \"targets\": \"cam.fov\", \"range\": [20, 30],"
         " \"default\": 31}",
         ":2:84: variables[0].default: 31 is not within the range 20 to 30"},
        {"{\"kind\": \"color\", \"name\": \"a\", \"targets\": \"wall.reflectance\","
         " \"range\": [0, 1], \"default\": [0, 2, 0]}",
         ":2:95: variables[0].default[1]: 2 is not within the range 0 to 1"},
        {"{\"kind\": \"translate\", \"name\": \"a\", \"targets\": \"box\", \"default\": [0, 0, 1],"
         " \"range\": {\"min\": [0, 0, 0], \"max\": [1, 0, 0]}}",
         ":2:72: variables[0].default[2]: this component does not vary: it is 0"},
        {"{\"kind\": \"visible\", \"name\": \"a\", \"targets\": \"box\", \"default\": 1}",
         ":2:63: variables[0].default: this must be true or false"},
        {"{\"kind\": \"camera\", \"name\": \"a\", \"target\": [0, 0, 0], \"default\": {\"orign\": "
         "3},"
         " \"origin\": {\"min\": [0, 0, 1], \"max\": [0, 0, 2]}}",
         ":2:75: variables[0].default.orign: unknown key; did you mean \"origin\"?"},
        /* choices */
        {"{\"kind\": \"choice\", \"name\": \"a\", \"choices\": [\"box\"]}",
         ":2:44: variables[0].choices: this must be a list of 2 to 4096 choices"},
        {"{\"kind\": \"choice\", \"name\": \"a\", \"choices\": [\"box\", \"box\"]}",
         ":2:52: variables[0].choices[1]: the choice \"box\" is given twice"},
        {"{\"kind\": \"choice\", \"name\": \"a\", \"choices\": [\"box\", \"bal\"]}",
         ":2:52: variables[0].choices[1]: the scene has no shape \"bal\"; did you mean \"ball\"?"},
        {"{\"kind\": \"choice\", \"name\": \"a\", \"choices\": [\"box\", \"glass\"]}",
         ":2:52: variables[0].choices[1]: \"glass\" is not a shape or an instance"},
        {"{\"kind\": \"choice\", \"name\": \"a\", \"choices\": [\"box\", {\"name\": \"x\","
         " \"shapes\": [\"ball\", \"box\"]}]}",
         ":2:85: variables[0].choices[1].shapes[1]: \"box\" is in two choices"},
        {"{\"kind\": \"choice\", \"name\": \"a\", \"targets\": \"box.bsdf\","
         " \"choices\": [\"wall\", \"tiles\"]}",
         ":2:76: variables[0].choices[1]: \"tiles\" is not a bsdf"},
        {"{\"kind\": \"choice\", \"name\": \"a\", \"targets\": \"wall.reflectance\","
         " \"choices\": [\"stripes\", \"tile\"]}",
         ":2:87: variables[0].choices[1]: the scene has no texture \"tile\"; did you mean "
         "\"tiles\"?"},
        {"{\"kind\": \"choice\", \"name\": \"a\", \"choices\": [\"box\", \"ball\"],"
         " \"default\": \"bull\"}",
         ":2:72: variables[0].default: \"bull\" is not among the choices; did you mean \"ball\"?"},
    };
    (void)unused;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        refuse(cases[i].variables, cases[i].message);
    assert_int_equal(n_wrong, 0);
}

static void tells_what_the_file_lacks(void **unused)
{
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"", "w.json:1:1: '[' or '{' expected near end of file"},
        {"[]", "w.json:1:1: this must be an object {\"variables\": [...]}"},
        {"{}", "w.json:1:1: variables: a list is missing here"},
        {"{\"variables\": {}}", "w.json:1:15: variables: this must be a list"},
        {"{\"variable\": []}", "w.json:1:14: variable: unknown key; did you mean \"variables\"?"},
        {"{\"variables\": []} x", "w.json:1:19: end of file expected near 'x'"},
    };
    (void)unused;
    text_write_string("w.xml", "<scene version='3.0.0'>" TEXT_SENSOR "</scene>");
    char path[256];
    snprintf(path, sizeof path, "%s", text_path("w.json"));
    struct scene_load_options options = {.variables_path = path};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene *s = NULL;
        struct error err = {{0}};
        text_write_string("w.json", cases[i].text);
        assert_int_equal(scene_load(text_path("w.xml"), &options, &s, &err), LMN_ERR_PARSE);
        assert_null(s);
        if (!str_ends(err.text, cases[i].message))
            fail_msg("\"%s\" instead of \"%s\"", err.text, cases[i].message);
    }
    struct scene *s = NULL;
    struct error err = {{0}};
    options.variables_path = "/nonexistent/v.json";
    assert_int_equal(scene_load(text_path("w.xml"), &options, &s, &err), LMN_ERR_IO);
    assert_non_null(strstr(err.text, "/nonexistent/v.json"));
}

static void refuses_too_many(void **unused)
{
    char text[40000], *end = text;
    (void)unused;
    for (int i = 0; i < 257; i++)
        end += sprintf(end,
                       "%s{\"kind\": \"translate\", \"name\": \"v%d\", \"targets\": \"box\","
                       " \"direction\": [0, 0, 1], \"range\": [0, 1]}",
                       i ? ",\n" : "", i);
    n_wrong = 0;
    refuse(text, ":258:31: more than 256 variables");
    assert_int_equal(n_wrong, 0);
}

/* ---- Hostile files
 * ------------------------------------------------------------------------------- */

static const char seed[] =
    "{\"name\": \"k\", \"kind\": \"scale\", \"targets\": \"one\", \"range\": [1, 2]},\n"
    "{\"name\": \"t\", \"kind\": \"translate\", \"targets\": [\"one\", \"ball\"],"
    " \"range\": {\"min\": [-1, -1, -1], \"max\": [1, 1, 1]}, \"default\": [0, 0.5, 0]},\n"
    "{\"name\": \"r\", \"kind\": \"rotate\", \"targets\": \"part\", \"axis\": [1, 2, 3],"
    " \"pivot\": [0, 0, 1], \"range\": [-90, 270]},\n"
    "{\"name\": \"c\", \"kind\": \"color\", \"targets\": \"wall.reflectance\", \"range\": [0, "
    "1]},\n"
    "{\"name\": \"d\", \"kind\": \"color\", \"targets\": \"tiles.color1\", \"from\": [0, 0, 0],"
    " \"to\": [1, 1, 1]},\n"
    "{\"name\": \"f\", \"kind\": \"float\", \"targets\": \"glass.alpha\", \"range\": [0.1, 0.6]},\n"
    "{\"name\": \"i\", \"kind\": \"intensity\", \"targets\": \"light\", \"range\": [0, 3]},\n"
    "{\"name\": \"e\", \"kind\": \"envmap\", \"range\": [0, 360], \"unit\": \"deg\"},\n"
    "{\"name\": \"m\", \"kind\": \"choice\", \"targets\": \"box\","
    " \"choices\": [\"metal\", \"glass\", \"wall\"], \"default\": \"wall\"},\n"
    "{\"name\": \"h\", \"kind\": \"choice\", \"choices\": [\"floor\", {\"name\": \"none\","
    " \"shapes\": []}]},\n"
    "{\"name\": \"v\", \"kind\": \"visible\", \"targets\": \"part\", \"default\": false},\n"
    "{\"name\": \"w\", \"kind\": \"camera\", \"target\": [0, 1, 0], \"up\": [0, 1, 0],"
    " \"origin\": {\"min\": [-1, 1, 4], \"max\": [1, 1, 6]}}";

/* Changes bytes, or replaces a token by another. */
static void mutate(char *text, size_t capacity, struct rng *rng)
{
    static const char *const tokens[] = {
        "null",      "true",        "[]",    "{}",          "\"\"",      "-1e308",
        "1e30",      "0",           "-0.0",  "[0, 0]",      "[1, 2, 3]", "\"box\"",
        "\"box.b\"", "1e-320",      "12345", "\"\\u0007\"", "[[[]]]",    "\"one.to_world\"",
        "\"range\"", "\"targets\"", ",",     ":",           "]",         "}",
    };
    uint32_t n = 1 + rng_below(rng, 8) / 6;
    for (uint32_t k = 0; k < n; k++) {
        size_t size = strlen(text), at = rng_below(rng, (uint32_t)size);
        if (rng_below(rng, 4) == 0) {
            static const char bytes[] = "\"{}[],:0-e.\\a \xff\xc3";
            text[at] = bytes[rng_below(rng, sizeof bytes - 1)];
            continue;
        }
        size_t from = at, to;
        while (from < size && !strchr("\"[0123456789-", text[from])) from++;
        if (from == size) continue;
        to = from + 1;
        while (to < size && !strchr(text[from] == '"' ? "\"" : ",]}", text[to])) to++;
        if (text[from] == '"' && to < size) to++;
        static const char *const numbers[] = {"-1e30", "0", "0.3", "0.31", "1e-30", "1.5"};
        const char *token = tokens[rng_below(rng, sizeof tokens / sizeof *tokens)];
        if (text[from] != '"' && text[from] != '[' && rng_below(rng, 4))
            token = numbers[rng_below(rng, 6)];
        size_t length = strlen(token);
        if (size - (to - from) + length + 1 > capacity) continue;
        memmove(text + from + length, text + to, size - to + 1);
        memcpy(text + from, token, length);
    }
}

static void survives_damage(void **unused)
{
    char text[4096];
    uint32_t n_loaded = 0;
    (void)unused;
    scene_free(text_variables(seed));
    for (uint32_t i = 0; i < 1500; i++) {
        struct rng rng = rng_keyed(7, i, 0);
        struct scene *s;
        struct error err;
        memcpy(text, seed, sizeof seed);
        mutate(text, sizeof text, &rng);
        if (text_load_variables(text, &s, &err) != LMN_OK) {
            assert_null(s);
            assert_true(strlen(err.text) > 0);
            assert_null(strchr(err.text, '\n'));
            continue;
        }
        struct scene_state state = text_state(s);
        float u[256];
        for (uint32_t k = 0; k < s->n_variables; k++) {
            const struct variable *v = &s->variables[k];
            assert_true(v->value >= v->min && v->value <= v->max);
            u[k] = rng_float(&rng);
        }
        scene_apply(s, u, &state);
        scene_state_release(&state);
        scene_free(s);
        n_loaded++;
    }
    printf("%u of 1500 damaged files still loaded\n", n_loaded);
}

static void survives_short_memory(void **unused)
{
    lmn_status status = LMN_ERR_MEMORY;
    uint64_t n = 0;
    (void)unused;
    scene_free(text_variables(seed));
    while (status != LMN_OK) {
        struct scene *s;
        struct error err;
        mem_fail_after(++n);
        status = text_load_file("s.xml", NULL, &s, &err);
        mem_fail_after(0);
        if (status == LMN_OK)
            scene_free(s);
        else if (status != LMN_ERR_MEMORY)
            fail_msg("%d: %s", status, err.text);
        assert_true(n < 10000);
    }
    assert_true(n > 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tells_what_is_wrong),   cmocka_unit_test(tells_what_the_file_lacks),
        cmocka_unit_test(refuses_too_many),      cmocka_unit_test(survives_damage),
        cmocka_unit_test(survives_short_memory),
    };
    return cmocka_run_group_tests_name("variables: errors", tests, text_setup, text_teardown);
}
