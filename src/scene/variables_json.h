/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_VARIABLES_JSON_H
#define SCENE_VARIABLES_JSON_H

#include "scene/builder.h"

/* Declares the variables of a JSON file (docs/scene-format.md, docs/variables.schema.json). */
lmn_status variables_read_json(struct builder *b, const char *path, struct error *err);

#endif
