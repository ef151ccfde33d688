/* SPDX-License-Identifier: Apache-2.0 */
/* Public plots. */
#include "api/handles.h"
#include "train/plot.h"
#include "train/plot_learning.h"

lmn_status lmn_plot(lmn_context *context, const char *const *paths, uint32_t n_paths,
                    const char *svg_path)
{
    return plot_svg(paths, n_paths, svg_path, context_begin(context));
}

lmn_status lmn_plot_learning(lmn_context *context, const char *results_path, const char *scene,
                             const char *svg_path)
{
    return plot_learning_svg(results_path, scene, svg_path, context_begin(context));
}
