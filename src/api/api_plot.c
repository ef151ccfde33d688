/* SPDX-License-Identifier: Apache-2.0 */
/* Public plots. */
#include "api/handles.h"
#include "train/plot.h"

lmn_status lmn_plot(lmn_context *context, const char *path, const char *svg_path)
{
    return plot_svg(path, svg_path, context_begin(context));
}
