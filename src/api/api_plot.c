/* SPDX-License-Identifier: Apache-2.0 */
/* Public plots. */
#include "api/handles.h"

#include <stdio.h>

#include "base/mem.h"
#include "train/checkpoint.h"
#include "train/plot.h"

/* safetensors: eight bytes of length, then a JSON object. A log starts with the object itself. */
static bool is_model(const char *path)
{
    unsigned char head[9] = {0};
    FILE *f = fopen(path, "rb");
    if (!f) return false;
    const bool answer = fread(head, 1, sizeof head, f) == sizeof head && head[0] != '{' &&
                        head[7] == 0 && head[8] == '{';
    fclose(f);
    return answer;
}

lmn_status lmn_plot(lmn_context *context, const char *path, const char *svg_path)
{
    lmn_status status = LMN_OK;
    struct error *err = context_begin(context);
    char *metrics = NULL;
    if (is_model(path)) {
        metrics = metrics_path(path);
        if (!metrics) {
            status = fail_memory(err, "a path");
            goto done;
        }
    }
    TRY(plot_svg(metrics ? metrics : path, svg_path, err));
done:
    mem_free(metrics);
    return status;
}
