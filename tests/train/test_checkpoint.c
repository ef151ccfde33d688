/* SPDX-License-Identifier: Apache-2.0 */
#include <dirent.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

#include "base/mem.h"
#include "base/rng.h"
#include "tiny.h"
#include "train/checkpoint.h"
#include "train/model.h"
#include "train/model_file.h"

/* cmocka last: it makes fail() a macro. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

/* A checkpoint after 12 steps, at tiny_path("good.lmn"), and the bytes of its state, which holds
 * all that the model does and more. */
static char *good;
static size_t good_size, header_size;

static void must(lmn_status status, const struct error *err)
{
    if (status != LMN_OK) fail_msg("%s", err->text);
}

static int setup(void **state)
{
    (void)state;
    struct error err = {0};
    struct trainer *t = NULL;
    lmn_train_options o = tiny_options();
    tiny_init(&tiny, 2);
    tiny.place.variables_path = "v.json";
    tiny.place.defines = (const char *const[]){"a=1", "b=\"two\""};
    tiny.place.n_defines = 2;
    if (trainer_new(&tiny.place, &o, &t, &err) != LMN_OK) return -1;
    for (int i = 0; i < 12; i++)
        if (trainer_step(t, NULL, &err) != LMN_OK) return -1;
    if (trainer_save(t, tiny_path(&tiny, "good.lmn"), &err) != LMN_OK) return -1;
    trainer_free(t);
    tiny.place.defines = NULL;
    tiny.place.n_defines = 0;
    good = tiny_read(tiny_path(&tiny, "good.lmn.state"), &good_size);
    for (int i = 0; i < 8; i++) header_size |= (size_t)(unsigned char)good[i] << (8 * i);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    mem_free(good);
    tiny_release(&tiny);
    return 0;
}

static const char *write_file(const char *name, const void *bytes, size_t size)
{
    const char *path = tiny_path(&tiny, name);
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
    return path;
}

/* Opens it in every way there is; what fails says so in one line that begins with the path. A path
 * that ends in ".state" is also resumed from. */
static lmn_status open_all(const char *path)
{
    char model[512];
    snprintf(model, sizeof model, "%s", path);
    char *ending = strstr(model, ".state");
    if (ending) *ending = '\0';
    struct error err[4] = {{{0}}};
    struct trainer *t = NULL;
    struct model *m = NULL;
    lmn_model_info info = {0};
    struct history h = {0};
    char **names = NULL;
    lmn_status status[4];
    status[0] = trainer_resume(&tiny.place, model, false, &t, &err[0]);
    status[1] = model_load(&tiny.place, path, false, &m, &err[1]);
    status[2] = checkpoint_read_info(path, &info, &err[2]);
    status[3] = checkpoint_read_history(path, &h, &names, &err[3]);
    for (int i = 0; i < 4; i++) {
        if (status[i] == LMN_OK) continue;
        assert_null(strchr(err[i].text, '\n'));
        if (status[i] != LMN_ERR_MEMORY) assert_memory_equal(err[i].text, model, strlen(model));
    }
    if (status[0] != LMN_OK) assert_null(t);
    if (status[1] != LMN_OK) assert_null(m);
    trainer_free(t);
    model_free(m);
    checkpoint_info_release(&info);
    history_release(&h);
    mem_free(names);
    return status[0];
}

static void header_is_safetensors(void **state)
{
    (void)state;
    json_t *header = json_loadb(good + 8, header_size, 0, NULL), *entry;
    const char *name;
    assert_non_null(header);
    assert_int_equal((8 + header_size) % 64, 0);
    size_t data = good_size - 8 - header_size, sum = 0;
    json_object_foreach(header, name, entry)
    {
        if (strcmp(name, "__metadata__") == 0) continue;
        const json_t *range = json_object_get(entry, "data_offsets");
        size_t begin = (size_t)json_integer_value(json_array_get(range, 0));
        size_t end = (size_t)json_integer_value(json_array_get(range, 1));
        assert_true(begin <= end && end <= data);
        sum += end - begin;
    }
    assert_int_equal(sum, data);
    const json_t *w = json_object_get(header, "network.hidden.0.weight");
    const json_t *shape = json_object_get(w, "shape");
    assert_string_equal(json_string_value(json_object_get(w, "dtype")), "F32");
    assert_int_equal(json_integer_value(json_array_get(shape, 0)), 16);
    assert_int_equal(json_integer_value(json_array_get(shape, 1)),
                     16 + 13 + tiny.scene->n_variables);
    json_decref(header);
}

static void info_tells_where_it_came_from(void **state)
{
    (void)state;
    struct error err = {0};
    lmn_model_info info;
    must(checkpoint_read_info(tiny_path(&tiny, "good.lmn"), &info, &err), &err);
    assert_string_equal(info.scene_path, "scenes/tiny.xml");
    assert_string_equal(info.variables_path, "v.json");
    assert_int_equal(info.n_defines, 2);
    assert_string_equal(info.defines[0], "a=1");
    assert_string_equal(info.defines[1], "b=\"two\"");
    assert_true(info.scene_hash == tiny.scene->hash);
    assert_int_equal(info.step, 12);
    uint32_t d = tiny.scene->n_variables, columns = 16 + 13 + d;
    assert_int_equal(info.n_weights, 4 * 16 + 2 * (16 * columns + 16) + 3 * columns + 3);
    assert_non_null(strstr(info.config_json, "\"n_chains\":4"));
    checkpoint_info_release(&info);
}

static void history_can_be_plotted(void **state)
{
    (void)state;
    struct error err = {0};
    struct history h;
    char **names;
    must(checkpoint_read_history(tiny_path(&tiny, "good.lmn"), &h, &names, &err), &err);
    assert_int_equal(h.n_rows, 12);
    for (uint32_t i = 0; i < 12; i++) {
        assert_true(h.rows[i][HISTORY_STEP] == i + 1);
        assert_true(h.rows[i][HISTORY_LOSS] > 0);
        assert_true(isnan(h.rows[i][HISTORY_LOSS_FRESH]) == (i < 4)); /* 5 warm-up events */
    }
    assert_true(h.n_snapshots >= 5 && h.n_snapshots <= 12);
    assert_string_equal(names[h.dim - 1], "patch.y");
    history_release(&h);
    mem_free(names);
}

static void weights_alone_render_the_same(void **state)
{
    (void)state;
    struct error err = {0};
    struct model *whole, *weights;
    struct image a, b;
    must(model_load(&tiny.place, tiny_path(&tiny, "good.lmn.state"), false, &whole, &err), &err);
    must(model_load(&tiny.place, tiny_path(&tiny, "good.lmn"), false, &weights, &err), &err);

    float u[8] = {0.3f, 0.6f, 0.9f};
    struct model_render_options o = {.window = {60, 40, 0, 0, 60, 40}, .with_buffers = true};
    must(model_render(whole, u, &o, &a, NULL, NULL, NULL, &err), &err);
    o.with_buffers = false;
    o.window = (struct window){60, 40, 11, 5, 20, 30};
    double seconds = -1;
    must(model_render(weights, u, &o, &b, &seconds, NULL, NULL, &err), &err);
    assert_true(seconds >= 0);
    assert_int_equal(a.n_channels, 3 + BUFFER_CHANNELS);
    assert_int_equal(image_channel(&a, "position.X"), 3);
    for (uint32_t y = 0; y < 30; y++)
        for (uint32_t x = 0; x < 20; x++)
            assert_memory_equal(a.data + ((size_t)(y + 5) * 60 + x + 11) * a.n_channels,
                                b.data + ((size_t)y * 20 + x) * 3, sizeof(float[3]));
    o.window.x = 41;
    image_release(&b);
    assert_int_equal(model_render(weights, u, &o, &b, NULL, NULL, NULL, &err), LMN_ERR_ARGUMENT);
    image_release(&a);
    model_free(whole);
    model_free(weights);
}

/* A copy of one file under another name. */
static const char *copy_file(const char *from, const char *to)
{
    size_t size;
    char *bytes = tiny_read(tiny_path(&tiny, from), &size);
    const char *path = write_file(to, bytes, size);
    mem_free(bytes);
    return path;
}

static void assert_cannot_resume(const char *name, lmn_status want, const char *message)
{
    struct error err = {0};
    struct trainer *t = NULL;
    assert_int_equal(trainer_resume(&tiny.place, tiny_path(&tiny, name), false, &t, &err), want);
    if (!strstr(err.text, message)) fail_msg("%s", err.text);
    assert_null(strchr(err.text, '\n'));
    assert_null(t);
}

static void train_and_save(uint64_t seed, uint32_t n_steps, const char *name)
{
    struct error err = {0};
    struct trainer *t = NULL;
    lmn_train_options o = tiny_options();
    o.seed = seed;
    must(trainer_new(&tiny.place, &o, &t, &err), &err);
    for (uint32_t i = 0; i < n_steps; i++) must(trainer_step(t, NULL, &err), &err);
    must(trainer_save(t, tiny_path(&tiny, name), &err), &err);
    trainer_free(t);
}

/* Whatever a kill leaves can be resumed; what does not belong together is refused. */
static void model_and_state_are_a_pair(void **state)
{
    (void)state;
    struct error err = {0};
    struct trainer *t = NULL;
    struct model *m = NULL;
    lmn_train_stats stats;
    train_and_save(11, 14, "later.lmn");
    train_and_save(12, 14, "other.lmn");

    copy_file("good.lmn", "pair.lmn");
    assert_cannot_resume("pair.lmn", LMN_ERR_IO, "pair.lmn.state: no such file");
    copy_file("other.lmn.state", "pair.lmn.state");
    assert_cannot_resume("pair.lmn", LMN_ERR_ARGUMENT, "another training");
    copy_file("good.lmn", "pair.lmn.state");
    assert_cannot_resume("pair.lmn", LMN_ERR_ARGUMENT, "no state");
    copy_file("good.lmn.state", "pair.lmn.state");
    copy_file("later.lmn", "pair.lmn");
    assert_cannot_resume("pair.lmn", LMN_ERR_ARGUMENT, "older state, of step 12");

    copy_file("good.lmn", "pair.lmn"); /* killed between the two files */
    copy_file("later.lmn.state", "pair.lmn.state");
    must(trainer_resume(&tiny.place, tiny_path(&tiny, "pair.lmn"), false, &t, &err), &err);
    trainer_get_stats(t, &stats);
    assert_int_equal(stats.step, 14);
    must(trainer_save(t, tiny_path(&tiny, "pair.lmn"), &err), &err);
    trainer_free(t);
    t = NULL;
    size_t sizes[2];
    char *bytes[2] = {tiny_read(tiny_path(&tiny, "later.lmn"), &sizes[0]),
                      tiny_read(tiny_path(&tiny, "pair.lmn"), &sizes[1])};
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(bytes[0], bytes[1], sizes[0]);
    mem_free(bytes[0]);
    mem_free(bytes[1]);

    copy_file("good.lmn.state", "first.lmn.state"); /* killed before the first model */
    must(trainer_resume(&tiny.place, tiny_path(&tiny, "first.lmn"), false, &t, &err), &err);
    trainer_free(t);
    assert_cannot_resume("none.lmn", LMN_ERR_IO, "none.lmn: cannot open");

    write_file("first.lmn", good, good_size / 2); /* no half of a model goes unnoticed */
    assert_cannot_resume("first.lmn", LMN_ERR_PARSE, "first.lmn: truncated");
    char *old = mem_new(good_size, 1), *version; /* of the time when both were in one file */
    memcpy(old, good, good_size);
    version = memmem(old, header_size, "\"version\":\"3\"", 13);
    assert_non_null(version);
    version[11] = '1';
    const char *path = write_file("first.lmn", old, good_size);
    mem_free(old);
    assert_cannot_resume("first.lmn", LMN_ERR_PARSE, "version 1, this program reads 3");
    assert_int_equal(model_load(&tiny.place, path, false, &m, &err), LMN_ERR_PARSE);
}

static void changed_scenes_are_refused(void **state)
{
    (void)state;
    struct error err = {0};
    struct model *m = NULL;
    struct trainer *t = NULL;
    const char *path = tiny_path(&tiny, "good.lmn");
    tiny.scene->hash++;
    assert_int_equal(model_load(&tiny.place, path, false, &m, &err), LMN_ERR_ARGUMENT);
    assert_non_null(strstr(err.text, "changed"));
    assert_int_equal(trainer_resume(&tiny.place, path, false, &t, &err), LMN_ERR_ARGUMENT);
    must(model_load(&tiny.place, path, true, &m, &err), &err);
    must(trainer_resume(&tiny.place, path, true, &t, &err), &err);
    tiny.scene->hash--;
    model_free(m);
    trainer_free(t);
}

static void test_set_is_fixed(void **state)
{
    (void)state;
    struct error err = {0};
    struct model *m;
    must(model_load(&tiny.place, tiny_path(&tiny, "good.lmn"), false, &m, &err), &err);
    lmn_eval_options few = {.n = 2, .resolution = 24, .spp = 64, .seed = 3};
    lmn_eval_options more = {.n = 3, .resolution = 24, .spp = 64, .seed = 3};
    lmn_metrics each[2], each_of_more[3];
    lmn_eval_result r, r_more;
    struct image sheet = {0};
    must(model_eval(m, &few, NULL, NULL, &r, each, &sheet, &err), &err);
    must(model_eval(m, &more, NULL, NULL, &r_more, each_of_more, NULL, &err), &err);
    assert_memory_equal(each, each_of_more, sizeof each); /* a larger set only adds */
    assert_float_equal(r.mean.mape, 0.5 * (each[0].mape + each[1].mape), 1e-12);
    assert_true(r.noise.mape > 0 && r.noise.mape < 0.5 * r.mean.mape);
    assert_true(r.frame_s > 0 && r.trace_s > 0);
    assert_true(sheet.width >= 3 * 24 && sheet.height >= 2 * 16);
    image_release(&sheet);
    model_free(m);
}

/* Half of a picture's samples against their mean err as much as the mean itself does. */
static void noise_floor_is_the_references_own_error(void **state)
{
    (void)state;
    struct error err = {0};
    struct model *m;
    must(model_load(&tiny.place, tiny_path(&tiny, "good.lmn"), false, &m, &err), &err);
    lmn_eval_result at_16, at_256;
    lmn_eval_options o = {.n = 2, .resolution = 48, .spp = 16, .seed = 3};
    must(model_eval(m, &o, NULL, NULL, &at_16, NULL, NULL, &err), &err);
    o.spp = 256;
    must(model_eval(m, &o, NULL, NULL, &at_256, NULL, NULL, &err), &err);
    assert_true(at_16.noise.mape / at_256.noise.mape > 3 &&
                at_16.noise.mape / at_256.noise.mape < 5); /* sqrt(256 / 16) = 4 */
    model_free(m);
}

static void truncated_files_are_refused(void **state)
{
    (void)state;
    for (size_t size = 0; size < 64; size++)
        assert_int_not_equal(open_all(write_file("bad.lmn.state", good, size)), LMN_OK);
    for (size_t size = 64; size < good_size; size += good_size / 150 + 1)
        assert_int_not_equal(open_all(write_file("bad.lmn.state", good, size)), LMN_OK);
    assert_int_not_equal(open_all(write_file("bad.lmn.state", good, good_size - 1)), LMN_OK);
    assert_int_not_equal(open_all(tiny_path(&tiny, "missing.lmn")), LMN_OK);
    assert_int_not_equal(open_all(tiny.folder), LMN_OK);
    assert_int_equal(open_all(write_file("bad.lmn.state", good, good_size)), LMN_OK);
}

/* Writes over part of a file that is there. */
static void patch_file(const char *path, size_t at, const void *bytes, size_t size)
{
    FILE *f = fopen(path, "r+b");
    assert_non_null(f);
    assert_int_equal(fseek(f, (long)at, SEEK_SET), 0);
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
}

/* Any byte of the header may be wrong, and some of the data: nothing crashes, nothing grows. */
static void mutated_files_do_no_harm(void **state)
{
    (void)state;
    static const char *const snippets[] = {"9",  "-1", "1e300", "null",    "\"\"",
                                           "[]", "{}", "\n",    "\\u0000", "99999999999999999999"};
    const char *path = write_file("mutated.lmn.state", good, good_size);
    size_t start = header_size + 8;
    struct rng r = rng_keyed(1, 2, 3);
    char copy[512];
    for (int i = 0; i < 1500; i++) {
        path = tiny_path(&tiny, "mutated.lmn.state");
        size_t at = rng_below(&r, (uint32_t)start), n = 1;
        char byte = (char)rng_u32(&r);
        const char *wrong = i % 3 == 0 ? snippets[rng_below(&r, 10)] : &byte;
        if (i % 3 == 0) n = strlen(wrong);
        patch_file(path, at, wrong, n);
        open_all(path);
        patch_file(path, at, good + at, n);
    }
    for (int i = 0; i < 200; i++) {
        path = tiny_path(&tiny, "mutated.lmn.state");
        size_t at = start + rng_below(&r, (uint32_t)(good_size - start - sizeof copy));
        for (size_t k = 0; k < sizeof copy; k++) copy[k] = (char)rng_u32(&r);
        patch_file(path, at, copy, sizeof copy);
        open_all(path);
        patch_file(path, at, good + at, sizeof copy);
    }
    assert_int_equal(open_all(tiny_path(&tiny, "mutated.lmn.state")), LMN_OK);
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    assert_true(usage.ru_maxrss < 2 << 20); /* KiB */
}

/* Overwrites the start of a tensor's data. */
static void assert_refused_with(const char *tensor, const void *value, size_t size,
                                const char *message)
{
    char *bytes = mem_new(good_size, 1);
    memcpy(bytes, good, good_size);
    json_t *header = json_loadb(good + 8, header_size, 0, NULL);
    const json_t *entry = json_object_get(header, tensor);
    assert_non_null(entry);
    json_int_t at = json_integer_value(json_array_get(json_object_get(entry, "data_offsets"), 0));
    memcpy(bytes + 8 + header_size + at, value, size);
    write_file("bad.lmn.state", bytes, good_size);
    struct error err = {0};
    struct trainer *t = NULL;
    assert_int_equal(trainer_resume(&tiny.place, tiny_path(&tiny, "bad.lmn"), true, &t, &err),
                     LMN_ERR_PARSE);
    if (!strstr(err.text, message)) fail_msg("%s", err.text);
    json_decref(header);
    mem_free(bytes);
}

static void impossible_values_are_refused(void **state)
{
    (void)state;
    const float nan_value = NAN, one = 1, minus = -1;
    const int64_t many = 1000000, negative = -1;
    const unsigned char two = 2;
    assert_refused_with("network.first.weight", &nan_value, 4, "not finite");
    assert_refused_with("adam.m", &nan_value, 4, "not finite");
    assert_refused_with("adam.v", &minus, 4, "adam.v");
    assert_refused_with("chains.u", &one, 4, "chains.u");
    assert_refused_with("replay.losses", &minus, 4, "replay");
    assert_refused_with("replay.is_large", &two, 1, "replay");
    assert_refused_with("state.counters", &many, 8, "counters");
    assert_refused_with("state.counters", &negative, 8, "counters");
}

static void crafted_headers_are_refused(void **state)
{
    (void)state;
    static const char two_at_one_place[] =
        "{\"a\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":[0,4]},"
        "\"b\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":[0,4]}}";
    static const char *const headers[] = {
        two_at_one_place,
        "",
        "{",
        "[]",
        "null",
        "{}",
        "{\"__metadata__\":{}}",
        "{\"__metadata__\":{\"format\":\"pt\"}}",
        "{\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,4]}}",
        "{\"a\":{\"dtype\":\"F32\",\"shape\":[4611686018427387904,4],\"data_offsets\":[0,0]}}",
        "{\"a\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":[4,8]}}",
        "{\"a\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":[4,0]}}",
        "{\"a\":{\"dtype\":\"F32\",\"shape\":[-1],\"data_offsets\":[0,4]}}",
        "{\"a\":{\"dtype\":\"Q7\\n\",\"shape\":[1],\"data_offsets\":[0,4]}}",
        "{\"a\\nb\":{\"dtype\":\"F32\",\"shape\":[1,1,1,1,1],\"data_offsets\":[0,4]}}",
        "{\"a\":{\"dtype\":7,\"shape\":{},\"data_offsets\":null}}",
        "{\"a\":[]}",
    };
    char bytes[1024];
    for (size_t i = 0; i < sizeof headers / sizeof *headers; i++) {
        size_t n = strlen(headers[i]);
        memset(bytes, 0, sizeof bytes);
        bytes[0] = (char)n;
        memcpy(bytes + 8, headers[i], n);
        assert_int_equal(open_all(write_file("bad.lmn.state", bytes, 8 + n + 4)), LMN_ERR_PARSE);
    }
    memset(bytes, 0xFF, sizeof bytes); /* a header of 2^64 - 1 bytes */
    assert_int_equal(open_all(write_file("bad.lmn.state", bytes, sizeof bytes)), LMN_ERR_PARSE);
}

static void failed_saves_leave_nothing(void **state)
{
    (void)state;
    struct error err = {0};
    struct trainer *t = NULL;
    must(trainer_resume(&tiny.place, tiny_path(&tiny, "good.lmn"), false, &t, &err), &err);
    assert_int_equal(trainer_save(t, tiny_path(&tiny, "no/such/folder.lmn"), &err), LMN_ERR_IO);
    assert_int_equal(trainer_save(t, "-", &err), LMN_ERR_ARGUMENT);
    trainer_free(t);
    DIR *d = opendir(tiny.folder);
    for (struct dirent *e; (e = readdir(d));) assert_null(strstr(e->d_name, ".tmp"));
    closedir(d);
}

/* Every allocation on the way may fail: an error, no leak (AddressSanitizer looks), no crash. */
static void short_memory_is_an_error(void **state)
{
    (void)state;
    uint32_t n_failed = 0;
    for (uint64_t n = 1; n < 400; n++) {
        struct error err = {0};
        struct trainer *t = NULL;
        mem_fail_after(n);
        lmn_status status = trainer_resume(&tiny.place, tiny_path(&tiny, "good.lmn"), false, &t,
                                           &err);
        mem_fail_after(0);
        trainer_free(t);
        if (status == LMN_OK) break;
        n_failed++;
    }
    assert_in_range(n_failed, 20, 398);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(header_is_safetensors),
        cmocka_unit_test(info_tells_where_it_came_from),
        cmocka_unit_test(history_can_be_plotted),
        cmocka_unit_test(weights_alone_render_the_same),
        cmocka_unit_test(model_and_state_are_a_pair),
        cmocka_unit_test(changed_scenes_are_refused),
        cmocka_unit_test(test_set_is_fixed),
        cmocka_unit_test(noise_floor_is_the_references_own_error),
        cmocka_unit_test(truncated_files_are_refused),
        cmocka_unit_test(mutated_files_do_no_harm),
        cmocka_unit_test(impossible_values_are_refused),
        cmocka_unit_test(crafted_headers_are_refused),
        cmocka_unit_test(failed_saves_leave_nothing),
        cmocka_unit_test(short_memory_is_an_error),
    };
    return cmocka_run_group_tests_name("checkpoint", tests, setup, teardown);
}
