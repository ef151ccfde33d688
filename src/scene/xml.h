/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SCENE_XML_H
#define SCENE_XML_H

#include "base/mem.h"
#include "scene/builder.h"

/*
 * XML as a small tree: elements and attributes with their places. Text between elements must be
 * blank. Entity declarations are refused; nesting and the number of elements are limited.
 */

struct xml_attribute {
    const char *name, *value;
};

struct xml_node {
    const char *name;
    struct xml_attribute *attributes; /* [n_attributes] */
    uint32_t n_attributes;
    struct place place;
    struct xml_node *first_child, *next;

    /* For the reader's use; zero at first. */
    uint8_t element;
    bool is_used;       /* a property that was asked for */
    bool is_legacy;     /* of a file for Mitsuba 0.x */
    uint8_t load_state; /* an object: not yet, being loaded, loaded */
    enum builder_kind kind;
    uint32_t index;
};

/* Shared by the files of one scene, so that includes cannot get around the limits. */
struct xml_budget {
    uint32_t n_nodes; /* left */
    size_t size;      /* bytes left */
};

enum { XML_MAX_DEPTH = 64, XML_MAX_NODES = 1 << 20, XML_MAX_SIZE = 64 << 20 };

/* Parses `text`, which came from file `path` (kept by reference in places). The tree lives in
 * `arena`. */
lmn_status xml_parse(const char *path, const char *text, size_t size, struct arena *arena,
                     struct xml_budget *budget, struct xml_node **root, struct error *err);

/* The value of an attribute, or NULL. */
const char *xml_attribute(const struct xml_node *node, const char *name);

#endif
