/* SPDX-License-Identifier: Apache-2.0 */
/* Public contexts, and the small services of handles.h that all calls share. */
#include "api/handles.h"

#include <string.h>

#include "base/cpu.h"
#include "base/mem.h"
#include "render/view.h"

struct error *context_begin(lmn_context *context)
{
    context->error.text[0] = '\0';
    return &context->error;
}

lmn_status options_copy(const char *type, const void *options, void *full, size_t full_size,
                        struct error *err)
{
    uint32_t size;
    memset(full, 0, full_size);
    if (!options) return LMN_OK;
    memcpy(&size, options, sizeof size);
    if (size < sizeof size) return fail(err, LMN_ERR_ARGUMENT, "%s: struct_size is not set", type);
    const unsigned char *bytes = options;
    for (size_t i = full_size; i < size; i++)
        if (bytes[i] != 0)
            return fail(err, LMN_ERR_ARGUMENT, "%s: options of a newer version", type);
    memcpy(full, options, size < full_size ? size : full_size);
    return LMN_OK;
}

lmn_status lmn_context_new(const lmn_context_options *options, lmn_context **out, char *message,
                           size_t message_size)
{
    lmn_status status = LMN_OK;
    lmn_context_options o;
    struct error err = {{0}};
    *out = NULL;
    lmn_context *c = mem_new(1, sizeof *c);
    if (!c) {
        status = fail_memory(&err, "the context");
        goto done;
    }
    TRY(options_copy("lmn_context_options", options, &o, sizeof o, &err));
    c->cpu_detected = cpu_detect();
    c->cpu = c->cpu_detected;
    if (o.cpu) {
        const uint32_t mask = cpu_mask_from_name(o.cpu);
        if (mask == UINT32_MAX) {
            status = fail(
                &err, LMN_ERR_ARGUMENT,
                "unknown instruction set \"%s\": baseline, avx2, avx512, avx512bf16 or amx", o.cpu);
            goto done;
        }
        c->cpu &= mask;
    }
    c->pool = pool_new(o.threads);
    if (!c->pool) {
        status = fail(&err, LMN_ERR_MEMORY, "cannot start %u threads", o.threads);
        goto done;
    }
    c->progress = o.progress;
    c->progress_user = o.progress_user;
    c->note = o.note;
    c->note_user = o.note_user;
    *out = c;
    c = NULL;
done:
    if (message && message_size > 0) {
        const size_t n = strnlen(err.text, message_size - 1);
        memcpy(message, err.text, n);
        message[n] = '\0';
    }
    lmn_context_free(c);
    return status;
}

void lmn_context_free(lmn_context *context)
{
    if (!context) return;
    pool_free(context->pool);
    str_release(&context->json);
    mem_free(context);
}

const char *lmn_context_message(const lmn_context *context)
{
    return context->error.text;
}

void lmn_context_info(const lmn_context *context, lmn_info *out)
{
    *out = (lmn_info){.version = LMN_VERSION,
                      .cpu_detected = cpu_name(context->cpu_detected),
                      .cpu_used = cpu_name(context->cpu),
                      .threads = pool_n_workers(context->pool),
                      .embree = embree_version()};
}
