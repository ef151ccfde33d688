/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_READER_MITSUBA_BSDF_H
#define SCENE_READER_MITSUBA_BSDF_H

#include "scene/reader_mitsuba_private.h"

/* One function per material; defaults are Mitsuba 3's. *f comes from bsdf_blank(). */
typedef lmn_status bsdf_fn(struct props *p, struct bsdf *f);

/* reader_mitsuba_nested.c: materials around others. */
bsdf_fn read_twosided, read_mask, read_blend, read_mixture, read_bumpmap, read_normalmap;

#endif
