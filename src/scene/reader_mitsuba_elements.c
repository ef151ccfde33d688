/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "scene/reader_mitsuba_private.h"

/* The elements of the format, and their attributes. */

struct element_entry {
    const char *name;
    enum element element;
    const char *attributes; /* allowed ones, each between blanks */
};

static const struct element_entry elements[] = {
    {"float", EL_FLOAT, " name value "},
    {"integer", EL_INTEGER, " name value "},
    {"boolean", EL_BOOLEAN, " name value "},
    {"string", EL_STRING, " name value "},
    {"point", EL_POINT, " name value x y z "},
    {"vector", EL_VECTOR, " name value x y z "},
    {"vector4f", EL_VECTOR4F, " name value "},
    {"rgb", EL_RGB, " name value id intent "},
    {"spectrum", EL_SPECTRUM, " name value filename id intent "},
    /* <spectrum type="...">: the same as a texture of that type, of Mitsuba 2 and 3 */
    {"srgb", EL_SRGB, " name value id intent "},
    {"blackbody", EL_BLACKBODY, " name temperature scale id "},
    {"transform", EL_TRANSFORM, " name id "},
    {"ref", EL_REF, " name id "},
    {"scene", EL_SCENE, " version type id "},
    {"bsdf", EL_BSDF, " type id name "},
    {"texture", EL_TEXTURE, " type id name "},
    {"emitter", EL_EMITTER, " type id name "},
    {"shape", EL_SHAPE, " type id name "},
    {"sensor", EL_SENSOR, " type id name "},
    {"film", EL_FILM, " type id name "},
    {"rfilter", EL_RFILTER, " type id name "},
    {"sampler", EL_SAMPLER, " type id name "},
    {"integrator", EL_INTEGRATOR, " type id name "},
    {"medium", EL_MEDIUM, " type id name "},
    {"phase", EL_PHASE, " type id name "},
    {"volume", EL_VOLUME, " type id name "},
    {"translate", EL_TRANSLATE, " value x y z "},
    {"rotate", EL_ROTATE, " value x y z angle "},
    {"scale", EL_SCALE, " value x y z "},
    {"lookat", EL_LOOKAT, " origin target up "},
    {"lookAt", EL_LOOKAT, " origin target up "},
    {"matrix", EL_MATRIX, " value "},
    {"default", EL_DEFAULT, " name value "},
    {"include", EL_INCLUDE, " filename "},
    {"alias", EL_ALIAS, " id as "},
    {"path", EL_PATH, " value "},
    {"animation", EL_ANIMATION, NULL},
    {"mode", EL_IGNORED, NULL}, /* notes of an exporter; any attributes */
    {"hide", EL_IGNORED, NULL},
};
enum { N_ELEMENTS = sizeof elements / sizeof *elements };

const char *element_name(enum element element)
{
    for (size_t i = 0; i < N_ELEMENTS; i++) {
        if (elements[i].element == element) return elements[i].name;
    }
    return "";
}

static const struct element_entry *find_element(const char *name)
{
    for (size_t i = 0; i < N_ELEMENTS; i++) {
        if (strcmp(elements[i].name, name) == 0) return &elements[i];
    }
    return NULL;
}

lmn_status check_element(struct reader *r, struct xml_node *node)
{
    const struct element_entry *e = find_element(node->name);
    if (e && e->element == EL_SPECTRUM && xml_attribute(node, "type")) e = find_element("texture");
    if (!e) {
        const char *names[N_ELEMENTS];
        for (size_t i = 0; i < N_ELEMENTS; i++) names[i] = elements[i].name;
        const char *closest = str_closest(node->name, names, N_ELEMENTS);
        if (!closest) return fail_node(r, node, "unknown element <%.60s>", node->name);
        return fail_node(r, node, "unknown element <%.60s>; did you mean <%s>?", node->name,
                         closest);
    }
    if (e->element == EL_ANIMATION)
        return fail_node(r, node, "<animation> (motion within a picture) is not supported");
    node->element = (uint8_t)e->element;
    for (uint32_t i = 0; e->attributes && i < node->n_attributes; i++) {
        char padded[64];
        const char *name = node->attributes[i].name;
        int n = snprintf(padded, sizeof padded, " %s ", name);
        if (n < 0 || (size_t)n >= sizeof padded || !strstr(e->attributes, padded))
            return fail_node(r, node, "<%s> has no attribute \"%.60s\"; it takes%s", node->name,
                             name, e->attributes);
    }
    if (e->element >= EL_BSDF && e->element <= EL_VOLUME && !xml_attribute(node, "type"))
        return fail_node(r, node, "<%s> needs a type", node->name);
    if (e->element == EL_REF && !xml_attribute(node, "id"))
        return fail_node(r, node, "<ref> needs an id");
    if (e->element >= EL_FLOAT && e->element <= EL_TRANSFORM && !xml_attribute(node, "name"))
        return fail_node(r, node, "<%s> needs a name", node->name);
    return LMN_OK;
}
