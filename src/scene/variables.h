/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_VARIABLES_H
#define SCENE_VARIABLES_H

#include "scene/builder.h"

/*
 * Variables are declared on the builder (so that shapes that move get a structure of their own) and
 * resolved on the finished scene (so that they know where in the state to write).
 */

/* Declares the authors' var_ objects, or what the JSON file says. variables_path NULL: the file
 * SCENE.variables.json beside b->path when it is there. */
lmn_status variables_declare(struct builder *b, const char *variables_path, struct error *err);

/* Fills scene->params, variables and bindings, and the defaults that variables set. */
lmn_status variables_resolve(const struct builder *b, struct scene *s, struct error *err);

#endif
