/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/reader_mitsuba.h"

#include "scene/reader_mitsuba_private.h"

enum { MAX_OBJECT_DEPTH = 64 };

/* ---- The scene ---------------------------------------------------------------------------- */

lmn_status keep_string(struct reader *r, const char *text, const char **out)
{
    *out = arena_strdup(r->b->arena, text);
    return *out ? LMN_OK : fail_memory(r->err, "names");
}

void note_ignored(struct reader *r, const struct xml_node *node, const char *what)
{
    enum { MAX_LISTED = 40 };
    if (r->n_ignored++ >= MAX_LISTED) return;
    str_add(&r->ignored, "%s%.60s (line %u)", r->n_ignored > 1 ? ", " : "", what,
            (unsigned)node->place.line);
}

static void tell_ignored(struct reader *r)
{
    if (!r->n_ignored || r->ignored.failed || !r->options || !r->options->note) return;
    struct str text = {0};
    str_add(&text, "%s: ignored: %s", r->b->path, r->ignored.text);
    if (!text.failed) r->options->note(r->options->note_user, text.text);
    str_release(&text);
}

lmn_status load_object(struct reader *r, struct xml_node *node)
{
    lmn_status status = LMN_OK;
    uint32_t index = 0;
    if (node->load_state == LOAD_DONE) return LMN_OK;
    if (node->load_state == LOAD_NOW)
        return fail_node(r, node, "<%s type=\"%.40s\"> refers to itself", node->name,
                         xml_attribute(node, "type"));
    if (r->depth == MAX_OBJECT_DEPTH)
        return fail_node(r, node, "objects are nested deeper than %d", MAX_OBJECT_DEPTH);
    node->load_state = LOAD_NOW;
    r->depth++;
    switch (node->element) {
    case EL_BSDF:
        TRY(load_bsdf(r, node, &index));
        node->kind = BUILDER_BSDF;
        break;
    case EL_TEXTURE:
        TRY(load_texture(r, node, &index));
        node->kind = BUILDER_TEXTURE;
        break;
    case EL_EMITTER:
        TRY(load_emitter(r, node, &index));
        node->kind = BUILDER_EMITTER;
        break;
    case EL_SHAPE:
        TRY(load_shape(r, node, SCENE_NONE, &index));
        break;
    default:
        status = fail_node(r, node, "<%s> has no place here", node->name);
        goto done;
    }
    node->index = index;
    node->load_state = LOAD_DONE;
done:
    r->depth--;
    return status;
}

static lmn_status load_scene(struct reader *r, struct xml_node *root)
{
    lmn_status status = LMN_OK;
    bool has_integrator = false, has_sensor = false;
    for (struct xml_node *c = root->first_child; c; c = c->next) {
        switch (c->element) {
        case EL_BSDF:
        case EL_TEXTURE:
        case EL_EMITTER:
        case EL_SHAPE:
            TRY(load_object(r, c));
            break;
        case EL_SENSOR:
            if (has_sensor) {
                note_ignored(r, c, "another sensor");
            } else {
                TRY(load_sensor(r, c));
            }
            has_sensor = true;
            break;
        case EL_INTEGRATOR:
            if (has_integrator) return fail_node(r, c, "a scene can have one <integrator>");
            TRY(load_integrator(r, c));
            has_integrator = true;
            break;
        case EL_MEDIUM:
        case EL_VOLUME:
        case EL_PHASE:
            return fail_node(r, c, "<%s> is not supported", c->name);
        default:
            return fail_node(r, c, "<%s> has no place in <scene>", c->name);
        }
    }
done:
    return status;
}

lmn_status reader_mitsuba_read(struct builder *b, const struct scene_load_options *options,
                               struct error *err)
{
    lmn_status status = LMN_OK;
    struct reader r = {.b = b, .err = err, .options = options};
    struct xml_node *root = NULL;
    r.budget = (struct xml_budget){.n_nodes = XML_MAX_NODES, .size = XML_MAX_SIZE};
    TRY(read_document(&r, &root));
    TRY(load_scene(&r, root));
    tell_ignored(&r);
done:
    str_release(&r.ignored);
    mem_free(r.mesh_text);
    mem_free(r.defines);
    mem_free(r.folders);
    mem_free(r.ids);
    arena_release(&r.arena);
    return status;
}
