/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene.h"

#include <string.h>

#include "scene/reader_mitsuba.h"
#include "scene/variables.h"

lmn_status scene_load(const char *path, const struct scene_load_options *options,
                      struct scene **out, struct error *err)
{
    lmn_status status = LMN_OK;
    struct builder *b = NULL;
    struct scene *s = NULL;
    TRY(builder_new(path, &b, err));
    TRY(reader_mitsuba_read(b, options, err));
    TRY(variables_declare(b, options ? options->variables_path : NULL, err));
    TRY(builder_finish(b, &s, err));
    TRY(variables_resolve(b, s, err));
    *out = s;
    s = NULL; /* ownership moved to the caller */
done:
    builder_free(b);
    scene_free(s);
    return status;
}

void scene_free(struct scene *s)
{
    if (!s) return;
    for (uint32_t i = 0; i < s->n_bitmaps; i++) bitmap_release(&s->bitmaps[i]);
    arena_release(&s->arena);
    mem_free(s);
}
