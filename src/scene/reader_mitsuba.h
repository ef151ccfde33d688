/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_READER_MITSUBA_H
#define SCENE_READER_MITSUBA_H

#include "scene/builder.h"

/*
 * Reads a Mitsuba scene (XML 2.x and 3.x, and the variable scenes of the paper's authors, which are
 * 2.2.1 with extra children) into a builder. Everything that is not understood is an error with its
 * place; what is understood and makes no difference here is told in one note.
 */
lmn_status reader_mitsuba_read(struct builder *b, const struct scene_load_options *options,
                               struct error *err);

#endif
