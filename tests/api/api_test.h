/* SPDX-License-Identifier: Apache-2.0 */
#ifndef API_TEST_H
#define API_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include <lumenaut/lumenaut.h>

/* What the tests of the public calls share. */

#define SCENE LMN_SOURCE_DIR "/tests/cli/scenes/box.xml"

/* A call must give `status`, and say why when that is a failure. */
#define EXPECT(context, call, status)                              \
    do {                                                           \
        assert_int_equal(call, status);                            \
        if ((status) == LMN_OK)                                    \
            assert_string_equal(lmn_context_message(context), ""); \
        else                                                       \
            assert_true(strlen(lmn_context_message(context)) > 8); \
    } while (0)

static inline lmn_context *new_context(uint32_t threads)
{
    const lmn_context_options options = {.struct_size = sizeof options, .threads = threads};
    lmn_context *context = NULL;
    char message[128];
    assert_int_equal(lmn_context_new(&options, &context, message, sizeof message), LMN_OK);
    assert_string_equal(message, "");
    return context;
}

static inline lmn_scene *load_scene(lmn_context *context)
{
    lmn_scene *scene = NULL;
    EXPECT(context, lmn_scene_load(context, SCENE, NULL, &scene), LMN_OK);
    return scene;
}

#endif
