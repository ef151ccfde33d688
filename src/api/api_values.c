/* SPDX-License-Identifier: Apache-2.0 */
/* Values of variables: defaults, draws, and what users write after -P. */
#include "api/handles.h"

#include "scene/assign.h"

void lmn_scene_default_values(const lmn_scene *scene, double *values)
{
    scene_default_values(scene->scene, values);
}

void lmn_scene_random_values(const lmn_scene *scene, uint64_t seed, uint64_t index, double *values)
{
    scene_random_values(scene->scene, seed, index, values);
}

lmn_status lmn_scene_parse_value(lmn_context *context, const lmn_scene *scene,
                                 const char *assignment, double *values)
{
    return scene_parse_value(scene->scene, assignment, values, context_begin(context));
}

lmn_status scene_units(const lmn_scene *scene, const double *values, float *u, struct error *err)
{
    const struct scene *s = scene->scene;
    for (uint32_t i = 0; values && i < s->n_variables; i++) {
        const struct variable *v = &s->variables[i];
        const double low = v->n_choices ? 0.0 : v->min;
        const double high = v->n_choices ? v->n_choices - 1.0 : v->max;
        /* Also refuses what is not a number. A value that went through text or float may lie a
         * rounding outside. */
        const double slack = 1e-6 * (high - low);
        if (!(values[i] >= low - slack && values[i] <= high + slack))
            return fail(err, LMN_ERR_ARGUMENT, "%s=%g: out of range; %g to %g", v->name, values[i],
                        low, high);
    }
    scene_values_to_units(s, values, u);
    return LMN_OK;
}
