/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_AUTHORS_VARIABLES_H
#define SCENE_AUTHORS_VARIABLES_H

#include "scene/builder.h"

/*
 * The variable scenes of the paper's authors (Diolatzis et al. 2022): objects whose id starts with
 * "var_" carry their ranges as children that Mitsuba does not know. docs/scene-format.md tells what
 * each means.
 *
 * Declares their variables: the sensor's first, then in the order of the document. Names are ids
 * without "var_", then ".x" and the like; b->variables stays as it is when there are none.
 */
lmn_status variables_read_authors(struct builder *b, struct error *err);

#endif
