/* SPDX-License-Identifier: Apache-2.0 */
/* Public plots. */
#include "api/handles.h"
#include "train/plot.h"

lmn_status lmn_plot(lmn_context *context, const char *const *paths, uint32_t n_paths,
                    const char *svg_path)
{
    return plot_svg(paths, n_paths, svg_path, context_begin(context));
}
