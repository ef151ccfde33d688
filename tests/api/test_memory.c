/* SPDX-License-Identifier: Apache-2.0 */
/* Every allocation fails once: the call says LMN_ERR_MEMORY, and (under ASan) nothing leaks. */
#include "api_test.h"

#include <stdio.h>
#include <unistd.h>

#include "base/mem.h"

/* Runs `call` with the n-th allocation failing, n = 1, 2, ..., until it succeeds. */
typedef lmn_status call_fn(lmn_context *context, lmn_scene *scene);

static uint64_t fail_each(lmn_context *context, lmn_scene *scene, call_fn *call)
{
    for (uint64_t n = 1; n < 100000; n++) {
        mem_fail_after(n);
        const lmn_status status = call(context, scene);
        mem_fail_after(0);
        if (status == LMN_OK) return n - 1;
        if (status != LMN_ERR_MEMORY)
            print_error("allocation %llu: status %d: %s\n", (unsigned long long)n, status,
                        lmn_context_message(context));
        assert_int_equal(status, LMN_ERR_MEMORY);
        assert_true(strlen(lmn_context_message(context)) > 0);
    }
    fail_msg("no end");
    return 0;
}

static lmn_status load(lmn_context *context, lmn_scene *unused)
{
    lmn_scene *scene = NULL;
    (void)unused;
    const lmn_status status = lmn_scene_load(context, SCENE, NULL, &scene);
    assert_true((status == LMN_OK) == (scene != NULL));
    lmn_scene_free(scene);
    return status;
}

static lmn_status load_and_trace(lmn_context *context, lmn_scene *unused)
{
    lmn_scene *scene = NULL;
    lmn_image *image = NULL;
    (void)unused;
    const lmn_trace_options o = {.struct_size = sizeof o,
                                 .width = 4,
                                 .height = 4,
                                 .spp = 2,
                                 .buffers = 1,
                                 .half_buffers = 1,
                                 .light_groups = 1,
                                 .follow_delta = 1,
                                 .split_delta = 1};
    lmn_status status = lmn_scene_load(context, SCENE, NULL, &scene);
    if (status == LMN_OK) status = lmn_scene_trace(context, scene, NULL, &o, &image, NULL);
    lmn_image_free(image);
    lmn_scene_free(scene);
    return status;
}

static lmn_status train(lmn_context *context, lmn_scene *scene)
{
    lmn_trainer *trainer = NULL;
    lmn_train_options o;
    lmn_train_options_init(&o);
    o.width = 8;
    o.depth = 1;
    o.patch_size = 12;
    o.resolution_start = 24;
    o.n_chains = 2;
    o.memory_mib = 1;
    o.spp = 1;
    const lmn_status status = lmn_trainer_new(context, scene, &o, &trainer);
    lmn_trainer_free(trainer);
    return status;
}

static void test_scene_load(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    assert_true(fail_each(context, NULL, load) > 20);
    lmn_context_free(context);
}

static void test_trace(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    assert_true(fail_each(context, NULL, load_and_trace) > 30);
    lmn_context_free(context);
}

static void test_trainer(void **state)
{
    (void)state;
    lmn_context *context = new_context(1);
    lmn_scene *scene = load_scene(context);
    assert_true(fail_each(context, scene, train) > 10);
    lmn_scene_free(scene);
    lmn_context_free(context);
}

static void test_context(void **state)
{
    (void)state;
    const lmn_context_options options = {.struct_size = sizeof options, .threads = 2};
    lmn_context *context = NULL;
    char message[64];
    for (uint64_t n = 1;; n++) {
        mem_fail_after(n);
        const lmn_status status = lmn_context_new(&options, &context, message, sizeof message);
        mem_fail_after(0);
        if (status == LMN_OK) break;
        assert_int_equal(status, LMN_ERR_MEMORY);
        assert_null(context);
        assert_true(strlen(message) > 0);
    }
    lmn_context_free(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_context),
        cmocka_unit_test(test_scene_load),
        cmocka_unit_test(test_trace),
        cmocka_unit_test(test_trainer),
    };
    return cmocka_run_group_tests_name("api_memory", tests, NULL, NULL);
}
