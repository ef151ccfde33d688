/* SPDX-License-Identifier: Apache-2.0 */
#include "train/checkpoint.h"

#include <string.h>

#include "base/mem.h"
#include "base/str.h"
#include "train/model_file.h"

char *state_path(const char *model_path)
{
    struct str s = {0};
    str_add(&s, "%s.state", model_path);
    if (!s.failed) return s.text;
    str_release(&s);
    return NULL;
}

/* A copy of strings in one block, to be freed by mem_free(). NULL when memory is short. */
static char **copy_list(char *const *list, uint32_t n, const char *const *more, uint32_t n_more)
{
    size_t size = 1;
    for (uint32_t i = 0; i < n; i++) size += sizeof(char *) + strlen(list[i]) + 1;
    for (uint32_t i = 0; i < n_more; i++) size += sizeof(char *) + strlen(more[i]) + 1;
    char **out = mem_new(size, 1);
    if (!out) return NULL;
    char *bytes = (char *)(out + n + n_more);
    for (uint32_t i = 0; i < n + n_more; i++) {
        const char *text = i < n ? list[i] : more[i - n];
        out[i] = bytes;
        bytes = stpcpy(bytes, text) + 1;
    }
    return out;
}

lmn_status checkpoint_read_info(const char *path, lmn_model_info *out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct model_file m = {0};
    lmn_model_info info = {0};
    char *metrics = NULL;
    TRY(model_file_open(&m, path, err));
    TRY(model_file_check_weights(&m, err));
    info = (lmn_model_info){.scene_path = mem_strdup(m.scene_path),
                            .variables_path = mem_strdup(m.variables_path),
                            .config_json = mem_strdup(m.config),
                            .defines = copy_list(m.defines, m.n_defines, NULL, 0),
                            .n_defines = m.n_defines,
                            .scene_hash = m.scene_hash,
                            .step = m.step,
                            .method = m.options.method,
                            .width = m.options.width,
                            .depth = m.options.depth,
                            .n_weights = model_file_n_weights(&m)};
    metrics = metrics_path(path);
    if (!info.scene_path || !info.variables_path || !info.config_json || !info.defines ||
        !metrics) {
        status = fail_memory(err, path);
        goto done;
    }
    metrics_times(metrics, m.step, &info.cpu_s, NULL, NULL);
    *out = info;
    info = (lmn_model_info){0};
done:
    checkpoint_info_release(&info);
    model_file_release(&m);
    mem_free(metrics);
    return status;
}

void checkpoint_info_release(lmn_model_info *info)
{
    mem_free(info->scene_path);
    mem_free(info->variables_path);
    mem_free(info->config_json);
    mem_free(info->defines);
    *info = (lmn_model_info){0};
}

lmn_status checkpoint_read_history(const char *path, struct history *out, char ***names,
                                   struct error *err)
{
    static const char *const corner[2] = {"patch.x", "patch.y"};
    lmn_status status = LMN_OK;
    struct model_file m = {0};
    TRY(model_file_open(&m, path, err));
    char **list = copy_list(m.names, m.n_names, corner, 2);
    if (!list) {
        status = fail_memory(err, path);
        goto done;
    }
    status = model_file_read_history(&m, out, err);
    if (status != LMN_OK) {
        mem_free(list);
        goto done;
    }
    *names = list;
done:
    model_file_release(&m);
    return status;
}
